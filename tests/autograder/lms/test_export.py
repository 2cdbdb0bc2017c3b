"""``autograder export``: files that Canvas and Moodle take, and who is not in them."""

from __future__ import annotations

import csv
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from robust_slam_autograder import cli
from robust_slam_autograder.grading import results
from robust_slam_autograder.grading.results import Result, without_grade
from robust_slam_autograder.nbgrader import gradebook

from tests.autograder import toy
from tests.autograder.nbgrader.test_gradebook import result

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
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A course with the marks of two students."""
    folder = tmp_path_factory.mktemp("graded")
    tests = toy.assignment()
    toy.make_tree(folder, 'title = "The toy"\n')
    marks = [result("ada", [4, 6, 5, 0], tests), result(ZOE, [4, 0, 0, 0], tests)]
    record(folder, *marks)
    return folder


def record(course: Path, *marks: Result) -> None:
    for mark in marks:
        results.write(course / "out", mark)
    known = [mark for mark in marks if mark.status != "failed"]
    gradebook.record(course / "out" / "gradebook.db", [toy.assignment()], known)


@pytest.fixture
def course(graded: Path, tmp_path: Path) -> Path:
    """A course of the test's own."""
    return Path(shutil.copytree(graded, tmp_path / "course"))


@pytest.fixture
def export(course: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Export with a roster's text: exit status, output, errors."""

    def command(system: str, roster: str, *arguments: object) -> tuple[int, str, str]:
        (course / "roster.csv").write_text(roster, encoding="utf-8", newline="")
        where = ("--out", course / "out", "--to", course / "marks.csv")
        what = ("export", "--format", system, "--roster", course / "roster.csv", *where)
        every = map(str, ("--solutions", course / "solutions", *what, *arguments))
        try:
            status = cli.main(list(every))
        except SystemExit as error:  # how argparse ends
            status = int(error.code or 0)
        return (status, *capsys.readouterr())

    return command


def rows(course: Path) -> list[list[str]]:
    with (course / "marks.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def test_canvas_gets_its_own_columns_and_points(course: Path, export: Run) -> None:
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


def test_moodle_gets_who_and_the_grade(course: Path, export: Run) -> None:
    assert export("moodle", MOODLE)[0] == 0
    assert rows(course) == [
        ["First name", "Last name", "ID number", "Email address", "Assignment: The toy (Real)"],
        ["Ada", "Lovelace", "s1", "ada", "15"],
        ["Zo\u00eb", "'@SUM(1)", "s2", "Zo\u00eb", "4"],
        ["Gone", "Girl", "s3", "gone", "-"],
    ]


def test_a_column_of_any_name_can_match(course: Path, export: Run) -> None:
    roster = MOODLE.replace("Email address", "E-Mail-Adresse")
    status, out, _ = export("moodle", roster, "--match", "E-Mail-Adresse")
    assert status == 0 and "matched by E-Mail-Adresse" in out
    assert rows(course)[0][3] == "E-Mail-Adresse"


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_line_ends_and_delimiters_of_the_roster_change_nothing(
    course: Path, export: Run, end: str
) -> None:
    export("canvas", CANVAS)
    wanted = (course / "marks.csv").read_bytes()
    export("canvas", CANVAS.replace("\n", end))
    assert (course / "marks.csv").read_bytes() == wanted


def test_an_assignment_that_is_new_there_is_said_to_be(course: Path, export: Run) -> None:
    status, _, err = export("canvas", CANVAS.replace("The toy (881)", "Else (881)"))
    assert status == 0 and "new columns, because the roster has none for them: 07-toy" in err
    table = rows(course)
    assert table[0][5:] == [toy.NAME] and [row[5] for row in table[1:]] == [
        *("20", "15", "4", "", "")
    ]


def test_a_column_is_named_where_no_name_says_it(course: Path, export: Run) -> None:
    roster = CANVAS.replace("The toy (881)", "Else (881)")
    status, _, err = export("canvas", roster, "--column", f"{toy.NAME}=Else (881)")
    assert status == 0 and "new columns" not in err
    assert rows(course)[0][5:] == ["Else (881)"] and rows(course)[4][5] == "7"


def test_who_handed_in_nothing_has_0_on_demand(course: Path, export: Run) -> None:
    status, _, err = export("canvas", CANVAS, "--missing-as-zero")
    assert status == 0 and "no submission of 07-toy, 0: 1 (gone)" in err
    assert [row[5] for row in rows(course)[2:5]] == ["15", "4", "0"]


def test_who_is_not_on_the_roster_is_named_and_the_status_says_so(
    course: Path, export: Run
) -> None:
    status, _, err = export("canvas", CANVAS.replace(",ada,", ",Ada,"))
    assert status == 1 and "not on the roster, and not in the file: 1 (ada)" in err
    assert [row[5] for row in rows(course)[2:4]] == ["", "4"]


def test_a_failure_of_the_grader_is_no_mark(course: Path, export: Run) -> None:
    failed = without_grade("failed", "why", student="ada", assignment=toy.NAME, max_score=20)
    record(course, failed)
    status, out, err = export("canvas", CANVAS, "--missing-as-zero")
    assert status == 1 and "1 of 3 students have marks" in out
    assert "the grader failed on ada/07-toy: no mark" in err
    assert [row[5] for row in rows(course)[2:5]] == ["", "4", "0"]


def test_what_a_person_gave_counts_and_what_waits_is_told(course: Path, export: Run) -> None:
    with Gradebook(f"sqlite:///{course / 'out' / 'gradebook.db'}") as book:
        row = book.find_grade("apply-twice", toy.NAME, toy.NAME, "ada")
        row.manual_score, row.needs_manual_grade = 2.25, True
        book.db.commit()
    _, _, err = export("canvas", CANVAS)
    assert rows(course)[2][5] == "17.25"
    assert "07-toy waits for a person's marks: 1 (ada)" in err


def submitted(course: Path, **times: str) -> tuple[str, Path]:
    """Submissions that say when they were handed in; gives the option that names their folder."""
    for student, time in times.items():
        folder = toy.hand_in(course / "submitted", student, toy.answer())
        (folder / "timestamp.txt").write_text(time)
    return "--submitted", course / "submitted"


def test_late_work_is_shown_before_and_after(course: Path, export: Run) -> None:
    (course / "late.toml").write_text(POLICY)
    when = {"ada": "2026-10-21 10:00:01 UTC", ZOE: "2026-10-20 12:00:00 Europe/Berlin"}
    status, out, _ = export(
        "canvas", CANVAS, "--late", course / "late.toml", *submitted(course, **when)
    )
    assert status == 0
    zoe, ada = (line.split() for line in out.splitlines()[1:3])
    assert ada == [
        *("ada", "07-toy", "2026-10-21", "12:00:01", "+0200", "timestamp.txt"),
        *("1d", "0h", "00m", "01s", "15", "11"),
    ]
    assert zoe[-3:] == ["timestamp.txt", "4", "4"]
    assert "10 % of the points for each 24 hours begun, after 0 minutes' grace" in out
    assert "Times are in Europe/Berlin." in out
    assert [row[5] for row in rows(course)[2:4]] == ["11", "4"]
    with Gradebook(f"sqlite:///{course / 'out' / 'gradebook.db'}") as book:
        assert book.find_submission(toy.NAME, "ada").score == 15  # the gradebook keeps its own


def test_an_extension_of_nobody_is_named(course: Path, export: Run) -> None:
    later = "= 2026-12-24T12:00:00\n"
    extensions = f"[extensions.07-toy]\nada {later}aad {later}[extensions.08]\nbob {later}"
    (course / "late.toml").write_text(POLICY + extensions)
    when = {"ada": "2026-10-21 10:00:01 UTC", ZOE: "2026-10-20 12:00:00 UTC"}
    status, _, err = export(
        "canvas", CANVAS, "--late", course / "late.toml", *submitted(course, **when)
    )
    assert status == 0
    assert "an extension for 07-toy, and no mark of theirs: 1 (aad)" in err and "bob" not in err


def test_a_mark_does_not_fall_below_nothing(course: Path, export: Run) -> None:
    (course / "late.toml").write_text(POLICY)
    when = {"ada": "2026-12-24 10:00:01 UTC", ZOE: "2026-12-24 12:00:00 UTC"}
    export("canvas", CANVAS, "--late", course / "late.toml", *submitted(course, **when))
    assert [row[5] for row in rows(course)[2:4]] == ["0", "0"]


def test_nbgraders_own_penalty_is_shown_and_never_taken_twice(course: Path, export: Run) -> None:
    with Gradebook(f"sqlite:///{course / 'out' / 'gradebook.db'}") as book:
        book.find_submission_notebook(toy.NAME, toy.NAME, "ada").late_submission_penalty = 3
        book.db.commit()
    status, out, _ = export("canvas", CANVAS)
    assert status == 0 and "nbgrader's own late policy" in out
    assert rows(course)[2][5] == "12"
    (course / "marks.csv").unlink()
    (course / "late.toml").write_text(POLICY)
    when = {"ada": "2026-10-21 10:00:01 UTC", ZOE: "2026-10-20 12:00:00 UTC"}
    status, _, err = export(
        "canvas", CANVAS, "--late", course / "late.toml", *submitted(course, **when)
    )
    assert status == 2 and "has taken 3 points off ada/07-toy" in err
    assert not (course / "marks.csv").exists()


@pytest.mark.parametrize(
    ("system", "old", "new", "words"),
    [
        ("canvas", "Student,", "Name,", "roster.csv:1: this is no gradebook of Canvas"),
        ("canvas", "SIS Login ID", "Login", "roster.csv:1: there is no column 'SIS Login ID'"),
        ("canvas", ",gone,", ",ada,", "roster.csv:6: 'ada' stands in line 4 already"),
        ("canvas", "Possible,,,,,,20", "Possible,,,,,,100", "roster.csv:3: Canvas has 07-toy out"),
        ("canvas", "Notes", "The toy (882)", "'The toy (882)' and 'The toy (881)' may both be"),
        ("canvas", ",13,s3,gone", ",,s3,=gone", "roster.csv:6: SIS Login ID '=gone' begins as"),
        ("moodle", ",gone,", ",-gone,", "roster.csv:4: Email address '-gone' begins as a formula"),
        ("moodle", "ID number", "Email address", "roster.csv:1: two columns are named"),
    ],
)
def test_what_is_doubtful_is_refused_and_nothing_written(
    course: Path, export: Run, system: str, old: str, new: str, words: str
) -> None:
    roster = CANVAS if system == "canvas" else MOODLE
    assert old in roster
    status, out, err = export(system, roster.replace(old, new))
    assert status == 2 and words in err and out == ""
    assert not (course / "marks.csv").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--match", "SIS User ID"], "nobody in its column 'SIS User ID' has a mark"),
        (["08-none"], "has no assignment 08-none; it has 07-toy"),
        (["--column", "08=Final Score"], "--column 08=…: there is no mark of 08"),
        (["--column", "07-toy=Nothing"], "there is no column 'Nothing' for --column"),
        (["--column", "07-toy"], "an assignment and its column"),
        (["--late", "none.toml"], "none.toml cannot be read"),
        (["--out", "nowhere"], "There is no gradebook nowhere/gradebook.db: grade first"),
        (["--to", "nowhere/marks.csv"], "There is no folder nowhere for --to"),
    ],
)
def test_wrong_use_is_told_and_nothing_written(
    course: Path, export: Run, arguments: list[str], words: str
) -> None:
    status, out, err = export("canvas", CANVAS, *arguments)
    assert status == 2 and words in err and out == ""
    assert not (course / "marks.csv").exists()


