"""No function that students can import gives a solution's values, or the statement allows it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest

from tests.assignments import answers, library_search, reference
from tests.assignments.library_search import Call, Hit

pytestmark = pytest.mark.long

ALLOWED = ("is fine", "are fine", "you may use", "you may call")
ALL_ALLOWED = (
    "You may use anything in NumPy and SciPy, even where one of their functions is the answer."
)


def hits(assignment: str, withheld: tuple[str, ...], only: str = "") -> Iterator[Hit]:
    calls = calls_of(assignment)
    with np.errstate(all="ignore"):
        for name in sorted({call.function for call in calls if only in ("", call.function)}):
            yield from library_search.search([c for c in calls if c.function == name], withheld)


@cache
def calls_of(assignment: str) -> list[Call]:
    return library_search.recorded(reference.load(assignment), seed=1)


def is_allowed(text: str, library: str) -> bool:
    """Whether the text allows NumPy and SciPy altogether, or this function by its name."""
    if library.startswith(("numpy.", "scipy.")) and ALL_ALLOWED in text:
        return True
    sentences = re.split(r"(?<=[.!?:)])\s", text)
    said = [one for one in sentences if f"`{library}`" in one]
    return any(word in one.lower() for one in said for word in ALLOWED)


def statement(assignment: str, function: str) -> str:
    """The text above the cell in which students write a function, the opening included."""
    cells = answers.source_notebook(assignment)["cells"]
    texts = ["".join(cell["source"]) for cell in cells]
    at = next(k for k, text in enumerate(texts) if re.search(rf"^def {function}\(", text, re.M))
    above = [k for k in range(at) if cells[k]["cell_type"] == "markdown"]
    return f"{texts[0]}\n\n{texts[above[-1]]}"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", answers.assignments())
def test_no_library_function_is_an_answer_unless_the_statement_allows_it(name: str) -> None:
    found = hits(name, reference.load(name).assignment.config.withheld)
    left = [hit for hit in found if not is_allowed(statement(name, hit.function), hit.library)]
    assert not [str(hit) for hit in left], "withhold the module, or say that the call is fine"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    ("name", "function", "library"),
    [
        ("00", "total_cost", "robust_slam.graphs.pose_graph.cost"),
        ("00", "solve_anchored", "robust_slam.descent.start.chordal"),
        ("02", "rho_huber", "scipy.special.huber"),
        ("02", "rho_cauchy", "robust_slam.estimators.kernels.cauchy"),
        ("05", "start_mu", "robust_slam.estimators.graduation.start_mu"),
        ("05", "repaired_gnc", "robust_slam.problems.LocationProblem"),
        ("06", "largest_consistent_set", "robust_slam.consistency.cliques.max_clique"),
        ("06", "pairwise_consistent", "robust_slam.consistency.pairwise.pairwise_consistent"),
        ("07", "connection_matrix", "robust_slam.certificates.sdp.connection_matrix"),
        ("08", "ate", "robust_slam.graphs.metrics.ate"),
    ],
)
def test_the_search_finds_what_would_be_an_answer(name: str, function: str, library: str) -> None:
    (whole,) = (one for one in answers.assignments() if one.startswith(name))
    others = []
    for hit in hits(whole, (), function):
        if library in hit.use:
            return
        others.append(str(hit))
    pytest.fail(f"{library} is not among {others}")


def test_a_statement_allows_what_it_names_in_a_sentence_that_says_so() -> None:
    assert is_allowed(f"Write it. {ALL_ALLOWED}", "scipy.special.huber")
    assert not is_allowed(f"Write it. {ALL_ALLOWED}", "robust_slam.estimators.kernels.huber")
    assert is_allowed("Write it. Calling `scipy.special.huber` is fine.", "scipy.special.huber")
    assert not is_allowed("It is fine. There is `scipy.special.huber`.", "scipy.special.huber")
    assert not is_allowed("Calling scipy is fine.", "scipy.special.huber")
