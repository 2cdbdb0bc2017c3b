"""The sparse normal equations of a factor graph, and the descent by them.

Poses and landmarks are blocks of one size, so that the pattern and the factorisation are those of
pose graphs. A coordinate that no factor acts on, such as the rotation of a landmark, or all of a
landmark whose factors have weight 0, has an empty row; a 1 on its diagonal keeps it where it is.

Source: Grisetti et al. 2010, the sparse blocks; Marquardt 1963 and Nielsen 1999, the damping.
"""

import numpy as np

from robust_slam._arrays import Array, times
from robust_slam.descent.sparse.pattern import find_pattern, sum_by_pose
from robust_slam.descent.step import Descent, damping_factor, increases, is_small
from robust_slam.factors.factor_graph import FRAME, FactorGraph
from robust_slam.graphs.pose_graph import check_joined, connected_parts

_DAMPING = 1e-4
_SLOW = 1e-4
"""This share of its diagonal keeps pose 0 where nothing else does; it hardly slows what does."""
_TRIALS = 40
"""So many dampings are tried before a step is given up."""


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

    def step(self, hessian: Array, gradient: Array, shift: Array) -> Array | None:
        """Return the δ ``(n + l, D)`` with (H + diag(shift)) δ = −g, or None if H is singular."""
        step = self.pattern.solve(hessian, -gradient, shift)
        return None if step is None else np.asarray(step[self.held :])

    def cost(self, x: Array, weights: Array) -> float:
        """Return ½ Σ w u² of a map ``(n + l, …)`` with ``weights`` ``(m,)``."""
        return 0.5 * float(weights @ self.norms(x) ** 2)

    def moved(self, x: Array, step: Array) -> Array:
        """Return each node of x ``(n + l, …)`` moved by its row of ``step`` ``(n + l, D)``."""
        return self.graph.group.compose(x, self.graph.group.exp(step))

    def check_joined(self, weights: Array) -> None:
        """Refuse weights ``(m,)`` of factors that do not connect all poses: Underdetermined."""
        ends = self.graph.ends[weights > 0.0] + 1
        parts = connected_parts(self.graph.nodes + 1, ends)[1 : self.graph.n + 1]
        check_joined(parts, "factor")

    def _with_frame(self, x: Array) -> Array:
        # The frame is the last entry, so that FRAME, which is −1, finds it.
        return np.concatenate([x, self.graph.group.identity()[None]])


def descend(
    equations: FactorEquations, x: Array, weights: Array, tol: float, steps: int
) -> Descent:
    """Descend from the map x ``(n + l, …)`` by at most so many ``steps``.

    They are those of Gauss–Newton, damped where one would increase the cost, and end as in
    ``gauss_newton`` with ``tol``; ``weights`` are ``(m,)``. Its error is theirs: Underdetermined.

    Source: Marquardt 1963, damping by the diagonal; Nielsen 1999, its growth.
    """
    equations.check_joined(weights)
    cost, damping, size = equations.cost(x, weights), 0.0, np.inf
    for _ in range(steps):
        tried = _tried(equations, x, weights, damping, cost)
        if tried is None:
            break
        step, moved, after, damping, predicted = tried
        small, size = is_small(step, x, tol), float(np.abs(step).max())
        gain = (cost - after) / max(predicted, np.finfo(float).tiny)
        x, cost = moved, after
        # A damped step can be small anywhere, an undamped one only near a minimum.
        if small and damping == 0.0:
            return Descent(x, cost, size, converged=True)
        damping = 0.0 if small else damping * damping_factor(gain)
    return Descent(x, cost, size, converged=False)


def _tried(
    equations: FactorEquations, x: Array, weights: Array, damping: float, cost: float
) -> tuple[Array, Array, float, float, float] | None:
    """Return the step with the first damping that does not increase the cost, or None.

    Behind it come the map there, its cost, this damping, and the decrease that was expected.
    """
    hessian, gradient = equations.system(x, weights)
    shift, growth = equations.shift(hessian, weights), 2.0
    for _ in range(_TRIALS):
        added = shift + damping * equations.pattern.diagonal(hessian)
        step = equations.step(hessian, gradient, added)
        if step is not None:
            moved = equations.moved(x, step)
            after = equations.cost(moved, weights)
            if not increases(after, cost):
                own = slice(equations.held, None)
                predicted = 0.5 * float(np.sum(step * (added[own] * step - gradient[own])))
                return step, moved, after, damping, predicted
        damping, growth = max(_DAMPING, growth * damping), 2.0 * growth
    return None
