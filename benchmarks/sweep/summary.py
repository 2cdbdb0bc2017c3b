"""The table of a sweep: a row for each graph, kind of outliers, rate and method.

Precision, recall and ATE are over the runs that ended with a map; ``failed`` counts the others,
and they are never among the ``good``. The median of CPU seconds is over all runs. Solves are
linear solves for the poses, and empty for methods that are not the library's.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from statistics import fmean, median

from benchmarks.methods import METHODS, PARAMETERS
from benchmarks.sweep.definition import CPU_LIMIT, GROUP, KINDS, LOST, PLANS, Plan, digest, worlds
from benchmarks.sweep.journal import Run

COMMAND = "make sweep"
COLUMNS = (
    *("graph", "kind", "percent", "method", "runs", "failed", "good"),
    *("precision", "recall", "ate_median", "ate_worst", "cpu_median", "solves_median"),
)


def text(runs: Iterable[Run]) -> str:
    """Return the table as CSV; lines that begin with # say how it was made."""
    groups: dict[tuple[str, ...], list[Run]] = {}
    runs = list(runs)
    for run in runs:
        groups.setdefault(_place(run), []).append(run)
    out = io.StringIO()
    out.writelines(f"# {line}\n" for line in _header(runs))
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


def _header(runs: Sequence[Run]) -> Iterator[str]:
    """Say what the results depend on: everything that is not in a column."""
    wanted = len(METHODS) * sum(1 for _ in worlds())
    yield f"{COMMAND}; definition {digest()}; {len(runs)} of {wanted} runs"
    for name, plan in PLANS.items():
        size = "public" if plan.poses is None else f"{plan.poses} poses, odometry {_sigma(plan)}"
        yield f"graph {name}: {size}, {plan.closures} closures, seeds 0 to {plan.seeds - 1}"
    yield f"groups of {GROUP}; parameters: " + "; ".join(
        f"{name} {value}" for name, value in PARAMETERS.items()
    )
    yield "precision, recall and ate (m) of the runs that did not fail; good: ate at most " + (
        f"{LOST} m; failed: no map, or none within {CPU_LIMIT} s of CPU time"
    )
    yield f"{sum(run.seconds for run in runs):.0f} s of CPU time"


def _sigma(plan: Plan) -> str:
    position, heading = plan.noise.odometry
    return f"{position} m and {heading} rad a step"


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
