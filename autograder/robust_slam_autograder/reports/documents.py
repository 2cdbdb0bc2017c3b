"""Self-contained HTML files from the templates.

A file asks for nothing: no script, no font, no picture from elsewhere, and its policy
forbids it. What other people wrote is escaped.
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
from robust_slam_autograder.markup import one_line

if TYPE_CHECKING:
    from jinja2 import Environment

SHARED_STYLE = "page"
_SHADE = re.compile("#[0-9a-fA-F]{6}")


def html(name: str, *, style: str = "", **content: object) -> str:
    """Fill in a template.

    Args:
        name: the template's, and its style's where ``style`` names no other.
        style: name of the style that goes on where the shared one ends.
        content: what the template shows.

    Raises:
        WrongUse: the course's file of colours cannot be read.
    """
    from markupsafe import Markup  # of the extra `grading`

    rules = _colours(layout.COLOURS) + _style(SHARED_STYLE) + _style(style or name)
    digest = base64.b64encode(hashlib.sha256(rules.encode()).digest()).decode()
    return (
        _templates()
        .get_template(f"{name}.html")
        .render(**content, style=Markup(rules), style_digest=digest, one_line=one_line)
    )


@functools.cache
def _templates() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader(__package__),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@functools.cache
def _style(name: str) -> str:
    return resources.files(__package__).joinpath("templates", f"{name}.css").read_text("utf-8")


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
