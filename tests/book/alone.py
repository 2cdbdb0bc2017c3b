"""A part of a page without the rest: axe-core takes long where there is much to look at."""

from playwright.sync_api import Page

_ALONE = """(part) => {
  for (const each of document.querySelectorAll("article section > *")) {
    const belongs = each.matches("h1") || each.closest(part) || each.querySelector(part);
    if (!belongs) each.remove();
  }
}"""


def leave_alone(page: Page, part: str) -> None:
    """Take all out of the text that is beside the parts that a selector names, but for the title.

    What a page has around its text stays, as do its colours.
    """
    page.evaluate(_ALONE, part)
