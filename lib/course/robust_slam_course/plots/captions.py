"""Figures whose caption depends on what the page computed.

The caption of any other figure is in the metadata of its notebook cell, where it cannot
follow the numbers. These captions are in the metadata of the output, where the book finds
them.
"""

from IPython.display import display
from matplotlib import pyplot as plt
from matplotlib.figure import Figure


def show(figure: Figure, caption: str, alt: str) -> None:
    """Display a pyplot figure with a caption, a paragraph of Markdown below it, and close it.

    `alt` says in plain words what it shows, for readers who cannot see it.
    """
    words = {"figure": {"caption": caption}, "image": {"alt": alt}}
    display(figure, metadata={"mystnb": words})
    plt.close(figure)
