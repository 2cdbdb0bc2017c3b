"""What ``course.toml``, in the source tree, says of the course as a whole.

It names what students install, and which files the public may have. The address of
the public repository stands in Jupyter Book's ``_config.yml`` beside the tree, where
the book's launch buttons find it too.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.reading.table import Kinds, read_table

COURSE_NAME = "course.toml"
BOOK_NAME = "_config.yml"
HAND_IN = "Hand in this one file, under the name that it had."
"""What students are told where the book's settings do not name a place."""
_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*://[^\s\"'`{}\\]+")
_PASSWORD = re.compile(r"://[^/@]*:[^/]*@")
_FOLDERS = ("book", "assignments", "readme")
_PLACES = {...: str}
_LISTS = {...: list}
_KINDS: Kinds = {
    "install": {"book": _PLACES, "assignments": _PLACES, "also": _LISTS, "tools": list},
    "public": dict.fromkeys(_FOLDERS, str) | {"files": list, "without": list, "known": _LISTS},
    "lab": {"python": str},
}
_BRANCH = re.compile(r"[\w][\w./-]*")
_PACKAGE = re.compile(r"[A-Za-z0-9][\w.-]*(\[[\w,.-]+\])?")
_REQUIREMENT = re.compile(rf"{_PACKAGE.pattern}([<>=!~]=?[\w.*]+(,[<>=!~]=?[\w.*]+)*)?")


@dataclass(frozen=True)
class Repository:
    """The course's public repository; without an address there is none."""

    url: str = ""
    branch: str = "main"

    def requirement(self, package: str, folder: str) -> str:
        """Return what pip is asked for, to install a package from a folder of the repository."""
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
    readme: str = ""
    """A file beside ``course.toml`` that becomes the public ``README.md``."""
    known: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Per file its own lines that a solution or a hidden test happens to hold too."""


@dataclass(frozen=True)
class Install:
    """What a student installs."""

    book: Mapping[str, str] = field(default_factory=dict)
    """For the book's notebooks: the course's packages, and the folder of each."""
    assignments: Mapping[str, str] = field(default_factory=dict)
    """For every assignment: the course's packages, and the folder of each."""
    also: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Per assignment the extras that it needs of these packages, as ``package[extra]``."""
    tools: tuple[str, ...] = ()
    """Packages of the package index, to work on assignments with."""


@dataclass(frozen=True)
class Course:
    """What others get of a course."""

    tree: Path
    """The instructor's source tree."""
    repository: Repository = field(default_factory=Repository)
    install: Install = field(default_factory=Install)
    public: Public | None = None
    lab: tuple[int, int] | None = None
    """The Python of the assignments in the browser."""
    hand_in: str = HAND_IN
    """How and where students hand in, in one sentence or a few."""

    @property
    def root(self) -> Path:
        """Return the course's folder, in which the source tree is."""
        return self.tree.resolve().parent

    def packages(self, assignment: str | None = None) -> dict[str, str]:
        """Return what an assignment needs of the course's packages, with the folder of each.

        They carry extras. Without an assignment they are those for all.
        """
        also = self.install.also
        wanted = [each for name in also if assignment in (None, name) for each in also[name]]
        found = {}
        for package, folder in self.install.assignments.items():
            name = name_of(package)
            extras = [_extras(each) for each in (package, *wanted) if name_of(each) == name]
            together = ",".join(dict.fromkeys(extra for some in extras for extra in some))
            found[f"{name}[{together}]" if together else name] = folder
        return found


def name_of(package: str) -> str:
    """Return a package's name, without its extras."""
    return package.partition("[")[0]


def _extras(package: str) -> list[str]:
    inside = package.partition("[")[2].rstrip("]")
    return [extra.strip() for extra in inside.split(",") if extra.strip()]


def load(tree: Path) -> Course:
    """Read the course of a source tree; without its files every setting has its default.

    Raises:
        WrongUse: a file cannot be read, an unknown key, or a value that is of no use.
    """
    path = tree / COURSE_NAME
    root = tree.resolve().parent
    repository, how = _repository(root / BOOK_NAME), hand_in(root)
    if not path.is_file():
        return Course(tree, repository, hand_in=how)
    table = read_table(path, _KINDS)
    install = _install(path, table.get("install", {}))
    public = _public(path, table["public"]) if "public" in table else None
    return Course(tree, repository, install, public, _lab(path, table.get("lab", {})), how)


