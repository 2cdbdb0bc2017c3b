"""Formulas leave the build as MathML that browsers draw, with signs that the font has."""

import io
import re
import xml.etree.ElementTree as etree
from functools import cache

import pytest
from fontTools.ttLib import TTFont
from playwright.sync_api import FloatRect, Page

from chapters._ext import formulas
from tests.book.conftest import PAGES, Site
from tests.chromium import page_in

MATHML = re.compile(r"<math\b.*?</math>", re.DOTALL)
CHILDREN = {"msub": 2, "msup": 2, "mfrac": 2, "munder": 2, "mover": 2, "msubsup": 3}
CORE = {
    *("math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "mstyle", "mpadded"),
    *("mfrac", "msqrt", "mroot", "msub", "msup", "msubsup", "munder", "mover", "munderover"),
    *("mtable", "mtr", "mtd"),
}
"""Elements of MathML Core, which browsers draw alike."""
NOT_DRAWN = {"\ufe00"}
"""Chooses among script letters where a font has two kinds."""


def trees(site: Site, page: str) -> list[etree.Element]:
    html = (site.folder / f"{page}.html").read_text(encoding="utf-8")
    return [etree.fromstring(formula) for formula in MATHML.findall(html)]


@cache
def held(font: bytes) -> set[str]:
    return set(map(chr, TTFont(io.BytesIO(font)).getBestCmap()))


@pytest.mark.parametrize("page", PAGES)
class TestPage:
    def test_no_formula_is_left_in_tex(self, page, site):
        html = (site.folder / f"{page}.html").read_text(encoding="utf-8")
        article = html[html.index("<article") : html.index("</article>")]
        assert len(re.findall(r'class="math[ "]', html)) == len(MATHML.findall(html))
        text = re.sub(r"<pre.*?</pre>", "", article, flags=re.S)
        assert not re.findall(r"\\\(|\\\[|\\begin\{", text)

    def test_browsers_draw_its_elements_in_the_courses_font(self, page, site, carried):
        found = trees(site, page)
        for element in (element for formula in found for element in formula.iter()):
            assert element.tag in CORE
            assert len(element) == CHILDREN.get(element.tag, len(element))
        signs = set("".join("".join(formula.itertext()) for formula in found)) - NOT_DRAWN
        assert {sign for sign in signs if not sign.isspace()} <= held(carried[-1])


def test_more_room_above_a_line_is_left_out_and_formulas_in_the_html_of_cells_are_read():
    tex = r"\begin{aligned} a &= b \\[6pt] c &= d \end{aligned}"
    assert formulas.mathml(tex, True) == formulas.mathml(tex.replace("[6pt]", ""), True)
    page = r'<i><div class="math notranslate">\[a &lt; b\]</div></i>'
    drawn = formulas.mathml("a < b", True)
    assert formulas.in_html(page, "page") == f'<i><div class="math">{drawn}</div></i>'


def test_a_formula_that_cannot_be_read_is_named_in_a_warning_with_its_place(monkeypatch):
    with pytest.raises(ValueError, match=r"closing.*In the formula '.*frac\{1'"):
        formulas.mathml(r"\frac{1", False)
    said: list[object] = []
    monkeypatch.setattr(formulas.LOGGER, "warning", lambda *_, location: said.append(location))
    page = r'<b>a</b> <span class="math notranslate">\(\frac{1 < 2\)</span>'
    assert formulas.in_html(page, "page") == r'<b>a</b> <span class="math">\frac{1 &lt; 2</span>'
    assert said == ["page"]


@pytest.mark.parametrize(
    ("before", "after", "kept"),
    [("so (", "), and", "({}),"), (" ", ", x", "{},"), (" ", " x", "")],
)
def test_punctuation_stays_with_a_formula_in_a_line(before, after, kept):
    formula = f'<span class="math">{formulas.mathml("x", False)}</span>'
    context = {"body": f"<p>{before}{formula}{after}</p>"}
    formulas.finish(None, "", "", context, None)
    found = re.findall(r'<span class="rs-kept">(.*?</span>.*?)</span>', context["body"])
    assert found == ([kept.format(formula)] if kept else [])


@pytest.fixture(scope="module")
def page(browser, site):
    with page_in(browser, java_script_enabled=False) as page:
        page.goto((site.folder / "chapters/03-irls.html").as_uri())
        yield page


def box(page: Page, part: str) -> FloatRect:
    """The place of the first part of a formula."""
    found = page.locator(part).first.bounding_box()
    assert found
    return found


def draw(page: Page, tex: str, display: bool) -> None:
    """Put a formula at the head of the page, in place of an earlier one."""
    page.evaluate(
        "(html) => document.querySelector('article').replaceChildren("
        "document.createRange().createContextualFragment(html))",
        formulas.mathml(tex, display),
    )


@pytest.mark.browser
def test_a_bracket_with_a_power_is_as_tall_as_its_partner(page):
    heights = page.locator("math:has(:is(msup, msub, msubsup) mo[minsize])").evaluate_all(
        """formulas => formulas.map(formula => [...formula.querySelectorAll("mo[minsize]")].map(
        bracket => bracket.getBoundingClientRect().height))"""
    )
    assert heights and all(max(own) < 1.05 * min(own) for own in heights)


@pytest.mark.browser
def test_formulas_need_no_script_and_have_the_font_of_the_book(page):
    root, inner = box(page, "msqrt"), box(page, "msqrt > *")
    session = page.context.new_cdp_session(page)
    document = session.send("DOM.getDocument")["root"]["nodeId"]
    session.send("CSS.enable")
    node = session.send("DOM.querySelector", {"nodeId": document, "selector": "article math mi"})
    drawn = session.send("CSS.getPlatformFontsForNode", node)["fonts"]
    assert [font["familyName"] for font in drawn] == ["STIX Two Math"]
    # Chromium would leave half an em at the right if the signs of roots had different widths.
    assert root["x"] + root["width"] - inner["x"] - inner["width"] < 2


@pytest.mark.browser
@pytest.mark.parametrize(
    ("tex", "upper", "lower"),
    [
        (r"\underbrace{g}_{w}", "mi", "mo"),
        (r"\begin{pmatrix} g \\ d \end{pmatrix}", "mtr:first-child mi", "mtr:last-child mi"),
    ],
)
def test_what_is_below_touches_nothing_above(tex, upper, lower, page):
    draw(page, tex, True)
    above, below = (box(page, f"article math {part}") for part in (upper, lower))
    assert above["y"] + above["height"] <= below["y"] + 0.5


@pytest.mark.browser
def test_fractions_side_by_side_have_a_bar_each(page):
    draw(page, r"\tfrac12\tfrac{a}{b}", False)
    first, second = page.locator("article mfrac").evaluate_all(
        """fractions => fractions.map((one) => {
        const parts = document.createRange();
        parts.selectNodeContents(one);
        const {left, right} = parts.getBoundingClientRect();
        return [left, right];
        })"""
    )
    assert second[0] - first[1] > 4
