"""What test cells draw from: the batch's seed and the case, and the number of a student's data."""

import contextlib
import hashlib
import hmac
import os
import unicodedata
from collections.abc import Iterator

import numpy as np

SEED_VARIABLE = "ROBUST_SLAM_SEED"
TOWN_VARIABLE = "ROBUST_SLAM_TOWN"
SHARED_TOWN = 0
"""The number of the data that everybody has who was not given a number."""
TOWNS = 10**6
PUBLIC_SEED = 0
"""Visible tests draw what students draw themselves: their messages tell nothing secret."""


def of_submission(secret: int, data: bytes) -> int:
    """Draw the seed of a submission's hidden pass.

    The same notebook has the same mark, while each change of it is checked with other inputs:
    what one hand-in finds out, by whatever channel, is of no use to the next, nor to another
    student. The secret is the batch's.
    """
    drawn = hmac.digest(str(secret).encode(), data, "sha256")
    return int.from_bytes(drawn[:8], "big") >> 1


def case_generator(seed: int, grade_id: str) -> np.random.Generator:
    """Make the generator that a case finds as ``rng``: it follows from seed and grade id alone."""
    digest = hashlib.sha256(grade_id.encode()).digest()
    return np.random.default_rng([seed, int.from_bytes(digest[:8], "big")])


def town_of(secret: str, student: str) -> int:
    """Return the number of a student's data, which tells nothing of the secret."""
    name = unicodedata.normalize("NFC", student.strip())
    digest = hashlib.blake2b(name.encode(errors="surrogateescape"), key=bytes.fromhex(secret))
    return 1 + int.from_bytes(digest.digest(), "big") % (TOWNS - 1)


@contextlib.contextmanager
def environment(seed: int, town: int | None = SHARED_TOWN) -> Iterator[None]:
    """Hand both numbers to the set-up cell, which plain nbgrader runs without them.

    Args:
        seed: of ``rng``.
        town: of the student's data; None leaves the number that stands in the notebook.
    """
    given = {SEED_VARIABLE: str(seed), TOWN_VARIABLE: "" if town is None else str(town)}
    before = {name: os.environ.get(name) for name in given}
    os.environ.update(given)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
