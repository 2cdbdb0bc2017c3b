"""Makes the student release with nbgrader, and looks at it before anyone gets it."""

import json
import logging
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from nbgrader.converters import GenerateAssignment
from nbgrader.converters.base import NbGraderException
from nbgrader.coursedir import CourseDirectory
from nbgrader.preprocessors import SaveCells

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.nbgrader.settings import nbgrader_settings
from robust_slam_autograder.publishing import course as courses
from robust_slam_autograder.publishing import handout, secret_lines, staging, wheels
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.source import compiled, defined_names, imports, names_read


def release(
    tree: Path, names: Sequence[str], out: Path, *, misconceptions: Path | None = None
) -> list[Path]:
    """Make the release of assignments: stubs for solutions, no hidden tests, locked cells.

    Args:
        tree: the instructor's source tree.
        names: which assignments; all of the tree where empty.
        out: the releases' folder; ``<out>/<name>/`` and ``<out>/<name>.zip`` are replaced.
        misconceptions: what ``autograder misconceptions`` has written; the release has it too.

    Returns:
        the released notebooks, each with its archive beside its folder.

    Raises:
        WrongUse: an assignment does not exist or cannot be read.
        GraderFailure: nbgrader failed, or a release still holds what it must not.
    """
    names = assignments.find_names(tree, names)
    sources = [assignments.notebook_path(tree / name) for name in names]
    for name, source in zip(names, sources, strict=True):
        assignments.load(source)
        if (out / name).resolve().is_relative_to(tree.resolve()):
            raise WrongUse(f"{out} is in the source tree, which must stay as it is: --out DIR.")
    course = courses.load(tree)
    with staging.made_beside(out) as part, tempfile.TemporaryDirectory() as built:
        packages = wheels.build(course, Path(built))
        for name, source in zip(names, sources, strict=True):
            _run_nbgrader(tree, name, part)
            _describe(source, part / name)
            if misconceptions is not None:
                _label(source, part / name, misconceptions)
            _inspect(source, part / name)
            handout.write(part / name, course, packages, part / f"{name}.zip")
        for name in names:
            staging.put(part / name, out / name)
            staging.put(part / f"{name}.zip", out / f"{name}.zip")
    return [out / name / source.name for name, source in zip(names, sources, strict=True)]


def _run_nbgrader(tree: Path, name: str, out: Path) -> None:
    config = nbgrader_settings(str(tree.resolve().parent))
    config.CourseDirectory.source_directory = str(tree.resolve())
    config.CourseDirectory.release_directory = str(out)
    config.CourseDirectory.assignment_id = name
    config.GenerateAssignment.no_database = True
    converter = GenerateAssignment(coursedir=CourseDirectory(config=config), config=config)
    # The gradebook is the grader's to write; a release needs none.
    converter.preprocessors = [pp for pp in converter.preprocessors if pp is not SaveCells]
    with _errors(converter.log) as said:
        try:
            converter.start()
        except NbGraderException as error:
            raise GraderFailure(f"nbgrader could not release {name}: {_reason(said)}") from error


def _describe(source: Path, made: Path) -> None:
    """Tell the student's own check what to check, whatever becomes of the notebook.

    That is the released cells of code, of an answer its names alone, and of hidden cases how many
    there are.
    """
    assignment = assignments.load(source)
    if assignment.config.hidden is not None or assignment.config.cells:
        raise WrongUse(
            f"{source.parent}: the release writes [hidden] and [released]: delete them here."
        )
    answers = {cell.grade_id: cell.source for cell in notebook.read(source) if cell.solution}
    cells = json.loads((made / source.name).read_text(encoding="utf-8"))["cells"]
    for cell in cells:
        name = cell["metadata"].get("nbgrader", {}).get("grade_id")
        if name in answers:
            cell["source"] = _names_alone(answers[name], assignment)
    kept = ("cell_type", "metadata", "source")
    code = [{key: one[key] for key in kept} for one in cells if one["cell_type"] == "code"]
    text = json.dumps({"nbformat": 4, "cells": code}).replace("'", "\\u0027")
    counts = assignment.hidden_cases or {}
    path = made / assignments.CONFIG_NAME
    before = path.read_text(encoding="utf-8").strip() if path.is_file() else ""
    lines = [
        *([before, ""] if before else []),
        "[hidden] # cases that you do not see",
        *(f"{json.dumps(name)} = {count}" for name, count in counts.items()),
        "\n[released] # what `autograder check` runs: the checks in your notebook do not count",
        f"cells = '{text}'",
    ]
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def _names_alone(answer: str, assignment: Assignment) -> str:
    """Reduce an answer to the names that it defines, and to imports that visible tests rely on."""
    used = names_read(*(compiled(case.visible, case.grade_id) for case in assignment.cases))
    lines = [
        line for line in imports(answer).splitlines() if used & names_read(compiled(line, ""))
    ]
    return "\n".join([*lines, *(f"{name} = ..." for name in defined_names(answer))])


def _label(source: Path, made: Path, misconceptions: Path) -> None:
    """Let the student's own check name what a wrong answer to a visible case looks like."""
    found = tables.read_made(misconceptions, source)
    if found is not None:
        tables.write(made / tables.FILE, found.exercises)


@contextmanager
def _errors(log: logging.Logger) -> Iterator[list[str]]:
    """Collect what nbgrader logs as errors: outside its own commands no one else reads it."""
    said: list[str] = []
    handler = logging.Handler(logging.ERROR)
    handler.emit = lambda record: said.append(record.getMessage())  # type: ignore[method-assign]
    log.addHandler(handler)
    try:
        yield said
    finally:
        log.removeHandler(handler)


def _reason(said: Sequence[str]) -> str:
    """The last line of a traceback, which says what was wrong; else of all that was said."""
    tracebacks = [text for text in said if text.startswith("Traceback")]
    return [*said, *tracebacks][-1].strip().splitlines()[-1]


def _inspect(source: Path, made: Path) -> None:
    """Look for hidden lines and solutions in a release, whatever nbgrader thinks of it."""
    telling = secret_lines.telling_lines([cell.source for cell in notebook.read(source)])
    for name, lines in secret_lines.lines_below(made):
        for mark in (assignments.BEGIN_HIDDEN, "BEGIN SOLUTION", "# hint:"):
            if any(mark in line for line in lines):
                raise GraderFailure(f"The release of {name} would hold {mark!r}: nothing written.")
        leaks = sorted(telling & lines)
        if leaks:
            what = f"a line of a solution or a hidden test ({leaks[0]})"
            raise GraderFailure(f"The release of {name} would hold {what}: nothing written.")
    released = {cell.grade_id: cell.source for cell in notebook.read(made / source.name)}
    for case in assignments.load(source).cases:
        if released.get(case.grade_id, "").strip() != case.visible.strip():
            raise GraderFailure(f"Case {case.grade_id} is not in the release as it should be.")
