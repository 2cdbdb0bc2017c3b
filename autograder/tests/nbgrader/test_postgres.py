"""A gradebook that several graders share: nothing is lost, be it PostgreSQL or SQLite."""

import itertools
import multiprocessing
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from nbgrader import dbutil
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.nbgrader import database, gradebook, totals
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.nbgrader.settings import nbgrader_settings
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.assignment import MAX_NAME
from robust_slam_autograder.reading.submission import DATABASE_VARIABLE

from .. import toy
from ..conftest import Run
from ..kernel import leave_out
from . import course as course_of
from . import postgresql
from .course import FULL, marked, with_text
from .postgresql import PASSWORD

pytestmark = pytest.mark.rest

CLASS = 12
NUMBERS = itertools.count()


@pytest.fixture(scope="module")
def server():
    if postgresql.programs() is None:
        leave_out("PostgreSQL is not installed: apt install postgresql")
    with postgresql.running() as started:
        yield started


@pytest.fixture
def shared(server):
    """The address of an empty database."""
    name = f"test{next(NUMBERS)}"
    server.run(f"CREATE DATABASE {name}")
    return server.url(name)


@pytest.fixture(params=["sqlite", "postgresql"])
def place(request, tmp_path):
    """Where there is no gradebook yet, of each kind."""
    if request.param == "sqlite":
        return tmp_path / "shared" / "gradebook.db"
    return request.getfixturevalue("shared")


def address(place: Location) -> str:
    """With its password, as nbgrader and the environment take it."""
    return database.url_of(place).render_as_string(hide_password=False)


def scores(place: Location) -> dict[str, float]:
    students = totals.read(place, toy.NAME).students
    return {student: total.score for student, total in students.items()}


def at_once(*tasks: tuple[Callable[..., object], tuple[object, ...]]) -> None:
    """Run functions in processes of their own, which all begin at the same moment."""
    fork = multiprocessing.get_context("fork")
    barrier = fork.Barrier(len(tasks))
    started = [fork.Process(target=_then, args=(barrier, *task)) for task in tasks]
    for process in started:
        process.start()
    for process in started:
        process.join()
    assert [process.exitcode for process in started] == [0] * len(tasks)


def _then(barrier: Any, function: Callable[..., object], arguments: tuple[object, ...]) -> None:
    barrier.wait()
    function(*arguments)


def record_some(place: Location, students: Sequence[str], points: Sequence[float]) -> None:
    """Record in small transactions, so that those of two graders alternate."""
    gradebook.TOGETHER = 3
    gradebook.record(place, [toy.assignment()], [marked(name, points) for name in students])


def enter_scores(place: Location, students: Sequence[str]) -> None:
    """Enter a person's scores, one after the other."""
    for name in students:
        course_of.enter(place, name, "double-random", 1)


class TestTwoAtOnce:
    def test_they_make_it_and_record_the_same_assignment(self, place):
        ours, theirs = ([f"{who}{n:02}" for n in range(CLASS)] for who in ("ann", "bob"))
        both = ["zoe", "zoë"]
        at_once(
            (record_some, (place, [*both, *ours], FULL)),
            (record_some, (place, [*theirs, *both], FULL)),
        )
        assert scores(place) == dict.fromkeys([*ours, *theirs, *both], 20)
        with gradebook.opened(place) as book:
            assert [one.name for one in book.assignments] == [toy.NAME]
            (notebook,) = book.find_assignment(toy.NAME).notebooks
            assert len(notebook.grade_cells) == 4 and len(notebook.solution_cells) == 2

    def test_what_a_person_enters_meanwhile_stays(self, place):
        students = [f"ann{n:02}" for n in range(CLASS)]
        record_some(place, students, FULL)
        others = [f"bob{n:02}" for n in range(CLASS)]
        at_once(
            (record_some, (place, students[::-1], [0, 0, 0, 0])),
            (record_some, (place, others, FULL)),
            (enter_scores, (place, students)),
        )
        assert scores(place) == dict.fromkeys(students, 1) | dict.fromkeys(others, 20)


def test_cells_go_with_the_marks_that_a_person_gave(place):
    for known in (with_text(), toy.assignment(), with_text()):
        gradebook.record(place, [known], [marked("ada", FULL)])
        if known == with_text():
            course_of.enter(place, "ada", "why", 2)
    kept = course_of.rows(place, "manual_score")["ada"]
    assert kept["why"] == 2 and set(kept) >= {"why", "draw", "double-random"}


