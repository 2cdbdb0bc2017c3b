"""Draw what a switch costs, and the two modes of a max-mixture."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from robust_slam._arrays import Array
from robust_slam.estimators.mixtures import NullHypothesis
from robust_slam.estimators.switches import switch, switched_cost
from robust_slam.palette import PALETTE

from robust_slam_course.style import LOOKS


def draw_switch_costs(ax: Axes, chi2: Sequence[float], lam: float) -> Axes:
    """Draw s²χ² + λ(1 − s)² over s from 0 to 1 for each χ², a marker at its lowest point."""
    s = np.linspace(0.0, 1.0, 201)
    for value, look in zip(chi2, LOOKS, strict=False):
        cost = s**2 * value + lam * (1.0 - s) ** 2
        ax.plot(s, cost, **look.line, label=f"χ² = {value:g}")
        lowest = switch(value, lam), switched_cost(value, lam)
        ax.plot(*lowest, look.marker, color=look.color, zorder=5)
    ax.set(xlabel="switch s", ylabel="cost", xlim=(-0.02, 1.02))
    return ax


def draw_modes(ax: Axes, rule: NullHypothesis, u_max: float) -> Axes:
    """Draw what each mode costs over u up to `u_max`, the lower broad behind, and the switch.

    The inlier mode costs u²/2, the outlier mode u²/(2 ratio²) + offset.
    """
    u = np.linspace(0.0, u_max, 301)
    inlier: Array = 0.5 * u**2
    outlier = inlier / rule.ratio**2 + rule.offset
    (lower,) = ax.plot(u, np.minimum(inlier, outlier), "-", label="lower of both")
    lower.set(color=PALETTE["muted"], linewidth=7.0, alpha=0.35)
    ax.plot(u, inlier, "-", color=PALETTE["inlier"], label="inlier mode")
    ax.plot(u, outlier, "--", color=PALETTE["outlier"], label="outlier mode")
    at = rule.switch_norm
    ax.plot(at, 0.5 * at**2, "D", color=PALETTE["estimate"], zorder=5, label=f"change, {at:.3f}")
    ax.set(xlabel="whitened residual u", ylabel="cost", xlim=(0.0, u_max))
    return ax
