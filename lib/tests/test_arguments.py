"""A wrong argument is named with what to give; results and problems have a line and identity."""

import copy
import dataclasses
import inspect
import pickle
import pkgutil
import re
from contextlib import nullcontext
from functools import partial
from importlib import import_module

import numpy as np
import pytest
import robust_slam as rs
from robust_slam import files
from robust_slam._names import FOLDERS
from robust_slam.certificates import certificate, certify, chordal_cost, solve_certified
from robust_slam.certificates.chordal import ChordalProblem
from robust_slam.certificates.newton import polish
from robust_slam.consistency.pairwise import pcm
from robust_slam.descent.minimise import gauss_newton, levenberg_marquardt
from robust_slam.descent.start import chordal
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.mixtures import max_mixture
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.switches import dcs, joint_switchable, switchable
from robust_slam.factors import FactorAnswer, FactorGraphProblem, park, solve_factors
from robust_slam.files import g2o
from robust_slam.files.gtsam_graph import to_gtsam
from robust_slam.files.trajectories import write_tum
from robust_slam.graphs import add_random_closures, spanning_tree
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.problems import LinearProblem, LocationProblem, PoseGraphProblem, RotationProblem

from .worlds import refused

GRAPH, TRUTH = manhattan(30, 0, closures=8)
FACTORS = park(40, 0)[0]


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: irls(GRAPH, "tukey"), ValueError, "kernel is 'tukey'; give one of squared, hu"),
        (lambda: irls(GRAPH, lambda z: z), TypeError, "kernel is <lambda>; give a kernel such as"),
        (lambda: irls(GRAPH, loss="tukey"), ValueError, "loss is 'tukey'; give one of squared"),
        (lambda: irls(GRAPH, "huber", 1.345), TypeError, r"x0 is 1.345; .* the scale is c=1.345"),
        (lambda: irls(GRAPH), TypeError, "give either a kernel, such as 'cauchy', or a loss"),
        (lambda: irls(GRAPH, "huber", loss="huber"), TypeError, "give either a kernel, such as"),
        (lambda: irls(GRAPH, "huber", c=0.0), ValueError, "k is 0.0; give a finite number above"),
        (lambda: irls(GRAPH, kernels.Kernel), TypeError, "kernel is Kernel; give"),
        (lambda: irls(GRAPH, 3.0), TypeError, "kernel is 3.0; give"),
        (lambda: gnc(GRAPH, x0=TRUTH[:-1]), ValueError, r"x0: the shape is \(29, 3\); give \(30"),
        (lambda: gnc(PoseGraphProblem(GRAPH), x0=1.0), ValueError, r"x0: the shape is \(\)"),
        (lambda: g2o.write("no.g2o", TRUTH, GRAPH), TypeError, "graph is a ndarray; give a PoseG"),
        (lambda: write_tum("no.tum", GRAPH), TypeError, "poses is a PoseGraph; give an array"),
        (lambda: gauss_newton(GRAPH, None), TypeError, r"poses is None; give an array \(30, 3\)"),
        (lambda: rs.solve(GRAPH, progress="yes"), TypeError, "progress is 'yes'; give True, F"),
        (lambda: max_mixture(GRAPH, 0.9, 10.0, 6), ValueError, "dimension is 6; .* have 3"),
        (lambda: rs.covariance(GRAPH, TRUTH, [0, -31]), ValueError, r"-31\]; poses are 0 to 29"),
    ],
)
def test_a_wrong_argument_is_named_with_what_to_give(call, error, message):
    with pytest.raises(error, match=message):
        call()


