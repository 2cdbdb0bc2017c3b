"""Self-contained HTML files from the templates.

A file asks for nothing: no script, no font, no picture from elsewhere, and its policy
forbids it. What other people wrote is escaped.
"""

from __future__ import annotations

import base64
import functools
import hashlib
from importlib import resources
from typing import TYPE_CHECKING

from robust_slam_autograder.markup import one_line

if TYPE_CHECKING:
    from jinja2 import Environment

SHARED_STYLE = "page"


def html(name: str, *, style: str = "", **content: object) -> str:
    """Fill in a template.

    Args:
        name: the template's, and its style's where ``style`` names no other.
        style: name of the style that goes on where the shared one ends.
        content: what the template shows.
    """
    from markupsafe import Markup  # of the extra `grading`

    rules = _style(SHARED_STYLE) + _style(style or name)
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
