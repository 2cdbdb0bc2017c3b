"""Each bad input gets an answer, or a message that names the edge and the remedy; none is silent.

The same table goes through the three doors: ``rs.load``, ``rs.solve`` and the command.
"""

import logging
import re
import warnings

import numpy as np
import pytest
import robust_slam as rs
from robust_slam import cli
from robust_slam.graphs import add_local_closures, add_random_closures, spoil_closures
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.odometry import sessions, spanning_tree
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.graphs.pose_graph import select


def edge(i, j, x=1, angle=0, half="100 0 0 100 0 400"):
    return f"EDGE_SE2 {i} {j} {x} 0 {angle} {half}\n"


WALK = "".join(edge(k, k + 1) for k in range(6))
BACK = edge(0, 6, 6)
AROUND = edge(0, 3, 3) + edge(1, 5, 4) + BACK


def instead(half):
    """The walk, whose edge 3-4, in line 4, has other information."""
    return "".join(edge(k, k + 1, half=half if k == 3 else "100 0 0 100 0 400") for k in range(6))


REFUSED = {
    "disconnected": (WALK + edge(10, 11), r": no path of edges joins vertex 0 to 10, 11; add an"),
    "zero information": (instead("0 0 0 0 0 0"), r":4: .* not positive .*nearest"),
    "information of 1e300": (instead("1e300 0 0 1e300 0 9"), ":4: .*outside 1e-30 to 1e30; give"),
    "information of 1e-300": (instead("9 0 0 9 0 1e-300"), ":4: .*outside 1e-30 to 1e30; give m"),
    "NaN": (WALK + edge(0, 6, "nan"), ":7: a number is not finite; remove NaN and infinity"),
    "a position of 1e200": (WALK + edge(0, 6, 1e200), r":7: a number is beyond 1e\+30; give met"),
    "an angle of 1e200": (WALK + edge(0, 6, 1, 1e200), r":7: a number is beyond 1e\+30; give m"),
    "an empty file": ("", ": no edge is there; add lines EDGE_SE2"),
    "one decimal comma": (
        WALK + edge(0, 6, "6,5") + edge(0, 5, 5.5),
        ":7: .*'6,5'; .* a point in",
    ),
    "decimal commas between commas": (
        8 * "0,5," + "\n",
        ":1: 16 numbers .*; decimal commas need s",
    ),
    "commas in place of spaces": (WALK + "EDGE_SE2,0,6,6,0,0\n", ":7: .* in place of the commas"),
    "no information": (WALK + "EDGE_SE2 0 6 6 0 0\n", ":7: .*give 11.* append 100 0 0 100 0 400"),
    "no covariance": ("EDGE_SE2 0 A0 A1 1 0 0\n", ":1: .*give 12.*append 0.01 0 0 0.01 0 0.0025"),
    "a diagonal": (
        WALK + edge(0, 6, half="9 9 9"),
        ":7: .*the last 6 are half of a matrix, row by",
    ),
    "similarities": ("EDGE_SIM3:QUAT 0 1 1 0 0\n", ":1: .*a similarity, .*export EDGE_SE3:QUAT$"),
    "the tutorial of g2o": ("TUTORIAL_EDGE_SE2 0 1 1\n", ":1: .*; take TUTORIAL_ out of them$"),
    "a tag with spaces": ("EDGE_SE3 : QUAT 0 1\n", ":1: .*; write VERTEX_SE3:QUAT and EDGE_SE3:Q"),
    "a prior of another name": (
        WALK + "EDGE_SE3_PRIOR:QUAT 1\n",
        ":7: .*; g2o writes EDGE_SE3_PR",
    ),
    "YAML": (
        "nodes:\n- id: 0\n",
        ":1: the tag 'nodes:' is unknown; this may be YAML, and a graph",
    ),
    "a date": (
        "2021-10-26 1 2 3\n",
        ":1: the tag '2021-10-26' is unknown; if it is a time, write",
    ),
    "no line that is known": (
        "HELLO\n",
        ":1: the tag 'HELLO' is unknown; use [^;]*, FIX; the command",
    ),
    "ranges": (
        WALK + "EDGE_RANGE 0 9 1 1\n",
        ":7: the tag 'EDGE_RANGE' is unknown; .*; the command and rs.factors.read_factors use",
    ),
}
"""What is refused: the text of a file, and what stands behind the file's name.

Of each check one, to see that all doors let its words through; ``test_g2o`` has the rest.
"""


def file_of(folder, text):
    path = folder / "bad.g2o"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_solved_is_refused_with_the_line_and_a_remedy(tmp_path, capsys, name):
    text, message = REFUSED[name]
    path = file_of(tmp_path, text)
    with pytest.raises(ValueError, match=re.escape(str(path)) + message):
        rs.load(path)
    assert cli.main(["solve", str(path), "--quiet"]) == 2
    (said,) = capsys.readouterr().err.splitlines()
    remedies = message.replace("nearest", "--indefinite nearest")
    assert re.match(f"robust-slam: {re.escape(str(path))}{remedies}", said)


