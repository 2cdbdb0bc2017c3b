"""The instructor's manual: every variant of every exam question, solved with the library."""

import re
from typing import Any

import numpy as np
import pytest
from robust_slam import estimators, graphs
from robust_slam.certificates import sdp
from robust_slam.consistency.pairwise import pairwise_distances
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import start_mu, tls_weight
from robust_slam.graphs import PoseGraph, pose_graph
from robust_slam.groups import se2
from robust_slam.problems import LocationProblem, chain

from solutions.manual.__main__ import HERE, exam, misconceptions, page, printed, sheet

CHAPTERS = sorted(path.stem for path in HERE.glob("0*.md"))


def line_graph(n: int, closures: list[list[int]], measured: list[float], turn: float = 0.0) -> Any:
    """Return poses 1 m apart on a line, or on a curve, with closures along x; σ = 0.1."""
    edges = np.array([[k, k + 1] for k in range(n - 1)] + closures)
    z = np.zeros((len(edges), 3))
    z[:, 0], z[: n - 1, 2] = [1.0] * (n - 1) + measured, turn
    information = np.tile(np.diag([100.0, 1e6, 1e6]), (len(edges), 1, 1))
    return PoseGraph(n, edges, z, information, np.arange(len(edges)) < n - 1)


def heading_ring(n: int, turn: float, sigma: float) -> Any:
    """Return a ring of poses in one place, each measured to be turned against the one before."""
    edges = np.array([[k, (k + 1) % n] for k in range(n)])
    information = np.tile(np.diag([1.0, 1.0, sigma**-2]), (n, 1, 1))
    z = np.outer(np.full(n, turn), [0.0, 0.0, 1.0])
    return PoseGraph(n, edges, z, information, np.arange(n) < n - 1)


def ring_matrix(n: int, turn: float) -> np.ndarray:
    """Return the matrix Q of such a ring with κ = 1."""
    graph = heading_ring(n, turn, 1.0)
    return sdp.connection_matrix(n, graph.edges, se2.rotation(graph.measurement))


FUNCTIONS = (pairwise_distances, start_mu, tls_weight, LocationProblem, chain)
HELPERS = (line_graph, heading_ring, ring_matrix)
LIBRARY = (
    {name: getattr(part, name) for part in (estimators, graphs) for name in part.__all__}
    | {each.__name__: each for each in (*FUNCTIONS, *HELPERS)}
    | {"np": np, "kernels": kernels, "pose_graph": pose_graph, "se2": se2, "sdp": sdp}
)
"""What the expressions of the pages may use."""


def test_there_is_a_page_for_each_chapter():
    assert [f"{k:02}" for k in range(10)] == CHAPTERS


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_the_library_solves_every_variant(chapter):
    for seed in range(12):
        questions = exam(chapter, seed)
        assert len(questions) == 3
        for question in questions:
            names, compared = LIBRARY | dict(question.values), 0
            for name, expression in question.library.items():
                names[name] = found = eval(expression, names)
                if name in question.values:
                    compared += 1
                    known = question.values[name]
                    if not isinstance(found, str):
                        known = pytest.approx(known, rel=1e-4, abs=1e-9)
                    assert found == known, f"{question.title}, seed {seed}: {name}"
            assert compared, question.title


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_a_page_has_marks_that_add_up_and_a_sheet_has_no_answers(chapter):
    for question in exam(chapter, 3):
        (total,) = re.findall(r"\((\d) points\)", question.title)
        marks = re.findall(r"^- (\d) points?:", question.text, re.MULTILINE)
        assert sum(map(int, marks)) == int(total), question.title
    whole, students = page(chapter, 3), sheet([chapter], 3)
    assert "<<" not in whole + students and "```toml" not in whole
    assert "Answer" not in students and "point:" not in students
    assert students.count("## ") == 3 and sheet([chapter], 4) != students
    assert "variant 3" in students, "else nobody knows which answers belong to a sheet"
    assert misconceptions(chapter) in whole


def test_an_exam_takes_some_questions_of_several_chapters_and_numbers_them_anew():
    (one,), two = exam("05", 7)[1:2], exam("08", 7)
    students = sheet(["05.2", "08"], 7)
    assert re.findall(r"^## (\d)\. (.+)$", students, re.MULTILINE) == [
        (str(number), question.title.partition(". ")[2])
        for number, question in enumerate((one, *two), 1)
    ]
    points = [int(p) for each in (one, *two) for p in re.findall(r"\((\d) p", each.title)]
    assert f"of {sum(points)}\n" in students
    assert printed(students).count("<section>") == len(points)
    for unknown in ("10", "05.4", "5"):
        with pytest.raises(ValueError, match=f"no {unknown}"):
            sheet([unknown], 7)
