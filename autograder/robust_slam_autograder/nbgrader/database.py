"""Where a gradebook is, SQLite's file or a PostgreSQL database: one of us writes at a time.

nbgrader looks whether a row is there and then adds it. Two programs that do so at once both
add it, and one of them fails. So each of our transactions begins with the database's own lock,
and the one that comes second waits for its end. nbgrader itself takes no such lock.
"""

import contextlib
import os
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sqlalchemy import (
    URL,
    Column,
    Connection,
    Engine,
    MetaData,
    String,
    Table,
    create_engine,
    delete,
    insert,
    inspect,
    make_url,
    select,
    text,
)
from sqlalchemy.exc import ArgumentError, DBAPIError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.reading.submission import DATABASE_NAME, DATABASE_VARIABLE

Location = Path | str | URL
"""SQLite's file, or a database's address as SQLAlchemy has it."""

LOCKS = {
    "sqlite": "BEGIN IMMEDIATE",
    # Any number will do that no other program in the same database takes.
    "postgresql": "SELECT pg_advisory_xact_lock(774411902)",
}
"""The first statement of a transaction that writes, by kind of database."""
_SNAPSHOT = {"sqlite": "BEGIN", "postgresql": "SET TRANSACTION ISOLATION LEVEL REPEATABLE READ"}
_PATIENCE = {"sqlite": {"timeout": "60"}, "postgresql": {"connect_timeout": "10"}}
"""Seconds: for another writer's transaction, and for a server that does not answer."""

RECORDED = Table(
    "autograder_recorded",
    MetaData(),
    Column("submission_id", String(32), primary_key=True),
    Column("fingerprint", String(64), nullable=False),
)
"""``results.signature`` of the result that a submission's marks are; nbgrader leaves the table
alone."""
TABLES = frozenset(
    {
        *("assignment", "base_cell", "comment", "course", "grade", "grade_cells", "notebook"),
        *("solution_cells", "source_cell", "student", "submitted_assignment"),
        *("submitted_notebook", "task_cells"),
    }
)
"""nbgrader's own, named here because its module takes a second to import."""
_SPOILT = re.compile("not a database|malformed|no such (table|column)")
_FIND_RECORDED = text(
    "SELECT submitted.student_id, assignment.name, recorded.fingerprint"
    " FROM autograder_recorded AS recorded"
    " JOIN submitted_assignment AS submitted ON submitted.id = recorded.submission_id"
    " JOIN assignment ON assignment.id = submitted.assignment_id"
)


def chosen(out: Path, named: str | None = None) -> URL:
    """Return the gradebook in use: a named one, else the environment's, else that of the results.

    Raises:
        WrongUse: as for ``url_of``.
    """
    return url_of(named or os.environ.get(DATABASE_VARIABLE) or out / DATABASE_NAME)


def url_of(location: Location) -> URL:
    """Return a gradebook's address.

    Raises:
        WrongUse: it is not an address, or that of another kind of database. A password in it is
            not told.
    """
    if isinstance(location, Path):
        location = URL.create("sqlite", database=str(location))
    try:
        url = make_url(location)
    except (ArgumentError, ValueError) as error:
        raise WrongUse(
            "That is no gradebook's address: it looks like postgresql://HOST/NAME, or "
            "sqlite:////FOLDER/gradebook.db."
        ) from error
    if url.host and "@" in f"{url.host}{url.database}":
        # What follows the first one is the password's rest, and would be shown as the host.
        raise WrongUse(
            "The gradebook's address has an @ too many: a password's own is written %40 there."
        )
    kind = url.get_backend_name()
    if kind not in LOCKS:
        raise WrongUse(f"A gradebook is in PostgreSQL or SQLite, not in {kind}.")
    if kind == "sqlite" and url.database in (None, "", ":memory:"):
        raise WrongUse("The gradebook's address names no file: sqlite:////FOLDER/gradebook.db.")
    # Which driver SQLAlchemy takes where none is named depends on its version.
    return url.set(drivername="postgresql+psycopg2") if url.drivername == "postgresql" else url


def patient(location: Location) -> URL:
    """Return a gradebook's address, with how long to wait for it."""
    url = url_of(location)
    return url.set(query={**_PATIENCE[url.get_backend_name()], **url.query})


def file_of(location: Location) -> Path | None:
    """Return the file of an SQLite gradebook."""
    url = url_of(location)
    return Path(url.database or "") if url.get_backend_name() == "sqlite" else None


def has_password(location: Location) -> bool:
    """Tell whether the address itself holds a password."""
    return bool(_secrets(url_of(location)))


def _secrets(url: URL) -> list[str]:
    hidden = [str(value) for key, value in url.query.items() if "password" in key]
    return [*([str(url.password)] if url.password else []), *hidden]


def shown(location: Location) -> str:
    """Return the address for people: without passwords."""
    url = url_of(location)
    hidden = [key for key in url.query if "password" in key]
    plain = url.set(drivername=url.get_backend_name()).difference_update_query(hidden)
    return str(file_of(url) or plain.render_as_string(hide_password=True))


@contextlib.contextmanager
def explained(location: Location, doing: str = "written") -> Iterator[None]:
    """Say of what a database refuses whose it is, why, and what to do; never a password.

    Raises:
        GraderFailure: in place of the database's own errors.
        WrongUse: the package that speaks with PostgreSQL is missing.
    """
    url = url_of(location)
    try:
        yield
    except ModuleNotFoundError as error:
        package = "psycopg2-binary" if error.name == "psycopg2" else error.name
        raise WrongUse(
            f"{error.name} is missing, which speaks with PostgreSQL: pip install {package}"
        ) from error
    except (SQLAlchemyError, OSError) as error:
        # Its own traceback would show the values that were sent, and so students' names.
        raise GraderFailure(
            f"The gradebook {shown(url)} cannot be {doing}: {_why(error, url)}"
        ) from None


