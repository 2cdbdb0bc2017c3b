"""Formulas are MathML when a page leaves the build: browsers draw them without a script.

KaTeX, from an installed package, reads the TeX; ``chapters/math/mathml.js`` puts its MathML into
the form that browsers draw. A formula that KaTeX cannot read ends the build. The signs
are those of STIX Two Math, cut down to what mathematics of this kind uses and carried inside
the style sheet, since browsers refuse fonts of another folder over file://.

The scripts are beside the style sheet too: a page loads them when a cell that its reader runs
shows formulas.
"""

from __future__ import annotations

import functools
import html
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import quickjs
from docutils import nodes
from fontTools import subset
from fontTools.ttLib import TTFont
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.ext.mathjax import html_visit_displaymath, html_visit_math

from robust_slam_fonts import cut_down, kept, packaged, packed, source

SOURCES = Path(__file__).resolve().parents[1] / "math"
SCRIPT = "mathml.js"
STYLE = "math.css"
KATEX = ("sphinxcontrib", "katex.min.js")
FONT = ("ziamath", "fonts/STIXTwoMath-Regular.ttf")

FORMULA = re.compile(
    r"(?P<before>[(“‘]*)"
    r'<(?P<tag>span|div) class="math notranslate nohighlight"(?P<id>[^>]*)>\s*'
    r"\\[(\[](?P<tex>.*?)\\[)\]]\s*</(?P=tag)>"
    r"(?P<after>[.,;:!?)”’]*)",
    re.DOTALL,
)
"""What Sphinx and the quizzes write, with the punctuation beside it."""

CHARACTERS = (
    *range(0x20, 0x7F),
    *range(0xA0, 0x100),
    *range(0x2C6, 0x2DE),
    *range(0x391, 0x3CA),
    *map(ord, "ϑϕϖϱϵ‒–—‖…′″‴⁡⁢⁣ℓℏℂℍℕℙℚℝℤ←↑→↓↔↦⇐⇒⇔⟵⟶⟷⟸⟹⟺"),
    *map(ord, "∀∂∃∅∆∇∈∉∏∑−∓∗∘√∝∞∣∥∧∨∩∪∫∼≃≅≈≠≡≤≥≪≫⊂⊃⊆⊇⊕⊖⊗⊤⊥⋅⋆⋮⋯⋱⪯⪰≺≻⌈⌉⌊⌋⏞⏟⎴⎵⟨⟩"),
    *range(0x1D400, 0x1D468),  # bold and italic letters; single ones are drawn italic
    *range(0x1D6E2, 0x1D71C),  # italic Greek
    *range(0x1D538, 0x1D551),  # double-struck
    *range(0x1D49C, 0x1D4B6),  # script
    *range(0x1D7CE, 0x1D7D8),  # bold digits
    0x1D6A4,
    0x1D6A5,
    0x210E,
)
"""The signs that the font keeps; a test looks for formulas with others."""

CONSTANTS = {
    # At the size of text the font's own bars are a pixel and a half, which is drawn as two.
    "FractionRuleThickness": 50,
    "OverbarRuleThickness": 50,
    "RadicalRuleThickness": 50,
}
"""What is changed in the font, in thousandths of its size."""

FONT_FACE = """@font-face {{
  font-family: "STIX Two Math";
  src: {source};
}}
"""


@functools.cache
def renderer() -> Callable[[str, bool], str]:
    """Return the function that makes MathML of TeX, in an interpreter of its own."""
    context = quickjs.Context()
    context.eval("var self = this;")
    context.eval(packaged(*KATEX).read_text(encoding="utf-8"))
    context.eval((SOURCES / SCRIPT).read_text(encoding="utf-8"))
    # As JSON, since the interpreter cannot hand over a string that it has not yet joined.
    context.eval("function inJson(tex, display) { return JSON.stringify(mathml(tex, display)); }")
    in_json = context.get("inJson")
    return functools.cache(lambda tex, display: str(json.loads(in_json(tex, display))))


