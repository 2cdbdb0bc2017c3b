"""The best attack on each solver in each town, which the picture keeps in ``best.json``."""

from concurrent.futures import ProcessPoolExecutor
from typing import Any

from robust_slam_course.pictures.breaking import rules


def best(town: str, solver: str) -> dict[str, Any]:
    """Return the attacks on a solver that were tried, and the score of the first that fools it.

    They are tried in the order of their scores, so no attack has a better one. The score is None
    where no attack fools the solver.
    """
    tried = 0
    for tried, attack in enumerate(rules.attacks(town, solver), 1):
        if rules.bent(attack) > rules.BOUND:
            return {"tried": tried, "score": str(attack)}
    return {"tried": tried, "score": None}


def table() -> dict[str, Any]:
    """Return the best attack on each solver in each town."""
    with ProcessPoolExecutor() as pool:
        runs = {
            f"{town}:{solver}": pool.submit(best, town, solver)
            for town in rules.TOWNS
            for solver in rules.SOLVERS
        }
        return {name: run.result() for name, run in runs.items()}
