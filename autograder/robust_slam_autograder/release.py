"""Makes the student release with nbgrader, and looks at it before anyone gets it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from nbgrader.converters import GenerateAssignment
from nbgrader.converters.base import NbGraderException
from nbgrader.coursedir import CourseDirectory
from nbgrader.preprocessors import SaveCells
from traitlets.config import Config

from robust_slam_autograder import assignment as assignments
from robust_slam_autograder import notebook
from robust_slam_autograder.errors import GraderFailure, WrongUse

STUB = 'raise NotImplementedError("Exercise: write this function, then delete this line.")'


def release(tree: Path, names: Sequence[str], out: Path) -> list[Path]:
    """Make the release of assignments: stubs for solutions, no hidden tests, locked cells.

    Args:
        tree: the instructor's source tree.
        names: which assignments; all of the tree where empty.
        out: the releases' folder; ``<out>/<name>/`` is replaced as a whole.

    Returns:
        the released notebooks.

    Raises:
        WrongUse: an assignment does not exist or cannot be read.
        GraderFailure: nbgrader failed, or a release still holds what it must not.
    """
    known = assignments.find_names(tree)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise WrongUse(f"{tree} has no assignment {unknown[0]}; it has {', '.join(known)}.")
    return [_release_one(tree, name, out) for name in names or known]


def _release_one(tree: Path, name: str, out: Path) -> Path:
    source = assignments.notebook_path(tree / name)
    assignments.load(source)
    with tempfile.TemporaryDirectory(prefix="release-") as folder:
        _run_nbgrader(tree, name, Path(folder))
        made = Path(folder) / name / source.name
        _inspect(source, made)
        target = out / name
        if target.exists():
            shutil.rmtree(target)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(made.parent, target)
    return target / source.name


def _run_nbgrader(tree: Path, name: str, out: Path) -> None:
    config = Config()
    config.CourseDirectory.root = str(tree.resolve().parent)
    config.CourseDirectory.source_directory = str(tree.resolve())
    config.CourseDirectory.release_directory = str(out)
    config.CourseDirectory.assignment_id = name
    config.ClearSolutions.code_stub = {"python": STUB}
    config.GenerateAssignment.no_database = True
    converter = GenerateAssignment(coursedir=CourseDirectory(config=config), config=config)
    # The gradebook is the grader's to write; a release needs none.
    converter.preprocessors = [pp for pp in converter.preprocessors if pp is not SaveCells]
    try:
        converter.start()
    except NbGraderException as error:
        raise GraderFailure(
            f"nbgrader could not release {name}: see its message above."
        ) from error


def _inspect(source: Path, made: Path) -> None:
    """Look for hidden lines and solutions in a release, whatever nbgrader thinks of it."""
    text = made.read_text(encoding="utf-8")
    for mark in (assignments.BEGIN_HIDDEN, "BEGIN SOLUTION", "# hint:"):
        if mark in text:
            raise GraderFailure(
                f"The release {made.name} still holds {mark!r}: nothing was written."
            )
    released = {cell.grade_id: cell.source for cell in notebook.read(made) if cell.grade_id}
    for case in assignments.load(source).cases:
        if released.get(case.grade_id, "").strip() != case.visible.strip():
            raise GraderFailure(f"Case {case.grade_id} is not in the release as it should be.")
