"""Cliques of dense graphs: what joins all others needs no search, and a budget always ends it."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.consistency import cliques
from robust_slam.consistency.cliques import max_clique


def dense(m, few, share, seed):
    """All joined, but for ``few`` vertices that are joined with probability ``share``."""
    rng = np.random.default_rng(seed)
    joined = np.ones((m, m), dtype=bool)
    chosen = rng.choice(m, few, replace=False)
    joined[chosen] = rng.random((few, m)) < share
    joined &= joined.T
    np.fill_diagonal(joined, True)
    return joined


@pytest.mark.parametrize("seed", range(3))
def test_vertices_that_join_all_others_are_taken_at_once(seed, monkeypatch):
    joined = dense(300, 20, 0.7, seed)
    everyone = np.flatnonzero(joined.all(axis=0))
    searched = []
    solve = cliques._solve
    monkeypatch.setattr(
        cliques, "_solve", lambda inner, *rest: searched.append(len(inner)) or solve(inner, *rest)
    )
    clique = max_clique(joined)
    assert searched == [300 - everyone.size]
    assert np.all(np.isin(everyone, clique.members))
    assert clique.proven
    assert np.all(joined[np.ix_(clique.members, clique.members)])


def test_a_complete_graph_is_its_own_clique():
    clique = max_clique(np.ones((500, 500), dtype=bool))
    assert clique.members.size == clique.bound == 500


def test_a_small_budget_ends_a_hard_search_with_a_valid_clique_and_bound():
    rng = np.random.default_rng(0)
    joined = np.triu(rng.random((300, 300)) < 0.9, 1)
    joined |= joined.T
    clique = max_clique(joined, budget=1000)
    assert not clique.proven and clique.bound > clique.members.size
    inside = joined[np.ix_(clique.members, clique.members)] | np.eye(
        clique.members.size, dtype=bool
    )
    assert np.all(inside)
