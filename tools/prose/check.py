"""Which files are read, and by which of the two checks."""

import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from proselint.checks import __register__
from proselint.registry import CheckRegistry
from proselint.tools import LintFile

from tools.prose import text

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).parent
PAGES = (
    "README.md",
    "lib/**/README.md",
    "autograder/*.md",
    "chapters/*.md",
    "chapters/*.ipynb",
    "solutions/*/*.ipynb",
)
CODE = (
    "lib/**/*.py",
    "lib/course/robust_slam_course/**/*.js",
    "autograder/**/*.py",
    "autograder/robust_slam_autograder/publishing/templates/*.txt",
    "autograder/robust_slam_autograder/reports/templates/*.html",
    "benchmarks/**/*.py",
    "chapters/_ext/*.py",
    "chapters/python/*.py",
    "chapters/python/*.js",
    "tools/**/*.py",
)


def findings(root: Path) -> Iterator[str]:
    """Yield what both checks find in a course, each with its place."""
    for path in _files(root, PAGES):
        for piece in text.read(path, path.relative_to(root).as_posix()):
            yield from by_proselint(piece)
            yield from by_the_list(piece)
    for path in _files(root, CODE):
        for piece in text.read(path, path.relative_to(root).as_posix()):
            yield from by_the_list(piece)


def by_proselint(piece: text.Piece) -> Iterator[str]:
    """Yield proselint's findings, without the checks that are off."""
    if not piece.text.strip():
        return
    _register()
    config = {"max_errors": 1000, "checks": _checks()}
    for found in LintFile(piece.place, piece.text).lint(config):  # type: ignore[arg-type]
        line = piece.line + found.pos[0] - 1
        result = found.check_result
        yield f"{piece.place}:{line}: {result.check_path}: {result.message}"


def by_the_list(piece: text.Piece) -> Iterator[str]:
    """Yield the words of the project's list, outside the phrases where they may stand."""
    pattern, instead, allowed = _words()
    kept = [match.span() for match in allowed.finditer(piece.text)]
    for match in pattern.finditer(piece.text):
        if any(start <= match.start() and match.end() <= end for start, end in kept):
            continue
        line = piece.line + piece.text.count("\n", 0, match.start())
        number = next(n for n, word in enumerate(match.groups()) if word is not None)
        shown = " ".join(match[0].split())
        yield f"{piece.place}:{line}: words: {shown!r}; write: {instead[number]}"


@cache
def _register() -> None:
    CheckRegistry().register_many(__register__)


@cache
def _checks() -> dict[str, bool]:
    """Return proselint's checks, the most specific first, as it expects them."""
    off = _read("proselint.toml")["off"]
    known = {check.path for check in __register__}
    unknown = [name for name in off if not any(path.startswith(name) for path in known)]
    if unknown:
        raise ValueError(f"proselint.toml: proselint has no checks {unknown}")
    every = {path.partition(".")[0]: True for path in known} | dict.fromkeys(off, False)
    return dict(sorted(every.items(), key=lambda item: -item[0].count(".")))


@cache
def _words() -> tuple[re.Pattern[str], list[str], re.Pattern[str]]:
    """Return a pattern with a group for each entry, what to write instead, and what may stand."""
    given = _read("words.toml")
    groups = (f"({_any_of(words.split(', '))})" for words in given["instead"])
    allowed = _any_of([phrase for phrases in given["allowed"].values() for phrase in phrases])
    return re.compile("|".join(groups)), list(given["instead"].values()), re.compile(allowed)


def _any_of(phrases: list[str]) -> str:
    return "|".join(map(_phrase, phrases))


def _phrase(words: str) -> str:
    """Return a pattern of a phrase, however its line is broken; ``*`` is the rest of a word."""
    first, rest = words[0], re.escape(words[1:]).replace(r"\ ", r"\s+").replace(r"\*", r"\w*")
    either = f"[{first.lower()}{first.upper()}]" if first.islower() else re.escape(first)
    return rf"\b{either}{rest}\b"


def _read(name: str) -> dict[str, dict[str, str]]:
    return tomllib.loads((HERE / name).read_text("utf-8"))


def _files(root: Path, patterns: tuple[str, ...]) -> list[Path]:
    found = {path for pattern in patterns for path in root.glob(pattern)}
    left_out = {".ipynb_checkpoints", ".venv", "tests"}
    return sorted(path for path in found if not left_out & {*path.relative_to(root).parts})
