"""Wrong answers are named by what they return; what is not sure has no name."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from robust_slam_autograder.grading.naming import Namer
from robust_slam_autograder.misconceptions import (
    aspects,
    known,
    shapes,
    slips,
    survey,
    tables,
    traits,
    wider,
)
from robust_slam_autograder.misconceptions.bench import Setting
from robust_slam_autograder.misconceptions.candidates import FACT, WRITTEN, Candidate, chosen
from robust_slam_autograder.misconceptions.known import Known
from robust_slam_autograder.misconceptions.prints import MAX_CALLS, Called, Trace, parts_of
from robust_slam_autograder.misconceptions.shapes import Seen
from robust_slam_autograder.misconceptions.tables import Table
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.labelled import Answer

from tests.autograder import toy
from tests.autograder.grading import course

RIGHT_BUT = "all that comes back where a test fails is right but"


def of_calls(*values: object) -> dict[str, tuple[str, ...]]:
    trace = Trace()
    for value in values:
        trace.add("f", (), value)
    return shapes.seen_by(trace).digests


def digests(*values: object) -> tuple[str, ...]:
    return of_calls(*values).get(shapes.WHOLE, ())


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
def test_the_same_values_alone_have_a_digest_in_common(
    one: object, other: object, are_alike: bool
) -> None:
    assert bool(set(digests(one)) & set(digests(other))) is are_alike


class Odd:
    def __array__(self, dtype: object = None, copy: object = None) -> object:
        raise RuntimeError("no")


@pytest.mark.parametrize(
    "value",
    [Odd(), object(), b"bytes", np.array(["a"]), np.zeros(300_000), [{}] * 9_000, {1: Odd()}],
    ids=lambda value: type(value).__name__,
)
def test_what_cannot_be_compared_has_no_digest(value: object) -> None:
    assert digests(value) == ()


def test_nested_and_many_values_come_to_an_end() -> None:
    deep: list[object] = []
    for _ in range(500):
        deep = [deep]
    assert digests(deep) == ()
    assert digests(*range(MAX_CALLS + 1)) == ()


@dataclass
class Engine:
    """What is known of the toy's first exercise, found out once for each list of answers."""

    setting: Setting
    tables: dict[tuple[Answer, ...], Table] = field(default_factory=dict)

    def table(self, *answers: Answer) -> Table:
        if answers not in self.tables:
            self.tables[answers] = survey.survey(self.setting, "double", answers)
        return self.tables[answers]

    def says(self, source: str, *answers: Answer) -> str:
        """What it says of a cell, knowing some answers."""
        typed = [Candidate(WRITTEN, "", source)]
        found = survey.shapes_of(self.setting, "double", lambda bench: typed, with_aspects=True)
        return next((self.table(*answers).sentence(shape) for _, shape in found), "")


@pytest.mark.parametrize(
    ("line", "becomes", "told"),
    [
        ("x**2", "x", "`x` is not squared where it should be"),
        ("x - n", "n - x", "a difference is taken the other way round"),
        ("np.sum(x * n)", "x * n", "a sum is not taken"),
        ("np.sum(x**2)", "np.sum(x) ** 2", "a sum is squared where squares belong added up"),
        ("np.max(x)", "x", ""),
        ("np.arange(n)", "np.arange(n + 1)", slips.SENTENCES["one off"]),
        ("x[n]", "x[n - 1]", slips.SENTENCES["one off"]),
        ("x if n < 2 else 0", "x if n <= 2 else 0", slips.SENTENCES["boundary"]),
    ],
)
def test_a_mutant_says_what_its_author_would_have_done_wrong(
    line: str, becomes: str, told: str
) -> None:
    cell = "def f(x, n):\n    return {}\n"
    said = {mutant.source: mutant.slip.sentence for mutant in wider.mutants(cell.format(line))}
    assert said[cell.format(becomes)] == told


SHOWN = re.sub("(?m)^#.*\n", "", toy.DOUBLE_RANDOM)
"""The toy's second case, of which students see all."""


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Engine:
    tree = toy.make_tree(
        tmp_path_factory.mktemp("tree"), value=toy.source_notebook(double_random=SHOWN)
    )
    path = tree / toy.NAME / f"{toy.NAME}.ipynb"
    return Engine(Setting(path, assignments.load(path)))


def wrong(name: str, source: str, story: str) -> Answer:
    return Answer("double", f"wrong_{name}", source, story, caught_by="double-random")


FOURFOLD = "def double(x):\n    return 4 * np.asarray(x)"


