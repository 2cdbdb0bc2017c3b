"""The list of the grader's mutants keeps up with the grader and its tests."""

from __future__ import annotations

import pytest

from tests.autograder import mutants
from tests.autograder.mutants import Mutant


@pytest.mark.parametrize("mutant", mutants.MUTANTS, ids=lambda one: f"{one.file}: {one.caught_by}")
def test_a_mutant_changes_one_place_and_names_a_test(mutant: Mutant) -> None:
    text = (mutants.ROOT / mutants.PACKAGE / mutant.file).read_text("utf-8")
    assert text.count(mutant.old) == 1 and mutant.old != mutant.new
    file, *_, name = mutant.caught_by.split("::")
    assert f"def {name}(" in (mutants.ROOT / mutants.TESTS / file).read_text("utf-8")
