"""What a visible test that fails says to the student.

It may quote the student's own exceptions, so it is for the visible pass alone.
"""

from __future__ import annotations

import ast
import traceback

from robust_slam_autograder.executor.session import SessionFault, StudentError
from robust_slam_autograder.reading.assignment import Case
from robust_slam_autograder.reading.source import plain_python
from robust_slam_autograder.student.wire import WireError

MAX_MESSAGE = 600
MAX_EXPLAINED = 1_200
"""A message and what explains it."""
UNEXPLAINED = "A check of this case did not pass."
NOT_WRITTEN = "Not written yet: the function still raises NotImplementedError."
LEFT_OUT = "A cell of your own ran longer than it may, or ended the process, and is left out"


def label(case: Case) -> str:
    """The file name that a case's cell is compiled under."""
    return f"<{case.grade_id}>"


def left_out(error: NameError) -> str:
    """Say that a name is missing because the cell that defines it was left out."""
    return clip(f"{LEFT_OUT}: {error}.")


def undefined(error: NameError, cell_error: StudentError | SessionFault | None) -> str:
    """Say why a name that a test uses is not defined.

    Args:
        error: raised by the test.
        cell_error: what the student's cell of that name raised, if it did.
    """
    if isinstance(cell_error, StudentError):
        return clip(f"Your cell stops with {_told(cell_error)}.")
    return clip(
        f"{error.name} is not defined in your notebook, or is nothing that can be checked."
    )


def message(error: Exception, source: str, case: Case) -> str:
    """Say what happened, from the exception that ended a visible test.

    Args:
        error: raised by the test or by the student's function.
        source: the test's.
        case: the test.
    """
    return clip(_message(error, source, case))


def _message(error: Exception, source: str, case: Case) -> str:
    if isinstance(error, StudentError):
        if isinstance(error, NotImplementedError):
            return NOT_WRITTEN
        if type(error).__name__ == WireError.__name__:
            return f"What your function returned cannot be checked: {str(error).rstrip('.')}."
        return f"Your function raised {_told(error)}."
    if isinstance(error, AssertionError):
        return str(error) or f"This does not hold: {_failing_check(error, source, case)}"
    return f"The check could not use what came back: {type(error).__name__}: {error}"


def _told(error: StudentError) -> str:
    what = f"{type(error).__name__}: {error}".rstrip(" :.")
    return f"{what} (line {error.line} of your cell)" if error.line else what


def _failing_check(error: BaseException, source: str, case: Case) -> str:
    """The statement of a visible test that did not hold."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == label(case)]
    for node in ast.walk(ast.parse(plain_python(source))):
        if isinstance(node, ast.Assert) and lines and node.lineno == lines[-1]:
            return ast.unparse(node.test)
    return "a check of this case"


def clip(text: str, most: int = MAX_MESSAGE) -> str:
    """Cut a text to the length that a message may have."""
    return text if len(text) <= most else text[: most - 1] + "…"
