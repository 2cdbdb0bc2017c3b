"""Graduated non-convexity: the loop with a surrogate kernel that becomes less convex.

The surrogate of the kernel is nearly convex at first and equals the kernel in the end. The
parameter μ controls it: it grows from near 0 for TLS and decreases to 1 for Geman–McClure.
Each step computes the weights of the surrogate at the last residuals, solves once from the
current x, and updates μ. It works well in practice but has no guarantee of convergence to
the global minimum.

All formulas have the ½ of this library, ρ ≈ u²/2 near 0. The papers leave it out; weights
and μ are the same numbers.

GTSAM takes the first μ from the residuals at the initial values of the user, includes known
inliers in it, and starts every inner solve from those values again. Here μ comes from the
untrusted measurements alone, and each solve starts from the last.

The papers update μ by one constant factor. Where steps hardly change any residual, an
*adaptive* rule takes two or three at once (``strides``), which can end in a slightly worse
local minimum.

Source: Yang et al. 2020, "Graduated Non-Convexity for Robust Spatial Perception", (12),
(14) and Remark 5; Black and Rangarajan 1996 for the outlier processes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt
from typing import Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, positive
from robust_slam._deadline import Deadline
from robust_slam.estimators.kernels import geman_mcclure, tls
from robust_slam.estimators.loop import Problem, prepare, reweight, settle
from robust_slam.estimators.result import Result, Step, StopReason
from robust_slam.estimators.thresholds import threshold_of
from robust_slam.graphs.pose_graph import PoseGraph

X = TypeVar("X")
Kind: TypeAlias = Literal["tls", "gm"]

_SMALLEST = float(np.finfo(np.float64).tiny)
_LARGEST = float(np.finfo(np.float64).max)
_SMOOTH = (0.1, 0.05)
"""Relative changes of 99 % of the norms below which an adaptive μ takes 2 and 3 factors."""


def tls_weight(u: ArrayLike, c: float, mu: float) -> Array:
    """Return the weight of the TLS surrogate, of any shape, as u.

    It is 1 up to the lower bound u² = c²μ/(μ+1), 0 from the upper bound u² = c²(μ+1)/μ, and
    (c/|u|)√(μ(μ+1)) − μ between them.

    Raises:
        ValueError: ``c`` or ``mu`` is not a finite number above zero.

    Source: Yang et al. 2020, equation (14).
    """
    c, mu = positive("c", c), positive("mu", mu)
    size = np.abs(np.asarray(u, dtype=np.float64))
    with np.errstate(over="ignore"):
        between = c / np.maximum(size, _SMALLEST) * _middle(mu) - mu
    return np.asarray(np.clip(between, 0.0, 1.0))


def tls_surrogate(u: ArrayLike, c: float, mu: float) -> Array:
    """Return the TLS surrogate ρ_μ(u), of any shape, as u.

    It is u²/2 below the lower bound of ``tls_weight``, c²/2 above the upper one, and
    c|u|√(μ(μ+1)) − μ(c² + u²)/2 between them, where its curvature is −μ. As μ → ∞ it
    becomes ``kernels.tls``; it is convex only in the limit μ → 0. Errors are as of ``tls_weight``.

    Source: SLAM Handbook 2026, (3.24), and Yang et al. 2020, both without the ½.
    """
    c, mu = positive("c", c), positive("mu", mu)
    size = np.abs(np.asarray(u, dtype=np.float64))
    low, high = c * sqrt(mu / (mu + 1.0)), c * sqrt((mu + 1.0) / mu)
    inside = np.clip(size, low, high)
    between = c * inside * _middle(mu) - 0.5 * mu * (c**2 + inside**2)
    return np.where(size <= low, 0.5 * size**2, np.where(size >= high, 0.5 * c**2, between))


def tls_process(w: ArrayLike, c: float, mu: float) -> Array:
    """Return the outlier process Φ of weights w in [0, 1], of any shape: ½ c² μ(1 − w)/(μ + w).

    The minimum of w u²/2 + Φ(w) over w is the surrogate, attained at ``tls_weight``, whose errors
    it has.

    Source: Black and Rangarajan 1996; SLAM Handbook 2026, Theorem 3.4, without the ½ there.
    """
    c, mu = positive("c", c), positive("mu", mu)
    w = np.asarray(w, dtype=np.float64)
    return np.asarray(0.5 * c**2 * mu * (1.0 - w) / (mu + w))


def _middle(mu: float) -> float:
    """Return √(μ(μ+1)) as √μ √(μ+1), which does not overflow."""
    return sqrt(mu) * sqrt(mu + 1.0)


def gm_weight(u: ArrayLike, c: float, mu: float) -> Array:
    """Return the weight of the Geman–McClure surrogate, (μc²/(u² + μc²))², of any shape.

    Errors are as of ``tls_weight``.

    Source: Yang et al. 2020, equation (12).
    """
    return geman_mcclure(_widened(c, mu)).weight(u)


def gm_surrogate(u: ArrayLike, c: float, mu: float) -> Array:
    """Return the Geman–McClure surrogate ½ μc²u²/(μc² + u²), of any shape.

    It is the kernel with scale c√μ: convex for u² ≤ μc²/3, and the kernel itself at μ = 1.
    Errors are as of ``tls_weight``.

    Source: SLAM Handbook 2026, (3.25), and Yang et al. 2020, both without the ½.
    """
    return geman_mcclure(_widened(c, mu)).rho(u)


def gm_process(w: ArrayLike, c: float, mu: float) -> Array:
    """Return the outlier process Φ of weights w in [0, 1], of any shape: ½ μc² (√w − 1)².

    The minimum of w u²/2 + Φ(w) over w is the surrogate, attained at ``gm_weight``. Errors are as
    of ``tls_weight``.

    Source: Black and Rangarajan 1996; SLAM Handbook 2026, Theorem 3.4, without the ½ there.
    """
    return np.asarray(0.5 * _widened(c, mu) ** 2 * (np.sqrt(np.asarray(w, float)) - 1.0) ** 2)


def _widened(c: float, mu: float) -> float:
    return positive("c", c) * sqrt(positive("mu", mu))


def start_mu(u_max: float, c: float, kind: Kind = "tls") -> float:
    """Return the first μ for the largest norm ``u_max``.

    For TLS it is c²/(2u² − c²), and inf when 2u² ≤ c²: there is nothing to reject. For
    Geman–McClure it is 2u²/c²; a value below 1 means that the kernel itself is convex enough.
    Values outside the range of floats are clipped.

    Raises:
        ValueError: ``u_max`` is negative or NaN, ``c`` is not a finite number above zero,
            or ``kind`` is unknown.

    Source: Yang et al. 2020, Remark 5.
    """
    check_kind(kind)
    if not u_max >= 0.0:
        raise ValueError(f"u_max is {u_max}; give a residual norm, a number of at least 0")
    with np.errstate(over="ignore"):
        ratio = float(2.0 * np.square(np.float64(u_max) / positive("c", c)))
    if kind == "gm":
        return min(ratio, _LARGEST)
    return inf if ratio <= 1.0 else max(1.0 / (ratio - 1.0), _SMALLEST)


def strides(moved: Array) -> int:
    """Return the number of factors by which an adaptive rule updates μ: 1, 2 or 3.

    ``moved`` ``(k,)`` is the change of each norm u in a step, relative to 1 + u. If 99 % of
    the norms change by at most 0.1 it is 2, by at most 0.05 it is 3: the path of the
    solution is nearly straight there, so a longer step seldom loses it.

    Source: derived here; step-length control for homotopy paths in Allgower and Georg 1990,
    chapter 6.
    """
    most = float(np.quantile(moved, 0.99)) if moved.size else 0.0
    return 1 + sum(most <= change for change in _SMOOTH)


@dataclass(frozen=True)
class _Schedule:
    """How μ moves: from ``mu0``, by default ``start_mu`` of the largest norm, by ``factor``.

    ``c`` is the scale of the kernel, the largest norm of an inlier. An ``adaptive`` rule takes
    as many factors at once as ``strides`` returns.

    Raises:
        ValueError: ``c`` or ``mu0`` is not above 0, or ``factor`` is not above 1.
    """

    c: float
    factor: float = 1.4
    mu0: float | None = None
    adaptive: bool = False

    def __post_init__(self) -> None:
        positive("c", self.c)
        if not positive("factor", self.factor) > 1.0:
            raise ValueError(f"factor is {self.factor}; μ has to move on, so give more than 1")
        if self.mu0 is not None:
            positive("mu0", self.mu0)


class GncTls(_Schedule):
    """The rule of GNC-TLS for norms ``(k,)``: μ grows until every weight is 0 or 1.

    At the default start the weight is 0 only beyond √2 u for the largest norm u, so that
    nothing is rejected at once. An adaptive rule multiplies μ by ``factor``² while no weight
    is 1.

    Source: Yang et al. 2020, (14) for the weight and Remark 5 for the first μ.
    """

    def start(self, norms: Array) -> float | StopReason:
        """Return the first μ, or NOTHING_TO_REJECT when 2u² ≤ c² for every norm."""
        mu = start_mu(float(np.max(norms, initial=0.0)), self.c, "tls")
        if mu == inf:
            return StopReason.NOTHING_TO_REJECT
        return mu if self.mu0 is None else self.mu0

    def weights(self, norms: Array, state: float) -> Array:
        """Return ``tls_weight``."""
        return tls_weight(norms, self.c, state)

    def next(self, state: float, weights: Array, moved: Array) -> float:
        """Return the larger μ of the next step."""
        if not self.adaptive:
            return self.factor * state
        # As long as no weight is 1, an approximate solution is enough.
        undecided = not np.any(weights == 1.0)
        return self.factor ** (2 if undecided else strides(moved)) * state

    def cost(self, norms: Array) -> float:
        """Return Σ min(u², c²)/2."""
        return float(np.sum(tls(self.c).rho(norms)))

    def finished(self, weights: Array, state: float, settled: bool) -> StopReason | None:
        """Stop when every weight is exactly 0 or 1."""
        # Clipped weights are exactly 0 and 1, so this needs no tolerance.
        binary = bool(np.all((weights == 0.0) | (weights == 1.0)))
        return StopReason.BINARY_WEIGHTS if binary else None


class GncGm(_Schedule):
    """The rule of GNC-GM for norms ``(k,)``: μ decreases to 1, the kernel itself.

    It starts at 1 at least. At the default start the surrogate is convex up to 0.816 u only
    for the largest norm u, so it is *nearly* convex for all norms.

    Source: Yang et al. 2020, (12) for the weight and Remark 5 for the first μ.
    """

    def start(self, norms: Array) -> float | StopReason:
        """Return the first μ, or NOTHING_TO_REJECT when there are no norms."""
        if norms.size == 0:
            return StopReason.NOTHING_TO_REJECT
        mu = start_mu(float(np.max(norms)), self.c, "gm") if self.mu0 is None else self.mu0
        return max(1.0, mu)

    def weights(self, norms: Array, state: float) -> Array:
        """Return ``gm_weight``."""
        return gm_weight(norms, self.c, state)

    def next(self, state: float, weights: Array, moved: Array) -> float:
        """Return the smaller μ of the next step, 1 at least."""
        return max(1.0, state / self.factor ** (strides(moved) if self.adaptive else 1))

    def cost(self, norms: Array) -> float:
        """Return Σ ρ(u) of the Geman–McClure kernel."""
        return float(np.sum(geman_mcclure(self.c).rho(norms)))

    def finished(self, weights: Array, state: float, settled: bool) -> StopReason | None:
        """Stop after the step at μ = 1."""
        return StopReason.CONVERGED if state == 1.0 else None


def check_kind(kind: str) -> None:
    """Check the name of a rule.

    Raises:
        ValueError: ``kind`` is not one of ``RULES``.
    """
    if kind not in RULES:
        raise ValueError(f"kind is {kind!r}; give one of {', '.join(map(repr, RULES))}")


RULES: dict[Kind, type[GncTls] | type[GncGm]] = {"tls": GncTls, "gm": GncGm}
"""The rule of each kind."""


def gnc(
    problem: Problem[X] | PoseGraph,
    c: float | None = None,
    kind: Kind = "tls",
    x0: X | None = None,
    *,
    trusted: ArrayLike | None = None,
    probability: float = 0.99,
    factor: float = 1.4,
    mu0: float | None = None,
    adaptive: bool = False,
    tol: float | None = None,
    max_iterations: int = 1000,
    max_seconds: float = inf,
    watch: Callable[[Step[X]], None] | None = None,
) -> Result[X]:
    """Minimise Σ ρ(u) of the TLS or Geman–McClure kernel by graduated non-convexity.

    Consistent outliers distort the unweighted solution and have small residuals there, so on a
    pose graph with trusted odometry dead reckoning is the better start.

    Parameters
    ----------
    problem
        A problem, or a pose graph, which is solved with one step for each μ: the poses lag behind
        μ, and closures are misjudged now and then. ``PoseGraphProblem(graph, steps=5)`` takes a
        few, which is faster. The last solve is repeated until it converges in any case.
    c
        The scale of the kernel, one number for all measurements; by default the norm that a
        Gaussian inlier does not exceed with ``probability``.
    kind
        "tls", truncated least squares, or "gm", Geman–McClure. For another kernel, or a loss of
        SciPy, there is ``irls``, from this map with ``x0=result.x``.
    x0
        The start: by default the unweighted solution, as in the paper, and dead reckoning on a
        pose graph; ``x0=problem.guess`` is that of a ``PoseGraphProblem``.
    trusted
        Edges ``(m,)`` of a pose graph that are never rejected, by default the odometry.
    probability
        It gives ``c`` where that is left out.
    factor, mu0, adaptive
        μ moves by ``factor`` in each step, from ``mu0``, by default where the surrogate is nearly
        convex; if ``adaptive``, by more while nothing is decided yet or norms hardly change.
    tol
        The largest change of a residual, relative to 1 + u, in the last solve, by default 1e-9,
        on a pose graph 1e-6.
    max_iterations
        The largest number of steps.
    max_seconds
        The CPU time (s) of the steps after the first one.
    watch
        Called with each step, to show progress.

    Returns
    -------
    Result
        With weights ``(m,)``. It stops with BINARY_WEIGHTS (TLS), CONVERGED (GM, after μ = 1),
        NOTHING_TO_REJECT, ALL_REJECTED, UNDERDETERMINED, TIME_LIMIT, or ITERATION_LIMIT, also
        when the last solve does not converge. The last x of GM belongs to the weights of the
        previous step, so it is near a minimum of the kernel's cost, not at one; ``irls`` with
        ``kernels.geman_mcclure`` continues from there.

    Raises
    ------
    ValueError
        ``kind`` is unknown, ``c`` or ``mu0`` is not above 0, ``factor`` is not above 1, or as
        ``irls``.
    Underdetermined
        The unweighted solution does not exist.
    NotConverged
        The unweighted solve did not converge; give ``x0``.

    Source
    ------
    Yang et al. 2020, (12), (14) and Remark 5; Antonante et al. 2022, Algorithm 2.

    Examples
    --------
    >>> from robust_slam.problems import LocationProblem
    >>> result = gnc(LocationProblem([0.1, -0.2, 0.15, -0.1, 5.0]), c=1.0)
    >>> round(result.x, 4), result.weights, result.stop.value
    (-0.0125, array([1., 1., 1., 1., 0.]), 'binary weights')
    """
    check_kind(kind)
    c = threshold_of(problem, probability) if c is None else c
    rule = RULES[kind](c, factor, mu0, adaptive)
    problem, x0, tol = prepare(problem, x0, tol, 1e-9, trusted)
    deadline = Deadline.after(max_seconds)
    result = reweight(
        problem,
        rule,
        x0,
        tol=tol,
        max_iterations=max_iterations,
        max_seconds=max_seconds,
        watch=watch,
    )
    if result.stop in (StopReason.BINARY_WEIGHTS, StopReason.CONVERGED):
        return settle(problem, rule, result, tol, max_seconds=deadline.left)
    return result
