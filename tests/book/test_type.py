"""The letters of the pages are light, complete and the same over file://; nothing moves."""

from __future__ import annotations

import base64
import io
import re

import pytest
from fontTools.ttLib import TTFont

from chapters._ext import robust_slam_type
from tests.book.conftest import WAYS, Site, place
from tests.chromium import Opener

SHIFT = """() => new Promise((done) => {
  let sum = 0;
  new PerformanceObserver((list) => {
    for (const entry of list.getEntries()) sum += entry.value;
  }).observe({type: "layout-shift", buffered: true});
  setTimeout(() => done(sum), 300);
})"""


@pytest.fixture(scope="module")
def fonts() -> list[bytes]:
    style = robust_slam_type.style_sheet()
    return [base64.b64decode(font) for font in re.findall(r"base64,([^)]*)[)]", style)]


def test_the_fonts_are_light(fonts: list[bytes]) -> None:
    assert len(fonts) == len(robust_slam_type.FACES)
    assert sum(map(len, fonts)) <= 60_000


def test_a_font_has_its_licence_and_not_the_name_that_is_reserved(fonts: list[bytes]) -> None:
    for font in fonts:
        names = TTFont(io.BytesIO(font))["name"]
        assert "SIL Open Font License" in names.getDebugName(13)
        assert "Adobe" in names.getDebugName(0) and "Source" not in names.getDebugName(1)


@pytest.mark.browser
@pytest.mark.parametrize("name", ["chapters/03-irls", "chapters/errata"])
@pytest.mark.parametrize("way", WAYS)
def test_a_page_is_drawn_in_them_and_keeps_its_shape(
    way: str, name: str, site: Site, address: str, open_page: Opener
) -> None:
    visit = open_page(place(site, address, name, way))
    loaded = "[...document.fonts].filter(f => f.status === 'loaded').map(f => f.family)"
    visit.page.evaluate("document.fonts.ready")
    families = {family.strip('"') for family in visit.page.evaluate(loaded)}
    assert {robust_slam_type.SANS, robust_slam_type.SERIF} <= families
    assert visit.page.evaluate(SHIFT) < 0.02
    assert visit.complaints == []
