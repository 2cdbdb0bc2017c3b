"""The command robust-slam: from a file to a map, or to a sentence that says what is wrong."""

from __future__ import annotations

import numpy as np
import pytest
import robust_slam as rs
from robust_slam import cli
from robust_slam.graphs.g2o import read, write
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.graphs.pose_graph import select


@pytest.fixture
def file(tmp_path):
    rng = np.random.default_rng(0)
    graph, truth = manhattan(60, rng, closures=20)
    spoiled, _ = add_random_closures(graph, 6, rng, poses=truth)
    write(tmp_path / "town.g2o", spoiled, truth)
    return tmp_path / "town.g2o"


def test_it_says_what_was_read_kept_rejected_and_certified(file, capsys):
    assert cli.main(["solve", str(file), "--quiet"]) == 0
    said = capsys.readouterr().out
    answer = rs.solve(rs.load(file))
    assert answer.graph.summary() in said
    assert answer.summary() in said
    assert f"{answer.rejected.size} closures: " in said


@pytest.mark.parametrize("suffix", [".g2o", ".tum", ".kitti"])
def test_it_writes_the_poses(file, tmp_path, suffix):
    out = tmp_path / f"map{suffix}"
    cli.main(["solve", str(file), "--quiet", "--out", str(out)])
    answer = rs.solve(rs.load(file))
    if suffix == ".g2o":
        np.testing.assert_array_equal(read(out).poses, answer.poses)
    else:
        assert len(out.read_text().splitlines()) == 60


def test_it_draws_the_map(file, tmp_path):
    cli.main(["solve", str(file), "--quiet", "--plot", str(tmp_path / "map.svg")])
    assert "<svg" in (tmp_path / "map.svg").read_text()


def test_progress_is_shown_unless_it_is_quiet(file, capsys):
    cli.main(["solve", str(file)])
    said = capsys.readouterr().err
    assert "PCM compares closures" in said and "the certificate is computed" in said
    cli.main(["solve", str(file), "--quiet"])
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nix.g2o"], "nix.g2o"),
        (["town.g2o", "--probability", "1"], "probability is 1"),
        (["bad.g2o"], "bad.g2o:1: the tag 'HELLO' is unknown"),
    ],
)
def test_wrong_input_is_one_line_and_code_2(file, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(file.parent)
    (file.parent / "bad.g2o").write_text("HELLO\n")
    assert cli.main(["solve", *arguments, "--quiet"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1 and words in said[0]


def test_an_unknown_ending_is_refused_before_the_work(file, capsys):
    with pytest.raises(SystemExit):
        cli.main(["solve", str(file), "--out", "map.txt"])
    assert "end it with .g2o, .tum, .kitti" in capsys.readouterr().err


def test_sessions_are_joined_and_the_answer_says_so(file):
    graph = rs.load(file)
    cut = select(graph, ~np.all(graph.edges == [29, 30], axis=1))
    answer = rs.solve(cut)
    assert "2 sessions" in "".join(answer.notes())
    assert answer.certificate.verdict.value == "certified"
    assert np.all(answer.kept[answer.bridges.edges])
    whole = rs.solve(graph)
    steps = np.diff(answer.poses[:, :2], axis=0) - np.diff(whole.poses[:, :2], axis=0)
    assert np.abs(steps).max() < 1.0


def test_the_answer_is_a_result(file):
    answer = rs.solve(rs.load(file))
    assert len(repr(answer)) < 120
    assert answer.weights.shape == answer.kept.shape
    np.testing.assert_array_equal(answer.weights > 0.5, answer.kept)
    kept = select(answer.graph, answer.kept)
    assert answer.cost == pytest.approx(rs.certificates.chordal_cost(kept, answer.poses))


@pytest.mark.parametrize(("given", "error"), [(3, TypeError), ("town.g2o", TypeError)])
def test_solve_says_what_it_takes(given, error):
    with pytest.raises(error, match="give a PoseGraph, for instance load"):
        rs.solve(given)


def test_an_unknown_kind_is_refused_before_the_work():
    with pytest.raises(ValueError, match="kind is 'cauchy'"):
        rs.solve(manhattan(10, 0)[0], kind="cauchy")


def test_the_library_tells_its_version_and_graphs_their_size():
    assert rs.__version__.count(".") == 2
    graph, _ = manhattan(1000, 0)
    assert repr(graph) == "<PoseGraph: 1,000 poses in SE(2), 1,199 edges, 200 of them closures>"
    assert rs.draw_map(graph, rs.graphs.dead_reckoning(graph)).lines
