"""Each rule of `autograder lint` finds what it is for, and leaves its near miss alone."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder import lint as lint_module
from robust_slam_autograder.lint import RULES, Finding
from robust_slam_autograder.publishing.student_release import release

from tests.autograder import toy

CELL = "double-random"
SAID = '"say why"'


def hidden(*lines: str) -> str:
    """A case whose hidden region holds these lines, from line 4 on."""
    opening = f"assert double(3) == 6, {SAID}\n### BEGIN HIDDEN TESTS\n# hint: Try more.\n"
    return opening + "\n".join(lines) + "\n### END HIDDEN TESTS\n"


def lint(
    folder: Path, value: dict[str, Any], config: str = "", answers: Path | None = None
) -> list[Finding]:
    tree = toy.make_tree(folder, config)
    path = toy.write(tree / toy.NAME / f"{toy.NAME}.ipynb", value)
    return lint_module.lint(path, answers)


def with_case(source: str, **fields: Any) -> dict[str, Any]:
    """The toy assignment with this text in one of its cases."""
    value = toy.source_notebook()
    value["cells"][3]["source"] = source
    value["cells"][3]["metadata"]["nbgrader"] |= fields
    return value


def lines(findings: list[Finding], rule: str, cell: str = CELL) -> list[int]:
    return [one.line for one in findings if (one.rule, one.grade_id) == (rule, cell)]


X = "x = rng.normal(size=5)"
GOT = "got = double(x)"
WANT = "want = x + x"
SHAPE = "assert np.shape(got) == (5,)"

# Rule, the lines of a hidden region (the first is line 4), the line found, and a near miss.
IN_HIDDEN: list[tuple[str, list[str], int, list[str]]] = [
    ("nan-passes", [X, "assert not np.any(np.abs(double(x) - 2 * x) > 1e-9)"], 5,
     [X, "assert not np.any(np.abs(x) > 9)"]),
    ("nan-passes", ["assert not (double(2.0) > 4)"], 4, ["assert not (double(2.0) > 4) is None"]),
    ("nan-passes", ["err = abs(double(2.0) - 4)", "if err > 1e-9:", "    raise AssertionError"], 5,
     ["err = abs(double(2.0) - 4)", "if err > 1e-9:", "    err = 0"]),
    ("nan-passes", ["err = abs(double(2.0) - 4)", "if err > 1e-9:", "    assert False"], 5,
     ["err = abs(double(2.0) - 4)", "if err <= 1e-9:", "    err = 0", "else:",
      "    raise ValueError"]),
    ("nan-passes", [X, GOT, "bad = np.abs(got - 2 * x) > 1e-9", "assert not bad.any()"], 6,
     [X, GOT, "good = np.abs(got - 2 * x) <= 1e-9", "assert good.all()"]),
    ("nan-passes", [X, "assert np.sum(double(x) > 9) == 0"], 5,
     [X, "assert np.sum(double(x) > 9) == 2"]),
    ("nan-passes", [X, "assert np.all(~(double(x) > 9))"], 5,
     [X, "assert np.all(double(x) <= 9)"]),
    ("nan-passes", ["assert double(1.5) != 1.5"], 4,
     ["got = double(1.5)", "assert np.isfinite(got)", "assert got != 1.5"]),
    ("nan-passes", ["def close(a, b):", "    return not np.any(np.abs(a - b) > 1)",
                    "assert close(double(1), 2)"], 5,
     ["def close(a, b):", "    return np.all(np.abs(a - b) <= 1)", "assert close(double(1), 2)"]),
    ("nan-order", [X, "assert max(abs(v) for v in double(x)) < 9"], 5,
     [X, "assert np.max(double(x)) < max(abs(v) for v in x) * 3"]),
    ("nan-skipped", [X, "assert np.nanmax(np.abs(double(x) - 2 * x)) < 1"], 5,
     [X, "assert np.max(np.abs(double(x) - np.nanmax(x))) < 9"]),
    ("equal-nan", [X, GOT, "assert np.allclose(got, 2 * x, equal_nan=True)"], 6,
     [X, GOT, "assert np.allclose(x, x + 0, equal_nan=True)"]),
    ("equal-nan", [X, "np.testing.assert_allclose(double(x), double(-x))"], 5,
     [X, "np.testing.assert_allclose(double(x), double(-x), equal_nan=False)"]),
    ("shape-unchecked", [X, GOT, "assert np.allclose(got, 2 * x)"], 6,
     [X, GOT, SHAPE, "assert np.allclose(got, 2 * x)"]),
    ("shape-unchecked", ["assert np.allclose(double([1, 1]), [2, 2])"], 4,
     ["np.testing.assert_allclose(double([1, 1]), [2, 2], strict=True)"]),
    ("shape-unchecked", [X, WANT, GOT, "assert np.max(np.abs(got - want)) < 1e-9"], 7,
     [X, WANT, GOT, "assert np.array_equal(got, want)",
      "assert np.max(np.abs(got - want)) < 1e-9"]),
    ("shape-unchecked", [X, WANT, GOT, "assert (np.asarray(got) == want).all()"], 7,
     [X, WANT, GOT, "got = np.asarray(got)", "assert got.shape == want.shape",
      "assert (got == want).all()"]),
    ("shape-unchecked",
     ["last, history = apply(abs, 1, 2)", "assert np.shape(last) == ()",
      "assert np.allclose(history, [1, 1, 1])"], 6,
     ["last, history = apply(abs, 1, 2)", "assert len(history) == 3",
      "assert np.allclose(history, [1, 1, 1])"]),
    ("shape-unchecked",
     ["def close(got, want):", "    assert np.allclose(got, want)", X, "close(double(x), 2 * x)"],
     5,
     ["def close(got, want):", "    assert np.shape(got) == np.shape(want)",
      "    assert np.allclose(got, want)", X, "close(double(x), 2 * x)"]),
    ("shape-unchecked", ["for f in (double,):", "    got = f([1, 2])",
                         "    assert np.allclose(got, np.array([2, 4]))"], 6,
     ["def right(got, want):", "    assert np.shape(got) == np.shape(want)",
      "got = double([1, 2])", "right(got, [2, 4])", "assert np.allclose(got, np.array([2, 4]))"]),
    ("number-unchecked", ["z = rng.uniform()", "assert np.allclose(double(z), 2 * z)"], 5,
     ["z = rng.uniform()", "assert np.allclose(float(double(z)), 2 * z)"]),
    ("empty-passes", ["assert np.all(np.asarray(double([1, 2])) > 0)"], 4,
     ["got = double([1, 2])", "assert len(got) == 2", "assert np.all(np.asarray(got) > 0)"]),
    ("empty-passes", ["assert all(v > 0 for v in double([1, 2]))"], 4,
     ["v = float(double(1))", "assert all(v > bound for bound in (0, 1))"]),
    ("zip-stops", [X, "for a, b in zip(double(x), x):", "    assert abs(a - 2 * b) < 1"], 5,
     [X, "for a, b in zip(double(x), x, strict=True):", "    assert abs(a - 2 * b) < 1"]),
    ("reference-after-call", [X, GOT, SHAPE, "assert np.allclose(got, x + x)"], 7,
     [X, "got = double(x.copy())", SHAPE, "assert np.allclose(got, x + x)"]),
    ("reference-after-call", [X, GOT, SHAPE, "assert np.allclose(got, x + x)"], 7,
     [X, WANT, GOT, "assert np.shape(got) == np.shape(x)", "assert np.allclose(got, want)"]),
    ("reference-after-call",
     [X, "for given in (x, x.tolist()):", "    got = double(given)",
      "    assert np.array_equal(got, 2 * x)"], 7,
     [X, "for given in (x.copy(), x.tolist()):", "    got = double(given)",
      "    assert np.array_equal(got, 2 * x)"]),
    ("reference-after-call",
     [X, "got = double(x[:2])", "assert np.array_equal(got, 2 * x[:2])"], 6,
     ["z = rng.uniform(1, 2)", "got = double(z)", "assert np.array_equal(got, 2 * z)"]),
    ("list-refused", [X, GOT, "assert got.sum() < 9"], 6,
     [X, "got = np.asarray(double(x))", "assert got.sum() < 9"]),
    ("list-refused", ["got = double([[1, 2]])", "assert got[:, 0] == 2"], 5,
     ["got = double([[1, 2]])", "assert np.asarray(got)[:, 0] == 2"]),
    ("type-checked", ["assert isinstance(double(2), int)"], 4,
     ["assert isinstance(double(2), (int, float, np.number))"]),
    ("type-checked", ["got = double(2)", "assert type(got) is float"], 5,
     ["got = double(2)", "assert not isinstance(got, str)", "kind = type(got)"]),
    ("exact-float", ["assert double(0.05) == 0.1"], 4, ["assert double(0.5) == 1"]),
    ("other-random", ["x = np.random.normal(size=5)", "assert len(double(x)) == 5"], 4,
     ["x = np.random.default_rng(3).normal(size=5)", "assert len(double(x)) == 5"]),
    ("other-random", ["x = np.random.default_rng().normal(size=5)", "assert len(double(x)) == 5"],
     4, [X, "assert len(double(x)) == 5"]),
    ("other-random", ["import random", "assert double(random.random()) < 2"], 5,
     ["assert double(rng.random()) < 2"]),
    ("assert-tuple", ["assert (double(5) == 10, 'twice 5')"], 4,
     ["assert double(5) == 10, ('twice', 5)"]),
    ("assert-constant", ["assert True"], 4, ["assert double(1)"]),
    ("assert-constant", ["assert 'double(5) is 10'"], 4,
     ["if double(5) != 10:", "    assert False"]),
    ("assert-constant", ["assert (v > 0 for v in double([1, 2]))"], 4,
     ["assert all(v > 0 for v in double([1, 2]))"]),
    ("assert-constant", ["assert double(5) == 10 or True"], 4,
     ["assert double(5) == 10 and True"]),
    ("bare-except", ["try:", "    double('a')", "except:", "    pass"], 6,
     ["try:", "    double('a')", "except TypeError:", "    pass"]),
    ("bare-except", ["import contextlib", "with contextlib.suppress(BaseException):",
                     "    double('a')"], 5,
     ["import contextlib", "with contextlib.suppress(TypeError):", "    double('a')"]),
    ("broad-except", ["try:", "    double('a')", "except (ValueError, Exception):", "    pass"], 6,
     ["try:", "    double('a')", "except (ValueError, TypeError):", "    pass"]),
    ("looks-inside", ["import inspect", "assert 'for' in inspect.getsource(double)"], 5,
     ["import math", "assert math.isclose(double(2.0), 4)"]),
    ("looks-inside", ["assert double.__code__.co_argcount == 1"], 4,
     ["assert np.asarray(double(1)).shape == ()"]),
    ("looks-inside", ["np.linalg.lstsq = None", "assert double(1) == 2"], 4,
     ["z = np.linalg.lstsq", "assert double(1) == 2"]),
    ("rebinds", ["double = abs(-2)", "assert double == 2"], 4,
     ["doubled = double(2)", "assert doubled == 4"]),
    ("cannot-cross", ["assert double(v for v in [1, 2])"], 4,
     ["assert double([v for v in [1, 2]])"]),
    ("cannot-cross", ["assert double({1, 2})"], 4, ["assert double({1: 2})"]),
    ("cannot-cross", ["assert double(rng)"], 4, ["assert double(rng.normal())"]),
    ("cannot-cross", ["assert double(np)"], 4, ["assert double(np.pi)"]),
    ("cannot-cross", ["class Box:", "    pass", "box = Box()", "assert double(box)"], 7,
     ["def box(u):", "    return u", "assert apply(box, 1, 2)"]),
    ("cannot-cross", ["pairs = zip([1], [2])", "assert double(pairs)"], 5,
     ["pairs = list(zip([1], [2]))", "assert double(pairs)"]),
    ("cannot-cross", ["assert double(np.array([1, 'a'], dtype=object))"], 4,
     ["assert double(np.array([1, 2], dtype=float))"]),
    ("tells-input", [X, "assert len(double(x)) == 5, f'{x}'"], 5,
     [X, "assert len(double(x)) == 5, 'a text'"]),
    ("tells-input", [X, "print(x)", "assert len(double(x)) == 5"], 5,
     [X, "str(x)", "assert len(double(x)) == 5"]),
]  # fmt: skip


def names_of_rules(found: list[tuple[str, list[str], int, list[str]]]) -> list[str]:
    return [f"{rule}-{number}" for number, (rule, *_) in enumerate(found)]


@pytest.mark.parametrize(("rule", "bad", "line", "near"), IN_HIDDEN, ids=names_of_rules(IN_HIDDEN))
def test_a_rule_finds_its_cell_and_leaves_the_near_miss(
    rule: str, bad: list[str], line: int, near: list[str], tmp_path: Path
) -> None:
    found = lint(tmp_path / "bad", with_case(hidden(*bad)))
    assert lines(found, rule) == [line], [str(one) for one in found]
    spared = lint(tmp_path / "near", with_case(hidden(*near)))
    assert not lines(spared, rule), [str(one) for one in spared]
    assert not lines(spared, "unreadable")


REGION = "### BEGIN HIDDEN TESTS\n{}\n### END HIDDEN TESTS\n"
GOOD = "# hint: Try more.\nx = rng.normal()\nassert double(x) == x + x"

# The same with whole cells.
WHOLE: list[tuple[str, str, int, str]] = [
    ("unreadable", "assert double(3 == 6\n", 1, "%time double(3)\nassert double(3) == 6\n"),
    ("no-check", "double(3)\n", 1, "if double(3) != 6:\n    raise AssertionError\n"),
    ("no-check", "\n", 1, "def check(v):\n    assert v\n\n\ncheck(double(3))\n"),
    ("no-check", hidden(X, "double(x)"), 3,
     hidden(X, "np.testing.assert_array_equal(double(x), 2 * x)")),
    ("no-rng", hidden("assert double(5) == 10"), 3, hidden("assert double(rng.uniform()) > 0")),
    ("no-message", "assert double(3) == 6\n", 1, f"assert double(3) == 6, {SAID}\n"),
    ("no-message", "x = 1\nassert double(x) == 2\n", 2, hidden("assert double(1) == 2")),
    ("no-hint", REGION.format("assert double(rng.normal())"), 2, REGION.format(GOOD)),
    ("no-hint", REGION.format("x = rng.normal()\n# hint: Late.\nassert double(x)"), 3,
     REGION.format(GOOD)),
    ("region-place", REGION.format(GOOD) * 2, 6, REGION.format(GOOD)),
    ("region-place", REGION.format(GOOD) + "assert double(1) == 2\n", 6,
     f"assert double(1) == 2\n{REGION.format(GOOD)}\n\n"),
    ("hint-quotes", REGION.format("# hint: Try double(x) == x + x.\nx = rng.normal()\n"
                                  "assert double(x) == x + x"), 2, REGION.format(GOOD)),
    ("hint-quotes", REGION.format("# hint: Mind far_away.\nfar_away = rng.normal()\n"
                                  "assert double(far_away)"), 2,
     "far_away = 2\n" + REGION.format("# hint: Mind far_away.\nassert double(far_away)")),
    ("hint-quotes", REGION.format("# hint: Not only 1234.5 doubles.\nassert double(1234.5)"), 2,
     REGION.format("# hint: Not only 2 doubles.\nassert double(2)")),
]  # fmt: skip


@pytest.mark.parametrize(
    ("rule", "bad", "line", "near"), WHOLE, ids=[f"{w[0]}-{i}" for i, w in enumerate(WHOLE)]
)
def test_a_rule_finds_its_whole_cell_and_leaves_the_near_miss(
    rule: str, bad: str, line: int, near: str, tmp_path: Path
) -> None:
    assert lines(lint(tmp_path / "bad", with_case(bad)), rule) == [line]
    spared = lint(tmp_path / "near", with_case(near))
    assert not lines(spared, rule), [str(one) for one in spared]


def test_two_hidden_cases_are_enough(tmp_path: Path) -> None:
    few = lint(tmp_path / "few", toy.source_notebook())
    assert lines(few, "few-hidden-cases", "double") == [1]
    assert lines(few, "few-hidden-cases", "apply") == [1]
    value = toy.source_notebook()
    value["cells"][2]["source"] = hidden("assert double(rng.normal())")
    enough = lint(tmp_path / "enough", value)
    assert not lines(enough, "few-hidden-cases", "double")


@pytest.mark.parametrize(("points", "is_odd"), [(0, True), (1.5, True), (-1, True), (2, False)])
def test_points_are_whole_and_more_than_none(points: float, is_odd: bool, tmp_path: Path) -> None:
    found = lint(tmp_path, with_case(toy.DOUBLE_RANDOM, points=points))
    assert bool(lines(found, "odd-points")) == is_odd


def test_a_case_that_belongs_to_no_exercise_is_found(tmp_path: Path) -> None:
    found = lint(tmp_path, with_case(toy.DOUBLE_RANDOM, grade_id="test_2"))
    assert lines(found, "orphan-case", "test_2") == [1]
    assert not lines(found, "orphan-case", "double-by-hand")


def test_an_exercise_without_points_is_found_and_a_helper_is_none(tmp_path: Path) -> None:
    value = toy.source_notebook()
    region = "    ### BEGIN SOLUTION\n    return 1\n    ### END SOLUTION\n"
    value["cells"] += [
        toy.cell(f"def lonely():\n{region}", "lonely", solution=True),
        toy.cell(f"def three():\n{region}", "three", solution=True),
        toy.test_cell("assert double(three()) == 2\n", "double-three", 1),
        toy.cell("An essay", "essay", solution=True, grade=True, points=5),
    ]
    found = lint(tmp_path, value)
    assert [one.grade_id for one in found if one.rule == "no-points"] == ["lonely"]


def test_a_solution_cell_without_its_region_is_found(tmp_path: Path) -> None:
    value = toy.source_notebook()
    value["cells"][1]["source"] = "def double(x):\n    return 2 * x\n"
    found = lint(tmp_path, value)
    assert lines(found, "no-solution-region", "double") == [1]
    assert not lines(found, "no-solution-region", "apply")


def test_a_region_in_a_cell_that_is_not_marked_for_it_is_found(tmp_path: Path) -> None:
    region = "def half(x):\n    ### BEGIN SOLUTION\n    return x / 2\n    ### END SOLUTION\n"
    value = toy.source_notebook()
    value["cells"] += [
        toy.cell(region) | {"id": "a"},
        toy.cell(toy.DOUBLE_RANDOM) | {"id": "b"},
        toy.cell(region + REGION.format(GOOD), "half", solution=True),
        toy.test_cell(region, "half-twice", 1),
    ]
    found = [one for one in lint(tmp_path, value) if one.rule == "region-unmarked"]
    assert {(one.grade_id, one.line) for one in found} == {
        *(("set-up 2", 2), ("set-up 3", 2), ("half", 5), ("half-twice", 2)),
    }
    assert "(def half(x):)" in found[0].message and "Autograded answer" in found[0].message


def test_a_set_up_cell_that_draws_is_found_and_a_function_in_it_may(tmp_path: Path) -> None:
    value = toy.source_notebook()
    value["cells"][0]["source"] += (
        "z = rng.normal(size=3)\nw = make(rng)\n\n\ndef later():\n    return rng.normal()\n"
    )
    found = lint(tmp_path, value)
    assert lines(found, "setup-draws", "set-up 1") == [6, 7]
    assert not lines(lint(tmp_path / "near", toy.source_notebook()), "setup-draws", "set-up 1")


def test_a_withheld_module_that_does_not_exist_is_found(tmp_path: Path) -> None:
    config = 'withheld = ["json.decoder", "json.no_such", "no_such_package.part"]\n'
    found = lint(tmp_path, toy.source_notebook(), config)
    said = [one.message for one in found if one.rule == "no-module"]
    assert len(said) == 2 and "json.no_such" in said[0] and "no_such_package" in said[1]


def test_a_package_that_is_not_installed_is_found(tmp_path: Path) -> None:
    config = 'packages = ["numpy", "ctypes", "no_such_package"]\n'
    found = lint(tmp_path, toy.source_notebook(), config)
    said = [one.message for one in found if one.rule == "no-package"]
    assert len(said) == 1 and "no_such_package, which is not installed" in said[0]


def test_an_import_that_students_may_not_make_is_found(tmp_path: Path) -> None:
    """In the set-up, and anywhere in a solution; what a set-up's function imports runs outside."""
    value = toy.source_notebook()
    value["cells"][0]["source"] += "import networkx\n\n\ndef later():\n    import networkx\n"
    solution = value["cells"][1]
    solution["source"] = solution["source"].replace("    return 2", "    import evo\n    return 2")
    found = lint(tmp_path, value)
    assert lines(found, "not-allowed", "set-up 1") == [6]
    assert lines(found, "not-allowed", "double") == [4]
    config = 'packages = ["numpy", "networkx", "evo"]\n'
    assert not [one for one in lint(tmp_path, value, config) if one.rule == "not-allowed"]
    config += 'withheld = ["evo"]\n'
    assert lines(lint(tmp_path, value, config), "not-allowed", "double") == [4]


