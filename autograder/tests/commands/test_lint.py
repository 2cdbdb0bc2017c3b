"""Each rule of `autograder lint` finds what it is for, and leaves its near miss alone."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbgrader
import pytest
from robust_slam_autograder import lint as lint_module
from robust_slam_autograder.lint import RULES, Finding

from .. import toy

CELL = "double-random"
SAID = '"say why"'


def hidden(*lines: str) -> str:
    """A case whose hidden region holds these lines, from line 4 on."""
    opening = f"assert double(3) == 6, {SAID}\n### BEGIN HIDDEN TESTS\n# hint: Try more.\n"
    return opening + "\n".join(lines) + "\n### END HIDDEN TESTS\n"


@pytest.fixture
def lint(tmp_path):
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


def with_cells(index: int, *cells: dict[str, Any]) -> dict[str, Any]:
    value = toy.source_notebook()
    value["cells"][index:index] = cells
    return value


def text(source: str) -> dict[str, Any]:
    return toy.cell(source) | {"cell_type": "markdown"}


def places(findings: list[Finding], rule: str) -> list[tuple[str, int]]:
    """The cells and lines in which a rule finds something."""
    return [(one.grade_id, one.line) for one in findings if one.rule == rule]


ROWS = Path(__file__).with_name("lint_rows.txt")


def rows() -> Iterator[Any]:
    """A rule, a case that breaks it, the line, and a near miss."""
    for number, row in enumerate(ROWS.read_text(encoding="utf-8").split("\n=== ")[1:]):
        head, *lines = row.splitlines()
        rule, *whole = head.split(" | ")
        bad = [line for line in lines if line[:1] != "+"]
        near = [line for line in lines if line[:1] != "-"]
        cells = ("\n".join(line[2:] for line in part) for part in (bad, near))
        finds, spares = cells if whole else map(hidden, cells)
        (at,) = (n for n, line in enumerate(bad, 1 if whole else 4) if line[1:2] == "!")
        yield pytest.param(rule, finds, at, spares, id=f"{rule}-{number}")


@pytest.mark.parametrize(("rule", "bad", "line", "near"), list(rows()))
def test_a_rule_finds_its_case_and_leaves_the_near_miss(lint, rule, bad, line, near):
    found = lint(with_case(bad))
    assert [at for cell, at in places(found, rule) if cell == CELL] == [line], found
    spared = lint(with_case(near))
    assert CELL not in dict(places(spared, rule)), spared
    assert not places(spared, "unreadable")


REGION_OF_HALF = "def half(x):\n    ### BEGIN SOLUTION\n    return x / 2\n    ### END SOLUTION\n"
DRAWS = "z = rng.normal(size=3)\nw = make(rng)\n\n\ndef later():\n    return rng.normal()\n"
PICTURE = "pictures.draw(double)\n"
PLAIN_DOUBLE = "def double(x):\n    return 2 * x\n"

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
    ("no-points", with_cells(
        7, toy.cell(REGION_OF_HALF.replace("half", "lonely"), "lonely", solution=True),
        toy.cell(REGION_OF_HALF.replace("half", "three"), "three", solution=True),
        toy.test_cell("assert double(three(6)) == 6\n", "double-three", 1),
        toy.cell("An essay", "essay", solution=True, grade=True, points=5),
    ), "", [("lonely", 1)]),
    ("no-solution-region", toy.source_notebook(double=PLAIN_DOUBLE), "", [("double", 1)]),
    ("unreadable", with_cells(7, toy.test_cell("x", "double-x", 1) | {"cell_type": "raw"}), "",
     [("double-x", 1)]),
    # A picture stands above the checks, or below another heading; there may be none.
    ("late-picture", with_cells(3, toy.cell(PICTURE)), "", [("double-by-hand", 1)]),
    ("late-picture", with_cells(2, toy.cell(PICTURE)), "", []),
    ("late-picture", with_cells(7, text("## All"), toy.cell(PICTURE)), "", []),
    ("rebinds", with_cells(2, toy.cell(f"from pictures import double\n{PICTURE}")), "",
     [("set-up 2", 1)]),
    ("rebinds", with_cells(2, toy.cell(f"from pictures import double as d\n{PICTURE}")), "", []),
    ("miscounted", with_cells(0, text("Three exercises, ten points each.")), "",
     [("first cell", 1)]),
    ("miscounted", with_cells(0, text("Two exercises, 5 points each.")), "", [("first cell", 1)]),
    ("miscounted", with_cells(1, text("## 1 · Double (10 points)"), text("## 3 · A (10 points)")),
     "", [("statements", 1)]),
    ("miscounted", with_cells(0, text("Two exercises, ten points each."),
     text("## 1 · Double (10 points)"), text("## 2 · Apply (10 points)")), "", []),
    # What a function of the set-up draws, it draws later.
    ("setup-draws", toy.source_notebook(setup=toy.SETUP + DRAWS), "",
     [("set-up 1", 6), ("set-up 1", 7)]),
    ("setup-draws", toy.source_notebook(), "", []),
    ("limits", toy.source_notebook(),
     "[limits]\ncall_seconds = 30\ncell_seconds = 20\nnotebook_seconds = 15\n",
     [("autograder.toml", 1)] * 2),
    ("limits", toy.source_notebook(), "[limits]\ncall_seconds = 20\n", []),
]  # fmt: skip


@pytest.mark.parametrize(
    ("rule", "value", "config", "wanted"),
    WHOLE_NOTEBOOKS,
    ids=[f"{rule}-{number}" for number, (rule, *_) in enumerate(WHOLE_NOTEBOOKS)],
)
def test_a_rule_finds_in_a_notebook_what_it_is_for_and_no_more(lint, rule, value, config, wanted):
    assert sorted(places(lint(value, config), rule)) == sorted(wanted)


def test_a_module_that_is_not_installed_is_named(lint):
    config = (
        'packages = ["numpy", "nowhere"]\nwithheld = ["json.decoder", "json.no", "nothing.part"]'
    )
    found = lint(toy.source_notebook(), config)
    said = [one.message for one in found if one.rule == "no-module"]
    assert len(said) == 3 and "json.no," in said[1] and "nothing.part" in said[2]
    assert "names nowhere, which is not installed here" in said[0]


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


ABOUT_ANSWERS = ("no-mutant", "bad-answer")
WRONG = "".join(
    f"[wrong_{name}]\nmisconception = 'Halves x.'\ncode = 'pass'\ncaught_by = '{{{name}}}'\n"
    for name in "abc"
)
RIGHT = "[right_a]\ncode = 'pass'\n[right_b]\ncode = 'pass'\n"
BOTH = RIGHT + WRONG


def caught(a: str = "double-random") -> str:
    return BOTH.format(a=a, b="double-random", c="double-random")


@pytest.mark.parametrize(
    ("double", "wanted"),
    [
        (caught(), []),
        (RIGHT, [("no-mutant", "double", "has 0 of the 3 answers wrong_… that the tests must")]),
        (caught().replace("[right_b]\ncode = 'pass'\n", ""),
         [("no-mutant", "double", "has 1 of the 2 answers right_…")]),
        ("[right_a]\nfrom = 'b'\n", [("bad-answer", "double.toml", "cannot be read: ")]),
        (caught("doubel"), [("bad-answer", "double.toml", "names doubel, not one")]),
        (caught("apply-by-hand"), [("bad-answer", "double.toml", "apply-by-hand")]),
        *((caught().replace("Halves x.", story, 1),
           [("bad-answer", "double.toml", "wrong_a has no misconception that goes on")])
          for story in ("Halves it.", "Half of x.", "Halves x")),
    ],
)  # fmt: skip
def test_an_exercise_needs_answers_that_name_its_cases_where_answers_are_given(
    lint, tmp_path, double, wanted
):
    file = tmp_path / "answers" / toy.NAME / "double.toml"
    file.parent.mkdir(parents=True)
    file.write_text(double, encoding="utf-8")
    found = lint(toy.source_notebook(), answers=tmp_path / "answers")
    assert [cell for cell, _ in places(found, "no-mutant")].count("apply") == 2
    said = [one for one in found if one.rule in ABOUT_ANSWERS and one.grade_id != "apply"]
    for one, (rule, place, text) in zip(said, wanted, strict=True):
        assert (one.rule, one.grade_id) == (rule, place) and text in one.message
    assert not any(places(lint(toy.source_notebook()), rule) for rule in ABOUT_ANSWERS)


TABLE = "Assignment **07-toy**:\n\n| exercise | you write |\n|---|---|\n| `{}` | it |\n"


SPEAKS = [
    ("autograder.toml", 1), ("chapters/07-toy.ipynb", 1), ("chapters/07-toy.ipynb", 5),
    ("chapters/students.md", 2), ("first cell", 2), ("text 2", 1), ("treble.toml", 1),
]  # fmt: skip


@pytest.mark.parametrize(("name", "wanted"), [("treble", SPEAKS), ("double", [])])
def test_each_place_that_speaks_of_an_exercise_that_is_gone_is_named(
    tmp_path, autograder, name, wanted
):
    """With treble in place of double; one line names another assignment, one none."""
    config = f'chapter = "07-toy"\n[sections]\napply = "Again"\ndouble = "{name}"\n'
    own = with_cells(0, text(f"You write\n{name} and apply."), text(f"Use your `{name}`."))
    toy.make_tree(tmp_path, config, own)
    chapter = [text("# double\n\nApply it.\n\n## Again"), text(TABLE.format(f"{name}`, `apply"))]
    toy.write(tmp_path / "chapters/07-toy.ipynb", toy.notebook(chapter))
    pages = f"| `06-toy.zip` | {name} |\n| `07-toy.zip` | {name} |\nA {name}.\n"
    (tmp_path / "chapters/students.md").write_text(pages)
    answers = tmp_path / "answers" / toy.NAME
    answers.mkdir(parents=True)
    (answers / f"{name}.toml").write_text(RIGHT)
    _, out, _ = autograder("lint", "--json", "--answers", answers.parent)
    rules = ("no-section", "stale-text", "bad-answer")
    found = [one for one in json.loads(out) if one["rule"] in rules]
    assert [(one["grade_id"], one["line"]) for one in found] == wanted


REASON = "(SECRET-REASON)"


def test_a_comment_allows_a_finding_in_its_case_or_in_its_exercise(lint):
    begin = "    ### BEGIN SOLUTION\n"
    allows = (
        f"    # lint: allow {rule} {REASON}\n" for rule in ("few-hidden-cases", "no-message")
    )
    case = hidden(f"# lint: allow no-rng {REASON}", "assert double(5) == 10")
    double = toy.DOUBLE.replace(begin, begin + "".join(allows))
    value = toy.source_notebook(double=double, double_random=case.replace(f", {SAID}", ""))
    found = lint(value)
    assert not places(found, "no-rng")
    assert not [one for one in found if one.rule.startswith("allow")]
    assert [cell for cell, _ in places(found, "few-hidden-cases")] == ["apply"]
    assert {cell for cell, _ in places(found, "no-message")} == {"apply-by-hand"}


@pytest.mark.parametrize(
    ("source", "line"),
    [
        (hidden("# lint: allow no-rng", "assert double(5) == 10"), 4),
        (hidden("# lint: allow no-rng ()", "assert double(5) == 10"), 4),
        (hidden("# lint: allow no-such (why)", "assert double(5)"), 4),
        (f"# lint: allow no-rng (why)\n{hidden('assert double(5) == 10')}", 1),
    ],
)
def test_a_comment_that_allows_nothing_is_found(lint, source, line):
    found = lint(with_case(source))
    assert places(found, "allow-comment") == [(CELL, line)]
    assert CELL in dict(places(found, "no-rng"))


def test_rules_have_names_of_their_own_and_each_has_a_test():
    names = [rule.name for rule in RULES]
    assert len(set(names)) == len(names)
    tested = {row.values[0] for row in rows()}
    text = Path(__file__).read_text(encoding="utf-8")
    assert not [name for name in names if name not in tested and f'"{name}"' not in text]
    assert all(rule.severity in ("error", "warning") for rule in RULES)
    assert all(rule.summary.endswith(".") for rule in RULES)


ONE = hidden("v = rng.uniform()", "assert double(v) == v + v")


@pytest.fixture
def run(tmp_path, autograder):
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
    assert run(ONE, "no-such").refused("no assignment no-such", toy.NAME)
    assert run(ONE, "--answers", "nowhere").refused("--answers DIR")


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
    for command in (["lint"], ["release", "--out", tmp_path / "out"]):
        status, _, err = autograder(*command)
        assert status == 2 and "ps1 has 2 notebooks, and an assignment is one: ps1.ipynb" in err
    # As they say: a folder for each notebook.
    for path in sorted((tree / "ps1").glob("*.ipynb")):
        (tree / path.stem).mkdir()
        path.rename(tree / path.stem / path.name)
    shutil.rmtree(tree / "ps1")
    status, said, _ = autograder("lint", "problem1")
    assert status == 1
    assert "sum_of_squares_uses_squares:3: rebinds: squares is the student's" in said
    assert autograder("release", "problem1", "--out", tmp_path / "out")[0] == 0
