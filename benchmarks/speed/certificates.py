"""Certificates of the public graphs: the cost, and where the time goes.

The chordal start, brought to rest by Gauss–Newton, is polished on the chordal cost and then
certified.

The line compares the cost with the optimal value that SE-Sync reports. A certified cost is
the least there is, up to the bound of the certificate.

Source: SE-Sync (Rosen et al. 2019), run on the same files, for the optimal values.
"""

from __future__ import annotations

from robust_slam.certificates import Certificate, Verdict, certificate
from robust_slam.certificates.newton import polish
from robust_slam.descent import gauss_newton, start
from robust_slam.graphs.datasets import load

from benchmarks.speed.clock import Side, spend
from benchmarks.speed.figure import shown

OPTIMAL = {
    "CSAIL": 31.7037,
    "intel": 52.3482,
    "M3500": 6431.39,
    "city10000": 638.625,
    "sphere2500": 1687.01,
    "torus3D": 24227.0,
    "parking-garage": 1.26249,
}
AGREE = 1e-5
"""A relative difference that counts as none."""


def measure(name: str) -> str:
    """Return cost and seconds of one graph.

    Raises:
        RuntimeError: the map is not certified.
    """
    graph = load(name)
    first = spend(Side("start", lambda: gauss_newton(graph, start.chordal(graph))))
    polished = spend(Side("polish", lambda: polish(graph, first.answer)))
    judged = spend(Side("certificate", lambda: certificate(graph, polished.answer)))
    found: Certificate = judged.answer
    if found.verdict is not Verdict.CERTIFIED:
        raise RuntimeError(f"{found.verdict.value} at a cost of {found.cost:.6g}")
    return (
        f"certified, cost {found.cost:.8g}, none below {found.lower_bound:.8g}, "
        f"SE-Sync's {OPTIMAL[name]:.6g}{_difference(found.cost, OPTIMAL[name])}; "
        f"start {shown(first)}, polish {shown(polished)}, certificate {shown(judged)}"
    )


def _difference(cost: float, optimal: float) -> str:
    share = cost / optimal - 1.0
    return "" if abs(share) <= AGREE else f" (they differ by {share:.1e})"
