"""What the poses of a minimum take up of the noise of the edges, to first order.

With the whitened Jacobian J of all edges, the poses take up J (JᵀJ)⁻¹ Jᵀ w of whitened noise w.
What is left are the residuals. So the residuals that a model of the noise would leave can be
drawn, without the matrix of any of it, for the price of a solve each.

Source: Förstner 1979 and Baarda 1968 for the matrix; Hutchinson 1990 for drawing in its place.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robust_slam._arrays import Array, Indices, Mask, times
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.sparse.pattern import PoseFactors, sum_by_pose
from robust_slam.graphs.pose_graph import PoseGraph, linearise, select

_DRAWS = 24
_NOTHING = 1e-4
"""The variance, of noise of variance 1, below which nothing is left of an edge."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """The linearised fit of all edges of ``equations``, with the two factors of J, ``jacobian``.

    ``residuals`` ``(m, D)`` are whitened, with ``root`` ``(m, D, D)``, which is Lᵀ where Ω = L Lᵀ.
    """

    equations: NormalEquations
    residuals: Array
    jacobian: Array
    root: Array

    @classmethod
    def of(cls, graph: PoseGraph, poses: Array, kept: Mask) -> Fitted:
        """Return the fit of the ``kept`` edges ``(m,)`` at ``poses``."""
        part = select(graph, kept)
        equations = NormalEquations(part)
        here = equations.residuals(poses)
        root = np.swapaxes(np.linalg.cholesky(part.information), 1, 2)
        whitened = times(root, here.r)
        return cls(equations, whitened, linearise(part, here.relative, here.r), root)

    @property
    def graph(self) -> PoseGraph:
        """The graph of these edges alone."""
        return self.equations.graph

    def taken_up(self, whitened: Array) -> Array | None:
        """Return what the poses take up of ``whitened`` noise ``(p, m, D)``, of that shape.

        It is None where the edges do not determine the poses to working precision.
        """
        if self._own is None:
            return None
        at_i, at_j = self._own.solve(self._pulled(whitened))[self.graph.edges.T]
        by_j, transfer = self.jacobian
        return np.asarray(np.moveaxis(self.root @ (by_j @ (transfer @ at_i + at_j)), -1, 0))

    def left(self, edges: Indices) -> Array:
        """Return the covariances ``(k, D, D)`` of what white noise leaves of ``edges`` ``(k,)``.

        The edges of the fit determine its poses.
        """
        d = self.graph.group.DOF
        units = np.zeros((edges.size, d, *self.residuals.shape))
        units[np.arange(edges.size)[:, None], np.arange(d), edges[:, None], np.arange(d)] = 1.0
        taken = self.taken_up(units.reshape(-1, *self.residuals.shape))
        assert taken is not None
        return np.eye(d) - taken.reshape(units.shape)[np.arange(edges.size), :, edges]

    def roughly_left(self, edges: Indices) -> Array:
        """Return ``left`` from a few draws of the noise, for many ``edges`` ``(k,)``."""
        noise = np.random.default_rng(0).normal(size=(_DRAWS, *self.residuals.shape))
        taken = self.taken_up(noise)
        assert taken is not None
        drawn = (noise - taken)[:, edges]
        return np.asarray(np.einsum("pka,pkb->kab", drawn, drawn) / _DRAWS)

    def following(self, edges: Indices) -> Array:
        """Return how far each pose moves with a displacement of ``edges`` ``(k,)``, ``(k, n)``.

        It is the longest move, relative to that of the measurement.
        """
        d = self.graph.group.DIMENSION
        moves = (self.moved(edges, self.root[edges, :, axis])[..., :d] for axis in range(d))
        return np.asarray(np.max([np.linalg.norm(each, axis=2) for each in moves], axis=0))

    def moved(self, edges: Indices, whitened: Array) -> Array:
        """Return how the poses move with ``whitened`` noise ``(k, D)`` of one edge, ``(k, n, D)``.

        It is a perturbation on the right for each of the ``edges`` ``(k,)``.
        """
        noise = np.zeros((edges.size, *self.residuals.shape))
        noise[np.arange(edges.size), edges] = whitened
        assert self._own is not None
        return np.asarray(np.moveaxis(self._own.solve(self._pulled(noise)), -1, 0))

    def log_determinant(self, information: Array) -> float:
        """Return log det JᵀJ with another ``information`` ``(m, D, D)``, or infinity."""
        factors = self._factors(information)
        return np.inf if factors is None else float(np.sum(np.log(factors.pivots[1:])))

    @cached_property
    def _own(self) -> PoseFactors | None:
        return self._factors(self.graph.information)

    def _factors(self, information: Array) -> PoseFactors | None:
        nothing = np.zeros_like(self.residuals)
        hessian, _ = self.equations.assemble(self.jacobian, information, nothing)
        return self.equations.pattern.factorise(hessian)

    def _pulled(self, whitened: Array) -> Array:
        """Return Jᵀ Lᵀ w ``(n, D, p)`` for w ``(p, m, D)``."""
        graph = self.graph
        by_j, transfer = (np.swapaxes(each, 1, 2) for each in self.jacobian)
        at_j = by_j @ (np.swapaxes(self.root, 1, 2) @ np.moveaxis(whitened, 0, -1))
        return sum_by_pose(graph.n, graph.edges, np.stack([transfer @ at_j, at_j]))


def relative_squares(left: Array, covariance: Array) -> Array:
    """Return the squares ``(k,)`` of ``left`` ``(k, D)`` in units of its ``covariance``."""
    spread = covariance + _NOTHING * np.eye(left.shape[1])
    return np.asarray(np.sum(left * np.linalg.solve(spread, left[..., None])[..., 0], axis=1))
