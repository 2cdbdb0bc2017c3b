"""The class on the site: its pages show what they are for, and nothing that is secret."""

import html
import json
import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from bs4 import BeautifulSoup

from autograder.tests import kernel
from chapters._ext.offers import thumbnail
from solutions.classes import answers, shown_class
from solutions.classes.shown_class import ATTEMPTS, M_ESTIMATORS, ONE_LIE, SHOWN, TABLE
from tests import npm
from tests.book import test_valid_html
from tests.test_secrets import answer_lines, secret_lines

pytestmark = pytest.mark.rest

STUDENTS = [f"student-{n:02}" for n in range(1, 13)]
WHOLE_LINES = 16
"""Letters without spaces; shorter lines of code are alike by chance."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The class's folder as `make course` makes it: submitted, graded by all tests, and pages."""
    folder = tmp_path_factory.mktemp("shown") / "shown"
    wall = [] if kernel.usable() else ["--unsandboxed"]
    sandbox = folder.with_name("sandbox")
    sandbox.write_text(" ".join(wall))
    command = ["make", "-o", ".venv/.ready", f"SHOWN={folder}", f"SANDBOX={sandbox}"]
    environment = {name: value for name, value in os.environ.items() if "MAKE" not in name}
    done = subprocess.run(
        [*command, f"{folder}/.pages"],
        cwd=answers.ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    mine = [path for student in SHOWN for path in (folder / "submitted" / student).iterdir()]
    where = ["--out", folder / "visible", "--seed", 0, *wall]
    shown_class.autograder(folder / "release", "grade", *mine, *where)
    return folder


@pytest.fixture(scope="module")
def pages(made):
    found = sorted((made / "pages").rglob("*.*"))
    return {str(path.relative_to(made / "pages")): path.read_text("utf-8") for path in found}


def text(page: str) -> str:
    """What a reader sees, on one line."""
    page = re.sub(r"<(style|title)>.*?</\1>", "", page, flags=re.DOTALL).replace("<wbr>", "")
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", page)).split())


def cases(folder: Path, student: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """The cases of the submission of which there is a page, by their grade ids."""
    path = folder / student / f"{SHOWN[student]}.json"
    for exercise in json.loads(path.read_text("utf-8"))["exercises"]:
        for case in exercise["cases"]:
            yield f"{exercise['name']}-{case['name']}", case


def test_there_is_feedback_of_the_two_who_wrote_their_own_and_of_no_other(pages):
    """The first one waits for `make` to grade a class, write its report and its feedback."""
    feedback = [name for name in pages if name.startswith("feedback/")]
    assert feedback == [f"feedback/{student}/{name}.html" for student, name in SHOWN.items()]
    assert len(pages) == 2 + 3 + len(STUDENTS)


def test_every_link_leads_to_a_page_or_a_chapter_of_the_site(pages):
    site = Path("/site")
    leads = set()
    for name, page in pages.items():
        for link in re.findall(r'href="(?!data:)([^"]+)"', page):
            parts = urlsplit(link)
            assert not parts.scheme
            place = (site / "samples" / name).parent / unquote(parts.path) if parts.path else None
            leads |= {place.resolve().relative_to(site)} if place else set()
    chapters = {path for path in leads if path.parts[0] == "chapters"}
    assert {path.stem for path in chapters} == {ONE_LIE, M_ESTIMATORS}
    assert {str(path.relative_to("samples")) for path in leads - chapters} == set(pages)


def test_the_page_teach_leads_to_pages_that_are_there(pages):
    source = (answers.ROOT / "chapters" / "teach.md").read_text("utf-8")
    linked = re.findall(r"\]\(\.\./samples/([^)]+)\)", source)
    assert len(linked) == 4 and set(linked) <= set(pages)


class TestSecrets:
    def test_the_attempts_are_no_solutions(self, made):
        """No line of theirs is one of a solution, and none of their exercises passes."""
        secret = {
            "".join(line.split())
            for name in SHOWN.values()
            for cell in answers.source_notebook(name)["cells"]
            if cell["metadata"].get("nbgrader", {}).get("solution")
            for line in "".join(cell["source"]).splitlines()
            if not line.startswith("def ")
        }
        own = {
            "".join(line.split())
            for cells in ATTEMPTS.values()
            for source in cells.values()
            for line in source.splitlines()
        }
        assert len(secret) > 30 and len(own) > 30
        assert not {line for line in own & secret if len(line) >= WHOLE_LINES}
        for student, name in SHOWN.items():
            result = json.loads((made / "graded" / student / f"{name}.json").read_text("utf-8"))
            assert "passed" not in {exercise["status"] for exercise in result["exercises"]}

    @pytest.mark.parametrize("student", SHOWN)
    def test_feedback_tells_what_the_release_tells_or_a_hint(self, student, made):
        """Graded by the release, which has no hidden test, the visible cases say the same."""
        visible = dict(cases(made / "visible", student))
        cells = answers.source_notebook(SHOWN[student])["cells"]
        source = "".join(line for cell in cells for line in cell["source"])
        hints = set(re.findall(r"# hint: (.+)", source))
        told = 0
        for grade_id, case in cases(made / "graded", student):
            other = visible[grade_id]
            assert case["compared"] == other["compared"]
            assert case["message"] == other["message"] or case["message"] in hints
            told += case["message"] in hints
        assert told > 3, "hidden checks failed too"

    def test_a_page_names_no_case_that_the_release_does_not(self, made):
        for name in TABLE:
            released = answers.source_notebook(name, made / "release")
            known = {c["metadata"].get("nbgrader", {}).get("grade_id") for c in released["cells"]}
            for path in (made / "graded").glob(f"*/{name}.json"):
                for exercise in json.loads(path.read_text("utf-8"))["exercises"]:
                    assert {f"{exercise['name']}-{c['name']}" for c in exercise["cases"]} <= known

    def test_no_line_of_a_solution_a_hidden_test_or_an_answer_is_in_a_page(self, pages):
        """Looked for within lines too: a page has few line breaks."""
        lines = (line for name in TABLE for line in secret_lines(name) | answer_lines(name))
        secrets = {" ".join(line.split()) for line in lines}
        assert len(secrets) > 200
        shown = {name: text(page) for name, page in pages.items()}
        assert not [(name, s) for name, words in shown.items() for s in secrets if s in words]
        marks = ("BEGIN HIDDEN", "BEGIN SOLUTION", "# hint", "rng.", "def ")
        assert not [(name, m) for name, words in shown.items() for m in marks if m in words]
        planted = f"<p>Look:</p><p><b>{html.escape(min(secrets))}</b> and more</p>"
        assert min(secrets) in text(planted)

    def test_the_seed_and_the_machine_are_in_no_page(self, made, pages):
        assert not [name for name, page in pages.items() if str(made) in page or "seed" in page]


def test_the_report_has_all_that_the_page_teach_speaks_of(pages):
    index = pages["report/index.html"]
    page = BeautifulSoup(index, "html.parser")
    assert [link.get_text() for link in page.select("th a[href^=students]")] == STUDENTS
    for level in ("all", "most", "some", "zero", "unmarked"):
        assert page.select(f"td.{level}")
    for name in TABLE:
        report = text(pages[f"report/{name}.html"])
        assert "Below the bars: points, of 40." in report, "there are enough marks for a picture"
        start = report.index("What 40 % of the class misunderstood")
        assert report[start : report.index("Exercises, hardest first")].count(" students") >= 3
    for page in pages.values():
        assert shown_class.NOTICE in text(page) and "do not publish" not in page


def test_its_heat_map_is_the_picture_on_the_page_teach_and_feedback_shows_own_values(pages):
    assert thumbnail(pages["report/index.html"]).count("<rect ") == len(STUDENTS) * 8
    first, second = (pages[name] for name in pages if name.startswith("feedback/"))
    assert "Yours 2.0 Expected 1600.0" in text(first)
    assert '<circle class="dot"' in first
    assert "0/0 is NaN" in text(second) and "Yours [nan, 0.5]" in text(second)


def test_the_pages_are_valid(made, tmp_path):
    validator = npm.installed(test_valid_html.HERE, "html-validate")
    found = sorted((made / "pages").rglob("*.html"))
    assert test_valid_html.complaints(validator, found, tmp_path / "said.json") == []
