"""The numbers of GTSAM's iSAM2 on the page *Filter or smoother* are those of GTSAM."""

import importlib.util
from typing import Any

import numpy as np
import pytest
from robust_slam.graphs import gtsam_graph

from autograder.tests.kernel import leave_out
from tests.book.prose import Chapter

PAGE = Chapter("filter-or-smoother")
SHOWN = ("imports", "filter", "drive")


@pytest.fixture(name="run", scope="module")
def fixture_run():
    """What the page defines, and iSAM2 after all edges, wrong closure included."""
    if importlib.util.find_spec("gtsam") is None:
        leave_out("gtsam is not installed; iSAM2 is not run")
    import gtsam

    names = PAGE.run(*SHOWN)
    graph = names["spoiled"]
    factors, values = gtsam_graph.to_gtsam(graph, np.zeros((graph.n, 3)))
    settings = gtsam.ISAM2Params()
    settings.setFactorization("QR")
    settings.relinearizeSkip = 1
    solver, anew, number = gtsam.ISAM2(settings), {}, {}

    def update(factor: Any, new: Any) -> Any:
        added = gtsam.NonlinearFactorGraph()
        added.push_back(factor)
        return solver.update(added, new)

    first = gtsam.Values()
    first.insert(0, values.atPose2(0))
    update(factors.at(len(graph.edges)), first)
    for k in names["arrivals"](graph).tolist():
        i, j = graph.edges[k].tolist()
        new = gtsam.Values()
        if graph.is_odometry[k]:
            step = gtsam.Pose2(*graph.measurement[k].tolist())
            new.insert(j, solver.calculateEstimatePose2(i).compose(step))
        told = update(factors.at(k), new)
        anew[k], number[k] = told.getVariablesReeliminated(), told.getNewFactorsIndices()[0]
    removed = number[names["wrong"]]
    return names | {"solver": solver, "anew": anew, "removed": removed, "gtsam": gtsam}


def error(run: dict[str, Any]) -> float:
    solver, truth = run["solver"], run["truth"]
    seen = (solver.calculateEstimatePose2(k) for k in range(len(truth)))
    poses = np.array([[pose.x(), pose.y(), pose.theta()] for pose in seen])
    return float(run["ate"](poses, truth))


def test_isam2_withdraws_a_closure_when_it_has_linearised_again(run):
    odometry = run["spoiled"].is_odometry
    steps = [count for k, count in run["anew"].items() if odometry[k]]
    closures = [count for k, count in run["anew"].items() if not odometry[k]]
    said = [
        f"eliminates {np.median(steps):.0f} of the poses again",
        f"and after a closure between {min(closures)} and {max(closures)} of the 100",
        f"the last of which has an error of {error(run):.2f} m",
    ]
    solver, gtsam = run["solver"], run["gtsam"]
    solver.update(gtsam.NonlinearFactorGraph(), gtsam.Values(), [run["removed"]])
    said.append(f"At this update, the error falls to {error(run):.2f} m")
    solver.update()
    solver.update()
    said.append(f"two updates later its error is {error(run):.2f} m")
    assert [phrase for phrase in said if phrase not in PAGE.text] == []
