"""Points need evidence; messages teach; hidden tests give one bit and the hint."""

import ast
import os
import sys
from dataclasses import replace
from typing import Any

import pytest
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading import messages
from robust_slam_autograder.grading.passes import Pass
from robust_slam_autograder.grading.results import CaseResult, ExerciseResult, Result
from robust_slam_autograder.reading.assignment import Assignment, Config, Limits
from robust_slam_autograder.sandbox import Unsandboxed

from .. import toy
from ..as_user import ROOT, ended

POSITIVE = "def double(x):\n    return abs(2 * np.asarray(x))\n"
DIES = "import os\ndef double(x): return 6 if x == 3 else os._exit(0)\n"


def grade(double: str = toy.RIGHT, tests: Assignment | None = None, seed: int = 3) -> Result:
    return toy.graded(toy.answer(double), tests, seed=seed)


def limited(double_random: str | None = None, **limits: float) -> Assignment:
    return toy.assignment(Config(limits=Limits(**limits)), double_random=double_random)


def exercise(result: Result, name: str = "double") -> ExerciseResult:
    (found,) = [each for each in result.exercises if each.name == name]
    return found


def case(result: Result, name: str) -> CaseResult:
    (found,) = [each for each in exercise(result).cases if each.name == name]
    return found


def outcome(result: Result) -> tuple[str, float, str]:
    """How the first exercise ended, its points, and how the other one ended."""
    double = exercise(result)
    return double.status, double.score, exercise(result, "apply").status


def test_each_case_earns_its_points_whole_or_not_at_all():
    result = grade(POSITIVE)
    assert (result.score, result.max_score, result.status) == (14, 20, "graded")
    assert outcome(result) == ("partial", 4, "passed")
    assert case(result, "random").message == "Try negative numbers."
    own = toy.checked(toy.answer(POSITIVE))
    assert own.score == own.max_score == toy.MOST, "a check runs the visible tests alone"


@pytest.mark.parametrize(
    ("answer", "sentence"),
    [
        ("def double(x): return 7\n", "double(3) is 6: add the number to itself"),
        ("def double(x): raise NotImplementedError\n", messages.NOT_WRITTEN),
        ("def double(x):\n    return x['a']\n",
         "TypeError: 'int' object is not subscriptable (line 2 of your cell)."),
        ("def double(x): return {1}\n",
         "What your function returned cannot be checked: a value"),
        ("double = (\n", "Your cell stops with SyntaxError: '(' was never closed (line 1"),
        ("Double = 3\n", "double is not defined in your notebook"),
        ("double = {1}\n", "double is not defined in your notebook, or is nothing that can be"),
        ("double = 3\n",
         "The check could not use what came back: TypeError: 'int' object is not"),
    ],
)  # fmt: skip
def test_visible_failures_tell_what_happened(answer, sentence):
    result = grade(answer)
    assert sentence in exercise(result).message
    assert exercise(result).status == "failed" and result.score == 10


def test_a_check_without_words_is_told_by_its_text():
    message = case(grade("def double(x): return 6\n"), "random").message
    assert message.splitlines()[0] == "This does not hold: np.shape(double([1, 2])) == (2,)"


def test_a_missing_exercise_is_named():
    result = toy.graded(toy.notebook([toy.cell(toy.RIGHT, "double", solution=True)]))
    assert exercise(result, "apply").status == "missing"
    assert "There is no cell apply" in exercise(result, "apply").message
    assert result.reason == "The cell apply was not found."


def test_an_exercise_that_earned_points_is_not_missing():
    """Nothing seems to define it, but something does: its status follows from its cases."""
    hidden_away = toy.RIGHT + f"exec({toy.APPLY!r}, globals())\n"
    value = toy.notebook([toy.cell(hidden_away, "double", solution=True)])
    assert toy.submission(value, toy.assignment()).missing == {"apply"}
    found = exercise(toy.graded(value), "apply")
    assert (found.status, found.score, found.message) == ("passed", 10, "")


def test_visible_checks_draw_from_the_public_seed():
    """What a student prints of a visible check's inputs tells nothing of the secret seed."""
    tests = toy.assignment(double_random="x = rng.normal()\nassert double(x) == 2 * x\n")
    tell = "def double(x):\n    if isinstance(x, float): raise ValueError(repr(x))\n    return 6\n"
    shown = {case(grade(tell, tests, seed), "random").message for seed in (1, 2)}
    assert len(shown) == 1
    assert repr(float(seeds.case_generator(0, "double-random").normal())) in shown.pop()


def test_hidden_inputs_are_drawn_from_the_batchs_seed():
    test = "# hint: Double it.\nx = rng.normal()\nassert double(x) == 2 * x\n"
    cell = f"assert double(1.0) == 2.0\n### BEGIN HIDDEN TESTS\n{test}### END HIDDEN TESTS\n"
    drawn = float(seeds.case_generator(8, "double-random").normal())
    wrong_there = f"def double(x):\n    return 0.0 if x == {drawn!r} else 2 * x\n"
    tests = toy.assignment(double_random=cell)
    earned = [case(grade(wrong_there, tests, seed), "random").earned for seed in (8, 9)]
    assert earned[0] == 0 < earned[1]


