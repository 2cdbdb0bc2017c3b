"""All entries together, in the order in which one batch grades them."""

import random

from tests.autograder import correct
from tests.autograder.hostile.broken import BROKEN
from tests.autograder.hostile.cells import all_cells
from tests.autograder.hostile.entry import Entry
from tests.autograder.hostile.files import FILES
from tests.autograder.hostile.metadata import METADATA

NEIGHBOURS = 8
"""Plain right submissions, for an attack to harm."""

_CELLS = all_cells()
ATTACKS = [entry for entry in [*_CELLS, *METADATA, *FILES, *BROKEN] if entry.kind]
"""Hostile and broken submissions."""
PLAIN = [entry for entry in _CELLS if not entry.kind]
"""Baselines and twins."""
BASELINES = [entry.name for entry in PLAIN if entry.name.startswith("plain-")]
"""Names of those that every attack is held against."""


def entries() -> list[Entry]:
    """Everything in one order, so that plain and correct work runs beside all kinds of attacks."""
    neighbours = [Entry(f"neighbour-{n}", "", "full", correct.plain) for n in range(NEIGHBOURS)]
    found = [*neighbours, *ATTACKS, *PLAIN, *correct.CORRECT]
    random.Random(1).shuffle(found)
    return found
