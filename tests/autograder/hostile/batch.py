"""Grades all entries of a target in one batch, by the command line, and counts what is wrong."""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robust_slam_autograder.reading.assignment import CONFIG_NAME, load_config
from robust_slam_autograder.reading.defaults import DEFAULT_PACKAGES

from tests.autograder import toy
from tests.autograder.hostile import catalogue, leaks, verdict
from tests.autograder.hostile.catalogue import BASELINES
from tests.autograder.hostile.entry import Entry, Place
from tests.autograder.hostile.target import Target, load

ROOT = Path(__file__).resolve().parents[3]
SEED = 20_261_121
LIMITS = "call_seconds = 3\ncell_seconds = 6\nnotebook_seconds = 90\n"
SHORT = "call_seconds = 0.4\ncell_seconds = 2\nnotebook_seconds = 30\n"
"""For the toy: loops cost little, and right answers take milliseconds."""
TOKEN_VARIABLE = "COURSE_TOKEN"
BATCH_SECONDS = 3_600.0
ATTACKERS_PACKAGES = ("ctypes", "msgpack", "socket", "subprocess")
"""Attacks are to reach the wall: the sentence about what students may import is none."""
MADE = ("out", "feedback")
"""Folders that the grader makes."""
SCRIPT = "<script>alert(1)"
"""One attack puts it into a message: in a page it must not come to life."""
SHARED = {
    "nr_free_pages": "a counter of the machine",
    "access times move": "what another run has read",
    "free-blocks": "how full the machine is",
}
"""Words of attacks that reach what all sandboxes share, in which one could leave a message."""
LARGE = 2**20
"""Files above this size are known by size and time alone."""
NEARBY = ("/tmp", "/var/tmp", "/dev/shm", "~", ".")
"""Folders beside the batch in which an attack's files would be found by its mark."""


@dataclass(frozen=True)
class Course:
    """A folder with everything of one batch in it."""

    root: Path
    target: Target
    mark: str

    def folder(self, entry: Entry) -> Path:
        """Where a submission lies."""
        return self.root / "submitted" / entry.name / self.target.name

    @property
    def out(self) -> Path:
        """Where results and summaries go."""
        return self.root / MADE[0]

    @property
    def pages(self) -> Path:
        """Where students' pages go."""
        return self.root / MADE[1]


@dataclass(frozen=True)
class Report:
    """What went wrong in a batch: sentences, none where all is well."""

    submissions: int
    inflated: tuple[str, ...]
    leaks: tuple[str, ...]
    harmed: tuple[str, ...]
    """Neighbours without full marks, files that changed, files and processes left behind."""
    stopped: tuple[str, ...]
    under_graded: tuple[str, ...]
    spilled: tuple[str, ...]
    """Attacks that cost their own author more than the exercise they stand in."""
    odd: tuple[str, ...]
    """Refusals without their sentence, faults without their name."""


def course_assignments() -> list[str]:
    """The course's own assignments."""
    return sorted(path.parent.name for path in (ROOT / "solutions").glob("*/*.ipynb"))


def attack(name: str, wall: str) -> Report:
    """Grade all submissions of one assignment, the toy or one of the course's, in one batch."""
    with tempfile.TemporaryDirectory(prefix="attack-", ignore_cleanup_errors=True) as folder:
        tree, limits = ROOT / "solutions", LIMITS
        if name == toy.NAME:
            settings = f'packages = {json.dumps(DEFAULT_PACKAGES)}\nwithheld = ["xml.dom"]\n'
            tree, limits = toy.make_tree(Path(folder, "tree"), settings), SHORT
        Path(folder, "course").mkdir()
        course = make(Path(folder, "course"), tree, name, limits)
        entries = catalogue.entries()
        write(course, entries)
        return run(course, entries, wall=wall, seed=SEED)


