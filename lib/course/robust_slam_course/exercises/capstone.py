"""Pictures for assignment 09: a world, its outliers, the back-end that finds them, a verdict.

A graph goes to a student's functions as a dict of arrays. ``library_tools`` are the functions
that the student's pipeline receives.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Mask, finite, mask
from robust_slam.certificates import optimality as certificates
from robust_slam.certificates.newton import polish
from robust_slam.consistency import cliques, pairwise
from robust_slam.drawing import draw_map, legend_below
from robust_slam.estimators import graduation as annealing
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.files import datasets
from robust_slam.graphs import generate, metrics, outliers, pose_graph
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.palette import PALETTE
from robust_slam.problems import PoseGraphProblem

from robust_slam_course.exercises import as_dict, draw_truth, picture, town

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
        "largest_consistent_set": lambda agree: (
            cliques.max_clique(np.array(agree, dtype=np.bool_), budget=_BUDGET).members
        ),
        "robust_solve": _robust_solve,
        "polish": lambda graph, poses: polish(PoseGraph(**graph), poses),
        "certificate": _certificate,
    }


@picture(width=7.0, height=3.2, ncols=2)
def make_graph(
    axes: Sequence[Axes],
    student: Callable[[int, int, tuple[float, float], int], tuple[Graph, ArrayLike]],
) -> None:
    """Draw the student's world, and how large the truth's residuals are in it."""
    left, right = axes
    made, poses = student(60, 60, (0.1, 0.05), 1)
    graph = PoseGraph(**made)
    truth = finite("truth", poses, (60, 3))
    squares = pose_graph.squared_norms(graph, truth)
    draw_map(graph, truth, left)
    left.set_title("your world: the way, its closures")
    bins = np.linspace(0.0, 14.0, 29)
    right.hist(
        squares, list(bins), density=True, color=PALETTE["estimate"], alpha=0.6, label="yours"
    )
    density = np.sqrt(bins / (2 * np.pi)) * np.exp(-bins / 2)
    draw_truth(right, bins, density, "χ², 3")
    right.set(xlabel="χ² of an edge at the truth", ylabel="density")
    spread = 3.0 * np.sqrt(6.0 / squares.size)  # a χ² of 3 degrees has the variance 6
    right.set_title(f"mean {squares.mean():.2f}: usual is 3 ± {spread:.2f}")
    right.legend()


@picture("Where closures say that the robot came back to", height=5.2)
def spoil(ax: Axes, student: Callable[[Graph, float, int], tuple[Graph, ArrayLike]]) -> None:
    """Draw where closures of a town say that their second pose is, before and after."""
    clean, _, truth = town(0)
    made, marked = student(as_dict(clean), 0.3, 1)
    graph = PoseGraph(**made)
    spoiled = mask("mask", marked, len(graph.edges))
    starts = truth[graph.edges[:, 0]]
    said = graph.group.compose(starts, graph.measurement)
    draw_map(pose_graph.select(clean, clean.is_odometry), truth, ax)
    for name, label, line, marker, chosen in (
        ("inlier", "correct", "-", "o", ~spoiled & ~graph.is_odometry),
        ("outlier", "spoiled", "--", "X", spoiled),
    ):
        for start, end in zip(starts[chosen], said[chosen], strict=True):
            way = np.stack([start, end])[:, :2].T
            ax.plot(*way, line, color=PALETTE[name], linewidth=1.5)
        ax.plot(*said[chosen, :2].T, marker, color=PALETTE[name], label=label)
    ax.legend()


@picture(
    "Headings: the same all round, turned once round, one pose pushed",
    width=7.0, height=3.0, ncols=3,
)  # fmt: skip
def judge(axes: Sequence[Axes], student: Callable[[Graph, Array], str]) -> None:
    """Draw headings of three maps of a robot that turns on the spot, and the verdicts on them."""
    graph, place = _spinning(7), np.arange(7)
    for ax, (name, turn) in zip(axes, _turned(7).items(), strict=True):
        poses = np.stack([0 * turn, 0 * turn, turn], axis=1)
        known = certificates.certificate(graph, poses).verdict.value
        arrows = np.cos(turn), np.sin(turn)
        ax.quiver(place, 0 * turn, *arrows, scale=9.0, width=0.012, pivot="mid")
        ax.set(xlim=(-1, 7), ylim=(-1, 1), xticks=range(7), yticks=[], xlabel="pose", title=name)
        ax.text(3, 0.75, f"truth: {known}", ha="center", color=PALETTE["muted"])
        ax.text(3, -0.85, f"yours: {student(as_dict(graph), poses)}", ha="center")


@picture(height=5.6)
def pipeline(
    ax: Axes, student: Pipeline, made: tuple[PoseGraph, Mask, Array] | None = None
) -> None:
    """Draw what the student's pipeline keeps of a town with outliers, ten if none is given."""
    graph, is_outlier, _ = made or town(10)
    _draw_decisions(ax, graph, student, is_outlier)


@picture(height=5.6)
def public_graph(ax: Axes, student: Pipeline) -> None:
    """Draw what the student's pipeline keeps of a public graph with forty outliers."""
    graph, is_outlier, word = _public()
    print(word)
    _draw_decisions(ax, graph, student, is_outlier)


def beside_gtsam(student: Pipeline) -> Figure | None:
    """Draw the student's map of the public graph over GTSAM's, of the edges that were kept."""
    if find_spec("gtsam") is None:
        print(NO_GTSAM)
        return None
    return _beside_gtsam(student)


@picture("", "x (m)", "y (m)", height=5.2)
def _beside_gtsam(ax: Axes, student: Pipeline) -> None:
    import gtsam
    from robust_slam.files.gtsam_graph import poses_from_gtsam, to_gtsam

    graph, _, _ = _public()
    kept, yours, _ = _answer(graph, student)
    left = pose_graph.select(graph, kept)
    factors, values = to_gtsam(left, yours)
    found = gtsam.LevenbergMarquardtOptimizer(factors, values).optimize()
    theirs = poses_from_gtsam(found, left)
    x, y = theirs[:, :2].T
    draw_truth(ax, x, y, "GTSAM")
    ax.plot(*yours[:, :2].T, "--", color=PALETTE["estimate"], linewidth=1.2, label="yours")
    ax.set_aspect("equal")
    ax.set_title(f"Positions differ by {metrics.ate(yours, theirs):.3f} m (RMSE)")
    ax.legend()


def _answer(graph: PoseGraph, student: Pipeline) -> tuple[Mask, Array, str]:
    """Return the edges that a student's pipeline keeps, its poses, and its verdict."""
    answer = student(as_dict(graph), _LIMIT, _LIMIT, library_tools())
    kept = mask("kept", answer["kept"], len(graph.edges))
    return kept, finite("poses", answer["poses"], (graph.n, 3)), answer["verdict"]


def _draw_decisions(ax: Axes, graph: PoseGraph, student: Pipeline, is_outlier: Mask) -> None:
    """Draw the map of a pipeline's answer, its decisions, and the verdict of the certificate."""
    kept, poses, verdict = _answer(graph, student)
    loops = ~graph.is_odometry
    precision, recall = metrics.precision_recall(kept[loops], ~is_outlier[loops])
    draw_map(graph, poses, ax, kept=kept, is_outlier=is_outlier)
    legend_below(ax)
    ax.set_title(f"precision {precision:.2f}, recall {recall:.2f}: {verdict}")


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
