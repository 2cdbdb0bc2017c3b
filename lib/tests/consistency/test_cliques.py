"""Maximum clique: right where all can be enumerated, with a bound that holds elsewhere."""

import numpy as np
import pytest
from robust_slam.consistency.cliques import max_clique

DENSITIES = (0.1, 0.3, 0.5, 0.7, 0.85, 0.95)


def random_adjacency(m, density, seed):
    upper = np.triu(np.random.default_rng(seed).random((m, m)) < density, 1)
    return upper | upper.T


def largest_by_growth(adjacency):
    """The size of a largest clique: with the first vertex or without."""
    near = [set(np.flatnonzero(row)) for row in adjacency]
    best = 0
    stack = [(0, set(range(len(near))))]
    while stack:
        size, left = stack.pop()
        best = max(best, size)
        if size + len(left) > best and left:
            v = min(left)
            stack += [(size, left - {v}), (size + 1, left & near[v])]
    return best


@pytest.mark.parametrize("budget", [1, 20, 60, 200, 1000, None])
@pytest.mark.parametrize("density", DENSITIES)
def test_at_every_budget_the_clique_is_one_and_the_bound_holds(density, budget):
    limit = {} if budget is None else {"budget": budget}
    for seed in range(4):
        adjacency = random_adjacency(28, density, 200 + seed)
        largest = largest_by_growth(adjacency)
        clique = max_clique(adjacency, **limit)
        inside = adjacency[np.ix_(clique.members, clique.members)]
        assert np.all(inside | np.eye(len(inside), dtype=bool))
        assert len(clique.members) <= largest <= clique.bound
        assert clique.proven == (len(clique.members) == clique.bound)
        assert clique.proven or budget is not None


def test_a_small_budget_ends_unproven_and_more_of_it_never_harms():
    adjacency = random_adjacency(120, 0.75, 0)
    answers = [max_clique(adjacency, budget=b) for b in (1, 3_000, 30_000, 3_000_000)]
    sizes = [len(a.members) for a in answers]
    bounds = [a.bound for a in answers]
    assert not answers[0].proven and answers[-1].proven
    assert sizes == sorted(sizes) and bounds == sorted(bounds, reverse=True)
    assert bounds[0] > bounds[-1]


def test_few_outliers_in_a_dense_graph_are_proven_without_a_search(seed):
    # Each of 10 outliers contradicts 40 of 600 closures that all agree: no clique holds more
    # than these 600 and a largest clique of outliers among themselves, and none swaps.
    rng = np.random.default_rng(seed)
    adjacency = np.ones((610, 610), dtype=bool)
    adjacency[600:, 600:] = np.eye(10, dtype=bool)
    for outlier in range(600, 610):
        against = rng.choice(600, 40, replace=False)
        adjacency[outlier, against] = adjacency[against, outlier] = False
    clique = max_clique(adjacency, budget=1)
    np.testing.assert_array_equal(clique.members, np.arange(600))
    assert clique.proven


@pytest.mark.long
def test_more_vertices_than_python_may_recurse_are_no_obstacle():
    # A path of 1100 vertices in the complement: a largest independent set there is every
    # other vertex, the ends included.
    m = 1100
    adjacency = ~np.eye(m, dtype=bool)
    step = np.arange(m - 1)
    adjacency[step, step + 1] = adjacency[step + 1, step] = False
    order = np.random.default_rng(0).permutation(m)
    clique = max_clique(adjacency[np.ix_(order, order)])
    assert len(clique.members) == clique.bound == 550


def test_the_diagonal_does_not_matter_and_the_input_stays_as_it_is(seed):
    adjacency = random_adjacency(40, 0.6, seed)
    full = adjacency | np.eye(40, dtype=bool)
    before = full.copy()
    np.testing.assert_array_equal(max_clique(full).members, max_clique(adjacency).members)
    np.testing.assert_array_equal(full, before)


@pytest.mark.parametrize(
    ("adjacency", "options", "told"),
    [
        (np.ones((2, 3), bool), {}, r"adjacency: the shape is \(2, 3\)"),
        (np.ones(4, bool), {}, r"adjacency: the shape is \(4,\)"),
        (np.ones((2, 2)), {}, "adjacency: the entries are float64"),
        (np.array([[1, 1], [0, 1]], bool), {}, r"entries \(0, 1\) and \(1, 0\) differ"),
        (np.eye(3, dtype=bool), {"budget": 0}, "budget is 0"),
    ],
)
def test_what_is_no_graph_is_refused(adjacency, options, told):
    with pytest.raises(ValueError, match=told):
        max_clique(adjacency, **options)
