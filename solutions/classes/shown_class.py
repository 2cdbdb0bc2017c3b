"""The class whose report and feedback the site shows: twelve invented students in two assignments.

``python -m solutions.classes.shown_class write RELEASE OUT`` releases both into ``RELEASE``, and
writes the class to ``OUT/<student>/<assignment>/``.
``python -m solutions.classes.shown_class pages GRADED OUT`` writes the pages for the site.

Most students hand in answers of the tests, right and wrong, of which the site shows marks alone.
The two whose feedback it shows hand in attempts of their own, which are written here, are naive,
and hold no line of a solution.
"""

import contextlib
import io
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_slam_autograder import cli

from solutions.classes import answers

ONE_LIE, M_ESTIMATORS = "00-one-lie", "01-m-estimators"
SHOWN = {"student-03": ONE_LIE, "student-07": M_ESTIMATORS}
"""Whose feedback is on the site, and on which assignment."""
SITE = "../../.."
"""The site's root, from a page of feedback on it."""
NOTICE = "A sample from the course’s site: the students are invented."
BROKEN = ("cut short",)
"""In place of answers: a file that is not whole."""

TABLE: Mapping[str, Mapping[str, Sequence[str]]] = {
    # total_cost, normal_equations, solve_anchored, strained_edges
    ONE_LIE: {
        "student-01": ["right_sum", "right_identity", "right_strike", "right_array"],
        "student-02": ["right_norm", "wrong_factor_two", "wrong_unweighted", "wrong_sign_dropped"],
        "student-04": ["wrong_half", "right_edge_by_edge", "right_prior", "wrong_sign_dropped"],
        "student-05": ["right_plain_loop", "wrong_unweighted", "", ""],
        "student-06": ["right_sum", "wrong_repeats_lost", "wrong_unweighted", "right_two_sides"],
        "student-07": ["right_norm", "right_laplacian", "right_lagrange", "wrong_three_sigma"],
        "student-08": ["wrong_distances", "wrong_sign_of_b", "", "wrong_sign_dropped"],
        "student-09": (),
        "student-10": ["right_sum", "right_identity", "wrong_unweighted", "wrong_sign_dropped"],
        "student-11": ["wrong_half", "wrong_buffered_index", "wrong_unweighted", ""],
        "student-12": ["right_sum", "right_laplacian", "right_strike", "wrong_squared"],
    },
    # influence, weight, location, classify
    M_ESTIMATORS: {
        "student-01": ["right_mid", "right_where", "right_average", "right_pair"],
        "student-02": ["right_mid", "wrong_plain_division", "wrong_one_step", "wrong_any_rise"],
        "student-03": ["wrong_one_sided", "wrong_plain_division", "", ""],
        "student-04": ["right_tiny_one_sided", "right_masked", "wrong_one_step", "wrong_any_fall"],
        "student-05": ["wrong_cost_over_u", "wrong_plain_division", "wrong_one_step", ""],
        "student-06": ["right_mid", "wrong_zero_at_zero", "right_increment", "wrong_any_rise"],
        "student-08": BROKEN,
        "student-09": ["wrong_large_step", "wrong_plain_division", "wrong_not_whitened", ""],
        "student-10": ["right_mid", "right_where", "wrong_median", "wrong_huber_unbounded"],
        "student-11": ["wrong_one_sided", "wrong_plain_division", "", "wrong_near_sighted"],
        "student-12": ["right_five_points", "right_where", "right_average", "wrong_any_rise"],
    },
}
"""By assignment and student the answer to each exercise, by its name in solutions/answers.

Where a name is empty the exercise is not written; where there is none, nothing is handed in.
"""

