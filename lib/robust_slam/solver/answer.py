"""What ``solve`` returns: a map, the edges it kept, and how far it can be trusted.

Source: Huber 1981, "Robust Statistics", chapter 1, for the breakdown point of one half.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._words import counted, few
from robust_slam.certificates.newton import Stop
from robust_slam.certificates.optimality import Certificate, Verdict
from robust_slam.consistency.bridges import Bridges
from robust_slam.descent.marginals import covariance
from robust_slam.estimators.result import StopReason
from robust_slam.graphs.pose_graph import PoseGraph, connected_parts, residual_norms, select
from robust_slam.solver.candidates import Candidate, loosened
from robust_slam.solver.misfit import Misfit
from robust_slam.solver.noise import noise_words, originals, rescaled
from robust_slam.solver.rivals import Lone
from robust_slam.solver.support import Support

_NAMED = 5
"""The largest number of closures in a note."""
_BREAKDOWN = 0.5
"""The share of outliers from which on they may agree on a map that the inliers do not have."""
_AS_CLAIMED = (0.5, 2.0)
"""Noise between these shares of the claimed deviations needs no remark."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Answer:
    """A map, the edges that were kept, and how far it can be trusted.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)`` with pose 0 the identity, are a minimum of the chordal
    cost of the ``kept`` edges, with the noise that was found, and ``certificate`` tells whether it
    is global; ``group.compose(file.poses[0], answer.poses)`` is the map in a file's frame. Whether
    the measurements single out the kept closures is their ``support``; ``rival`` ``(m,)`` marks
    the edges of a map that explains what is contested nearly as well where it is AMBIGUOUS, and
    is None otherwise. ``lone`` are the places that alone hold a part of the map, with its poses,
    and ``misfit`` is what neither noise nor outliers explain; then the support is WEAK. Copies of
    an edge are kept with it, and count once.
    ``candidates`` are all maps that were compared, and ``best`` the one of the largest evidence.
    ``bridges`` are closures that were trusted to join sessions. A closure was kept if its
    residual, whitened with ``best.tested``, is at most ``threshold``.
    """

    graph: PoseGraph
    poses: Array
    best: Candidate
    candidates: tuple[Candidate, ...]
    bridges: Bridges
    threshold: float
    certificate: Certificate
    support: Support
    rival: Mask | None
    misfit: Misfit
    lone: tuple[Lone, ...]

    @property
    def kept(self) -> Mask:
        """A mask ``(m,)`` of the edges that were kept, odometry included."""
        return self.best.kept

    @property
    def weights(self) -> Array:
        """The weight of each edge, ``(m,)``, 0 or 1."""
        return self.kept.astype(np.float64)

    @property
    def noise(self) -> Array:
        """The deviations of the kept edges, in units of those that they claim, ``(4,)``.

        They are those of odometry's positions and rotations, and of closures' positions and
        rotations: the roots of the expected variances, and 1 where too few closures are kept to
        tell.
        """
        return self.best.found

    def about(self, graph: PoseGraph, own: Indices) -> Answer:
        """Return the answer about ``graph``, of whose edges this one's are ``own`` ``(k,)``.

        The others are copies, or rejected.
        """
        first = originals(graph)
        row = np.minimum(np.searchsorted(own, first), own.size - 1)
        there, step = own[row] == first, self.misfit.step
        return replace(
            self,
            graph=graph,
            best=replace(self.best, kept=self.best.kept[row] & there),
            candidates=tuple(replace(one, kept=one.kept[row] & there) for one in self.candidates),
            bridges=replace(self.bridges, edges=own[self.bridges.edges]),
            rival=None if self.rival is None else self.rival[row] & there,
            misfit=replace(
                self.misfit,
                step=None if step is None else int(own[step]),
                closures=own[self.misfit.closures],
            ),
            lone=tuple(replace(one, edge=int(own[one.edge])) for one in self.lone),
        )

    @property
    def precise(self) -> PoseGraph:
        """The graph with the noise that was found in place of the claims.

        The copies of an edge keep next to nothing of their information.
        """
        copies = originals(self.graph) != np.arange(len(self.kept))
        return loosened(rescaled(self.graph, self.noise), copies)

    def covariance(self, k: ArrayLike) -> Array:
        """Return the covariance ``(…, D, D)`` of poses ``k`` ``(…)``, with the noise found.

        Its units and coordinates are those of ``rs.covariance``, which takes any other graph.

        Raises:
            ValueError: ``k`` is not a number of a pose.

        >>> from robust_slam import solve
        >>> from robust_slam.graphs import manhattan
        >>> solve(manhattan(60, 0, closures=15)[0]).covariance([20, 40]).shape
        (2, 3, 3)
        """
        return covariance(self.precise, self.poses, k, self.weights)

    @property
    def clean(self) -> PoseGraph:
        """The kept edges with the noise found, for other programs: save with names=file.ids."""
        return select(self.precise, self.kept)

    @property
    def residuals(self) -> Array:
        """The norm of each edge's residual at ``poses``, ``(m,)``, whitened as in ``precise``."""
        return residual_norms(self.precise, self.poses)

    @property
    def cost(self) -> float:
        """The chordal cost of the kept edges of ``precise``, which the certificate is about.

        It takes one precision for the position of an edge and one for its rotation. For a
        minimum with the whole information matrices continue with
        ``gauss_newton(answer.clean, answer.poses)``.
        """
        return self.certificate.cost

    @property
    def stop(self) -> StopReason:
        """Why the last descent of the map stopped, or TIME_LIMIT if the time did not suffice."""
        return self.best.stop

    @property
    def late(self) -> bool:
        """Whether the time limit ended the search or the proof."""
        return self.stop is StopReason.TIME_LIMIT or self.certificate.stop is Stop.TIME_LIMIT

    @property
    def rejected(self) -> Indices:
        """The edges that were not kept, ascending, slips among them."""
        return np.flatnonzero(~self.kept)

    @property
    def slips(self) -> Indices:
        """The steps of the odometry that slipped and were given up, ascending."""
        return np.flatnonzero(~self.kept & self.graph.is_odometry)

    def __repr__(self) -> str:
        kept = f"{int(self.kept.sum()):,} of {self.kept.size:,} edges kept"
        return f"<Answer: {self.poses.shape[0]:,} poses, {kept}, {self.verdict}>"

    @property
    def verdict(self) -> str:
        """Whether the map is optimal for the kept closures, and their support, in words."""
        proven = self.certificate.verdict is Verdict.CERTIFIED
        optimal = "optimal" if proven else "not proven optimal"
        return f"{optimal} for the kept closures, support {self.support.value}"

    def summary(self, names: ArrayLike | None = None) -> str:
        """Return what was found, a line each, and the ``notes``.

        ``names`` ``(n,)`` are the ids of the poses in their file, such as ``read(path).names``,
        by default their numbers in the graph.
        """
        closures = ~self.graph.is_odometry
        kept, total = int(np.sum(self.kept & closures)), int(closures.sum())
        proof, lost = self.certificate, np.flatnonzero(~self.kept & closures)
        named = f"{counted(lost.size, 'closure')}: {self._named(lost, names)}"
        rows = [
            ("read", f"{counted(self.kept.size, 'edge')}, {counted(total, 'closure')} among them"),
            ("tried", f"{counted(len(self.candidates), 'map')}, the best from {self.best.name}"),
            ("noise", noise_words(self.noise)),
            ("kept", f"{kept:,} of {counted(total, 'closure')}"),
            *([("rejected", named)] if lost.size else []),
            ("map", f"{counted(len(self.poses), 'pose')}, chordal cost {self.cost:.6g}"),
            ("optimum", f"{self.verdict}; the gap is at most {proof.bound:.3g}{_end(proof)}"),
        ]
        return "\n".join([*(f"{name:<8} {text}" for name, text in rows), *self.notes(names)])

    __str__ = summary

    def notes(self, names: ArrayLike | None = None) -> list[str]:
        """Return a sentence for each thing that limits what the map can be trusted with.

        ``names`` are those of ``summary``.
        """
        return [
            *self._support_notes(names),
            *self._misfit_notes(names),
            *self._lone_notes(names),
            *self._slip_notes(names),
            *self._session_notes(),
            *self._share_notes(),
            *([_LATE] if self.late else []),
        ]

    def _support_notes(self, names: ArrayLike | None) -> list[str]:
        late = self.stop is StopReason.TIME_LIMIT
        told = late or self.misfit or self.slips.size or self.lone
        if np.all(self.graph.is_odometry):
            return ["There is no closure: the map is the odometry alone, and nothing tests it."]
        if self.support is Support.WEAK and not told:
            return [
                "Odometry alone has nearly as much evidence as this map, as where closures are "
                "few: look for more closures, or for odometry that slipped."
            ]
        if self.rival is None:
            return []
        edges = np.flatnonzero(self.rival & ~self.kept)
        return [
            f"{counted(edges.size, 'rejected closure')} would give another map of comparable "
            f"evidence: {self._named(edges, names)}. Only other measurements can tell "
            "which is right."
        ]

    def _misfit_notes(self, names: ArrayLike | None) -> list[str]:
        step, closures = self.misfit.step, self.misfit.closures
        lines = []
        if step is not None:
            metres, radians = self.misfit.off
            size = (
                f" by {metres:.2g} m and {np.rad2deg(radians):.2g}°," if metres == metres else ""
            )
            tree = self.graph.is_odometry | np.isin(np.arange(len(self.kept)), self.bridges.edges)
            tree[step] = False
            ends = connected_parts(self.graph.n, self.graph.edges[tree])[self.graph.edges]
            across = int(np.sum(self.kept & ~tree & (ends[:, 0] != ends[:, 1]))) - 1
            lines.append(
                f"The odometry at {self._named(np.array([step]), names)} is off{size} by more "
                f"than its noise explains, as {counted(across, 'closure')} across it show"
                + (_BENDS if self.misfit.bent else _HARMLESS)
            )
        if closures.size:
            lines.append(
                f"{counted(closures.size, 'rejected closure')} are closer to the map than "
                f"outliers would be: {self._named(closures, names)}. They may be right, and the "
                "map wrong."
            )
        return lines

    def _slip_notes(self, names: ArrayLike | None) -> list[str]:
        if not self.slips.size:
            return []
        return [
            f"The odometry slipped at {counted(self.slips.size, 'step')}: "
            f"{self._named(self.slips, names)}. There closures alone join the map, and where "
            "exactly it slipped is not certain."
        ]

    def _session_notes(self) -> list[str]:
        if not self.bridges.edges.size:
            return []
        sessions = self.bridges.edges.size + 1
        return [f"The odometry leaves {sessions:,} sessions, joined by closures."]

    def _lone_notes(self, names: ArrayLike | None) -> list[str]:
        ids = np.arange(self.graph.n) if names is None else np.asarray(names)
        return [
            f"{_parts(ids, one.poses)} rest on one place, that of closure "
            f"{self._named(np.array([one.edge]), names)}: no other closure and not the odometry "
            "would tell if it were wrong."
            for one in self.lone[:_NAMED]
        ]

    def _named(self, edges: Indices, names: ArrayLike | None) -> str:
        ids = np.arange(self.graph.n) if names is None else np.asarray(names)
        return few(f"{i}-{j}" for i, j in ids[self.graph.edges[edges]])

    def _share_notes(self) -> list[str]:
        lines, closures = [], int(np.sum(~self.graph.is_odometry))
        low, high = _AS_CLAIMED
        copies = int(np.sum(originals(self.graph) != np.arange(len(self.kept))))
        if copies:
            lines.append(f"{counted(copies, 'edge')} repeat another, and count once with it.")
        if self.noise.min() < low or self.noise.max() > high:
            lines.append(
                "The noise differs from the claims of the file; weights, thresholds and the "
                "certificate use the noise that was found."
            )
        rejected = self.rejected.size - self.slips.size
        if rejected > _BREAKDOWN * closures:
            lines.append(
                f"{rejected:,} of {counted(closures, 'closure')} were rejected. Beyond "
                "one half outliers may agree on a wrong map."
            )
        return lines


_BENDS = ": it may have slipped there or nearby, which bends the map."
_LATE = "The time limit ended the computation: the map is the best one until then."
_HARMLESS = "; without it no pose would be elsewhere by more than closures tolerate."


def _parts(ids: NDArray[Any], poses: Indices) -> str:
    """Return "Poses 3 to 7 and 12" for runs of ``poses`` ``(k,)``, the longest first."""
    runs = np.split(poses, np.flatnonzero(np.diff(poses) > 1) + 1)
    runs = sorted(runs, key=len, reverse=True)[:2]
    words = [
        f"{ids[run[0]]} to {ids[run[-1]]}" if run.size > 1 else f"{ids[run[0]]}" for run in runs
    ]
    return "Poses " + " and ".join(words)


def _end(proof: Certificate) -> str:
    """Return why the search for a certificate stopped without one."""
    if proof.verdict is Verdict.CERTIFIED or proof.stop is None:
        return ""
    return f"; the search stopped: {proof.stop.value}"
