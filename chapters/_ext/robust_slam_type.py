"""The letters of the pages: Source Sans for text, Source Serif for headings, on any machine.

They come from installed packages, cut down to the signs that the pages use. Like the font of the
formulas they are carried inside a style sheet, since browsers refuse fonts of another folder over
file://, and since text that begins in another font would move when its own comes late. Their
licence reserves their name for the whole fonts, so the pages call them otherwise.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from docutils import nodes
from fontTools import subset
from sphinx.application import Sphinx

from robust_slam_fonts import cut_down, kept, packaged, packed, source

STYLE = "type.css"
SANS, SERIF = "Course Sans", "Course Serif"
FACES = (
    (SANS, "normal", "400", "font_source_sans_pro", "files/SourceSansPro-Regular.ttf"),
    (SANS, "italic", "400 700", "font_source_sans_pro", "files/SourceSansPro-It.ttf"),
    (SANS, "normal", "600 700", "font_source_sans_pro", "files/SourceSansPro-Semibold.ttf"),
    (SERIF, "normal", "400 700", "font_source_serif_pro", "files/SourceSerifPro-Semibold.ttf"),
)
"""Family, style, weights, package and file of each."""
HEADINGS = (*range(0x20, 0x7F), *map(ord, "\xa0·×éöü–—‘’“”…′μρσχ"))
SIGNS = (
    *HEADINGS,
    *range(0xA0, 0x100),
    *range(0x391, 0x3CA),
    *map(ord, "ćčšžłńřżőű̃ϑϕϵ‖″‹›₀₁₂₃₄₅⁰⁴⁵⁶⁷⁸⁹→←↑↓−√∞≈≠≤≥✓∂∑∏"),
)
"""What the fonts keep; a test looks for other signs on the pages."""
LOAD = "document.fonts.forEach((face) => /Course|STIX/.test(face.family) && face.load());"
"""Begins before the text is there to be drawn, so that nothing moves when the fonts come."""
FACE = """@font-face {{
  font-display: swap;
  font-family: "{family}";
  font-style: {style};
  font-weight: {weight};
  src: {source};
}}
"""


def font(path: Path, family: str) -> bytes:
    """Return a font under the family's name with the family's signs alone, as woff2."""
    return kept(partial(made, path, family), path, __file__)


def made(path: Path, family: str) -> bytes:
    """Cut a font down, and rename it."""
    options = subset.Options(
        hinting=False, layout_features=["kern", "liga", "mark", "tnum"], name_IDs=[0, 1, 13, 14]
    )
    whole = cut_down(path, HEADINGS if family == SERIF else SIGNS, options)
    for record in whole["name"].names:
        if record.nameID == 1:
            record.string = family
    return packed(whole)


def style_sheet() -> str:
    """Return the style sheet that carries the fonts."""
    faces = []
    for family, style, weight, package, name in FACES:
        held = source(font(packaged(package, name), family))
        faces.append(FACE.format(family=family, style=style, weight=weight, source=held))
    return "".join(faces)


def write_style(app: Sphinx, exception: Exception | None) -> None:
    """Put the style sheet among the static files."""
    if exception is None and app.builder.format == "html":
        path = Path(app.outdir) / "_static" / STYLE
        path.write_text(style_sheet(), encoding="utf-8")


def add_style(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Let every page load the style sheet."""
    app.add_css_file(STYLE)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.add_js_file(None, body=LOAD, priority=100)
    app.connect("html-page-context", add_style)
    app.connect("build-finished", write_style)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
