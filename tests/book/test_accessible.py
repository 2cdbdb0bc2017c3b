"""How axe-core looks at a page; each of the site is looked at where it is open on a phone, too."""

from importlib.resources import files

import pytest
from playwright.sync_api import Page

pytestmark = [pytest.mark.browser, pytest.mark.rest]

WORDS_OF_BUTTONS = "rules: {'label-content-name-mismatch': {enabled: true}}"
"""What a button is called holds what is written on it: a rule that axe-core leaves out."""
COLOURS = "runOnly: ['color-contrast', 'link-in-text-block']"
"""What axe-core looks for in the dark: only the colours differ."""
LOOKS: list[str] = []
"""The looks of the texts of all pages so far, in both themes."""
Looks = list[str] | None
ALONE = """(part) => {
  for (const each of document.querySelectorAll("article section > *")) {
    const belongs = each.matches("h1") || each.closest(part) || each.querySelector(part);
    if (!belongs) each.remove();
  }
}"""
DARK = "document.documentElement.dataset.theme = 'dark'"
EACH_LOOK_ONCE = """(known) => {
  const looks = new Map(known.map((look, place) => [look, place]));
  const number = (...look) => {
    const key = look.join();
    if (!looks.has(key)) looks.set(key, looks.size);
    return looks.get(key);
  };
  const mark = (element, above, frame, flows) => {
    const style = getComputedStyle(element), box = element.getBoundingClientRect();
    const look = number(above, element.tagName, element.className, style.color, style.opacity,
      style.backgroundColor, style.backgroundImage, style.fontSize, style.fontWeight);
    flows &&= /static|relative/.test(style.position) && /^(auto|0px)$/.test(style.inset)
      && style.transform === "none" && !element.matches("svg, form, button, input, select, label");
    const shown = box.width && element.checkVisibility({visibilityProperty: true});
    const plain = flows && box.left >= frame.left && box.right <= frame.right
      && box.top >= frame.top && box.bottom <= frame.bottom;
    const said = [...element.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE)
      .map((node) => node.data.trim()).join("");
    const before = looks.size;
    if (said && shown && plain) number("text", look, /\\w\\w/.test(said) || said);
    const apart = shown && !plain && (said || element.matches("input, select"));
    const around = !element.closest("article") && [box.x, box.y, box.width, said];
    if (apart && around) number("around", look, ...around);
    element.toggleAttribute("data-look", (apart && !around) || looks.size > before);
    if (style.overflow !== "visible") frame = box;
    for (const child of element.children) mark(child, look, frame, flows);
  };
  const page = {left: 0, right: innerWidth, top: -Infinity, bottom: Infinity};
  mark(document.body, "", page, true);
  return [...looks.keys()];
}"""
"""Marks one of the texts that are drawn alike, on grounds drawn alike: the contrast of the others
is the same. What does not stand in the flow of the page, or not wholly in its box, is marked, but
around the article only once in one place; what is not shown is not: axe-core passes over it. It
is given looks that it need not mark, and returns them with those of this page."""
READY = """() => {
  axe.configure({noHtml: true, rules: [{id: "color-contrast", selector: "[data-look]"}]});
  const colour = axe.commons.color.Color.prototype, read = colour.parseString, known = new Map();
  colour.parseString = function (text) {
    if (!known.has(text)) {
      read.call(this, text);
      known.set(text, {r: this.r, g: this.g, b: this.b, alpha: this.alpha});
    }
    return Object.assign(this, known.get(text));
  };
}"""
"""axe-core looks at the marked texts, and reads each colour once."""
DRAWN_AS_ONE = """() => {
  window.drawn = [...document.querySelectorAll(".rs-figure svg")].map((figure) => {
    const parts = [...figure.childNodes];
    figure.replaceChildren();
    return [figure, parts];
  });
  for (const formula of document.querySelectorAll("math")) formula.replaceWith("formula");
  for (const sign of document.querySelectorAll(":is(pre, dt.sig) span:not([data-look])"))
    if (!sign.querySelector("[data-look]")) sign.replaceWith(sign.textContent);
}"""
"""A figure has tests of its own, a formula has one colour, and keywords look alike: axe-core would
look at each of their thousands of letters."""
DRAWN_AGAIN = "for (const [figure, parts] of window.drawn) figure.replaceChildren(...parts)"
STILL = """Promise.allSettled(document.getAnimations()
  .filter((each) => each.timeline instanceof DocumentTimeline)  // a line that scrolls never ends
  .map((each) => each.finished)).then(() => 0)"""
"""Resolves when nothing fades or moves any more."""


def leave_alone(page: Page, part: str) -> None:
    """Leave of the text its title and the parts that a selector names: axe-core takes long.

    What a page has around its text stays, as do its colours.
    """
    page.evaluate(ALONE, part)


def violations(page: Page, options: str = "", seen: Looks = None) -> list[dict[str, object]]:
    """What axe-core says against looks not seen yet; of what is well it keeps no record."""
    seen = [] if seen is None else seen
    if not page.evaluate("'axe' in window"):
        page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8"))
        page.evaluate(READY)
    seen[:] = page.evaluate(EACH_LOOK_ONCE, seen)
    ran = f"axe.run({{resultTypes: ['violations'], {options}}})"
    return page.evaluate(f"{ran}.then(ran => ran.violations)")


def complaints(
    page: Page, options: str = WORDS_OF_BUTTONS, seen: Looks = None
) -> set[tuple[str, str]]:
    """The rule and the place of each violation, however small, but in looks that were seen."""
    return {
        (str(violation["id"]), str(node["target"][0]))
        for violation in violations(page, options, seen)
        for node in violation["nodes"]
    }


def assert_open_to_all(page: Page) -> None:
    """Look at a page in the light and in the dark, but for looks that other pages had."""
    page.evaluate(STILL)
    page.evaluate(EACH_LOOK_ONCE, LOOKS)
    page.evaluate(DRAWN_AS_ONE)
    assert complaints(page, seen=LOOKS) == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert complaints(page, COLOURS, LOOKS) == set()
    page.evaluate(DRAWN_AGAIN)


def test_a_faint_colour_is_seen_in_the_dark_too(site, open_page):
    page = open_page((site.folder / "chapters/index.html").as_uri(), color_scheme="light").page
    page.add_style_tag(content="html[data-theme='dark'] .keyword { color: #222 }")
    page.evaluate("document.querySelector('article p').innerHTML = '<b class=keyword>word</b>'")
    assert complaints(page, COLOURS) == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert {rule for rule, _ in complaints(page, COLOURS)} == {"color-contrast"}
