"""A page asks for one style sheet and one script, in which are its fonts and its icons.

The theme and the extensions have a dozen of each. They are joined in their order, and
``chapters/_templates/layout.html`` links the two files that come of it.

Source Sans is for text, Source Serif for headings, STIX for formulas. They come from installed
packages, cut down to the signs that the pages use and carried inside the style sheet, as are the
icons: browsers refuse fonts of another folder over file://, and text that begins in another font
would move when its own comes late. The licence of the first two reserves their name for the whole
fonts, so the pages call them otherwise. Cutting takes seconds: what was made is kept.
"""

from __future__ import annotations

import base64
import hashlib
import io
import logging
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatch
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from docutils import nodes
from fontTools import subset
from fontTools.ttLib import TTFont
from robust_slam_course.style import site_colours
from sphinx.application import Sphinx

logging.getLogger("fontTools").setLevel(logging.WARNING)
STYLE, SCRIPT = "course.css", "course.js"
SHEETS = (
    "basic.css",
    "styles/pydata-sphinx-theme.css",
    "pygments.css",
    "styles/sphinx-book-theme.css",
    "togglebutton.css",
    "copybutton.css",
    "mystnb.*.css",
    "sphinx-design.min.css",
    "math.css",
    "site.css",
)
SCRIPTS = (
    "doctools.js",
    "sphinx_highlight.js",
    "clipboard.min.js",
    "copybutton.js",
    "scripts/sphinx-book-theme.js",
    "togglebutton.js",
    "print.js",
    "progress.js",
    "scripts/bootstrap.js",
    "scripts/pydata-sphinx-theme.js",
)
"""Files and patterns below _static/, in the order in which a page would link them."""
UNUSED = ("design-tabs.js", "sphinx-thebe.js", "sphinx-thebe.css", "styles/theme.css")
"""No page has tabs, or a kernel in the cloud; the last one imports the first of the sheets."""

ICONS = re.compile(r'class="[^"]*\bfa-[^"]*"')
NAME = re.compile(r"\bfa-[\w-]+")
ICON_RULE = re.compile(r'((?:\.fa-[\w-]+:{1,2}before,?)+)\{content:"[^"]*"\}')
"""The rules of the theme's two thousand icons."""
CODE = re.compile(r"\\([ef][0-9a-f]{3})\b|([\ue000-\uf8ff])")
"""An icon that a rule writes."""
ICON_FONT = re.compile(r"url\([^)]*/(fa-[\w-]+)\.woff2\)[^;}]*")

KEPT = Path(__file__).resolve().parents[2] / "build" / "fonts"
MAKERS = ("brotli", "fonttools")
"""Packages on which the bytes of fonts depend."""
SANS, SERIF, MATH = "Course Sans", "Course Serif", "STIX Two Math"
HEADINGS = (*range(0x20, 0x7F), *map(ord, "\xa0·×éöü–—‘’“”…′μρσχ"))
TEXT = (
    *HEADINGS,
    *range(0xA0, 0x100),
    *range(0x391, 0x3CA),
    *map(ord, "ćčšžłńřżőű̃ϑϕϵ‖″‹›₀₁₂₃₄₅⁰⁴⁵⁶⁷⁸⁹→←↑↓−√∞≈≠≤≥✓∂∑∏"),
)
FORMULAS = (
    *range(0x20, 0x7F),
    *range(0xA0, 0x100),
    *range(0x2C6, 0x2DE),
    *range(0x391, 0x3CA),
    *map(ord, "ϑϕϖϱϵ‒–—‖…′″‴⁡⁢⁣ℓℏℂℍℕℙℚℝℤ←↑→↓↔↦⇐⇒⇔⟵⟶⟷⟸⟹⟺"),
    *map(ord, "∀∂∃∅∆∇∈∉∏∑−∓∗∘√∝∞∣∥∧∨∩∪∫∼≃≅≈≠≡≤≥≪≫⊂⊃⊆⊇⊕⊖⊗⊤⊥⋅⋆⋮⋯⋱⪯⪰≺≻⌈⌉⌊⌋⏞⏟⎴⎵⟨⟩"),
    *range(0x1D400, 0x1D468),  # bold and italic letters; single ones are drawn italic
    *range(0x1D6A8, 0x1D71C),  # bold and italic Greek
    *range(0x1D538, 0x1D551),  # double-struck
    *range(0x1D49C, 0x1D4B6),  # script
    *range(0x1D7CE, 0x1D7D8),  # bold digits
    0x1D6A4,
    0x1D6A5,
    0x210E,
)
"""The signs that fonts keep; tests look for others on the pages."""
IN_TEXT = {"hinting": False, "layout_features": ["kern", "liga", "mark", "tnum"]}
IN_FORMULAS = {"hinting": False, "layout_features": []}
"""What else they keep."""


class Face(NamedTuple):
    """A font of the pages: where it comes from, and what is kept of it."""

    family: str
    style: str
    weight: str
    package: str
    path: str
    signs: Iterable[int]
    options: Mapping[str, object] = IN_TEXT


_SANS, _SERIF = "font_source_sans_pro", "font_source_serif_pro"
FACES = (
    Face(SANS, "normal", "400", _SANS, "files/SourceSansPro-Regular.ttf", TEXT),
    Face(SANS, "italic", "400 700", _SANS, "files/SourceSansPro-It.ttf", TEXT),
    Face(SANS, "normal", "600 700", _SANS, "files/SourceSansPro-Semibold.ttf", TEXT),
    Face(SERIF, "normal", "400 700", _SERIF, "files/SourceSerifPro-Semibold.ttf", HEADINGS),
    Face(MATH, "normal", "400", "ziamath", "fonts/STIXTwoMath-Regular.ttf", FORMULAS, IN_FORMULAS),
)


