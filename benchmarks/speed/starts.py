"""The chordal start of spatial graphs, against GTSAM's ``InitializePose3``.

Both relax the rotations to matrices, solve one linear problem, and take the nearest rotations.
Positions are a second linear problem here; there they come from one Gauss–Newton step on whole
poses, which moves the rotations too. The remark gives the cost where each ends.
"""

from __future__ import annotations

import gtsam
from robust_slam.descent import start
from robust_slam.graphs import gtsam_graph, pose_graph
from robust_slam.graphs.datasets import load

from benchmarks.speed.clock import Side, in_turns
from benchmarks.speed.figure import Figure, named, shown, told
from benchmarks.speed.ways import our_sides


def measure(name: str) -> Figure:
    """Return the figure of one graph."""
    graph = load(name)
    factors, _ = gtsam_graph.to_gtsam(graph)
    sides = our_sides(lambda: start.chordal(graph), lambda poses: pose_graph.cost(graph, poses))
    gtsams = Side("GTSAM", lambda: gtsam.InitializePose3.initialize(factors), factors.error)
    *own, other = in_turns([*sides, gtsams])
    ours = named(sides, own)
    remark = (
        f"GTSAM {shown(other)} to a cost of {other.answer:.4g}, "
        f"ours {told(ours)} to {own[0].answer:.4g}"
    )
    return Figure(other, ours, remark)