FILE = files.GraphFile(GRAPH, TRUTH, np.arange(30), np.arange(30))
REST = {"path": "no.g2o", "kernel": "huber", "pi_in": 0.9, "ratio": 9.0, "gamma": 3.0}
GRAPHS = ("graph", "graphs", "problem")
TAKERS = {PoseGraphProblem} | {
    taker
    for module in (rs, *(getattr(rs, folder) for folder in FOLDERS))
    for taker in (getattr(module, name) for name in module.__all__)
    if callable(taker)
    and taker not in (files.GraphFile, files.GraphFileError, files.save, FactorAnswer)
    if any(name in GRAPHS for name in inspect.signature(taker).parameters)
}


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (FILE, "is a GraphFile; give a PoseGraph, its attribute graph"),
        (
            FACTORS,
            "is a FactorGraph; give a PoseGraph, its attribute relative, or solve the whole",
        ),
        (3, "is a int; give a PoseGraph, (for instance|or a problem such)"),
    ],
)
@pytest.mark.parametrize("taker", sorted(TAKERS, key=lambda taker: taker.__name__))
def test_what_is_no_pose_graph_is_named_with_what_to_give(taker, wrong, words):
    taken = {solve_factors: FACTORS, FactorGraphProblem: FACTORS}.get(taker)
    asked = inspect.signature(taker).parameters.values()
    needed = [
        one.name for one in asked if one.default is one.empty and one.kind is not one.VAR_KEYWORD
    ]
    given = {name: REST.get(name, 0) for name in [*needed, *["kernel"] * (taker is irls)]}
    given |= {name: [wrong] if name == "graphs" else wrong for name in needed if name in GRAPHS}
    with nullcontext() if taken is wrong else pytest.raises(TypeError, match=words):
        taker(**given)


TAKE_POSES = [gauss_newton, levenberg_marquardt, chordal_cost, polish, certificate, certify]
TAKE_WEIGHTS = [lambda *given, take=take: take(given[0], TRUTH, *given[1:]) for take in TAKE_POSES]

WRITE = [partial(g2o.write, "no.g2o"), to_gtsam]


def test_edges_that_are_trusted_are_kept_by_every_estimator_of_a_graph():
    wrong, _ = add_random_closures(GRAPH, 1, 0, poses=TRUTH)
    trusted = np.append(GRAPH.is_odometry, True)
    for solve in (gnc, partial(irls, kernel="tls")):
        assert not solve(wrong).kept[-1] and solve(wrong, trusted=trusted).kept[-1]
    with pytest.raises(ValueError, match="trusted: it is for a pose graph; a problem has its own"):
        gnc(PoseGraphProblem(GRAPH), trusted=trusted)
    with pytest.raises(ValueError, match=r"the rows \[R | t\] of each: poses\[:, :3\]"):
        rs.PoseGraph(2, [[0, 1]], np.eye(4)[None], np.eye(6))


@pytest.mark.parametrize("take", [*TAKE_POSES, *WRITE, solve_certified])
@refused((TRUTH[:-1], "poses: the shape"), (np.full((30, 3), np.nan), "poses: the entry"))
def test_poses_that_do_not_fit_are_refused_by_name(take, wrong, message):
    with pytest.raises(ValueError, match=message):
        take(GRAPH, wrong)


@pytest.mark.parametrize("take", [*TAKE_WEIGHTS, spanning_tree, chordal, ChordalProblem.of])
@refused(
    (np.ones(3), "weights: the shape"),
    (np.full(37, np.nan), "weights: the entry"),
    (np.where(np.arange(37) == 7, -0.5, 1.0), "weights: edge 7 weighs less than 0"),
    (np.eye(37)[0], r"joins pose 2 to pose 0 \(28 poses are loose\)"),
)
def test_weights_that_do_not_fit_are_refused_by_name(take, wrong, message):
    with pytest.raises(ValueError, match=message):
        take(GRAPH, wrong)


def test_what_the_package_lists_is_there_and_the_kernels_that_have_a_name_are_told():
    for name in re.findall(r"^- ``(\w+)``", rs.__doc__, re.M):
        assert getattr(rs, name).__name__ == f"robust_slam.{name}"
    assert not [name for name in kernels.KERNELS if f'"{name}"' not in irls.__doc__]


