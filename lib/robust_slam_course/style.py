"""How the course's figures look: one palette, told apart by line and marker too.

The colours are those of Okabe and Ito (2008), safe for the colour-blind, with the orange
darkened until it shows on white. A figure is an opaque white card: it is read the same
way on a light page and on a dark one, on paper and in JupyterLab.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from cycler import cycler

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType

LineStyle = str | tuple[float, tuple[float, ...]]

_INK = "#262626"

PALETTE: dict[str, str] = {
    "truth": _INK,
    "estimate": "#0072B2",
    "odometry": "#5C5C5C",
    "inlier": "#009E73",
    "outlier": "#D55E00",
    "accent": "#CC79A7",
    "muted": "#767676",
}

LINESTYLES: dict[str, LineStyle] = {
    "truth": ":",
    "estimate": "-",
    "odometry": "-",
    "inlier": "-",
    "outlier": (0.0, (5.0, 2.0)),
    "accent": "--",
    "muted": "-",
}

MARKERS: dict[str, str] = {
    "truth": "+",
    "estimate": "o",
    "odometry": ".",
    "inlier": "o",
    "outlier": "X",
    "accent": "P",
    "muted": ".",
}


@dataclass(frozen=True)
class Look:
    """A colour, a line and a marker; any two of ``LOOKS`` differ in all three."""

    color: str
    linestyle: LineStyle
    marker: str


LOOKS: tuple[Look, ...] = (
    Look(_INK, "-", "o"),
    Look("#0072B2", (0.0, (6.0, 2.0)), "s"),
    Look("#009E73", (0.0, (6.0, 2.0, 1.5, 2.0)), "^"),
    Look("#B8860B", (0.0, (3.0, 1.5)), "v"),
    Look("#D55E00", (0.0, (1.5, 1.2)), "D"),
    Look("#7B3F9E", (0.0, (8.0, 2.0, 1.5, 2.0, 1.5, 2.0)), "P"),
    Look("#8C510A", (0.0, (11.0, 3.0)), "X"),
    Look("#4B6B00", (0.0, (4.0, 1.2, 1.0, 1.2)), "*"),
)
"""Looks for things of one kind that stand beside each other, such as kernels."""

_CYCLE = (1, 4, 2, 5, 3, 0)

# 5.6 inches and 11 points: on a phone 350 pixels wide the letters still stand 9 pixels high.
STYLE: dict[RcKeyType, Any] = {
    "figure.figsize": (5.6, 3.5),
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "font.size": 11.0,
    "axes.titlesize": 11.0,
    "axes.facecolor": "white",
    "axes.edgecolor": PALETTE["muted"],
    "axes.labelcolor": _INK,
    "axes.prop_cycle": cycler(
        color=[LOOKS[number].color for number in _CYCLE],
        linestyle=[LOOKS[number].linestyle for number in _CYCLE],
    ),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.8,
    "lines.linewidth": 2.0,
    "lines.markersize": 7.0,
    "text.color": _INK,
    "xtick.color": "#4D4D4D",
    "ytick.color": "#4D4D4D",
    "legend.frameon": False,
    "legend.fontsize": 10.0,
    "legend.handlelength": 2.6,
    # Letters stay letters, and the same figure gives the same bytes.
    "svg.fonttype": "none",
    "svg.hashsalt": "robust-slam",
}


@contextmanager
def figure_style() -> Iterator[None]:
    """Draw in the course's style inside a `with` block; the settings come back after it."""
    with mpl.rc_context(STYLE):
        yield


def use_style() -> None:
    """Draw in the course's style from here on; notebooks show their figures as SVG.

    Outside a notebook only matplotlib's settings change.
    """
    mpl.rcParams.update(STYLE)
    show_figures()


def show_figures() -> None:
    """Have a notebook show a figure that a cell ends with as SVG; elsewhere nothing happens.

    Without this, or pyplot, a notebook prints the name of a figure and shows no picture.
    """
    from IPython.core.getipython import get_ipython

    if get_ipython() is not None:
        from matplotlib_inline.backend_inline import set_matplotlib_formats

        # matplotlib_inline has no types.
        set_matplotlib_formats("svg", metadata={"Date": None})  # type: ignore[no-untyped-call]
