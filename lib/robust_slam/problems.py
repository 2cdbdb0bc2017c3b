"""Four problems for the loop: a location, a linear problem, a rotation and a pose graph.

Each computes whitened residual norms at an x and solves for x with given weights.

Source: Gauss 1809, weighted least squares.
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask, deviations, finite, mask
from robust_slam._words import counted
from robust_slam.descent.minimise import damped, last, undamped
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.step import ELSEWHERE, STEP_LIMIT, check_limits
from robust_slam.errors import Underdetermined
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, check_weights
from robust_slam.groups.rotations import nearest_rotations


class LocationProblem:
    """Measurements z ``(m,)`` of one number x, with standard deviations sigma.

    ``sigma`` is a scalar or ``(m,)``, in the unit of z; ``trusted`` is a mask ``(m,)``,
    none by default. The whitened residual is u = |z − x|/sigma.

    Raises:
        ValueError: ``z`` is empty or not finite, or the shapes do not agree.
    """

    def __init__(
        self, z: ArrayLike, sigma: ArrayLike = 1.0, trusted: ArrayLike | None = None
    ) -> None:
        self.z = finite("z", z, (-1,))
        if self.z.size == 0:
            raise ValueError("z is empty; give at least one measurement")
        self.sigma = deviations(sigma, self.z.size)
        self.trusted = mask("trusted", trusted, self.z.size)

    def __repr__(self) -> str:
        return f"<LocationProblem: {_measured(self.trusted)}>"

    def initial(self) -> float:
        """Return the mean of z, each weighted by 1/sigma²."""
        return self.solve(np.ones_like(self.z), 0.0)

    def residual_norms(self, x: float) -> Array:
        """Return |z − x|/sigma, ``(m,)``."""
        return np.abs(self.z - x) / self.sigma

    def solve(self, weights: Array, x: float) -> float:
        """Return the weighted mean Σ w z/sigma² / Σ w/sigma²; ``x`` is not needed.

        Raises:
            Underdetermined: every weight is 0.
        """
        information = weights / self.sigma**2
        total = float(np.sum(information))
        if total == 0.0:
            raise Underdetermined("weights: all are 0, so x is not determined; keep at least one")
        return float(information @ self.z / total)


class LinearProblem:
    """Measurements z = J x + noise with standard deviations sigma.

    ``jacobian`` is J ``(m, n)``, ``measurement`` z ``(m,)``, ``sigma`` a scalar or
    ``(m,)`` in the unit of z, ``trusted`` a mask ``(m,)`` (none by default), and
    ``fixed`` a mask ``(n,)`` of unknowns held at 0 (none by default).

    Raises:
        ValueError: the shapes do not agree, or an entry is not finite.
    """

    def __init__(
        self,
        jacobian: ArrayLike,
        measurement: ArrayLike,
        sigma: ArrayLike = 1.0,
        trusted: ArrayLike | None = None,
        fixed: ArrayLike | None = None,
    ) -> None:
        self.jacobian = finite("jacobian", jacobian, (-1, -1))
        m, n = self.jacobian.shape
        self.measurement = finite("measurement", measurement, (m,))
        self.sigma = deviations(sigma, m)
        self.trusted = mask("trusted", trusted, m)
        self.fixed = mask("fixed", fixed, n)

    def __repr__(self) -> str:
        unknowns = counted(self.fixed.size, "unknown")
        return f"<LinearProblem: {unknowns}, {_measured(self.trusted)}>"

    def initial(self) -> Array:
        """Return the least-squares solution x ``(n,)``."""
        m, n = self.jacobian.shape
        return self.solve(np.ones(m), np.zeros(n))

    def residuals(self, x: Array) -> Array:
        """Return the whitened residuals (J x − z)/sigma with their sign, ``(m,)``."""
        return np.asarray((self.jacobian @ x - self.measurement) / self.sigma)

    def residual_norms(self, x: Array) -> Array:
        """Return |J x − z|/sigma, ``(m,)``."""
        return np.abs(self.residuals(x))

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the x ``(n,)`` that minimises Σ w u²; the start ``x`` is not needed.

        Raises:
            Underdetermined: the rows with positive weight do not determine x.
        """
        # Scaling rows by √w avoids JᵀJ, which would square the condition number of J.
        scale = np.sqrt(weights) / self.sigma
        rows = self.jacobian[:, ~self.fixed] * scale[:, None]
        free, _, rank, _ = np.linalg.lstsq(rows, self.measurement * scale, rcond=None)
        if rank < rows.shape[1]:
            raise Underdetermined(
                f"the measurements with positive weight determine {rank} of {rows.shape[1]} "
                "unknowns; fix an unknown, trust a measurement or add one"
            )
        solution = np.zeros(self.fixed.size)
        solution[~self.fixed] = free
        return solution


def _measured(trusted: Mask, noun: str = "measurement") -> str:
    return f"{counted(trusted.size, noun)}, {int(trusted.sum()):,} of them trusted"


def chain(
    n: int,
    i: ArrayLike,
    j: ArrayLike,
    z: ArrayLike,
    sigma: ArrayLike = 1.0,
    anchor: int = 0,
    trusted: ArrayLike | None = None,
) -> LinearProblem:
    """Return the 1-D pose graph of ``n`` poses with z = x[j] − x[i] and x[anchor] = 0.

    ``i``, ``j``, ``z`` are ``(m,)``, poses are numbered from 0, ``sigma`` is a scalar or
    ``(m,)``. Only differences are measured, so one pose, the anchor, is held fixed.

    Raises:
        ValueError: an index is out of range, an edge joins a pose to itself, or the
            shapes do not agree.
    """
    measurement = finite("z", z, (-1,))
    tail, head = (_ends(name, value, measurement.size, n) for name, value in (("i", i), ("j", j)))
    if np.any(tail == head):
        raise ValueError(f"edge {int(np.argmax(tail == head))} joins a pose to itself")
    if not 0 <= anchor < n:
        raise ValueError(f"anchor is {anchor}; give a pose from 0 to {n - 1}")
    rows = np.arange(measurement.size)
    jacobian = np.zeros((measurement.size, n))
    jacobian[rows, head] = 1.0
    jacobian[rows, tail] = -1.0
    return LinearProblem(jacobian, measurement, sigma, trusted, fixed=np.arange(n) == anchor)


