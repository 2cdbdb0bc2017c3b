"""The fonts of the pages: cut down to what is drawn, and ready to be carried in a style sheet.

``make book`` runs it first, as ``python -m tools.fonts``; it writes build/fonts. Source Sans is
for text, Source Serif for headings, STIX for formulas, and the theme's Font Awesome for icons.
Browsers refuse fonts of another folder over file://, and text that begins in another font would
move when its own comes late, so ``chapters/_ext/look.py`` puts them into the style sheet
itself. The licence of Source Sans and Source Serif reserves their name for the whole fonts, so the
pages call them otherwise.
"""

import base64
import io
import logging
from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from fontTools import subset
from fontTools.ttLib import TTFont

logging.getLogger("fontTools").setLevel(logging.WARNING)
MADE = Path(__file__).resolve().parents[1] / "build" / "fonts"
STYLE = "fonts.css"
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
ICONS = (
    *(0xF002, 0xF010, 0xF019, 0xF03A, 0xF042, 0xF057, 0xF058, 0xF05A, 0xF062, 0xF064, 0xF065),
    *(0xF06A, 0xF071, 0xF09B, 0xF0C9, 0xF0EB, 0xF0F3, 0xF104, 0xF105, 0xF107, 0xF15B, 0xF185),
    *(0xF186, 0xF1C1, 0xF296, 0xF303, 0xF35D),
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


def rule(face: Face) -> str:
    """Return the rule of a style sheet that carries a font."""
    font = cut_down(packaged(face.package, face.path), face.signs, face.options)
    if face.family == MATH:
        fit_for_formulas(font)
    for record in font["name"].names:
        if record.nameID == 1:
            record.string = face.family
    data = base64.b64encode(packed(font)).decode()
    return (
        f'@font-face {{\n  font-display: swap;\n  font-family: "{face.family}";\n'
        f"  font-style: {face.style};\n  font-weight: {face.weight};\n"
        f'  src: url(data:font/woff2;base64,{data}) format("woff2");\n}}\n'
    )


def packaged(package: str, name: str) -> Path:
    """Return the path of the one file that an installed package carries under a name or pattern.

    Raises:
        RuntimeError: the package, or the file in it, is not installed.
    """
    found = find_spec(package)
    for folder in found.submodule_search_locations or () if found else ():
        for path in Path(folder).glob(name):
            return path
    raise RuntimeError(f"{package} with {name} is not installed: run make setup")


def cut_down(path: Path, signs: Iterable[int], options: Mapping[str, object]) -> TTFont:
    """Return a font with these signs alone."""
    font = TTFont(path, recalcTimestamp=False)
    subsetter = subset.Subsetter(subset.Options(name_IDs=[0, 1, 2, 13, 14], **options))
    subsetter.populate(unicodes=signs)
    subsetter.subset(font)
    return font


def packed(font: TTFont) -> bytes:
    """Return a font as a file of the format woff2."""
    font.flavor, file = "woff2", io.BytesIO()
    font.save(file)
    return file.getvalue()


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


def main() -> None:
    """Write the style sheet with the fonts, and a file for each font of icons."""
    MADE.mkdir(parents=True, exist_ok=True)
    (MADE / STYLE).write_text("".join(map(rule, FACES)), encoding="utf-8")
    theme = packaged("pydata_sphinx_theme", "**/fa-solid-900.woff2").parent
    for path in theme.glob("fa-*.woff2"):
        (MADE / path.name).write_bytes(packed(cut_down(path, ICONS, IN_TEXT)))


if __name__ == "__main__":
    main()
