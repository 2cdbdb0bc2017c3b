"""The table of a sweep: a row for each graph, kind of outliers, rate and method.

Precision, recall and ATE are over the runs that ended with a map; ``failed`` counts the others,
and they are never among the ``good``. The median of CPU seconds is over all runs. Solves are
linear solves for the poses, and empty for methods that are not the library's.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Sequence
from statistics import fmean, median

from robust_slam.estimators import chi_square_threshold

from benchmarks.methods import METHODS, PARAMETERS, PROBABILITY, START_TOL
from benchmarks.sweep.definition import CPU_LIMIT, GROUP, KINDS, LOST, PLANS, Plan, digest, worlds
from benchmarks.sweep.journal import Run

COMMAND = "make sweep"
COLUMNS = (
    *("graph", "kind", "percent", "method", "runs", "failed", "good"),
    *("precision", "recall", "ate_median", "ate_worst", "cpu_median", "solves_median"),
)


def text(runs: Iterable[Run]) -> str:
    """Return the table as CSV; lines ``# name: JSON`` before it say how it was made."""
    groups: dict[tuple[str, ...], list[Run]] = {}
    runs = list(runs)
    for run in runs:
        groups.setdefault(_place(run), []).append(run)
    out = io.StringIO()
    out.writelines(f"# {name}: {json.dumps(value)}\n" for name, value in _header(runs).items())
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([*place, *_values(groups[place])] for place in sorted(groups, key=_order))
    return out.getvalue()


def _place(run: Run) -> tuple[str, ...]:
    return run.world.graph, run.world.kind, str(run.world.percent), run.method


def _order(place: tuple[str, ...]) -> tuple[int, ...]:
    graph, kind, percent, method = place
    ranks = (list(PLANS).index(graph), KINDS.index(kind), int(percent))
    return *ranks, list(METHODS).index(method)


def _header(runs: Sequence[Run]) -> dict[str, object]:
    """Return what the results depend on: everything that is not in a column."""
    wanted = len(METHODS) * sum(1 for _ in worlds())
    thresholds = {dof: chi_square_threshold(PROBABILITY, dof) for dof in (3, 6)}
    return {
        "version": digest(),
        "command": COMMAND,
        "runs": f"{len(runs)} of {wanted}",
        "graphs": {name: _described(plan) for name, plan in PLANS.items()},
        "group": GROUP,
        "good": LOST,
        "failed": f"no map, or none within {CPU_LIMIT} s of CPU time",
        "parameters": PARAMETERS | {"tol of the start": START_TOL, "c": thresholds},
        "cpu seconds": round(sum(run.seconds for run in runs)),
    }


def _described(plan: Plan) -> dict[str, object]:
    own = {} if plan.poses is None else {"poses": plan.poses, "odometry": plan.noise.odometry}
    return {**own, "closures": plan.closures, "seeds": plan.seeds}


def _values(runs: list[Run]) -> list[object]:
    scores = [run.score for run in runs if run.score is not None]
    counts = [len(runs), len(runs) - len(scores), sum(one.ate <= LOST for one in scores)]
    seconds = _short(median(run.seconds for run in runs), 2)
    if not scores:
        return [*counts, "", "", "", "", seconds, ""]
    errors = [one.ate for one in scores]
    means = (fmean(one.precision for one in scores), fmean(one.recall for one in scores))
    solves = [one.solves for one in scores if one.solves is not None]
    middle = _short(median(solves), 0) if solves else ""
    return [*counts, *map(_short, (*means, median(errors), max(errors))), seconds, middle]


def _short(value: float, digits: int = 3) -> str:
    return f"{round(value, digits):g}"
