"""Cases of certificates of headings, and of rings of headings at rest."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam.certificates import sdp
from robust_slam.certificates.chordal import ChordalProblem, pose_blocks
from robust_slam.certificates.newton import descend
from robust_slam.certificates.optimality import Certificate, certificate
from robust_slam.graphs import se2
from robust_slam.graphs.pose_graph import PoseGraph

from tests.course.parity_cases import Angles, Case


def heading_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Headings at random and on twisted rings: Q, S, its spectrum, the bound, the verdict."""
    for k in range(60):
        n, edges, turns = _ring(rng, float(rng.choice([0.0, 0.2, 1.0])))
        angles = _headings(rng, n, k)
        R, measured = (se2.rotation(np.outer(one, [0.0, 0.0, 1.0])) for one in (angles, turns))
        R, Q = np.hstack(list(R)), sdp.connection_matrix(n, edges, measured)
        graph = rotation_graph(n, edges, turns)
        S, eigenvalues = sdp.dense_certificate(Q, R)
        proof = certificate(graph, np.outer(angles, [0.0, 0.0, 1.0]))
        yield Case(
            {"n": n, "edges": edges, "turns": turns, "R": R.ravel()},
            {"Q": Q, "S": S, "eigenvalues": eigenvalues, **_numbers(proof)},
        )


def ring_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Rings beside a twisted one that the page lets go: where their headings rest."""
    for _ in range(30):
        n, alpha = int(rng.integers(5, 13)), float(rng.choice([0.0, 0.1, 0.3]))
        edges = np.array([[k, (k + 1) % n] for k in range(n)])
        angles = 2.0 * np.pi * np.arange(n) / n + 0.1 * rng.normal(size=n)
        angles[0] = 0.0
        problem = ChordalProblem.of(rotation_graph(n, edges, np.full(n, alpha)))
        blocks = descend(problem, pose_blocks(np.outer(angles, [0.0, 0.0, 1.0]))).last.blocks
        headings = np.arctan2(blocks[:, 1, 0], blocks[:, 0, 0])
        turned = np.outer(headings - headings[0], [0.0, 0.0, 1.0])
        yield Case({"angles": angles, "alpha": alpha}, {"headings": Angles(turned)})


def rotation_graph(n: int, edges: np.ndarray, turns: np.ndarray) -> PoseGraph:
    """A pose graph of headings alone: all measured positions are 0, and so are all positions."""
    z = np.outer(turns, [0.0, 0.0, 1.0])
    return PoseGraph(n, edges, z, [np.eye(3)] * turns.size, np.zeros(turns.size, bool))


def _numbers(proof: Certificate) -> dict[str, Any]:
    return {
        "verdict": proof.verdict.value,
        "stationarity": proof.stationarity if proof.stationarity > 1e-8 else 0.0,
        "lambdaMin": proof.lambda_min,
        "cost": proof.cost,
        "lowerBound": proof.lower_bound,
        "bound": proof.bound,
    }


def _ring(rng: np.random.Generator, noise: float) -> tuple[int, np.ndarray, np.ndarray]:
    """A ring of headings with chords: the number, the edges, the measured turns."""
    n = int(rng.integers(3, 13))
    across = [rng.permutation(n)[:2] for _ in range(int(rng.integers(0, 3)))]
    edges = np.array([*([k, (k + 1) % n] for k in range(n)), *across])
    return n, edges, noise * rng.normal(size=len(edges))


def _headings(rng: np.random.Generator, n: int, k: int) -> np.ndarray:
    if k % 4 == 0:
        return np.zeros(n)
    if k % 4 == 1:
        return 2.0 * np.pi * np.arange(n) / n
    if k % 4 == 2:
        return np.pi * rng.integers(0, 2, n)  # antipodal
    return rng.uniform(-np.pi, np.pi, n)
