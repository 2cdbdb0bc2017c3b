"""Cases of certificates: headings alone, the staircase on them, and pose graphs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from robust_slam.certificates import sdp
from robust_slam.certificates.chordal import ChordalProblem, chordal_cost, pose_blocks
from robust_slam.certificates.newton import descend
from robust_slam.certificates.optimality import Certificate, certificate, certify, judge
from robust_slam.certificates.staircase import climb, rounded
from robust_slam.descent import gauss_newton, start
from robust_slam.graphs import add_random_closures, circle, manhattan, se2
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.course.parity_cases import Angles, Case
from tests.lib.course.parity_graphs import as_given
from tests.lib.worlds import random_graph, shaken


def heading_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Headings at random and on twisted rings: Q, S, its spectrum, the bound, the verdict."""
    for k in range(60):
        n, edges, turns, kappa = _ring(rng, float(rng.choice([0.0, 0.2, 1.0])))
        angles = _headings(rng, n, k)
        R = np.hstack(list(se2.rotation(np.outer(angles, [0.0, 0.0, 1.0]))))
        Q = sdp.connection_matrix(n, edges, _rotations(turns), kappa)
        graph = rotation_graph(n, edges, turns, kappa)
        S, eigenvalues = sdp.dense_certificate(Q, R)
        proof = certificate(graph, np.outer(angles, [0.0, 0.0, 1.0]))
        given = {"n": n, "edges": edges, "turns": turns, "kappa": kappa}
        yield Case(
            given | {"R": R.ravel(), "rank": 2},
            {"Q": Q, "S": S, "eigenvalues": eigenvalues, **_numbers(proof)},
        )


def climb_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The staircase from twisted rings with noise: cost, λ_min and bound at every rank."""
    for _ in range(30):
        n, edges, turns, kappa = _ring(rng, float(rng.choice([0.05, 0.2])), least=7, chords=1)
        problem = ChordalProblem.of(rotation_graph(n, edges, turns, kappa))
        twisted = 2.0 * np.pi * np.arange(n) / n
        flat = descend(problem, pose_blocks(np.outer(twisted, [0.0, 0.0, 1.0]))).last.blocks
        angles = np.arctan2(flat[:, 1, 0], flat[:, 0, 0])
        graph = rotation_graph(n, edges, turns, kappa)
        yield Case(
            {"n": n, "edges": edges, "turns": turns, "kappa": kappa, "angles": angles},
            _staircase(graph, problem, angles),
        )


def graph_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Pose graphs with weights, polished or as they are, at good maps and at folded ones."""
    for k in range(50):
        graph, poses = _graph(rng, k)
        weights = np.where(graph.is_odometry, 1.0, rng.choice([0.0, 0.5, 1.0], len(graph.edges)))
        if k % 4 == 0:
            at = shaken(se2, poses, 0.1, rng)
            proof = certificate(graph, at, weights)
        else:
            at = start.chordal(graph, weights)
            if k % 4 == 1:
                at = gauss_newton(graph, at, weights)
            at_end, proof = certify(graph, at, weights)
        polished = at if k % 4 == 0 else at_end
        yield Case(
            {
                "graph": as_given(graph), "poses": at.ravel(), "weights": weights,
                "polish": bool(k % 4),
            },
            {"poses": Angles(polished), "chordal": chordal_cost(graph, at, weights),
             **_numbers(proof)},
        )  # fmt: skip


def rotation_graph(n: int, edges: np.ndarray, turns: np.ndarray, kappa: np.ndarray) -> PoseGraph:
    """A pose graph of headings alone: all measured positions are 0, and so are all positions."""
    information = np.zeros((turns.size, 3, 3))
    information[:] = np.eye(3)
    information[:, 2, 2] = kappa
    z = np.outer(turns, [0.0, 0.0, 1.0])
    return PoseGraph(n, edges, z, information, np.zeros(turns.size, bool))


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
) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
    """A ring of headings with chords: the number, the edges, the measured turns, precisions."""
    n = int(rng.integers(least, 13))
    across = [rng.permutation(n)[:2] for _ in range(int(rng.integers(0, chords + 1)))]
    edges = np.array([*([k, (k + 1) % n] for k in range(n)), *across])
    turns = noise * rng.normal(size=len(edges))
    return n, edges, turns, rng.uniform(0.5, 2.0, len(edges))


def _headings(rng: np.random.Generator, n: int, k: int) -> np.ndarray:
    if k % 4 == 0:
        return np.zeros(n)
    if k % 4 == 1:
        return 2.0 * np.pi * np.arange(n) / n
    if k % 4 == 2:
        return np.pi * rng.integers(0, 2, n)  # antipodal
    return rng.uniform(-np.pi, np.pi, n)


def _rotations(turns: np.ndarray) -> np.ndarray:
    return se2.rotation(np.outer(turns, [0.0, 0.0, 1.0]))


def _graph(rng: np.random.Generator, k: int) -> tuple[PoseGraph, np.ndarray]:
    n = int(rng.choice([2, 5, 20, 48, 100], p=[0.15, 0.25, 0.3, 0.2, 0.1]))
    if n < 20:
        poses, graph = random_graph(int(rng.integers(10**6)), n=n, m=2 * n, residual=0.2)
        return graph, poses
    if k % 2:
        graph, poses = manhattan(n, rng, turn=0.3, closures=n // 8)
    else:
        graph, poses = circle(n, rng, laps=2, closures=n // 5)
    return (add_random_closures(graph, 1, rng)[0] if k % 3 == 0 else graph), poses
