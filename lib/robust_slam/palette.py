"""Colours, lines and markers of what a figure shows: told apart by each of the three.

The colours are those of ``colours.toml`` beside this file, the one place to change them.
"""

import re
import tomllib
from importlib.resources import files
from typing import NamedTuple

LineStyle = str | tuple[float, tuple[float, ...]]


class Colour(NamedTuple):
    """A colour on a light page and on paper, and on a dark page."""

    light: str
    dark: str


def colours(text: str) -> dict[str, Colour]:
    """Return the colours by name.

    Raises:
        ValueError: a colour is not given as two colours of six hexadecimal digits.
    """
    found = {name: Colour(**colour) for name, colour in tomllib.loads(text).items()}
    for name, colour in found.items():
        if not all(re.fullmatch("#[0-9a-fA-F]{6}", shade) for shade in colour):
            raise ValueError(f"colours.toml: {name} is {colour}; write each shade as #rrggbb")
    return found


COLOURS: dict[str, Colour] = colours(
    files(__package__).joinpath("colours.toml").read_text(encoding="utf-8")
)
"""The style sheets know each as a variable, such as ``--rs-ink``."""

PALETTE: dict[str, str] = {
    "truth": COLOURS["ink"].light,
    "estimate": COLOURS["estimate"].light,
    "odometry": COLOURS["muted"].light,
    "inlier": COLOURS["inlier"].light,
    "outlier": COLOURS["outlier"].light,
    "accent": COLOURS["accent"].light,
    "muted": COLOURS["faint"].light,
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
