"""Pictures for assignment 09: a world, its outliers, the back-end that finds them, a verdict.

Every function takes a student's own, of the same name. A graph goes to them as a dict of
arrays. ``library_tools`` are the functions that the student's pipeline receives.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Indices, Mask, finite, mask
from robust_slam.certificates import optimality as certificates
from robust_slam.certificates.newton import polish
from robust_slam.consistency import cliques, pairwise
from robust_slam.drawing import draw_map, legend_below
from robust_slam.estimators import graduation as annealing
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import datasets, generate, metrics, outliers, pose_graph
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.palette import PALETTE
from robust_slam.problems import PoseGraphProblem
from scipy.stats import chi2

from robust_slam_course.exercises import as_dict, once_it_works

Graph = Mapping[str, Any]
Tools = Mapping[str, Callable[..., Any]]
Pipeline = Callable[[Graph, float, float, Tools], Mapping[str, Any]]

NO_GTSAM = "GTSAM is not installed here: pip install gtsam, and run this cell once more."
_LIMIT = chi_square_threshold(0.99, 3)
_BUDGET = 1_000_000
_OUTLIERS = 40


def library_tools() -> dict[str, Callable[..., Any]]:
    """Return the five tools of the capstone's pipeline, by name, as the library has them."""
    return {
        "pairwise_consistent": _pairwise_consistent,
        "largest_consistent_set": _largest_consistent_set,
        "robust_solve": _robust_solve,
        "polish": lambda graph, poses: polish(PoseGraph(**graph), poses),
        "certificate": _certificate,
    }


@once_it_works
def make_graph(
    student: Callable[[int, int, tuple[float, float], int], tuple[Graph, ArrayLike]],
) -> Figure:
    """Draw the student's world, and how large the truth's residuals are in it."""
    made, poses = student(60, 60, (0.1, 0.05), 1)
    graph = PoseGraph(**made)
    truth = finite("truth", poses, (60, 3))
    squares = pose_graph.squared_norms(graph, truth)
    fig = Figure(figsize=(7.0, 3.2))
    left, right = fig.subplots(1, 2)
    draw_map(graph, truth, left)
    left.set_title("your world: the way, its closures")
    bins = np.linspace(0.0, 14.0, 29)
    right.hist(squares, bins, density=True, color=PALETTE["estimate"], alpha=0.6, label="yours")
    density = chi2.pdf(bins, 3)
    right.plot(bins, density, "-", color=PALETTE["muted"], linewidth=6, alpha=0.4, label="χ², 3")
    right.set(xlabel="χ² of an edge at the truth", ylabel="density")
    spread = 3.0 * np.sqrt(6.0 / squares.size)  # a χ² of 3 degrees has the variance 6
    right.set_title(f"mean {squares.mean():.2f}: usual is 3 ± {spread:.2f}")
    right.legend()
    return fig


@once_it_works
def spoil(student: Callable[[Graph, float, int], tuple[Graph, ArrayLike]]) -> Figure:
    """Draw where closures of a town say that their second pose is, before and after."""
    clean, truth = generate.manhattan(60, np.random.default_rng(2), side=6, closures=20)
    made, marked = student(as_dict(clean), 0.3, 1)
    graph = PoseGraph(**made)
    spoiled = mask("mask", marked, len(graph.edges))
    said = graph.group.compose(truth[graph.edges[:, 0]], graph.measurement)
    starts = truth[graph.edges[:, 0]]
    fig = Figure(figsize=(5.6, 5.2))
    ax = fig.subplots()
    draw_map(pose_graph.select(clean, clean.is_odometry), truth, ax)
    for name, chosen in (("inlier", ~spoiled & ~graph.is_odometry), ("outlier", spoiled)):
        label = {"inlier": "correct", "outlier": "spoiled"}[name]
        for k in np.flatnonzero(chosen):
            ends = np.stack([starts[k], said[k]])
            line = "-" if name == "inlier" else "--"
            ax.plot(*ends[:, :2].T, line, color=PALETTE[name], linewidth=1.5)
        marker = {"inlier": "o", "outlier": "X"}[name]
        ax.plot(*said[chosen, :2].T, marker, color=PALETTE[name], label=label)
    ax.set_title("Where closures say that the robot came back to")
    ax.legend()
    return fig


@once_it_works
def judge(student: Callable[[Graph, Array], str]) -> Figure:
    """Draw headings of three maps of a robot that turns on the spot, and the verdicts on them."""
    fig = Figure(figsize=(7.0, 3.0))
    for ax, (name, turn) in zip(fig.subplots(1, 3), _turned(7).items(), strict=True):
        graph, poses = _spinning(7), np.stack([0 * turn, 0 * turn, turn], axis=1)
        known = certificates.certificate(graph, poses).verdict.value
        ax.quiver(
            np.arange(7), 0 * turn, np.cos(turn), np.sin(turn), scale=9.0, width=0.012, pivot="mid"
        )
        ax.set(xlim=(-1, 7), ylim=(-1, 1), xticks=range(7), yticks=[], xlabel="pose")
        ax.set_title(name)
        ax.text(3, 0.75, f"truth: {known}", ha="center", color=PALETTE["muted"])
        ax.text(3, -0.85, f"yours: {student(as_dict(graph), poses)}", ha="center")
    fig.suptitle("Headings: the same all round, turned once round, one pose pushed", fontsize=11)
    return fig


@once_it_works
def pipeline(student: Pipeline) -> Figure:
    """Draw what the student's pipeline keeps of a town with ten outliers."""
    rng = np.random.default_rng(2)
    graph, truth = generate.manhattan(60, rng, side=6, closures=20)
    graph, is_outlier = outliers.add_random_closures(graph, 10, rng, poses=truth)
    return _decisions(graph, student(as_dict(graph), _LIMIT, _LIMIT, library_tools()), is_outlier)


