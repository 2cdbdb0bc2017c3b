"""The instructor's notebook as the grader sees it: set-up, solution cells, exercises, cases.

An assignment is a folder of an nbgrader source tree, ``<tree>/<name>/<name>.ipynb``,
with an optional ``autograder.toml`` beside the notebook.
"""

import functools
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reading.source import defined_names, imported_modules, imports, tree_of
from robust_slam_autograder.reading.table import Kinds, read_table

CONFIG_NAME = "autograder.toml"
BEGIN_HIDDEN = "BEGIN HIDDEN TESTS"
END_HIDDEN = "END HIDDEN TESTS"
TOWN = "TOWN"
"""In test cells, the number from which a student's own data are drawn."""
MAX_NAME = 128
"""Characters of a name in nbgrader's gradebook; PostgreSQL takes no more."""
DEFAULT_PACKAGES = ("numpy", "scipy", "matplotlib")
"""Packages that student code may import beside the standard library, where none are named."""


@dataclass(frozen=True)
class Limits:
    """CPU seconds of the student's code and the tests together; see ``executor.budget``."""

    call_seconds: float = 10.0
    """One call of a student's function."""
    cell_seconds: float = 20.0
    """One cell, the student's or a test."""
    notebook_seconds: float = 120.0
    """All of one submission's passes together."""


_HINT = re.compile(r"\s*#\s*hint:\s*(.+)")
_KINDS: Kinds = {
    "title": str,
    "chapter": str,
    "sections": {...: str},
    "packages": list,
    "withheld": list,
    "hints": {...: [str]},
    "causes": {...: str},
    "hidden": {...: int},
    "limits": dict.fromkeys(Limits.__dataclass_fields__, (int, float)),
    "released": {"cells": str},
}
_NAMES = {
    "withheld": (r"[^\W\d]\w*(\.[^\W\d]\w*)*", "module names"),
    "packages": (r"[^\W\d]\w*", 'names as they are imported, such as ["numpy"]'),
}
MAX_SECONDS = 86_400.0


@dataclass(frozen=True)
class Config:
    """What ``autograder.toml`` says of one assignment."""

    title: str = ""
    chapter: str = ""
    sections: Mapping[str, str] = field(default_factory=dict)
    """Per exercise the chapter's heading to read again, as it stands there."""
    hints: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Per exercise hints for anyone who fails it, each telling more than the one before."""
    packages: tuple[str, ...] = DEFAULT_PACKAGES
    """What student code may import beside the standard library."""
    withheld: tuple[str, ...] = ()
    """Modules that student code may not import all the same, because they hold the answers."""
    limits: Limits = field(default_factory=Limits)
    causes: Mapping[str, str] = field(default_factory=dict)
    """By a text that a student's exception holds, what is most often behind it."""
    hidden: Mapping[str, int] | None = None
    """In a release: per exercise how many of its cases hold checks that students do not see."""
    cells: str = ""
    """In a release: its cells of code, as a notebook's JSON, of answers the names alone."""

    def place(self, exercise: str) -> str:
        """Say where an exercise's matter stands; empty for an assignment without a chapter."""
        heading = f", “{said}”" if (said := self.sections.get(exercise)) else ""
        return f"chapter {self.chapter}{heading}" if self.chapter else ""


@dataclass(frozen=True)
class Case:
    """One test cell: it earns its points whole or not at all."""

    grade_id: str
    exercise: str
    name: str
    points: float
    visible: str
    """Source without the hidden region: what the student has."""
    full: str
    """Source with the hidden region."""
    hint: str
    """The instructor's sentence for a failure in the hidden region; empty where there is none."""

    @property
    def has_hidden(self) -> bool:
        """Return whether the case holds checks that the student does not see."""
        return self.visible != self.full

    @functools.cached_property
    def has_town(self) -> bool:
        """Return whether it uses the student's own data: then no label is looked for."""
        return re.search(rf"\b{TOWN}\b", self.full) is not None


@dataclass(frozen=True)
class Piece:
    """A piece of code, to be run in order."""

    label: str
    """How messages name it: the solution cell's grade id, "set-up 1", "own cell"."""
    source: str
    own: bool
    """Whether only its definitions run, because it is no solution and no locked cell."""


@dataclass(frozen=True)
class Solution:
    """One solution cell: its id and the names that it must define."""

    grade_id: str
    names: tuple[str, ...]

    def is_of(self, name: str) -> bool:
        """Tell whether an exercise's or a function's name belongs to it."""
        return name == self.grade_id or name in self.names


