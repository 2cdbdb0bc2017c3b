"""What the pipeline returns: a map, the edges it kept, and what happened at each stage.

Source: SLAM Handbook 2026, chapter 3, for the stages; Huber 1981, "Robust Statistics", chapter
1, for the breakdown point of one half.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._words import counted
from robust_slam.certificates.newton import Stop
from robust_slam.certificates.optimality import Certificate, Verdict
from robust_slam.consistency.bridges import Bridges
from robust_slam.consistency.pairwise import PcmResult
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.pipeline.classification import Classification

_NAMED = 5
"""The largest number of closures in a note."""
_BREAKDOWN = 0.5
"""The share of outliers from which on they may agree on a map that the inliers do not have."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Answer:
    """A map, the edges that were kept, and the result of each stage.

    ``kept`` ``(m,)`` marks the edges of the graph that were kept, odometry among them, and
    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, are a minimum of their chordal cost. ``stages``
    tells what PCM, GNC and truncated least squares made of the closures, and ``certificate``
    whether the minimum is global. ``noise`` is the deviation of the kept edges in units of the
    deviation they claim, and ``threshold`` the largest whitened residual norm of a closure that
    is kept; it is scaled where the noise is below 0.1, as ``solve`` tells.
    """

    graph: PoseGraph
    poses: Array
    stages: Classification
    noise: float
    threshold: float
    certificate: Certificate

    @property
    def kept(self) -> Mask:
        """The edges ``(m,)`` that were kept, odometry among them."""
        return self.stages.final.kept

    @property
    def weights(self) -> Array:
        """The weight of each edge, ``(m,)``, 0 or 1."""
        return self.kept.astype(np.float64)

    @property
    def consistency(self) -> PcmResult:
        """The result of PCM over all edges."""
        return self.stages.consistency

    @property
    def bridges(self) -> Bridges:
        """The closures that were trusted to join sessions, where the odometry does not."""
        return self.stages.bridges

    @property
    def result(self) -> Result[Array]:
        """The result of GNC over the consistent edges."""
        return self.stages.result

    @property
    def final(self) -> Result[Array]:
        """The result of truncated least squares over all edges, which decides."""
        return self.stages.final

    @property
    def cost(self) -> float:
        """The chordal cost of the kept edges, which the certificate is about.

        It takes one precision for the position of an edge and one for its rotation. For a
        minimum with the whole information matrices continue with
        ``gauss_newton(select(graph, answer.kept), answer.poses)``.
        """
        return self.certificate.cost

    @property
    def stop(self) -> StopReason:
        """Why GNC stopped, or TIME_LIMIT if the time did not suffice for the closures."""
        limited = self.final.stop is StopReason.TIME_LIMIT
        return self.final.stop if limited else self.result.stop

    @property
    def history(self) -> tuple[Step[Array], ...]:
        """The steps of GNC, over the consistent edges."""
        return self.result.history

    @property
    def rejected(self) -> Indices:
        """The edges that were not kept, ascending."""
        return np.flatnonzero(~self.kept)

    @property
    def returned(self) -> Indices:
        """The edges that PCM or GNC rejected and that were kept in the end, ascending."""
        return np.flatnonzero(self.kept & ~self._classified())

    def __repr__(self) -> str:
        kept = f"{int(self.kept.sum()):,} of {self.kept.size:,} edges kept"
        return f"<Answer: {self.poses.shape[0]:,} poses, {kept}, {self.certificate.verdict.value}>"

    def summary(self, names: ArrayLike | None = None) -> str:
        """Return what happened at each stage, a line each, and the ``notes``.

        ``names`` ``(n,)`` are the ids of the poses in their file, such as ``read(path).names``,
        by default their numbers in the graph.
        """
        masks = (self.consistency.kept, self._classified(), self.kept)
        agree, classified, kept = (int(np.sum(mask & ~self.graph.is_odometry)) for mask in masks)
        proof, steps = self.certificate, counted(len(self.history) - 1, "step")
        total = counted(int(np.sum(~self.graph.is_odometry)), "closure")
        rows = [
            ("read", f"{counted(self.kept.size, 'edge')}, {total} among them"),
            ("PCM", f"{counted(agree, 'closure')} consistent{self._about_pcm()}"),
            ("GNC", f"{counted(classified, 'closure')} kept; {self.result.stop.value}, {steps}"),
            ("TLS", f"{counted(kept, 'closure')} kept, {self.returned.size:,} of them returned"),
            ("map", f"{counted(len(self.poses), 'pose')}, chordal cost {self.cost:.6g}"),
            (
                "optimum",
                f"{proof.verdict.value}, the gap is at most {proof.bound:.3g}{_end(proof)}",
            ),
        ]
        return "\n".join([*(f"{name:<8} {text}" for name, text in rows), *self.notes(names)])

    def notes(self, names: ArrayLike | None = None) -> list[str]:
        """Return a sentence for each thing that limits what the map can be trusted with.

        ``names`` are those of ``summary``.
        """
        return [*self._session_notes(names), *self._share_notes(), *self._time_notes()]

    def _classified(self) -> Mask:
        """Return the edges ``(m,)`` that PCM and GNC kept."""
        kept = self.consistency.kept.copy()
        kept[kept] = self.result.kept
        return kept

    def _about_pcm(self) -> str:
        if not self.consistency.complete:
            return ", not all pairs compared"
        return "" if self.consistency.clique.proven else ", maybe not the largest such set"

    def _session_notes(self, names: ArrayLike | None) -> list[str]:
        edges, support = self.bridges.edges, self.bridges.support
        if not edges.size:
            return []
        lines = [f"The odometry leaves {edges.size + 1:,} sessions, joined by trusted closures."]
        alone = edges[support == 1]
        if alone.size:
            named = self._named(alone, names)
            lines.append(f"Nothing confirms {alone.size:,} of these closures: {named}.")
        return lines

    def _named(self, edges: Indices, names: ArrayLike | None) -> str:
        ids = np.arange(self.graph.n) if names is None else np.asarray(names)
        shown = [f"{i}-{j}" for i, j in ids[self.graph.edges[edges[:_NAMED]]]]
        return ", ".join([*shown, "…"] if edges.size > _NAMED else shown)

    def _share_notes(self) -> list[str]:
        lines, closures = [], int(np.sum(~self.graph.is_odometry))
        if self.noise < 0.1:
            lines.append(
                f"Residuals are {self.noise:.2g} of the deviations that the information matrices "
                f"claim, so closures were tested with the norm {self.threshold:.3g}."
            )
        if self.rejected.size > _BREAKDOWN * closures:
            lines.append(
                f"{self.rejected.size:,} of {counted(closures, 'closure')} were rejected. Beyond "
                "one half outliers may agree on a wrong map, or the information matrices claim "
                "more precision than the measurements have."
            )
        return lines

    def _time_notes(self) -> list[str]:
        stopped = [self.result.stop, self.final.stop, self.certificate.stop]
        if StopReason.TIME_LIMIT in stopped or Stop.TIME_LIMIT in stopped:
            return ["The time limit ended the computation: the map is the best one until then."]
        return []


def _end(proof: Certificate) -> str:
    """Return why the search for a certificate stopped without one."""
    if proof.verdict is Verdict.CERTIFIED or proof.stop is None:
        return ""
    return f"; the search stopped: {proof.stop.value}"