def test_a_limit_above_the_one_around_it_is_found(tmp_path: Path) -> None:
    config = "[limits]\ncall_seconds = {}\ncell_seconds = 20\nnotebook_seconds = 15\n"
    found = lint(tmp_path, toy.source_notebook(), config.format(30))
    assert len(lines(found, "limits", "autograder.toml")) == 2
    found = lint(tmp_path, toy.source_notebook(), "[limits]\ncall_seconds = 20\n")
    assert not lines(found, "limits", "autograder.toml")


def test_an_exercise_needs_a_wrong_and_a_right_answer_where_answers_are_given(
    tmp_path: Path,
) -> None:
    answers = tmp_path / "answers"
    (answers / toy.NAME).mkdir(parents=True)
    both = "def right_a():\n    pass\n\n\ndef wrong_a():\n    pass\n"
    (answers / toy.NAME / "double.py").write_text(both, encoding="utf-8")
    found = lint(tmp_path, toy.source_notebook(), answers=answers)
    assert lines(found, "no-mutant", "apply") == [1, 1]
    assert not lines(found, "no-mutant", "double")
    (answers / toy.NAME / "double.py").write_text(both[:25], encoding="utf-8")
    found = lint(tmp_path, toy.source_notebook(), answers=answers)
    assert [one.message.split(":")[0].split()[-1] for one in found if one.rule == "no-mutant"][
        :1
    ] == ["wrong_…"]
    (answers / toy.NAME / "double.py").write_text("wrong_a = change(right_a)\n", encoding="utf-8")
    found = lint(tmp_path, toy.source_notebook(), answers=answers)
    unread = [one.message for one in found if one.rule == "no-mutant"]
    assert "double.py cannot be read: " in unread[0]
    assert not [one for one in lint(tmp_path, toy.source_notebook()) if one.rule == "no-mutant"]


