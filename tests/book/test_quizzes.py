"""The quizzes of the chapters in Chromium."""

import json
import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.book.conftest import CHAPTERS, place
from tests.book.test_accessible import COLOURS, DARK, STILL, complaints, leave_alone
from tests.chromium import visiting

pytestmark = [pytest.mark.browser, pytest.mark.rest]

ONE, OTHER = CHAPTERS[-1], CHAPTERS[0]
VERDICT = re.compile(r"(✓ Right\.|✗ No\.) .+", re.S)
REFUSED = """Object.defineProperty(window, "localStorage", {
  get() { throw new DOMException("refused", "SecurityError"); },
})"""
CHOOSE_ALL = """() => Array.from(document.querySelectorAll(".rs-quiz fieldset"), (question) => {
  const shown = () => [...question.querySelectorAll("p")].filter(
    (answer) => answer.checkVisibility({visibilityProperty: true})).map((p) => p.innerText);
  return [shown(), Array.from(question.querySelectorAll(".rs-option"), (option) => {
    option.querySelector("label").click();
    return [option.querySelector("p").innerText, shown()];
  })];
})"""
"""What each question shows before it is answered, and the answer of each option with what is then
shown."""
KEPT = "localStorage.getItem('robust-slam-progress')"


def questions(page: Page) -> list[Locator]:
    """The questions of a page, of which there are several."""
    found = page.locator(".rs-quiz fieldset").all()
    assert len(found) > 1
    return found


def choose(question: Locator, kind: str) -> None:
    """Choose the first option that is right ("right") or wrong ("wrong")."""
    verdict = {"right": ".rs-correct", "wrong": ".rs-incorrect"}[kind]
    option = question.locator(".rs-option", has=question.page.locator(verdict)).first
    option.locator("input").check()


def chosen(page: Page) -> int:
    """How many options of a page are chosen."""
    return page.locator(".rs-quiz :checked").count()


def ticks(page: Page) -> list[str]:
    """The titles in the sidebar that carry a tick."""
    return page.locator(".bd-links a:has(.rs-done)").all_inner_texts()


@pytest.fixture(scope="module")
def page(site, browser):
    """A chapter, open while its quiz is answered in several ways."""
    url = (site.folder / f"{ONE}.html").as_uri()
    with visiting(browser, url, color_scheme="light") as visit:
        yield visit.page


def test_every_option_answers_when_it_is_chosen(page):
    asked = page.evaluate(CHOOSE_ALL)
    assert len(asked) > 1
    for before, options in asked:
        assert before == []
        for answer, shown in options:
            assert shown == [answer] and VERDICT.match(answer)
    assert chosen(page) == len(asked)
    aligned = "all => [...new Set(all.map((answer) => getComputedStyle(answer).textAlign))]"
    assert page.locator(".rs-quiz p").evaluate_all(aligned) == ["start"]


def test_it_is_answered_by_mouse_and_keyboard_and_enter_leaves_it_there(page):
    before, question = page.url, questions(page)[0]
    question.locator("label").nth(1).click()
    expect(question.locator("p").nth(1)).to_be_visible()
    question.locator("input").first.press("Space")
    expect(question.locator("p").nth(0)).to_be_visible()
    page.keyboard.press("ArrowDown")
    expect(question.locator("p").nth(0)).to_be_visible()
    page.keyboard.press("Space")
    expect(question.locator("p").nth(0)).to_be_hidden()
    expect(question.locator("p").nth(1)).to_be_visible()
    page.keyboard.press("Enter")
    expect(question.locator("p").nth(1)).to_be_visible()
    assert page.url == before


def test_on_paper_nothing_is_answered(page):
    seen = page.locator(".rs-quiz :is(p, button):visible")
    assert seen.count() > 1
    page.emulate_media(media="print")
    expect(seen).to_have_count(0)
    expect(questions(page)[0].locator("label").first).to_be_visible()
    page.emulate_media(media="screen")


def test_answers_are_open_to_all(page):
    leave_alone(page, ".rs-quiz")
    for question in questions(page):
        choose(question, "right")
    choose(questions(page)[0], "wrong")
    for options, theme in (("", "0"), (COLOURS, DARK)):
        page.evaluate(theme)
        page.evaluate(STILL)
        places = {place for _, place in complaints(page, options)}
        assert not [place for place in places if "rs-" in place or "input" in place]


@pytest.mark.parametrize("name", CHAPTERS)
def test_every_question_has_a_name_one_right_option_and_answers(name, site):
    found = site.parsed(name).select(".rs-quiz fieldset")
    assert len(found) > 1
    for question in found:
        assert question.legend.get_text().strip() and len(question.select(".rs-correct")) == 1
        answers = [option.p.get_text().strip() for option in question.select(".rs-option")]
        assert len(answers) > 1 and all(map(VERDICT.match, answers))


def test_without_scripts_every_option_answers(site, open_page):
    page = open_page((site.folder / f"{ONE}.html").as_uri(), java_script_enabled=False).page
    for question in questions(page):
        for kind, verdict in (("right", "✓ Right."), ("wrong", "✗ No.")):
            choose(question, kind)
            expect(question.locator("p:visible")).to_have_count(1)
            expect(question.locator("p:visible")).to_contain_text(verdict)
    assert page.locator(".rs-forget").count() == 0


def test_choices_and_the_tick_last_until_they_are_forgotten(address, site, open_page):
    visit = open_page(place(site, address, ONE, "http"), viewport={"width": 1280, "height": 900})
    page = visit.page
    asked = questions(page)
    for question in asked[:-1]:
        choose(question, "right")
    choose(asked[-1], "wrong")
    assert ticks(page) == []
    choose(asked[-1], "right")
    [titled] = ticks(page)
    assert titled.endswith("✓")
    choose(asked[0], "wrong")
    assert ticks(page) == []
    choose(asked[0], "right")
    tick = page.get_by_role("img", name="quiz done")
    expect(tick).to_have_count(1)

    page.reload()
    assert chosen(page) == page.locator(".rs-quiz .rs-correct:visible").count() == len(asked)
    assert ticks(page) == [titled]

    page.goto(place(site, address, OTHER, "http"))
    assert (chosen(page), ticks(page)) == (0, [titled])
    page.get_by_role("button", name="Forget my progress").click()
    assert (ticks(page), page.evaluate(KEPT)) == ([], None)
    expect(page.locator(".rs-forget [role=status]")).to_contain_text("are forgotten")
    page.go_back()
    assert (chosen(page), ticks(page)) == (0, [])
    assert visit.complaints == visit.outside == []


def test_a_prediction_is_remembered_and_is_no_part_of_the_quiz(address, site, open_page):
    visit = open_page(place(site, address, OTHER, "http"), viewport={"width": 1280, "height": 900})
    page = visit.page
    prediction = page.locator(".rs-predict").first
    answer = prediction.locator("p:visible")
    prediction.locator("label").first.click()
    page.reload()
    expect(answer).to_contain_text("The 33 steps between its ends")
    for question in questions(page):
        choose(question, "right")
    assert len(ticks(page)) == 1
    kept = page.evaluate(KEPT)
    page.locator(".rs-picture [data-control=reset]").first.click()
    page.wait_for_function(f"{KEPT} !== {json.dumps(kept)}")
    page.reload()
    expect(answer).to_have_count(0)