def test_tests_print_nothing(capfd):
    prints = "import sys; print(x, 'LOUD'); print('LOUD', file=sys.stderr)"
    loud = toy.DOUBLE_RANDOM.replace("got =", f"{prints}\ngot =", 1)
    assert grade(tests=toy.assignment(double_random=loud)).score == 20
    assert "LOUD" not in "".join(capfd.readouterr())


def test_a_fault_that_a_test_swallows_is_a_fault():
    """A bare except in a test must not turn a hang or a death into a pass."""
    swallowing = "try:\n    double(-1)\nexcept:\n    pass\n"
    assert outcome(grade(DIES, toy.assignment(double_random=swallowing))) == ("died", 4, "passed")


@pytest.mark.parametrize(
    ("test", "answer"),
    [
        ("while double(1) is not None:\n    pass\nwhile True:\n    pass\n", "None"),
        # The student's function asks the test's own function for more than it can give.
        ("double(lambda n: sum(1 for _ in range(int(n))))\n", "x(1e18)"),
    ],
    ids=["a test", "a callback"],
)
def test_what_computes_for_ever_on_this_side_is_ended(test, answer):
    tests = limited(test, call_seconds=0.4, cell_seconds=0.4, notebook_seconds=20)
    result = grade(f"def double(x): return 6 if x == 3 else {answer}\n", tests)
    assert outcome(result) == ("timeout", 4, "passed")


def test_a_value_that_an_own_cell_builds_step_by_step_is_there():
    value = toy.answer("def double(x):\n    return sum(T) * np.asarray(x)\n")
    own = toy.cell("T = []\nfor i in range(2):\n    print(i)\n    T.append(1)\n")
    value["cells"].insert(1, own)
    assert toy.graded(value).score == toy.MOST


def test_what_an_own_cell_that_hangs_should_define_is_missing_for_want_of_time():
    slow = toy.cell("import time\nTWO = time.sleep(9) or 2\n")
    answer = toy.answer("def double(x):\n    return TWO * np.asarray(x)\n", toy.APPLY, slow)
    result = toy.graded(answer, limited(call_seconds=1, cell_seconds=0.5))
    assert exercise(result).status == "failed"
    assert exercise(result).message.startswith(f"{messages.LEFT_OUT}: name 'TWO'")
    assert exercise(result, "apply").status == "passed"


@pytest.mark.parametrize(
    ("double", "is_doubtful"),
    [
        (toy.RIGHT, False),
        ("def double(x):\n    return 7\n", False),
        ("def double(x):\n    while True: pass\n", True),
        ("def double(x):\n    return TWO * np.asarray(x)\n", True),
    ],
    ids=["right", "wrong", "a limit", "for want of a cell of its own"],
)
def test_what_a_busy_machine_may_be_to_blame_for_is_doubtful(double, is_doubtful):
    """A signal for the batch, which grades it once more; the result says what happened."""
    tests = limited(call_seconds=1, cell_seconds=0.5)
    slow = [toy.cell("import time\nTWO = time.sleep(9) or 2\n")] if "TWO" in double else []
    value = toy.answer(double, toy.APPLY, *slow)
    code = toy.submission(value, tests)
    assert Pass("a", tests, code, Unsandboxed()).look().doubtful == is_doubtful


CALLER = "def apply(f, x, times):\n    return double(f(x)), [{}]\n"


def test_who_calls_what_is_not_written_is_told_so():
    unwritten = "def double(x):\n    raise NotImplementedError\n"
    unwritten = toy.graded(toy.answer(unwritten, CALLER.format("")))
    assert exercise(unwritten).message == messages.NOT_WRITTEN
    said = "apply calls double, which is not written yet: it raises NotImplementedError."
    assert exercise(unwritten, "apply").message == said


def test_the_cell_in_which_an_exception_rose_is_named():
    """Another exercise's line is no line of this one, and causes are looked for where it is."""
    raising = "def double(x):\n    rows = [1]\n    return rows[0.0]\n"
    told = exercise(toy.graded(toy.answer(raising, CALLER.format(""))), "apply").message
    assert "(line 3 of your cell for double)" in told and "np.asarray(rows)" in told


def test_an_exception_of_a_function_of_the_test_has_its_own_name_and_class():
    test = "def half(x):\n    raise ZeroDivisionError('no half')\nassert double(half) == 1\n"
    tests = toy.assignment(double_random=test)
    told = case(grade("def double(x):\n    return 6 if x == 3 else x(3)\n", tests), "random")
    assert told.message.startswith("Your function raised ZeroDivisionError: no half (line 2")
    catches = "    try:\n        return x(3)\n    except ZeroDivisionError:\n        return 1\n"
    result = grade(f"def double(x):\n    if x == 3: return 6\n{catches}", tests)
    assert case(result, "random").passed