def _why(error: Exception, url: URL) -> str:
    said = error.orig if isinstance(error, DBAPIError) and error.orig is not None else error
    why = re.sub(r"^\(\S+\) ", "", str(said).split("\n")[0]).rstrip(".")
    for secret in _secrets(url):
        why = why.replace(secret, "***")
    if "disk is full" in why:
        return f"{why}: make room, and give the same command again; it goes on from here."
    if url.get_backend_name() == "sqlite":
        return f"{why}: {_anew(file_of(url))}" if _SPOILT.search(why) else f"{why}."
    if f'database "{url.database}"' in why:
        owner = f"--owner={url.username} " if url.username else ""
        return f"{why}. Make it on its server: createdb {owner}{url.database}"
    if isinstance(error, DBAPIError) and getattr(said, "pgcode", None) is None:
        return f"{why}. See that the server runs and takes connections from here, and as whom."
    return f"{why}."


def _engine(location: Location) -> Engine:
    # No connection stays open behind it.
    return create_engine(patient(location), poolclass=NullPool)


def exists(location: Location) -> bool:
    """Tell whether there is a gradebook.

    Raises:
        GraderFailure: the server cannot be reached, or the file is no database, or no whole one.
    """
    file = file_of(location)
    if file is not None and not file.exists():
        return False
    with explained(location, "read"):
        lost = TABLES - set(inspect(_engine(location)).get_table_names())
    if lost and lost != TABLES:  # nbgrader would make it anew, without what it held
        raise GraderFailure(
            f"The gradebook {shown(location)} has lost its table {min(lost)}: {_anew(file)}"
        )
    return not lost


def refuse_missing(location: Location) -> None:
    """Refuse to go on without a gradebook.

    Raises:
        WrongUse: there is none.
        GraderFailure: as for ``exists``.
    """
    if not exists(location):
        raise WrongUse(
            f"There is no gradebook {shown(location)}: grade first, or say --out DIR or "
            "--gradebook URL."
        )


def _anew(file: Path | None) -> str:
    """Say how to come from a spoilt gradebook to a whole one."""
    aside = f"mv {shlex.quote(str(file))} {shlex.quote(f'{file}.spoilt')}" if file else "rename it"
    return (
        "put back a copy that you have kept, or move it away "
        f"({aside}) and grade again: tests' marks are recorded anew from the results, and what "
        "a person entered is in the old one alone."
    )


def recorded(location: Location) -> dict[str, str]:
    """Return by ``student/assignment`` the signature of each result whose marks are there.

    Raises:
        GraderFailure: it cannot be read.
    """
    if not exists(location):
        return {}
    with explained(location, "read"), _engine(location).connect() as book:
        if not inspect(book).has_table(RECORDED.name):
            return {}
        return {f"{student}/{name}": seen for student, name, seen in book.execute(_FIND_RECORDED)}


def rows(location: Location, statement: str, **values: object) -> list[tuple[Any, ...]]:
    """Return what a statement selects from a gradebook; nothing where there is none.

    nbgrader's own classes ask for each submission anew, and take a second to import.

    Raises:
        GraderFailure: it cannot be read.
    """
    if not exists(location):
        return []
    with explained(location, "read"), _engine(location).connect() as book:
        return [tuple(row) for row in book.execute(text(statement), values)]


def make(location: Location) -> None:
    """Make a gradebook where there is none: all of it, or nothing where this is killed.

    Raises:
        GraderFailure: it cannot be written.
    """
    file = file_of(location)
    exists(location)
    with explained(location):
        engine = _engine(location)
        if file is not None:
            file.parent.mkdir(parents=True, exist_ok=True)
        if inspect(engine).has_table(RECORDED.name):
            return
        with engine.begin() as book:
            book.execute(text(LOCKS[book.dialect.name]))
            if not inspect(book).has_table("assignment"):
                _make_nbgraders(book)
            RECORDED.create(book, checkfirst=True)


def _make_nbgraders(book: Connection) -> None:
    """Make what ``nbgrader.api.Gradebook`` makes in several transactions, in one."""
    from alembic.script import ScriptDirectory  # these take a second to import
    from nbgrader.api import Base, Course
    from nbgrader.dbutil import ALEMBIC_DIR

    Base.metadata.create_all(book)
    book.execute(insert(Course.__table__).values(id="default_course"))
    version = ScriptDirectory(ALEMBIC_DIR).get_current_head()
    book.execute(text("CREATE TABLE alembic_version (version_num VARCHAR(32) NOT NULL)"))
    book.execute(text("INSERT INTO alembic_version VALUES (:version)"), {"version": version})


def copy(location: Location, to: Path) -> None:
    """Copy a gradebook, as it is at one moment, into a new SQLite file; empty where there is none.

    Raises:
        GraderFailure: it cannot be read.
    """
    from nbgrader.api import Base  # it takes a second to import

    make(to)
    if not exists(location):
        return
    with (
        explained(location, "read"),
        _engine(location).connect() as book,
        _engine(to).begin() as copied,
    ):
        book.execute(text(_SNAPSHOT[book.dialect.name]))
        for table in Base.metadata.sorted_tables:
            copied.execute(delete(table))
            rows = [row._asdict() for row in book.execute(select(table))]
            if rows:
                copied.execute(insert(table), rows)