def test_the_roster_is_not_written_over(course: Path, export: Run) -> None:
    status, _, err = export("canvas", CANVAS, "--to", course / "roster.csv")
    assert status == 2 and "is the roster itself" in err
    assert (course / "roster.csv").read_text(encoding="utf-8") == CANVAS


def test_a_gradebook_that_lags_behind_the_results_is_refused(course: Path, export: Run) -> None:
    results.write(course / "out", result("ada", [4, 6, 5, 5], toy.assignment()))
    status, _, err = export("canvas", CANVAS)
    assert status == 2 and "does not have ada/07-toy as it was graded last" in err


def test_two_spellings_of_one_name_have_no_mark_and_the_others_have(
    course: Path, export: Run
) -> None:
    record(course, result("Zo\u00eb", [4, 6, 5, 5], toy.assignment()))
    status, _, err = export("canvas", CANVAS, "--missing-as-zero")
    assert status == 1 and "are one name, written in two ways: no mark" in err
    assert [row[5] for row in rows(course)[2:5]] == ["15", "3.5", "0"]


JUNK = {
    "words": lambda path: path.write_text("soon"),
    "binary": lambda path: path.write_bytes(b"\xff\xfe\x00"),
    "empty": Path.touch,
    "long": lambda path: path.write_text("9" * 5000),
    "before all time": lambda path: path.write_text("0001-01-01 00:00:00 +2359"),
    "pipe": os.mkfifo,
    "folder": Path.mkdir,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "nothing": lambda path: shutil.rmtree(path.parents[1]),
}