ATTEMPTS: Mapping[str, Mapping[str, str]] = {
    # The first thing that comes to mind, without uncertainties.
    "student-03": {
        "total_cost": """\
def total_cost(x, i, j, z, sigma):
    error = 0
    for k in range(len(z)):
        error = error + abs(x[j[k]] - x[i[k]] - z[k])
    return error
""",
        "normal_equations": """\
def normal_equations(n, i, j, z, sigma):
    H = np.eye(n)
    b = np.zeros(n)
    for k in range(len(z)):
        b[j[k]] = z[k]
    return H, b
""",
        "solve_anchored": """\
def solve_anchored(n, i, j, z, sigma, anchor=0):
    # follow the edges one after the other
    x = np.zeros(n)
    for k in range(len(z)):
        x[j[k]] = x[i[k]] + z[k]
    return x
""",
        "strained_edges": """\
def strained_edges(residuals, tol):
    answer = []
    for r in residuals:
        answer.append(r > tol)
    return answer
""",
    },
    # It looks finished, but the repetition and the case of 0 are missing.
    "student-07": {
        "influence": """\
def influence(rho, u):
    u = np.asarray(u, float)
    step = 1e-3
    return (rho(u + step) - rho(u)) / step
""",
        "weight": """\
def weight(psi, u):
    u = np.asarray(u, float)
    return psi(u) / u
""",
        "location": """\
def location(z, sigma, weight, x0, tol):
    # todo: repeat this until x stays
    w = weight(np.asarray(z, float) - x0)
    return np.average(z, weights=w)
""",
        "classify": """\
def classify(psi):
    far = psi(1e3)
    words = ["redescending", "bounded", "unbounded"]
    return words[int(far > 0.1) + int(far > 10)]
""",
    },
}
"""By student and exercise what is written here, for the assignment of ``SHOWN``."""


def write(release: Path, out: Path) -> list[Path]:
    """Release the assignments, write the class's submissions, and return their folders."""
    autograder(answers.SOLUTIONS, "release", *TABLE, "--out", release)
    folders = []
    for assignment in TABLE:
        released = answers.source_notebook(assignment, release)
        for student, sources in _sources(assignment).items():
            text = answers.text(answers.with_answers(released, sources))
            is_broken = TABLE[assignment].get(student) == BROKEN
            text = text[:1000] if is_broken else text
            folders.append(answers.hand_in(out, student, assignment, text))
    return folders


def _sources(assignment: str) -> dict[str, Mapping[str, str]]:
    """By student what stands in the cells of those who hand in."""
    known = {(one.exercise, one.name): one.source for one in answers.answers(assignment)}
    exercises = answers.solutions(assignment)
    found: dict[str, Mapping[str, str]] = {
        student: {
            exercise: known[exercise, name]
            for exercise, name in zip(exercises, names, strict=False)
            if name and names != BROKEN
        }
        for student, names in TABLE[assignment].items()
        if names
    }
    shown = {student: ATTEMPTS[student] for student, name in SHOWN.items() if name == assignment}
    return {**found, **shown}


def pages(graded: Path, out: Path) -> None:
    """Write ``report/`` on all, and ``feedback/`` for ``SHOWN`` alone, as the site shows them."""
    where, feedback = ("--out", graded, "--notice", NOTICE), out / "feedback"
    autograder(answers.SOLUTIONS, "feedback", *SHOWN, *where, "--to", feedback, "--site", SITE)
    # Of their other submissions, which are answers of the tests, there is no page.
    for student, assignment in SHOWN.items():
        for path in (feedback / student).iterdir():
            if path.name != f"{assignment}.html":
                path.unlink()
    autograder(answers.SOLUTIONS, "report", *where, "--to", out / "report", "--feedback", feedback)


def autograder(solutions: Path, *arguments: object) -> None:
    """Run a command of the grader, which says nothing on its way."""
    with contextlib.redirect_stdout(io.StringIO()):
        status = cli.main(["--solutions", *map(str, (solutions, *arguments))])
    if status:
        raise SystemExit(status)


def main(arguments: Sequence[str]) -> None:
    """Run one of the two commands."""
    {"write": write, "pages": pages}[arguments[0]](*map(Path, arguments[1:]))


if __name__ == "__main__":
    main(sys.argv[1:])
