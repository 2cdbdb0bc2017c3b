"""The scalar precisions of the rotation and the translation of each measurement."""

from __future__ import annotations

import numpy as np

from robust_slam._arrays import Array
from robust_slam.graphs.pose_graph import PoseGraph


def precisions(graph: PoseGraph) -> tuple[Array, Array]:
    """Return κ ``(m,)``, without a unit, and τ ``(m,)`` in 1/m², the precisions of each edge.

    In SE(2) κ = Ω_θθ and τ = 2 / tr(Ω_tt⁻¹), in SE(3) κ = 3 / (2 tr(Ω_RR⁻¹)) and
    τ = 3 / tr(Ω_tt⁻¹), where Ω_tt and Ω_RR are the diagonal blocks of the information. As
    ‖R − I‖²_F ≈ 2 θ², a small angle costs κ · 2 θ²: in SE(3) as much as in the logarithm
    cost without its ½, in SE(2) twice as much. Both definitions are those of SE-Sync.

    Source: Rosen et al. 2019, the appendix on the measurements' concentration parameters.
    """
    d = graph.group.DIMENSION
    tau = d / _inverse_traces(graph.information[:, :d, :d])
    rotation = graph.information[:, d:, d:]
    kappa = rotation[:, 0, 0].copy() if d == 2 else 3.0 / (2.0 * _inverse_traces(rotation))
    return kappa, tau


def _inverse_traces(blocks: Array) -> Array:
    """Return tr(B⁻¹) ``(m,)``: the sum of principal minors of order d − 1 over det B."""
    minors = np.trace(blocks, axis1=1, axis2=2)
    if blocks.shape[-1] == 3:
        # ½ (tr(B)² − tr(B²)), written without cancellation of large terms.
        pairs = [blocks[:, [i, i, j, j], [i, j, i, j]] for i, j in ((0, 1), (0, 2), (1, 2))]
        minors = sum(p[:, 0] * p[:, 3] - p[:, 1] * p[:, 2] for p in pairs)
    return np.asarray(minors / np.linalg.det(blocks))
