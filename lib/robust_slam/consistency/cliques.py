"""Maximum clique: a largest set of vertices that are all joined to each other.

The problem is NP-hard and hard to approximate. The search is exact and anytime: it counts
the candidates it examines and, when its budget is used up, returns the best clique so far
and an upper bound on the size of all cliques. Sets of vertices are the bits of an integer.

The graph is reduced first. A vertex is removed if it cannot be in a clique as large as the
best one known, or if it is dominated: all its neighbours are neighbours of another vertex
that it is not joined to. The rest is split into the components of the *complement*: the
union of largest cliques of the components is a largest clique. This alone nearly solves
dense graphs, such as those of few outliers.

Source: Tomita and Seki 2003, branch and bound with a greedy colouring; San Segundo et al.
2011, the same on sets of bits; Fomin, Grandoni and Kratsch 2009, domination and components
for independent sets, which are the cliques of the complement.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from math import inf

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from robust_slam._arrays import Indices, Mask
from robust_slam._deadline import Deadline

BUDGET = 20_000_000
"""The default number of candidates that a search examines: about ten seconds."""
_FEW = 20
"""Neighbours to check before a full test of domination."""


@dataclass(frozen=True, eq=False)
class Clique:
    """A clique with an upper bound on the largest one.

    ``members`` ``(k,)`` are vertices, ascending. No clique is larger than ``bound``, and
    ``proven`` is True if k equals it.
    """

    members: Indices
    proven: bool
    bound: int


@dataclass
class _Node:
    """An open node of the search: ``size`` vertices ``chosen``, and candidates to add.

    ``order`` are the ``candidates`` to branch on, the last one first, each with its colour:
    no clique among the remaining candidates is larger than ``colours[-1]``.
    """

    chosen: int
    size: int
    candidates: int
    order: list[int]
    colours: list[int]

    @property
    def bound(self) -> int:
        """An upper bound on the cliques below this node, 0 if no branch is left."""
        return self.size + self.colours[-1] if self.order else 0

    def take(self, near: Sequence[int]) -> tuple[int, int]:
        """Add the next candidate; return the chosen vertices and their common candidates."""
        v = self.order.pop()
        self.colours.pop()
        self.candidates ^= 1 << v
        return self.chosen | 1 << v, self.candidates & near[v]


def max_clique(adjacency: ArrayLike, *, budget: int = BUDGET, max_seconds: float = inf) -> Clique:
    """Return a largest clique of ``adjacency`` ``(m, m)``, or the best within ``budget``.

    ``adjacency`` is boolean and symmetric; its diagonal does not matter. ``budget`` counts the
    candidates at each branch node, which measures the work without a clock: the same input
    always gives the same result, unless ``max_seconds`` of CPU time end the search first. Of
    several largest cliques any one may be returned.

    Raises:
        ValueError: ``adjacency`` is not square, boolean and symmetric, ``budget`` is below 1,
            or ``max_seconds`` is negative.

    Source: Tomita and Seki 2003; San Segundo et al. 2011; see the module.

    >>> adjacency = np.zeros((5, 5), dtype=bool)
    >>> for i, j in [(0, 1), (0, 2), (1, 2), (2, 3), (3, 4)]:
    ...     adjacency[i, j] = adjacency[j, i] = True
    >>> clique = max_clique(adjacency)
    >>> clique.members.tolist(), clique.proven
    ([0, 1, 2], True)
    """
    deadline = Deadline.after(max_seconds)
    joined = _checked(adjacency)
    if budget < 1:
        raise ValueError(f"budget is {budget}; give at least 1")
    # In dense graphs most vertices are joined to all others: they belong to every largest
    # clique and need no search.
    joins_all = joined.sum(axis=1) == len(joined) - 1
    inner = joined[np.ix_(~joins_all, ~joins_all)]
    found, bound = _solve(inner, _greedy(inner), budget, deadline)
    held, free = np.flatnonzero(joins_all), np.flatnonzero(~joins_all)
    members = np.sort(np.concatenate([held, free[found]]))
    bound += held.size
    return Clique(members, members.size == bound, bound)


def _checked(adjacency: ArrayLike) -> Mask:
    joined = np.array(adjacency)
    if joined.ndim != 2 or joined.shape[0] != joined.shape[1]:
        raise ValueError(f"adjacency: the shape is {joined.shape}; give (m, m)")
    if joined.size and joined.dtype != np.bool_:
        raise ValueError(f"adjacency: the entries are {joined.dtype}; give booleans")
    joined = joined.astype(np.bool_)
    if np.any(joined != joined.T):
        i, j = (int(k) for k in np.argwhere(joined != joined.T)[0])
        raise ValueError(f"adjacency: entries ({i}, {j}) and ({j}, {i}) differ; make it symmetric")
    np.fill_diagonal(joined, False)
    return joined


def _solve(joined: Mask, best: Indices, budget: int, deadline: Deadline) -> tuple[Indices, int]:
    """Return a clique, at least as large as the clique ``best``, and a bound on the largest.

    Components are split and reduced until they are connected; their cliques are united.
    """
    todo = _split(joined, np.arange(len(joined)), best)
    members, bound = [np.empty(0, dtype=np.intp)], 0
    while todo:
        part, best = todo.pop()
        if part.size == 1:
            members.append(part)
            bound += 1
            continue
        if deadline.passed:
            members.append(best)
            bound += part.size
            continue
        kept, best = _reduced(joined, part, best)
        inner = joined[np.ix_(kept, kept)]
        smaller = _split(joined, kept, best)
        if len(smaller) > 1:
            todo.extend(smaller)
            continue
        found, most, budget = _branch(inner, np.searchsorted(kept, best), budget, deadline)
        members.append(kept[found])
        bound += most
    return np.concatenate(members), bound


def _split(joined: Mask, part: Indices, best: Indices) -> list[tuple[Indices, Indices]]:
    """Return the components of the complement of ``part``, each with its share of ``best``."""
    if not part.size:
        return []
    _, label = connected_components(~joined[np.ix_(part, part)], directed=False)
    order = np.argsort(label, kind="stable")
    pieces = np.split(part[order], np.flatnonzero(np.diff(label[order])) + 1)
    return [(piece, np.intersect1d(piece, best)) for piece in pieces]


def _greedy(joined: Mask) -> Indices:
    """Return a clique: greedily the next vertex that excludes the fewest others."""
    apart = ~joined
    ruled_out = apart.sum(axis=1)
    alive = np.ones(len(joined), dtype=np.bool_)
    members = []
    while np.any(alive):
        v = int(np.argmin(np.where(alive, ruled_out, len(joined) + 1)))
        gone = alive & apart[v]
        ruled_out -= apart[:, gone].sum(axis=1)
        alive &= ~gone
        members.append(v)
    return np.array(members, dtype=np.intp)


def _degeneracy(joined: Mask) -> tuple[Indices, Indices]:
    """Return a degeneracy ordering of the vertices, and their core numbers.

    Source: Matula and Beck 1983.
    """
    m = len(joined)
    degree = joined.sum(axis=1)
    order, core = np.empty(m, dtype=np.intp), np.empty(m, dtype=np.intp)
    level = 0
    for k in range(m):
        v = int(np.argmin(degree))
        level = max(level, int(degree[v]))
        order[k], core[v] = v, level
        degree -= joined[v]
        degree[v] = 2 * m
    return order, core


def _reduced(joined: Mask, part: Indices, best: Indices) -> tuple[Indices, Indices]:
    """Return vertices of ``part`` that contain a largest clique of it, and a clique.

    The clique has the size of ``best``. A clique of k vertices has core numbers of at least
    k − 1, so ``best`` is never removed.
    """
    _, core = _degeneracy(joined[np.ix_(part, part)])
    part = part[core + 1 >= best.size]
    alive, kept = _undominated(
        _bits(joined[np.ix_(part, part)]), _set(np.searchsorted(part, best))
    )
    return part[_indices(alive)], part[_indices(kept)]


def _undominated(near: Sequence[int], best: int) -> tuple[int, int]:
    """Return the vertices that no other dominates, and a clique of them as large as ``best``.

    A vertex dominates v if it is joined to all neighbours of v, but not to v. It can replace
    v in every clique, and it does so in ``best``.
    """
    alive, before = (1 << len(near)) - 1, 0
    while alive != before:
        before = alive
        for v in _members(before):
            other = _dominator(v, near, alive)
            if other:
                alive ^= 1 << v
                best = best ^ 1 << v | other if best >> v & 1 else best
    return alive, best


def _dominator(v: int, near: Sequence[int], alive: int) -> int:
    """Return the set of one vertex that dominates ``v``, or the empty set 0."""
    own = near[v] & alive
    others = alive & ~near[v] & ~(1 << v)
    # A few neighbours of v exclude nearly all others; only the rest needs a full test.
    for neighbour in islice(_members(own), _FEW):
        others &= near[neighbour]
    return next((1 << other for other in _members(others) if not own & ~near[other]), 0)


def _branch(
    joined: Mask, best: Indices, budget: int, deadline: Deadline
) -> tuple[Indices, int, int]:
    """Return a clique, a bound on the largest, and the remaining budget."""
    order = _degeneracy(joined)[0][::-1]
    near = _bits(joined[np.ix_(order, order)])
    found, size = _set(np.argsort(order)[best]), best.size
    stack = [_opened(0, 0, (1 << len(near)) - 1, near, size)]
    budget -= len(near)
    while stack and budget > 0 and not deadline.passed:
        node = stack[-1]
        if node.bound <= size:
            stack.pop()
            continue
        chosen, inside = node.take(near)
        if inside:
            stack.append(_opened(chosen, node.size + 1, inside, near, size))
            budget -= inside.bit_count()
        elif node.size + 1 > size:
            found, size = chosen, node.size + 1
    bound = max([size, *(node.bound for node in stack)])
    return order[_indices(found)], bound, budget


def _opened(chosen: int, size: int, candidates: int, near: Sequence[int], best: int) -> _Node:
    """Return a node without the branches that cannot lead to more than ``best`` vertices."""
    order, colours = _coloured(candidates, near, best - size)
    return _Node(chosen, size, candidates, order, colours)


def _coloured(left: int, near: Sequence[int], enough: int) -> tuple[list[int], list[int]]:
    """Colour vertices greedily; return those with a colour above ``enough``, and the colours.

    Joined vertices have different colours, so no clique among the vertices with colours 1 to
    k is larger than k.
    """
    order: list[int] = []
    colours: list[int] = []
    colour = 0
    while left:
        colour += 1
        free = left
        while free:
            lowest = free & -free
            v = lowest.bit_length() - 1
            left ^= lowest
            free &= ~(near[v] | lowest)
            if colour > enough:
                order.append(v)
                colours.append(colour)
    return order, colours


def _bits(joined: Mask) -> list[int]:
    rows = np.packbits(joined, axis=1, bitorder="little")
    return [int.from_bytes(row.tobytes(), "little") for row in rows]


def _set(members: Indices) -> int:
    return sum(1 << int(v) for v in members)


def _members(bits: int) -> Iterator[int]:
    while bits:
        lowest = bits & -bits
        yield lowest.bit_length() - 1
        bits ^= lowest


def _indices(bits: int) -> Indices:
    return np.array(list(_members(bits)), dtype=np.intp)
