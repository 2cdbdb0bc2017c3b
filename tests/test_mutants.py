"""Mutants that no longer fit the project are named before any is tried."""

from tests.mutants import Mutant, main


def test_what_no_longer_applies_or_names_no_test_is_named(capsys):
    here = "tests/test_mutants.py"
    gone = [
        Mutant(here, "is_gone", "", f"{here}::test_that_is_gone"),
        Mutant("tests/that_is_gone.py", "text", "", f"{here}::test_that_is_gone"),
    ]
    assert main(gone, []) == 2
    said = capsys.readouterr().err
    assert f"{here} has 'is_gone' " in said
    assert "that_is_gone.py has 'text' 0 times" in said and f"{here}::test_that_is_gone" in said
