"""The map of a factor graph without its outliers, in one function.

It stands beside ``rs.solve``, whose answers promise what is not available here: a certificate of
the optimum, the noise that was found, and the support of the map. All of these are computed from
relative poses alone. What carries over is the principle: several descents from odometry, truncated
least squares from each, and the map of the largest evidence.

Source: Huber 1964, Agarwal et al. 2013 (DCS) and Yang et al. 2020 (GNC) for the descents; their
combination is derived here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._deadline import Deadline
from robust_slam._words import counted, few
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.result import Result, StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.factors.equations import FactorEquations
from robust_slam.factors.evidence import evidence
from robust_slam.factors.factor_graph import FactorGraph, as_factor_graph
from robust_slam.factors.problem import FactorGraphProblem, thresholds_of
from robust_slam.progress import Progress, stages

_TOL = 1e-3
"""A descent is at rest when no norm changes by more than this, relative to 1 + it."""
_STEPS = 200
_LAST = 1e-9


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class FactorAnswer:
    """A map of a factor graph, and the factors that it keeps.

    ``x`` ``(n + l, …)`` has the poses first and then the landmarks, and is a minimum of the cost
    of the ``kept`` factors ``(m,)``. ``evidence`` has the log-evidence (nats) of the map of each
    descent, by name, up to one constant. There is no covariance of it: ``rs.covariance`` knows
    relative poses alone.
    """

    graph: FactorGraph
    x: Array
    kept: Mask
    evidence: dict[str, float]
    stop: StopReason

    @property
    def poses(self) -> Array:
        """The poses, ``(n, 3)`` or ``(n, 3, 4)``."""
        return self.x[: self.graph.n]

    @property
    def landmarks(self) -> Array:
        """The positions of the landmarks, ``(l, 2)`` or ``(l, 3)``, in m."""
        return self.graph.positions_of(self.x)

    @property
    def rejected(self) -> Indices:
        """The factors that were not kept, ascending."""
        return np.flatnonzero(~self.kept)

    @property
    def lost(self) -> Indices:
        """The landmarks of which no factor was kept: their positions mean nothing."""
        nodes = np.arange(self.graph.n, self.graph.nodes)
        return np.setdiff1d(nodes, self.graph.ends[self.kept]) - self.graph.n

    @property
    def doubts(self) -> tuple[str, ...]:
        """A sentence about each kind of measurement of which most are rejected."""
        norms = FactorEquations(self.graph).norms(self.x)
        off = {name: norms[at][~self.kept[at]] for name, at in self.graph.slices.items()}
        return tuple(
            f"{counted(far.size, name[:-1])} of {size:,} rejected, half of them beyond "
            f"{np.median(far):.0f} of the claimed deviations; claim what the sensor can do, or "
            "look for missing digits or another frame"
            for name, far in off.items()
            if name != "relative"
            and 0.5 * (size := self.graph.slices[name].stop - self.graph.slices[name].start) > 2
            and far.size > 0.5 * size
        )

    def __repr__(self) -> str:
        nodes = f"{self.graph.n:,} poses, {counted(self.graph.landmarks, 'landmark')}"
        return f"<FactorAnswer: {nodes}, {self.kept.sum():,} of {self.kept.size:,} factors kept>"

    def summary(self) -> str:
        """Return a line for each kind, with the numbers of rejected ones in it, and each limit."""
        best = max(self.evidence, key=self.evidence.__getitem__)
        rows = [("tried", f"{counted(len(self.evidence), 'descent')}, the best {best}")]
        for name, at in self.graph.slices.items():
            kept, named = self.kept[at], few(np.flatnonzero(~self.kept[at]))
            without = f"; rejected: {named}" if named else ""
            rows.append((name, f"{kept.sum():,} of {kept.size:,} kept{without}"))
        rows += [("doubt", words) for words in self.doubts]
        rows.append(("optimum", "not certified: a local minimum for the kept factors"))
        if self.lost.size:
            rows.append(("lost", f"{counted(self.lost.size, 'landmark')} without a kept factor"))
        if self.stop is StopReason.TIME_LIMIT:
            rows.append(("time", "the limit ended the search"))
        return "\n".join(f"{name:<10} {text}" for name, text in rows)

    __str__ = summary


def solve_factors(
    graph: FactorGraph,
    probability: float = 0.99,
    *,
    x0: ArrayLike | None = None,
    trusted: ArrayLike | None = None,
    progress: bool | Progress = False,
    max_seconds: float = inf,
) -> FactorAnswer:
    """Return the map of a factor graph without its outliers, and which factors these are.

    DCS and GNC descend from the map ``x0`` ``(n + l, …)``, by default
    odometry, in the frame of priors or GPS, with landmarks where most of their sightings place
    them; and DCS descends from the map of Huber's kernel, too. From each end truncated least
    squares decides about all factors, and the map of the largest evidence is returned. An inlier
    passes with ``probability``, in each kind by its own χ² threshold. ``trusted`` ``(m,)`` factors
    are never rejected; by default these are odometry and priors. ``progress`` is that of
    ``rs.solve``. After ``max_seconds`` of CPU time no further descent begins.

    Unlike ``rs.solve`` it takes the deviations that are claimed for true, and cannot tell whether
    the minimum is global, nor whether other measurements would give a map as good. Outliers that
    agree with each other, or a start that is far away, can mislead it. A wrong sighting of a
    landmark that hardly any other factor reaches cannot be told from a right one.

    Raises:
        TypeError: ``graph`` is neither a factor graph nor a pose graph.
        ValueError: an argument does not fit, or ``probability`` is not inside (0, 1).
        Underdetermined: what is kept does not connect all poses; trust the factors that do.

    Source: Huber 1964, Agarwal et al. 2013 and Yang et al. 2020 for the descents.

    >>> from robust_slam.factors import park
    >>> graph, truth, is_wrong = park(100, 1)
    >>> answer = solve_factors(graph)
    >>> int(is_wrong.sum()), int(np.sum(answer.kept & is_wrong))
    (50, 0)
    """
    deadline = Deadline.after(max_seconds)
    whole = as_factor_graph(graph)
    limits = thresholds_of(whole, probability)
    quick = FactorGraphProblem(whole, x0, trusted, limits, steps=1)
    equations = FactorEquations(whole)
    ends: dict[str, tuple[Array, float]] = {}
    with stages(progress) as tell:
        for name, descent in _DESCENTS.items():
            if ends and deadline.passed:
                break
            tell(f"{name} descends")
            x = descent(quick, quick.guess, deadline.left).x
            x = _reweighted(kernels.tls, quick, x, deadline.left).x
            kept = quick.trusted | (quick.residual_norms(x) <= quick.threshold)
            ends[name] = x, evidence(equations, x, kept)
    best = max(ends.values(), key=lambda end: end[1])[0]
    last = FactorGraphProblem(whole, best, trusted, limits, tol=_LAST)
    result = _reweighted(kernels.tls, last, best, deadline.left)
    equations.check_joined(result.weights)
    return FactorAnswer(
        graph=whole,
        x=result.x,
        kept=result.kept,
        evidence={name: value for name, (_, value) in ends.items()},
        stop=StopReason.TIME_LIMIT if deadline.passed else result.stop,
    )


def _reweighted(
    kernel: Callable[[float], kernels.Kernel],
    problem: FactorGraphProblem,
    x: Array,
    seconds: float,
) -> Result[Array]:
    scaled, tol = kernel(problem.threshold), _TOL if problem.steps == 1 else _LAST
    return irls(problem, scaled, x, tol=tol, max_iterations=_STEPS, max_seconds=seconds)


def _huber_dcs(problem: FactorGraphProblem, x: Array, seconds: float) -> Result[Array]:
    wide = _reweighted(kernels.huber, problem, x, seconds).x
    return _reweighted(kernels.dcs, problem, wide, seconds)


_DESCENTS: dict[str, Callable[[FactorGraphProblem, Array, float], Result[Array]]] = {
    "Huber, DCS": _huber_dcs,
    "DCS": partial(_reweighted, kernels.dcs),
    "GNC": lambda problem, x, seconds: gnc(
        problem, problem.threshold, x0=x, tol=_TOL, max_seconds=seconds
    ),
}
"""From a map, within the seconds that are left.

Where GPS or landmarks that are seen again bound the drift, Huber's convex kernel finds the way
that odometry lost; where odometry is good and closures are wrong, it is the other way round.
"""
