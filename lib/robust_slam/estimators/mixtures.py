"""Max-mixtures: a measurement has several modes, and the most likely one counts.

The density is p(z|x) ∝ max_i π_i N(μ_i, Λ_i⁻¹) in place of the sum of the modes, so the
cost of an edge is, up to a constant, min_i [½ e_iᵀ Λ_i e_i − log(π_i |Λ_i|^½)], with e_i
the residual against the mean of mode i. The logarithm is the normaliser of the mode: without
it a broad mode would always win. Here the constant is such that mode 0 costs 0 at zero
residual; the other modes then cost at least log(π_0 |Λ_0|^½) − log(π_i |Λ_i|^½), which
may be negative.

The maximum keeps the problem a least-squares problem: once the modes are chosen, every
cost is quadratic in the residual. The logarithm of a sum of modes is not.

``max_mixture`` is the null hypothesis, two modes with the same mean, as a rule of the loop
on residual norms. ``max_mixture_modes`` takes modes with different means.

Source: Olson and Agarwal 2012, "Inference on networks of mixtures for robust robot
mapping", the max-mixture density.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import log, sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask, finite, positive
from robust_slam.descent.normal_equations import NormalEquations, weighted_edges
from robust_slam.descent.step import (
    ROUNDING,
    Linearisation,
    check_limits,
    is_small,
    retract,
)
from robust_slam.estimators.loop import Problem, as_graph_problem, reweight
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.estimators.thresholds import dimension_of
from robust_slam.graphs import pose_graph
from robust_slam.graphs.pose_graph import PoseGraph, check_poses
from robust_slam.problems import PoseGraphProblem

X = TypeVar("X")

_HALVINGS = 30


@dataclass(frozen=True)
class NullHypothesis:
    """The rule for two modes with the same mean: a narrow inlier and a broad outlier mode.

    The inlier mode has the probability ``pi_in`` and the deviations that whiten u; the
    outlier mode has the rest, and deviations ``ratio`` times as large. ``dimension`` is
    that of the residual: 1 for a number, 3 in SE(2), 6 in SE(3). Each edge costs
    min(u²/2, u²/(2 ratio²) + offset) and weighs 1 or 1/ratio².

    Raises:
        ValueError: ``pi_in`` is not inside (0, 1), ``ratio`` is not above 1, or
            ``dimension`` is below 1.

    Source: Olson and Agarwal 2012, the null-hypothesis mixture.
    """

    pi_in: float
    ratio: float
    dimension: int

    def __post_init__(self) -> None:
        if not 0.0 < self.pi_in < 1.0:
            raise ValueError(f"pi_in is {self.pi_in}; give a probability inside (0, 1)")
        if not positive("ratio", self.ratio) > 1.0:
            raise ValueError(f"ratio is {self.ratio}; outliers spread wider, so give more than 1")
        if self.dimension != int(self.dimension) or self.dimension < 1:
            raise ValueError(f"dimension is {self.dimension}; give a whole number of at least 1")

    @property
    def offset(self) -> float:
        """The cost of the outlier mode at u = 0: log(π_in ratio^D / π_out), maybe negative.

        Source: derived here; |Λ|^½ of the outlier mode is that of the inlier mode divided
        by ratio^D.
        """
        return log(self.pi_in / (1.0 - self.pi_in)) + self.dimension * log(self.ratio)

    @property
    def switch_norm(self) -> float:
        """The norm u beyond which the outlier mode wins; 0 when it wins everywhere.

        Source: derived here; u²/2 = u²/(2 ratio²) + offset.
        """
        return sqrt(max(0.0, 2.0 * self.offset / (1.0 - self.ratio**-2)))

    def start(self, norms: Array) -> None:
        """Return None for any norms ``(k,)``: the rule has no state."""

    def weights(self, norms: Array, state: None) -> Array:
        """Return ``(k,)`` weights: 1 where the inlier mode costs least, 1/ratio² elsewhere."""
        inlier, outlier = self._costs(norms)
        return np.where(inlier <= outlier, 1.0, self.ratio**-2)

    def next(self, state: None, weights: Array, moved: Array) -> None:
        """Return None for any weights ``(k,)``."""

    def cost(self, norms: Array) -> float:
        """Return Σ min(u²/2, u²/(2 ratio²) + offset) over the norms ``(k,)``."""
        return float(np.sum(np.minimum(*self._costs(norms))))

    def finished(self, weights: Array, state: None, settled: bool) -> StopReason | None:
        """Stop when the residuals have settled, for any weights ``(k,)``."""
        return StopReason.CONVERGED if settled else None

    def _costs(self, norms: Array) -> tuple[Array, Array]:
        inlier = 0.5 * np.asarray(norms) ** 2
        return inlier, inlier / self.ratio**2 + self.offset


def max_mixture(
    problem: Problem[X] | PoseGraph,
    pi_in: float,
    ratio: float,
    dimension: int | None = None,
    x0: X | None = None,
    *,
    tol: float | None = None,
    max_iterations: int = 100,
) -> Result[X]:
    """Minimise the cost of the null hypothesis, from ``x0`` or from plain least squares.

    The arguments are those of ``NullHypothesis``; ``dimension`` is by default that of the pose
    graph, and 1 where there is none. A weight of 1/ratio² marks a measurement
    that the outlier mode explains better. No measurement is rejected completely: a residual
    u keeps the influence of an inlier with u/ratio², so take a ratio of at least the largest
    expected u.

    Raises:
        ValueError: as ``NullHypothesis`` and ``loop.reweight``, or ``dimension`` is not that of
            the graph.

    Source: Olson and Agarwal 2012, the null-hypothesis mixture.

    >>> from robust_slam.problems import LocationProblem
    >>> result = max_mixture(LocationProblem([0.0, 0.1, 5.0]), 0.9, 100.0, 1, x0=0.0)
    >>> result.weights.round(4).tolist()
    [1.0, 1.0, 0.0001]
    """
    own = dimension_of(problem)
    if own > 1 and dimension not in (None, own):
        raise ValueError(f"dimension is {dimension}; residuals of this graph have {own}")
    rule = NullHypothesis(pi_in, ratio, own if dimension is None else dimension)
    return reweight(problem, rule, x0, tol=tol, max_iterations=max_iterations)


@dataclass(frozen=True, eq=False)
class Mode:
    """An alternative mode of the edges of a graph.

    ``probability`` is a scalar or ``(m,)``, at least 0, and 0 where an edge has no such
    alternative; ``measurement`` ``(m, 3)`` or ``(m, 3, 4)`` and ``information``
    ``(m, D, D)`` are as in the graph.
    """

    probability: ArrayLike
    measurement: Array
    information: Array


def alternative(
    graph: PoseGraph, edges: ArrayLike, probability: ArrayLike, measurement: ArrayLike
) -> Mode:
    """Return a mode in which the edges with indices ``edges`` ``(k,)`` have another measurement.

    ``probability`` is a scalar or ``(k,)``, ``measurement`` ``(k, 3)`` or ``(k, 3, 4)``;
    the information stays that of the graph.

    Raises:
        ValueError: ``edges`` is not a list of edges of the graph, or a shape differs.
    """
    m = len(graph.edges)
    chosen = np.asarray(edges)
    if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError("edges: give the numbers of edges, a list of whole numbers")
    if np.any((chosen < 0) | (chosen >= m)):
        raise ValueError(f"edges: an entry is outside 0 to {m - 1}")
    changed, chance = graph.measurement.copy(), np.zeros(m)
    changed[chosen] = finite("measurement", measurement, (chosen.size, *changed.shape[1:]))
    chance[chosen] = np.broadcast_to(np.asarray(probability, np.float64), chosen.shape)
    return Mode(chance, changed, graph.information)


@dataclass(frozen=True, eq=False, repr=False)
class ModeStep(Step[Array]):
    """A step with the cheapest mode ``(m,)`` of each edge, 0 for the graph's own.

    The weights are 1 for mode 0 and 0 for the others; ``cost`` is the sum over the modes.
    """

    modes: Indices


@dataclass(frozen=True, eq=False, repr=False)
class ModeResult(Result[Array]):
    """A result whose ``kept`` marks the edges in mode 0, the graph's own."""

    history: tuple[ModeStep, ...]

    @property
    def modes(self) -> Indices:
        """The mode ``(m,)`` of each edge at the last step."""
        return self.history[-1].modes