@pytest.mark.parametrize("spoil", JUNK.values(), ids=JUNK)
def test_a_junk_timestamp_costs_its_own_student_the_mark(
    course: Path, export: Run, spoil: Callable[[Path], object]
) -> None:
    (course / "late.toml").write_text(POLICY)
    where = submitted(course, ada="soon", **{ZOE: "2026-10-20 12:00:00 Europe/Berlin"})
    stamp = where[1] / "ada" / toy.NAME / "timestamp.txt"
    stamp.unlink()
    spoil(stamp)
    late = ("--late", course / "late.toml", "--missing-as-zero", *where)
    status, out, err = export("canvas", CANVAS, *late)
    assert status == 1 and "1 of 3 students have marks" in out
    assert "ada/07-toy has no mark: " in err and "no submission of 07-toy, 0: 1 (gone)" in err
    assert [row[5] for row in rows(course)[2:5]] == ["", "4", "0"]
    assert ("timestamp.txt" in err) != (spoil is JUNK["nothing"])


def test_where_no_submission_says_when_nothing_is_written(course: Path, export: Run) -> None:
    (course / "late.toml").write_text(POLICY)
    late = ("--late", course / "late.toml", "--submitted", course / "nowhere")
    status, out, err = export("canvas", CANVAS, *late)
    assert status == 2 and out == "" and "--submitted DIR" in err
    assert not (course / "marks.csv").exists()


