"""The solvers in the page answer what the library answers, and the comparison catches bugs."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.lib.course import parity
from tests.lib.course.parity import JS, SOLVERS

pytestmark = [pytest.mark.long, pytest.mark.rest]

BUGS = """
a sign in a Jacobian, seen by descents, in normal_equations.js
- [a, -half, c * x + y / 2]
+ [a, half, c * x + y / 2]
a weight without its square, seen by loop:locations, in kernels.js
- weight: (u, c) => 1 / (1 + (u / c) ** 2) ** 2,
+ weight: (u, c) => 1 / (1 + (u / c) ** 2),
a slower μ, seen by loop:annealed locations, in graduation.js
- next: (mu) => factor * mu,
+ next: (mu) => Math.sqrt(factor) * mu,
a μ from the wrong norm, seen by loop:graphs, in graduation.js
- Math.max(0, ...norms), c, "tls"
+ norms.at(-1), c, "tls"
a cost without its half, seen by loop:graphs, in loop.js
- return robust + 0.5 * trusted;
+ return robust + trusted;
a bound on cliques that is one too low, seen by cliques, in consistency.js
- if (chosen.length + colours[place] <= best.length) return;
+ if (chosen.length + colours[place] <= best.length + 1) return;
a closure against the direction of travel, seen by pcm, in consistency.js
- if (ends[0] > ends[1]) {
+ if (ends[0] < ends[1]) {
a fit that is not leaning, seen by loop:lines, in location.js
- const height = weightedMean(weights, y);
+ const height = weightedMean(p, y);
a multiplier that is not symmetric, seen by climbs, in certificate.js
- blocks[4 * i + 2] = blocks[4 * i + 1];
+ blocks[4 * i + 2] = -blocks[4 * i + 1];
a transposed measurement, seen by climbs, in certificate.js
- const [cosine, sine] = [Math.cos(turns[k]), Math.sin(turns[k])];
+ const [cosine, sine] = [Math.cos(turns[k]), -Math.sin(turns[k])];
a shared edge without its adjoint, seen by fleets, in fleet.js
- z: back, information: turned };
+ z: back, information };
a prior of half its log-odds, seen by priors, in priors.js
- lambda + 2 * logOdds[k - first]
+ lambda + logOdds[k - first]
a covariance of another pose, seen by covariances, in covariance.js
- const first = 3 * (pose - 1);
+ const first = 3 * pose - (pose > 1 ? 6 : 3);
an offset that goes the other way, seen by attacks, in breaking.js
- [...offset, 0]
+ [...offset.map((far) => -far), 0]
an attack that is compared with the truth, seen by attacks, in breaking.js
- bent: ate(x, poses)
+ bent: ate(x, data.truth)
a step that is not halved, seen by descents, in descent.js
- retractPoses(here.poses, step, 0.5 ** halvings)
+ retractPoses(here.poses, step, 1)
""".strip().splitlines()
"""Three lines for each bug: its name, the solver that shows it and its file; right; wrong."""
PLANTED = list(zip(BUGS[::3], BUGS[1::3], BUGS[2::3], strict=True))


@pytest.fixture(scope="module")
def differences() -> dict[str, list[float]]:
    """All cases of all solvers, in one run of node."""
    return parity.compared(SOLVERS)


@pytest.mark.parametrize("name", SOLVERS)
def test_the_page_answers_what_the_library_answers(
    name: str, differences: dict[str, list[float]]
) -> None:
    """The first one waits for all cases of all solvers, here and in one run of node."""
    worst = int(np.argmax(differences[name]))
    given = parity.drawn(name)[worst].given
    assert differences[name][worst] <= SOLVERS[name][1], (worst, given)


def test_there_are_hundreds_of_cases_and_every_reason_to_stop() -> None:
    cases = [case for name in SOLVERS for case in parity.drawn(name)]
    assert len(cases) > 800
    assert {case.expected["stop"] for case in cases if "stop" in case.expected} == {
        "converged", "binary weights", "nothing to reject", "all rejected", "underdetermined",
        "iteration limit",
    }  # fmt: skip


@pytest.mark.parametrize(("bug", "right", "wrong"), PLANTED, ids=BUGS[::3])
def test_the_comparison_catches(bug: str, right: str, wrong: str, tmp_path: Path) -> None:
    _, solver, file = re.split(", seen by |, in ", bug)
    folder = tmp_path / "solve"
    shutil.copytree(JS, folder)
    source = (folder / file).read_text(encoding="utf-8")
    assert source.count(right[2:]) == 1
    (folder / file).write_text(source.replace(right[2:], wrong[2:]), encoding="utf-8")
    found = parity.compared([solver], folder)[solver]
    assert max(found) > 100 * SOLVERS[solver][1]
