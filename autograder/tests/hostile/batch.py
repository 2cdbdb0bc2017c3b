"""Grades all entries of a target in one batch, by the command line, and counts what is wrong."""

import contextlib
import json
import os
import re
import secrets
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robust_slam_autograder import layout
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.misconceptions import survey, tables
from robust_slam_autograder.misconceptions.tables import Known
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.assignment import CONFIG_NAME, DEFAULT_PACKAGES, load_config

from .. import toy
from ..as_user import ROOT
from . import catalogue, leaks, verdict
from .catalogue import BASELINES
from .cells import TAGS
from .entry import Entry, Place
from .target import Target, load

Ended = tuple[int | None, list[str]]
"""Exit status, none where a command did not end, and what was said."""
Entries = Sequence[Entry]
Found = Mapping[str, Mapping[str, Any]]
"""Results by student."""
Snapshot = dict[str, tuple[object, ...]]
SEED = 20_261_121
LIMITS = "call_seconds = 3\ncell_seconds = 6\nnotebook_seconds = 90\n"
SHORT = "call_seconds = 0.4\ncell_seconds = 1\nnotebook_seconds = 30\n"
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
WORDS = (*TAGS, "NAME", "RIGHT", "WITHHELD", "OWNER")
"""Words of templates."""
NEARBY = ("/tmp", "/var/tmp", "/dev/shm", "~", ".")
"""Folders beside the batch in which an attack's files would be found by its mark."""


@dataclass(frozen=True)
class Course:
    """A folder with everything of one batch in it: ``submitted``, and what the grader makes."""

    root: Path
    target: Target
    mark: str
    out: Path
    """Where results and summaries go."""
    pages: Path
    """Where students' pages go."""

    def folder(self, entry: Entry) -> Path:
        return self.root / "submitted" / entry.name / self.target.name


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
    ill_written: tuple[str, ...]
    """Submissions that are not there, hold a word of a template, or a line of a hidden test."""


def course_assignments() -> list[str]:
    return sorted(path.parent.name for path in (ROOT / "solutions").glob("*/*.ipynb"))


def attack(name: str, wall: str) -> Report:
    """Grade all submissions of one assignment, the toy or one of the course's, in one batch.

    Many of them only wait, for limits that are judged alone: so four run at once.
    """
    with tempfile.TemporaryDirectory(prefix="attack-", ignore_cleanup_errors=True) as folder:
        tree, limits = ROOT / "solutions", LIMITS
        if name == toy.NAME:
            settings = f'packages = {json.dumps(DEFAULT_PACKAGES)}\nwithheld = ["xml.dom"]\n'
            tree, limits = toy.make_tree(Path(folder, "tree"), settings), SHORT
        course = _make(Path(folder, "course"), tree, name, limits)
        entries = catalogue.entries()
        for entry in entries:
            place = Place(course.folder(entry), course.root, course.mark)
            entry.write(course.target, place)
        if name == toy.NAME:
            _label(course)
        before = snapshot(course.root)
        token = f"planted-token-{secrets.token_hex(8)}"
        options = ["--jobs", "4", "--seed", str(SEED), "--sandbox", wall]
        ended = _grade(course, entries, options, token)
        changed = [f"{path} changed" for path in differences(before, snapshot(course.root))]
        return _report(course, entries, ended, token, changed)


def _label(course: Course) -> None:
    """Find out how answers can be wrong: labels must tell nothing of hidden inputs either."""
    tests = course.root / "solutions" / toy.NAME / f"{toy.NAME}.ipynb"
    assignment = assignments.load(tests)
    found = {name: survey.survey(assignment, name, []) for name in assignment.exercises}
    folder = course.root / layout.MISCONCEPTIONS
    tables.write_made(folder, tests, Known(tables.digest(tests), "", found))


def _make(root: Path, tree: Path, name: str, limits: str) -> Course:
    """Lay out a course around one assignment of a tree, with these limits in its settings."""
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
    (root / "submitted").mkdir()
    target = load(root / "solutions", name, root / "release")
    return Course(root, target, f"mk{secrets.token_hex(6)}", *(root / folder for folder in MADE))