def make(root: Path, tree: Path, name: str, limits: str) -> Course:
    """Lay out a course around one assignment of a tree, with these limits in its settings.

    Args:
        root: an empty folder.
        tree: the source tree that the assignment is copied from.
        name: the assignment.
        limits: lines of the settings' ``[limits]``.
    """
    shutil.copytree(tree / name, root / "solutions" / name)
    settings = root / "solutions" / name / CONFIG_NAME
    allowed = json.dumps([*load_config(settings).packages, *ATTACKERS_PACKAGES])
    text = settings.read_text("utf-8") if settings.exists() else ""
    kept = re.sub(r"(?m)^packages = .*$", "", text.split("[limits]")[0])
    settings.write_text(f"packages = {allowed}\n{kept}\n[limits]\n{limits}", "utf-8")
    outside = root / "outside"
    outside.mkdir()
    (outside / "notes.txt").write_text("a neighbour's notes")
    for path in (outside, outside / "notes.txt"):
        path.chmod(0o777)
    target = load(root / "solutions", name, root / "release")
    return Course(root, target, f"mk{secrets.token_hex(6)}")


def write(course: Course, entries: Sequence[Entry]) -> None:
    """Write every submission."""
    (course.root / "submitted").mkdir(exist_ok=True)
    for entry in entries:
        entry.write(course.target, Place(course.folder(entry), course.root, course.mark))


def run(
    course: Course,
    entries: Sequence[Entry],
    *,
    wall: str,
    seed: int,
    jobs: int = 4,
) -> Report:
    """Grade the batch and look at what became of everything.

    Args:
        course: from ``make``; its submissions are written.
        entries: those submissions.
        wall: the back end.
        seed: the batch's secret.
        jobs: how many at once: many of them only wait, for limits that are judged alone.
    """
    before = snapshot(course.root)
    token = f"planted-token-{secrets.token_hex(8)}"
    options = ["--jobs", str(jobs), "--seed", str(seed), "--sandbox", wall]
    status, said = _grade(course, entries, options, os.environ | {TOKEN_VARIABLE: token})
    found = results(course, entries)
    marks = {name: earned(value, course.target) for name, value in found.items()}
    texts = leaks.secrets(course.target, seed) | {token: "the token"} | SHARED
    changed = [f"{path} changed" for path in differences(before, snapshot(course.root))]
    return Report(
        submissions=len(entries),
        inflated=_sentences(verdict.inflated(e, marks, course.target, BASELINES) for e in entries),
        leaks=(
            *leaks.shown(course.out, said, texts),
            *leaks.shown(course.pages, (), texts | {SCRIPT: "a student's script"}),
        ),
        harmed=(*_neighbours(entries, marks, course.target), *changed, *left_behind(course.mark)),
        stopped=tuple(_stops(status, said, entries, found)),
        under_graded=_sentences(
            verdict.under_graded(e, marks, course.target) for e in entries if e.kind
        ),
        spilled=_sentences(
            verdict.spilled(e, marks, course.target, BASELINES[0]) for e in entries
        ),
        odd=_sentences(_oddity(e, found.get(e.name), course.target) for e in entries),
    )


def _sentences(said: Any) -> tuple[str, ...]:
    return tuple(sentence for sentence in said if sentence)


def _grade(
    course: Course,
    entries: Sequence[Entry],
    options: Sequence[str],
    environment: Mapping[str, str],
) -> tuple[int | None, list[str]]:
    """Grade everything, write the summaries and the pages; exit status and what was said."""
    grader = [sys.executable, "-m", "robust_slam_autograder.cli"]
    grader += ["--solutions", str(course.root / "solutions")]
    paths = [str(course.folder(entry)) for entry in entries]
    summaries = ["--json", str(course.out / "marks.json")]
    summaries += ["--markdown", str(course.out / "marks.md")]
    to = ["--out", str(course.out)]
    status, said = _call(
        [*grader, "grade", *paths, *to, *options, *summaries], environment, course.root
    )
    pages = [*grader, "feedback", *to, "--to", str(course.pages)]
    its_status, more = _call(pages, environment, course.root)
    return (its_status if status == 0 else status), [*said, *more]


