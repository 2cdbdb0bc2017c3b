"""``autograder export``: files that Canvas and Moodle take, and who is not in them."""

import csv
import shutil
import zipfile
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from robust_slam_autograder.grading import results
from robust_slam_autograder.grading.journal import open_journal
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.nbgrader import gradebook
from robust_slam_autograder.reading.submission import DATABASE_NAME

from .. import toy
from ..conftest import Run
from ..nbgrader.course import marked
from ..reports import samples
from ..timestamps import JUNK

ZOE = "Zoe\u0308"
"""As some systems name folders; the roster writes ë as one letter."""
CANVAS = """\
\ufeffStudent,ID,SIS User ID,SIS Login ID,Section,Notes,The toy (881),Final Score
,,,,,,Manual Posting,
    Points Possible,,,,,,20,(read only)
"Lovelace, Ada",11,s1,ada,One,,,0
"Zo\u00eb, =1+1",12,s2,Zo\u00eb,One,,3.5,0
=cmd(),13,s3,gone,Two and One,,7,0
"Student, Test",14,,,One,,N/A,
"""
MOODLE = """\
First name,Last name,ID number,Email address,Assignment: The toy (Real),Course total (Real)
Ada,Lovelace,s1,ada,-,-
Zo\u00eb,@SUM(1),s2,Zo\u00eb,"3,5",-
Gone,Girl,s3,gone,-,-
"""
POLICY = """\
timezone = "Europe/Berlin"
[policy]
percent_per_day = 10
[due]
07-toy = 2026-10-20T12:00:00
"""
IN_TIME = "2026-10-20 12:00:00 Europe/Berlin"
A_DAY_LATE = "2026-10-21 10:00:01 UTC"


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("graded") / "out"
    record(out, marked("ada", [4, 6, 5, 0]), marked(ZOE, [4, 0, 0, 0]))
    return out


def record(out: Path, *marks: Result) -> None:
    for mark in marks:
        results.write(out, mark)
    known = [mark for mark in marks if mark.status != "failed"]
    gradebook.record(out / DATABASE_NAME, [toy.assignment()], known)


@pytest.fixture
def course(graded: Path, tmp_path: Path) -> Path:
    toy.make_tree(tmp_path, 'title = "The toy"\n')
    shutil.copytree(graded, tmp_path / "out")
    return tmp_path


