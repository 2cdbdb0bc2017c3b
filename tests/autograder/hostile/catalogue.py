"""All entries together, in the order in which one batch grades them."""

from __future__ import annotations

from tests.autograder import correct
from tests.autograder.hostile.broken import BROKEN
from tests.autograder.hostile.cells import all_cells
from tests.autograder.hostile.entry import Entry
from tests.autograder.hostile.files import FILES
from tests.autograder.hostile.metadata import METADATA

NEIGHBOURS = 8

_CELLS = all_cells()
ATTACKS = [entry for entry in [*_CELLS, *METADATA, *FILES, *BROKEN] if entry.kind]
"""Hostile and broken submissions."""
PLAIN = [entry for entry in _CELLS if not entry.kind]
"""Baselines and twins."""
BASELINES = [entry.name for entry in PLAIN if entry.name.startswith("plain-")]
"""Names of those that every attack is held against."""


def neighbours() -> list[Entry]:
    """Plain right submissions, for an attack to harm."""
    return [Entry(f"neighbour-{n}", "", "full", correct.plain) for n in range(NEIGHBOURS)]


def entries() -> list[Entry]:
    """Everything, correct work spread evenly among the attacks, so that some runs beside each."""
    innocent = [*neighbours(), *PLAIN, *correct.CORRECT]
    count = len(ATTACKS)
    places = [(n + 0.5) * count / len(innocent) for n in range(len(innocent))]
    numbered = [*zip(range(count), ATTACKS, strict=True), *zip(places, innocent, strict=True)]
    return [entry for _, entry in sorted(numbered, key=lambda pair: pair[0])]
