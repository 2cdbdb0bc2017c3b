"""Matplotlib's SVG as part of a page: short, with the page's font and colours.

Colours become variables of the style sheet, ``var(--rs-ink,#…)``; a grey goes to the
nearest of the neutral ones. Names are made from the drawing's content, so that those of several
drawings stay apart on a page and the same drawing gives the same bytes.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from itertools import groupby
from xml.etree import ElementTree as ET

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from robust_slam.palette import COLOURS

NEUTRALS = ("ground", "grid", "faint", "muted", "ink")
"""The greys, from the lightest."""

PIXELS = 96.0 / 72.0
"""A page's pixels in a point."""

_HEX = re.compile(r"#[0-9a-f]{6}\b")
_NUMBER = re.compile(r"-?\d+\.\d+")
# Of several names of one colour the first.
_NAMES = {colour.light.lower(): name for name, colour in reversed(COLOURS.items())}
_FONT = re.compile(r"font: (?P<before>.*?)(?P<size>[\d.]+px) ")
_REFERENCE = re.compile(r"#([\w-]+)")
_REFERRING = ("href", "clip-path")
_PLACE = re.compile(r"translate\(([-\d.]+) ([-\d.]+)\)")
_UPRIGHT = re.compile(r"^rotate\(-?0 .*\)$")
_INITIAL = {"stroke-linejoin: round", "stroke-linecap: butt", "fill-opacity: 1", "opacity: 1"}
_RAISED = str.maketrans("−-.0123456789", "⁻⁻·⁰¹²³⁴⁵⁶⁷⁸⁹")
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def inline(svg: str, kind: str) -> str:
    """Return matplotlib's SVG as an element of a page, of the class `kind`."""
    root = _without_namespaces(ET.fromstring(svg))
    for group in root.iter("g"):
        _centre_lines(group)
    _strip(root)
    for element in root.iter():
        _restyle(element)
        _shorten_numbers(element)
    for text in root.iter("text"):
        _set_formula(text)
    _rename(root)
    _, _, width, height = (float(number) for number in root.get("viewBox", "0 0 1 1").split())
    size = {"width": f"{width * PIXELS:.0f}", "height": f"{height * PIXELS:.0f}"}
    # What matplotlib gives no colour is black, and black is the page's ink.
    ink = {"style": f"fill:{_variable('#000000')}"}
    root.attrib = {"class": kind, "viewBox": f"0 0 {width:g} {height:g}", **size, **ink}
    return ET.tostring(root, encoding="unicode")


def _without_namespaces(root: ET.Element) -> ET.Element:
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
        element.attrib = {key.rpartition("}")[2]: value for key, value in element.items()}
        if element.tag not in {"text", "tspan"}:
            element.text = None
        element.tail = None
    return root


def _centre_lines(group: ET.Element) -> None:
    """Anchor the lines of a centred text at their middles, so that any font centres them.

    Matplotlib anchors a single line as it is aligned, and several at their left ends.
    """
    lines = [text for text in group if text.tag == "text"]
    places = [_PLACE.fullmatch(line.get("transform", "")) for line in lines]
    starts = [(float(place[1]), place[2]) for place in places if place]
    if len(lines) < 2 or len(starts) < len(lines):
        return
    middles = [x + 0.5 * _width(line) for (x, _), line in zip(starts, lines, strict=True)]
    if max(middles) - min(middles) > 1.0:
        return
    for line, (_, y) in zip(lines, starts, strict=True):
        line.set("transform", f"translate({middles[0]:.2f} {y})")
        line.set("style", f"{line.get('style', '')}; text-anchor: middle")


def _width(line: ET.Element) -> float:
    """Return the width of a line of text as matplotlib measured it, in points."""
    font = FontProperties(size=_size(line))
    return text_to_path.get_text_width_height_descent(line.text or "", font, ismath=False)[0]


def _references(root: ET.Element) -> set[str]:
    """Return the names that elements of the drawing refer to."""
    return {
        name
        for element in root.iter()
        for key in _REFERRING
        for name in _REFERENCE.findall(element.get(key, ""))
    }


def _strip(root: ET.Element) -> None:
    """Take away what no one sees: metadata, rules for the whole page, groups of a single name."""
    wanted = _references(root)
    for element in root.iter():
        if element.get("id") not in wanted:
            element.attrib.pop("id", None)
    _unwrap(root)


