"""Fonts of installed packages, cut down to the signs that pages use and carried in style sheets.

Browsers refuse fonts of another folder over file://, so no font is a file of its own.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

from fontTools import subset
from fontTools.ttLib import TTFont


def packaged(package: str, name: str) -> Path:
    """Return the path of a file that an installed package carries."""
    found = find_spec(package)
    for folder in found.submodule_search_locations or () if found else ():
        path = Path(folder) / name
        if path.is_file():
            return path
    raise RuntimeError(f"{package} with {name} is not installed: run make setup")


def cut_down(path: Path, signs: Iterable[int], options: subset.Options) -> TTFont:
    """Return a font with these signs alone."""
    font = TTFont(path, recalcTimestamp=False)
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=signs)
    subsetter.subset(font)
    return font


def packed(font: TTFont) -> bytes:
    """Return a font as woff2."""
    font.flavor = "woff2"
    target = io.BytesIO()
    font.save(target)
    return target.getvalue()


def source(font: bytes) -> str:
    """Return a font in woff2 as the source of a face in a style sheet."""
    return f'url(data:font/woff2;base64,{base64.b64encode(font).decode()}) format("woff2")'
