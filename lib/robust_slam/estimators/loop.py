"""The one loop of the course: reweight, solve, repeat.

Robust estimation as a sequence of weighted least-squares problems. A *problem* computes
residuals and a weighted solution; a *rule* turns residuals into weights. Methods differ in
the rule alone, and problems do not depend on rules.

Source: Black and Rangarajan 1996; SLAM Handbook 2026, Theorem 3.4.
"""

from collections.abc import Callable
from math import inf
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Mask
from robust_slam._deadline import Deadline
from robust_slam.descent.step import check_limits
from robust_slam.errors import Underdetermined
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses
from robust_slam.problems import PoseGraphProblem

X = TypeVar("X")
State = TypeVar("State", bound="float | None")

GRAPH_TOL = 1e-6
"""The tolerance where a pose graph is given: beyond it, no decision on an edge changes."""
_SOLVES = 500
"""The largest number of repetitions of the last solve."""


class Problem(Protocol[X]):
    """Weighted least squares over an unknown x of any type; weights are ``(m,)``."""

    @property
    def trusted(self) -> Mask:
        """The measurements ``(m,)`` whose weight is always 1, such as odometry."""

    def initial(self) -> X:
        """Return the least-squares solution, with all weights 1."""

    def residual_norms(self, x: X) -> Array:
        """Return the whitened residual norm of each measurement, ``(m,)``, at least 0."""

    def solve(self, weights: Array, x: X) -> X:
        """Return the minimiser of Σ w u², starting from ``x`` if the solver is iterative.

        Raises:
            Underdetermined: the measurements with positive weight do not determine it.
        """


class Rule(Protocol[State]):
    """How weights are computed from residuals.

    The state is the rule's μ, or None. The loop passes it from step to step and records it.
    Residual norms and weights are those of the untrusted measurements alone, ``(k,)``; k may
    be 0.
    """

    def start(self, norms: Array) -> State | StopReason:
        """Return the first state, or the reason why there is nothing to do."""

    def weights(self, norms: Array, state: State) -> Array:
        """Return one weight in [0, 1] for each residual norm."""

    def next(self, state: State, weights: Array, moved: Array) -> State:
        """Return the state of the next step.

        ``weights`` ``(k,)`` are those of this step, and ``moved`` ``(k,)`` is the change of
        each residual norm u in this step, relative to 1 + u.
        """

    def cost(self, norms: Array) -> float:
        """Return Σ ρ(u), the cost that the rule minimises."""

    def finished(self, weights: Array, state: State, settled: bool) -> StopReason | None:
        """Return why to stop after a step that used ``weights`` and ``state``, or None.

        ``settled`` is True if this step changed no residual.
        """


class Stateless:
    """What all rules without a state share: they stop when the residuals have settled."""

    def start(self, norms: Array) -> None:
        """Return None, whatever the norms ``(k,)``."""

    def next(self, state: None, weights: Array, moved: Array) -> None:
        """Return None, whatever the weights ``(k,)``."""

    def finished(self, weights: Array, state: None, settled: bool) -> StopReason | None:
        """Return CONVERGED when no residual changed in the step with the weights ``(k,)``."""
        return StopReason.CONVERGED if settled else None


def prepare(
    given: Problem[X] | PoseGraph,
    x0: X | None,
    tol: float | None,
    usual: float,
    trusted: ArrayLike | None = None,
) -> tuple[Problem[X], X | None, float]:
    """Return a problem, its start and its tolerance, from a problem or a pose graph.

    ``x0`` and ``tol`` are kept where they are given. Otherwise a graph has start, tolerance and
    ``trusted`` edges ``(m,)`` as in ``irls``, and the tolerance of a problem is ``usual``.

    Raises:
        TypeError: ``given`` is neither.
        ValueError: ``x0`` are not poses of the graph, or ``trusted`` is given beside a problem.
    """
    graph = given.graph if isinstance(given, PoseGraphProblem) else given
    if x0 is not None and isinstance(graph, PoseGraph):
        check_poses("x0", x0, graph)  # type: ignore[arg-type]
    if isinstance(given, PoseGraph):
        problem = PoseGraphProblem(given, trusted=trusted, tol=GRAPH_TOL, steps=1)
        start: X = problem.guess if x0 is None else x0  # type: ignore[assignment]
        return problem, start, GRAPH_TOL if tol is None else tol  # type: ignore[return-value]
    if trusted is not None:
        raise ValueError("trusted: it is for a pose graph; a problem has its own, problem.trusted")
    if not hasattr(given, "residual_norms"):
        check_graph(given, "problem", "or a problem such as LocationProblem or PoseGraphProblem")
    return given, x0, usual if tol is None else tol