def _unwrap(parent: ET.Element) -> None:
    kept: list[ET.Element] = []
    for child in parent:
        _unwrap(child)
        if child.tag in {"metadata", "style"} or _is_empty(child):
            continue
        kept += list(child) if child.tag == "g" and not child.attrib else [child]
    parent[:] = kept


def _is_empty(element: ET.Element) -> bool:
    holds_nothing = element.tag in {"g", "defs"} and len(element) == 0
    return holds_nothing or element.get("style") == "fill: none"


def _restyle(element: ET.Element) -> None:
    """Shorten a style, and give it the page's font and colours."""
    style = element.attrib.pop("style", "")
    parts = [part for each in style.split("; ") if each for part in _without_family(each)]
    kept = [part for part in parts if part not in _INITIAL]
    if kept:
        text = "; ".join(kept).replace(": ", ":").replace("; ", ";")
        element.set("style", _HEX.sub(lambda found: _variable(found[0]), text))


def _without_family(part: str) -> list[str]:
    """Return a part of a style, of a font only size and slope; matplotlib 3.8 joins them."""
    found = _FONT.match(part)
    if not found:
        return [] if part.startswith("font-family") else [part]
    slope = ["font-style: italic"] if re.search("italic|oblique", found["before"]) else []
    return [f"font-size: {found['size']}", *slope]


def _variable(colour: str) -> str:
    """Return the colour as a variable of the page, or as it is where it has no name."""
    name = _NAMES.get(colour) or _neutral(colour)
    return f"var(--rs-{name},{colour})" if name else colour


def _neutral(colour: str) -> str | None:
    """Return the neutral that is nearest to a grey."""
    red, green, blue = (colour[k : k + 2] for k in (1, 3, 5))
    if not red == green == blue:
        return None
    return min(NEUTRALS, key=lambda name: abs(int(COLOURS[name].light[1:3], 16) - int(red, 16)))


def _shorten_numbers(element: ET.Element) -> None:
    """Keep two decimals, a hundredth of a point, and one in long paths."""
    for key in ("d", "x", "y", "width", "height", "transform"):
        value = element.get(key)
        if value is not None and not value.startswith(("matrix", "scale")):
            digits = 1 if len(value) > 400 else 2
            element.set(key, _short(value.strip(), digits))
    if _UPRIGHT.match(element.get("transform", "")):
        del element.attrib["transform"]


def _short(text: str, digits: int) -> str:
    """Round the numbers of a path or a place, and leave out what need not be there."""
    short = _NUMBER.sub(lambda found: f"{round(float(found[0]), digits):g}", text)
    return re.sub(r"\s*([MLQCz])\s*", r"\1", short)


def _set_formula(text: ET.Element) -> None:
    """Let a formula flow in the page's font: plain letters, and powers as raised digits.

    Matplotlib places each letter by the measures of its own font.
    """
    spans = list(text.iter("tspan"))
    if not spans:
        return
    size = max(_size(span) for span in spans)
    line = next(_height(span) for span in spans if _size(span) == size)
    said = ""
    for (small, height), letters in groupby(spans, key=lambda span: (_size(span), _height(span))):
        run = "".join(letter.text or "" for letter in letters)
        said += run.translate(_RAISED if height < line else _LOWERED) if small < size else run
    style = next(span.get("style", "") for span in spans if _size(span) == size)
    text[:] = []
    text.text = said
    text.set("style", style)


def _height(span: ET.Element) -> float:
    return float(span.get("y", 0.0))


def _size(span: ET.Element) -> float:
    """Return the size of a text's letters in points."""
    found = re.search(r"font.*?([\d.]+)px", span.get("style", ""))
    return float(found[1]) if found else 0.0


def _rename(root: ET.Element) -> None:
    """Give short names that no other drawing has."""
    digest = hashlib.sha256(ET.tostring(root)).hexdigest()[:6]
    new = {name: f"f{digest}{k}" for k, name in enumerate(_named(root))}
    for element in root.iter():
        if "id" in element.attrib:
            element.set("id", new[element.attrib["id"]])
        for key in _REFERRING:
            if key in element.attrib:
                value = element.attrib[key]
                element.set(key, _REFERENCE.sub(lambda found: f"#{new[found[1]]}", value))


def _named(root: ET.Element) -> Iterator[str]:
    return (element.attrib["id"] for element in root.iter() if "id" in element.attrib)
