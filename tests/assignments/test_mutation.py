"""The mutation tool kills what a case notices, reports what survives, refuses stale entries."""

import json
from pathlib import Path

import pytest

from autograder.tests import toy
from tests.assignments.mutation import __main__ as command
from tests.assignments.mutation import equivalents
from tests.assignments.mutation.cells import mutants

pytestmark = pytest.mark.rest

NAME = "planted"
SOLUTION = """\
def size(u):
    ### BEGIN SOLUTION
    if u < 0:
        return -u
    return u
    ### END SOLUTION
"""
CELL = "def f({}):\n    {}\n    ### BEGIN SOLUTION\n    {}\n    ### END SOLUTION\n"
POSITIVE = "assert size(3) == 3\nassert size(0.5) == 0.5"
NEGATIVE = "assert size(-0.5) == 0.5\nassert size(-3) == 3"


def plant(tree: Path, **cases: str) -> Path:
    """Write an assignment of one exercise; its cases are test cells of one point each."""
    cells = [toy.cell("import numpy as np", "setup", locked=True)]
    cells.append(toy.cell(SOLUTION, "size", solution=True))
    cells += [toy.test_cell(source, f"size-{name}", 1) for name, source in cases.items()]
    toy.write(tree / NAME / f"{NAME}.ipynb", toy.notebook(cells))
    return tree


def status(tree: Path) -> int:
    """The exit status of the command."""
    return command.main([NAME, "--solutions", str(tree), "--judged", str(tree), "--jobs", "1"])


@pytest.mark.parametrize(
    ("source", "wanted"),
    [
        ("return a * b", {"return a / b", "return -(a * b)", "pass"}),
        ("return a @ b", {"return a * b", "return b @ a"}),
        ("return a <= b", {"return a < b", "return a > b"}),
        ("return a and b", {"return a or b"}),
        ("return (a + b) * 2", {"return (a - b) * 2", "return (a + b) * 4", "return (a + b) * 1"}),
        ("return a[0]", {"return a[1]", "return a[-1]"}),
        ("return a[b]", {"return a[b + 1]", "return a[b - 1]"}),
        ("return a[:b]", {"return a[1:b]", "return a[:b - 1]", "return a[:b + 1]"}),
        ("return [0 for _ in range(b)]", {"return [0 for _ in range(b - 1)]"}),
        (
            "return np.sum(a, axis=0)",
            {"return np.mean(a, axis=0)", "return np.sum(a)", "return a"},
        ),
        ("return np.arctan2(a, b)", {"return np.arctan2(b, a)"}),
        ("return a.T", {"return a"}),
        ("return a, b", {"return (b, a)", "return -a, b", "return a, -b"}),
        ("a += b", {"a -= b", "pass"}),
        ("if f(a): a = True", {"if not f(a): a = True", "if f(a): a = False"}),
        ("a = np.inf", {"a = np.nan"}),
    ],
)
def test_a_line_is_changed_in_all_the_ways_that_it_can_be(source, wanted):
    found = mutants("f", CELL.format("a, b", "# before", source))
    assert wanted <= {mutant.becomes for mutant in found}


def test_only_solution_regions_are_changed_and_no_words_of_an_error():
    text = CELL.format("a=1", "b = 2", "raise ValueError(f'{a + 1} of 3')")
    assert [mutant.becomes for mutant in mutants("f", text)] == ["pass"]
    with pytest.raises(ValueError, match="BEGIN SOLUTION"):
        mutants("f", "def f(): return 1")


def test_a_planted_mutant_is_killed_by_the_case_that_notices(tmp_path):
    tree = plant(tmp_path, positive=POSITIVE, negative=NEGATIVE)
    report = command.mutate(NAME, tree, tree, seed=1, jobs=1)
    killers = {one.mutant.becomes: one.lost for one in report.verdicts}
    assert killers["return u"] == ("size-negative",)
    assert killers["if u < 1:"] == ("size-positive",)
    # Zero is its own negative: no case can tell.
    assert [one.mutant.becomes for one in report.survivors] == ["if u <= 0:"]


def test_a_survivor_is_reported_where_a_case_is_missing(tmp_path, capsys):
    assert status(plant(tmp_path, positive=POSITIVE)) == 1
    assert "    - return -u\n    + return u\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "becomes", "problem"),
    [("if u < 7:", "if u <= 7:", "no mutant"), ("if u < 0:", "if u >= 0:", "kills")],
)
def test_a_stale_judgement_is_refused(tmp_path, line, becomes, problem, capsys):
    tree = plant(tmp_path, positive=POSITIVE, negative=NEGATIVE)
    entry = {"exercise": "size", "line": line, "becomes": becomes, "reason": "0 is -0"}
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in entry.items())
    (tree / NAME / equivalents.FILE).write_text(f"[[equivalent]]\n{text}", encoding="utf-8")
    assert status(tree) == 2
    assert problem in capsys.readouterr().err