def max_mixture_modes(
    problem: PoseGraphProblem | PoseGraph,
    alternatives: Sequence[Mode],
    x0: ArrayLike | None = None,
    *,
    tol: float = 1e-9,
    max_iterations: int = 200,
) -> ModeResult:
    """Minimise Σ min_i [½ e_iᵀ Λ_i e_i + offset_i] over the poses.

    Mode 0 of an edge is the measurement of the graph, with the probability that
    ``alternatives`` leave. Trusted edges have no other mode. Each iteration chooses the
    cheapest modes at the current poses and takes one Gauss–Newton step with them, halved
    until the cost does not increase. The start is ``x0`` ``(n, 3)`` or ``(n, 3, 4)``, by
    default the guess of the problem: least squares would assume mode 0 for every edge. The
    result is a local minimum, and another start may lead to other modes.

    The result has CONVERGED when the modes do not change and the step is small, with
    ``tol`` as in ``gauss_newton``.

    Raises:
        ValueError: a mode does not fit the graph, the probabilities of an edge are
            negative or leave nothing to mode 0, or a limit is out of range.
        Underdetermined: the normal equations are singular.

    Source: Olson and Agarwal 2012, the max-mixture with several means.
    """
    problem, x0 = as_graph_problem(problem, x0)
    check_limits(tol, max_iterations)
    mixture = _mixture(problem.graph, alternatives, ~problem.trusted)
    equations, ones = NormalEquations(problem.graph), np.ones(len(problem.graph.edges))
    current = mixture.at(problem.guess if x0 is None else check_poses("x0", x0, problem.graph))
    history = [current]
    for _ in range(max_iterations):
        chosen = mixture.chosen(current.modes)
        linearisation = Linearisation.at(chosen, current.x, ones)
        step = equations.solve(*weighted_edges(chosen, linearisation, ones))
        trial = _backtrack(mixture, current, step)
        history.append(trial)
        if is_small(step, current.x, tol) and np.array_equal(trial.modes, current.modes):
            return ModeResult.ending(history, StopReason.CONVERGED)
        current = trial
    return ModeResult.ending(history, StopReason.ITERATION_LIMIT)


