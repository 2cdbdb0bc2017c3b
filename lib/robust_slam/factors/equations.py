"""The sparse normal equations of a factor graph, and the descent by them.

Poses and landmarks are blocks of one size, so that the pattern and the factorisation are those of
pose graphs. A coordinate that no factor acts on, such as the rotation of a landmark, or all of a
landmark whose factors have weight 0, has an empty row; a 1 on its diagonal keeps it where it is.

Source: Grisetti et al. 2010, the sparse blocks; Marquardt 1963 and Nielsen 1999, the damping.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import islice

import numpy as np

from robust_slam._arrays import Array, times
from robust_slam.descent.minimise import damped, last
from robust_slam.descent.sparse.pattern import find_pattern, sum_by_pose
from robust_slam.descent.step import Descent, is_small
from robust_slam.factors.factor_graph import FRAME, FactorGraph
from robust_slam.graphs.pose_graph import check_joined, connected_parts

_SLOW = 1e-4
"""This share of its diagonal keeps pose 0 where nothing else does; it hardly slows what does."""
_TRIALS = 40
"""So many dampings are tried for a step, in the mean over all steps."""


class FactorEquations:
    """The linear step of a factor graph; its sparsity pattern is found at construction.

    The block that is held is the frame of the map where something is measured in it, else pose 0.
    """

    def __init__(self, graph: FactorGraph) -> None:
        self.graph = graph
        self._absolute = graph.ends[:, 0] == FRAME
        self.held = int(np.any(self._absolute))
        self._ends = graph.ends + self.held
        self.pattern = find_pattern(graph.nodes + self.held, self._ends, graph.group.DOF)

    def norms(self, x: Array) -> Array:
        """Return the whitened residual norm of each factor, ``(m,)``, at a map ``(n + l, …)``."""
        group, nodes = self.graph.group, self._with_frame(x)
        norms = np.empty(len(self._ends))
        for block, at in zip(self.graph.blocks, self.graph.slices.values(), strict=True):
            a, b = nodes[block.ends.T]
            residual = block.model.residual(group, a, b, block.measurement)
            norms[at] = np.linalg.norm(times(block.root, residual), axis=1)
        return norms

    def system(self, x: Array, weights: Array) -> tuple[Array, Array]:
        """Return Σ w Jᵀ Ω J as the blocks of the pattern, and Σ w Jᵀ Ω r ``(N, D)``.

        ``weights`` are ``(m,)``. N is the number of nodes, and of the frame where it is held.
        """
        group, nodes = self.graph.group, self._with_frame(x)
        pieces = np.empty((3, weights.size, group.DOF, group.DOF))
        pulls = np.empty((2, weights.size, group.DOF))
        for block, at in zip(self.graph.blocks, self.graph.slices.values(), strict=True):
            a, b = nodes[block.ends.T]
            root = np.sqrt(weights[at, None, None]) * block.root
            residual = times(root, block.model.residual(group, a, b, block.measurement))
            by_a, by_b = (root @ j for j in block.model.jacobians(group, a, b, block.measurement))
            to_a, to_b = np.swapaxes(by_a, 1, 2), np.swapaxes(by_b, 1, 2)
            pieces[:, at] = to_a @ by_a, to_b @ by_b, to_a @ by_b
            pulls[:, at] = times(to_a, residual), times(to_b, residual)
        return self.pattern.sum(pieces), sum_by_pose(self.pattern.n, self._ends, pulls)

    def shift(self, hessian: Array, weights: Array) -> Array:
        """Return what is added to the diagonal ``(N, D)`` so that nothing is undetermined.

        Where too few factors of positive weight fix the map in its frame, pose 0 keeps its place.
        """
        diagonal = self.pattern.diagonal(hessian)
        shift = np.where(diagonal == 0.0, 1.0, 0.0)
        if self.held and not self._fixed(weights):
            shift[self.held] += _SLOW * diagonal[self.held]
        return shift

    def _fixed(self, weights: Array) -> bool:
        """Tell whether a prior or positions of enough nodes of positive weight fix the frame."""
        used = self._absolute & (weights > 0.0)
        priors = used[self.graph.slices.get("priors", slice(0))]
        nodes = np.unique(self.graph.ends[used, 1])
        return bool(np.any(priors) or nodes.size >= self.graph.group.DIMENSION)

    def check_joined(self, weights: Array) -> None:
        """Refuse weights ``(m,)`` of factors that do not connect all poses: Underdetermined."""
        ends = self.graph.ends[weights > 0.0] + 1
        parts = connected_parts(self.graph.nodes + 1, ends)[1 : self.graph.n + 1]
        check_joined(parts, "factor")

    def _with_frame(self, x: Array) -> Array:
        # The frame is the last entry, so that FRAME, which is −1, finds it.
        return np.concatenate([x, self.graph.group.identity()[None]])


@dataclass(frozen=True, eq=False)
class _Place:
    """Weighted least squares at a map ``poses`` ``(n + l, …)``, with ``weights`` ``(m,)``."""

    equations: FactorEquations
    poses: Array
    weights: Array

    @cached_property
    def cost(self) -> float:
        return 0.5 * float(self.weights @ self.equations.norms(self.poses) ** 2)

    @cached_property
    def _system(self) -> tuple[Array, Array, Array]:
        hessian, gradient = self.equations.system(self.poses, self.weights)
        return hessian, gradient, self.equations.shift(hessian, self.weights)

    def step(self, damping: float) -> tuple[Array, float] | None:
        hessian, gradient, shift = self._system
        pattern, own = self.equations.pattern, slice(self.equations.held, None)
        shift = shift + damping * pattern.diagonal(hessian)
        step = pattern.solve(hessian, -gradient, shift)
        if step is None:
            return None
        return step[own], 0.5 * float(np.sum((step * (shift * step - gradient))[own]))

    def moved(self, step: Array) -> _Place:
        group = self.equations.graph.group
        return _Place(self.equations, group.compose(self.poses, group.exp(step)), self.weights)

    def is_small(self, step: Array, tol: float) -> bool:
        return is_small(step, self.poses, tol)


def descend(
    equations: FactorEquations, x: Array, weights: Array, tol: float, steps: int
) -> Descent[_Place]:
    """Descend from the map x ``(n + l, …)`` by at most so many ``steps``.

    They are those of Gauss–Newton, damped where one would increase the cost, and end as in
    ``gauss_newton`` with ``tol``; ``weights`` are ``(m,)``. Its error is theirs: Underdetermined.

    Source: Marquardt 1963, damping by the diagonal; Nielsen 1999, its growth.
    """
    equations.check_joined(weights)
    start = _Place(equations, x, weights)
    taken = damped(start, tol, _TRIALS * steps, damping=0.0, ends_undamped=True)
    return last(islice(taken, 1 + steps))
