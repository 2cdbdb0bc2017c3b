"""The noise that a map shows: how large the deviations are beside those that edges claim.

A file may claim deviations that are far too large or too small, and of rotations other than of
positions. Four factors describe this: of the positions and the rotations of odometry, and of
those of closures. Each is found from the kept edges as the root of their squared residuals over
their redundancy, which is the share of a measurement that the others check.

Source: Helmert 1907 and Förstner 1979 for variance components; Box and Tiao 1973 for what is
expected of them; Hutchinson 1990 for the traces from random signs.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.pose_graph import ROWS, PoseGraph, from_checked
from robust_slam.solver.fitted import Fitted

_PROBES = 24
"""Random signs for a trace; the redundancy is then right to a few percent."""
_ENOUGH = 20.0
"""With a smaller redundancy a kind of edge takes the factor of its counterpart."""
_LEAST = 30.0
"""With a smaller redundancy in all, nothing is found."""
_ROUNDED = 0.3
"""Two measurements of the same poses are copies if they differ by less of their deviations."""
SMALLEST = 1e-3
"""No factor is taken to be below this."""
_NAMES = (
    "odometry's positions",
    "odometry's rotations",
    "closures' positions",
    "closures' rotations",
)


@dataclass(frozen=True, eq=False)
class Found:
    """The factors ``(4,)`` on the claimed deviations, and their redundancy ``(4,)``.

    Both are in the order of positions and rotations of odometry, then of closures. Factors are
    1 where the redundancy does not suffice in all.
    """

    factors: Array
    redundancy: Array

    @property
    def enough(self) -> bool:
        """Whether the kept edges check each other enough to tell their noise."""
        return float(self.redundancy.sum()) >= _LEAST

    @property
    def expected(self) -> Array:
        """The factors ``(4,)`` of the expected variances, which are a little larger.

        Σu² over the variance has a χ² distribution with r degrees of freedom, r the redundancy.
        The variance given Σu² is then expected to be Σu²/(r − 2). With Σu²/r the covariance of a
        map would be too small by as much, which is a tenth where r is 20.

        Source: Box and Tiao 1973, section 2.3, the posterior of a variance.
        """
        if not self.enough:
            return self.factors
        told = _pools(self.redundancy) @ self.redundancy
        return self.factors * np.sqrt(told / (told - 2.0))


def rescaled(graph: PoseGraph, factors: Array) -> PoseGraph:
    """Return ``graph`` with deviations that are its own times the ``factors`` ``(4,)``."""
    if np.all(factors == 1.0):
        return graph
    each = 1.0 / np.array([factors[2:], factors[:2]])[graph.is_odometry.astype(int)]
    by_entry = each[:, _kinds(graph)]
    information = graph.information * by_entry[:, :, None] * by_entry[:, None, :]
    rows = {name: getattr(graph, name) for name in ROWS}
    return from_checked(graph.n, rows | {"information": np.asarray(information)})


def originals(graph: PoseGraph) -> Indices:
    """Return for each edge the one that it repeats, ``(m,)``, itself where it repeats none.

    A copy joins the same poses, either way, and measures the same but for rounding: two
    measurements of their own would differ by more of their deviations.
    """
    group, first = graph.group, np.arange(len(graph.edges))
    low, high = np.sort(graph.edges, axis=1).T
    order = np.lexsort((first, ~graph.is_odometry, high, low))
    again = np.flatnonzero((np.diff(low[order]) == 0) & (np.diff(high[order]) == 0)) + 1
    ahead = (graph.edges[:, 0] == low).reshape(-1, *(1,) * len(group.POSE_SHAPE))
    z = np.where(ahead, graph.measurement, graph.inverse_measurement)
    for k in again:
        one, before = order[k], order[k - 1]
        for other in dict.fromkeys((first[before], before)):
            off = group.log(group.between(z[other], z[one]))
            if off @ graph.information[other] @ off <= _ROUNDED**2:
                first[one] = first[other]
                break
    return first


def find_noise(
    graph: PoseGraph, poses: Array, kept: Mask, scale: ArrayLike = (1.0, 1.0, 1.0, 1.0)
) -> Found:
    """Return the noise of the ``kept`` edges ``(m,)`` at their minimum ``poses``.

    Kinds of few redundancy share a factor on the claimed deviations. Those of ``graph`` are
    ``scale`` ``(4,)`` times the claimed ones.

    Source: Förstner 1979, the estimate Σu²/r with r the redundancy of a group.
    """
    return noise_of(Fitted.of(graph, poses, kept), scale)


def noise_of(fit: Fitted, scale: ArrayLike = (1.0, 1.0, 1.0, 1.0)) -> Found:
    """Return ``find_noise`` of a fit at its minimum, with its ``scale`` ``(4,)``."""
    kind = _kinds(fit.graph) + 2 * (~fit.graph.is_odometry)[:, None]
    squares = np.bincount(kind.ravel(), (fit.residuals**2).ravel(), 4)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (_PROBES, *fit.residuals.shape))
    taken = fit.taken_up(signs)
    if taken is None:
        return Found(np.ones(4), np.zeros(4))
    hat = np.bincount(kind.ravel(), np.mean(signs * taken, axis=0).ravel(), 4)
    counts = np.bincount(kind.ravel(), minlength=4).astype(np.float64)
    redundancy = np.maximum(counts - hat, 0.0)
    if redundancy.sum() < _LEAST:
        return Found(np.ones(4), redundancy)
    # Kinds of few redundancy share that of both kinds, or of all.
    pools, claimed = _pools(redundancy), np.asarray(squares * np.square(scale), dtype=np.float64)
    factors = np.maximum(np.sqrt((pools @ claimed) / (pools @ redundancy)), SMALLEST)
    return Found(factors / np.asarray(scale), redundancy)


def _kinds(graph: PoseGraph) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
    """Return for each entry of a residual ``(D,)`` whether it is a rotation: 0 or 1."""
    return (np.arange(graph.group.DOF) >= graph.group.DIMENSION).astype(np.intp)


def _pools(redundancy: Array) -> Mask:
    """Return for each factor ``(4, 4)`` which kinds tell it: its own, both alike, or all."""
    pools = np.eye(4, dtype=np.bool_)
    for pair in ([0, 2], [1, 3]):
        wider = pair if redundancy[pair].sum() >= _ENOUGH else slice(None)
        for kind in pair:
            if redundancy[kind] < _ENOUGH:
                pools[kind, wider] = True
    return pools


def noise_words(factors: Array) -> str:
    """Return the ``factors`` ``(4,)`` in words, such as "odometry's positions 0.3, …"."""
    if np.ptp(factors) < 1e-9:
        return f"{factors[0]:.2g} of the claimed deviations"
    each = ", ".join(f"{name} {factor:.2g}" for name, factor in zip(_NAMES, factors, strict=True))
    return f"{each} of the claimed deviations"
