"""Wrong answers are named by what they return; what is not sure has no name."""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from robust_slam_autograder.grading import returned
from robust_slam_autograder.grading.explain import MAX_CALLS, Call
from robust_slam_autograder.misconceptions import survey, tables
from robust_slam_autograder.misconceptions.tables import Known, Table
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.labelled import Answer

from .. import toy
from ..grading import course


def digests(*values: object) -> tuple[str, ...]:
    calls = [Call("f", (), {}, value, 0, 0) for value in values]
    return returned.digests(calls, raised=False)


@pytest.mark.parametrize(
    ("one", "other", "are_alike"),
    [
        ([1.0, 2.0], np.array([1, 2]), True),
        (np.float32(0.5), 0.5 + 1e-12, True),
        ((1e300, np.nan, np.inf), [1e300, np.nan, np.inf], True),
        ({"a": 1, "b": (2.5, None)}, {"b": [2.5, None], "a": 1.0}, True),
        ([1.0, 2.0], [2.0, 1.0], False),
        (0.5, 0.5001, False),
        (np.nan, np.inf, False),
        (np.inf, -np.inf, False),
        (True, 1.0, False),
        ([1.0, 2.0], [[1.0, 2.0]], False),
        ("yes", "no", False),
        ((1.0, 2.0), (1.0, "2.0"), False),
    ],
)
def test_the_same_values_alone_have_a_digest_in_common(one, other, are_alike):
    assert bool(set(digests(one)) & set(digests(other))) is are_alike


class Odd:
    def __array__(self, dtype: object = None, copy: object = None) -> object:
        raise RuntimeError("no")


@pytest.mark.parametrize(
    "value",
    [Odd(), object(), b"bytes", np.array(["a"]), np.zeros(300_000), [{}] * 9_000, {1: Odd()}],
    ids=lambda value: type(value).__name__,
)
def test_what_cannot_be_compared_has_no_digest(value):
    assert digests(value) == ()


def test_nested_and_many_values_come_to_an_end():
    deep: list[object] = []
    for _ in range(500):
        deep = [deep]
    assert digests(deep) == ()
    assert digests(*range(MAX_CALLS + 1)) == ()


@dataclass
class Engine:
    """What is known of the toy's first exercise, found out once for each list of answers."""

    path: Path
    tables: dict[tuple[Answer, ...], Table] = field(default_factory=dict)

    def table(self, *answers: Answer) -> Table:
        if answers not in self.tables:
            test = assignments.load(self.path)
            self.tables[answers] = survey.survey(test, "double", answers)
        return self.tables[answers]

    def says(self, source: str, *answers: Answer) -> str:
        """What it says of a cell, knowing some answers."""
        result = toy.checked(toy.answer(source), assignments.load(self.path))
        return tables.named(result.exercises[0], self.table(*answers)).misconception


SHOWN = re.sub("(?m)^#.*\n", "", toy.DOUBLE_RANDOM)
"""The toy's second case, of which students see all."""


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    value = toy.source_notebook(double_random=SHOWN)
    tree = toy.make_tree(tmp_path_factory.mktemp("tree"), value=value)
    return Engine(tree / toy.NAME / f"{toy.NAME}.ipynb")


def wrong(name: str, source: str, story: str) -> Answer:
    return Answer("double", f"wrong_{name}", source, story, caught_by="double-random")


FOURFOLD = "def double(x):\n    return 4 * np.asarray(x)"
SIGNED = "def double(x):\n    return 2 * np.abs(x)"


def test_an_author_s_label_comes_before_a_rule(engine):
    other = "def double(x):\n    return np.add(x, x) * 2"
    assert engine.says(FOURFOLD) == "what comes back is twice what it should be"
    label = engine.says(FOURFOLD, wrong("four", other, "Doubles it twice."))
    assert label == "your function doubles it twice"


def test_one_failed_case_is_enough_for_an_author_s_label(engine):
    late = "def double(x):\n    y = 2 * np.asarray(x)\n    return y + 0.1234 * (y.size > 2)"
    assert engine.says(late, wrong("late", late, "Adds to rows.")) == "your function adds to rows"


def test_a_batch_names_what_visible_cases_saw_and_keeps_it_through_the_hidden_pass(
    engine, tmp_path
):
    tree = toy.make_tree(tmp_path, value=toy.source_notebook(double_random=SHOWN))
    tests = tree / toy.NAME / f"{toy.NAME}.ipynb"
    known = Known(tables.digest(tests), "", {"double": engine.table()})
    tables.write_made(tmp_path / "known", tests, known)
    for student, source in (("ada", FOURFOLD), ("bob", toy.DOUBLE), ("cem", SIGNED)):
        toy.hand_in(tmp_path / "submitted", student, toy.answer(source))
    graded = course.grade(tmp_path, naming=tables.namer(tmp_path / "known"))
    ada, bob, cem = (item.load().exercises[0] for item in graded)
    assert ada.misconception == engine.says(FOURFOLD) != "" and ada.pattern
    assert (bob.status, bob.misconception, bob.pattern) == ("passed", "", "")
    assert cem.misconception == engine.says(SIGNED) != ""


@pytest.mark.parametrize("value", ["no", True, 3.0])
def test_words_and_whole_numbers_name_no_slip(engine, value):
    source = f"def double(x):\n    return {value!r}"
    assert engine.says(source, wrong("same", source, "Always says it.")) == ""


def test_right_values_name_no_slip(tmp_path):
    """Another answer with these values may have lost its case for any reason."""
    test = "calls = []\nlast, history = apply(lambda v: calls.append(v) or v + 0.5, 0.25, 1)\n"
    value = toy.source_notebook(apply_by_hand=f"{test}assert len(calls) == 1\n")
    path = toy.make_tree(tmp_path, value=value) / toy.NAME / f"{toy.NAME}.ipynb"
    tests = assignments.load(path)
    twice = "def apply(f, x, times):\n    f(x)\n    return f(x), [x, x + 0.5]\n"
    answer = Answer("apply", "wrong_twice", twice, "Asks twice.", caught_by="apply-by-hand")
    table = survey.survey(tests, "apply", [answer])
    exercise = toy.checked(toy.answer(apply=twice), tests).exercises[1]
    assert exercise.status == "partial" and tables.named(exercise, table).misconception == ""


def test_two_labels_for_the_same_values_are_none(engine):
    one, two = (wrong(name, FOURFOLD, f"{name}s it.") for name in ("Square", "Multiplie"))
    assert engine.says(FOURFOLD, one, two) == ""
    changes = [survey.Way(f"what `{name}` returns is half", "", is_written=False) for name in "fg"]
    assert survey.chosen(changes) == ""


def test_a_table_holds_no_label_that_could_be_read(engine, tmp_path):
    path = tmp_path / tables.FILE
    tables.write(path, {"double": engine.table(wrong("four", FOURFOLD, "Squares it."))})
    assert "quare" not in path.read_text()
    assert tables.read(path)["double"]
    path.write_text('{"double": {"labels": {}, "right": {}, "arguments": ["x"]}}')
    assert tables.read(path) == {}
