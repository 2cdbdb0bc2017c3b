"""The solvers in the page answer what the library answers, and the comparison catches bugs."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.lib.course import parity
from tests.lib.course.parity import JS, SOLVERS

pytestmark = pytest.mark.long

BUGS = {
    "a sign in a Jacobian": (
        "normal_equations.js",
        "[a, -half, c * x + y / 2]",
        "[a, half, c * x + y / 2]",
        "descents",
    ),
    "a weight without its square": (
        "kernels.js",
        "weight: (u, c) => 1 / (1 + (u / c) ** 2) ** 2,",
        "weight: (u, c) => 1 / (1 + (u / c) ** 2),",
        "loop:locations",
    ),
    "a slower μ": (
        "graduation.js",
        "next: (mu) => factor * mu,",
        "next: (mu) => Math.sqrt(factor) * mu,",
        "loop:annealed locations",
    ),
    "a μ from the wrong norm": (
        "graduation.js",
        'Math.max(0, ...norms), c, "tls"',
        'norms.at(-1), c, "tls"',
        "loop:graphs",
    ),
    "a cost without its half": (
        "loop.js",
        "return robust + 0.5 * trusted;",
        "return robust + trusted;",
        "loop:graphs",
    ),
    "a bound on cliques that is one too low": (
        "consistency.js",
        "if (chosen.length + colours[place] <= best.length) return;",
        "if (chosen.length + colours[place] <= best.length + 1) return;",
        "cliques",
    ),
    "a closure against the direction of travel": (
        "consistency.js",
        "if (ends[0] > ends[1]) {",
        "if (ends[0] < ends[1]) {",
        "pcm",
    ),
    "a fit that is not leaning": (
        "location.js",
        "const height = weightedMean(weights, y);",
        "const height = weightedMean(p, y);",
        "loop:lines",
    ),
    "a multiplier that is not symmetric": (
        "certificate.js",
        "blocks[4 * i + 2] = blocks[4 * i + 1];",
        "blocks[4 * i + 2] = -blocks[4 * i + 1];",
        "climbs",
    ),
    "a transposed measurement": (
        "certificate.js",
        "addBlock(Q, n, i, j, [-cosine, sine, -sine, -cosine]);\n    addBlock(Q, n, j, i, "
        "[-cosine, -sine, sine, -cosine]);\n  });",
        "addBlock(Q, n, j, i, [-cosine, sine, -sine, -cosine]);\n    addBlock(Q, n, i, j, "
        "[-cosine, -sine, sine, -cosine]);\n  });",
        "climbs",
    ),
    "a shared edge without its adjoint": (
        "fleet.js",
        "z: back, information: turned };",
        "z: back, information };",
        "fleets",
    ),
    "a prior of half its log-odds": (
        "priors.js",
        "lambda + 2 * logOdds[k - first]",
        "lambda + logOdds[k - first]",
        "priors",
    ),
    "a covariance of another pose": (
        "covariance.js",
        "const first = 3 * (pose - 1);",
        "const first = 3 * pose - (pose > 1 ? 6 : 3);",
        "covariances",
    ),
    "an offset that goes the other way": (
        "breaking.js",
        "[...offset, 0]",
        "[...offset.map((far) => -far), 0]",
        "attacks",
    ),
    "an attack that is compared with the truth": (
        "breaking.js",
        "bent: ate(x, poses)",
        "bent: ate(x, data.truth)",
        "attacks",
    ),
    "a step that is not halved": (
        "descent.js",
        "retractPoses(here.poses, step, 0.5 ** halvings)",
        "retractPoses(here.poses, step, 1)",
        "descents",
    ),
}


@pytest.fixture(scope="module")
def differences() -> dict[str, list[float]]:
    """All cases of all solvers, in one run of node."""
    return parity.compared(SOLVERS)


@pytest.mark.parametrize("name", SOLVERS)
def test_the_page_answers_what_the_library_answers(
    name: str, differences: dict[str, list[float]]
) -> None:
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


@pytest.mark.parametrize("bug", BUGS)
def test_the_comparison_catches(bug: str, tmp_path: Path) -> None:
    file, right, wrong, solver = BUGS[bug]
    folder = tmp_path / "solve"
    shutil.copytree(JS, folder)
    source = (folder / file).read_text(encoding="utf-8")
    assert source.count(right) == 1
    (folder / file).write_text(source.replace(right, wrong), encoding="utf-8")
    found = parity.compared([solver], folder)[solver]
    assert max(found) > 100 * SOLVERS[solver][1]
