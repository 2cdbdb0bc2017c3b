"""The mutation tool kills what a case notices, reports what survives, refuses stale entries."""

import json
from pathlib import Path

import pytest
from robust_slam_autograder.errors import WrongUse

from tests.assignments.mutation import __main__ as command
from tests.assignments.mutation import equivalents, run
from tests.assignments.mutation.cells import Mutant, mutants
from tests.assignments.mutation.report import Report
from tests.assignments.mutation.run import Verdict
from tests.assignments.planted import NAME, plant

pytestmark = pytest.mark.rest

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
BOTH = {"positive": POSITIVE, "negative": NEGATIVE}


@pytest.fixture
def tree(tmp_path):
    """An assignment of one exercise, whose cases notice all that can be noticed."""
    plant(tmp_path, "size", SOLUTION, BOTH)
    return tmp_path


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """What a run finds in that assignment."""
    tree = tmp_path_factory.mktemp("tree")
    plant(tree, "size", SOLUTION, BOTH)
    return command.mutate(NAME, tree, tree, seed=1, jobs=1)


def status(tree: Path) -> int:
    """The exit status of the command."""
    return command.main([NAME, "--solutions", str(tree), "--judged", str(tree), "--jobs", "1"])


def judge(tree: Path, line: str, becomes: str, reason: str = "0 is -0") -> Path:
    entry = {"exercise": "size", "line": line, "becomes": becomes, "reason": reason}
    text = "".join(f"{key} = {json.dumps(value)}\n" for key, value in entry.items())
    path = tree / NAME / equivalents.FILE
    path.write_text(f"[[equivalent]]\n{text}", encoding="utf-8")
    return path


def changes(source: str) -> set[str]:
    """What may become of a solution's one line."""
    return {mutant.becomes for mutant in mutants("f", CELL.format("a, b", "# before", source))}


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
    assert wanted <= changes(source)


def test_a_change_keeps_the_rest_of_the_text_and_every_mutant_differs():
    text = CELL.format("ψ", "# as it was", "return ψ  -  2")
    found = [mutant.source for mutant in mutants("f", text)]
    assert len(set(found)) == len(found) > 4
    assert text.replace("2", "3") in found
    assert all("# as it was" in source for source in found)


def test_only_solution_regions_are_changed_and_no_words_of_an_error():
    text = CELL.format("a=1", "b = 2", "raise ValueError(f'{a + 1} of 3')")
    assert [mutant.becomes for mutant in mutants("f", text)] == ["pass"]
    with pytest.raises(ValueError, match="BEGIN SOLUTION"):
        mutants("f", "def f(): return 1")


def test_a_planted_mutant_is_killed_by_the_case_that_notices(report):
    killers = {one.mutant.becomes: one.lost for one in report.verdicts}
    assert killers["return u"] == ("size-negative",)
    assert killers["if u < 1:"] == ("size-positive",)
    # Zero is its own negative: no case can tell.
    assert [one.mutant.becomes for one in report.survivors] == ["if u <= 0:"]


def test_what_is_judged_equivalent_counts_for_the_score_alone(report, tree):
    judged = equivalents.read(judge(tree, "if u < 0:", "if u <= 0:"))
    after = Report(NAME, report.verdicts, judged)
    assert (len(after.equivalent), after.score) == (1, 1.0)
    assert after.raw_score == report.raw_score == report.score < 0.95
    assert not after.is_good  # more than a tenth is judged so
    killed = [one for one in report.verdicts if one.is_killed]
    assert Report(NAME, [*report.verdicts, *killed], judged).is_good


def test_a_survivor_is_reported_where_a_case_is_missing(tmp_path, capsys):
    plant(tmp_path, "size", SOLUTION, {"positive": POSITIVE})
    assert status(tmp_path) == 1
    assert "    - return -u\n    + return u\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "becomes", "problem"),
    [("if u < 7:", "if u <= 7:", "no mutant"), ("if u < 0:", "if u >= 0:", "kills")],
)
def test_a_stale_judgement_is_refused(tree, line, becomes, problem, capsys):
    judge(tree, line, becomes)
    assert status(tree) == 2
    assert problem in capsys.readouterr().err


def test_a_judgement_needs_a_reason(tree):
    with pytest.raises(equivalents.Stale, match="reason"):
        equivalents.read(judge(tree, "if u < 0:", "if u <= 0:", reason=" "))


def test_an_endless_loop_is_cut_and_counts_as_killed(tree):
    (one,) = run.exercises(tree / NAME / f"{NAME}.ipynb")
    endless = "def size(u):\n    while True:\n        pass\n"
    limited = run.with_limits(one, seed=1)
    verdict = run.grade(limited, Mutant("size", "size", endless, "", ""), seed=1)
    assert verdict == Verdict(verdict.mutant, (), "timeout")
    assert verdict.is_killed


def test_a_reference_that_loses_marks_is_refused(tmp_path):
    plant(tmp_path, "size", SOLUTION, {"negative": NEGATIVE.replace("== 3", "== 4")})
    with pytest.raises(WrongUse, match="size-negative"):
        command.mutate(NAME, tmp_path, tmp_path, seed=1, jobs=1)
