"""A case that refuses a right answer for one seed in a thousand costs a class its points."""

import pytest

from solutions.classes import answers
from tests.assignments import reference


@pytest.mark.soak
@pytest.mark.parametrize("name", answers.assignments())
def test_the_reference_passes_every_hidden_case_with_any_seed(name):
    solutions = reference.load(name)
    for case in solutions.assignment.cases:
        for seed in range(1, 10_001) if case.has_hidden else ():
            try:
                solutions.run(case, seed)
            except Exception as error:  # a test fails by raising, whatever it raises
                error.add_note(f"{case.grade_id} refuses the reference with seed {seed}")
                raise
