"""Who follows the page *Operate* literally gets what it promises."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder.sandbox import BACK_ENDS

from autograder.tests import kernel
from autograder.tests.kernel import working
from solutions.classes import answers, sample_class
from tests.operate_page import clone, page
from tests.operate_page.page import Command, File, Step
from tests.operate_page.terminal import Said, Terminal

pytestmark = [pytest.mark.long, pytest.mark.rest]

SOURCE = page.source()
BLOCKS = page.blocks(SOURCE)
STEPS = list(page.steps(SOURCE))
TYPED = [step for step in STEPS if isinstance(step, Command)]


@dataclass(frozen=True)
class Promise:
    """What the page says that a command does."""

    says: str = ""
    """A line of this each."""
    makes: str = ""
    """Files and folders, apart by spaces."""
    makes_not: str = ""
    by_hand: Callable[[Path], None] | None = None
    """What the page has its reader do in the folder just before."""


def fix_a_test(folder: Path) -> None:
    """Take the check of Cauchy's cost at u = c out of its first case."""
    path = folder / "solutions" / "02-four-costs" / "02-four-costs.ipynb"
    notebook = json.loads(path.read_text("utf-8"))
    names = [c["metadata"].get("nbgrader", {}).get("grade_id") for c in notebook["cells"]]
    cell = notebook["cells"][names.index("rho_cauchy-by-hand")]
    kept = [line for line in cell["source"] if "close(rho_cauchy(1.0" not in line]
    assert len(kept) == len(cell["source"]) - 1
    cell["source"] = kept
    path.write_text(json.dumps(notebook), "utf-8")


def printed(heading: str) -> str:
    """The lines that the page shows as printed, in a section."""
    start = SOURCE.count("\n", 0, SOURCE.index(f"\n## {heading}\n")) + 1
    return next(block.body for block in BLOCKS if block.kind == "text" and block.line > start)