def test_an_author_s_label_comes_before_a_rule(engine: Engine) -> None:
    other = "def double(x):\n    return np.add(x, x) * 2"
    assert engine.says(FOURFOLD) == "what comes back is twice what it should be"
    label = engine.says(FOURFOLD, wrong("four", other, "Doubles it twice."))
    assert label == "your function doubles it twice"


def test_a_batch_names_what_visible_cases_saw_and_keeps_it_through_the_hidden_pass(
    engine: Engine, tmp_path: Path
) -> None:
    tree = toy.make_tree(tmp_path, value=toy.source_notebook(double_random=SHOWN))
    tests = known.digest(tree / toy.NAME / f"{toy.NAME}.ipynb")
    known.write(tmp_path / "known", toy.NAME, Known(tests, "", {"double": engine.table()}))
    for student, source in (("ada", FOURFOLD), ("bob", toy.DOUBLE)):
        toy.hand_in(tmp_path / "submitted", student, toy.answer(source))
    graded = course.grade(tmp_path, naming=Namer(tmp_path / "known"))
    ada, bob = (item.load().exercises[0] for item in graded)
    assert ada.misconception == engine.says(FOURFOLD) != "" and ada.pattern
    assert (bob.status, bob.misconception, bob.pattern) == ("passed", "", "")


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("x", "c"), "only entries where the size of `x` is above `c` are wrong"),
        (("x", "tol"), ""),
    ],
)
def test_entries_are_compared_with_an_argument_but_not_with_a_tolerance(
    names: tuple[str, str], told: str
) -> None:
    found = {"only entries where the size of {} is above {} are wrong 0 1": ("a digest",)}
    assert aspects.told([(found, found)], names) == told


@pytest.mark.parametrize(
    ("mine", "right", "told"),
    [
        ((1.5, [2.5, 3.5]), (1.5, [2.5, 4.5]), f"{RIGHT_BUT} the second part"),
        ({"a": 1.5, "b": [2]}, {"a": 1.5, "b": [3]}, f"{RIGHT_BUT} `b`"),
        ({"a": 1.5, "b": [2]}, {"a": 1.5, "c": [2]}, f"{RIGHT_BUT} `c`"),
        ([[1.5, 2.5]] * 3, [[1.5, 3.5]] * 3, f"{RIGHT_BUT} the second column"),
        ([True, False, True], [0, 2], "a mask comes back where indices belong"),
        ([1, 0, 1], [True, False, True], "numbers come back where truth values belong"),
        ([3, 9], [3, 5, 7], "fewer entries come back than should"),
        (2.5, "! ValueError", "an answer comes back where an error should be raised"),
        (
            2.5,
            2.5,
            "the right values come back, so the fault is their type, their last digits or what is "
            "done besides",
        ),
    ],
)
def test_a_piece_that_is_not_right_is_told_by_the_solution_s_own_name(
    mine: object, right: object, told: str
) -> None:
    table = tables.Table(
        {}, {name: {k: frozenset(v) for k, v in of_calls(right).items()} for name in "ab"}, ()
    )
    shape = shapes.Shape()
    for name in "ab":
        shape.add(name, Seen(of_calls(mine), told=True, real=True))
    assert table.sentence(shape) == told
    assert table.sentence(shapes.Shape()) == ""


@pytest.mark.parametrize("value", ["no", True, 3.0])
def test_words_and_whole_numbers_name_no_slip_however_many_cases_they_fail(value: object) -> None:
    shape = shapes.Shape()
    for name in "abcdef":
        shape.add(name, Seen(of_calls(value), told=True))
    assert not survey.counts(Candidate(FACT, "`x` were squared", fact="0"), shape)


def test_two_labels_for_the_same_values_are_none(engine: Engine) -> None:
    one, two = (wrong(name, FOURFOLD, f"{name}s it.") for name in ("Square", "Multiplie"))
    assert engine.says(FOURFOLD, one, two) == ""


def test_a_table_holds_no_label_that_could_be_read(engine: Engine, tmp_path: Path) -> None:
    path = tmp_path / tables.FILE
    tables.write(path, {"double": engine.table(wrong("four", FOURFOLD, "Squares it."))})
    assert "quare" not in path.read_text()
    assert tables.read(path)["double"].labels
    path.write_text('{"double": {"labels": 3}}')
    assert tables.read(path) == {}


def traits_of(*args: object, **options: object) -> frozenset[str]:
    return traits.of_call(Called("f", args, (), tuple(options.items())))


