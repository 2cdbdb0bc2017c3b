"""The command robust-slam: from a file to a map, or to a sentence that says what is wrong."""

import re
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import robust_slam as rs
from robust_slam import cli
from robust_slam.files import datasets
from robust_slam.files.g2o import write
from robust_slam.files.reading import read
from robust_slam.files.trajectories import write_tum
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.graphs.pose_graph import select

from .worlds import refused, with_outliers


def solve(*words):
    """Give the exit status of ``robust-slam solve``, without a bar."""
    return cli.main(["solve", *map(str, words), "--quiet"])


@pytest.fixture
def file(tmp_path):
    graph, _, truth, _ = with_outliers(manhattan, 60, 0, 6, closures=20)
    write(tmp_path / "town.g2o", graph, truth)
    return tmp_path / "town.g2o"


def test_it_says_what_was_read_kept_rejected_and_certified(file, capsys):
    assert solve(file) == 0
    said = capsys.readouterr().out
    answer = rs.solve(rs.load(file))
    assert answer.graph.summary() in said
    assert "The time limit" not in said
    assert answer.summary() in said
    assert f"{answer.rejected.size} closures: " in said


def test_it_writes_what_was_asked_for_with_the_ids_of_the_file(file, tmp_path):
    graph = rs.load(file)
    write(file, graph, names=np.arange(60) + 500)
    names = {"out": "map.g2o", "clean": "clean.g2o", "rejected": "edges.txt", "plot": "map.svg"}
    paths = {option: tmp_path / name for option, name in names.items()}
    solve(file, *(word for name, path in paths.items() for word in (f"--{name}", path)))
    answer, clean = rs.solve(graph), read(paths["clean"])
    np.testing.assert_array_equal(read(paths["out"]).poses, answer.poses)
    np.testing.assert_array_equal(read(paths["out"]).ids, np.arange(60) + 500)
    np.testing.assert_array_equal(clean.graph.edges, graph.edges[answer.kept])
    expected = answer.precise.information[answer.kept]
    np.testing.assert_allclose(clean.graph.information, expected, rtol=1e-12)
    np.testing.assert_allclose(clean.poses, answer.poses, atol=1e-12)
    said = np.loadtxt(paths["rejected"])
    assert answer.rejected.size >= 6
    np.testing.assert_array_equal(said[:, :2], graph.edges[answer.rejected] + 500)
    np.testing.assert_allclose(said[:, 2], answer.residuals[answer.rejected], rtol=1e-3)
    assert said[:, 2].min() > answer.threshold
    assert "<svg" in paths["plot"].read_text()


def test_the_example_of_the_readme_draws_and_prints_for_a_small_graph(file, monkeypatch, capsys):
    monkeypatch.chdir(file.parent)
    readme = Path(__file__).parents[1].joinpath("README.md").read_text("utf-8")
    exec(re.findall(r"```python\n(.*?)```", readme, re.S)[0].replace("my.g2o", file.name))
    plt.close()
    assert "<svg" in Path("my-map.svg").read_text() and "e-0" in capsys.readouterr().out