ANSWERED = {
    "no closure": (WALK, "no edge is a loop closure, so the map is the odometry alone"),
    "two poses": (edge(0, 1), "no edge is a loop closure"),
    "two poses and a second edge": (edge(0, 1) + edge(0, 1, 1.1), "kept +1 of 1 closure"),
    "a copied closure": (WALK + AROUND + BACK, "line 10 gives edge 0-6 once more with the same n"),
    "a rounded copy from the other end": (
        WALK
        + AROUND
        + edge(0, 6, 6.1234567, 0.1)
        + "EDGE_SE2 6 0 -6.0929 0.6113 -0.1 9 0 0 9 0 9",
        "line 11 gives edge 6-0 once more with the same numbers, or those of its inverse; drop",
    ),
    "a switchable edge": (
        WALK + AROUND + "VERTEX_SWITCH 9 1\nEDGE_SWITCH_PRIOR 9 1 1\n"
        "EDGE_SE2_SWITCHABLE 1 6 9 5 0 0 100 0 0 100 0 400\n",
        "kept +4 of 4 closures",
    ),
    "decimal commas": ((WALK + AROUND + edge(0, 5, 5.25)).replace(".", ","), "read as decimal po"),
    "a copied file": (2 * WALK + AROUND, r"line 7 gives edge 0-1 once .* \(so do 5 more\)"),
    "both directions": (WALK + AROUND + edge(1, 0, -1), "kept +4 of 4 closures"),
    "a gap in the ids": (
        WALK + edge(6, 600) + edge(600, 601) + edge(0, 601, 8) + AROUND,
        "edge 6-600 crosses a gap in the ids",
    ),
    "a gap in the odometry": (
        WALK + edge(0, 600, 0.5) + edge(600, 601) + edge(2, 601, -0.5) + AROUND,
        "odometry leaves 2 sessions",
    ),
    "closures alone": (
        edge(0, 2, 2) + edge(2, 4, 2) + edge(0, 4, 4) + edge(1, 3) + edge(0, 3, 3),
        "sessions +5",
    ),
    "information of 1e20": (
        instead("1e20 0 0 1e20 0 1e20") + AROUND,
        r"line 4: the deviations of edge 3-4 are a factor of 1e\+09 from those of other edges",
    ),
    "information of 1e-20": (
        WALK + AROUND + edge(0, 5, 5, half="1e-20 0 0 1e-20 0 1e-20"),
        r"line 10: the deviations of edge 0-5 are a factor of \de\+1\d from those of other edges",
    ),
    "an information of 0, replaced": (
        instead("9 0 0 9 0 0").replace("9 0 0 9 0 0", "9 0 0 0 0 4") + AROUND,
        "1 of 9 information matrices not positive def",
    ),
}
"""What has an answer: the text of a file, and what is said about it."""


@pytest.mark.parametrize("name", ANSWERED)
def test_what_can_be_solved_has_a_map_and_what_is_odd_is_said(tmp_path, capsys, caplog, name):
    text, words = ANSWERED[name]
    path = file_of(tmp_path, text)
    with warnings.catch_warnings(), caplog.at_level(logging.WARNING):
        warnings.simplefilter("error")
        answer = rs.solve(rs.load(path, indefinite="nearest"))
        code = cli.main(["solve", str(path), "--quiet", "--indefinite", "nearest"])
    assert np.all(np.isfinite(answer.poses)) and code in (0, 1)
    assert re.search(words, capsys.readouterr().out + caplog.text)
    told = [*caplog.messages, answer.graph.summary(), answer.summary()]
    assert re.search(words, "\n".join(told))


def cut_in_two(seed=0):
    """A town whose odometry has a gap in the middle that closures bridge, and its true poses."""
    graph, truth = manhattan(60, seed, closures=30)
    gone = np.all(graph.edges == [29, 30], axis=1) & graph.is_odometry
    return select(graph, ~gone), truth


@pytest.mark.parametrize(
    "add",
    [
        lambda graph, rng: add_random_closures(graph, 100, rng),
        lambda graph, rng: add_local_closures(graph, 20, rng),
        lambda graph, rng: add_aliased_closures(graph, 2, rng, size=4),
        lambda graph, rng: spoil_closures(graph, 0.2, rng),
    ],
    ids=["random", "local", "aliased", "spoiled"],
)
def test_outliers_can_be_added_where_the_odometry_has_gaps(add, seed):
    graph, _ = cut_in_two(seed)
    assert sessions(graph).max() == 1
    spoiled, is_outlier = add(graph, np.random.default_rng(seed))
    known = spanning_tree(graph)
    i, j = spoiled.edges[is_outlier].T
    z = spoiled.measurement[is_outlier]
    moved = spoiled.group.compose(known[i], z)[:, :2] - known[j][:, :2]
    assert is_outlier.any() and np.linalg.norm(moved, axis=1).min() > 0.5


def test_a_hundred_random_closures_are_rejected_across_a_gap():
    graph, _ = cut_in_two()
    spoiled, is_outlier = add_random_closures(graph, 100, 0)
    answer = rs.solve(spoiled)
    assert not np.any(answer.kept & is_outlier)