def _call(
    command: Sequence[str], environment: Mapping[str, str], folder: Path
) -> tuple[int | None, tuple[str, str]]:
    """Exit status (None where it did not end) and what was said."""
    try:
        done = subprocess.run(
            command,
            env=environment,
            cwd=folder,
            capture_output=True,
            timeout=BATCH_SECONDS,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        return None, ("", "")
    out, err = (text.decode(errors="replace") for text in (done.stdout, done.stderr))
    return done.returncode, (out, err)


def results(course: Course, entries: Sequence[Entry]) -> dict[str, dict[str, Any]]:
    """The result files that there are, by student."""
    found = {}
    for entry in entries:
        path = course.out / entry.name / f"{course.target.name}.json"
        if path.is_file():
            found[entry.name] = json.loads(path.read_text("utf-8"))
    return found


def earned(result: Mapping[str, Any], target: Target) -> dict[str, float]:
    """Marks by the case's grade id."""
    ids = {(case.exercise, case.name): case.grade_id for case in target.assignment.cases}
    pairs = [(e["name"], case) for e in result["exercises"] for case in e["cases"]]
    return {ids[exercise, case["name"]]: case["earned"] for exercise, case in pairs}


def _neighbours(
    entries: Sequence[Entry], marks: Mapping[str, verdict.Marks], target: Target
) -> tuple[str, ...]:
    plain = [entry for entry in entries if not entry.kind]
    return _sentences(verdict.under_graded(entry, marks, target) for entry in plain)


def _stops(
    status: int | None,
    said: Sequence[str],
    entries: Sequence[Entry],
    found: Mapping[str, Mapping[str, Any]],
) -> list[str]:
    stops = [f"{entry.name} has no result" for entry in entries if entry.name not in found]
    failed = [(name, value) for name, value in found.items() if value["status"] == "failed"]
    stops += [f"the grader failed on {name}: {value['reason']}" for name, value in failed]
    return stops if status == 0 else [f"exit status {status}: {' '.join(said)[-300:]}", *stops]


def _oddity(entry: Entry, result: Mapping[str, Any] | None, target: Target) -> str:
    if result is None:
        return ""
    if (entry.bound == "refused") != (result["status"] == "refused"):
        return f"{entry.name} is {result['status']}: {result['reason']}"
    if entry.bound == "refused":
        is_one = re.fullmatch(r"(?s)\S.*[^.]\.", result["reason"]) and ". " not in result["reason"]
        return "" if is_one else f"{entry.name} is refused without a sentence: {result['reason']}"
    owner = target.assignment.owner
    status = {e["status"] for e in result["exercises"] if owner(e["name"]) == target.victim}
    ends_otherwise = entry.ends and entry.ends not in status
    return f"{entry.name} ends {status}, not {entry.ends}" if ends_otherwise else ""


def snapshot(root: Path) -> dict[str, tuple[object, ...]]:
    """What lies in a course's folder, but for what the grader makes."""
    found = {}
    for top, folders, files in os.walk(root):
        if Path(top) == root:
            folders[:] = [name for name in folders if name not in MADE]
        for name in [*folders, *files]:
            path = Path(top, name)
            found[str(path.relative_to(root))] = _state(path)
    return found


def _state(path: Path) -> tuple[object, ...]:
    facts = path.lstat()
    content = ""
    if stat.S_ISREG(facts.st_mode) and facts.st_size <= LARGE:
        content = hashlib.sha256(path.read_bytes()).hexdigest()
    elif stat.S_ISLNK(facts.st_mode):
        content = os.readlink(path)
    time = None if stat.S_ISDIR(facts.st_mode) else facts.st_mtime_ns
    return facts.st_mode, facts.st_uid, facts.st_size if time else 0, time, content


def differences(
    before: Mapping[str, tuple[object, ...]], after: Mapping[str, tuple[object, ...]]
) -> list[str]:
    """Paths that are new, gone, or not as they were."""
    return sorted(path for path in {*before, *after} if before.get(path) != after.get(path))


def left_behind(mark: str) -> list[str]:
    """Processes and files that carry a batch's mark."""
    found = [f"the process {path.parent.name} lives on" for path in _processes(mark)]
    for place in map(os.path.expanduser, NEARBY):
        if os.path.isdir(place):
            found += [f"{place}/{name} was left" for name in os.listdir(place) if mark in name]
    return found


def _processes(mark: str) -> list[Path]:
    found = []
    for path in [*Path("/proc").glob("[0-9]*/cmdline"), *Path("/proc").glob("[0-9]*/comm")]:
        try:
            data = path.read_bytes()
        except OSError:  # it has just ended
            continue
        if mark.encode() in data:
            found.append(path)
    return found
