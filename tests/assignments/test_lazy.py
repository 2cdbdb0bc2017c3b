"""Answers that solve nothing earn no hidden point; planted weak cases are found."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from tests.assignments import answers, reference
from tests.assignments.lazy.search import earned
from tests.assignments.planted import NAME, plant

pytestmark = pytest.mark.long


@pytest.mark.parametrize("name", answers.assignments())
def test_no_lazy_answer_earns_a_hidden_point(name: str, request: pytest.FixtureRequest) -> None:
    soak = request.config.getoption("--soak")
    for seed in range(1, 4 if soak else 2):
        found = earned(reference.load(name), seed, thorough=soak)
        assert not {one.case.grade_id: one.how for one in found}


SOLUTION = """
def scale(u, k):
    ### BEGIN SOLUTION
    return np.multiply(u, k), np.sign(u), {"largest": np.max(u)}
    ### END SOLUTION
"""
VISIBLE = """
scaled, signs, more = scale([1.0, 2.0], 3.0)
assert np.allclose(scaled, [3.0, 6.0])
### BEGIN HIDDEN TESTS
# hint: Multiply.
"""
HIDDEN = {
    "by-heart": "scaled, _, _ = scale(np.array([1, 2]), 3)\nassert np.allclose(scaled, [3, 6])",
    "constant": "u = rng.uniform(1, 2, 3)\nassert np.allclose(scale(u, 2)[1], 1)",
    "echo": "u = rng.uniform(1, 2, 3)\nassert np.allclose(scale(u, 1.0)[0], u)",
    "apart": (
        "u = -rng.uniform(1, 2, 3)\nscaled, signs, _ = scale(u, 1.0)\n"
        "assert np.allclose(scaled, u) and np.allclose(signs, -1)"
    ),
    "nested": (
        "u = rng.uniform(1, 2, 3)\nscaled, _, more = scale(u, -1.0)\n"
        "assert np.allclose(scaled, -u) and more['largest'] == max(u)"
    ),
    "sound": "u = rng.uniform(1, 2, 3)\nassert np.allclose(scale(u, 2.5)[0], 2.5 * u)",
    "sound-in-one-part": (
        "u = rng.permutation([-1.5, 2.5, 3.5])\nscaled, signs, _ = scale(u, 1.0)\n"
        "assert np.allclose(scaled, u) and np.allclose(signs, np.divide(u, np.abs(u)))\n"
        "assert np.allclose(scale(u, 2.0)[0], 2 * u)"
    ),
}


def test_weak_cases_that_are_planted_are_found(tmp_path: Path) -> None:
    cases = {name: f"{VISIBLE}{hidden}\n### END HIDDEN TESTS" for name, hidden in HIDDEN.items()}
    plant(tmp_path, "scale", SOLUTION, cases)
    found = {one.case.name: one.how for one in earned(reference.load(NAME, tmp_path), 1)}
    assert found.pop("by-heart") == "by heart"
    assert "argument 1" in found.pop("echo")
    assert "minus argument 1" in found.pop("nested")
    assert set(found) == {"constant", "apart"}


def test_a_case_that_sees_only_the_calls_of_a_function_handed_in_is_found(tmp_path: Path) -> None:
    solution = "def ask(f, u):\n    ### BEGIN SOLUTION\n    return f(u, 3)\n    ### END SOLUTION"
    case = """
    seen = []
    ### BEGIN HIDDEN TESTS
    # hint: Call f.
    u = rng.uniform(1, 2)
    answer = ask(lambda v, k: seen.append(v) or k * v, u)
    {check}
    ### END HIDDEN TESTS
    """
    checks = {"calls": "assert seen == [u]", "value": "assert answer == 3 * u"}
    cases = {name: dedent(case.format(check=check)) for name, check in checks.items()}
    plant(tmp_path, "ask", solution, cases)
    solutions = reference.load(NAME, tmp_path)
    assert [one.case.name for one in earned(solutions, 1)] == ["calls"]
