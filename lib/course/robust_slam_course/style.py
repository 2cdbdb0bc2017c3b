"""How the course's figures and pages look, in the colours of `robust_slam/colours.toml`.

Matplotlib draws with those for a light page. On a page of the book they are variables of its
style sheet, for figures (`robust_slam_course.figures`), live pictures, quizzes and the site alike.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import matplotlib as mpl
import matplotlib.figure
from cycler import cycler
from robust_slam.palette import COLOURS, PALETTE, LineStyle

if TYPE_CHECKING:
    from matplotlib.typing import RcKeyType


@dataclass(frozen=True)
class Look:
    """A colour, a line and a marker; any two of ``LOOKS`` differ in all three."""

    color: str
    linestyle: LineStyle
    marker: str

    @property
    def line(self) -> dict[str, Any]:
        """Return the settings of matplotlib's line without a marker."""
        return {"color": self.color, "linestyle": self.linestyle}


LOOKS: tuple[Look, ...] = (
    Look(COLOURS["ink"].light, "-", "o"),
    Look(COLOURS["plum"].light, (0.0, (6.0, 2.0)), "s"),
    Look(COLOURS["ochre"].light, (0.0, (6.0, 2.0, 1.5, 2.0)), "^"),
    Look(COLOURS["olive"].light, (0.0, (3.0, 1.5)), "v"),
    Look(COLOURS["accent"].light, (0.0, (1.5, 1.2)), "P"),
    Look(COLOURS["brown"].light, (0.0, (8.0, 2.0, 1.5, 2.0, 1.5, 2.0)), "p"),
    Look(COLOURS["estimate"].light, (0.0, (11.0, 3.0)), "<"),
    Look(COLOURS["faint"].light, (0.0, (4.0, 1.2, 1.0, 1.2)), "*"),
)
"""Looks for things of one kind that stand beside each other, such as kernels.

None is taken for data: green is an inlier, and an orange cross or diamond an outlier.
"""

_CYCLE = (6, 2, 1, 3, 4)

# Pages draw it a second time for phones; 11 points are 15 pixels on a wide page.
STYLE: dict[RcKeyType, Any] = {
    "figure.figsize": (5.6, 3.5),
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "font.size": 11.0,
    "axes.titlesize": 11.0,
    "axes.facecolor": "white",
    "axes.edgecolor": PALETTE["muted"],
    "axes.labelcolor": PALETTE["truth"],
    "axes.prop_cycle": cycler(
        color=[LOOKS[number].color for number in _CYCLE],
        linestyle=["-", *(LOOKS[number].linestyle for number in _CYCLE[1:])],
    ),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": COLOURS["grid"].light,
    "grid.linewidth": 0.8,
    "lines.linewidth": 2.0,
    "lines.markersize": 7.0,
    "text.color": PALETTE["truth"],
    "xtick.color": COLOURS["muted"].light,
    "ytick.color": COLOURS["muted"].light,
    "legend.frameon": False,
    "legend.fontsize": 10.0,
    "legend.handlelength": 2.6,
    # Letters stay letters, and the same figure gives the same bytes.
    "svg.fonttype": "none",
    "svg.hashsalt": "robust-slam",
}


def variables(page: Literal["light", "dark"]) -> str:
    """Return the colours as variables of a style sheet, without the ground, which is a page's."""
    return " ".join(
        f"--rs-{name}: {getattr(colour, page)};"
        for name, colour in COLOURS.items()
        if name != "ground"
    )


def site_colours() -> str:
    """Return the style sheet that gives the site its colours; on paper they are the light ones."""
    dark = f'html[data-theme="dark"] {{ {variables("dark")} }}'
    return f":root {{ {variables('light')} }}\n@media not print {{ {dark} }}\n"


@contextmanager
def figure_style() -> Iterator[None]:
    """Draw in the course's style inside a `with` block, or in a function that this decorates."""
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

    Without this, or pyplot, a notebook prints the name of a figure and shows no picture. In a
    build of the book it is a part of the page.
    """
    from IPython.core.getipython import get_ipython

    from robust_slam_course import figures

    shell = get_ipython()
    formatter = getattr(shell, "display_formatter", None)
    if formatter is None:
        return
    from matplotlib_inline.backend_inline import set_matplotlib_formats

    # matplotlib_inline has no types.
    set_matplotlib_formats("svg", metadata={"Date": None})  # type: ignore[no-untyped-call]
    if figures.is_for_a_page():
        formatter.formatters["image/svg+xml"].for_type(mpl.figure.Figure, figures.page_html)
