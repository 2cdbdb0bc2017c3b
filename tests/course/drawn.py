"""What a figure shows, in words and few numbers, beside what it showed when it was looked at.

A description holds every line, text, patch, collection and image of every panel: its look, how
many numbers it has, their mean, and a weighted mean that tells their order. Colours are named as
in the palette, so that another shade changes nothing here.

After a change that is meant, look at the figures, then write the descriptions anew with
``ROBUST_SLAM_DRAWN=1 pytest FILE``.
"""

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.spines import Spine
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedFormatter
from robust_slam.palette import COLOURS

NAMES = {colour.light: name for name, colour in reversed(COLOURS.items())}
AGAIN = "ROBUST_SLAM_DRAWN"


def check(figure: Figure, case: str, path: Path, tolerance: float = 1e-5) -> None:
    """Compare a figure with its description in a file, or write that where it is asked for."""
    panels = {f"panel {k}": _panel(ax) for k, ax in enumerate(figure.axes)}
    legends = [[text.get_text() for text in one.get_texts()] for one in figure.legends]
    found = json.loads(json.dumps(panels | {"legends": legends}, default=lambda one: one.item()))
    known = json.loads(path.read_text("utf-8")) if path.exists() else {}
    if os.environ.get(AGAIN):
        cases = sorted((known | {case: found}).items())
        lines = (f"{json.dumps(one)}: {json.dumps(it, ensure_ascii=False)}" for one, it in cases)
        path.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")
    else:
        assert case in known, f"{case} is not in {path.name}: look at it, then set {AGAIN}=1"
        assert _apart(known[case], found, tolerance) == []


def _apart(known: Any, found: Any, tolerance: float, where: str = "") -> list[Any]:
    """Return where two descriptions differ, with what is known and what was found."""
    if isinstance(known, dict) and isinstance(found, dict) and known.keys() == found.keys():
        pairs = [(f"{where}/{key}", known[key], found[key]) for key in known]
    elif isinstance(known, list) and isinstance(found, list) and len(known) == len(found):
        pairs = [(f"{where}/{k}", *pair) for k, pair in enumerate(zip(known, found, strict=True))]
    elif isinstance(known, float | int) and isinstance(found, float | int):
        is_near = abs(known - found) <= tolerance * (1 + abs(known))
        return [] if is_near else [[where, known, found]]
    else:
        return [] if known == found else [[where, known, found]]
    return [gap for place, one, two in pairs for gap in _apart(one, two, tolerance, place)]


def _panel(ax: Axes) -> dict[str, Any]:
    words = [ax.get_title(where) for where in ("left", "center", "right")]
    ticks = [
        [label.get_text() for label in axis.get_ticklabels()]
        for axis in (ax.xaxis, ax.yaxis)
        if isinstance(axis.get_major_formatter(), FixedFormatter)
    ]
    legend = ax.get_legend()
    shown = [
        _described(one)
        for one in ax.get_children()
        if one is not ax.patch and (not isinstance(one, Text) or one in ax.texts)
    ]
    return {
        "words": [*words, ax.get_xlabel(), ax.get_ylabel(), ax.get_xscale(), ax.get_yscale()],
        "axes": [ax.axison, str(ax.get_aspect()), *(ax.xaxis_inverted(), ax.yaxis_inverted())],
        "ticks": ticks,
        "legend": [text.get_text() for text in legend.get_texts()] if legend else [],
        "shown": [" ".join(map(str, look)) for look, _ in filter(None, shown)],
        "numbers": [numbers for _, numbers in filter(None, shown)],
    }


def _described(one: Artist) -> tuple[list[Any], list[float]] | None:
    """Return the look of what is drawn and its numbers; nothing for frames and axes."""
    match one:
        case Line2D():
            name = "" if one.get_label().startswith("_") else one.get_label()
            look = [name, _colour(one.get_color()), one._unscaled_dash_pattern]
            look += [one.get_linewidth(), one.get_marker(), _colour(one.get_markerfacecolor())]
            numbers = one.get_xydata()
        case Text() if one.get_text():
            look, numbers = [one.get_text(), _colour(one.get_color())], one.get_position()
        case Annotation():
            look, numbers = ["arrow"], [one.xy, one.xyann]
        case Spine():
            return None
        case Patch():
            look = [type(one).__name__, one.get_hatch(), _colour(one.get_facecolor())]
            numbers = one.get_patch_transform().transform(one.get_path().vertices)
        case LineCollection():
            look, numbers = ["segments"], np.concatenate([*one.get_segments(), [[0, 0]]])
        case Collection():
            look = [type(one).__name__, [len(path.vertices) for path in one.get_paths()][:3]]
            sizes = getattr(one, "get_sizes", list)()
            values = one.get_array()
            numbers = [*np.ravel(one.get_offsets()), *sizes]
            numbers += [] if values is None else [*np.ma.filled(values, np.nan).ravel()]
        case AxesImage():
            look, numbers = ["image"], one.get_array()
        case _:
            return None
    return [*look, f"alpha {one.get_alpha()}", f"above {one.get_zorder():g}"], _summed(numbers)


def _colour(colour: Any) -> str:
    if isinstance(colour, str) and colour == "none":
        return colour
    return NAMES.get(to_hex(colour), to_hex(colour))


def _summed(numbers: Any) -> list[float]:
    """Return how many numbers there are, how many are left out, their mean, and a weighted one."""
    flat = np.ma.filled(np.ma.asarray(numbers, dtype=np.float64), np.nan).ravel()
    seen = np.isfinite(flat)
    order = np.cos(np.arange(flat.size))
    sums = (np.sum(part * np.where(seen, flat, 0.0)) for part in (1.0, order))
    means = [one / max(seen.sum(), 1) for one in sums]
    return [flat.size, int(flat.size - seen.sum()), *(float(f"{mean:.7g}") for mean in means)]
