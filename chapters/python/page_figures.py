"""Matplotlib's back end of the page: figures are drawn by Agg and shown in the page."""

from matplotlib.backends.backend_agg import FigureCanvasAgg as FigureCanvas

from page_session import show

__all__ = ["FigureCanvas", "show"]
