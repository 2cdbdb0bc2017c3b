"""A matplotlib figure as a small, stable still picture for a page."""

import io
import re
from urllib.parse import quote

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

_SIZE = re.compile(r'viewBox="0 0 ([\d.]+) ([\d.]+)"')
_BEFORE_SVG = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
# Metadata, turns by nothing, the indent, and fonts before the page's own.
_IDLE = re.compile(
    r"\s*<metadata>.*?</metadata>| transform=\"rotate\(-0 [^\"]*\"|(?<=\n) +"
    r"|(?<=font-family: )(?:'[\w ]+', )+",
    re.DOTALL,
)
_PLACE = re.compile(r'(?<=\s[dxy]=")[^"]*')
_TAIL = re.compile(r"(\.\d\d)\d+")


def address(svg: str) -> str:
    """Return the SVG as the address of an image: its ids stay apart from the page's."""
    return "data:image/svg+xml;charset=utf-8," + quote(svg, safe=" ='():;/,")


def size(svg: str) -> tuple[int, int]:
    """Return width and height in the page's pixels, 4/3 of a point."""
    width, height = _SIZE.findall(svg)[0]
    return round(float(width) * 4 / 3), round(float(height) * 4 / 3)


def to_svg(figure: Figure) -> str:
    """Return the figure as small, stable SVG text, and close it.

    Coordinates keep two decimals, a hundredth of a point.
    """
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    plt.close(figure)
    svg = _IDLE.sub("", _BEFORE_SVG.sub("", buffer.getvalue()))
    return _PLACE.sub(lambda place: _TAIL.sub(r"\1", place[0]), svg)