def _lab(path: Path, table: dict[str, Any]) -> tuple[int, int] | None:
    version = re.fullmatch(r"(\d+)\.(\d+)", table.get("python", ""))
    if table and version is None:
        raise WrongUse(f'{path}: [lab] has python, such as "3.12".')
    return (int(version[1]), int(version[2])) if version else None


def _install(path: Path, table: dict[str, Any]) -> Install:
    for key in ("book", "assignments"):
        for package, folder in table.get(key, {}).items():
            if not _PACKAGE.fullmatch(package) or not _is_inside(folder):
                raise WrongUse(f"{path}: [install.{key}] takes package = its folder ({package}).")
    also = table.get("also", {})
    known = {name_of(package) for package in table.get("assignments", {})}
    for package in (str(each) for packages in also.values() for each in packages):
        if not _PACKAGE.fullmatch(package) or name_of(package) not in known:
            raise WrongUse(
                f"{path}: [install.also] takes extras of the packages of [install.assignments], "
                f'as "package[extra]", not {package!r}.'
            )
    tools = tuple(table.get("tools", ()))
    if not all(isinstance(tool, str) and _REQUIREMENT.fullmatch(tool) for tool in tools):
        raise WrongUse(f"{path}: tools takes a list of packages, each with its versions at most.")
    table["tools"] = tools
    table["also"] = {name: tuple(packages) for name, packages in also.items()}
    return Install(**table)


def _public(path: Path, table: dict[str, Any]) -> Public:
    table["known"] = {name: tuple(lines) for name, lines in table.get("known", {}).items()}
    for key in ("files", "without"):
        names = table[key] = tuple(table.get(key, ()))
        if not all(isinstance(name, str) and _is_inside(name) for name in names):
            raise WrongUse(f"{path}: {key} must be a list of paths inside the course's folder.")
    if not all(_is_inside(table.get(key, "x")) for key in _FOLDERS):
        raise WrongUse(f"{path}: {', '.join(_FOLDERS)} want a path inside the course's folder.")
    return Public(**table)


def _is_inside(name: str) -> bool:
    parts = name.removesuffix("/").split("/")
    return all(part not in ("", ".", "..") for part in parts) and "\\" not in name


def hand_in(root: Path) -> str:
    """Return how and where students of a course hand in, as its ``_config.yml`` has it.

    Raises:
        WrongUse: the file cannot be read, or has no text there.
    """
    path = root / BOOK_NAME
    value: object = _settings(path)
    for key in ("parse", "myst_substitutions", "hand_in"):
        value = value.get(key) if isinstance(value, dict) else None
    if value is not None and not isinstance(value, str):
        raise WrongUse(f"{path}: parse.myst_substitutions.hand_in must be a text ({value!r}).")
    return value or HAND_IN


def _settings(path: Path) -> dict[str, Any]:
    """Read the book's settings; of none there are none."""
    import yaml  # of the extra `grading`

    try:
        value = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise WrongUse(f"{path} cannot be read: {error}.") from error
    return value if isinstance(value, dict) else {}


def _repository(path: Path) -> Repository:
    table = _settings(path).get("repository")
    table = table if isinstance(table, dict) else {}
    url, branch = table.get("url") or "", table.get("branch") or "main"
    if not isinstance(url, str) or not (url == "" or _ADDRESS.fullmatch(url)):
        raise WrongUse(
            f"{path}: repository.url must be an address https://… or nothing ({url!r})."
        )
    if _PASSWORD.search(url):
        raise WrongUse(
            f"{path}: repository.url holds a password, and students would get it: take it out."
        )
    if not isinstance(branch, str) or not _BRANCH.fullmatch(branch):
        raise WrongUse(f"{path}: repository.branch must be a branch's name ({branch!r}).")
    return Repository(url.rstrip("/"), branch)