def test_a_comment_in_the_hidden_region_allows_a_finding_there(tmp_path: Path) -> None:
    comment = "# lint: allow no-rng (the lesson's own numbers)"
    found = lint(tmp_path, with_case(hidden(comment, "assert double(5) == 10")))
    assert not lines(found, "no-rng")
    assert not [one for one in found if one.rule.startswith("allow")]


def test_a_comment_in_a_solution_region_allows_for_the_exercise_and_its_cases(
    tmp_path: Path,
) -> None:
    value = toy.source_notebook()
    comments = "".join(
        f"    # lint: allow {rule} (a reason)\n" for rule in ("few-hidden-cases", "no-message")
    )
    region = "    ### BEGIN SOLUTION\n"
    value["cells"][1]["source"] = toy.DOUBLE.replace(region, region + comments)
    found = lint(tmp_path, value)
    assert [one.grade_id for one in found if one.rule == "few-hidden-cases"] == ["apply"]
    assert {one.grade_id for one in found if one.rule == "no-message"} == {"apply-by-hand"}


@pytest.mark.parametrize(
    ("source", "rule", "line"),
    [
        (hidden("# lint: allow no-rng", "assert double(5) == 10"), "allow-comment", 4),
        (hidden("# lint: allow no-rng ()", "assert double(5) == 10"), "allow-comment", 4),
        (hidden("# lint: allow no-such (why)", "assert double(5)"), "allow-comment", 4),
        (f"# lint: allow no-message (why)\nassert double(3) == 6, {SAID}\n", "allow-comment", 1),
        (hidden(X, "# lint: allow no-rng (why)", "assert len(double(x)) == 5"), "allow-unused", 5),
    ],
)
def test_a_comment_that_does_not_hold_is_found(
    source: str, rule: str, line: int, tmp_path: Path
) -> None:
    assert lines(lint(tmp_path, with_case(source)), rule) == [line]


