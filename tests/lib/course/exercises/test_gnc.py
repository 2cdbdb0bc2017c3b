"""The pictures of 05-gnc: drawn with the right functions, a sentence with unfinished ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam.estimators import graduation as library
from robust_slam.problems import LocationProblem
from robust_slam_course.exercises import gnc


def mu_schedule(mu0: float, factor: float, n: int, kind: str) -> list[float]:
    values = [mu0]
    while len(values) < n and (kind == "tls" or values[-1] > 1.0):
        values.append(values[-1] * factor if kind == "tls" else max(values[-1] / factor, 1.0))
    return values


def loop(z, sigma, c, factor, kind, mu0=None, x0=None):
    result = library.gnc(LocationProblem(z, sigma), c, kind, factor=factor, mu0=mu0)
    names = ("mu", "weights", "x")
    rows = {name: [getattr(step, name) for step in result.history[1:]] for name in names}
    return result.x, result.weights, rows


def repaired(z, c):
    result = library.gnc(LocationProblem(z), c)
    return result.x, result.weights


RIGHT: dict[str, Callable[..., object]] = {
    "gnc_tls_weight": library.tls_weight,
    "gnc_gm_weight": library.gm_weight,
    "start_mu": library.start_mu,
    "mu_schedule": mu_schedule,
    "gnc": loop,
    "repaired_gnc": repaired,
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_function_lies_on_the_truth(name: str) -> None:
    figure = getattr(gnc, name)(RIGHT[name])
    assert isinstance(figure, Figure)
    pairs = 0
    for ax in figure.axes:
        for truth, yours in zip(ax.lines, ax.lines[1:], strict=False):
            if truth.get_linewidth() == 6.0:
                np.testing.assert_allclose(yours.get_xydata(), truth.get_xydata(), rtol=1e-9)
                pairs += 1
    assert pairs == {"start_mu": 2, "mu_schedule": 2, "gnc": 12, "repaired_gnc": 1}.get(name, 3)


def test_the_listing_ends_where_the_lesson_prints_it() -> None:
    figure = gnc.repaired_gnc(repaired)
    listing = figure.axes[0].lines[0].get_ydata()
    np.testing.assert_allclose(listing[[0, 19]], [-0.0046, 0.9495], atol=5e-5)