def reweight(
    problem: Problem[X] | PoseGraph,
    rule: Rule[State],
    x0: X | None = None,
    *,
    trusted: ArrayLike | None = None,
    tol: float | None = None,
    max_iterations: int = 100,
    max_seconds: float = inf,
    watch: Callable[[Step[X]], None] | None = None,
) -> Result[X]:
    """Run the loop from ``x0``, or from plain least squares, until the rule stops it.

    Where ``problem`` is a pose graph, start, tolerance and ``trusted`` ``(m,)`` are as in
    ``prepare``; else ``tol`` is 1e-12 by default. ``watch`` is called with each step, to show
    progress. After ``max_seconds`` of CPU time, but not before the first step, it stops with
    TIME_LIMIT.

    A whitened residual u has settled when its change, relative to 1 + u, is at most ``tol``.
    When the weights of a step do not determine x, the loop stops with the previous x: with
    ALL_REJECTED if every untrusted weight is 0, else with UNDERDETERMINED.

    Raises:
        ValueError: the residuals at the start are not finite, ``tol`` or ``max_seconds`` is
            negative, or ``max_iterations`` is below 1.
        Underdetermined: the plain least-squares solution does not exist.
        TypeError: ``problem`` is neither a problem nor a pose graph.

    Source: Black and Rangarajan 1996; SLAM Handbook 2026, Theorem 3.4; Yang et al. 2020.
    """
    problem, x0, tol = prepare(problem, x0, tol, 1e-12, trusted)
    check_limits(tol, max_iterations)
    deadline = Deadline.after(max_seconds)
    x = problem.initial() if x0 is None else x0
    norms = _start_norms(problem, x)
    untrusted = ~problem.trusted
    history = [Step(x, np.ones_like(norms), _cost(rule, norms, untrusted), None)]
    state = rule.start(norms[untrusted])
    if isinstance(state, StopReason):
        return Result.ending(history, state)

    for _ in range(max_iterations):
        weights = np.ones_like(norms)
        weights[untrusted] = rule.weights(norms[untrusted], state)
        try:
            x = problem.solve(weights, x)
        except Underdetermined:
            history.append(Step(x, weights, history[-1].cost, state))
            return Result.ending(history, _without_solution(weights[untrusted]))
        before, norms = norms, problem.residual_norms(x)
        history.append(Step(x, weights, _cost(rule, norms, untrusted), state))
        if watch is not None:
            watch(history[-1])
        moved = _moved(before, norms)
        stop = rule.finished(weights[untrusted], state, bool(np.all(moved <= tol)))
        if stop is not None:
            return Result.ending(history, stop)
        if deadline.passed:
            return Result.ending(history, StopReason.TIME_LIMIT)
        state = rule.next(state, weights[untrusted], moved[untrusted])
    return Result.ending(history, StopReason.ITERATION_LIMIT)


def settle(
    problem: Problem[X],
    rule: Rule[State],
    result: Result[X],
    tol: float,
    *,
    max_seconds: float = inf,
) -> Result[X]:
    """Return ``result`` with its last solve repeated until it converges.

    It has converged when no residual changes by more than ``tol``. Residuals of rejected
    measurements may oscillate, so the repetition also stops when Σ w u² no longer falls. A
    problem whose solve takes only a few steps, such as a pose graph with one step for each
    μ, thereby converges with the final weights; the history gets one more step. An exact
    solve leaves the result unchanged. If the limit on solves or ``max_seconds`` of CPU time
    are reached first, the reason becomes ITERATION_LIMIT or TIME_LIMIT.

    Source: derived here.
    """
    x, norms = result.x, problem.residual_norms(result.x)
    first, stop = norms, StopReason.ITERATION_LIMIT
    deadline = Deadline.after(max_seconds)
    for _ in range(_SOLVES):
        x = problem.solve(result.weights, x)
        before, norms = norms, problem.residual_norms(x)
        if np.all(_moved(before, norms) <= tol) or result.weights @ (norms**2 - before**2) >= 0.0:
            stop = result.stop
            break
        if deadline.passed:
            stop = StopReason.TIME_LIMIT
            break
    if stop is result.stop and np.all(_moved(first, norms) <= tol):
        return result
    last = Step(x, result.weights, _cost(rule, norms, ~problem.trusted), result.history[-1].mu)
    return Result.ending([*result.history, last], stop)


def _moved(before: Array, norms: Array) -> Array:
    return np.asarray(np.abs(norms - before) / (1.0 + before))


def _start_norms(problem: Problem[X], x: X) -> Array:
    norms = problem.residual_norms(x)
    if not np.all(np.isfinite(norms)):
        raise ValueError("x0: its residuals are not finite; start from finite numbers")
    return norms


def _cost(rule: Rule[State], norms: Array, untrusted: Mask) -> float:
    return rule.cost(norms[untrusted]) + 0.5 * float(np.sum(norms[~untrusted] ** 2))


def _without_solution(untrusted: Array) -> StopReason:
    rejected = untrusted.size > 0 and not np.any(untrusted > 0.0)
    return StopReason.ALL_REJECTED if rejected else StopReason.UNDERDETERMINED