@pytest.mark.parametrize("depends", [True, False])
def test_what_depends_on_a_function_that_hung_is_stopped(depends):
    """It would hang there again; one that only has a variable of that name is run."""
    caller = CALLER.format("") if depends else toy.APPLY.replace("history", "double")
    value = toy.answer("def double(x):\n    while True: pass\n", caller)
    result = toy.graded(value, limited(call_seconds=0.3, cell_seconds=5, notebook_seconds=20))
    found = exercise(result, "apply")
    assert found.status == ("timeout" if depends else "passed")
    said = "Not run: your code depends on double, which ran longer than it may: begin there."
    assert (found.message == said) is depends


def test_what_calls_a_function_that_does_not_pass_says_so():
    value = toy.answer("def double(x): return 7\n", "def apply(f, x, times): return double(x)\n")
    said = "apply calls double, which does not pass: begin there."
    assert said in exercise(toy.graded(value), "apply").message
    assert said not in exercise(toy.graded(value)).message


@pytest.mark.parametrize("fields", [{}, {"grade_id": "double", "solution": True}])
def test_a_cell_that_was_split_inside_of_a_function_is_told_as_that(fields):
    value = toy.answer("def double(x):\n    y = 2 * x\n")
    value["cells"].insert(2, toy.cell("\n    y = y + 0\n    return y\n\nz = 1\n", **fields))
    assert "A cell begins inside of a function" in toy.graded(value).reason
    assert "was a cell split inside of it?" in exercise(grade("def double(x):\n")).message
    assert not grade("x = 1\ndef double(x):\n    return 2 * x\n").reason


@pytest.mark.parametrize("body", ["while True: pass", "return x['a']", "return 7"])
def test_no_text_of_a_students_is_parsed_on_this_side(monkeypatch, body):
    """Magics make a reader slow: a hang of one exercise had all of them read once more here."""
    read: list[str] = []
    parse = ast.parse

    def noted(text: str, *more: Any, **options: Any) -> ast.AST:
        read.append(text)
        return parse(text, *more, **options)

    monkeypatch.setattr(ast, "parse", noted)
    value = toy.answer(f"def double(x):\n    {body}\n", CALLER.format(""), toy.cell("%own\na = 1"))
    result = toy.graded(value, limited(call_seconds=0.3, cell_seconds=5, notebook_seconds=20))
    assert exercise(result).status != "passed" and exercise(result, "apply").message
    assert not [text for text in read if "%own" in text or f"\n    {body}" in text]


def test_a_submission_has_its_time_and_no_more():
    tests = limited(call_seconds=20, cell_seconds=20, notebook_seconds=0.5)
    result = grade("def double(x):\n    while True: pass\n", tests)
    assert {each.status for each in result.exercises} == {"timeout"}
    assert (result.status, result.score) == ("graded", 0)


def test_a_lost_case_leaves_its_variables_to_the_next():
    """Test cells share variables; a hang in one exercise must not cost another its inputs."""
    tests = toy.assignment(double_random="shared = 4\ndouble(-1)\n")
    *before, last = tests.cases
    tests = replace(tests, cases=(*before, replace(last, full="assert shared == 4\n")))
    assert outcome(grade(DIES, tests)) == ("died", 4, "passed")


def test_a_hidden_hang_keeps_what_was_earned_before_it():
    text = "def double(x):\n    while np.shape(x) == (5,): pass\n    return 2 * np.asarray(x)\n"
    result = grade(text, limited(call_seconds=0.3, cell_seconds=5, notebook_seconds=20))
    assert exercise(result).status == "timeout" and result.score == 14
    assert "ran longer than it may" in exercise(result).message
    assert case(result, "random").message == "Try negative numbers."


def test_the_environment_is_left_as_it_was(monkeypatch):
    monkeypatch.setenv(seeds.SEED_VARIABLE, "before")
    grade()
    assert os.environ[seeds.SEED_VARIABLE] == "before"


def test_asserts_count_under_an_optimising_interpreter():
    """`python -O` leaves out asserts: then every test would pass."""
    script = f"from {__name__} import grade; print(grade('double = abs').score)"
    done = ended([sys.executable, "-OO", "-c", script], cwd=ROOT)
    assert done.stdout.strip() == "10", done.stderr


MAGIC = {"source": "%matplotlib inline\nimport os\nimport numpy as np\n"}


@pytest.mark.parametrize("setup", [MAGIC, {"metadata": {}}], ids=["magic", "unmarked"])
def test_set_up_cells_of_other_trees_work(setup):
    value = toy.source_notebook()
    value["cells"][0] |= setup
    assert grade(tests=toy.assignment(value=value)).score == toy.MOST
