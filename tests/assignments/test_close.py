"""The ``close`` of the set-up cells takes what agrees, and says what differs."""

import numpy as np
import pytest

from tests.assignments import reference

close = reference.load("03-irls").names["close"]


@pytest.mark.parametrize(
    ("got", "want", "said"),
    [
        (1 + 1e-9, 1, ""),
        ([1, 2], np.array([1.0, 2.0]), ""),
        (np.inf, np.inf, ""),
        ([True, False], [1, 0], ""),
        ([], np.zeros(0), ""),
        ([1.0], 1.0, "Got shape (1,), expected one number."),
        (1.0, [1.0, 1.0], "Got one number, expected shape (2,)."),
        ([], [1.0], "Got shape (0,), expected shape (1,)."),
        ([[1.0, 1.0]], [1.0, 1.0], "Got shape (1, 2), expected shape (2,)."),
        (0.5, 1.0, "Why.\nHere, it is 0.5; expected 1.0."),
        (np.nan, 1.0, "Why.\nHere, it is nan; expected 1.0."),
        ([1.0, np.nan], [1.0, np.nan], "Why.\nHere, entry [1] is nan; expected nan."),
        (np.inf, 1.0, "Why.\nHere, it is inf; expected 1.0."),
        ([[1, 2], [3, 5]], [[1, 2], [3, 4]], "Why.\nHere, entry [1, 1] is 5; expected 4."),
    ],
)
def test_lists_agree_with_arrays_and_what_differs_is_said(got, want, said):
    found = ""
    try:
        close(got, want, "Why.")
    except AssertionError as error:
        found = str(error)
    assert found == said


def test_the_tolerance_may_be_another():
    close(1.05, 1.0, "Why.", rtol=0, atol=0.1)
    with pytest.raises(AssertionError, match=r"^Here, it is 1\.05"):
        close(1.05, 1.0)
