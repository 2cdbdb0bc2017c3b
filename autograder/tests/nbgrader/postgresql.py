"""A PostgreSQL server for tests: Debian's own programs, in a temporary folder, gone afterwards."""

import contextlib
import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import psycopg2
import psycopg2.extensions
from sqlalchemy import URL

USER, PASSWORD = "grader", "canary/of:the@password"


@dataclass(frozen=True)
class Server:
    """A running server; it listens on a socket in its own folder alone."""

    folder: Path

    def url(self, database: str) -> URL:
        """The address of a database, with the password in it."""
        where = {"host": str(self.folder)}
        return URL.create("postgresql", USER, PASSWORD, database=database, query=where)

    def connect(self, database: str = "postgres") -> psycopg2.extensions.connection:
        """Connect to a database; each statement counts at once."""
        who = {"user": USER, "password": PASSWORD}
        made = psycopg2.connect(host=str(self.folder), dbname=database, **who)
        made.autocommit = True
        return made

    def run(self, statement: str, database: str = "postgres") -> list[tuple[Any, ...]]:
        with contextlib.closing(self.connect(database)) as connection, connection.cursor() as at:
            at.execute(statement)
            return at.fetchall() if at.description else []


def programs() -> Path | None:
    """The folder of the server's programs, of the newest version that is installed."""
    found = [path.parent for path in Path("/usr/lib/postgresql").glob("*/bin/initdb")]
    return max(found, key=lambda path: int(path.parent.name), default=None)


@contextlib.contextmanager
def running() -> Iterator[Server]:
    """Make and start a server; it is stopped and removed however this ends."""
    at = programs()
    assert at is not None
    # A socket's path has to be short, and the server's user has to reach it.
    folder = Path(tempfile.mkdtemp(prefix="pg", dir="/tmp"))
    who = _who()
    secret = folder / "password"
    secret.write_text(PASSWORD)
    for path in (folder, secret):
        if who:
            os.chown(path, who["user"], who["group"])
    try:
        making = [at / "initdb", "-D", folder / "data", "-U", USER, f"--pwfile={secret}"]
        making += ["-A", "scram-sha-256", "-E", "UTF8", "--locale=C", "--no-sync"]
        subprocess.run(making, cwd="/", check=True, stdout=subprocess.DEVNULL, **who)
        serving = [at / "postgres", "-D", folder / "data", "-k", folder, "-c", "listen_addresses="]
        log = (folder / "log").open("wb")
        with (
            log,
            subprocess.Popen([*serving, "-F"], cwd="/", stdout=log, stderr=log, **who) as server,
        ):
            try:
                yield _answering(Server(folder), server)
            finally:
                server.send_signal(signal.SIGQUIT)  # at once: nothing of it is kept
    finally:
        shutil.rmtree(folder)


def _who() -> dict[str, Any]:
    """Under which user the server runs: it refuses to be root."""
    if os.geteuid() != 0:
        return {}
    for name in ("postgres", "nobody"):
        with contextlib.suppress(KeyError):
            found = pwd.getpwnam(name)
            return {"user": found.pw_uid, "group": found.pw_gid, "extra_groups": []}
    raise AssertionError("there is no user postgres and no user nobody")


def _answering(server: Server, process: subprocess.Popen[bytes]) -> Server:
    while process.poll() is None:
        with contextlib.suppress(psycopg2.OperationalError):
            server.run("SELECT 1")
            return server
        time.sleep(0.05)
    raise AssertionError((server.folder / "log").read_text("utf-8", "replace"))
