"""Cases of certificates: headings alone, the staircase on them, and pose graphs."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam.certificates import sdp
from robust_slam.certificates.chordal import ChordalProblem, pose_blocks
from robust_slam.certificates.newton import descend
from robust_slam.certificates.optimality import Certificate, certificate, judge
from robust_slam.certificates.staircase import climb, rounded
from robust_slam.graphs import se2
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.course.parity_cases import Angles, Case


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


def climb_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The staircase from twisted rings with noise: cost, λ_min and bound at every rank."""
    for _ in range(30):
        n, edges, turns = _ring(rng, float(rng.choice([0.05, 0.2])), least=7, chords=1)
        problem = ChordalProblem.of(rotation_graph(n, edges, turns))
        twisted = 2.0 * np.pi * np.arange(n) / n
        flat = descend(problem, pose_blocks(np.outer(twisted, [0.0, 0.0, 1.0]))).last.blocks
        angles = np.arctan2(flat[:, 1, 0], flat[:, 0, 0])
        graph = rotation_graph(n, edges, turns)
        yield Case(
            {"n": n, "edges": edges, "turns": turns, "angles": angles},
            _staircase(graph, problem, angles),
        )


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


def _staircase(graph: PoseGraph, problem: ChordalProblem, angles: np.ndarray) -> dict[str, Any]:
    blocks, levels = pose_blocks(np.outer(angles, [0.0, 0.0, 1.0])), []
    for rank in range(2, 8):
        proof = judge(problem, blocks)
        numbers = _numbers(proof)
        if rank > 2 and proof.direction is not None:
            # A saddle: rounding pushes the last step off it, by about the stationarity asked for.
            del numbers["verdict"], numbers["stationarity"]
        levels.append({"r": rank, "proof": numbers})
        if proof.direction is None or rank == 7:
            break
        blocks = descend(problem, climb(problem, blocks, proof.direction)).last.blocks
    headings = rounded(graph, blocks, np.zeros((graph.n, 3)))
    return {"levels": levels, "headings": Angles(headings)}


def _ring(
    rng: np.random.Generator, noise: float, least: int = 3, chords: int = 2
) -> tuple[int, np.ndarray, np.ndarray]:
    """A ring of headings with chords: the number, the edges, the measured turns."""
    n = int(rng.integers(least, 13))
    across = [rng.permutation(n)[:2] for _ in range(int(rng.integers(0, chords + 1)))]
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
