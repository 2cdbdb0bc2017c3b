"""A matplotlib figure as a small, stable still picture for a page."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from urllib.parse import quote

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

_SIZE = re.compile(r'viewBox="0 0 ([\d.]+) ([\d.]+)"')
_BEFORE_SVG = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)
_PLACE = re.compile(r'(?<=\s[dxy]=")[^"]*')
_TAIL = re.compile(r"(\.\d\d)\d+")


@dataclass(frozen=True)
class Still:
    """A picture as SVG text."""

    svg: str

    @property
    def source(self) -> str:
        """Return the picture as the address of an image: its ids stay apart from the page's."""
        return "data:image/svg+xml;charset=utf-8," + quote(self.svg, safe=" ='():;/,")

    @property
    def size(self) -> tuple[int, int]:
        """Return width and height in the page's pixels, 4/3 of a point."""
        width, height = _SIZE.findall(self.svg)[0]
        return round(float(width) * 4 / 3), round(float(height) * 4 / 3)


def to_svg(figure: Figure) -> str:
    """Return the figure as small, stable SVG text, and close it.

    Coordinates keep two decimals, a hundredth of a point.
    """
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    plt.close(figure)
    svg = _METADATA.sub("", _BEFORE_SVG.sub("", buffer.getvalue()))
    return _PLACE.sub(lambda place: _TAIL.sub(r"\1", place[0]), svg)


def check_words(argument: str, text: str) -> None:
    """Check that there is something to read.

    Raises:
        ValueError: there is not.
    """
    if not text.strip():
        raise ValueError(f"{argument}: empty; some hear a page and do not see it, so give words.")