AUTOGRADER = ".venv/bin/autograder"
EXPORT, REGRADE = f"{AUTOGRADER} export", f"{AUTOGRADER} regrade 02-four-costs"
FEEDBACK = "feedback/sample-half/02-four-costs.html"
MATCHED = "5 of 5 students have marks, matched by "
PROMISES = {
    "make setup": Promise("Nothing to be done", ".venv/bin/autograder"),
    ".venv/bin/autograder grade solutions/03-irls/03-irls.ipynb \\\n"
    "    --student me --out build/first": Promise(
        "40/40  all passed", "build/first/me/03-irls.json"
    ),
    "make course": Promise(
        "[3/4] the book\nsample-half \nWhere each thing is:\nbuild/sample/feedback",
        "build/html/index.html build/release build/sample/graded/gradebook.db build/log/book.log "
        f"build/sample/{FEEDBACK}",
        makes_not="class",
    ),
    "make book": Promise(makes="build/html/index.html"),
    "make release": Promise("", "build/release/03-irls.zip build/release/03-irls/03-irls.ipynb"),
    f"{AUTOGRADER} lint --strict --answers solutions/answers": Promise(
        "0 errors, 0 warnings in 2 assignments"
    ),
    "mkdir -p class && cp -Rp build/sample/. class/": Promise(
        makes="class/submitted/sample-half/02-four-costs/02-four-costs.ipynb"
    ),
    f"{AUTOGRADER} doctor": Promise("✓ works"),
    "make grade": Promise(
        "8 graded, 2 refused, 0 failed, 10 of them unchanged and reused",
        "class/graded/sample-half/02-four-costs.json class/graded/.run.json",
    ),
    ".venv/bin/dask scheduler --host 127.0.0.1 --port 8786 &": Promise(),
    ".venv/bin/dask worker tcp://127.0.0.1:8786 --nthreads 1 --nworkers 2 &": Promise(),
    f"{AUTOGRADER} grade class/submitted/*/03-irls --out build/trial "
    "--scheduler tcp://127.0.0.1:8786": Promise(
        "4 graded, 1 refused, 0 failed. ", "build/trial/sample-half/03-irls.json"
    ),
    "kill %1 %2": Promise(),
    "make feedback": Promise("10 submissions of 5 students", f"class/{FEEDBACK}"),
    "make report": Promise(
        "report on 2 of 2 assignments", "class/report/index.html class/report/02-four-costs.html"
    ),
    f"{AUTOGRADER} mark sample-half 02-four-costs threshold +2 \\\n"
    '    --reason "The idea is right, and one sign is wrong."': Promise(
        "0 by the tests, +2 by hand: 2/10 points"
    ),
    f"{AUTOGRADER} report 02-four-costs --similar": Promise("report on 1 of 2 assignments"),
    f"{AUTOGRADER} report --no-names --to class/report-no-names": Promise(
        makes="class/report-no-names/index.html"
    ),
    ".venv/bin/python -m robust_slam_course.pictures.breaking scores "
    "class/break-the-map.csv": Promise(
        "2 scores were replayed, and 0 refused", "class/scores.csv"
    ),
    "JUPYTER_CONFIG_PATH=autograder .venv/bin/nbgrader export": Promise(makes="grades.csv"),
    f"{EXPORT} --format canvas --roster class/roster.csv": Promise(
        f"{MATCHED}SIS Login ID", "class/canvas.csv"
    ),
    f'{EXPORT} --format moodle --roster class/moodle-roster.csv --match "ID number"': Promise(
        f"{MATCHED}ID number", "class/moodle.csv"
    ),
    f"{EXPORT} 02-four-costs 03-irls --format canvas --roster class/roster.csv \\\n"
    "    --late class/late.toml": Promise(
        "before  after\n10 % of the points for each 24 hours begun\nclass/canvas.csv"
    ),
    REGRADE: Promise(printed("Regrade"), by_hand=fix_a_test),
    f"{REGRADE} --apply": Promise("gradebook: sample-misprints 43 → 44"),
    "make public": Promise("", "build/public/assignments/03-irls.zip build/public/lib"),
    f"{AUTOGRADER} init-ci github-grading --out .": Promise(
        "Next:", ".github/workflows/grading.yml"
    ),
    f"{AUTOGRADER} init-ci gradescope": Promise(makes="class/gradescope/03-irls.zip"),
    "chmod 700 class": Promise(),
}
"""By command what it promises; its exit status is 0."""
SCHEDULER_PORT = "8786"
"""Dask's own, on the page; the test takes one that is free."""


class Reader:
    """Who follows the page, and is never sent back; ``with_book`` nothing is built anew."""

    def __init__(self, folder: Path, *, with_book: bool) -> None:
        self.course = folder / "course"
        self.course.mkdir()
        clone.make(self.course)
        clone.lend_environment(self.course)
        clone.lend_book(self.course, pages=with_book)
        home = folder / "home"
        home.mkdir()
        self.terminal = Terminal(self.course, clone.environment(home), folder / "terminal.log")
        self.port = str(kernel.free_port())
        self.done = 0
        self.said: dict[str, Said] = {}

    def follow(self, until: Command) -> Said:
        """Do all that stands above a command that was not done, and the command."""
        end = STEPS.index(until)
        for step in STEPS[self.done : end]:
            self.do(step)
        said = self.do(until)
        self.done = end + 1
        assert said is not None
        return said

    def do(self, step: Step) -> Said | None:
        """Save a file, or type a command."""
        if isinstance(step, File):
            (self.course / step.name).write_text(step.text, "utf-8")
            return None
        promise = PROMISES.get(step.text, Promise())
        if promise.by_hand is not None:
            promise.by_hand(self.course)
        said = self.terminal.run(step.text.replace(SCHEDULER_PORT, self.port))
        self.said[step.text] = said
        return said


@pytest.fixture(scope="module")
def follower(tmp_path_factory, request):
    """In ``make soak`` the reader's `make course` builds the book, as `make test` has done."""
    working(next(iter(kernel.usable() or BACK_ENDS)))
    folder = tmp_path_factory.mktemp("instructor")
    someone = Reader(folder, with_book=not kernel.is_soak(request.config))
    yield someone
    someone.terminal.close()