def test_the_dimension_of_a_mixture_is_that_of_the_problem():
    by_hand = max_mixture(GRAPH, 0.9, 10.0, 3)
    np.testing.assert_array_equal(max_mixture(GRAPH, 0.9, 10.0).x, by_hand.x)
    location = LocationProblem([0.0, 0.1, 5.0])
    assert max_mixture(location, 0.9, 9.0, x0=0.0).x == max_mixture(location, 0.9, 9.0, 1, 0.0).x


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (pcm(GRAPH), "8 of 8 closures agree"),
        (rs.solve(GRAPH).bridges, "0 closures"),
        (rs.solve(GRAPH).misfit, "step None, 0 closures"),
        (LocationProblem([1.0]), "1 measurement, 0 of them trusted"),
        (LinearProblem(np.eye(2), [0, 0]), "2 unknowns, 2 measurements, 0 of"),
        (RotationProblem(np.eye(3), np.eye(3)), "3 measurements, 0 of them trusted"),
        (PoseGraphProblem(GRAPH), "30 poses in SE(2), 37 edges, 29 of them trusted"),
        (rs.PoseGraph(2, [[0, 1]], [[1, 0, 0]], [np.eye(3)], [True]), "1 edge, 0 of them"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_value_has_a_line(value, words):
    assert words in repr(value)
    assert repr(value).startswith(f"<{type(value).__name__}: ") and len(repr(value)) < 100


def test_a_certificate_is_told_line_by_line_without_its_arrays():
    proof = certify(GRAPH, TRUTH)[1]
    words = ["verdict  certified", f"cost     {proof.cost:.6g}", f"bound    {proof.bound:.3g}"]
    assert proof.summary().splitlines() == [*words, "stop     stationary"]
    assert "direction" not in repr(proof)


def test_numbers_of_poses_may_count_from_the_end():
    from_the_end, from_0 = (rs.covariance(GRAPH, TRUTH, k) for k in ([-1, -29], [29, 1]))
    np.testing.assert_array_equal(from_the_end, from_0)


def test_what_holds_arrays_is_compared_by_identity_but_for_graphs_and_has_a_hash():
    assert len({gnc(GRAPH), gnc(GRAPH)}) == 2 and gnc(GRAPH) != gnc(GRAPH)
    names = [module.name for module in pkgutil.walk_packages(rs.__path__, "robust_slam.")]
    classes = {
        value
        for name in names
        for value in vars(import_module(name)).values()
        if isinstance(value, type) and dataclasses.is_dataclass(value)
    }
    arrays = re.compile(r"(?!.*Callable).*(Array|Mask|Indices|ndarray|\bX\b)")
    held = [c for c in classes if any(arrays.match(str(f.type)) for f in dataclasses.fields(c))]
    assert len(held) > 20
    assert [c.__name__ for c in held if c.__eq__ is not object.__eq__] == ["PoseGraph"]


@pytest.mark.parametrize("make", [manhattan, sphere])
def test_a_used_problem_can_be_pickled_and_used_again(make):
    graph, _ = make(30, 0)
    problem = PoseGraphProblem(graph)
    x = problem.initial()
    weights = graph.is_odometry.astype(float)
    problem.solve(weights, x)
    copy = pickle.loads(pickle.dumps(problem))
    np.testing.assert_array_equal(copy.initial(), x)
    np.testing.assert_array_equal(copy.solve(weights, x), problem.solve(weights, x))


@pytest.mark.parametrize(
    "made",
    [
        lambda: GRAPH,
        lambda: gnc(GRAPH),
        lambda: irls(GRAPH, "huber"),
        lambda: rs.solve(GRAPH),
        lambda: solve_factors(FACTORS),
        lambda: pcm(GRAPH),
        lambda: certify(GRAPH, TRUTH)[1],
        lambda: rs.GrowingMap(GRAPH),
        lambda: FACTORS,
    ],
)
def test_a_result_is_printed_pickled_and_copied(made):
    one = made()
    for again in (pickle.loads(pickle.dumps(one)), copy.copy(one), copy.deepcopy(one)):
        assert repr(again) == repr(one) and str(again) == str(one)
    assert str(one) == (one.summary() if hasattr(one, "summary") else repr(one))


@pytest.mark.parametrize(
    "solve",
    [
        *(gnc, switchable, dcs, rs.solve),
        lambda graph: irls(graph, kernels.cauchy(1.0)),
        lambda graph: max_mixture(graph, 0.9, 10.0),
        lambda graph: joint_switchable(graph, 10.0),
    ],
)
def test_every_robust_solve_returns_the_same_kind_of_result(solve):
    result = solve(GRAPH)
    assert result.poses.shape == TRUTH.shape
    assert result.kept.shape == result.weights.shape == (len(GRAPH.edges),)
    np.testing.assert_array_equal(result.kept, result.weights > 0.5)
    assert isinstance(result.stop, StopReason)
    assert isinstance(result.cost, float)
    assert len(result.candidates if solve is rs.solve else result.history) > 0
    assert "\n" not in repr(result) and len(repr(result)) < 120
    assert result.summary().count("\n") > 1
