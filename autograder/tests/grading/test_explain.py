"""A visible check that failed says what came back, what was expected, and a likely cause."""

from typing import Any

import numpy as np
import pytest
from robust_slam_autograder.grading import explain, likely_causes
from robust_slam_autograder.grading.results import Compared
from robust_slam_autograder.reading.assignment import Config

from .. import toy

LABEL = "<case>"


def said(cell: str, **functions: Any) -> str:
    """What is said of a test cell that fails with these functions of a student's."""
    return returned(cell, **functions).text.removeprefix("\n")


def close(got: Any, want: Any, why: str = "") -> None:
    assert got == want, why


def returned(cell: str, **functions: Any) -> explain.Returned:
    """The same, as text and as data."""
    calls = explain.Calls()
    names: dict[str, Any] = {"np": np, "close": close, **calls.watched(functions)}
    calls.begin(LABEL, names)
    with pytest.raises(Exception) as caught:
        exec(compile(cell, LABEL, "exec"), names)
    told = explain.returned(caught.value, cell, calls)
    assert all(names[name].__name__ == name for name in functions), "the functions are back"
    return told


@pytest.mark.parametrize(
    ("cell", "sentence"),
    [
        ("assert f(3) == 6", "f(3) returned 7; expected 6."),
        ("y = f(3)\nassert np.allclose(y, 6.0)", "f(3) returned 7; expected 6.0."),
        ("assert 6 == f(3)", "f(3) returned 7; expected 6."),
        ("close(f(2), 7)\nclose(\n    f(3), 6, 'two lines'\n)", "f(3) returned 7; expected 6."),
        ("assert 6 > f(3), (\n    'two lines'\n)", "f(3) returned 7; expected less than 6."),
        ("assert f(1) < f(3)", "f(1) returned 7; expected less than 7."),
        ("a = f(1)\nassert f(3) > 6 and f(2) <= 5", "f(2) returned 7; expected at most 5."),
        ("for n in (7, 8):\n    assert f(n) == n", "f(8) returned 7; expected 8."),
        ("assert np.all(f(3) >= np.arange(9))",
         "f(3) returned 7; expected at least [0, 1, 2, 3, 4, 5, 6, 7, 8]."),
        ("assert np.shape([f(3)]) == ()", "np.shape([f(3)]) is (1,); expected ()."),
        ("assert f(3) != 7", "f(3) returned 7; expected anything but 7."),
        ("f(3)[0]", "f(3) returned 7."),
        ("assert not f(3)", "f(3) returned 7."),
        ("def helper():\n    return f(2)\nassert helper() == 1", "helper() is 7; expected 1."),
        ("assert f(*range(90)) == 6", "f(…) returned 7; expected 6."),
    ],
)  # fmt: skip
def test_what_came_back_stands_beside_what_was_expected(cell, sentence):
    assert said(cell, f=lambda *_: 7) == f"Here, {sentence}"


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (2.0000300000001, "returned 2.00003; expected 2.0."),
        ([1.0, float("nan")], f"returned [1.0, nan]; expected 2.0. {likely_causes.NAN}"),
        (None, f"returned None. {likely_causes.NO_VALUE}"),
        (np.zeros((2, 2)), "returned [[0., 0.], [0., 0.]]; expected 2.0."),
        ((1, [2]), "returned (1, [2])."),
    ],
)
def test_values_are_short_and_readable(value, sentence):
    told = said("assert np.allclose(f(), 2.0, rtol=1e-9)", f=lambda: value)
    assert told == f"Here, f() {sentence}"


@pytest.mark.parametrize(
    ("value", "cell", "sentence"),
    [
        (1 - 1e-12, "assert f() >= 1.0", "0.999999999999; expected at least 1.0."),
        (np.array([1 - 1e-12]), "assert np.all(f() >= np.ones(1))",
         "array([0.999999999999]); expected at least array([1.])."),
        (0.1 + 0.2, "assert f() == 0.3", "0.30000000000000004; expected 0.3."),
        (1 + 1e-12, "assert f() < 1.0", "1.000000000001; expected less than 1.0."),
    ],
)  # fmt: skip
def test_enough_digits_are_shown_to_be_true(value, cell, sentence):
    assert said(cell, f=lambda: value) == f"Here, f() returned {sentence}"


def test_a_part_of_what_was_returned_is_named_as_the_check_names_it():
    cell = "last, history = f(1)\nassert history == [1, 2]"
    assert said(cell, f=lambda _: (2, [1])) == "Here, history is [1]; expected [1, 2]."


def test_a_function_is_not_called_again():
    counted: list[int] = []
    said("assert np.allclose(f(3), 6)", f=lambda n: counted.append(n) or 7)
    assert counted == [3]


def test_where_nothing_can_be_said_nothing_is():
    assert said("assert 1 == 2", f=abs) == "Here, 1 is 1; expected 2."
    assert said("x = f(1)\nassert False, 'no'", f=abs) == ""
    assert said("import nothing_of_that_name", f=abs) == ""