class TestPostgresIsStrict:
    """What SQLite takes as it comes."""

    def test_the_longest_names_fit(self, shared):
        long = "ä" * 50 + "x" * (MAX_NAME - 50)
        value = toy.source_notebook()
        value["cells"][3]["metadata"]["nbgrader"]["grade_id"] = f"double-{'r' * (MAX_NAME - 7)}"
        tests = replace(toy.assignment(value=value), name=long, path=Path(long, f"{long}.ipynb"))
        gradebook.record(shared, [tests], [marked(long, FULL, tests)])
        assert totals.read(shared, long).students[long].score == 20

    @pytest.mark.parametrize(
        ("name", "grade_id"), [("n" * (MAX_NAME + 1), "x"), (toy.NAME, "g" * (MAX_NAME + 1))]
    )
    def test_a_name_that_does_not_fit_is_refused_before_grading(self, tmp_path, name, grade_id):
        value = toy.source_notebook()
        value["cells"][3]["metadata"]["nbgrader"]["grade_id"] = grade_id
        path = toy.write(tmp_path / name / f"{name}.ipynb", value)
        with pytest.raises(WrongUse, match="a name of more than 128 characters: shorten it"):
            assignments.load(path)

    def test_any_message_is_a_comment(self, shared):
        mark = marked("ada", FULL)
        odd = replace(mark.exercises[0], message="a\0b \udcff 😀 %s %(x)s ' " + "long " * 50_000)
        mark = replace(mark, exercises=(odd, *mark.exercises[1:]))
        gradebook.record(shared, [toy.assignment()], [mark])
        said = course_of.rows(shared, "comment")["ada"]["double"]
        assert said.startswith("a\\x00b \\udcff 😀 %s %(x)s ' long ") and len(said) > 250_000

    def test_nbgraders_own_upgrade_has_nothing_to_do(self, shared, server, monkeypatch):
        """The server starts, and the upgrade is a process of Alembic's own."""
        monkeypatch.setenv("PATH", f"{course_of.SCRIPTS}{os.pathsep}{os.environ['PATH']}")
        record_some(shared, ["ada"], FULL)
        versions = [server.run("SELECT version_num FROM alembic_version", shared.database or "")]
        # Its configuration file gives % a meaning of its own.
        dbutil.upgrade(address(shared).replace("%", "%%"))
        versions += [server.run("SELECT version_num FROM alembic_version", shared.database or "")]
        assert versions[0] == versions[1] and len(versions[0]) == 1
        assert scores(shared) == {"ada": 20}


@pytest.fixture
def run(course, autograder):
    """Run a command on the course, with results of its own."""
    return lambda name, *arguments: autograder(name, "--out", course / "out", *arguments)


def grade(run: Run, course: Path, *arguments: object) -> str:
    paths = sorted((course / "submitted").glob("*/*"))
    status, out, err = run("grade", *paths, *toy.quickly(), "--jobs", 1, *arguments)
    assert status == 0, err
    return out


class TestCommands:
    def test_what_a_gradebook_has_is_asked_of_the_gradebook(
        self, course, run, server, shared, monkeypatch
    ):
        own = course / "out" / "gradebook.db"
        grade(run, course)
        before = own.read_bytes()
        monkeypatch.setenv(DATABASE_VARIABLE, address(shared))
        said = grade(run, course)
        assert "2 of them unchanged and reused" in said and PASSWORD not in said
        assert f"Gradebook: postgresql://grader:***@/{shared.database}" in said
        assert scores(shared) == scores(own) == {"ada": 20, "bob": 20}
        record_some(shared, ["bob"], [0, 0, 0, 0])  # by somebody else
        with gradebook.opened(shared) as book:
            book.remove_submission(toy.NAME, "ada")
        grade(run, course)
        assert scores(shared) == {"ada": 20, "bob": 20}
        for statement in ("DROP DATABASE {}", "CREATE DATABASE {}"):
            server.run(statement.format(shared.database))
        grade(run, course)
        assert scores(shared) == {"ada": 20, "bob": 20}
        assert own.read_bytes() == before

    def test_regrade_looks_at_a_copy_and_export_reads_all(self, course, run, shared, monkeypatch):
        monkeypatch.setenv(DATABASE_VARIABLE, address(shared))
        record_some(shared, ["eve"], [4, 6, 0, 0])  # another grader's
        grade(run, course)
        changed = toy.source_notebook(double_by_hand="assert double(3) == 7\n")
        toy.make_tree(course, value=changed)
        again = ("regrade", toy.NAME, "--submitted", course / "submitted", *toy.quickly())
        assert run(*again).worked("gradebook would change: ada 20 → 16")
        assert scores(shared) == {"ada": 20, "bob": 20, "eve": 10}
        assert run(*again, "--apply")[0] == 0
        roster = course / "roster.csv"
        people = "".join(f"{name},{name},1,{name},One\n" for name in ("ada", "bob", "eve"))
        roster.write_text("Student,ID,SIS User ID,SIS Login ID,Section\n" + people)
        to = course / "marks.csv"
        system = ("--format", "canvas", "--roster", roster, "--to", to)
        status, _, err = run("export", *system)
        assert status == 0, err
        marks = [line.rsplit(",", 1)[-1] for line in to.read_text("utf-8-sig").splitlines()]
        assert marks[-3:] == ["16", "16", "10"]

    def test_nbgraders_own_commands_write_there_too(self, tmp_path, shared, monkeypatch):
        """``nbgrader autograde`` starts and grades in a sandbox."""
        made = course_of.make(tmp_path)
        course_of.hand_in(made, "ada", course_of.answer())
        where = ("--SafeExporter.unsandboxed=True", f"--CourseDirectory.db_url={address(shared)}")
        done = course_of.run(made, "nbgrader", "autograde", toy.NAME, *where)
        assert done.returncode == 0, done.stderr
        assert PASSWORD not in done.stdout + done.stderr
        assert scores(shared) == {"ada": 20}
        assert database.recorded(shared).keys() == {f"ada/{toy.NAME}"}
        monkeypatch.setenv(DATABASE_VARIABLE, "postgresql://host/grades")
        settings = nbgrader_settings(str(tmp_path))
        assert settings.CourseDirectory.db_url == "postgresql+psycopg2://host/grades"


