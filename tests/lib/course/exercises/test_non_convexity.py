"""The pictures of 04-non-convexity: drawn with the right functions, a sentence with others."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam.estimators.kernels import tls
from robust_slam.estimators.reweighting import irls
from robust_slam.problems import LocationProblem
from robust_slam_course.exercises import non_convexity
from robust_slam_course.plots.landscapes import minima


def cost(x, z, rho):
    return sum(rho(np.asarray(x) - one) for one in z)


def local_minima(z, rho, lo, hi):
    grid = np.linspace(lo, hi, 14_001)
    return grid[minima(cost(grid, z, rho))]


def tls_descent(z, c, x0):
    return irls(LocationProblem(z), tls(c), x0).x


def best_of(z, c, starts):
    ends = [tls_descent(z, c, x0) for x0 in starts]
    return min(ends, key=lambda x: np.sum(tls(c).rho(x - z)))


RIGHT: dict[str, Callable[..., object]] = {
    "cost": cost,
    "local_minima": local_minima,
    "tls_descent": tls_descent,
    "best_of": best_of,
}


@pytest.mark.parametrize(("name", "curves"), [("cost", 3), ("tls_descent", 2)])
def test_a_right_curve_lies_on_the_truth(name: str, curves: int) -> None:
    figure = getattr(non_convexity, name)(RIGHT[name])
    assert isinstance(figure, Figure)
    lines = figure.axes[0].lines
    pairs = [pair for pair in pairwise(lines) if pair[0].get_linewidth() == 6]
    assert len(pairs) == curves
    for truth, yours in pairs:
        np.testing.assert_allclose(yours.get_xydata(), truth.get_xydata(), rtol=1e-9)


@pytest.mark.parametrize(("name", "places"), [("local_minima", 7), ("best_of", 1)])
def test_right_places_lie_in_the_rings_of_the_truth(name: str, places: int) -> None:
    figure = getattr(non_convexity, name)(RIGHT[name])
    assert isinstance(figure, Figure)
    lines = figure.axes[0].lines
    rings = [line for line in lines if line.get_markersize() == 15.0]
    yours = [line for line in lines if str(line.get_label()).startswith("yours")]
    truth = np.concatenate([line.get_xydata() for line in rings])
    assert truth.shape == (places, 2)
    np.testing.assert_allclose(
        np.concatenate([line.get_xydata() for line in yours]), truth, atol=1e-3
    )