@once_it_works
def public_graph(student: Pipeline) -> Figure:
    """Draw what the student's pipeline keeps of a public graph with forty outliers."""
    graph, is_outlier, word = _public()
    print(word)
    return _decisions(graph, student(as_dict(graph), _LIMIT, _LIMIT, library_tools()), is_outlier)


def beside_gtsam(student: Pipeline) -> Figure | None:
    """Draw the student's map of the public graph over GTSAM's, of the edges that were kept."""
    if find_spec("gtsam") is None:
        print(NO_GTSAM)
        return None
    return _beside_gtsam(student)


@once_it_works
def _beside_gtsam(student: Pipeline) -> Figure:
    import gtsam
    from robust_slam.graphs.gtsam_graph import poses_from_gtsam, to_gtsam

    graph, _, _ = _public()
    answer = student(as_dict(graph), _LIMIT, _LIMIT, library_tools())
    left = pose_graph.select(graph, mask("kept", answer["kept"], len(graph.edges)))
    yours = finite("poses", answer["poses"], (graph.n, 3))
    factors, values = to_gtsam(left, yours)
    found = gtsam.LevenbergMarquardtOptimizer(factors, values).optimize()
    theirs = poses_from_gtsam(found, left)
    fig = Figure(figsize=(5.6, 5.2))
    ax = fig.subplots()
    ax.plot(*theirs[:, :2].T, "-", color=PALETTE["muted"], linewidth=6, alpha=0.4, label="GTSAM")
    ax.plot(*yours[:, :2].T, "--", color=PALETTE["estimate"], linewidth=1.2, label="yours")
    ax.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    ax.set_title(f"Positions differ by {metrics.ate(yours, theirs):.3f} m (RMSE)")
    ax.legend()
    return fig


def _decisions(graph: PoseGraph, answer: Mapping[str, Any], is_outlier: Mask) -> Figure:
    """Draw the map of a pipeline's answer, its decisions, and the verdict of the certificate."""
    kept = mask("kept", answer["kept"], len(graph.edges))
    poses = finite("poses", answer["poses"], (graph.n, 3))
    loops = ~graph.is_odometry
    precision, recall = metrics.precision_recall(kept[loops], ~is_outlier[loops])
    fig = Figure(figsize=(5.6, 5.6))
    ax = fig.subplots()
    draw_map(graph, poses, ax, kept=kept, is_outlier=is_outlier)
    legend_below(ax)
    ax.set_title(f"precision {precision:.2f}, recall {recall:.2f}: {answer['verdict']}")
    return fig


def _public() -> tuple[PoseGraph, Mask, str]:
    """Return the graph intel, or a generated one, with outliers, their mask and a sentence."""
    rng = np.random.default_rng(2)

    def made() -> PoseGraph:
        return generate.manhattan(400, rng, side=9, closures=80)[0]

    graph, word = datasets.load_or_generate("intel", made)
    spoiled, is_outlier = outliers.add_random_closures(graph, _OUTLIERS, rng)
    return spoiled, is_outlier, word


def _pairwise_consistent(
    odometry: ArrayLike,
    odometry_cov: ArrayLike,
    ends: ArrayLike,
    loops: ArrayLike,
    loop_cov: ArrayLike,
    gamma: float,
) -> Mask:
    """Return which pairs of closures are consistent, from arrays as in assignment 06."""
    steps = np.array(odometry, dtype=np.float64).reshape(-1, 3)
    chain = np.stack([np.arange(len(steps)), np.arange(1, len(steps) + 1)], axis=1)
    closures = np.array(loops, dtype=np.float64).reshape(-1, 3)
    covariance = [
        np.array(c, dtype=np.float64).reshape(-1, 3, 3) for c in (odometry_cov, loop_cov)
    ]
    graph = PoseGraph(
        n=len(steps) + 1,
        edges=np.concatenate([chain, np.array(ends, dtype=np.intp).reshape(-1, 2)]),
        measurement=np.concatenate([steps, closures]),
        information=np.linalg.inv(np.concatenate(covariance)),
        is_odometry=np.arange(len(steps) + len(closures)) < len(steps),
    )
    return pairwise.pairwise_consistent(graph, gamma)


def _largest_consistent_set(agree: ArrayLike) -> Indices:
    """Return the members of a largest clique, or of the largest within a budget."""
    return cliques.max_clique(np.array(agree, dtype=np.bool_), budget=_BUDGET).members


def _robust_solve(graph: Graph, c: float) -> tuple[Array, Array]:
    """Return poses and weights of GNC-TLS as the library's pipeline runs it."""
    problem = PoseGraphProblem(PoseGraph(**graph), steps=1)
    result = annealing.gnc(problem, c, x0=problem.guess)
    return result.x, result.weights


def _certificate(graph: Graph, poses: ArrayLike) -> tuple[str, float]:
    """Return the verdict on poses, and the bound on their optimality gap."""
    found = certificates.certificate(PoseGraph(**graph), poses)
    return found.verdict.value, found.bound


def _spinning(n: int) -> PoseGraph:
    """Return a ring of n poses in which no step and no turn was measured."""
    ring = np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1)
    unit = np.tile(np.eye(3), (n, 1, 1))
    return PoseGraph(n, ring, np.zeros((n, 3)), unit, np.arange(n) < n - 1)


def _turned(n: int) -> dict[str, Array]:
    """Return headings (n,) of three maps of the ring, by name."""
    twisted = 2.0 * np.pi * np.arange(n) / n
    pushed = np.where(np.arange(n) == n // 2, 0.8, 0.0)
    return {"all alike": np.zeros(n), "once round": twisted, "one pushed": pushed}