class TestMistakes:
    """What is wrong is said with its remedy, and never a password."""

    @pytest.fixture
    def grade_ada(self, course, run):
        paths = (course / "submitted" / "ada" / toy.NAME, *toy.quickly())
        return lambda *arguments: run("grade", *paths, *arguments)

    @pytest.mark.parametrize(
        ("address", "sentence"),
        [
            ("gradebook.db", "looks like postgresql://HOST/NAME"),
            (f"postgresql//ta:{PASSWORD}@host/grades", "looks like postgresql://HOST/NAME"),
            ("postgresql://ta:secret@host:port/grades", "looks like postgresql://HOST/NAME"),
            ("mysql://host/grades", "not in mysql"),
            ("sqlite://", "names no file"),
            ("sqlite:////nowhere/at/all/gradebook.db", "There is no folder /nowhere/at/all"),
            ("postgresql://ta:secret@host/grades", "put it into ~/.pgpass or $PGPASSWORD"),
            ("postgresql://host/grades?password=secret", "put it into ~/.pgpass or $PGPASSWORD"),
            ("postgresql://127.0.0.1:1/grades", "See that the server runs"),
        ],
    )
    def test_nothing_is_graded(self, course, grade_ada, address, sentence):
        status, out, err = grade_ada("--gradebook", address)
        assert status == 2 and sentence in err and out == ""
        assert "secret" not in err and PASSWORD not in err and "Traceback" not in err
        assert not (course / "out").exists()

    def test_a_missing_driver_is_named(self, grade_ada, monkeypatch):
        monkeypatch.setitem(sys.modules, "psycopg2", None)
        status, _, err = grade_ada("--gradebook", "postgresql://host/grades")
        assert status == 2 and "pip install psycopg2-binary" in err

    def test_a_database_that_is_not_there_and_a_wrong_password(
        self, course, grade_ada, server, monkeypatch
    ):
        for url, sentence in {
            server.url("grades"): "Make it on its server: createdb --owner=grader grades",
            server.url("postgres").set(password=f"wrong{PASSWORD}"): "authentication failed",
        }.items():
            monkeypatch.setenv(DATABASE_VARIABLE, address(url))
            status, _, err = grade_ada()
            assert status == 2 and sentence in err and PASSWORD not in err
        assert not (course / "out").exists()

    @pytest.mark.parametrize("rest", ["secret@host/grades", "secret/x@host/grades"])
    def test_a_password_with_an_at_sign_is_not_told(self, grade_ada, monkeypatch, rest):
        monkeypatch.setenv(DATABASE_VARIABLE, f"postgresql://ta:a@{rest}")
        status, out, err = grade_ada()
        assert status == 2 and "%40" in err and "secret" not in out + err

    def test_a_server_that_goes_away_costs_no_result(self, grade_ada, server, shared, monkeypatch):
        gone = server.url("gone")
        with monkeypatch.context() as there_at_first:
            there_at_first.setattr(places, "gradebook", lambda options: gone)
            status, _, err = grade_ada()
        assert status == 1 and 'database "gone" does not exist' in err and PASSWORD not in err
        monkeypatch.setenv(DATABASE_VARIABLE, address(shared))
        assert "1 of them unchanged and reused" in grade_ada()[1]
        assert scores(shared) == {"ada": 20}
