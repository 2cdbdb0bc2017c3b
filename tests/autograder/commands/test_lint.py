"""Each rule of `autograder lint` finds what it is for, and leaves its near miss alone."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import nbgrader
import pytest
from robust_slam_autograder import lint as lint_module
from robust_slam_autograder.lint import RULES, Finding
from robust_slam_autograder.publishing.student_release import release

from tests.autograder import toy
from tests.autograder.conftest import Run

CELL = "double-random"
SAID = '"say why"'


def hidden(*lines: str) -> str:
    """A case whose hidden region holds these lines, from line 4 on."""
    opening = f"assert double(3) == 6, {SAID}\n### BEGIN HIDDEN TESTS\n# hint: Try more.\n"
    return opening + "\n".join(lines) + "\n### END HIDDEN TESTS\n"


@pytest.fixture
def lint(tmp_path: Path) -> Any:
    def run(value: dict[str, Any], config: str = "", answers: Path | None = None) -> list[Finding]:
        tree = toy.make_tree(tmp_path, config, value)
        if not config:
            (tree / toy.NAME / "autograder.toml").unlink(missing_ok=True)
        return lint_module.lint(tree / toy.NAME / f"{toy.NAME}.ipynb", answers)

    return run


def with_case(source: str, **fields: Any) -> dict[str, Any]:
    value = toy.source_notebook(double_random=source)
    value["cells"][3]["metadata"]["nbgrader"] |= fields
    return value


def with_more(*cells: dict[str, Any], **sources: str) -> dict[str, Any]:
    value = toy.source_notebook(**sources)
    value["cells"] += cells
    return value


def places(findings: list[Finding], rule: str) -> list[tuple[str, int]]:
    """The cells and lines in which a rule finds something."""
    return [(one.grade_id, one.line) for one in findings if one.rule == rule]


def messages(findings: list[Finding], rule: str) -> list[str]:
    return [one.message for one in findings if one.rule == rule]


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
    # A variable that is made anew is the student's no more.
    ("nan-passes", [X, GOT, "assert not np.any(got > 2)"], 6,
     [X, GOT, "got = np.ones(5)", "assert not np.any(got > 2)", "assert double(x)"]),
]  # fmt: skip


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

CASES = [(rule, hidden(*bad), line, hidden(*near)) for rule, bad, line, near in IN_HIDDEN] + WHOLE
NAMES = [f"{rule}-{number}" for number, (rule, *_) in enumerate(CASES)]


@pytest.mark.parametrize(("rule", "bad", "line", "near"), CASES, ids=NAMES)
def test_a_rule_finds_its_case_and_leaves_the_near_miss(lint, rule, bad, line, near):
    found = lint(with_case(bad))
    assert [at for cell, at in places(found, rule) if cell == CELL] == [line], found
    spared = lint(with_case(near))
    assert CELL not in dict(places(spared, rule)), spared
    assert not places(spared, "unreadable")


REGION_OF_HALF = "def half(x):\n    ### BEGIN SOLUTION\n    return x / 2\n    ### END SOLUTION\n"
DRAWS = "z = rng.normal(size=3)\nw = make(rng)\n\n\ndef later():\n    return rng.normal()\n"
PLAIN_DOUBLE = "def double(x):\n    return 2 * x\n"
LEVEL = toy.DOUBLE + "\n\nlevel = double(1)\n"
PAIR = toy.DOUBLE + "\n\nclass Pair:\n    pass\n\n\nclass Own:\n    pass\n"

# Rule, notebook, configuration, and all that the rule finds in it.
WHOLE_NOTEBOOKS: list[tuple[str, dict[str, Any], str, list[tuple[str, int]]]] = [
    ("few-hidden-cases", toy.source_notebook(), "", [("double", 1), ("apply", 1)]),
    ("few-hidden-cases", toy.source_notebook(double_by_hand=hidden("assert double(rng.normal())")),
     "", [("apply", 1)]),
    *(("odd-points", with_case(toy.DOUBLE_RANDOM, points=points), "", [(CELL, 1)])
      for points in (0, 1.5, -1)),
    ("odd-points", with_case(toy.DOUBLE_RANDOM, points=2), "", []),
    ("orphan-case", with_case(toy.DOUBLE_RANDOM, grade_id="test_2"), "", [("test_2", 1)]),
    # A helper that another exercise's case uses needs no points of its own, nor does an essay.
    ("no-points", with_more(
        toy.cell(REGION_OF_HALF.replace("half", "lonely"), "lonely", solution=True),
        toy.cell(REGION_OF_HALF.replace("half", "three"), "three", solution=True),
        toy.test_cell("assert double(three(6)) == 6\n", "double-three", 1),
        toy.cell("An essay", "essay", solution=True, grade=True, points=5),
    ), "", [("lonely", 1)]),
    ("no-solution-region", toy.source_notebook(double=PLAIN_DOUBLE), "", [("double", 1)]),
    ("region-unmarked", with_more(
        toy.cell(REGION_OF_HALF) | {"id": "a"},
        toy.cell(toy.DOUBLE_RANDOM) | {"id": "b"},
        toy.cell(REGION_OF_HALF + REGION.format(GOOD), "half", solution=True),
        toy.test_cell(REGION_OF_HALF, "half-twice", 1),
    ), "", [("set-up 2", 2), ("set-up 3", 2), ("half", 5), ("half-twice", 2)]),
    # What a function of the set-up draws, it draws later.
    ("setup-draws", toy.source_notebook(setup=toy.SETUP + DRAWS), "",
     [("set-up 1", 6), ("set-up 1", 7)]),
    ("setup-draws", toy.source_notebook(), "", []),
    ("limits", toy.source_notebook(),
     "[limits]\ncall_seconds = 30\ncell_seconds = 20\nnotebook_seconds = 15\n",
     [("autograder.toml", 1)] * 2),
    ("limits", toy.source_notebook(), "[limits]\ncall_seconds = 20\n", []),
    ("nan-passes", toy.source_notebook(
        double_by_hand="assert not (level > 3), 'say why'\n", double=LEVEL), "",
     [("double-by-hand", 1)]),
    ("asks-for-class", toy.source_notebook(
        double=PAIR, double_random=f"got = Pair(3)\nassert double(got.x) == 6, {SAID}\n"), "",
     [("double", 8)]),
]  # fmt: skip


@pytest.mark.parametrize(
    ("rule", "value", "config", "wanted"),
    WHOLE_NOTEBOOKS,
    ids=[f"{rule}-{number}" for number, (rule, *_) in enumerate(WHOLE_NOTEBOOKS)],
)
def test_a_rule_finds_in_a_notebook_what_it_is_for_and_no_more(lint, rule, value, config, wanted):
    assert sorted(places(lint(value, config), rule)) == sorted(wanted)


@pytest.mark.parametrize(
    ("rule", "config", "named"),
    [
        (
            "no-module",
            'withheld = ["json.decoder", "json.no_such", "no_such_package.part"]',
            ["json.no_such", "no_such_package"],
        ),
        (
            "no-package",
            'packages = ["numpy", "ctypes", "no_such_package"]',
            ["no_such_package, which is not installed"],
        ),
    ],
)
def test_a_module_that_does_not_exist_is_named(lint, rule, config, named):
    said = messages(lint(toy.source_notebook(), config), rule)
    assert len(said) == len(named)
    assert all(name in message for name, message in zip(named, said, strict=True))


def test_an_import_that_students_may_not_make_is_found(lint):
    """In the set-up, and anywhere in a solution; what a set-up's function imports runs outside."""
    value = toy.source_notebook(
        setup=f"{toy.SETUP}import networkx\n\n\ndef later():\n    import networkx\n",
        double=toy.DOUBLE.replace("    return 2", "    import evo\n    return 2"),
    )
    assert places(lint(value), "not-allowed") == [("set-up 1", 6), ("double", 4)]
    config = 'packages = ["numpy", "networkx", "evo"]\n'
    assert not places(lint(value, config), "not-allowed")
    assert places(lint(value, f'{config}withheld = ["evo"]\n'), "not-allowed") == [("double", 4)]


