"""What a student reads: plain sentences, the hint and no more, and a page that is only read."""

from __future__ import annotations

import functools
import http.server
import itertools
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from docutils.nodes import make_id
from hypothesis import given
from robust_slam_autograder import cli
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading.results import Result, without_grade
from robust_slam_autograder.markup import visible
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.assignment import Config
from robust_slam_autograder.reports import feedback, rendering
from robust_slam_autograder.reports.feedback import Book

from tests.autograder import toy
from tests.autograder.reports import samples
from tests.autograder.test_markup import ANY_TEXT, GITHUB, TEXTS
from tests.chromium import Opener, QuietHandler, Visit

ROOT = Path(__file__).parents[3]
# The public course has the release in place of the instructor's sources.
ASSIGNMENTS = ROOT / ("solutions" if (ROOT / "solutions").is_dir() else "assignments")
SITE = "https://example.org/course/"
CONFIG = Config(
    title="Twice, and *again*", chapter="07-toy", sections={"apply": "Half, or no half"}
)
Render = Callable[[feedback.Page], str]
RENDERED = pytest.mark.parametrize("render", [rendering.html, rendering.markdown])


def page(result: Result, config: Config = CONFIG, site: str = SITE) -> feedback.Page:
    return feedback.page(result, config, Book(site))


