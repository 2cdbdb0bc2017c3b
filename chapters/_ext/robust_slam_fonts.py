"""Fonts of installed packages, cut down to the signs that pages use and carried in style sheets.

Browsers refuse fonts of another folder over file://, so no font is a file of its own. Cutting
takes seconds: what was made is kept, under a name that changes with all that it is made of.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import tempfile
from collections.abc import Callable, Iterable
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from fontTools import subset
from fontTools.ttLib import TTFont

KEPT = Path(__file__).resolve().parents[2] / "build" / "fonts"
MAKERS = ("brotli", "fonttools")
"""Packages on which the bytes depend."""


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


def kept(make: Callable[[], bytes], whole: Path, module: str) -> bytes:
    """Return what is made of a font, made now where it was not made before.

    Args:
        make: makes it.
        whole: the font; of one font a module makes one thing.
        module: the path of the module that says how it is made.
    """
    digest = hashlib.sha256(repr([metadata.version(name) for name in MAKERS]).encode())
    for path in (whole, Path(module), Path(__file__)):
        digest.update(path.read_bytes())
    name = f"{Path(module).stem}-{whole.stem}"
    target = KEPT / f"{name}-{digest.hexdigest()[:16]}.woff2"
    if not target.is_file():
        KEPT.mkdir(parents=True, exist_ok=True)
        for old in KEPT.glob(f"{name}-*.woff2"):
            old.unlink(missing_ok=True)
        with tempfile.NamedTemporaryFile(dir=KEPT, delete=False) as part:
            part.write(make())
        os.replace(part.name, target)
    return target.read_bytes()


def source(font: bytes) -> str:
    """Return a font in woff2 as the source of a face in a style sheet."""
    return f'url(data:font/woff2;base64,{base64.b64encode(font).decode()}) format("woff2")'