@dataclass(frozen=True)
class Assignment:
    """All that grading needs to know of an assignment."""

    name: str
    """As nbgrader has it: the folder's."""
    path: Path
    """The instructor's notebook."""
    setup: tuple[Piece, ...]
    """The instructor's cells that are no solution and no test; they run on both sides."""
    imports: tuple[str, ...]
    """What the instructor's solution cells import, for tests that rely on it."""
    libraries: tuple[str, ...]
    """Modules that the instructor's solutions import, wherever in a cell."""
    solutions: tuple[Solution, ...]
    cases: tuple[Case, ...]
    config: Config
    given: frozenset[str]
    """What students have of the instructor's code cells, stripped, to tell their own from it."""
    marked: tuple[Cell, ...]
    """All the instructor's cells that have a grade id, for nbgrader's gradebook and formgrader."""

    @property
    def notebook(self) -> str:
        """Return the notebook's name without its ending."""
        return self.path.stem

    @property
    def exercises(self) -> tuple[str, ...]:
        """Return the exercises' names in order."""
        return tuple(dict.fromkeys(case.exercise for case in self.cases))

    @functools.cached_property
    def blocks(self) -> tuple[str, ...]:
        """Return what is cut from a cell that was merged with it: checks, and no single line."""
        checks = {case.visible.strip() for case in self.cases} - {""}
        long = {text for text in self.given if "\n" in text}
        return tuple(sorted(checks | long, key=len, reverse=True))

    @property
    def names(self) -> tuple[str, ...]:
        """Return every name that a student is asked to define."""
        return tuple(name for solution in self.solutions for name in solution.names)

    @property
    def max_score(self) -> float:
        """Return the points of all cases together."""
        return sum(case.points for case in self.cases)

    @property
    def hidden_cases(self) -> Mapping[str, int] | None:
        """Count each exercise's hidden cases; give None in a release that does not say."""
        found = Counter(case.exercise for case in self.cases if case.has_hidden)
        return dict(found) or self.config.hidden

    def names_of(self, exercise: str) -> tuple[str, ...]:
        """Return the names that an exercise's cell is to define."""
        return next((one.names for one in self.solutions if one.is_of(exercise)), ())

    def owner(self, name: str) -> str:
        """Return the grade id of the cell that an exercise's or a function's name belongs to."""
        return next((one.grade_id for one in self.solutions if one.is_of(name)), name)


def find_names(tree: Path, chosen: Iterable[str] = ()) -> list[str]:
    """List the assignments of a source tree; once each those that are chosen, where any are.

    Raises:
        WrongUse: there is no such folder, no assignment in it, or none of a chosen name.
    """
    if not tree.is_dir():
        raise WrongUse(
            f"There is no folder {tree}: name the instructor's source tree, "
            "autograder --solutions DIR …"
        )
    folders = [path for path in tree.iterdir() if not path.name.startswith(".")]
    names = sorted(path.name for path in folders if any(path.glob("*.ipynb")))
    if not names:
        raise WrongUse(f"{tree} holds no assignment: it needs NAME/NAME.ipynb.")
    wanted = list(dict.fromkeys(chosen))
    if unknown := [name for name in wanted if name not in names]:
        raise WrongUse(f"{tree} has no assignment {unknown[0]}; it has {', '.join(names)}.")
    return wanted or names


def notebook_path(folder: Path) -> Path:
    """Find the one notebook of an assignment's folder.

    Raises:
        WrongUse: there is none, or more than one and none has the folder's name.
    """
    named = folder / f"{folder.name}.ipynb"
    found = [named] if named.is_file() else sorted(folder.glob("*.ipynb"))
    if len(found) != 1:
        raise WrongUse(
            f"{folder} has {len(found)} notebooks, and an assignment is one: "
            f"{folder.name}.ipynb. Give each notebook a folder of its own."
        )
    return found[0]


def load(path: Path) -> Assignment:
    """Read the assignment whose notebook is ``path`` and the configuration beside it.

    Raises:
        WrongUse: the notebook or its ``autograder.toml`` cannot be used; names the cell or key.
    """
    try:
        cells = notebook.read(path)
    except Refused as error:
        raise WrongUse(str(error)) from error
    config = load_config(beside := path.parent / CONFIG_NAME)
    assignment = from_cells(cells, path, config)
    known = assignment.exercises
    for table, names in (("sections", config.sections), ("hints", config.hints)):
        for exercise in (one for one in names if one not in known):
            raise WrongUse(
                f"{beside}: [{table}] names {exercise!r}; the exercises are {', '.join(known)}: "
                f"correct the name, or mark its cells in {path.name} again as nbgrader has them."
            )
    return assignment


def of(tree: Path, name: str) -> Assignment:
    """Read an assignment of a source tree; see ``load``."""
    return load(notebook_path(tree / name))