def link(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Leave out of a page what is joined; files that this module does not know stay."""
    joined = [f"_static/{name}" for name in (*SHEETS, *SCRIPTS, *UNUSED)]
    for kind in ("css_files", "script_files"):
        context[kind] = [
            each
            for each in dict.fromkeys(context[kind])  # the theme names some twice
            if not any(fnmatch(str(each.filename), name) for name in joined)
            and "thebe" not in str(each.attributes)
        ]


def write(app: Sphinx, exception: Exception | None) -> None:
    """Write the style sheet and the script that pages link."""
    if exception or app.builder.format != "html":
        return
    out, static = Path(app.outdir), Path(app.outdir, "_static")
    # Semicolons, since "use strict" of the first file is not for the others.
    script = "".join(f";\n{text}" for text in texts(static, SCRIPTS))
    (static / SCRIPT).write_text(script, encoding="utf-8")
    icons: set[str] = set()
    for page in (*out.glob("*.html"), *out.glob("chapters/*.html")):
        icons.update(*map(NAME.findall, ICONS.findall(page.read_text("utf-8"))))
    style = with_icons("\n".join(texts(static, SHEETS)), icons, static)
    (static / STYLE).write_text(fonts() + site_colours() + style, encoding="utf-8")


def texts(static: Path, names: Iterable[str]) -> Iterator[str]:
    """Give the texts of files by their names; a theme without one of them is another theme."""
    for name in names:
        found = sorted(static.glob(name))
        if not found:
            raise FileNotFoundError(f"{name} is not in {static}: look at the lists in look.py")
        yield from (path.read_text("utf-8") for path in found)


def with_icons(style: str, shown: set[str], static: Path) -> str:
    """Return a style sheet that carries the icons that pages show and its own rules write."""

    def used(match: re.Match[str]) -> str:
        return match[0] if shown & set(NAME.findall(match[1])) else ""

    def carried(match: re.Match[str]) -> str:
        return source(cut_down(next(static.rglob(f"{match[1]}.woff2")), signs, **IN_TEXT))

    style = ICON_RULE.sub(used, style)
    signs = {int(code, 16) if code else ord(sign) for code, sign in CODE.findall(style)}
    return ICON_FONT.sub(carried, style)


def fonts() -> str:
    """Return the rules that carry the fonts, made now where they were not made before."""
    digest = hashlib.sha256(repr([metadata.version(name) for name in MAKERS]).encode())
    for path in (Path(__file__), *(packaged(face.package, face.path) for face in FACES)):
        digest.update(path.read_bytes())
    kept = KEPT / f"{digest.hexdigest()[:16]}.css"
    if not kept.is_file():
        shutil.rmtree(KEPT, ignore_errors=True)
        KEPT.mkdir(parents=True)
        part = kept.with_suffix(".part")
        part.write_text("".join(map(rule, FACES)), encoding="utf-8")
        part.replace(kept)
    return kept.read_text(encoding="utf-8")


def rule(face: Face) -> str:
    """Return the rule of a style sheet that carries a font."""
    font = cut_down(packaged(face.package, face.path), face.signs, **face.options)
    if face.family == MATH:
        fit_for_formulas(font)
    for record in font["name"].names:
        if record.nameID == 1:
            record.string = face.family
    return (
        f'@font-face {{\n  font-display: swap;\n  font-family: "{face.family}";\n'
        f"  font-style: {face.style};\n  font-weight: {face.weight};\n  src: {source(font)};\n}}\n"
    )


def packaged(package: str, name: str) -> Path:
    """Return the path of a file that an installed package carries."""
    found = find_spec(package)
    for folder in found.submodule_search_locations or () if found else ():
        path = Path(folder) / name
        if path.is_file():
            return path
    raise RuntimeError(f"{package} with {name} is not installed: run make setup")


def cut_down(path: Path, signs: Iterable[int], **options: object) -> TTFont:
    """Return a font with these signs alone."""
    font = TTFont(path, recalcTimestamp=False)
    subsetter = subset.Subsetter(subset.Options(name_IDs=[0, 1, 2, 13, 14], **options))
    subsetter.populate(unicodes=signs)
    subsetter.subset(font)
    return font


def source(font: TTFont) -> str:
    """Return a font as the source of a face in a style sheet, in woff2."""
    font.flavor, packed = "woff2", io.BytesIO()
    font.save(packed)
    data = base64.b64encode(packed.getvalue()).decode()
    return f'url(data:font/woff2;base64,{data}) format("woff2")'


def fit_for_formulas(font: TTFont) -> None:
    """Make bars thin, and the signs of tall roots as narrow as the usual one.

    At the size of text the font's own bars are a pixel and a half, which is drawn as two.
    Chromium leaves as much room for every root as the widest sign needs.
    """
    constants, variants = (
        getattr(font["MATH"].table, f"Math{name}") for name in ("Constants", "Variants")
    )
    for name in ("FractionRuleThickness", "OverbarRuleThickness", "RadicalRuleThickness"):
        getattr(constants, name).Value = 50  # thousandths of the size
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


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build, behind all that adds files."""
    app.connect("html-page-context", link, priority=900)
    app.connect("build-finished", write, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