@pytest.mark.parametrize(
    ("end", "passed", "told"),
    [
        (traits_of([1, 2]), [traits_of(np.array([0.5, 1.5]))] * 4, "`x` holds integers"),
        (traits_of(0.5, 2.0), [traits_of(0.5, 1.0)] * 4, "`c` is not 1"),
        (traits_of(0.5, kind="gm"), [traits_of(0.5, kind="tls")] * 4, "`kind` is “gm”"),
        (traits_of([1, 2]), [traits_of(np.array([0.5]))] * 3, ""),
        (traits_of([1, 2]), [traits_of([3, 4])] * 4, ""),
        (traits_of([1, 2], 2.0), [traits_of(np.array([0.5, 1.5]), 1.0)] * 4, "`x` holds integers"),
        (traits_of(0.5, -0.5), [traits_of(0.5, 0.5)] * 4, ""),
        (traits_of([0.5] * 60), [traits_of([0.5] * 3)] * 4, ""),
    ],
    ids=["integers", "number", "option", "too few", "passed", "two", "by chance", "much"],
)
def test_where_it_goes_wrong_is_told_where_nothing_else_is_particular(
    end: frozenset[str], passed: list[frozenset[str]], told: str
) -> None:
    counts = Counter(one for some in passed for one in some)
    said = traits.told([end], counts, ("x", "c"))
    assert said == (f"only tests in which {told} fail" if told else "")


@pytest.mark.parametrize(
    ("value", "is_told"), [(2.0, True), (2.5, False), ("! ValueError", False)]
)
def test_integers_are_to_blame_only_where_whole_numbers_come_back(
    value: object, is_told: bool
) -> None:
    end, other = (
        traits.of_call(Called("f", (np.array(x),), tuple(parts_of(y))))
        for x, y in (([1, 2], value), ([0.5, 1.5], 2.5))
    )
    told = traits.told([end], Counter(list(other) * 4), ("x",))
    assert (told == "only tests in which `x` holds integers fail") is is_told


def test_of_what_was_done_to_an_argument_several_facts_say_only_which_it_is() -> None:
    zero, one = (Candidate(FACT, f"`x` were {n}", fact=str(n), about="x") for n in (0, 1))
    other = Candidate(FACT, "`c` were 1", about="c")
    told = [chosen(some) for some in ([zero], [zero, one], [zero, other])]
    assert [one.sentence if one else "" for one in told] == [
        "`x` were 0",
        "`x` is not used as it should",
        "",
    ]


NEARLY = "all is nearly right, and not as exact as it should be"


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("raise ValueError", "an error is raised where an answer belongs"),
        ("return y + 2 * np.pi * (y < -0.5)", "all is right but for whole turns of 2π"),
        ("return y > 0", ""),
        ("return np.append(y, y[:1])[::-1]", "more entries come back than should"),
        (
            "pass\n    y = y[:-1] if y.size > 1 else y",
            "something is missing, and all that comes back is right",
        ),
        (
            "return np.append(y, 0.5)",
            "one entry too many comes last, and those before it are right",
        ),
        ("return np.append(y[:-1], 0.5)", "all is right but the last entry"),
        ("return np.append(y[1:], 0.5)", "each entry stands one place too early"),
        ("return y + 4e-4 * np.cos(1 + 7 * y)", NEARLY),
        ("return y * 1.5", "all is right but for a common factor"),
        ("return y * 1.003", NEARLY),
        (
            "return np.where(np.abs(x) > np.median(np.abs(x)), 0.1, y)",
            "only entries where `x` is far from 0 are wrong",
        ),
        ("return y", ""),
    ],
)
def test_what_is_right_of_an_answer_is_told(engine: Engine, body: str, told: str) -> None:
    source = f"def double(x):\n    y = 2 * np.asarray(x)\n    if y.size > 2:\n        {body}\n"
    assert engine.says(f"{source}    return y") == told


@pytest.mark.parametrize(
    "body",
    ["return x + 0.1234", "raise NotImplementedError", "while True: pass", "return None"],
)
def test_what_is_unknown_has_no_name(engine: Engine, body: str) -> None:
    assert engine.says(f"def double(x):\n    {body}") == ""


def test_a_word_is_told_where_the_solution_says_it_too() -> None:
    def says(word: str) -> frozenset[str]:
        return traits.of_call(Called("f", (), ((f"'{word}'", None),)))

    passed = Counter(one for word in ("yes", "no", "no", "no") for one in says(word))
    told = [traits.told([says(word)], passed, (), ("no", "yes")) for word in ("yes", "0.125")]
    assert told == ["“yes” comes back where another answer belongs", ""]
    always = Counter(list(says("no")) * 4)
    assert traits.told([says("no")], always, (), ("no", "yes")) == "“no” is the only answer"
