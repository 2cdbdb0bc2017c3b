"""What is most often behind an exception, in a sentence that says what to do about it.

What is particular to an assignment stands in its ``autograder.toml``, under ``[causes]``.
"""

import ast
import itertools
import re
from collections.abc import Mapping

from robust_slam_autograder.executor.session import StudentError

NAN = (
    "NaN equals nothing, itself included. It comes from 0/0, from inf - inf, or from the root "
    "or the logarithm of a negative number."
)
NO_VALUE = "A function that ends without a return statement returns None."

MAX_NAME = 30
MAX_LINE = 200

_LIST = "A list does no arithmetic: make it an array first, with np.asarray."
_SHAPES = (
    "Two arrays have shapes that do not fit each other: print the shape of each, and compare "
    "with the shapes in the statement."
)
_NONE = f"A value is None. {NO_VALUE}"


_CAUSES = {
    r"^(TypeError|AttributeError): .*NoneType": _NONE,
    r"^TypeError: list indices must be integers or slices, not"
    r"|only integer scalar arrays can be converted to a scalar index": (
        "A list takes one integer as its index: make it an array first, with np.asarray."
    ),
    r"^TypeError: .*(operand type|not supported between|multiply sequence).*": _LIST,
    r"^AttributeError: 'list' object has no attribute": _LIST,
    r"^TypeError: .*positional argument|^TypeError: .*unexpected keyword argument": (
        "The arguments of your function must be those of the statement, in the same order."
    ),
    r"broadcast|not aligned|mismatch in its core dimension|cannot reshape|inhomogeneous"
    r"|dimensions .*must match|sequence\. The requested array": _SHAPES,
    r"truth value of an array": (
        "`if`, `and` and `or` take one truth value, and an array holds many: use np.where, "
        "`&` and `|`, or np.any and np.all."
    ),
    r"^TypeError: only .*arrays can be converted to Python scalars"
    r"|^TypeError: must be real number, not (list|numpy)": (
        "float() and the functions of math take one number: use NumPy's function of that name."
    ),
    r"Cannot cast ufunc": (
        "An array of integers keeps no fractions: make it one of floats, "
        "np.asarray(x, dtype=float)."
    ),
    r"^IndexError: arrays used as indices must be": (
        "An array used as an index must hold integers or booleans."
    ),
    r"^IndexError: .*out of (bounds|range)": (
        "Indices count from 0: the last of n entries has the index n - 1."
    ),
    r"^LinAlgError: Singular matrix": (
        "The matrix is singular: the equations leave some unknown free. Fix what they leave "
        "free, or use each equation that the statement gives."
    ),
    r"^LinAlgError: .*must be square": (
        "Solving and inverting take a square matrix: print its shape."
    ),
    r"must not contain infs or NaNs|did not converge": f"An array holds NaN or inf. {NAN}",
    r"^IndentationError: (unexpected|.*after function)|^SyntaxError: '(return|yield)' outside": (
        "A function must be whole in one cell: was a cell split inside of it? Merge its halves."
    ),
    r"^ZeroDivisionError": "A number is divided by 0: which input makes it 0?",
    r"^RecursionError": "A function calls itself without end: which call should be the last?",
}
"""What is behind an exception, by a pattern of it as ``Type: message``; the first counts."""


def of(error: StudentError, cell: str, known: Mapping[str, str]) -> str:
    """Say on a line of its own what most often causes an exception; empty where not known.

    Args:
        error: what the student's code raised.
        cell: the cell that the exercise asks for.
        known: the assignment's own sentences, by a text that the exception holds.
    """
    lines = cell.splitlines()
    line = lines[error.line - 1] if error.line and 0 < error.line <= len(lines) else ""
    told = likely(f"{type(error).__name__}: {error}", line, known)
    return f"\n{told}" if told else ""


def likely(told: str, line: str = "", known: Mapping[str, str] | None = None) -> str:
    """Say what most often causes an exception; empty where nothing is known.

    Args:
        told: the exception, as ``Type: message``.
        line: the line of code that raised it, where known.
        known: as in ``of``.
    """
    own = (sentence for text, sentence in (known or {}).items() if text in told)
    name = _indexed(line) if "list indices" in told else ""
    if name:
        return f"{name} is a list; make it an array: {name} = np.asarray({name})."
    found = (sentence for pattern, sentence in _CAUSES.items() if re.search(pattern, told))
    return next(itertools.chain(own, found), "")


def _indexed(line: str) -> str:
    """Return the one name that a line of code takes entries of; empty where there are several."""
    if len(line) > MAX_LINE:  # student code is read here, and a long line may take for ever
        return ""
    try:
        tree = ast.parse(line.strip().rstrip(":"))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ""
    found = {
        node.value.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name)
    }
    name = found.pop() if len(found) == 1 else ""
    return name if len(name) <= MAX_NAME else ""
