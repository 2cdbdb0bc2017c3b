"""The two tables of a sweep: tier A world by world, and all tiers in sums.

Precision, recall and ATE are over the runs that ended with a map; ``failed`` counts the others,
and they are never among the ``good``. The median of CPU seconds is over all runs. Solves are
linear solves for the poses, and empty for methods that are not the library's.

A map is good if its ATE is at most ``LOST``. What a world allows differs from world to world,
however, so tiers are compared by another measure: a map is close if its ATE is at most ``TIMES``
that of the map of the correct edges alone, or at most ``SURE`` where that is less. On a public
graph, whose reference is an optimum that other weights of the same measurements move, that is
``LOST``.

Rows of the table that was there before stay where the runs at hand are fewer, so that a machine
without the journal of all others can add a method. ``kept`` in the header names them; what they
won and lost, and their times, are beside the runs of then.
"""

import csv
import io
import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import isnan
from statistics import fmean, median

import numpy as np
from robust_slam.estimators import chi_square_threshold
from robust_slam_course.results import Row
from scipy.stats import binomtest

from benchmarks.methods import GNC, METHODS, ORACLE, PARAMETERS, PROBABILITY, SOLVER, START_TOL
from benchmarks.sweep import seal
from benchmarks.sweep.definition import (
    CPU_LIMIT,
    GENERATED,
    GROUP,
    KINDS,
    LOST,
    PLANS,
    TIERS,
    Plan,
    World,
    digest,
    entered,
    worlds,
)
from benchmarks.sweep.journal import Key, Run

Place = tuple[str, ...]
"""What names a row: its entries before the number of runs."""
COMMAND = "make sweep"
TIMES, SURE = 2.0, 0.1
"""A close map has at most so many times the ATE of the correct edges alone, or so many m."""
COLUMNS = (
    *("graph", "kind", "percent", "method", "runs", "failed", "good"),
    *("precision", "recall", "ate_median", "ate_worst", "cpu_median", "solves_median"),
)
TIER_COLUMNS = (
    *("tier", "part", "method", "runs", "failed", "good", "close", "low", "high", "won", "lost"),
    *("outliers_kept", "outliers", "recall", "ate_median", "nees", "cpu", "cpu_ratio"),
    *("assured_wrong", "flagged", "flagged_close"),
)


def text(runs: Iterable[Run], before: Iterable[Row] = ()) -> str:
    """Return the table of tier A as CSV, a row for each graph, kind, rate and method.

    Lines ``# name: JSON`` ahead of it say how it was made. ``before`` are rows of a table of the
    same version.
    """
    of_tier_a = (run for run in runs if run.world.tier == "A")
    groups = _grouped(of_tier_a, lambda run: (*map(str, run.world[:3]), run.method))
    rows = {place: [*place, *_values(own)] for place, own in groups.items()}
    return _table(_header("A"), COLUMNS, rows, before, _order)


def tiers(runs: Iterable[Run], before: Iterable[Row] = ()) -> str:
    """Return the table of all tiers as CSV, a row for each tier, part and method.

    The part of C, D and G to J is what was changed, of E the percent of outliers, of F the graph.
    ``low`` and ``high`` are the 95 % interval of Wilson for the share of close maps, ``won``
    and ``lost`` the worlds where this method alone, or ``rs.solve`` alone, has one. ``nees`` is
    the mean of close maps, ``cpu`` the sum in seconds and ``cpu_ratio`` its ratio to GNC-TLS in
    the same worlds. ``assured_wrong`` are maps that are not close and that the method calls
    optimal without a warning.
    """
    runs = list(runs)
    done = {run.key: run for run in runs}
    groups = _grouped(runs, lambda run: (run.world.tier, _part(run.world), run.method))
    rows = {place: [*place, *_sums(own, done)] for place, own in groups.items()}
    parts = list(dict.fromkeys((world.tier, _part(world)) for world in worlds()))

    def order(place: Place) -> tuple[object, ...]:
        return place[0], _rank(place[2]), parts.index((place[0], place[1]))

    header = {**_header(), "close": [TIMES, SURE, LOST]}
    return _table(header, TIER_COLUMNS, rows, before, order)


def beside(runs: Iterable[Run], name: str) -> str:
    """Return a few lines: close maps of the method ``name``, of the library and of the best."""
    runs = list(runs)
    done = {run.key: run for run in runs}
    own = [run for run in runs if run.method == name]
    lines = ["Close maps:"]
    for method in (name, SOLVER, ORACLE):
        there = _of(method, own, done)
        lines.append(f"{method:<32}{sum(is_close(run, done) for run in there):>5} of {len(there)}")
    return "\n".join(lines)


def is_close(run: Run, done: Mapping[Key, Run]) -> bool:
    """Tell whether the map of a run is close to that of the correct edges alone."""
    known = done.get((run.world, ORACLE))
    if run.score is None or known is None or known.score is None:
        return False
    sure = SURE if run.world.graph in GENERATED else LOST
    return run.score.ate <= max(sure, TIMES * known.score.ate)


def _grouped(runs: Iterable[Run], place: Callable[[Run], Place]) -> dict[Place, list[Run]]:
    groups: dict[Place, list[Run]] = defaultdict(list)
    for run in runs:
        groups[place(run)].append(run)
    return groups