class Skeleton(HTMLParser):
    """A page's tags with their attributes, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, Any]] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, attrs))

    def handle_endtag(self, tag: str) -> None:
        self.tags.append((f"/{tag}", None))

    def handle_comment(self, data: str) -> None:
        self.tags.append(("comment", None))

    def handle_data(self, data: str) -> None:
        self.text += data


class TestWords:
    """What the content says."""

    def test_each_status_has_a_meaning_and_all_but_passed_an_advice(self) -> None:
        shown = page(samples.result(*samples.EVERY_STATUS))
        assert [exercise.outcome for exercise in shown.exercises] == [
            "✓ passed",
            "✗ partial",
            "✗ timeout",
            "✗ died",
            "✗ missing",
            "✗ failed",
        ]
        assert all(exercise.meaning.endswith(".") for exercise in shown.exercises)
        assert [bool(exercise.advice) for exercise in shown.exercises] == [False] + [True] * 5
        assert shown.start == shown.exercises[1]

    def test_a_case_has_a_word_its_points_and_its_message(self) -> None:
        (exercise,) = page(samples.result(samples.PARTLY)).exercises
        first, second = exercise.cases
        assert (first.outcome, first.points, first.message) == ("✓ passed", "5 of 5 points", "")
        assert (second.outcome, second.points) == ("✗ failed", "0 of 5 points")
        assert second.message == "Add the ½."
        assert not first.other_inputs and second.other_inputs

    def test_one_point_is_a_point(self) -> None:
        one = samples.exercise("e", "passed", samples.case("c", points=1))
        assert page(samples.result(one)).exercises[0].points == "1 of 1 point"

    def test_a_message_is_told_once(self) -> None:
        (stub,) = page(samples.result(samples.UNWRITTEN)).exercises
        assert [(c.message, c.as_above) for c in stub.cases] == [
            ("Not written.", False),
            ("", True),
        ]
        assert stub.message == ""

    def test_what_comes_after_a_fault_was_not_run(self) -> None:
        (hung,) = page(samples.result(samples.HUNG)).exercises
        assert [c.outcome for c in hung.cases] == ["✓ passed", "✗ failed", "✗ not run"]
        assert [c.message for c in hung.cases] == ["", samples.SLOW, ""]
        assert [c.other_inputs for c in hung.cases] == [True, True, False]

    def test_an_exercise_says_what_no_case_does(self) -> None:
        (gone,) = page(samples.result(samples.MISSING)).exercises
        assert gone.message == "No cell."

    def test_all_passed_is_said_where_hidden_checks_ran_alone(self) -> None:
        assert page(samples.result(samples.PASSED)).verdict.startswith("All checks passed")
        visible_only = samples.exercise("e", "passed", samples.case("c", visible=True))
        shown = page(samples.result(visible_only))
        assert shown.verdict == "Public checks passed: 1 of 1 exercises."
        assert shown.exercises[0].meaning == "The public checks passed."
        assert "All" not in rendering.markdown(shown) + rendering.html(shown)

    def test_a_refusal_has_its_reason_and_the_fix(self) -> None:
        shown = page(samples.refused("a.ipynb is not valid JSON: save it again."))
        assert shown.note == "a.ipynb is not valid JSON: save it again."
        assert (shown.note_kind, shown.score, shown.max_score) == ("Reason", "0", "20")
        assert "hand it in again" in shown.next

    def test_why_the_grader_failed_is_not_the_students(self) -> None:
        why = "The instructor's cell, set-up 1, fails: 0.1234."
        failed = without_grade("failed", why, student="ada", assignment="07-toy", max_score=20)
        shown = page(failed)
        assert "not to blame" in shown.verdict and "nothing" in shown.next
        assert "0.1234" not in rendering.html(shown) + rendering.markdown(shown)

    @RENDERED
    def test_seconds_and_sandbox_are_in_no_page(self, render: Render) -> None:
        slow = samples.result(*samples.EVERY_STATUS, seconds=1234.5, sandbox="bubblewrap")
        quick = replace(slow, seconds=0.25, sandbox="fork")
        assert render(page(slow)) == render(page(quick))


class TestChapter:
    """The way back to the chromium."""

    def test_with_a_site_it_is_a_link_to_the_section(self) -> None:
        shown = page(samples.result(samples.PASSED, samples.PARTLY, samples.HUNG))
        passed, partly, hung = shown.exercises
        base = "https://example.org/course/chapters/07-toy.html"
        assert passed.reading is None
        assert partly.reading == feedback.Reading(
            "chapter 07-toy, “Half, or no half”", f"{base}#half-or-no-half"
        )
        assert hung.reading == feedback.Reading("chapter 07-toy", base)
        assert f'href="{base}#half-or-no-half"' in rendering.html(shown)
        assert f"](<{base}#half-or-no-half>)" in rendering.markdown(shown)

    def test_a_path_from_the_page_is_a_site_too(self) -> None:
        (partly,) = page(samples.result(samples.PARTLY), site="../../html").exercises
        assert partly.reading is not None
        assert partly.reading.address == "../../html/chapters/07-toy.html#half-or-no-half"

    def test_without_a_site_it_is_a_name(self) -> None:
        shown = page(samples.result(samples.PARTLY), site="")
        assert "chapter 07-toy, “Half, or no half”" in rendering.html(shown)
        assert "href=" in rendering.html(shown) and "07-toy.html" not in rendering.html(shown)
        assert "](" not in rendering.markdown(shown)

    def test_without_a_chapter_there_is_none(self) -> None:
        (partly,) = page(samples.result(samples.PARTLY), Config()).exercises
        assert partly.reading is None

    def test_sections_are_of_exercises_that_there_are(self, tmp_path: Path) -> None:
        tree = toy.make_tree(tmp_path, '[sections]\ndoubel = "A heading"\n')
        with pytest.raises(WrongUse, match=r"names 'doubel'; the exercises are double, apply"):
            assignments.load(tree / toy.NAME / f"{toy.NAME}.ipynb")
        config = tree / toy.NAME / assignments.CONFIG_NAME
        config.write_text("[sections]\ndouble = 1\n")
        with pytest.raises(WrongUse, match="double has a value of the wrong type"):
            assignments.load_config(config)


def has_a_chapter(name: str) -> bool:
    config = assignments.load_config(ASSIGNMENTS / name / assignments.CONFIG_NAME)
    return (ROOT / "chapters" / f"{config.chapter}.ipynb").is_file()


COURSE = [name for name in assignments.find_names(ASSIGNMENTS) if has_a_chapter(name)]


@pytest.mark.parametrize("name", COURSE)
class TestCourse:
    """The course's own assignments and chapters."""

    def test_every_exercise_names_a_heading_of_its_chapter(self, name: str) -> None:
        loaded = assignments.load(ASSIGNMENTS / name / f"{name}.ipynb")
        assert set(loaded.config.sections) == set(loaded.exercises)
        headings = chapter_headings(loaded.config.chapter)
        for heading in loaded.config.sections.values():
            assert headings.count(heading) == 1, heading

    def test_the_site_has_the_sections_that_pages_link_to(self, name: str) -> None:
        config = assignments.load_config(ASSIGNMENTS / name / assignments.CONFIG_NAME)
        built = ROOT / "build" / "html" / "chapters" / f"{config.chapter}.html"
        assert built.is_file(), "build the site first: make book"
        ids = {
            dict(attrs).get("id")
            for tag, attrs in Skeleton(built.read_text(encoding="utf-8")).tags
            if tag == "section"
        }
        assert {feedback.anchor(heading) for heading in config.sections.values()} <= ids

    def test_anchors_follow_the_books_rule(self, name: str) -> None:
        config = assignments.load_config(ASSIGNMENTS / name / assignments.CONFIG_NAME)
        headings = chapter_headings(config.chapter)
        assert len(headings) > 10
        assert [feedback.anchor(each) for each in headings] == [make_id(each) for each in headings]


