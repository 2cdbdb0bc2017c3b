"""Maps that may be right: several descents from odometry, each settled with its own noise.

No descent is best on all graphs. A few of them, which fail in different worlds, give candidates,
and the evidence decides among them. Each candidate is settled in turns: truncated least squares
decides about all closures, and the kept edges tell their noise, with which it decides again.

Source: Geman and McClure 1985, Agarwal et al. 2013 (DCS), Yang et al. 2020 (GNC) and Mangelson et
al. 2018 (PCM) for the descents; that they are candidates is derived here.
"""

from collections.abc import Callable, Generator, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias, TypeVar, cast

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam._deadline import Deadline
from robust_slam.consistency.pairwise import pcm
from robust_slam.descent import start
from robust_slam.errors import Underdetermined
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc, start_mu
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import accumulated_rotation
from robust_slam.graphs.pose_graph import PoseGraph, residual_norms, select, unreached
from robust_slam.problems import PoseGraphProblem
from robust_slam.progress import Progress
from robust_slam.solver.evidence import evidence
from robust_slam.solver.fitted import Fitted
from robust_slam.solver.noise import SMALLEST, Found, find_noise, noise_of, rescaled

T = TypeVar("T")
Steps: TypeAlias = Generator[None, None, T]

TOL = 1e-3
"""A descent is at rest when no residual norm u changes by more than this, relative to 1 + u."""
_STEPS = 60
_SCALES = (1.0, 1 / 4, 1 / 16)
"""What the deviations may be beside those that are claimed: first guesses."""
_MUCH_LESS = 0.5
"""The smallest of these is tried only where all maps show less noise than this."""
_WIDER = (3.0, 9.0, 27.0)
"""Further guesses, tried while hardly any closure is kept."""
_FEW = (5, 0.05)
"""Hardly any closures: fewer than so many and than this share."""
_HIGH, _LOW, _MARGIN = 1.15, 0.7, 3.0
"""Deviations are raised above the first, and lowered to the margin if that is below the second."""
_CUT, _WIDEN = 0.05, 1.3
"""Where more than this share of closures is near, those of closures are raised by the second."""
_ROUNDS, _ROUND = 8, 10
_AT_REST = 0.1
"""A step that lowers the cost by less (nats) is the last of a descent that others follow."""
_SETTLED = 0.1
"""Noise is settled when no factor changes by more, relative to itself."""
_LOST = np.pi
"""The deviation (rad) of a rotation along the odometry from which on it may be any."""
_TRIMS = 2
"""So many times the closures that fit worst are left out of the chordal map."""
_WORST = 3.0
"""A closure fits too badly if its residual is so many times the median."""
_NEAR = 3.0
"""A closure within so many thresholds is near: another descent might keep it."""
_SOME = 0.02
"""Fewer rejected closures near a map than this share of the kept ones leave it as it is."""
_REACH = 5.0
"""A rejected closure may return if its residual is at most so many thresholds."""
_AS_CLAIMED = 1.5
"""Noise within this factor of the claimed one is as claimed."""
_MANY = 1000
"""So many closures tell their noise whatever they claim."""
_MUCH = 100.0
"""Two descents that agree with so much evidence (nats) need no third."""
_LOOSE = 1e-8
"""The share of its information that a slipped step keeps."""
_CLAIMED = Found(np.ones(4), np.zeros(4))
_RARE = 1.0 - 1e-5
"""An inlier has a larger residual with one minus this probability, if the noise is Gaussian."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A map, the closures that it keeps, and how much the measurements support it.

    ``kept`` ``(m,)`` are edges within the threshold with deviations that are ``tested`` ``(4,)``
    times the claimed ones, ``found`` ``(4,)`` is the noise of the kept edges relative to the
    claims, and ``evidence`` is relative to odometry alone, in nats, with the deviations that were
    found. ``near`` counts the rejected closures within a few thresholds, and ``misfits`` the kept
    ones that are too far from the map for the noise of the others.
    """

    name: str
    poses: Array
    kept: Mask
    tested: Array
    found: Array
    evidence: float
    near: int
    misfits: int
    stop: StopReason


