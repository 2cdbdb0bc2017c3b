"""The solvers in the page answer what the library answers.

``tests/course/mutants.py`` plants bugs that these comparisons must catch.
"""

import numpy as np
import pytest

from tests.course import parity
from tests.course.parity import SOLVERS

pytestmark = [pytest.mark.long, pytest.mark.rest]


@pytest.mark.parametrize("name", SOLVERS)
def test_the_page_answers_what_the_library_answers(name):
    differences = parity.compared(name)
    worst = int(np.argmax(differences))
    given = parity.drawn(name)[worst].given
    assert differences[worst] <= SOLVERS[name][1], (worst, given)


def test_there_are_hundreds_of_cases_and_every_reason_to_stop():
    cases = [case for name in SOLVERS for case in parity.drawn(name)]
    assert len(cases) > 800
    assert {case.expected["stop"] for case in cases if "stop" in case.expected} == {
        "converged", "binary weights", "nothing to reject", "all rejected", "underdetermined",
        "iteration limit",
    }  # fmt: skip