@pytest.mark.parametrize(
    ("double", "wanted"),
    [
        ("[right_a]\ncode = 'pass'\n[wrong_a]\ncode = 'pass'\ncaught_by = 'a'\n", []),
        ("[right_a]\ncode = 'pass'\n", ["wrong_…"]),
        ("[right_a]\nfrom = 'right_b'\n", ["read"]),
    ],
)
def test_an_exercise_needs_a_wrong_and_a_right_answer_where_answers_are_given(
    lint, tmp_path, double, wanted
):
    file = tmp_path / "answers" / toy.NAME / "double.toml"
    file.parent.mkdir(parents=True)
    file.write_text(double, encoding="utf-8")
    found = lint(toy.source_notebook(), answers=tmp_path / "answers")
    assert [cell for cell, _ in places(found, "no-mutant")].count("apply") == 2
    said = [m for m in messages(found, "no-mutant") if "apply" not in m]
    assert [message.split(":")[0].split()[-1] for message in said] == wanted
    assert not places(lint(toy.source_notebook()), "no-mutant")


REASON = "(SECRET-REASON)"
FROM_THE_REGION = "    ### BEGIN SOLUTION\n" + "".join(
    f"    # lint: allow {rule} {REASON}\n" for rule in ("few-hidden-cases", "no-message")
)
ALLOWED = toy.source_notebook(
    double=toy.DOUBLE.replace("    ### BEGIN SOLUTION\n", FROM_THE_REGION),
    double_random=hidden(f"# lint: allow no-rng {REASON}", "assert double(5) == 10").replace(
        f", {SAID}", ""
    ),
)


def test_a_comment_allows_a_finding_in_its_case_or_in_its_exercise(lint):
    found = lint(ALLOWED)
    assert not places(found, "no-rng")
    assert not [one for one in found if one.rule.startswith("allow")]
    assert [cell for cell, _ in places(found, "few-hidden-cases")] == ["apply"]
    assert {cell for cell, _ in places(found, "no-message")} == {"apply-by-hand"}