def _table(
    header: Mapping[str, object],
    columns: Sequence[str],
    rows: Mapping[Place, Sequence[object]],
    before: Iterable[Row],
    order: Callable[[Place], tuple[object, ...]],
) -> str:
    count = columns.index("runs")
    table = {place: [str(value) for value in row] for place, row in rows.items()}
    kept: dict[str, list[str]] = {}
    for old in ([row[name] for name in columns] for row in before):
        place = tuple(old[:count])
        if place not in table or int(table[place][count]) < int(old[count]):
            table[place] = old
            names = kept.setdefault(place[0], [])
            names += [place[-1]] * (place[-1] not in names)
    runs = sum(int(row[count]) for row in table.values())
    told = {**header, "runs": f"{runs} of {header['runs']}", "kept": kept}
    out = io.StringIO()
    out.writelines(f"# {name}: {json.dumps(value)}\n" for name, value in told.items())
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(table[place] for place in sorted(table, key=order))
    return out.getvalue()


def _part(world: World) -> str:
    if world.tier == "E":
        return f"{world.percent} %"
    return world.graph if world.tier == "F" else world.change


def _order(place: Place) -> tuple[int, ...]:
    graph, kind, percent, method = place
    ranks = (list(PLANS).index(graph), KINDS.index(kind), int(percent))
    return *ranks, _rank(method)


def _rank(method: str) -> int:
    """Return the place of a method among all; those that were entered from outside come last."""
    return list(METHODS).index(method) if method in METHODS else len(METHODS)


def _header(tiers: Iterable[str] = TIERS) -> dict[str, object]:
    """Return what the results depend on, and how many runs there are with all methods."""
    thresholds = {dof: chi_square_threshold(PROBABILITY, dof) for dof in (3, 6)}
    return {
        "version": digest(),
        "sealed": seal.HASH,
        "command": COMMAND,
        "runs": sum(len(entered(world)) for world in worlds(tiers)),
        "graphs": {name: _described(plan) for name, plan in PLANS.items()},
        "group": GROUP,
        "good": LOST,
        "failed": f"no map, or none within {CPU_LIMIT} s of CPU time",
        "parameters": PARAMETERS | {"tol of the start": START_TOL, "c": thresholds},
    }


def _described(plan: Plan) -> dict[str, object]:
    own = {} if plan.poses is None else {"poses": plan.poses, "odometry": plan.noise.odometry}
    return {**own, "closures": plan.closures, "seeds": plan.seeds}


def _values(runs: list[Run]) -> list[object]:
    scores = [run.score for run in runs if run.score is not None]
    counts = [len(runs), len(runs) - len(scores), sum(one.ate <= LOST for one in scores)]
    seconds = _short(float(np.median([run.seconds for run in runs])), 2)
    if not scores:
        return [*counts, "", "", "", "", seconds, ""]
    errors = [one.ate for one in scores]
    means = (fmean(one.precision for one in scores), fmean(one.recall for one in scores))
    solves = [one.solves for one in scores if one.solves is not None]
    middle = _short(median(solves), 0) if solves else ""
    return [*counts, *map(_short, (*means, median(errors), max(errors))), seconds, middle]


def _sums(runs: list[Run], done: Mapping[Key, Run]) -> list[object]:
    close = {run.world for run in runs if is_close(run, done)}
    scores = {run.world: run.score for run in runs if run.score is not None}
    ours = _of(SOLVER, runs, done)
    theirs = {run.world for run in ours if is_close(run, done)}
    met = {run.world for run in ours}
    interval = binomtest(len(close), len(runs)).proportion_ci(method="wilson")
    each = scores.values()
    nees = [one.nees for world, one in scores.items() if world in close and one.nees is not None]
    cpu = sum(run.seconds for run in runs)
    base = sum(run.seconds for run in _of(GNC, runs, done))
    judged = {world: one for world, one in scores.items() if one.flagged is not None}
    own = [
        sum(bool(one.assured) for world, one in judged.items() if world not in close),
        sum(bool(one.flagged) for one in judged.values()),
        sum(bool(one.flagged) for world, one in judged.items() if world in close),
    ]
    return [
        *(len(runs), len(runs) - len(scores), sum(one.ate <= LOST for one in each)),
        *(len(close), _short(interval.low), _short(interval.high)),
        *(len((close & met) - theirs), len(theirs - close)),
        *(sum(one.outliers for one in each), sum(one.wrong for one in each)),
        _mean([one.recall for one in each]),
        _short(median(one.ate for one in each)) if scores else "",
        *(_mean(nees), _short(cpu, 1), _short(cpu / base, 2) if base else ""),
        *(own if judged else ["", "", ""]),
    ]


def _of(method: str, runs: list[Run], done: Mapping[Key, Run]) -> list[Run]:
    found = (done.get((run.world, method)) for run in runs)
    return [run for run in found if run is not None]


def _mean(values: Sequence[float]) -> str:
    return _short(fmean(values)) if values else ""


def _short(value: float, digits: int = 3) -> str:
    return "" if isnan(value) else f"{round(value, digits):g}"