def test_a_comment_does_not_reach_the_release(tmp_path: Path) -> None:
    tree = toy.make_tree(tmp_path)
    value = with_case(hidden("# lint: allow no-rng (SECRET-REASON)", "assert double(5) == 10"))
    region = "    ### BEGIN SOLUTION\n"
    allowed = region + "    # lint: allow few-hidden-cases (SECRET-REASON)\n"
    value["cells"][1]["source"] = toy.DOUBLE.replace(region, allowed)
    toy.write(tree / toy.NAME / f"{toy.NAME}.ipynb", value)
    (made,) = release(tree, [], tmp_path / "release")
    assert "SECRET-REASON" not in made.read_text(encoding="utf-8")


def test_results_are_told_apart_by_their_place_in_a_tuple(tmp_path: Path) -> None:
    source = hidden(
        "last, history = apply(abs, 1, 2)",
        "assert np.shape(history) == (3,)",
        "assert np.allclose(last, rng.normal(size=3))",
        "assert np.allclose(history[1], 1.0)",
    )
    found = lint(tmp_path, with_case(source))
    assert lines(found, "shape-unchecked") == [6]
    assert not lines(found, "number-unchecked")


def test_a_variable_that_is_made_anew_is_the_students_no_more(tmp_path: Path) -> None:
    source = hidden(X, GOT, "got = np.ones(5)", "assert not np.any(got > 2)", "assert double(x)")
    assert not lines(lint(tmp_path, with_case(source)), "nan-passes")