@pytest.mark.sandbox
@pytest.mark.parametrize("command", TYPED, ids=lambda command: f"{command.line}: {command.text}")
def test_a_command_does_what_the_page_promises(follower, command):
    """`make course` releases and grades all; on a cluster, two workers first have to start."""
    said = follower.follow(command)
    assert said.status == 0, said.text
    promise = PROMISES[command.text]
    assert not [words for words in promise.says.split("\n") if words not in said.text], said.text
    made = [name for name in promise.makes.split() if (follower.course / name).exists()]
    assert made == promise.makes.split()
    assert not [name for name in promise.makes_not.split() if (follower.course / name).exists()]


@pytest.fixture(scope="module")
def course(follower):
    """The folder in which `make course` and `make grade` have been run."""
    (command,) = (step for step in TYPED if step.text == "make grade")
    if follower.done <= STEPS.index(command):
        assert follower.follow(command).status == 0
    return follower.course


@pytest.mark.sandbox
class TestSampleClass:
    """What `make course` left: no command below it on the page touches the sample's folder."""

    @pytest.fixture
    def results(self, course, assignment):
        """By student the results of an assignment."""
        graded = course / "build" / "sample" / "graded"
        paths = {name: graded / name / f"{assignment}.json" for name in sample_class.STUDENTS}
        return {name: json.loads(path.read_text("utf-8")) for name, path in paths.items()}

    @pytest.mark.parametrize("assignment", clone.ASSIGNMENTS)
    def test_each_student_gets_the_marks_of_what_they_did(self, results, assignment):
        solved, untouched = results["sample-solutions"], results["sample-untouched"]
        assert solved["score"] == solved["max_score"] > 0
        assert solved["sandbox"] == kernel.usable()[0]
        assert untouched["score"] == 0 and untouched["status"] == "graded"
        assert {exercise["status"] for exercise in untouched["exercises"]} == {"failed"}
        half, done = results["sample-half"], set(sample_class.half(assignment))
        assert lost(half) == {e["name"] for e in half["exercises"]} - done
        assert half["score"] == 10 * len(done)
        typed_in = set(sample_class.misprints(assignment))
        assert lost(results["sample-misprints"]) == typed_in
        broken = results["sample-broken"]
        assert broken["status"] == "refused" and broken["score"] == 0
        assert f"{assignment}.ipynb" in broken["reason"]
        assert broken["reason"].count(". ") == 0 and broken["reason"].endswith(".")

    def test_a_second_run_says_the_same(self, course, follower):
        """`make grade` finds the sample's results beside a copy of its submissions."""
        first = (course / "build" / "log" / "sample.log").read_text("utf-8")
        marks = re.compile(r"(?m)^sample-\S+ .*$")
        found = marks.findall(first)
        assert found == marks.findall(follower.said["make grade"].text)
        assert len(found) == len(sample_class.STUDENTS) * len(clone.ASSIGNMENTS)
        assert "reused" not in first


def lost(value: dict[str, Any]) -> set[str]:
    """The exercises of a result that lack points."""
    return {e["name"] for e in value["exercises"] if e["score"] < e["max_score"]}


def test_the_misprints_of_chapters_two_to_five_are_there():
    assert set(sample_class.misprints("02-four-costs")) >= {"rho_cauchy", "table", "convex_until"}
    assert set(sample_class.misprints("03-irls")) >= {"irls_step", "irls"}
    for assignment in ("04-non-convexity", "05-gnc"):
        assert set(sample_class.misprints(assignment)) == set(answers.solutions(assignment))


def test_a_block_says_what_it_is_a_remark_is_about_it_and_a_command_promises_something():
    fences = re.findall(r"^\s*(?:```|~~~)", SOURCE, re.M)
    assert len(fences) == 2 * len(BLOCKS)
    assert not [(block.line, block.kind) for block in BLOCKS if block.kind not in page.KINDS]
    remarks = [remark for block in BLOCKS for remark in block.remarks]
    assert re.findall(r"^%.*", SOURCE, re.M) == remarks
    assert not [remark for block in BLOCKS for remark in page.unknown_remarks(block)]
    assert {command.text for command in TYPED} == set(PROMISES)
