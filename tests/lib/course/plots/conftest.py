"""Axes in the course's style, on a figure that no window holds."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from robust_slam_course.style import figure_style


@pytest.fixture
def ax() -> Iterator[Axes]:
    with figure_style():
        yield Figure().subplots()