@dataclass(frozen=True, eq=False)
class _Mixture:
    """One graph per mode, and the cost ``(K, m)`` of each mode at zero residual."""

    graphs: tuple[PoseGraph, ...]
    offsets: Array

    def at(self, poses: Array) -> ModeStep:
        chi2 = np.stack([pose_graph.squared_norms(graph, poses) for graph in self.graphs])
        costs = 0.5 * chi2 + self.offsets
        modes = np.argmin(costs, axis=0)
        kept = (modes == 0).astype(np.float64)
        return ModeStep(poses, kept, float(np.sum(costs.min(axis=0))), None, modes)

    def chosen(self, modes: Indices) -> PoseGraph:
        each = np.arange(modes.size)
        return replace(
            self.graphs[0],
            measurement=np.stack([graph.measurement for graph in self.graphs])[modes, each],
            information=np.stack([graph.information for graph in self.graphs])[modes, each],
        )


def _mixture(graph: PoseGraph, alternatives: Sequence[Mode], untrusted: Mask) -> _Mixture:
    graphs = (graph, *(_with_mode(graph, k, mode) for k, mode in enumerate(alternatives)))
    chance = np.zeros((len(graphs), len(graph.edges)))
    for k, mode in enumerate(alternatives):
        given = _chances(f"alternatives[{k}]", mode, len(graph.edges))
        chance[k + 1, untrusted] = given[untrusted]
    chance[0] = 1.0 - chance.sum(axis=0)
    if np.any(chance[0] <= 0.0):
        raise ValueError(
            f"alternatives: the probabilities of edge {int(np.argmax(chance[0] <= 0.0))} leave "
            "nothing to what the graph says; let them sum to less than 1"
        )
    with np.errstate(divide="ignore"):
        height = np.log(chance) + [0.5 * np.linalg.slogdet(g.information)[1] for g in graphs]
    return _Mixture(graphs, height[0] - height)


def _with_mode(graph: PoseGraph, k: int, mode: Mode) -> PoseGraph:
    try:
        return replace(graph, measurement=mode.measurement, information=mode.information)
    except ValueError as error:
        raise ValueError(f"alternatives[{k}]: {error}") from error


def _chances(name: str, mode: Mode, m: int) -> Array:
    given = np.asarray(mode.probability, dtype=np.float64)
    chance = finite(f"{name}.probability", np.full(m, given) if given.ndim == 0 else given, (m,))
    if np.any(chance < 0.0):
        raise ValueError(f"{name}.probability: entry {int(np.argmax(chance < 0.0))} is below 0")
    return chance


def _backtrack(mixture: _Mixture, current: ModeStep, step: Array) -> ModeStep:
    """Take the longest of step, step/2, step/4, … that does not increase the cost."""
    for halvings in range(_HALVINGS):
        trial = mixture.at(retract(mixture.graphs[0], current.x, step * 0.5**halvings))
        if trial.cost <= current.cost + ROUNDING * (1.0 + abs(current.cost)):
            return trial
    return current
