"""The best attack on each solver in each town of *Break the map*: the table of a live picture.

python -m tools.data.breaking
python -m tools.data.breaking --out lib/course/robust_slam_course/pictures/breaking.json
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from typing import Any

from robust_slam import breaking

from tools.data import make


def best(town: str, solver: str) -> dict[str, Any]:
    """Return the attacks on a solver that were tried, and the score of the first that fools it.

    They are tried in the order of their scores, so no attack has a better one. The score is None
    where no attack fools the solver.
    """
    tried = 0
    for tried, attack in enumerate(breaking.attacks(town, solver), 1):
        if breaking.bent(attack) > breaking.BOUND:
            return {"tried": tried, "score": str(attack)}
    return {"tried": tried, "score": None}


def table() -> dict[str, Any]:
    """Return the best attack on each solver in each town."""
    with ProcessPoolExecutor() as pool:
        runs = {
            f"{town}:{solver}": pool.submit(best, town, solver)
            for town in breaking.TOWNS
            for solver in breaking.SOLVERS
        }
        return {name: run.result() for name, run in runs.items()}


def told(made: dict[str, Any]) -> Iterator[str]:
    """Yield how many attacks were tried, and the best score."""
    for name, found in made.items():
        yield f"{name:10} {found['tried']:6} {found['score'] or 'none'}"


if __name__ == "__main__":
    make(__doc__, table, told)