@dataclass(frozen=True, eq=False)
class Search:
    """What all candidates have in common.

    They descend from the poses ``x0`` ``(n, …)`` with the ``trusted`` edges ``(m,)``, of which
    ``given`` ``(m,)`` were told to be right, and keep a closure up to the ``threshold``. With
    ``learns`` they find their noise, else the claims hold. ``entropy`` is that of
    ``outlier_entropy``, and ``slips`` ``(m,)`` are steps of the odometry that are given up.
    ``tell`` is told each descent, and after the ``deadline`` no other begins.
    """

    graph: PoseGraph
    x0: Array
    given: Mask
    trusted: Mask
    threshold: float
    learns: bool
    tell: Progress
    deadline: Deadline
    entropy: float
    slips: Mask

    def candidates(self) -> list[Candidate]:
        """Return the candidates, at least one.

        Raises:
            Underdetermined: the trusted edges do not determine the map to working precision.
        """
        # Where closures join sessions, odometry alone leads nowhere: PCM looks at pairs first.
        joined = bool(np.any(self.trusted & ~self.graph.is_odometry))
        found = [self._settled("PCM, GNC" if joined else "DCS", np.ones(4))]
        if self._clear(found[0]):
            return found
        for scale in _SCALES if self.learns else _SCALES[:1]:
            if scale < _SCALES[1] and max(one.found.max() for one in found) > _MUCH_LESS:
                break
            found.extend(self._tried("GM", np.full(4, scale)))
        for scale in _WIDER if self.learns else ():
            if max(map(self._closures, found)) >= max(_FEW[0], _FEW[1] * np.sum(~self.trusted)):
                break
            found.extend(self._tried("GM", np.full(4, scale)))
        best = max(found, key=lambda one: one.evidence)
        if joined or not np.all(best.tested == 1.0):
            found.extend(self._tried("DCS", best.tested))
        if _agree(found):
            return found
        found.extend(self._tried("GNC", best.tested))
        if not (joined and np.all(best.tested == 1.0)):
            found.extend(self._tried("PCM, GNC", best.tested))
        return found

    def refined(self, best: Candidate) -> Candidate:
        """Return ``best`` with poses and noise that belong to each other.

        The noise was found at poses of other weights, so both are computed in turns. In the end
        it is that of the expected variances.
        """
        if not self.learns or np.array_equal(best.found, np.ones(4)):
            return best
        kept, poses, found, expected = best.kept, best.poses, best.found, best.found
        for _ in range(_ROUNDS):
            if self.deadline.passed:
                break
            graph = rescaled(self.graph, found)
            poses = self.problem(graph).solve(kept.astype(np.float64), poses)
            again = find_noise(graph, poses, kept, found)
            expected = np.maximum(found * again.expected, SMALLEST)
            found = np.maximum(found * again.factors, SMALLEST)
            if np.all(np.abs(again.factors - 1.0) <= _SETTLED):
                break
        return replace(best, poses=poses, found=expected)

    def _closures(self, one: Candidate) -> int:
        return int(np.sum(one.kept & ~self.trusted))

    def _clear(self, one: Candidate) -> bool:
        """Tell whether most closures agree, with the noise they claim, and no other is near.

        Many closures may have another noise: outliers hide in deviations that are claimed too
        large, but then some do not fit the noise of the others. Where odometry has lost its
        rotation, few closures are not trusted to have found it.
        """
        kept = self._closures(one)
        if one.evidence <= 0.0 or 2 * kept <= np.sum(~self.trusted) or one.near > _SOME * kept:
            return False
        claimed = bool(np.all(np.abs(np.log(one.found)) < np.log(_AS_CLAIMED)))
        if one.misfits > 0 or kept >= _MANY:
            return one.misfits == 0
        own = rescaled(self.graph, one.found)
        return claimed and accumulated_rotation(own, self.trusted) <= _LOST

    def _tried(self, name: str, scale: Array) -> Iterator[Candidate]:
        """Yield ``_settled``, or nothing where no time is left or the map is not determined."""
        if not self.deadline.passed:
            with suppress(Underdetermined):
                yield self._settled(name, scale)

    def _settled(self, name: str, scale: Array) -> Candidate:
        """Return the candidate of a descent with ``scale`` ``(4,)`` of the claimed deviations."""
        self.tell(f"{name} with {scale.max():.2g} of the claimed deviations")
        problem = self.problem(rescaled(self.graph, scale))
        poses = _DESCENTS[name](problem, self.threshold, self.deadline.left)
        return self.settle(name, poses, scale)

    def problem(self, graph: PoseGraph) -> PoseGraphProblem:
        """Return the problem of ``graph``, where slips hold parts together and no more."""
        return Sparing(loosened(graph, self.slips), self.x0, self.trusted, steps=1)

    def reviewing(self) -> Steps[Candidate]:
        """Descend by DCS until the cost is at rest, in steps of a linear solve or so."""
        problem, kernel = self.problem(self.graph), kernels.dcs(self.threshold)
        poses, _ = yield from self._descending(problem, kernel, self.x0, 2 * _ROUND, _AT_REST)
        return (yield from self.settling("DCS", poses, np.ones(4)))

    def settle(self, name: str, poses: Array, tested: Array) -> Candidate:
        """Return the best of the rounds of truncated least squares and noise."""
        return finished(self.settling(name, poses, tested))

    def settling(self, name: str, poses: Array, tested: Array) -> Steps[Candidate]:
        """Do as ``settle``, in steps of a linear solve or so."""
        best: Candidate | None = None
        kernel = kernels.tls(self.threshold)
        for _ in range(_ROUNDS):
            problem = self.problem(rescaled(self.graph, tested))
            poses, stop = yield from self._descending(problem, kernel, poses, _ROUND, -np.inf)
            norms = problem.residual_norms(poses)
            kept = (self.trusted & ~self.slips) | (~self.trusted & (norms <= self.threshold))
            fit = Fitted.of(problem.graph, poses, kept)
            found = noise_of(fit) if self.learns else _CLAIMED
            own = np.maximum(tested * found.factors, SMALLEST) if found.enough else np.ones(4)
            near = int(np.sum(~kept & ~self.trusted & (norms < _NEAR * self.threshold)))
            precise = rescaled(self.graph, own)
            support = evidence(precise, poses, kept, self.entropy, fit)
            rare = chi_square_threshold(_RARE, self.graph.group.DOF)
            misfits = int(np.sum(kept & ~self.trusted & (residual_norms(precise, poses) > rare)))
            one = Candidate(name, poses, kept, tested, own, support, near, misfits, stop)
            if best is not None and one.evidence <= best.evidence:
                break
            best = one
            change = _change(found, near, int(np.sum(kept & ~self.trusted)))
            if np.all(change == 1.0) or self.deadline.passed:
                break
            yield
            tested = np.maximum(tested * change, SMALLEST)
        assert best is not None
        return best

    def _descending(
        self, problem: PoseGraphProblem, kernel: kernels.Kernel, x: Array, most: int, rest: float
    ) -> Steps[tuple[Array, StopReason]]:
        """Do ``irls`` from ``x`` ``(n, …)``, ``most`` solves, and return its poses and its stop.

        A solve that lowers the cost by less than ``rest`` is the last.
        """
        stop = StopReason.ITERATION_LIMIT
        for _ in range(most):
            seconds = self.deadline.left
            result = irls(problem, kernel, x, tol=TOL, max_iterations=1, max_seconds=seconds)
            x, stop = result.x, result.stop
            yield
            lowered = result.history[0].cost - result.cost
            if stop is not StopReason.ITERATION_LIMIT or lowered < rest:
                break
        return x, stop


