"""Mutants of the solvers in the page, and the family of parity cases that shows each.

``python -m tests.course.mutants [WORD…]`` tries them, as ``tests/mutants.py`` says.
"""

import re
import sys

from tests.mutants import Mutant, main

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
a multiplier of the next heading, seen by headings, in certificate.js
- multipliers[c >> 1];
+ multipliers[(c + 2) % width >> 1];
a transposed measurement, seen by headings, in certificate.js
- const [cosine, sine] = [Math.cos(turns[k]), Math.sin(turns[k])];
+ const [cosine, sine] = [Math.cos(turns[k]), -Math.sin(turns[k])];
a neighbour that expects the wrong turn, seen by rings, in ring.js
- found[(i + 1) % n] - alpha]
+ found[(i + 1) % n] + alpha]
a shared edge without its adjoint, seen by fleets, in fleet.js
- z: back, information: turned };
+ z: back, information };
a prior of half its log-odds, seen by priors, in priors.js
- lambda + 2 * logOdds[k - first]
+ lambda + logOdds[k - first]
a covariance of another pose, seen by covariances, in covariance.js
- const first = 3 * (pose - 1);
+ const first = 3 * pose - (pose > 1 ? 6 : 3);
an offset that goes the other way, seen by attacks, in ../../../pictures/breaking/attack.js
- [...offset, 0]
+ [...offset.map((far) => -far), 0]
an attack that is compared with the truth, seen by attacks, in ../../../pictures/breaking/attack.js
- bent: ate(x, poses)
+ bent: ate(x, data.truth)
a step that is not halved, seen by descents, in descent.js
- retractPoses(here.poses, step, 0.5 ** halvings)
+ retractPoses(here.poses, step, 1)
""".strip().splitlines()
"""Three lines for each bug: its name, the cases that show it and its file; right; wrong."""
JS = "lib/course/robust_slam_course/canvas/js/solve"
TEST = "tests/course/test_solvers_in_the_page.py::test_the_page_answers_what_the_library_answers"
MUTANTS = [
    Mutant(f"{JS}/{file}", right[2:], wrong[2:], f"{TEST}[{cases}]")
    for bug, right, wrong in zip(BUGS[::3], BUGS[1::3], BUGS[2::3], strict=True)
    for _, cases, file in [re.split(", seen by |, in ", bug)]
]

if __name__ == "__main__":
    raise SystemExit(main(MUTANTS, sys.argv[1:]))
