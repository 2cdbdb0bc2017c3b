"""The tools of assignment 09 work, and its pictures of public data and of GTSAM's map."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam.certificates import certify
from robust_slam.consistency import pairwise
from robust_slam.graphs import generate, outliers, pose_graph
from robust_slam_course import pipeline as library
from robust_slam_course.exercises import capstone

from tests.assignments import reference

NAMES = reference.load("09-capstone").names
as_dict, pipeline = NAMES["as_dict"], NAMES["pipeline"]


def town(seed=7, count=6):
    rng = np.random.default_rng(seed)
    graph, truth = generate.manhattan(30, rng, side=5, closures=12)
    graph, is_outlier = outliers.add_random_closures(graph, count, rng, poses=truth)
    return graph, is_outlier


# In the second town GNC decides otherwise where it begins at least squares.
@pytest.mark.parametrize(("seed", "count"), [(7, 6), (6, 8)])
def test_tools_put_together_decide_as_the_library_does(seed, count):
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


def test_the_tool_for_pairs_takes_arrays_and_lists():
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
    found = pose_graph.select(graph, ~is_outlier), "a small town"
    monkeypatch.setattr(capstone.datasets, "load_or_generate", lambda *_: found)


def test_a_public_graph_is_named_and_drawn(monkeypatch, capsys):
    small(monkeypatch)
    figure = capstone.public_graph(pipeline)
    assert isinstance(figure, Figure)
    assert capsys.readouterr().out == "a small town\n"


def test_where_there_is_no_data_a_graph_is_made(monkeypatch, capsys):
    def keep_all(graph, *_):
        poses = np.zeros((graph["n"], 3))
        return {"kept": np.ones(len(graph["edges"]), bool), "poses": poses, "verdict": len(poses)}

    monkeypatch.setattr(
        capstone.datasets, "load_or_generate", lambda name, make: (make(), "made up")
    )
    figure = capstone.public_graph(keep_all)
    # Forty closures of 120 are outliers.
    assert figure.axes[0].get_title() == "precision 0.67, recall 1.00: 400"
    assert capsys.readouterr().out == "made up\n"


def test_gtsam_has_the_same_map(monkeypatch):
    pytest.importorskip("gtsam")
    small(monkeypatch)
    figure = capstone.beside_gtsam(pipeline)
    assert isinstance(figure, Figure)
    assert float(figure.axes[0].get_title().split()[3]) < 0.05


def test_without_gtsam_a_sentence_says_so(monkeypatch, capsys):
    monkeypatch.setattr(capstone, "find_spec", lambda name: None)
    assert capstone.beside_gtsam(pipeline) is None
    assert capsys.readouterr().out == f"{capstone.NO_GTSAM}\n"
