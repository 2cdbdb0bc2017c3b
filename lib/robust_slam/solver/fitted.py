"""What the poses of a minimum take up of the noise of the edges, to first order.

With the whitened Jacobian J of all edges, the poses take up J (JᵀJ)⁻¹ Jᵀ w of whitened noise w.
What is left are the residuals. So the residuals that a model of the noise would leave can be
drawn, without the matrix of any of it, for the price of a solve each.

Source: Förstner 1979 and Baarda 1968 for the matrix; Hutchinson 1990 for drawing in its place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.descent.normal_equations import NormalEquations, linear_change
from robust_slam.descent.sparse.pattern import PoseFactors, sum_by_pose
from robust_slam.graphs.pose_graph import PoseGraph, linearise, select


@dataclass(frozen=True, eq=False)
class Fitted:
    """The linearised fit of the edges of ``graph``, all of which count.

    ``residuals`` ``(m, D)`` are whitened, with ``root`` ``(m, D, D)``, which is Lᵀ where Ω = L Lᵀ.
    """

    graph: PoseGraph
    residuals: Array
    jacobian: Array
    root: Array
    factors: PoseFactors

    @classmethod
    def of(cls, graph: PoseGraph, poses: Array, kept: Mask) -> Fitted | None:
        """Return the fit of the ``kept`` edges ``(m,)`` at ``poses``, None if not determined."""
        part = select(graph, kept)
        equations = NormalEquations(part)
        here = equations.at(poses, np.ones(len(part.edges)))
        factors = equations.pattern.factorise(equations.system(here)[0])
        if factors is None:
            return None
        root = np.swapaxes(np.linalg.cholesky(part.information), 1, 2)
        jacobian = linearise(part, here.residuals.relative, here.residuals.r)
        whitened = (root @ here.residuals.r[..., None])[..., 0]
        return cls(part, whitened, jacobian, root, factors)

    def taken_up(self, whitened: Array) -> Array:
        """Return what the poses take up of ``whitened`` noise ``(p, m, D)``, of that shape."""
        steps = self.factors.solve(self._pulled(whitened))
        changes = [
            self.root @ linear_change(self.jacobian, self.graph, step)[..., None]
            for step in np.moveaxis(steps, -1, 0)
        ]
        return np.stack(changes)[..., 0]

    def _pulled(self, whitened: Array) -> Array:
        """Return Jᵀ Lᵀ w ``(n, D, p)`` for w ``(p, m, D)``."""
        graph = self.graph
        by_j, transfer = (np.swapaxes(each, 1, 2) for each in self.jacobian)
        at_j = by_j @ (np.swapaxes(self.root, 1, 2) @ np.moveaxis(whitened, 0, -1))
        return sum_by_pose(graph.n, graph.edges, np.stack([transfer @ at_j, at_j]))