def _ends(name: str, value: ArrayLike, m: int, n: int) -> Indices:
    ends = np.asarray(value)
    if ends.shape != (m,) or (m and not np.issubdtype(ends.dtype, np.integer)):
        raise ValueError(f"{name}: give {m} whole numbers, one for each entry of z")
    outside = (ends < 0) | (ends >= n)
    if np.any(outside):
        edge = int(np.argmax(outside))
        raise ValueError(f"{name}: edge {edge} names pose {ends[edge]}; poses are 0 to {n - 1}")
    return ends.astype(np.intp)


class RotationProblem:
    """Vectors b = R a + noise, measured in two frames, and the rotation x = R ``(3, 3)``.

    ``a`` and ``b`` are ``(m, 3)`` in one unit, ``sigma`` is a scalar or ``(m,)`` in that unit,
    ``trusted`` a mask ``(m,)``, none by default. The whitened residual is u = ‖b − R a‖/sigma.

    Raises:
        ValueError: the shapes do not agree, or an entry is not finite.

    Source: Wahba 1965, the problem; Umeyama 1991, the lemma that solves it.
    """

    dimension = 3
    """The dimension of a residual, for the default threshold."""

    def __init__(
        self, a: ArrayLike, b: ArrayLike, sigma: ArrayLike = 1.0, trusted: ArrayLike | None = None
    ) -> None:
        self.a = finite("a", a, (-1, 3))
        self.b = finite("b", b, self.a.shape)
        self.sigma = deviations(sigma, len(self.a))
        self.trusted = mask("trusted", trusted, len(self.a))

    def __repr__(self) -> str:
        return f"<RotationProblem: {_measured(self.trusted)}>"

    def initial(self) -> Array:
        """Return the least-squares rotation ``(3, 3)``."""
        return self.solve(np.ones(len(self.a)), np.eye(3))

    def residual_norms(self, x: Array) -> Array:
        """Return ‖b − x a‖/sigma, ``(m,)``."""
        return np.asarray(np.linalg.norm(self.b - self.a @ x.T, axis=1) / self.sigma)

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the rotation that minimises Σ w u²; the start ``x`` is not needed.

        Raises:
            Underdetermined: the vectors with positive weight all have one direction.
        """
        moment = (self.b * (weights / self.sigma**2)[:, None]).T @ self.a
        if np.linalg.matrix_rank(moment) < 2:
            raise Underdetermined(
                "the vectors with positive weight have one direction, so the turn around it is "
                "not determined; add a vector in another direction"
            )
        return nearest_rotations(moment)


class PoseGraphProblem:
    """A pose graph for the loop; x are poses, ``(n, 3)`` or ``(n, 3, 4)``.

    The unweighted solve starts at the poses ``guess``, by default those of
    ``spanning_tree``, which are dead reckoning where the odometry is complete. ``trusted``
    ``(m,)`` is the mask of edges whose weight stays 1, by default the odometry. Each solve
    takes at most ``steps`` Gauss–Newton steps from the poses of the previous solve and
    stops earlier as ``gauss_newton`` does with ``tol``. The loop repeats the solve, so a
    few steps are enough.

    Raises:
        ValueError: ``guess`` or ``trusted`` does not fit the graph, or a limit is out of
            range.
    """

    def __init__(
        self,
        graph: PoseGraph,
        guess: ArrayLike | None = None,
        trusted: ArrayLike | None = None,
        *,
        tol: float = 1e-9,
        steps: int = 100,
    ) -> None:
        self.graph = graph
        self.guess = spanning_tree(graph) if guess is None else check_poses("guess", guess, graph)
        self.trusted = mask(
            "trusted", graph.is_odometry if trusted is None else trusted, len(graph.edges)
        )
        check_limits(tol, steps)
        self.tol = tol
        self.steps = steps
        self._equations = NormalEquations(graph)

    def __repr__(self) -> str:
        poses = f"{self.graph.n:,} poses in SE({self.graph.group.DIMENSION})"
        return f"<PoseGraphProblem: {poses}, {_measured(self.trusted, 'edge')}>"

    def initial(self) -> Array:
        """Return the least-squares poses, found from the guess with all weights 1.

        Gross errors can make Gauss–Newton very slow, so this is Levenberg–Marquardt.

        Raises:
            NotConverged: as many steps as ``gauss_newton`` takes were not enough.
        """
        ones = np.ones(len(self.graph.edges))
        start = self._equations.start(self.guess, ones)
        return last(damped(start, self.tol, STEP_LIMIT)).converged_poses(STEP_LIMIT, ELSEWHERE)

    def residual_norms(self, x: Array) -> Array:
        """Return the whitened residual norm of every edge, ``(m,)``."""
        return self._equations.residual_norms(np.asarray(x))

    def solve(self, weights: Array, x: Array) -> Array:
        """Return the poses that Gauss–Newton reaches from ``x``.

        Raises:
            Underdetermined: the edges with positive weight do not connect all poses.
        """
        full = check_weights(weights, self.graph)
        start = self._equations.start(check_poses("x", x, self.graph), full)
        return undamped(start, self.tol, self.steps).here.poses