def test_a_comment_does_not_reach_the_release(tmp_path):
    (made,) = release(toy.make_tree(tmp_path, value=ALLOWED), [], tmp_path / "release")
    assert "SECRET-REASON" not in made.read_text(encoding="utf-8")


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
def test_a_comment_that_allows_nothing_is_found(lint, source, rule, line):
    assert places(lint(with_case(source)), rule) == [(CELL, line)]


def test_results_are_told_apart_by_their_place_in_a_tuple(lint):
    source = hidden(
        "last, history = apply(abs, 1, 2)",
        "assert np.shape(history) == (3,)",
        "assert np.allclose(last, rng.normal(size=3))",
        "assert np.allclose(history[1], 1.0)",
    )
    found = lint(with_case(source))
    assert places(found, "shape-unchecked") == [(CELL, 6)]
    assert not places(found, "number-unchecked")


def test_rules_have_names_of_their_own_and_each_has_a_test():
    names = [rule.name for rule in RULES]
    assert len(set(names)) == len(names)
    text = Path(__file__).read_text(encoding="utf-8")
    assert not [name for name in names if f'"{name}"' not in text]
    assert all(rule.severity in ("error", "warning") for rule in RULES)
    assert all(rule.summary.endswith(".") for rule in RULES)


ONE = hidden("v = rng.uniform()", "assert double(v) == v + v")


@pytest.fixture
def run(tmp_path: Path, autograder: Run) -> Run:
    """Run ``autograder lint`` on a tree with this case beside one that has nothing wrong."""

    def command(source: str, *arguments: object) -> tuple[int, str, str]:
        cells = [
            toy.cell(toy.SETUP, "setup", locked=True),
            toy.cell(toy.DOUBLE, "double", solution=True),
            toy.test_cell(source, "double-one", 1),
            toy.test_cell(ONE, "double-two", 1),
        ]
        toy.make_tree(tmp_path, value=toy.notebook(cells))
        return autograder("lint", *arguments)

    return command


def test_a_clean_assignment_passes_even_strictly(run):
    status, out, _ = run(ONE, "--strict")
    assert (status, out) == (0, "✓ 0 errors, 0 warnings in 1 assignment.\n")


def test_a_warning_fails_only_strictly(run):
    source = ONE.replace(f", {SAID}", "")
    status, out, _ = run(source, toy.NAME)
    assert status == 0 and out.endswith("✓ 0 errors, 1 warnings in 1 assignment.\n")
    assert f"{toy.NAME}.ipynb: double-one:1: no-message: Students see" in out
    assert run(source, "--strict")[0] == 1


def test_an_error_fails_and_json_has_every_field(run):
    status, out, _ = run(ONE.replace(f"double(3) == 6, {SAID}", f"(1, 2), {SAID}"), "--json")
    (found,) = json.loads(out)
    assert status == 1
    assert set(found) == {"path", "grade_id", "line", "rule", "severity", "message"}
    assert (found["grade_id"], found["line"], found["rule"]) == ("double-one", 1, "assert-tuple")
    assert found["severity"] == "error"


def test_wrong_use_names_the_remedy(run):
    status, _, err = run(ONE, "no-such")
    assert status == 2 and "no assignment no-such" in err and toy.NAME in err
    status, _, err = run(ONE, "--answers", "nowhere")
    assert status == 2 and "--answers DIR" in err


def test_rules_are_listed_with_a_sentence_each(run):
    status, out, _ = run(ONE, "--rules")
    assert status == 0
    assert [line.split()[0] for line in out.splitlines()] == [rule.name for rule in RULES]


def test_nbgraders_own_demonstration_is_told_what_does_not_work_here(tmp_path, autograder):
    """Two notebooks in one assignment, and a test that takes away a function it relies on."""
    tree = tmp_path / "solutions"
    # What `nbgrader quickstart` copies.
    demonstration = Path(nbgrader.__file__).parent / "docs/source/user_guide/source/ps1"
    shutil.copytree(demonstration, tree / "ps1")
    status, said, _ = autograder("lint")
    assert status == 1
    lines = said.splitlines()
    several = [line for line in lines if line.split(": ")[2:3] == ["several-notebooks"]]
    assert "This assignment is 2 notebooks (problem1.ipynb and problem2.ipynb)" in several[0]
    assert "problem2.ipynb" in several[1] and "holds no test cell" in several[1]
    assert "sum_of_squares_uses_squares:3: rebinds: squares is the student's" in said
    status, _, err = autograder("release", "--out", tmp_path / "out")
    assert status == 2 and "ps1 has 2 notebooks, and an assignment is one: ps1.ipynb" in err
    # As lint says: a folder for each notebook.
    for path in sorted((tree / "ps1").glob("*.ipynb")):
        (tree / path.stem).mkdir()
        path.rename(tree / path.stem / path.name)
    shutil.rmtree(tree / "ps1")
    assert autograder("release", "problem1", "--out", tmp_path / "out")[0] == 0
