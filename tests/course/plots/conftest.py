"""Axes in the course's style, on a figure that no window holds."""

import pytest
from matplotlib.figure import Figure
from robust_slam_course.style import figure_style


@pytest.fixture
def ax():
    with figure_style():
        yield Figure().subplots()
