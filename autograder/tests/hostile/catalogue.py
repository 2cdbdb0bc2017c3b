"""All entries together, in the order in which one batch grades them."""

import random

from .. import correct
from .broken import BROKEN
from .cells import all_cells
from .entry import Entry
from .files import FILES
from .metadata import METADATA

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