def from_cells(cells: Sequence[Cell], path: Path, config: Config) -> Assignment:
    """Sort the code cells of the notebook there into set-up, solutions and cases.

    Raises:
        WrongUse: two cells share a grade id, a hidden region is not closed, there is no case.
    """
    name = path.resolve().parent.name
    code = [cell for cell in cells if cell.kind == "code"]
    marked = tuple(cell for cell in cells if cell.grade_id is not None)
    if any(cell.grade_id is None and (cell.grade or cell.solution) for cell in cells):
        raise WrongUse(f"{name} has a test or solution cell without a grade id: name it.")
    ids = Counter(cell.grade_id or "" for cell in marked)
    for one in [name, path.stem, *ids]:
        if len(one) > MAX_NAME:
            raise WrongUse(f"{one} is a name of more than {MAX_NAME} characters: shorten it.")
        if ids[one] > 1:
            raise WrongUse(f"{name} has two cells with the grade id {one}: rename one.")
    answers = [cell for cell in code if cell.solution]
    solutions = tuple(
        Solution(cell.grade_id or "", tuple(defined_names(cell.source))) for cell in answers
    )
    known = {each for one in solutions for each in (one.grade_id, *one.names)}
    tests = [cell for cell in code if cell.grade and not cell.solution]
    if not tests:
        raise WrongUse(f"{name} holds no test cell: mark its tests as nbgrader has them.")
    cases = tuple(_case(cell, known) for cell in tests)
    plain = [cell for cell in code if not cell.solution and not cell.grade]
    given = ["", *(cell.source for cell in plain), *(case.visible for case in cases)]
    return Assignment(
        name=name,
        path=path,
        # Locked cells run whole; of cells without nbgrader's marks the definitions alone.
        setup=tuple(
            Piece(f"set-up {number}", cell.source, own=not cell.locked)
            for number, cell in enumerate(plain, start=1)
        ),
        imports=tuple(found for cell in answers if (found := imports(cell.source))),
        libraries=tuple(
            dict.fromkeys(name for cell in answers for name in imported_modules(cell.source))
        ),
        solutions=solutions,
        cases=cases,
        config=config,
        given=frozenset(text.strip() for text in given),
        marked=marked,
    )


def _case(cell: Cell, known: set[str]) -> Case:
    grade_id = cell.grade_id or ""
    exercises = [name for name in known if grade_id.startswith(f"{name}-")]
    # Not our naming: in another instructor's tree each test cell is an exercise of its own.
    exercise = max(exercises, key=len, default=grade_id)
    visible, hidden = split_hidden(cell.source, grade_id)
    match = _HINT.match(hidden)
    return Case(
        grade_id=grade_id,
        exercise=exercise,
        name=grade_id[len(exercise) + 1 :] or "tests",
        points=cell.points,
        visible=visible,
        full=cell.source,
        hint=match.group(1).strip() if match else "",
    )


def split_hidden(source: str, grade_id: str) -> tuple[str, str]:
    """Split a test cell into what the student has and the text of its hidden regions.

    Raises:
        WrongUse: a region is opened twice or not closed.
    """
    parts: tuple[list[str], list[str]] = ([], [])
    inside = False
    for line in source.split("\n"):
        if BEGIN_HIDDEN in line or END_HIDDEN in line:
            if inside == (BEGIN_HIDDEN in line):
                raise WrongUse(f"Cell {grade_id}: hidden regions must open and close in turn.")
            inside = not inside
        else:
            parts[inside].append(line)
    if inside:
        raise WrongUse(f"Cell {grade_id}: a hidden region is not closed ({END_HIDDEN}).")
    return "\n".join(parts[False]), "\n".join(parts[True])


def load_config(path: Path) -> Config:
    """Read ``autograder.toml``; without the file every setting has its default.

    Raises:
        WrongUse: not TOML, an unknown key, or a value of the wrong type.
    """
    table = read_table(path, _KINDS) if path.is_file() else {}
    for key, (form, what) in _NAMES.items():
        names = table.setdefault(key, getattr(Config, key))
        if not all(isinstance(name, str) and re.fullmatch(form, name) for name in names):
            raise WrongUse(f"{path}: {key} must be a list of {what}.")
        table[key] = tuple(names)
    limits, released = table.pop("limits", {}), table.pop("released", {})
    if not all(0 < seconds <= MAX_SECONDS for seconds in limits.values()):
        raise WrongUse(f"{path}: limits are seconds, more than 0 and at most {MAX_SECONDS:.0f}.")
    hints = {name: tuple(some) for name, some in table.pop("hints", {}).items()}
    return Config(**table, **released, hints=hints, limits=Limits(**limits))


def released(folder: Path) -> Assignment | None:
    """Read what a release's folder says of its assignment; None where it says nothing.

    Cases whose checks are all hidden are left out: nothing of them can pass or fail.

    Raises:
        WrongUse: its ``autograder.toml`` is not as the release wrote it.
    """
    config = load_config(folder / CONFIG_NAME)
    if not config.cells:
        return None
    cells = notebook.parse(config.cells.encode(), CONFIG_NAME)
    found = from_cells(cells, folder / f"{folder.resolve().name}.ipynb", config)
    return replace(found, cases=tuple(c for c in found.cases if tree_of(c.visible).body))