@pytest.fixture
def export(course: Path, autograder: Run, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Export with a roster's text: exit status, output, errors."""
    monkeypatch.chdir(course)

    def command(system: str, roster: str, *arguments: object) -> tuple[int, str, str]:
        (course / "roster.csv").write_text(roster, encoding="utf-8", newline="")
        what = ("--format", system, "--roster", "roster.csv", "--out", "out", "--to", "marks.csv")
        return autograder("export", *what, *arguments)

    return command


def rows(course: Path) -> list[list[str]]:
    with (course / "marks.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def column(course: Path) -> list[str]:
    """The marks of Ada, Zoë and who handed in nothing, in a file for Canvas."""
    return [row[5] for row in rows(course)[2:5]]


def test_canvas_gets_its_own_columns_and_points(course, export):
    status, out, err = export("canvas", CANVAS)
    assert status == 0 and "2 of 3 students have marks, matched by SIS Login ID" in out
    assert rows(course) == [
        ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", "The toy (881)"],
        ["    Points Possible", "", "", "", "", "20"],
        ["Lovelace, Ada", "11", "s1", "ada", "One", "15"],
        ["Zo\u00eb, =1+1", "12", "s2", "Zo\u00eb", "One", "4"],
        ["'=cmd()", "13", "s3", "gone", "Two and One", "7"],
        ["Student, Test", "14", "", "", "One", "N/A"],
    ]
    assert err == "no submission of 07-toy, left as the roster has it: 1 (gone)\n"
    assert (course / "marks.csv").stat().st_mode & 0o777 == 0o600


def test_students_get_numbers_that_grading_uses(course, export, autograder):
    what = ("--format", "canvas", "--roster", "roster.csv", "--out", "out", "--to", "marks.csv")
    export("canvas", CANVAS)
    assert autograder("towns", *what)[0] == 0
    first, journal = rows(course), open_journal(course / "out", None)
    assert first[0][-1] == "Town" and first[1][-1] == "0"
    old = CANVAS.replace(",Final Score", ",Town (7)").replace(",(read only)", ",1000000.00")
    assert autograder("export", *what)[0] == 0
    (course / "roster.csv").write_text(old, encoding="utf-8")
    assert autograder("towns", *what)[0] == 0 and rows(course)[1][-1] == "0"
    (course / "roster.csv").write_text(CANVAS, encoding="utf-8")
    assert autograder("towns", *what)[0] == 0
    assert [row[-1] for row in first[2:5]] == [str(journal.town(n)) for n in ("ada", ZOE, "gone")]
    assert autograder("towns", *what)[0] == 0 and rows(course) == first


@pytest.mark.parametrize("head", ["Email address", "E-Mail-Adresse"])
def test_moodle_gets_who_and_the_grade(course, export, head):
    match = [] if head in MOODLE else ["--match", head]
    status, out, _ = export("moodle", MOODLE.replace("Email address", head), *match)
    assert status == 0 and f"matched by {head}" in out
    assert rows(course) == [
        ["First name", "Last name", "ID number", head, "Assignment: The toy (Real)"],
        ["Ada", "Lovelace", "s1", "ada", "15"],
        ["Zo\u00eb", "'@SUM(1)", "s2", "Zo\u00eb", "4"],
        ["Gone", "Girl", "s3", "gone", "-"],
    ]


ELSE = CANVAS.replace("The toy (881)", "Else (881)")
"""A roster whose columns have other names than the assignment."""
ADA = CANVAS.replace(",ada,", ",00Ada,")
"""An ID as no folder has it."""


@pytest.mark.parametrize(
    ("roster", "arguments", "status", "said", "marks"),
    [
        (CANVAS.replace("\n", "\r\n"), [], 0, "as the roster has it: 1 (gone)", ["15", "4", "7"]),
        (CANVAS, ["--missing-as-zero"], 0, "07-toy, 0: 1 (gone)", ["15", "4", "0"]),
        (CANVAS.replace(",ada,", ",Ada,"), [], 1, "not in the file: 1 (ada)", ["", "4", "7"]),
        (ADA, ["--missing-as-zero"], 1, "capitals differ: ada as 00Ada", ["", "4", "7"]),
        (ELSE, [], 0, "new columns, because the roster has none", ["15", "4", ""]),
        (ELSE, ["--column", "07-toy=Else (881)"], 0, "", ["15", "4", "7"]),
        (CANVAS.replace(",ada,", ",ada\u3000,"), [], 0, "", ["15", "4", "7"]),
        (CANVAS.replace(",20,", ',"0020,00",'), [], 0, "", ["15", "4", "7"]),
    ],
)
def test_each_student_has_the_mark_that_there_is(
    course, export, roster, arguments, status, said, marks
):
    ended, _, err = export("canvas", roster, *arguments)
    assert ended == status and said in err
    assert column(course) == marks
    (name,) = rows(course)[0][5:]
    assert name == (toy.NAME if "new columns" in err else roster.split(",")[6])
    assert ("new columns" in err) == said.startswith("new columns")


@pytest.mark.parametrize(
    ("mark", "told", "marks"),
    [
        (samples.failed("why"), "the grader failed on ada/07-toy: no mark", ["", "4", "0"]),
        (marked("Zo\u00eb", [4, 6, 5, 5]), "written in two ways: no mark", ["15", "3.5", "0"]),
    ],
)
def test_who_has_no_mark_is_told_and_the_others_have_theirs(course, export, mark, told, marks):
    record(course / "out", mark)
    status, out, err = export("canvas", CANVAS, "--missing-as-zero")
    assert status == 1 and "1 of 3 students have marks" in out and told in err
    assert column(course) == marks


def test_whose_notebook_could_not_be_read_is_named(course, export):
    record(course / "out", samples.refused("It is no notebook."))
    status, _, err = export("canvas", CANVAS)
    assert status == 0 and column(course)[0] == "0"
    assert "ada/07-toy was refused, so no test has given it points: let it be" in err
    assert "(It is no notebook.)" in err


def test_nobody_has_a_zero_whose_notebook_collect_may_have_left_out(course, export, autograder):
    zipped = "twin_99_1_07-toy.ipynb"
    with zipfile.ZipFile("all.zip", "w") as file:
        file.writestr(zipped, "{}")
    (course / "roster.csv").write_text(CANVAS, encoding="utf-8")
    what = ("all.zip", "--format", "canvas", "--roster", "roster.csv")
    assert autograder("collect", *what, "--assignment", toy.NAME)[0] == 1
    status, _, err = export("canvas", CANVAS, "--missing-as-zero")
    assert status == 1 and column(course) == ["15", "4", "7"]
    assert f"no 0 either, for what collect left out may be theirs ({zipped})" in err
    file = course / "class" / "submitted" / ".left-out.json"
    file.write_text(file.read_text().replace(toy.NAME, "08-other"))
    assert export("canvas", CANVAS, "--missing-as-zero")[0] == 0
    assert column(course) == ["15", "4", "0"]


def test_what_a_person_gave_counts_and_what_waits_is_told(course, export):
    with Gradebook(f"sqlite:///{course / 'out' / DATABASE_NAME}") as book:
        row = book.find_grade("apply-twice", toy.NAME, toy.NAME, "ada")
        row.manual_score, row.needs_manual_grade = 2.25, True
        book.db.commit()
    _, _, err = export("canvas", CANVAS)
    assert column(course)[0] == "17.25"
    assert "07-toy waits for a person's marks: 1 (ada)" in err


class TestLate:
    """``--late``: what is taken off late work."""

    @pytest.fixture
    def late(self, course: Path, export: Run) -> Run:
        """Export late work, with the times at which Ada and Zoë handed in."""

        def command(ada: str, zoe: str = IN_TIME, policy: str = POLICY) -> tuple[int, str, str]:
            (course / "late.toml").write_text(policy)
            for student, time in {"ada": ada, ZOE: zoe}.items():
                folder = toy.hand_in(course / "submitted", student, toy.answer())
                (folder / "timestamp.txt").write_text(time)
            return export("canvas", CANVAS, "--late", "late.toml", "--submitted", "submitted")

        return command

    def test_it_is_shown_before_and_after(self, course, late):
        status, out, _ = late(A_DAY_LATE)
        assert status == 0 and column(course)[:2] == ["11", "4"]
        zoe, ada = (line.split() for line in out.splitlines()[1:3])
        assert ada == [
            *("ada", "07-toy", "2026-10-21", "12:00:01", "+0200", "timestamp.txt"),
            *("1d", "0h", "00m", "01s", "15", "11"),
        ]
        assert zoe[-3:] == ["timestamp.txt", "4", "4"]
        assert "10 % of the points for each 24 hours begun, after 0 minutes' grace" in out
        assert "Times are in Europe/Berlin." in out
        with Gradebook(f"sqlite:///{course / 'out' / DATABASE_NAME}") as book:
            # The gradebook keeps its own.
            assert book.find_submission(toy.NAME, "ada").score == 15

    def test_an_extension_of_a_student_without_a_mark_is_named(self, late):
        later = "= 2026-12-24T12:00:00\n"
        extensions = f"[extensions.07-toy]\nada {later}aad {later}[extensions.08]\nbob {later}"
        status, _, err = late(A_DAY_LATE, IN_TIME, POLICY + extensions)
        assert status == 0 and "bob" not in err
        assert "an extension for 07-toy, and no mark of theirs: 1 (aad)" in err

    def test_a_mark_does_not_fall_below_nothing(self, course, late):
        late("2026-12-24 10:00:01 UTC", "2026-12-24 12:00:00 UTC")
        assert column(course)[:2] == ["0", "0"]

    def test_nbgraders_own_penalty_is_shown_and_never_taken_twice(self, course, export, late):
        with Gradebook(f"sqlite:///{course / 'out' / DATABASE_NAME}") as book:
            row = book.find_submission_notebook(toy.NAME, toy.NAME, "ada")
            row.late_submission_penalty = 3
            book.db.commit()
        assert export("canvas", CANVAS).worked("nbgrader's own late policy")
        assert column(course)[0] == "12"
        (course / "marks.csv").unlink()
        assert late(A_DAY_LATE).refused("has taken 3 points off ada/07-toy")
        assert not (course / "marks.csv").exists()

    @pytest.mark.parametrize(
        ("spoil", "said"),
        [
            (lambda stamp: (stamp.unlink(), JUNK["device"](stamp)), "timestamp.txt"),
            (lambda stamp: shutil.rmtree(stamp.parents[1]), "--submitted DIR"),
        ],
        ids=["junk", "no submission"],
    )
    def test_a_submission_without_a_time_costs_its_own_student_the_mark(
        self, course, export, late, spoil, said
    ):
        late(IN_TIME)
        spoil(course / "submitted" / "ada" / toy.NAME / "timestamp.txt")
        what = ("--late", "late.toml", "--missing-as-zero", "--submitted", "submitted")
        status, out, err = export("canvas", CANVAS, *what)
        assert status == 1 and "1 of 3 students have marks" in out
        assert "ada/07-toy has no mark: " in err and said in err
        assert column(course) == ["", "4", "0"]


COLUMN = "--column"
MATCH = ("--match", "SIS User ID")


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        (("Student,", "Name,"), [], "roster.csv:1: this is no gradebook of Canvas"),
        (("SIS Login ID", "Login"), [], "roster.csv:1: there is no column 'SIS Login ID'"),
        ((",gone,", ",ada,"), [], "roster.csv:6: 'ada' stands in line 4 already"),
        (("le,,,,,,20", "le,,,,,,100"), [], "roster.csv:3: Canvas has 07-toy out"),
        (("le,,,,,,20", 'le,,,,,,"1,020.0"'), [], "07-toy out of 1,020.0, its"),
        (("Notes", "The toy (882)"), [], "'The toy (882)' and 'The toy (881)' may both be"),
        ((",13,s3,gone", ",,s3,=gone"), [], "roster.csv:6: SIS Login ID '=gone' begins as"),
        ((",s1,", ',"=""00Ada""",'), MATCH, 'capitals differ: ada as ="00Ada"'),
        (("The toy", "Final Grade"), [COLUMN, "07-toy=Final Grade (881)"], "Canvas passes over"),
        ((",gone,", ",-gone,"), None, "roster.csv:4: Email address '-gone' begins as a formula"),
        (("ID number", "Email address"), None, "roster.csv:1: two columns are named"),
        ((), MATCH, "no one in its column 'SIS User ID' has a mark"),
        ((), ["08-none"], "has no assignment 08-none; it has 07-toy"),
        ((), [COLUMN, "08=Final Score"], "--column 08=…: there is no mark of 08"),
        ((), [COLUMN, "07-toy=Nothing"], "there is no column 'Nothing' for --column"),
        ((), [COLUMN, "07-toy"], "an assignment and its column"),
        ((), ["--late", "none.toml"], "none.toml cannot be read"),
        ((), ["--late", "late.toml", "--submitted", "none"], "--submitted DIR"),
        ((), ["--out", "nowhere"], "There is no gradebook nowhere/gradebook.db: grade first"),
        ((), ["--to", "nowhere/marks.csv"], "There is no folder nowhere for --to"),
        ((), ["--to", "roster.csv"], "is the roster itself"),
        ((), ["--roster", "none.csv"], "none.csv cannot be read"),
    ],
)
def test_a_doubtful_roster_and_wrong_use_write_nothing(course, export, change, arguments, words):
    """Without arguments, not even none, the roster is Moodle's."""
    (course / "late.toml").write_text(POLICY)
    system, roster = ("moodle", MOODLE) if arguments is None else ("canvas", CANVAS)
    given = roster.replace(*change) if change else roster
    assert (given != roster) == bool(change)
    assert export(system, given, *(arguments or ())).refused(words)
    assert not (course / "marks.csv").exists()
    assert (course / "roster.csv").read_text(encoding="utf-8") == given


def test_a_gradebook_that_lags_behind_the_results_is_refused(course, export):
    results.write(course / "out", marked("ada", [4, 6, 5, 5]))
    assert export("canvas", CANVAS).refused("does not have ada/07-toy as it was graded last")
