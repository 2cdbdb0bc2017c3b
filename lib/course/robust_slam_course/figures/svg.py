"""Matplotlib's SVG as part of a page: short, with the page's font and colours.

Colours become variables of the style sheet, ``var(--rs-ink,#…)``; a grey goes to the
nearest of the neutral ones. Names are made from the drawing's content, so that those of several
drawings stay apart on a page and the same drawing gives the same bytes.
"""

import re
from hashlib import sha256
from itertools import groupby
from xml.etree import ElementTree as ET

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from robust_slam.palette import COLOURS

NEUTRALS = ("ground", "grid", "faint", "muted", "ink")
"""The greys, from the lightest."""

PIXELS = 96.0 / 72.0
"""A page's pixels in a point."""

_OF_A_FILE = re.compile(
    r"^.*?(?=<svg)|<metadata>.*?</metadata>"
    r"|<style.*?</style>"  # its rules would be the whole page's
    r'| xmlns(:\w+)?="[^"]*"|xlink:|(?<=>)\s+(?=<)',
    re.DOTALL,
)
_HEX = re.compile(r"#[0-9a-f]{6}\b")
_NUMBER = re.compile(r"-?\d+\.\d+")
# Of several names of one colour the first.
_NAMES = {colour.light.lower(): name for name, colour in reversed(COLOURS.items())}
_FONT = re.compile(r"font: (?P<before>.*?)(?P<size>[\d.]+px) ")
_NAME = re.compile(r' id="(?P<named>[^"]*)"|(?P<before>href="#|url\(#)(?P<meant>[\w-]+)')
_PLACE = re.compile(r"translate\(([-\d.]+) ([-\d.]+)\)")
_UPRIGHT = re.compile(r"^rotate\(-?0 .*\)$")
_RAISED = str.maketrans("−-.0123456789", "⁻⁻·⁰¹²³⁴⁵⁶⁷⁸⁹")
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def inline(svg: str, kind: str) -> str:
    """Return matplotlib's SVG as an element of a page, of the class `kind`."""
    root = ET.fromstring(_OF_A_FILE.sub("", svg))
    for group in root.iter("g"):
        _centre_lines(group)
    for element in root.iter():
        _restyle(element)
        _shorten_numbers(element)
    for text in root.iter("text"):
        _set_formula(text)
    _, _, width, height = (float(number) for number in root.get("viewBox", "0 0 1 1").split())
    size = {"width": f"{width * PIXELS:.0f}", "height": f"{height * PIXELS:.0f}"}
    # What matplotlib gives no colour is black, and black is the page's ink.
    ink = {"style": f"fill:{_variable('#000000')}"}
    root.attrib = {"class": kind, "viewBox": f"0 0 {width:g} {height:g}", **size, **ink}
    return _renamed(ET.tostring(root, encoding="unicode"))


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


def _restyle(element: ET.Element) -> None:
    """Shorten a style, and give it the page's font and colours."""
    style = element.attrib.pop("style", "")
    parts = [part for each in style.split("; ") if each for part in _without_family(each)]
    if parts:
        text = ";".join(parts).replace(": ", ":")
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
    """Keep one decimal, a tenth of a point, and leave out what need not be there."""
    for key in ("d", "x", "y", "width", "height", "transform"):
        value = element.get(key, "")
        if value and not value.startswith(("matrix", "scale")):
            short = _NUMBER.sub(lambda found: f"{round(float(found[0]), 1):g}", value.strip())
            element.set(key, re.sub(r"\s*([MLQCz])\s*", r"\1", short))
    if _UPRIGHT.match(element.get("transform", "")):
        del element.attrib["transform"]


def _set_formula(text: ET.Element) -> None:
    """Let a formula flow in the page's font: plain letters, and powers as raised digits.

    Matplotlib places each letter by its own font; what has no raised or lowered sign stays small.
    """
    # Older releases, as the page's, give a place for each letter.
    spans = sorted(text.iter("tspan"), key=lambda span: float(span.get("x", "0").split()[0]))
    if not spans:
        return
    size = max(_size(span) for span in spans)
    first = next(span for span in spans if _size(span) == size)
    text[:], text.text, part = [], "", text
    at = line = _height(first)
    for (small, height), letters in groupby(spans, key=lambda span: (_size(span), _height(span))):
        run = "".join(letter.text or "" for letter in letters)
        said = run.translate(_RAISED if height < line else _LOWERED) if small < size else run
        to = height if small < size and said == run else line
        if to != at:
            style = {} if to == line else {"style": f"font-size:{small:g}px"}
            part, at = ET.SubElement(text, "tspan", style, dy=f"{to - at:.1f}"), to
        part.text = (part.text or "") + said
    text.set("style", first.get("style", ""))


def _height(span: ET.Element) -> float:
    return float(span.get("y", 0.0))


def _size(span: ET.Element) -> float:
    """Return the size of a text's letters in points."""
    found = re.search(r"font.*?([\d.]+)px", span.get("style", ""))
    return float(found[1]) if found else 0.0


def _renamed(svg: str) -> str:
    """Give short names that no other drawing has to what is meant somewhere, to the rest none."""
    digest = sha256(svg.encode()).hexdigest()[:6]
    meant = dict.fromkeys(found["meant"] for found in _NAME.finditer(svg) if found["meant"])
    names = {name: f"f{digest}{k}" for k, name in enumerate(meant)}

    def named(found: re.Match[str]) -> str:
        if found["meant"]:
            return f"{found['before']}{names[found['meant']]}"
        return f' id="{names[found["named"]]}"' if found["named"] in names else ""

    return _NAME.sub(named, svg)