def _report(
    course: Course, entries: Entries, ended: Ended, token: str, changed: list[str]
) -> Report:
    """Look at what became of everything."""
    target, found = course.target, results(course, entries)
    marks = {name: earned(value, target) for name, value in found.items()}
    files = [path for path in course.root.glob("submitted/**/*.ipynb") if path.is_file()]
    own = {SEED, *(seeds.of_submission(SEED, path.read_bytes()) for path in files)}
    texts = leaks.secrets(target, *own) | {token: "the token"} | SHARED
    drawn = (leaks.drawn(target, seed) for seed in own)
    out, pages = leaks.places(course.out, ended[1]), leaks.places(course.pages)
    lost = [(entry, verdict.under_graded(entry, marks, target)) for entry in entries]
    return Report(
        submissions=len(entries),
        inflated=_sentences(verdict.inflated(e, marks, target, BASELINES) for e in entries),
        leaks=(
            *leaks.shown(out, texts),
            *leaks.shown(pages, texts | {SCRIPT: "a student's script"}),
            *leaks.numbers_shown(out | pages, drawn),
        ),
        harmed=(
            *_sentences(sentence for entry, sentence in lost if not entry.kind),
            *changed,
            *left_behind(course.mark),
        ),
        stopped=tuple(_stops(ended, entries, found)),
        under_graded=_sentences(sentence for entry, sentence in lost if entry.kind),
        spilled=_sentences(verdict.spilled(e, marks, target, BASELINES[0]) for e in entries),
        odd=_sentences(_oddity(e, found.get(e.name), target) for e in entries),
        ill_written=tuple(_ill_written(course, entries)),
    )


def _ill_written(course: Course, entries: Iterable[Entry]) -> Iterator[str]:
    target = course.target
    known = "".join([*map(_text, target.released["cells"]), *target.answers.values()])
    words = [word for word in (*WORDS, *leaks.hidden_lines(target)) if word not in known]
    for entry in entries:
        path = course.folder(entry) / target.file
        if not os.path.lexists(path.parent):
            yield f"{entry.name} was not written"
        if entry.kind.startswith(("broken", "files", "others: a link")) or not path.is_file():
            continue
        cells = json.loads(path.read_bytes().decode("utf-8-sig"))["cells"]
        text = "\n".join(map(_text, cells))
        yield from (f"{entry.name} holds {word}" for word in words if word in text)


def _text(cell: Mapping[str, Any]) -> str:
    return "".join(cell["source"])


def _sentences(said: Iterable[str]) -> tuple[str, ...]:
    return tuple(sentence for sentence in said if sentence)


def _grade(course: Course, entries: Entries, options: list[str], token: str) -> Ended:
    """Grade everything, with a secret in the environment; write the summaries and the pages."""
    grader = [sys.executable, "-m", "robust_slam_autograder.cli"]
    grader += ["--solutions", str(course.root / "solutions")]
    paths = [str(course.folder(entry)) for entry in entries]
    to = ["--out", str(course.out)]
    summaries = ["--json", f"{course.out}/marks.json", "--markdown", f"{course.out}/marks.md"]
    said: list[str] = []
    for command in (
        ["grade", *paths, *to, *options, *summaries],
        ["feedback", *to, "--to", str(course.pages)],
    ):
        try:
            done = subprocess.run(
                [*grader, *command],
                env=os.environ | {TOKEN_VARIABLE: token},
                cwd=course.root,
                capture_output=True,
                timeout=BATCH_SECONDS,
                stdin=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired:
            return None, said
        said += [text.decode(errors="replace") for text in (done.stdout, done.stderr)]
        if done.returncode:
            return done.returncode, said
    return 0, said


def results(course: Course, entries: Entries) -> Found:
    paths = {e.name: course.out / e.name / f"{course.target.name}.json" for e in entries}
    return {name: json.loads(p.read_text("utf-8")) for name, p in paths.items() if p.is_file()}


def earned(result: Mapping[str, Any], target: Target) -> dict[str, float]:
    """Marks by the case's grade id."""
    ids = {(case.exercise, case.name): case.grade_id for case in target.assignment.cases}
    pairs = [(e["name"], case) for e in result["exercises"] for case in e["cases"]]
    return {ids[exercise, case["name"]]: case["earned"] for exercise, case in pairs}


def _stops(ended: Ended, entries: Entries, found: Found) -> list[str]:
    status, said = ended
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


def snapshot(root: Path) -> Snapshot:
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
    # Nobody can set the time at which the kernel saw a file's content or mode change last.
    changed = None if stat.S_ISDIR(facts.st_mode) else facts.st_ctime_ns
    return facts.st_mode, facts.st_uid, facts.st_ino, changed


def differences(before: Snapshot, after: Snapshot) -> list[str]:
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
        with contextlib.suppress(OSError):  # it has just ended
            if mark.encode() in path.read_bytes():
                found.append(path)
    return found