def test_a_students_variable_is_followed_too(tmp_path: Path) -> None:
    value = with_case("assert not (level > 3), 'say why'\n")
    value["cells"][1]["source"] += "\n\nlevel = double(1)\n"
    assert lines(lint(tmp_path, value), "nan-passes") == [1]


def test_rules_have_names_of_their_own_and_each_has_a_test() -> None:
    names = [rule.name for rule in RULES]
    assert len(set(names)) == len(names)
    text = Path(__file__).read_text(encoding="utf-8")
    assert not [name for name in names if f'"{name}"' not in text]
    assert all(rule.severity in ("error", "warning") for rule in RULES)
    assert all(rule.summary.endswith(".") for rule in RULES)


Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run ``autograder lint`` on a tree with this case: exit status, output, errors."""

    def command(source: str, *arguments: object) -> tuple[int, str, str]:
        value = clean()
        value["cells"][2]["source"] = source
        tree = toy.make_tree(tmp_path)
        toy.write(tree / toy.NAME / f"{toy.NAME}.ipynb", value)
        status = cli.main(["--solutions", str(tree), "lint", *map(str, arguments)])
        out, err = capsys.readouterr()
        return status, out, err

    return command


ONE = hidden("v = rng.uniform()", "assert double(v) == v + v")


def clean() -> dict[str, Any]:
    """An assignment in which no rule finds anything."""
    return toy.notebook(
        [
            toy.cell(toy.SETUP, "setup", locked=True),
            toy.cell(toy.DOUBLE, "double", solution=True),
            toy.test_cell(ONE, "double-one", 1),
            toy.test_cell(ONE, "double-two", 1),
        ]
    )


def test_a_clean_assignment_passes_even_strictly(run: Run) -> None:
    status, out, _ = run(ONE, "--strict")
    assert status == 0
    assert out == "✓ 0 errors, 0 warnings in 1 assignment.\n"


def test_a_warning_fails_only_strictly(run: Run) -> None:
    source = ONE.replace(f", {SAID}", "")
    status, out, _ = run(source, toy.NAME)
    assert status == 0 and out.endswith("✓ 0 errors, 1 warnings in 1 assignment.\n")
    assert f"{toy.NAME}.ipynb: double-one:1: no-message: Students see" in out
    assert run(source, "--strict")[0] == 1


def test_an_error_fails_and_json_has_every_field(run: Run) -> None:
    status, out, _ = run(ONE.replace(f"double(3) == 6, {SAID}", f"(1, 2), {SAID}"), "--json")
    (found,) = json.loads(out)
    assert status == 1
    assert set(found) == {"path", "grade_id", "line", "rule", "severity", "message"}
    assert (found["grade_id"], found["line"], found["rule"]) == ("double-one", 1, "assert-tuple")
    assert found["severity"] == "error"


def test_wrong_use_names_the_fix(run: Run, tmp_path: Path) -> None:
    status, _, err = run(ONE, "no-such")
    assert status == 2 and "no assignment no-such" in err and toy.NAME in err
    status, _, err = run(ONE, "--answers", tmp_path / "nowhere")
    assert status == 2 and "--answers DIR" in err


def test_rules_are_listed_with_a_sentence_each(run: Run) -> None:
    status, out, _ = run(ONE, "--rules")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == [rule.name for rule in RULES]


def test_a_class_that_tests_use_is_told(tmp_path: Path) -> None:
    value = with_case(f"got = Pair(3)\nassert double(got.x) == 6, {SAID}\n")
    value["cells"][1]["source"] += "\n\nclass Pair:\n    pass\n\n\nclass Own:\n    pass\n"
    found = [one for one in lint(tmp_path, value) if one.rule == "asks-for-class"]
    assert [(one.grade_id, one.message.split(",")[0]) for one in found] == [
        ("double", "Tests use the class Pair")
    ]


def test_nbgraders_own_demonstration_is_told_what_does_not_work_here(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Two notebooks in one assignment, and a test that takes away a function it relies on."""
    command = [sys.executable, "-m", "nbgrader", "quickstart", "demo"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    tree = tmp_path / "demo" / "source"
    assert cli.main(["--solutions", str(tree), "lint"]) == 1
    said = capsys.readouterr().out
    several = [
        line for line in said.splitlines() if line.split(": ")[2:3] == ["several-notebooks"]
    ]
    assert "This assignment is 2 notebooks (problem1.ipynb and problem2.ipynb)" in several[0]
    assert "problem2.ipynb" in several[1] and "holds no test cell" in several[1]
    assert "sum_of_squares_uses_squares:3: rebinds: squares is the student's" in said
    assert cli.main(["--solutions", str(tree), "release", "--out", str(tmp_path / "out")]) == 2
    assert "ps1 has 2 notebooks, and an assignment is one: ps1.ipynb" in capsys.readouterr().err
    # As lint says: a folder for each notebook.
    for path in sorted((tree / "ps1").glob("*.ipynb")):
        (tree / path.stem).mkdir()
        path.rename(tree / path.stem / path.name)
    arguments = ["release", "problem1", "--out", str(tmp_path / "out")]
    (tree / "ps1" / "jupyter.png").unlink()
    (tree / "ps1").rmdir()
    assert cli.main(["--solutions", str(tree), *arguments]) == 0
