"""Files from the templates: self-contained HTML, and Markdown.

A page asks for nothing: it has no script, no font or picture from elsewhere, and its policy
forbids them. It carries the course's fonts and sign where those are there. What other people
wrote is escaped: in HTML always, in Markdown by the filters.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import re
import tomllib
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from robust_slam_autograder import layout
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.markup import cell, code, one_line, prose, visible

if TYPE_CHECKING:
    from jinja2 import Environment, Template

SHARED_STYLE = "page"
MAX_SHOWN = 300
"""Letters of a value; results hold fewer, unless characters that do not show are written out."""
_SHADE = re.compile("#[0-9a-fA-F]{6}")
_FACE = re.compile(r"@font-face \{[^}]*font-family: (?P<family>\"[^\"]*\");[^}]*\}")


def html(name: str, **content: object) -> str:
    """Fill in a template, with the shared style and that of the first word of its name.

    Raises:
        WrongUse: the course's file of colours cannot be read.
    """
    from markupsafe import Markup  # of the extra `grading`

    shared = _style(SHARED_STYLE)
    rules = _fonts(layout.FONTS, shared) + _colours(layout.COLOURS) + shared
    rules += _style(name.partition("-")[0])
    digest = base64.b64encode(hashlib.sha256(rules.encode()).digest()).decode()
    content |= {"style": Markup(rules), "style_digest": digest, "logo": _logo(layout.LOGO)}
    return template(f"{name}.html").render(**content)


def template(file: str) -> Template:
    """Return a template; what HTML ones show is escaped."""
    return _templates().get_template(file)


@functools.cache
def _templates() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader(__package__),
        autoescape=lambda file: file is None or not file.endswith(".md"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    filters = (cell, code, duration, in_brackets, one_line, percent, prose, short, visible)
    made.filters |= {each.__name__: each for each in filters}
    return made


def short(text: str) -> str:
    """Return a value of a student's as far as it fits beside another one."""
    shown = visible(text)
    return shown if len(shown) <= MAX_SHOWN else f"{shown[: MAX_SHOWN - 1]}…"


def percent(share: float | None) -> str:
    """Return a share in per cent; shows 0 % or 100 % only when exact."""
    if share is None:
        return "–"
    if 0 < share < 0.01:
        return "<1 %"
    if 0.99 < share < 1:
        return ">99 %"
    return f"{100 * share:.0f} %"


def duration(seconds: float) -> str:
    """Return seconds for people: two digits, then minutes, then hours."""
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def in_brackets(address: str) -> str:
    """Return an address for Markdown's angle brackets, where it may hold all but these."""
    return address.replace("<", "%3C").replace(">", "%3E").replace("\n", "")


@functools.cache
def _style(name: str) -> str:
    return resources.files(__package__).joinpath("templates", f"{name}.css").read_text("utf-8")


def _fonts(path: Path, style: str) -> str:
    """Return the upright fonts that a style sheet carries and ``style`` names."""
    if not path.is_file():
        return ""
    faces = _FACE.finditer(path.read_text("utf-8"))
    return "\n".join(
        face[0] for face in faces if face["family"] in style and "italic" not in face[0]
    )


def _logo(path: Path) -> str:
    """Return a picture as an address that holds it; empty where there is none."""
    if not path.is_file():
        return ""
    return f"data:image/svg+xml;base64,{base64.b64encode(path.read_bytes()).decode()}"


def _colours(path: Path) -> str:
    """Return the course's colours as variables of a style sheet; without them it has its own."""
    if not path.is_file():
        return ""
    light, dark = "", ""
    try:
        for name, colour in tomllib.loads(path.read_text("utf-8")).items():
            light += f"--rs-{name}: {_shade(colour['light'])}; "
            dark += f"--rs-{name}: {_shade(colour['dark'])}; "
    except (ValueError, KeyError, TypeError) as error:
        example = 'estimate = { light = "#0072b2", dark = "#5bb8f0" }'
        raise WrongUse(f"{path}: write a colour as {example} ({error!r}).") from None
    return (
        f":root {{ {light}}}\n@media not print "
        f"{{ @media (prefers-color-scheme: dark) {{ :root {{ {dark}}} }} }}\n"
    )


def _shade(text: str) -> str:
    if not _SHADE.fullmatch(text):
        raise ValueError(text)
    return text