def chapter_headings(chapter: str) -> list[str]:
    notebook = json.loads((ROOT / "chapters" / f"{chapter}.ipynb").read_text(encoding="utf-8"))
    cells = (cell for cell in notebook["cells"] if cell["cell_type"] == "markdown")
    lines = (line for cell in cells for line in "".join(cell["source"]).split("\n"))
    return [line.lstrip("#").strip() for line in lines if line.startswith("#")]


class TestInjection:
    """Whatever a student writes, the page's structure is the same and the text is to be read."""

    @TEXTS
    def test_hostile_text_makes_no_tag(self, text: str) -> None:
        shown = Skeleton(rendering.html(page(samples.told(text))))
        wanted = Skeleton(rendering.html(page(samples.told("harmless"))))
        assert shown.tags == wanted.tags
        assert shown.text.count(visible(text)) >= 4

    @given(ANY_TEXT)
    def test_no_text_makes_a_tag(self, text: str) -> None:
        if text:
            shown = Skeleton(rendering.html(page(samples.told(text))))
            assert shown.tags == Skeleton(rendering.html(page(samples.told("harmless")))).tags

    @TEXTS
    def test_hostile_text_makes_no_markdown(self, text: str) -> None:
        if text.strip():
            assert markdown_shape(text) == markdown_shape("harmless")

    @given(ANY_TEXT)
    def test_no_text_makes_markdown(self, text: str) -> None:
        if text.split():
            assert markdown_shape(text) == markdown_shape("harmless")

    def test_markdown_has_the_chapters_links_and_no_others(self) -> None:
        text = rendering.markdown(page(samples.told(" ".join(samples.HOSTILE.values()))))
        children = [child for block in GITHUB.parse(text) for child in block.children or []]
        links = [child.attrs["href"] for child in children if child.type == "link_open"]
        assert links == ["https://example.org/course/chapters/07-toy.html"] * 2
        assert not any(child.type in ("html_inline", "image") for child in children)