WITHOUT_MATPLOTLIB = """
import sys
sys.modules["matplotlib"] = None
from robust_slam.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_without_matplotlib_only_a_drawing_is_missed_and_that_before_the_work(file, tmp_path):
    def run(option, name):
        given = ["solve", str(file), "--quiet", option, str(tmp_path / name)]
        command = [sys.executable, "-c", WITHOUT_MATPLOTLIB, *given]
        return subprocess.run(command, capture_output=True, text=True)

    assert run("--out", "map.g2o").returncode == 0 and (tmp_path / "map.g2o").is_file()
    drawn = run("--plot", "map.svg")
    fix = "robust-slam: maps are drawn by Matplotlib: pip install matplotlib"
    assert (drawn.returncode, drawn.stdout, drawn.stderr.strip()) == (2, "", fix)


@pytest.mark.parametrize("suffix", [".tum", ".kitti"])
def test_trajectories_are_in_the_order_of_the_ids_whichever_is_fixed(file, tmp_path, suffix):
    out = tmp_path / f"map{suffix}"
    file.write_text("FIX 40\n" + file.read_text())
    solve(file, "--out", out)
    poses = rs.solve(rs.load(file)).poses[[*range(1, 41), 0, *range(41, 60)]]
    columns = [1, 2] if suffix == ".tum" else [3, 7]
    np.testing.assert_array_equal(np.loadtxt(out)[:, columns], poses[:, :2])


@pytest.mark.parametrize(
    ("names", "arguments", "said"),
    [
        ([*range(30), *range(90, 120)], [], "29-90 crosses a gap .* name it: --closure 29-90"),
        ([*range(30), *range(90, 120)], ["--closure", "90-29"], ""),
        (np.arange(60), ["--closure", "3-9"], "--closure 3-9: no odometry joins these ids"),
    ],
)
def test_odometry_across_a_gap_is_told_and_can_be_a_closure(file, capsys, names, arguments, said):
    write(file, rs.load(file), names=names)
    code = solve(file, *arguments)
    told = capsys.readouterr()
    notes = [line for line in told.out.splitlines() if line.startswith("note")]
    assert re.search(said or "^$", "".join(notes) + told.err)
    joined = "sessions   2" in told.out and "trusted  1 closure: " in told.out
    assert code == 2 or joined == bool(arguments)


def test_ids_with_letters_are_named_so_and_come_back_as_keys(tmp_path, capsys):
    path, out, edges = (tmp_path / name for name in ("town.pyfg", "map.g2o", "rejected.txt"))
    graph, _ = manhattan(60, 0, closures=20)
    spoiled, is_outlier = add_random_closures(graph, 6, 0)
    half = " ".join(map(repr, np.linalg.inv(graph.information[0])[np.triu_indices(3)].tolist()))
    path.write_text(
        "".join(
            f"EDGE_SE2 0.5 K{i} K{j} {x} {y} {angle} {half}\n"
            for (i, j), (x, y, angle) in zip(spoiled.edges, spoiled.measurement, strict=True)
        )
    )
    solve(path, "--closure", "K1-K0", "--out", out, "--rejected", edges)
    i, j = spoiled.edges[np.argmax(is_outlier)]
    assert f"K{i} K{j} " in edges.read_text()
    assert f"rejected {len(edges.read_text().splitlines())} closures: K" in capsys.readouterr().out
    np.testing.assert_array_equal(read(out).ids, (ord("K") << 56) + np.arange(60))


def test_a_drive_and_its_closures_are_a_graph_and_the_map_has_its_times(tmp_path, capsys):
    drive, closures, out = (tmp_path / name for name in ("drive.txt", "loops.g2o", "map.tum"))
    graph, truth = manhattan(60, 0, closures=20)
    times = 1e9 + 0.1 * np.arange(60)
    write_tum(drive, truth, times)
    write(closures, graph)
    closures.write_text("".join(closures.read_text().splitlines(keepends=True)[59:]))
    given = ["--closures", closures, "--odometry", "0.05", "0.02", "--out", out]
    assert solve(drive, *given) == 0
    assert "closures   20, each within about 0.05 m" in capsys.readouterr().out
    np.testing.assert_array_equal(np.loadtxt(out)[:, 0], times)
    np.testing.assert_allclose(np.loadtxt(out)[:, 1:3], truth[:, :2], atol=0.3)
    # Without closures nothing tests it.
    assert solve(drive, *given[2:5]) == 1
    assert solve(drive) == 2
    assert "such as --odometry 0.05 0.01 in m and rad" in capsys.readouterr().err


def test_a_drive_whose_quaternions_begin_with_w_is_read_again(tmp_path, capsys):
    drive, closures = tmp_path / "drive.tum", tmp_path / "loops.g2o"
    graph, truth = sphere(40, 0)
    rs.save(drive, graph, truth)
    rows = np.loadtxt(drive)
    np.savetxt(drive, rows[:, [0, 1, 2, 3, 7, 4, 5, 6]])
    rs.save(closures, graph)
    closures.write_text("".join(closures.read_text().splitlines(keepends=True)[39:]))
    given = ["--closures", closures, "--odometry", "0.05", "0.02", "--readings"]
    assert solve(drive, *given) == 1
    said = capsys.readouterr().out
    assert "reading  with quaternions of the trajectory that begin with w" in said


def test_landmarks_and_gps_are_used_or_left_out(file, tmp_path, capsys):
    names = {"--plot": "map.svg", "--rejected": "rejected", "--out": "map.tum"}
    where = {option: tmp_path / name for option, name in names.items()}
    truth = read(file).poses
    fixes = np.column_stack([np.arange(0, 60, 10), truth[::10, :2]])
    fixes[1, 1] += 50.0
    gps = [f"EDGE_PRIOR_SE2_XY {k:.0f} {x} {y} 4 0 4\n" for k, x, y in fixes]
    file.write_text(file.read_text() + "".join(gps))
    assert solve(file, *(word for pair in where.items() for word in pair)) == 1
    said = capsys.readouterr().out
    assert "positions  5 of 6 kept" in said and "not certified" in said
    assert "10 " in where["--rejected"].read_text()
    np.testing.assert_allclose(np.loadtxt(where["--out"])[:, 1:3], truth[:, :2], atol=0.5)
    assert solve(file, "--unknown", "skip") == 0
    assert solve(file, "--clean", "clean.g2o") == 2
    assert "--clean: it is for relative poses alone" in capsys.readouterr().err


def test_a_name_is_that_of_a_public_graph_and_an_interrupt_is_said(file, capsys, monkeypatch):
    monkeypatch.setattr(datasets, "find", {"intel": file}.__getitem__)
    assert solve("intel") == 0
    assert rs.load(file).summary() in capsys.readouterr().out

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "solve", interrupted)
    assert cli.main(["solve", str(file)]) == 130
    assert capsys.readouterr().err.strip() == "robust-slam: interrupted"


def test_a_pipe_that_closes_early_leaves_no_traceback(file):
    command = [sys.executable, "-m", "robust_slam.cli", "solve", str(file), "--quiet"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, **pipes) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141


def test_without_time_there_is_a_map_without_a_certificate(file, capsys):
    assert solve(file, "--max-seconds", "0") == 1
    assert "The time limit ended the computation" in capsys.readouterr().out
    assert solve(file, "--max-seconds", "-1") == 2
    assert "max_seconds is -1.0; give a number" in capsys.readouterr().err


def test_closures_are_named_by_the_ids_of_the_file(file, capsys):
    graph = rs.load(file)
    joins = [29, 30]
    cut = select(graph, ~np.all(graph.edges == joins, axis=1))
    alone = np.all(np.sort(cut.edges < 30, axis=1) == [False, True], axis=1)
    alone[np.argmax(alone)] = False
    write(file, select(cut, ~alone), names=np.arange(60) * 2 + 500)
    assert solve(file) == 1
    said = capsys.readouterr().out
    i, j = np.array(re.search(r"that of closure (\d+)-(\d+):", said).groups(), dtype=int)
    assert {i < 560, j < 560} == {True, False}
    content = read(file)
    answer = rs.solve(content.graph)
    assert answer.summary(content.names) in said
    assert f"{i}-{j}" not in answer.summary()


def test_progress_is_shown_unless_it_is_quiet(file, capsys):
    cli.main(["solve", str(file)])
    said = capsys.readouterr().err
    assert "DCS with 1 of the claimed deviations" in said and "the certificate is computed" in said
    solve(file)
    assert capsys.readouterr().err == ""


@refused(
    (["nix.g2o"], "nix.g2o"),
    (["town.g2o", "--probability", "1"], "probability is 1"),
    (["bad.g2o"], "leave such lines out with --unknown skip"),
    (["town.g2o", "--out", "town.g2o"], "--out town.g2o: this is the input"),
    (["town.g2o", "--plot", "no/map.svg"], "--plot no/map.svg: there is no folder no"),
    (["town.g2o", "--rejected", "no/edges"], "--rejected no/edges: there is no folder no"),
)
def test_wrong_input_is_one_line_and_code_2(file, capsys, monkeypatch, wrong, message):
    monkeypatch.chdir(file.parent)
    (file.parent / "bad.g2o").write_text(f"HELLO\n{file.read_text()}")
    monkeypatch.setattr("robust_slam.solver.Search", None)
    assert solve(*wrong) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1 and message in said[0]


def test_an_unknown_ending_is_refused_before_the_work(file, capsys):
    with pytest.raises(SystemExit):
        cli.main(["solve", str(file), "--out", "map.txt"])
    assert "end it with .g2o, .tum, .kitti" in capsys.readouterr().err