def mathml(tex: str, display: bool) -> str:
    """Return a formula as a ``<math>`` element.

    Raises
    ------
    ValueError
        KaTeX cannot read it; the message says where.
    """
    try:
        return renderer()(tex.strip(), display)
    except quickjs.JSException as error:
        raise ValueError(str(error).splitlines()[0]) from error


def with_formulas(page: str, complain: Callable[[str], None]) -> str:
    """Return a page's HTML with its formulas as MathML; what cannot be read stays as it is.

    A formula in a line stays together with the punctuation beside it.
    """

    def replaced(match: re.Match[str]) -> str:
        tex, tag = html.unescape(match["tex"]), match["tag"]
        try:
            drawn = mathml(tex, tag == "div")
        except ValueError as error:
            complain(f"{error} in {tex!r}")
            return match[0]
        shown = f'<{tag} class="math"{match["id"]}>{drawn}</{tag}>'
        before, after = match["before"], match["after"]
        if tag == "span" and (before or after):
            return f'<span class="rs-kept">{before}{shown}{after}</span>'
        return before + shown + after

    return FORMULA.sub(replaced, page)


def font() -> bytes:
    """Return the font of the formulas, cut down to ``CHARACTERS``, as woff2."""
    return kept(made, packaged(*FONT), __file__)


def made() -> bytes:
    """Cut the font down."""
    options = subset.Options(layout_features=[], name_IDs=[0, 1, 2, 13, 14])
    whole = cut_down(packaged(*FONT), CHARACTERS, options)
    constants = whole["MATH"].table.MathConstants
    for name, value in CONSTANTS.items():
        getattr(constants, name).Value = value
    narrow_roots(whole)
    return packed(whole)


def narrow_roots(font: TTFont) -> None:
    """Make the signs of tall roots as narrow as the usual one.

    Chromium leaves as much room for every root as the widest sign needs.
    """
    variants = font["MATH"].table.MathVariants
    usual = font.getBestCmap()[ord("√")]
    construction = variants.VertGlyphConstruction[variants.VertGlyphCoverage.glyphs.index(usual)]
    names = [record.VariantGlyph for record in construction.MathGlyphVariantRecord]
    names += [part.glyph for part in construction.GlyphAssembly.PartRecords]
    width = font["hmtx"][usual][0]
    for name in names:
        advance, bearing = font["hmtx"][name]
        glyph, factor = font["glyf"][name], width / advance
        glyph.coordinates.scale((factor, 1))
        glyph.removeHinting()
        glyph.recalcBounds(font["glyf"])
        font["hmtx"][name] = width, round(bearing * factor)


def render(app: Sphinx, exception: Exception | None) -> None:
    """Render the formulas of the pages that were written, and put style and scripts beside.

    Raises
    ------
    ExtensionError
        Formulas that cannot be read; it names them and their pages.
    """
    if exception or app.builder.format != "html":
        return
    write_files(Path(app.outdir) / "_static")
    unreadable: list[str] = []
    for name in sorted(app.env.found_docs):
        path = Path(app.builder.get_outfilename(name))
        before = path.read_text(encoding="utf-8")
        said: list[str] = []
        after = with_formulas(before, said.append)
        unreadable += [f"{name}: {line}" for line in said]
        if after != before:
            path.write_text(after, encoding="utf-8")
    if unreadable:
        raise ExtensionError("Formulas that cannot be read:\n" + "\n".join(unreadable))


def write_files(folder: Path) -> None:
    """Put the style sheet with the font, and the scripts, among the static files."""
    face = FONT_FACE.format(source=source(font()))
    rules = (SOURCES / STYLE).read_text(encoding="utf-8")
    (folder / STYLE).write_text(face + rules, encoding="utf-8")
    for script in (packaged(*KATEX), SOURCES / SCRIPT):
        (folder / script.name).write_bytes(script.read_bytes())


def add_style(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Add the style sheet; pages without formulas have the titles of other pages beside them."""
    if doctree:
        app.add_css_file(STYLE)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.add_html_math_renderer("mathml", (html_visit_math, None), (html_visit_displaymath, None))
    app.connect("html-page-context", add_style)
    app.connect("build-finished", render)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