def test_two_values_that_were_compared_are_data_too():
    found = returned("assert f(3) < 6", f=lambda _: None if _ == 1 else 7)
    assert found.compared == Compared("f(3)", "7", "expected less than", "6", "")
    found = returned("assert np.allclose(f(), 2.0)", f=lambda: [1.0, np.nan])
    assert found.compared is not None and found.compared.remark == likely_causes.NAN
    assert returned("f(3)[0]", f=lambda _: 7).compared is None


@pytest.mark.parametrize(
    ("value", "expected", "curves"),
    [
        ([1, 2, 3], "[3.0, 2.0, 1.0]", ((1, 2, 3), (3, 2, 1))),
        (np.array([1e-9, 0.12345678, 3]), "0.5", ((1e-9, 0.123457, 3), (0.5, 0.5, 0.5))),
        ([1, 2], "[2, 1]", ()),
        ([1.0, 2.0, 3.0], "[1.0, 2.0, 3.0, 4.0]", ()),
        ([[1.0, 2.0, 3.0]] * 3, "1.0", ()),
        ([1.0, np.nan, 3.0], "1.0", ()),
        ([1.0, np.inf, 3.0], "1.0", ()),
        ([True, False, True], "[True, True, True]", ()),
        (["a", "b", "c"], "['b', 'b', 'b']", ()),
        ([1, [2], 3], "[1, 2, 3]", ()),
        ([10**400, 1, 2], "[1, 2, 3]", ()),
        (np.zeros(201), "np.ones(201)", ()),
    ],
    ids=repr,
)
def test_rows_of_numbers_can_be_drawn_and_nothing_else(value, expected, curves):
    found = returned(f"assert np.array_equiv(f(), {expected})", f=lambda: value).compared
    assert found is not None and found.curves == curves


def test_long_values_are_cut():
    assert len(explain.show("x" * 10_000)) <= explain.MAX_VALUE
    assert len(explain.show([[float(n)] * 9 for n in range(99)])) <= explain.MAX_VALUE


@pytest.mark.parametrize(
    ("raised", "sentence"),
    [
        ("[1][[0]]", "make it an array first, with np.asarray"),
        ("[1][np.array([0, 1])]", "make it an array first, with np.asarray"),
        ("[1, 2] - [1]", "A list does no arithmetic"),
        ("[1, 2] * 0.5", "A list does no arithmetic"),
        ("abs([1])", "A list does no arithmetic"),
        ("[1] > 0.5", "A list does no arithmetic"),
        ("[1].shape", "A list does no arithmetic"),
        ("np.ones(3) + np.ones(2)", "shapes that do not fit"),
        ("np.ones((2, 3)) @ np.ones(2)", "shapes that do not fit"),
        ("np.dot(np.ones((2, 3)), np.ones(2))", "shapes that do not fit"),
        ("np.array([[1], [2, 3]])", "shapes that do not fit"),
        ("np.ones(6).reshape(4, 2)", "shapes that do not fit"),
        ("None + 1", "A value is None"),
        ("None[0]", "A value is None"),
        ("None.shape", "A value is None"),
        ("1 if np.arange(3) > 1 else 0", "np.where"),
        ("float(np.ones(3))", "take one number"),
        ("__import__('math').sqrt([1])", "take one number"),
        ("np.arange(3).__isub__(0.5)", "dtype=float"),
        ("np.ones(3)[np.array([0.5])]", "integers or booleans"),
        ("np.ones(3)[3]", "the last of n entries has the index n - 1"),
        ("[1][1]", "the last of n entries has the index n - 1"),
        ("np.linalg.solve(np.zeros((2, 2)), np.ones(2))", "The matrix is singular"),
        ("np.linalg.inv(np.ones((2, 3)))", "square matrix"),
        ("np.linalg.eigvals(np.full((2, 2), np.nan))", "holds NaN or inf"),
        ("(lambda x: x)()", "those of the statement"),
        ("(lambda x: x)(1, 2)", "those of the statement"),
        ("1 / 0", "divided by 0"),
        ("(lambda f: f(f))(lambda f: f(f))", "without end"),
        ("open('/nothing/there')", ""),
    ],
)  # fmt: skip
def test_exceptions_have_a_likely_cause(raised, sentence):
    """The exceptions are those of the installed Python and NumPy, not texts written here."""
    with pytest.raises(Exception) as caught:
        eval(raised, {"np": np})
    told = likely_causes.likely(f"{type(caught.value).__name__}: {caught.value}")
    assert sentence in told if sentence else told == ""


def explained(double: str, config: Config | None = None) -> str:
    """The second line of what a student's check says of the first exercise."""
    result = toy.checked(toy.answer(double), toy.assignment(config))
    return result.exercises[0].message.splitlines()[1]


def test_the_list_that_is_indexed_is_named():
    answer = "def double(x):\n    x = [1]\n    return x[[0]]\n"
    assert explained(answer) == "x is a list; make it an array: x = np.asarray(x)."


def test_an_assignments_own_causes_come_first():
    answer = "def double(x):\n    return np.linalg.inv(np.zeros((2, 2)))\n"
    config = Config(causes={"Singular matrix": "Fix one pose."})
    assert explained(answer, config) == "Fix one pose."
