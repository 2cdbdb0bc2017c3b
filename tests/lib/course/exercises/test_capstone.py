"""The pictures of assignment 09 draw what a student's functions return, and its tools work."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam import pipeline as library
from robust_slam.certificates import certify, optimality
from robust_slam.consistency import pairwise
from robust_slam.graphs import generate, outliers, pose_graph
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam_course.exercises import capstone


def as_dict(graph):
    names = ("edges", "measurement", "information", "is_odometry")
    return {"n": graph.n} | {name: getattr(graph, name) for name in names}


def make_graph(n, loops, noise, seed):
    rng = np.random.default_rng(seed)
    sigma = generate.Noise(odometry=noise, closure=noise)
    graph, truth = generate.circle(n, rng, laps=4, closures=loops, noise=sigma)
    return as_dict(graph), truth


def spoil(graph, fraction, seed):
    rng = np.random.default_rng(seed)
    spoiled, is_outlier = outliers.spoil_closures(PoseGraph(**graph), fraction, rng)
    return as_dict(spoiled), is_outlier


def judge(graph, poses):
    return optimality.certificate(PoseGraph(**graph), poses).verdict.value


def pipeline(graph, gamma, c, tools):
    own, cov = graph["is_odometry"], np.linalg.inv(graph["information"])
    z, loops = graph["measurement"], np.flatnonzero(~graph["is_odometry"])
    agree = tools["pairwise_consistent"](
        z[own], cov[own], graph["edges"][loops], z[loops], cov[loops], gamma
    )

    def left(kept):
        return {key: value if key == "n" else value[kept] for key, value in graph.items()}

    kept = own.copy()
    kept[loops[tools["largest_consistent_set"](agree)]] = True
    poses, weights = tools["robust_solve"](left(kept), c)
    kept[kept] = weights > 0.5
    poses = tools["polish"](left(kept), poses)
    verdict, gap = tools["certificate"](left(kept), poses)
    return {"poses": poses, "kept": kept, "verdict": verdict, "gap": gap}


RIGHT: dict[str, Callable[..., object]] = {
    "make_graph": make_graph,
    "spoil": spoil,
    "judge": judge,
    "pipeline": pipeline,
}


def drawn(name: str) -> Figure:
    figure = getattr(capstone, name)(RIGHT[name])
    assert isinstance(figure, Figure)
    return figure


def town(seed=7, count=6):
    rng = np.random.default_rng(seed)
    graph, truth = generate.manhattan(30, rng, side=5, closures=12)
    graph, is_outlier = outliers.add_random_closures(graph, count, rng, poses=truth)
    return graph, is_outlier


def test_the_truth_of_a_right_world_has_the_residuals_it_should() -> None:
    title = drawn("make_graph").axes[1].get_title()
    assert abs(float(title.split()[1].rstrip(":")) - 3) < 0.8


def test_spoiled_closures_are_marked() -> None:
    ax = drawn("spoil").axes[0]
    counts = {line.get_label(): len(line.get_xdata()) for line in ax.lines}
    assert (counts["correct"], counts["spoiled"]) == (14, 6)


def test_three_maps_have_three_verdicts() -> None:
    said = [[text.get_text() for text in ax.texts] for ax in drawn("judge").axes]
    verdicts = ["certified", "not certified", "not stationary"]
    assert said == [[f"truth: {word}", f"yours: {word}"] for word in verdicts]


def test_decisions_are_told_in_the_title() -> None:
    assert drawn("pipeline").axes[0].get_title() == "precision 1.00, recall 1.00: certified"


# In the second town GNC decides otherwise where it begins at least squares.
@pytest.mark.parametrize(("seed", "count"), [(7, 6), (6, 8)])
def test_tools_put_together_decide_as_the_library_does(seed: int, count: int) -> None:
    graph, _ = town(seed, count)
    whole = library.solve(graph)
    limit = 3.3682141752187276
    answer = pipeline(as_dict(graph), limit, limit, capstone.library_tools())
    kept = whole.consistency.kept.copy()
    kept[kept] = whole.result.kept  # the assignment's pipeline lets no closure return
    poses, certificate = certify(pose_graph.select(graph, kept), whole.result.x)
    np.testing.assert_array_equal(answer["kept"], kept)
    np.testing.assert_allclose(answer["poses"], poses, atol=1e-6)
    assert answer["verdict"] == certificate.verdict.value
    assert answer["gap"] == pytest.approx(certificate.bound, abs=1e-6)


def test_the_tool_for_pairs_takes_arrays_and_lists() -> None:
    graph, _ = town()
    own, loops = graph.is_odometry, ~graph.is_odometry
    cov = np.linalg.inv(graph.information)
    arrays = [graph.measurement[own], cov[own], graph.edges[loops]]
    arrays += [graph.measurement[loops], cov[loops]]
    tool = capstone.library_tools()["pairwise_consistent"]
    want = pairwise.pairwise_consistent(graph, 3.0)
    np.testing.assert_array_equal(tool(*arrays, 3.0), want)
    np.testing.assert_array_equal(tool(*[array.tolist() for array in arrays], 3.0), want)
    assert tool(arrays[0], arrays[1], [], [], [], 3.0).shape == (0, 0)


def small(monkeypatch: pytest.MonkeyPatch) -> None:
    graph, is_outlier = town()
    monkeypatch.setattr(capstone, "_public", lambda: (graph, is_outlier, "a small town"))


def test_a_public_graph_is_named_and_drawn(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    small(monkeypatch)
    figure = capstone.public_graph(pipeline)
    assert isinstance(figure, Figure)
    assert capsys.readouterr().out == "a small town\n"


def test_where_there_is_no_data_a_graph_is_made(
    monkeypatch: pytest.MonkeyPatch, tmp_path: object
) -> None:
    def missing(name, make):
        return make(), "made up"

    monkeypatch.setattr(capstone.datasets, "load_or_generate", missing)
    graph, is_outlier, word = capstone._public()
    assert (graph.n, int(is_outlier.sum()), word) == (400, 40, "made up")


def test_gtsam_has_the_same_map(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("gtsam")
    small(monkeypatch)
    figure = capstone.beside_gtsam(pipeline)
    assert isinstance(figure, Figure)
    assert float(figure.axes[0].get_title().split()[3]) < 0.05


def test_without_gtsam_a_sentence_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(capstone, "find_spec", lambda name: None)
    assert capstone.beside_gtsam(pipeline) is None
    assert capsys.readouterr().out == f"{capstone.NO_GTSAM}\n"
