"""What a visible test that fails says to the student.

It may quote the student's own exceptions, so it is for the visible pass alone.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, replace

from robust_slam_autograder.executor.session import SessionFault, StudentError
from robust_slam_autograder.grading import pythons
from robust_slam_autograder.grading.explain import HERE, failing_test
from robust_slam_autograder.grading.results import Compared, Ending, Words
from robust_slam_autograder.protocol.wire import WireError
from robust_slam_autograder.reading.assignment import Case
from robust_slam_autograder.reading.source import plain_python

MAX_MESSAGE = 600
MAX_EXPLAINED = 1_200
"""A message and what explains it."""
UNEXPLAINED = "A check of this case did not pass."
NOT_WRITTEN = "Not written yet: the function still raises NotImplementedError."
LEFT_OUT = "A cell of your own ran longer than it may, or ended the process, and is left out"
CALLS = "\n{} calls {}, which does not pass: begin there."
STOPPED = "Not run: your code depends on {}, which ran longer than it may: begin there."
NO_HINT = "A hidden check of this case did not pass."
_NOT_RUN = "; the rest of this exercise was not run."
FAULT_SENTENCES = {
    Ending.TIMEOUT: f"Your code ran longer than it may{_NOT_RUN}",
    Ending.DIED: f"Your code ended its whole process{_NOT_RUN}",
}


@dataclass(frozen=True)
class Told:
    """What a student is told of a case that failed; its fields are those of ``CaseResult``."""

    message: str = ""
    words: Words = Words.CHECK
    gist: str = ""
    raised: str = ""
    compared: Compared | None = None
    returned: tuple[str, ...] | None = None

    def further(self, line: str, compared: Compared | None = None) -> Told:
        """Add a line that explains the message, which begins with its line break.

        Where a check has named values itself, as ``close`` of the course's assignments does, the
        line comes in place of these: it names the call too.
        """
        if not line:
            return self
        gist = self.gist or self.message
        before = gist if self.words is Words.CHECK else self.message
        text = clip(before + line, MAX_EXPLAINED)
        return replace(self, message=text, gist=gist, compared=compared)

    def beside(self, line: str = "") -> Told:
        """Add a line that looks elsewhere, where the message is not the grader's own."""
        if not line or self.words is Words.GRADER:
            return self
        text = clip(self.message + line, MAX_EXPLAINED)
        return replace(self, message=text, gist=self.gist or self.message)


def label(case: Case) -> str:
    """Return the file name that a case's cell is compiled under."""
    return f"<{case.grade_id}>"


def own(sentence: str) -> Told:
    """Tell a sentence of the grader's own."""
    return Told(clip(sentence), Words.GRADER)


def left_out(error: NameError) -> Told:
    """Say that a name is missing because the cell that defines it was left out."""
    return _quoting(LEFT_OUT, f": {error}.")


def lost(own: StudentError) -> str:
    """Say on a line of its own that a cell of the student's own could not be read."""
    return f"\n{_raised('A cell of your own is left out: ', own).message}"


def undefined(error: NameError, cell_error: StudentError | SessionFault | None) -> Told:
    """Say why a name that a test uses is not defined.

    Args:
        error: raised by the test.
        cell_error: what the student's cell of that name raised, if it did.
    """
    if isinstance(cell_error, StudentError):
        return _raised("Your cell stops with ", cell_error)
    return own(f"{error.name} is not defined in your notebook, or is nothing that can be checked.")


def message(error: Exception, source: str, case: Case, owners: Mapping[str, str]) -> Told:
    """Say what happened, from what a visible test of this source or a student's function raised.

    ``owners`` has for each function that students are asked for the cell that it belongs to.
    """
    if isinstance(error, NotImplementedError) and isinstance(error, StudentError):
        return own(_not_written(error, owners))
    if isinstance(error, StudentError):
        if type(error).__name__ == WireError.__name__:
            why = str(error).rstrip(".")
            return _quoting("What your function returned cannot be checked", f": {why}.")
        return _raised("Your function raised ", error, elsewhere(error, owners))
    if isinstance(error, AssertionError):
        test = failing_test(error, plain_python(source), label(case))
        what = ast.unparse(test) if test else "a check of this case"
        said = str(error) or f"This does not hold: {what}"
        return Told(clip(said), gist=clip(said.partition(f"\n{HERE}")[0]))
    return _raised("The check could not use what came back: ", error)


def _not_written(error: StudentError, owners: Mapping[str, str]) -> str:
    called, raiser = _ends(error)
    if called == raiser or not owners.keys() >= {called, raiser}:
        return NOT_WRITTEN
    return f"{called} calls {raiser}, which is not written yet: it raises NotImplementedError."


def elsewhere(error: StudentError, owners: Mapping[str, str]) -> str:
    """Return the cell of another exercise, where an exception rose there; else empty."""
    called, raiser = (owners.get(name, "") for name in _ends(error))
    return raiser if called and called != raiser else ""


def _ends(error: StudentError) -> tuple[str, str]:
    return (error.functions or ("",))[0], (error.functions or ("",))[-1]


def _raised(begins: str, error: Exception, cell: str = "") -> Told:
    """Quote an exception behind the beginning of a sentence."""
    name = type(error).__name__
    rest = f": {error}".rstrip(" :.")
    line = error.line if isinstance(error, StudentError) else 0
    where = f" (line {line} of your cell{f' for {cell}' if cell else ''})" if line else ""
    return _quoting(f"{begins}{name}", f"{rest}{where}.", name)


def _quoting(gist: str, rest: str, raised: str = "") -> Told:
    return Told(clip(gist + rest), Words.STUDENT, clip(f"{gist}."), clip(raised))


def clip(text: str, most: int = MAX_MESSAGE) -> str:
    """Cut a text to the length that a message may have, and folders of this machine from it."""
    text = pythons.without_paths(text)
    return text if len(text) <= most else text[: most - 1] + "…"
