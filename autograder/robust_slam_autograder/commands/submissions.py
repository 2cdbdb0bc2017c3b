"""Whose work each path of ``grade`` holds, and of which assignment.

A path is a folder ``<student>/<assignment>/``, or a notebook that is named for its student and
is outside any such layout. A path that is neither is left out with one sentence, and the others
are graded: one student's odd file must not stop the class, nor count as another student's work.
"""

import os
import stat
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.reading import submission

LAYOUT = "submitted"
"""nbgrader's folder of the students' folders."""
MACOS = "__MACOSX"


@dataclass(frozen=True)
class Claim:
    """A submission that a path holds."""

    student: str
    assignment: str
    path: Path


@dataclass(frozen=True)
class Stray:
    """A path that is left out."""

    path: Path
    why: str
    """How its sentence goes on after the path; it names no student."""


class _LeftOut(Exception):
    """Why a path is left out."""


@dataclass(frozen=True)
class Places:
    """What is in the results' folder already.

    Attributes:
        folders: the students who have results there.
        strays: files where a student's folder would be.
        own: files that grading itself writes there.
    """

    folders: Collection[str] = ()
    strays: Collection[str] = ()
    own: Collection[str] = ()


@dataclass(frozen=True)
class Reader:
    """Reads paths.

    Attributes:
        names: the assignments that there are.
        assignment: the one that the command line names, if it does.
        student: the one that the command line names, if it does.
        places: where the results are to stand.
    """

    names: Sequence[str]
    assignment: str | None
    student: str | None
    places: Places

    def read(self, paths: Iterable[Path]) -> tuple[list[Claim], list[Stray]]:
        """Tell submissions from strays.

        Args:
            paths: absolute paths, none twice, links not resolved.

        Raises:
            WrongUse: a path does not exist, or the options contradict the paths.
        """
        strays: list[Stray] = []
        modes: dict[Path, int] = {}
        for path in paths:
            try:
                modes[path] = path.lstat().st_mode
            except OSError as error:
                why = f"cannot be read ({error.strerror}): make it readable."
                strays.append(Stray(path, why))
        roots = self._roots(modes)
        claims: list[Claim] = []
        for path, mode in modes.items():
            try:
                claims.append(self._claim(path, mode, roots))
            except _LeftOut as error:
                strays.append(Stray(path, str(error)))
        apart, alike = self._apart(claims)
        kept, doubled = self._once(apart)
        return kept, [*strays, *alike, *doubled]

    def _claim(self, path: Path, mode: int, roots: Collection[Path]) -> Claim:
        if self.student:
            student = self.student
        elif self._is_in_layout(path, mode):
            if self._is_in_a_students_folder(path.parent):
                raise _LeftOut(
                    "is in another student's folder: name folders <student>/<assignment>/ alone."
                )
            student = path.parent.name
        elif not submission.is_notebook(path.name) or stat.S_ISDIR(mode):
            raise _LeftOut(_odd(path, mode))
        elif self._owner(path).parent in roots or self._is_students(path.parent):
            raise _LeftOut(self._misplaced(path))
        else:
            student = path.stem
        return Claim(self._allowed(student), self._assignment_of(path, mode), path)

    def _is_in_layout(self, path: Path, mode: int) -> bool:
        """Tell whether a path stands where a submission's folder belongs."""
        # A file manager or an editor makes folders of these names.
        is_systems = path.name == MACOS or path.name.startswith(".")
        is_any = self.assignment and stat.S_ISDIR(mode) and not is_systems
        return path.name in self.names or bool(is_any)

    def _assignment_of(self, path: Path, mode: int) -> str:
        said = [name for name in (path.name, path.stem, path.parent.name) if name in self.names]
        if self.assignment and said[:1] not in ([], [self.assignment]):
            raise _LeftOut(f"belongs to {said[0]}, not to {self.assignment}.")
        only = [] if stat.S_ISDIR(mode) or len(self.names) > 1 else self.names
        name = next(iter([*filter(None, [self.assignment]), *said, *only]), None)
        if name is None:
            raise _LeftOut("does not say its assignment: add --assignment NAME.")
        return name

    def _allowed(self, student: str) -> str:
        if student in self.names:
            raise _LeftOut("does not say whose it is: add --student NAME, or name its folder.")
        if student == MACOS:
            raise _LeftOut("was made by macOS and holds no submission: delete it.")
        if student in self.places.strays:
            raise _LeftOut(
                "has no place for its result, because a file in the results' folder has the name "
                "of its student: move that file away."
            )
        if submission.is_student(student) and student not in self.places.own:
            return student
        if self.student:
            raise WrongUse(f"{student!r} is no name for a student: use --student NAME.")
        return submission.stand_in(student)

    def _misplaced(self, path: Path) -> str:
        """Say why a notebook in a student's folder does not count as the work of its own name."""
        if path.parent.name in self.names:
            return "is in a submission's folder: name that folder, or add --student NAME."
        return (
            "is beside the folders <student>/<assignment>/: move it into the right one, "
            "or grade it alone with --student NAME."
        )

    def _owner(self, path: Path) -> Path:
        """Return the folder that is a student's, if the path is in the layout."""
        return path.parent.parent if path.parent.name in self.names else path.parent

    def _is_students(self, folder: Path) -> bool:
        return any(os.path.lexists(folder / name) for name in self.names)

    def _is_in_a_students_folder(self, folder: Path) -> bool:
        """Tell whether a folder that looks like a student's was made by another student."""
        owner = folder.parent
        return owner.parent.name == LAYOUT and self._is_students(owner)

    def _roots(self, modes: dict[Path, int]) -> set[Path]:
        """Return folders whose folders are students', as far as these paths tell."""
        in_layout = [path for path, mode in modes.items() if self._is_in_layout(path, mode)]
        others = modes.keys() - set(in_layout)
        owners = {self._owner(path) for path in others if submission.is_notebook(path.name)}
        parents = [owner.parent for owner in owners]
        # Notebooks in several folders side by side: each folder is a student's.
        several = {folder for folder in parents if parents.count(folder) > 1}
        named = {folder for folder in parents if folder.name == LAYOUT}
        return {path.parent.parent for path in in_layout} | several | named

    def _apart(self, claims: Sequence[Claim]) -> tuple[list[Claim], list[Stray]]:
        """Leave out students whose names differ from another's in capitals alone.

        Others are those who have results there, too: one who has some keeps the name.
        """
        students = {claim.student for claim in claims}
        folders = set(self.places.folders)
        why = (
            "has a student whose name differs from another's in capitals alone, and a disk may "
            "not tell them apart: name one of them anew."
        )
        kept, strays = [], []
        for claim in claims:
            others = students if claim.student in folders else students | folders
            if claim.student.casefold() in map(str.casefold, others - {claim.student}):
                strays.append(Stray(claim.path, why))
            else:
                kept.append(claim)
        return kept, strays

    def _once(self, claims: Sequence[Claim]) -> tuple[list[Claim], list[Stray]]:
        """Keep one path a submission: the one in the layout, or none where that is in doubt."""
        groups: dict[tuple[str, str], list[Claim]] = {}
        for claim in claims:
            groups.setdefault((claim.student, claim.assignment), []).append(claim)
        kept: list[Claim] = []
        for names, group in groups.items():
            if len(group) > 1 and self.student:
                raise WrongUse(
                    "A submission is handed in twice: --student NAME takes one path each."
                )
            inside = [one for one in group if (one.path.parent.name, one.path.name) == names]
            kept += group if len(group) == 1 else inside if len(inside) == 1 else ()
        why = "is a second submission of the same work: grade one of them."
        return kept, [Stray(claim.path, why) for claim in claims if claim not in kept]


def _odd(path: Path, mode: int) -> str:
    if path.name == MACOS:
        return "was made by macOS and holds no submission: delete it."
    if stat.S_ISDIR(mode):
        return (
            "does not say its assignment, or misspells it: name folders <student>/<assignment>/, "
            "or add --assignment NAME."
        )
    kind = "a file" if stat.S_ISREG(mode) else "a link" if stat.S_ISLNK(mode) else "no plain file"
    return f"is {kind} and no notebook: move it into <student>/<assignment>/, or delete it."


def missing(paths: Iterable[Path]) -> Iterator[Path]:
    """Return paths at which there is nothing."""
    for path in paths:
        try:
            path.lstat()
        except (FileNotFoundError, NotADirectoryError):
            yield path
        except OSError:
            continue