def finished(steps: Steps[T]) -> T:
    """Do all ``steps``, and return what they end with."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return cast(T, end.value)


def loosened(graph: PoseGraph, slips: Mask) -> PoseGraph:
    """Return ``graph`` with edges in ``slips`` ``(m,)`` that hold its parts together, no more."""
    if not np.any(slips):
        return graph
    information = graph.information.copy()
    information[slips] *= _LOOSE
    return replace(graph, information=information)


def _agree(found: list[Candidate]) -> bool:
    """Tell whether DCS and Geman–McClure keep the same closures, with much evidence."""
    best = max(found, key=lambda one: one.evidence)
    names = {one.name for one in found if np.array_equal(one.kept, best.kept)}
    return best.evidence > _MUCH and names == {"DCS", "GM"}


def _change(found: Found, near: int, kept: int) -> Array:
    """Return the factors ``(4,)`` by which the tested deviations change.

    Many closures just outside the threshold are inliers that were cut off: the others then show
    less noise than there is.
    """
    if not found.enough:
        return np.ones(4)
    h = found.factors
    change = np.where(h > _HIGH, h, np.where(_MARGIN * h < _LOW, _MARGIN * h, 1.0))
    if near > _CUT * kept:
        change[2:] = np.maximum(change[2:], _WIDEN)
    return change


def _reweighted(
    kernel: Callable[[float], kernels.Kernel], problem: PoseGraphProblem, c: float, seconds: float
) -> Array:
    return irls(
        problem, kernel(c), problem.guess, tol=TOL, max_iterations=_STEPS, max_seconds=seconds
    ).x


def _graduated_consistent(problem: PoseGraphProblem, c: float, seconds: float) -> Array:
    """Descend by GNC over what PCM keeps, from odometry or from a chordal map of it.

    Where odometry has lost its rotation, a chordal map without the closures that fit it worst may
    be closer; then the one of lower TLS cost is taken.
    """
    deadline = Deadline.after(seconds)
    used = pcm(problem.graph, c, max_seconds=seconds).kept | problem.trusted
    consistent = select(problem.graph, used)

    def truncated(poses: Array) -> float:
        return float(np.sum(np.minimum(residual_norms(consistent, poses), c) ** 2))

    x0 = min((problem.guess, *_trimmed(consistent)), key=truncated)
    fewer = Sparing(consistent, x0, problem.trusted[used], steps=1)
    poses = gnc(fewer, c, "tls", x0, tol=TOL, max_seconds=deadline.left).x
    return readmitted(problem, poses, c, deadline.left)


def readmitted(
    problem: PoseGraphProblem, poses: Array, c: float, seconds: float = np.inf
) -> Array:
    """Return the poses that GNC reaches from ``poses`` ``(n, …)`` over all closures near them.

    Inliers that were rejected pull on the map only when they return, so at first closures
    count up to ``_REACH`` thresholds.

    Source: Yang et al. 2020 for the surrogate and, Remark 5, its first μ; its use to take
    closures back is derived here.
    """
    norms = problem.residual_norms(poses)
    near = ~problem.trusted & (norms > c) & (norms < _REACH * c)
    if not np.any(near):
        return poses
    # Weights are above 0 up to _REACH thresholds, or to √2 of the largest norm if less.
    mu = max(1.0 / (_REACH**2 - 1.0), start_mu(float(np.max(norms[near])), c))
    return gnc(problem, c, x0=poses, mu0=mu, tol=TOL, max_seconds=seconds).x


def _trimmed(graph: PoseGraph) -> Iterator[Array]:
    """Yield chordal maps, each without the closures that fit the one before worst."""
    used = np.ones(len(graph.edges), dtype=np.bool_)
    for _ in range(_TRIMS + 1):
        poses = start.chordal(select(graph, used))
        yield poses
        if np.all(graph.is_odometry):
            return
        norms = residual_norms(graph, poses)
        before = used
        used = graph.is_odometry | (norms <= _WORST * np.median(norms[~graph.is_odometry]))
        if np.array_equal(used, before) or unreached(graph, used).size:
            return


_DESCENTS: dict[str, Callable[[PoseGraphProblem, float, float], Array]] = {
    "DCS": partial(_reweighted, kernels.dcs),
    "GM": partial(_reweighted, kernels.geman_mcclure),
    "GNC": lambda problem, c, seconds: (
        gnc(problem, c, "tls", problem.guess, tol=TOL, max_seconds=seconds).x
    ),
    "PCM, GNC": _graduated_consistent,
}
"""From odometry, with the threshold and the seconds that are left."""


class Sparing(PoseGraphProblem):
    """A problem that leaves out edges that weigh next to nothing, for the fill-in they cause."""

    least = 1e-6

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the poses ``(n, …)`` of the next step from ``x``, with ``weights`` ``(m,)``.

        Edges that weigh less than ``least`` are left out.
        """
        return super().solve(np.where(weights < self.least, 0.0, weights), x)
