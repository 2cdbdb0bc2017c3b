"""Nothing that student code says in the hidden pass reaches the result or the terminal.

Each exercise of the assignment here is one way to say something. All hidden checks hand
over the canary, which is what student code tries to pass on.
"""

import textwrap
from pathlib import Path

import pytest
from robust_slam_autograder.grading import messages, results
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.reading.assignment import Assignment, Config, Limits

from .. import toy

CANARY = "CANARY_INPUT"
HINT = "Try other texts."
HIDDEN = f"got = {{name}}('{CANARY}')\nassert got == 'right', f'given {CANARY}, got {{{{got}}}}'\n"
USES = f"table = {{{{'a': 1}}}}\nassert table[{{name}}('{CANARY}')] == 1\n"
WAYS = {
    "name_error": "raise NameError('LEAK ' + x)",
    "name_of_a_name_error": "raise NameError('gone', name=x)",
    "undefined_name": "eval(x)",
    "unbound_local": "raise UnboundLocalError(x)",
    "name_error_by_a_subclass": "raise type(x, (NameError,), {})(x)",
    "name_error_in_a_helper": "helper(x)",
    "class_name": "raise type(x, (Exception,), {})()",
    "class_name_of_a_key_error": "raise type(x, (KeyError,), {})(1)",
    "message_class": "raise type('Odd', (ValueError,), {'__str__': lambda self: x})()",
    "value_error": "raise ValueError([x])",
    "key_error": "raise KeyError(x)",
    "attribute_error": "getattr(x, x)",
    "import_error": "__import__(x)",
    "syntax_error": "compile('1 +', x, 'exec')",
    "not_written": "raise NotImplementedError(x)",
    "assertion": "assert False, x",
    "stop_iteration": "raise StopIteration(x)",
    "system_exit": "raise SystemExit(x)",
    "interrupt": "raise KeyboardInterrupt(x)",
    "generator_exit": "raise GeneratorExit(x)",
    "group": "raise ExceptionGroup(x, [ValueError(x)])",
    "chained": "raise ValueError(x) from NameError(x)",
    "wire_error": "raise type('WireError', (Exception,), {})(x)",
    "type_that_cannot_cross": "return type(x, (), {})()",
    "session_fault": "raise type('SessionFault', (BaseException,), {'kind': x})(x)",
    "answer": "return x",
    "answer_that_is_no_text": "return [x]",
    "warning": "import warnings; warnings.warn(x)",
    "deprecation": "import warnings; warnings.warn(x, DeprecationWarning)",
    "printed": "import sys; print(x); print(x, file=sys.stderr); sys.__stderr__.write(x)",
    "logged": "import logging; logging.error(x)",
    "audible_exit": "import sys; sys.exit(x)",
    "death": "import os; keep(x); os._exit(1)",
}
BY_KEY = ("answer_by_key", "return x")
"""The test itself fails on what comes back, with a KeyError whose text is that."""
HELPERS = "def helper(x):\n    raise NameError(f'name {x!r} is not defined', name=x)\n"


def assignment() -> Assignment:
    """One exercise a way: a visible check that passes, then the hidden one."""
    cells = [toy.cell(toy.SETUP, "setup", locked=True)]
    for name in [*WAYS, BY_KEY[0]]:
        hidden = (USES if name == BY_KEY[0] else HIDDEN).format(name=name)
        region = f"### BEGIN HIDDEN TESTS\n# hint: {HINT}\n{hidden}### END HIDDEN TESTS\n"
        cells += [
            toy.cell(f"def {name}(x):\n    pass\n", name, solution=True),
            toy.test_cell(f"assert {name}('open') is None\n{region}", f"{name}-case", 1),
        ]
    limits = Limits(call_seconds=20, cell_seconds=20, notebook_seconds=120)
    return toy.assignment(Config(limits=limits), value=toy.notebook(cells))


def grade(tests: Assignment, *own: str, kept: Path) -> Result:
    """Grade a submission that tries every way; ``kept`` outlives its processes."""
    keep = "def keep(x): KEPT.write_text(x)\n"
    memory = f"from pathlib import Path\nKEPT = Path({str(kept)!r})\n{keep}"
    # It names what the cell that is left out should define, so that every NameError might be
    # its fault.
    again = "if KEPT.exists():\n    raise NameError(KEPT.read_text())\ndef unused(): boom\n"
    cells = [toy.cell(source) for source in [memory, HELPERS, *own]]
    for name, body in [*WAYS.items(), BY_KEY]:
        lines = f"def {name}(x):\n    if x == 'open': return\n{textwrap.indent(body, '    ')}\n"
        cells.append(toy.cell(again + lines, name, solution=True))
    return toy.graded(toy.notebook(cells), tests)


@pytest.mark.parametrize(
    "own", [(), ("import os\nboom = os._exit(0)\n",)], ids=["plain", "with a cell left out"]
)
def test_a_hidden_check_says_nothing_of_the_students(own, tmp_path, capfd):
    tests = assignment()
    result = grade(tests, *own, kept=tmp_path / "kept")
    cases = {exercise.name: exercise.cases[0] for exercise in result.exercises}
    assert set(cases) == {*WAYS, BY_KEY[0]} and result.score == 0
    said = results.as_text(result) + "".join(capfd.readouterr())
    assert CANARY not in said
    assert {case.message for case in cases.values()} == {HINT}
    constants = {HINT, *messages.FAULT_SENTENCES.values()}
    assert {exercise.message for exercise in result.exercises} <= constants
