"""What ``course.toml``, in the source tree, says of the course as a whole.

It names what students install, and which files the public may have. The address of
the public repository stands in Jupyter Book's ``_config.yml`` beside the tree, where
the book's launch buttons find it too.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.reading.assignment import check_table

COURSE_NAME = "course.toml"
BOOK_NAME = "_config.yml"
_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*://[^\s\"'`{}\\]+")
_PASSWORD = re.compile(r"://[^/@]*:[^/]*@")
_BRANCH = re.compile(r"[\w][\w./-]*")
_PACKAGE = re.compile(r"[A-Za-z0-9][\w.-]*(\[[\w,.-]+\])?")


@dataclass(frozen=True)
class Repository:
    """The course's public repository; without an address there is none."""

    url: str = ""
    branch: str = "main"

    def requirement(self, package: str, folder: str) -> str:
        """What pip is asked for, to install a package from a folder of the repository."""
        return f"{package} @ git+{self.url}@{self.branch}#subdirectory={folder}"


@dataclass(frozen=True)
class Public:
    """Which files the public may have."""

    files: tuple[str, ...] = ()
    """Paths from the course's root; one that ends with ``/`` means all below that folder."""
    without: tuple[str, ...] = ()
    """What of these stays private, in the same form."""
    book: str = "chapters"
    """The folder of the book's notebooks."""
    assignments: str = "assignments"
    """The folder that the student release goes to."""
    known: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Per file its own lines that a solution or a hidden test happens to hold too."""


@dataclass(frozen=True)
class Course:
    """What others get of a course."""

    tree: Path
    """The instructor's source tree."""
    repository: Repository = field(default_factory=Repository)
    install: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """For ``book`` and for ``assignments`` what a student installs: package and folder."""
    public: Public | None = None

    @property
    def root(self) -> Path:
        """The course's folder, in which the source tree lies."""
        return self.tree.resolve().parent


def load(tree: Path) -> Course:
    """Read the course of a source tree; without its files every setting has its default.

    Raises:
        WrongUse: a file cannot be read, an unknown key, or a value that is of no use.
    """
    path = tree / COURSE_NAME
    repository = _repository(tree.resolve().parent / BOOK_NAME)
    if not path.is_file():
        return Course(tree, repository)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise WrongUse(f"{path} is not valid TOML: {error}.") from error
    check_table(path, table, {"install": dict, "public": dict})
    install = _install(path, table.get("install", {}))
    public = _public(path, table["public"]) if "public" in table else None
    return Course(tree, repository, install, public)


def _install(path: Path, table: dict[str, Any]) -> dict[str, dict[str, str]]:
    check_table(path, table, {"book": dict, "assignments": dict})
    for packages in table.values():
        check_table(path, packages, dict.fromkeys(packages, str))
        for package, folder in packages.items():
            if not _PACKAGE.fullmatch(package) or not _is_inside(folder):
                raise WrongUse(f"{path}: [install] wants package = its folder, not {package}.")
    return table


def _public(path: Path, table: dict[str, Any]) -> Public:
    kinds = {"files": list, "without": list, "book": str, "assignments": str, "known": dict}
    check_table(path, table, kinds)
    known = table.get("known", {})
    check_table(path, known, dict.fromkeys(known, list))
    table["known"] = {name: tuple(lines) for name, lines in known.items()}
    for key in ("files", "without"):
        names = table[key] = tuple(table.get(key, ()))
        if not all(isinstance(name, str) and _is_inside(name) for name in names):
            raise WrongUse(f"{path}: {key} wants a list of paths inside the course's folder.")
    if not all(_is_inside(table.get(key, "x")) for key in ("book", "assignments")):
        raise WrongUse(f"{path}: book and assignments want a folder inside the course's folder.")
    return Public(**table)


def _is_inside(name: str) -> bool:
    parts = name.removesuffix("/").split("/")
    return all(part not in ("", ".", "..") for part in parts) and "\\" not in name


def _repository(path: Path) -> Repository:
    import yaml  # of the extra `grading`

    try:
        value = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return Repository()
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise WrongUse(f"{path} cannot be read: {error}.") from error
    table = value.get("repository") if isinstance(value, dict) else None
    table = table if isinstance(table, dict) else {}
    url, branch = table.get("url") or "", table.get("branch") or "main"
    if not isinstance(url, str) or not (url == "" or _ADDRESS.fullmatch(url)):
        raise WrongUse(f"{path}: repository.url wants an address https://… or nothing ({url!r}).")
    if _PASSWORD.search(url):
        raise WrongUse(
            f"{path}: repository.url holds a password, and students would get it: take it out."
        )
    if not isinstance(branch, str) or not _BRANCH.fullmatch(branch):
        raise WrongUse(f"{path}: repository.branch wants a branch's name ({branch!r}).")
    return Repository(url.rstrip("/"), branch)
