"""Checks of what a chapter's text says about the data that the chapter hands out."""

import numpy as np
from numpy.typing import ArrayLike

CHANGED = (
    "You changed the data or the code, so this check of the text no longer applies: "
    "what you see holds for yours, the text for the book's."
)


def check_text(*holds: ArrayLike) -> None:
    """Print a sentence if the text does not hold for what a cell has computed.

    All of `holds` has to hold, and of an array all entries. A reader may change the data of an
    example, and sees what they give. What holds for all data is an ``assert``; that the text holds
    for the book's data is a test of the book.
    """
    if not all(map(np.all, holds)):
        print(CHANGED)


def near(values: ArrayLike, printed: ArrayLike, tol: float = 1e-8) -> bool:
    """Tell whether values are as printed, to a tolerance; of another number they are not."""
    there, here = np.asarray(values), np.asarray(printed)
    return there.shape == here.shape and bool(np.allclose(there, here, atol=tol))