def markdown_shape(text: str) -> list[str]:
    blocks = GITHUB.parse(rendering.markdown(page(samples.told(text))))
    return [token.type for block in blocks for token in (block, *(block.children or []))]


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run ``feedback`` on a graded class's folder: exit status, output, errors."""

    def command(*arguments: object) -> tuple[int, str, str]:
        where = ["--out", tmp_path / "graded", "--to", tmp_path / "feedback"]
        tree = ["--solutions", str(tmp_path / "solutions")]
        try:
            status = cli.main([*tree, "feedback", *map(str, [*where, *arguments])])
        except SystemExit as error:  # how argparse ends
            status = int(error.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return command


@pytest.fixture
def graded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a source tree and results of three students, one of them hostile."""
    monkeypatch.setattr("robust_slam_autograder.commands.grade.record", lambda *_: None)
    config = 'title = "Twice"\nchapter = "07-toy"\nwithheld = ["xml.dom"]\n'
    tree = toy.make_tree(tmp_path, config)
    paths = [
        toy.hand_in(tmp_path / "submitted", student, value)
        for student, value in {
            "ada": toy.answer(),
            "ben": toy.answer("def double(x):\n    return 2 * abs(np.asarray(x))\n"),
            "<b>cleo": toy.answer(TELLS),
        }.items()
    ]
    where = ["--out", str(tmp_path / "graded"), "--unsandboxed", "--seed", str(SEED)]
    assert cli.main(["--solutions", str(tree), "grade", *where, *map(str, paths)]) == 0
    return tmp_path


SEED = 20_261
# Tells what it was called with, wherever a message may come from.
TELLS = """\
def double(x):
    raise ValueError(f"<script>{np.asarray(x).tolist()}</script> [x](http://evil.example)")
"""


class TestCommand:
    def test_each_submission_has_two_files(self, graded: Path, run: Run) -> None:
        status, out, _ = run("--site", SITE)
        assert (status, out) == (
            0,
            f"feedback on 3 submissions of 3 students: {graded / 'feedback'}\n",
        )
        found = {path.relative_to(graded / "feedback") for path in graded.rglob("feedback/*/*")}
        names = itertools.product(("ada", "ben", "<b>cleo"), (".html", ".md"))
        assert found == {Path(student, toy.NAME + end) for student, end in names}
        text = (graded / "feedback" / "ben" / f"{toy.NAME}.md").read_text(encoding="utf-8")
        assert text.startswith("## Twice: 14 of 20 points\n\nStudent: `ben`\n")
        assert "(0 of 6 points, checked with other inputs too): `Try negative numbers.`" in text
        assert "https://example.org/course/chapters/07-toy.html" in text

    def test_no_page_tells_what_is_hidden(self, graded: Path, run: Run) -> None:
        assert run()[0] == 0
        texts = [path.read_text(encoding="utf-8") for path in graded.rglob("feedback/*/*")]
        seconds = [str(toy.result(graded / "graded", s)["seconds"]) for s in ("ada", "ben")]
        secrets = [toy.CANARY, "rng.normal", str(SEED), *toy.hidden_inputs(SEED), *seconds]
        assert len(texts) == 6 and len(secrets) == 10
        assert not [secret for secret in secrets for text in texts if secret in text]
        assert any("ValueError: &lt;script&gt;3&lt;/script&gt;" in text for text in texts)

    def test_a_student_may_be_named(self, graded: Path, run: Run) -> None:
        status, out, _ = run("ada")
        assert status == 0 and "on 1 submissions of 1 students" in out
        assert [path.name for path in (graded / "feedback").iterdir()] == ["ada"]

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (["eve"], "holds no result of eve: grade that submission first"),
            (["--out", "nowhere"], "nowhere holds no result: grade first"),
            (["--site", "javascript:alert(1)"], "an address https://…, or a path"),
        ],
    )
    def test_wrong_use_is_told(
        self, graded: Path, run: Run, arguments: list[str], sentence: str
    ) -> None:
        status, out, err = run(*arguments)
        assert status == 2 and sentence in err and out == ""
        assert not (graded / "feedback").exists()

    def test_a_place_that_cannot_be_written_is_named(self, graded: Path, run: Run) -> None:
        (graded / "taken").write_text("a file")
        status, out, err = run("--to", graded / "taken")
        assert (status, out) == (1, "")
        path = graded / "taken" / "<b>cleo" / f"{toy.NAME}.html"
        assert err == (
            f"autograder: {path} cannot be written (Not a directory): make room or make its "
            "folder writable, or choose another with --to DIR.\n"
        )

    @pytest.mark.parametrize("text", ["{", "[]", '{"schema": 1}', '{"schema": 1, "exercises": 7}'])
    def test_a_file_that_is_no_result_is_named(self, graded: Path, run: Run, text: str) -> None:
        (graded / "graded" / "ada" / f"{toy.NAME}.json").write_text(text)
        status, _, err = run()
        assert status == 2 and f"{toy.NAME}.json is no result file" in err


# In the browser

SCHEMES = ("light", "dark")
WAYS = ("http", "file")
PAGES = {
    "every-status": samples.result(*samples.EVERY_STATUS, reason="A cell was copied."),
    "passed": samples.result(samples.PASSED),
    "refused": samples.refused("07-toy.ipynb is not valid JSON: save it again from JupyterLab."),
    "hostile": samples.result(
        *(samples.told(text).exercises[0] for text in samples.HOSTILE.values()),
        student=" ".join(samples.HOSTILE.values()),
        reason="\n".join(samples.HOSTILE.values()),
    ),
}

# WCAG 2.2: the contrast of each piece of text with what is behind it; those below 4.5.
LOW_CONTRAST = """() => {
  const parse = text => text.match(/[\\d.]+/g).map(Number);
  const light = color => parse(color).slice(0, 3)
    .map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, n) => sum + v * [0.2126, 0.7152, 0.0722][n], 0);
  const behind = node => {
    for (; node; node = node.parentElement) {
      const color = getComputedStyle(node).backgroundColor;
      if (parse(color)[3] !== 0) return color;
    }
    return "rgb(255, 255, 255)";
  };
  const low = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const text = walk.currentNode.data.trim(), node = walk.currentNode.parentElement;
    if (!text) continue;
    const pair = [light(getComputedStyle(node).color), light(behind(node))].sort((a, b) => b - a);
    if ((pair[0] + 0.05) / (pair[1] + 0.05) < 4.5) low.push(text);
  }
  return low;
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("feedback")
    for name, result in PAGES.items():
        (made / f"{name}.html").write_text(rendering.html(page(result)), encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def served(folder: Path) -> Iterator[str]:
    handler = functools.partial(QuietHandler, directory=folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(params=list(itertools.product(PAGES, SCHEMES)), ids="-".join)
def visit(request: pytest.FixtureRequest, folder: Path, open_page: Opener) -> Visit:
    name, scheme = request.param
    return open_page((folder / f"{name}.html").as_uri(), color_scheme=scheme)


@pytest.mark.browser
class TestPage:
    """The page in Chromium."""

    def test_it_is_quiet_asks_for_nothing_and_is_read_by_all(self, visit: Visit) -> None:
        page = visit.page
        assert (visit.complaints, visit.outside) == ([], [])
        assert page.evaluate("performance.getEntriesByType('resource').length") == 0
        assert page.evaluate("document.scripts.length + document.images.length") == 0
        assert "feedback for" in page.title()
        assert page.evaluate(LOW_CONTRAST) == []

    @pytest.mark.parametrize("way", WAYS)
    def test_it_asks_for_itself_alone(
        self, folder: Path, served: str, open_page: Opener, way: str
    ) -> None:
        base = served if way == "http" else folder.as_uri()
        visit = open_page("about:blank")
        asked: list[str] = []
        visit.page.on("request", lambda request: asked.append(request.url))
        visit.page.goto(f"{base}/every-status.html")
        assert asked == [f"{base}/every-status.html"]
        assert visit.complaints == []

    def test_it_fits_a_phone(self, visit: Visit) -> None:
        visit.page.set_viewport_size({"width": 390, "height": 844})
        assert visit.page.evaluate("document.documentElement.scrollWidth") <= 390

    def test_landmarks_headings_and_tables_say_what_they_are(self, visit: Visit) -> None:
        page = visit.page
        assert page.evaluate("document.documentElement.lang") == "en"
        assert page.locator("header").count() == page.locator("main").count() == 1
        levels = page.evaluate("[...document.querySelectorAll('h1,h2,h3')].map(h => h.tagName)")
        assert levels[0] == "H1" and set(levels[1:]) == {"H2"}
        assert page.locator("th:not([scope])").count() == 0
        named = "[...document.querySelectorAll('[aria-labelledby]')].every(n =>"
        assert page.evaluate(
            f"{named} document.getElementById(n.getAttribute('aria-labelledby')))"
        )
        ids = page.evaluate("[...document.querySelectorAll('[id]')].map(n => n.id)")
        assert len(ids) == len(set(ids))

    def test_keys_lead_to_the_exercise_to_start_with(
        self, folder: Path, open_page: Opener
    ) -> None:
        page = open_page((folder / "every-status.html").as_uri()).page
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.textContent") == "apply"
        page.keyboard.press("Enter")
        assert page.url.endswith("#exercise-2")
        assert page.locator("#exercise-2").text_content() == "apply"

    def test_on_paper_all_is_dark_on_white(self, folder: Path, open_page: Opener) -> None:
        page = open_page((folder / "every-status.html").as_uri(), color_scheme="dark").page
        page.emulate_media(media="print", color_scheme="dark")
        colour = "getComputedStyle(document.body).backgroundColor"
        assert page.evaluate(colour) == "rgb(255, 255, 255)"
        assert page.evaluate(LOW_CONTRAST) == []

    def test_a_page_that_would_not_do_is_found(self, tmp_path: Path, open_page: Opener) -> None:
        """The policy stops what autoescape would have let through, and grey on grey is seen."""
        text = rendering.html(page(samples.told("A MESSAGE")))
        bad = text.replace("A MESSAGE", "<script>document.title = 'taken'</script>")
        bad = bad.replace("</header>", "<p id=grey><font color=#999>grey</font></p></header>")
        path = tmp_path / "bad.html"
        path.write_text(bad, encoding="utf-8")
        visit = open_page(path.as_uri(), color_scheme="light")
        assert visit.page.title() != "taken"
        assert any("Content Security Policy" in said for said in visit.complaints)
        assert visit.page.evaluate(LOW_CONTRAST) == ["grey"]