def test_from_the_submission_to_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    toy.make_tree(tmp_path)
    toy.hand_in(tmp_path / "class" / "submitted", "ada", toy.answer())
    half = toy.answer(apply="def apply(f, x, times):\n    return x, []\n")
    folder = toy.hand_in(tmp_path / "class" / "submitted", "gone", half)
    (folder / "timestamp.txt").write_text("2026-10-21 10:00:01 UTC")
    (folder.parents[1] / "ada" / toy.NAME / "timestamp.txt").write_text("2026-10-01 00:00:00 UTC")
    paths = [str(path) for path in (tmp_path / "class" / "submitted").glob("*/*")]
    assert cli.main(["grade", *paths, "--unsandboxed", "--seed", "1"]) == 0
    (tmp_path / "roster.csv").write_text(CANVAS, encoding="utf-8")
    (tmp_path / "late.toml").write_text(POLICY)
    command = ["export", "--format", "canvas", "--roster", "roster.csv", "--late", "late.toml"]
    assert cli.main([*command, "--column", f"{toy.NAME}=The toy (881)"]) == 0
    assert "2 of 3 students have marks" in capsys.readouterr().out
    text = (tmp_path / "class" / "canvas.csv").read_text(encoding="utf-8")
    assert '"Lovelace, Ada",11,s1,ada,One,20\n' in text
    assert "'=cmd(),13,s3,gone,Two and One,6\n" in text
