"""Matplotlib's back end of the page: Agg draws figures in the course's style, the page shows them.

The cell that sets the style in a notebook does not run where only its imports are needed.
"""

from matplotlib.backends.backend_agg import FigureCanvasAgg as FigureCanvas
from robust_slam_course.style import use_style

from page_session import show

__all__ = ["FigureCanvas", "show"]

use_style()
