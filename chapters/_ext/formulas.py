r"""Formulas are MathML when a page leaves the build: browsers draw them without a script.

math-core makes MathML Core of the TeX. A formula that it cannot read is a warning, with which the
build fails. A page loads KaTeX, which is beside it, only when a cell that its reader runs shows
formulas; those that the cells of the book show, between ``\(`` and ``\)`` in their HTML, are read
here.
"""

import functools
import html
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

import math_core
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

LOGGER = logging.getLogger(__name__)
KATEX = "katex.min.js"
IN_HTML = re.compile(
    r'(?P<place><(?:span|div) class="math)[^"]*">\s*\\[(\[](?P<tex>.*?)\\[)\]]', re.S
)
"""A formula in the output of a cell."""
ROOM = re.compile(r"\\\\\s*\[[^]]*\]")
"""A new line with more room above it, which math-core would print."""
LARGE_BASE = re.compile(r"(<msu(?:b|p|bsup)>)(<mo minsize[^>]*>[^<]*</mo>)")
"""A large bracket with a power or an index."""
PRIME = re.compile(r"<msup>(<mi>[^<]*</mi>)(<mo>[′″]</mo>)</msup>")
"""A derivative; the sign is high by itself, and as a power it would be small and higher still."""
BESIDE = re.compile(
    r'([(“‘]*)(<span class="math"[^>]*><math.*?</math></span>)([.,;:!?)”’]*)', re.S
)
"""A formula of a line, and the punctuation beside it."""


@functools.cache
def mathml(tex: str, display: bool) -> str:
    """Return a formula as a ``<math>`` element.

    Raises
    ------
    ValueError
        math-core cannot read it; the message says where.
    """
    converter = math_core.LatexToMathML(fancy_error=False)
    plain = ROOM.sub(r"\\\\", tex.strip())
    try:
        drawn = converter.convert_with_local_state(plain, displaystyle=display)
    except math_core.LatexError as error:
        raise ValueError(f"{error} In the formula {tex!r}") from error
    # As an accent a brace would touch what is above it.
    drawn = drawn.replace('<munder accentunder="true">', "<munder>")
    # Chromium gives a bracket its size in a row, and not as the base of a power.
    drawn = LARGE_BASE.sub(r"\1<mrow>\2</mrow>", drawn)
    return PRIME.sub(r"<mrow>\1\2</mrow>", drawn).replace("&ApplyFunction;", "\u2061")


def shown(tex: str, display: bool, where: object) -> str:
    """Return a formula as MathML, or its TeX after a warning that names the place."""
    try:
        return mathml(tex, display)
    except ValueError as error:
        LOGGER.warning("%s", error, location=where)
        return html.escape(tex)


def visit(self: HTML5Translator, node: nodes.math | nodes.math_block) -> None:
    """Write a formula, in a line or of its own."""
    display = isinstance(node, nodes.math_block)
    tag = "div" if display else "span"
    self.body.append(self.starttag(node, tag, "", CLASS="math"))
    self.body.append(f"{shown(node.astext(), display, node)}</{tag}>")
    raise nodes.SkipNode


def finish(app: Sphinx, page: str, template: str, context: dict[str, Any], *_: object) -> None:
    """Read the formulas in the HTML of cells; keep punctuation in the line of its formula."""
    if "body" in context:
        context["body"] = BESIDE.sub(
            lambda part: (
                f'<span class="rs-kept">{part[0]}</span>' if part[1] + part[3] else part[0]
            ),
            in_html(context["body"], page),
        )


def in_html(text: str, where: object) -> str:
    """Return HTML with its formulas as MathML."""

    def replaced(match: re.Match[str]) -> str:
        tex, display = html.unescape(match["tex"]), match["place"].startswith("<div")
        return f'{match["place"]}">{shown(tex, display, where)}'

    return IN_HTML.sub(replaced, text)


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Put KaTeX beside the pages, for cells that their readers run."""
    if exception is None and app.builder.format == "html":
        script = files("sphinxcontrib").joinpath(KATEX).read_bytes()
        Path(app.outdir, "_static", KATEX).write_bytes(script)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.add_html_math_renderer("mathml", (visit, None), (visit, None))
    app.connect("html-page-context", finish)
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
