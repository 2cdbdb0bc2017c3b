"""The best attack on each solver in each town of *Break the map*: the table of a live picture.

python -m tools.data.breaking
python -m tools.data.breaking --out lib/robust_slam_course/pictures/breaking.json
"""

from __future__ import annotations

import argparse
import json
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

from robust_slam import breaking


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


def main() -> None:
    """Compute the table, and write it if asked to."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, help="write the table to this file")
    out = parser.parse_args().out
    with ProcessPoolExecutor() as pool:
        runs = {
            f"{town}:{solver}": pool.submit(best, town, solver)
            for town in breaking.TOWNS
            for solver in breaking.SOLVERS
        }
        made = {name: run.result() for name, run in runs.items()}
    for name, found in made.items():
        print(f"{name:10} {found['tried']:6} {found['score'] or 'none'}")
    if out:
        out.write_text(json.dumps(made, indent=0) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
