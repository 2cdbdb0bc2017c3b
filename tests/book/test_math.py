"""Formulas leave the build as MathML that browsers draw, with signs that the font has."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as etree
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import pytest
from fontTools.ttLib import TTFont
from playwright.sync_api import Browser
from sphinx.errors import ExtensionError

from chapters._ext import robust_slam_math
from tests.book.conftest import PAGES, Site

MATHML = re.compile(r"<math\b.*?</math>", re.DOTALL)
NAMESPACE = "{http://www.w3.org/1998/Math/MathML}"
CHILDREN = {"msub": 2, "msup": 2, "mfrac": 2, "munder": 2, "mover": 2, "msubsup": 3}
CORE = {
    *("math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "mstyle", "mpadded"),
    *("mfrac", "msqrt", "mroot", "msub", "msup", "msubsup", "munder", "mover", "munderover"),
    *("mtable", "mtr", "mtd"),
}
"""Elements of MathML Core, which browsers draw alike."""


def trees(site: Site, page: str) -> list[etree.Element]:
    """The formulas of a page."""
    html = (site.folder / f"{page}.html").read_text(encoding="utf-8")
    return [etree.fromstring(formula) for formula in MATHML.findall(html)]


def name(element: etree.Element) -> str:
    """The name of an element of MathML."""
    return element.tag.removeprefix(NAMESPACE)


@pytest.mark.parametrize("page", PAGES)
class TestPage:
    """What holds for the formulas of every page."""

    def test_no_formula_is_left_in_tex(self, page: str, site: Site) -> None:
        html = (site.folder / f"{page}.html").read_text(encoding="utf-8")
        article = html[html.index("<article") : html.index("</article>")]
        places = re.findall(r'class="math[ "]', html)
        assert len(places) == len(MATHML.findall(html))
        assert not re.findall(
            r"\\\(|\\\[|\\begin\{", re.sub(r"<pre.*?</pre>", "", article, flags=re.S)
        )

    def test_elements_are_of_mathml_core_and_have_their_children(
        self, page: str, site: Site
    ) -> None:
        for formula in trees(site, page):
            for element in formula.iter():
                assert name(element) in CORE
                assert len(element) == CHILDREN.get(name(element), len(element))

    def test_the_font_has_every_sign(self, page: str, site: Site) -> None:
        signs = set("".join("".join(formula.itertext()) for formula in trees(site, page)))
        assert {sign for sign in signs if not sign.isspace()} <= held()


@cache
def held() -> set[str]:
    return set(map(chr, TTFont(io.BytesIO(robust_slam_math.font())).getBestCmap()))


def mathml(tex: str, display: bool = False) -> str:
    """A formula without its outermost element and row."""
    whole = robust_slam_math.mathml(tex, display)
    return whole.split(">", 1)[1].removeprefix("<mrow>").removesuffix("</mrow></math>")


@pytest.mark.parametrize(
    ("tex", "drawn"),
    [
        (r"\mathbb E", '<mi mathvariant="normal">𝔼</mi>'),
        (r"\mathbb R", '<mi mathvariant="normal">ℝ</mi>'),
        (r"\mathcal N", '<mi mathvariant="normal">𝒩</mi>'),
        (r"\ln 2", '<mi>ln</mi><mspace width="0.1667em"></mspace><mn>2</mn>'),
        (r"\ln(", '<mi>ln</mi><mo stretchy="false">(</mo>'),
        (r"\tilde R", '<mover accent="true"><mi>R</mi><mo stretchy="false">˜</mo></mover>'),
        (r"w =", '<mi>w</mi><mo rspace="0">=</mo>'),
        (r"u_{\max}", "<msub><mi>u</mi><mi>max</mi></msub>"),
    ],
)
def test_what_mathml_core_leaves_out_is_put_right(tex: str, drawn: str) -> None:
    assert mathml(tex) == drawn


def test_the_bars_of_a_norm_stand_close() -> None:
    bar = '<mo stretchy="false" lspace="0" rspace="0">∥</mo>'
    assert mathml(r"\lVert r\rVert") == f"{bar}<mi>r</mi>{bar}"
    assert "lspace" not in mathml(r"R \mid t")


def test_columns_are_aligned_by_the_style_sheet() -> None:
    drawn = mathml(r"\begin{aligned} a &= b \\ c &= d \end{aligned}", display=True)
    assert re.findall(r'mtd class="(\S+)"', drawn) == ["rs-right", "rs-left"] * 2


def test_punctuation_stays_with_a_formula_in_a_line() -> None:
    before = r'(<span class="math notranslate nohighlight">\(x\)</span>), so'
    after = robust_slam_math.with_formulas(before, pytest.fail)
    assert re.fullmatch(
        r'<span class="rs-kept">\(<span class="math"><math.*</span>\),</span> so', after
    )


def test_a_formula_that_cannot_be_read_ends_the_build(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(r'<span class="math notranslate nohighlight">\(\frac{1\)</span>')
    (tmp_path / "_static").mkdir()
    builder = SimpleNamespace(format="html", get_outfilename=lambda _: path)
    env = SimpleNamespace(found_docs=["page"])
    app = SimpleNamespace(builder=builder, env=env, outdir=tmp_path)
    with pytest.raises(ExtensionError, match=r"page: .*KaTeX parse error.*frac"):
        robust_slam_math.render(app, None)


@pytest.mark.browser
def test_formulas_need_no_script_and_have_the_font_of_the_book(
    site: Site, browser: Browser
) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((site.folder / "chapters/05-gnc.html").as_uri())
    root = page.locator("msqrt").first.bounding_box()
    inner = page.locator("msqrt > *").first.bounding_box()
    session = context.new_cdp_session(page)
    document = session.send("DOM.getDocument")["root"]["nodeId"]
    session.send("CSS.enable")
    node = session.send("DOM.querySelector", {"nodeId": document, "selector": "article math mi"})
    fonts = session.send("CSS.getPlatformFontsForNode", node)["fonts"]
    assert [font["familyName"] for font in fonts] == ["STIX Two Math"]
    # Chromium would leave half an em at the right if the signs of roots had different widths.
    assert root and inner
    assert root["x"] + root["width"] - inner["x"] - inner["width"] < 2
    context.close()
