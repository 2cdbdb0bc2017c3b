"""Maximum clique: a largest set of vertices that are all joined to each other.

The problem is NP-hard, and hard to approximate. The search here is exact, and anytime: it
counts what it looks at and, when its budget is used up, gives the best clique so far and a
bound that no clique exceeds. The bits of a Python integer stand for a set of vertices.

First the graph is made smaller. A vertex that can be in no clique as large as the one at
hand is dropped; so is one whose neighbours are all neighbours of another, to which it is
not joined itself. What is left falls apart where the *complement* does: vertices that are
joined to all others stand alone there, and largest cliques of the parts make up one of the
whole. Dense graphs, such as those of few wrong closures, are nearly done by this alone.

Source: Tomita and Seki 2003, branch and bound with a greedy colouring; San Segundo et al.
2011, the same on sets of bits; Fomin, Grandoni and Kratsch 2009, domination and components
for independent sets, which are the cliques of the complement.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from robust_slam._arrays import Indices, Mask

BUDGET = 20_000_000
"""Candidates that a search looks at, unless another number is given: about ten seconds."""
_FEW = 20
"""Neighbours to look at before a full test."""


@dataclass(frozen=True, eq=False)
class Clique:
    """A clique, and how far it can be from a largest one.

    ``members`` ``(k,)`` are vertices, ascending. ``bound`` is a size that no clique
    exceeds, and ``proven`` tells that k reaches it.
    """

    members: Indices
    proven: bool
    bound: int


@dataclass
class _Node:
    """An open node of the search: ``size`` vertices ``chosen``, and what may join them.

    ``order`` are the ``candidates`` that are worth a try, the last one first, each with its
    colour: no clique among the candidates that are left is larger than ``colours[-1]``.
    """

    chosen: int
    size: int
    candidates: int
    order: list[int]
    colours: list[int]

    @property
    def bound(self) -> int:
        """A size that no clique below this node exceeds, 0 if nothing is worth a try."""
        return self.size + self.colours[-1] if self.order else 0

    def take(self, near: Sequence[int]) -> tuple[int, int]:
        """Take the next candidate; return the vertices with it and what may join these."""
        v = self.order.pop()
        self.colours.pop()
        self.candidates ^= 1 << v
        return self.chosen | 1 << v, self.candidates & near[v]


def max_clique(
    adjacency: ArrayLike, *, fixed: ArrayLike | None = None, budget: int = BUDGET
) -> Clique:
    """Return a largest clique of ``adjacency`` ``(m, m)``, or the best within ``budget``.

    ``adjacency`` is boolean and symmetric; its diagonal does not matter. ``fixed`` are the
    indices ``(f,)`` of vertices that have to be members; the clique is then a largest one
    among those that contain them. ``budget`` counts the candidates at each branch node, which
    is what a search costs, and never the clock: the same input always gives the same answer.
    Of several largest cliques any may come back.

    Raises:
        ValueError: ``adjacency`` is not square, boolean and symmetric, ``fixed`` are not
            indices of vertices that are all joined, or ``budget`` is below 1.

    Source: Tomita et al. 2010; San Segundo et al. 2011; see the module.
    """
    joined = _checked(adjacency)
    held = _held(fixed, joined)
    if budget < 1:
        raise ValueError(f"budget is {budget}; give at least 1")
    free = np.flatnonzero(joined[held].all(axis=0))
    inner = joined[np.ix_(free, free)]
    found, bound = _solve(inner, _improved(inner, _greedy(inner)), budget)
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


def _held(fixed: ArrayLike | None, joined: Mask) -> Indices:
    held = np.array([] if fixed is None else fixed)
    if held.size and not np.issubdtype(held.dtype, np.integer):
        raise ValueError(f"fixed: the entries are {held.dtype}; give indices of vertices")
    held = np.unique(held.astype(np.intp))
    if np.any((held < 0) | (held >= len(joined))):
        raise ValueError(f"fixed: vertices are 0 to {len(joined) - 1}; got {held.tolist()}")
    apart = ~joined[np.ix_(held, held)]
    np.fill_diagonal(apart, False)
    if np.any(apart):
        i, j = held[np.argwhere(apart)[0]]
        raise ValueError(f"fixed: vertices {i} and {j} are not joined, so no clique has both")
    return held


def _solve(joined: Mask, best: Indices, budget: int) -> tuple[Indices, int]:
    """Return a clique, at least as large as the clique ``best``, and a bound on the largest.

    Parts are taken on until they no longer fall apart; what they have adds up.
    """
    todo = [(np.arange(len(joined)), best)]
    members, bound = [np.empty(0, dtype=np.intp)], 0
    while todo:
        part, best = todo.pop()
        kept, best = _reduced(joined, part, best)
        inner = joined[np.ix_(kept, kept)]
        pieces = [kept[piece] for piece in _pieces(inner)]
        if len(pieces) > 1:
            todo.extend((piece, np.intersect1d(piece, best)) for piece in pieces)
            continue
        found, most, budget = _branch(inner, np.searchsorted(kept, best), budget)
        members.append(kept[found])
        bound += most
    return np.concatenate(members), bound


def _greedy(joined: Mask) -> Indices:
    """Return a clique: always the vertex next that rules out the fewest others."""
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


def _improved(joined: Mask, clique: Indices) -> Indices:
    """Return ``clique``, enlarged while a vertex can join or two can come for one.

    Source: Andrade, Resende and Werneck 2012, on the complement.
    """
    while clique.size:
        lacks = (~joined[:, clique]).sum(axis=1)
        lacks[clique] = len(joined)
        ready, nearly = np.flatnonzero(lacks == 0), np.flatnonzero(lacks == 1)
        if ready.size:
            clique = np.append(clique, ready[0])
            continue
        if not nearly.size:
            return np.sort(clique)
        # The one member that each of these is not joined to, and the pairs that share it.
        lacked = clique[np.argmin(joined[np.ix_(nearly, clique)], axis=1)]
        pairs = joined[np.ix_(nearly, nearly)] & (lacked[:, None] == lacked)
        if not np.any(pairs):
            break
        a, b = np.argwhere(pairs)[0]
        clique = np.append(clique[clique != lacked[a]], nearly[[a, b]])
    return np.sort(clique)


def _degeneracy(joined: Mask) -> tuple[Indices, Indices]:
    """Return the vertices, each of least degree among those behind it, and core numbers.

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
    """Return vertices of ``part`` that hold a largest clique of it, and a clique like ``best``.

    A clique of k vertices lies where core numbers are at least k − 1, so that ``best``
    itself stays.
    """
    _, core = _degeneracy(joined[np.ix_(part, part)])
    part = part[core + 1 >= best.size]
    alive, kept = _undominated(
        _bits(joined[np.ix_(part, part)]), _set(np.searchsorted(part, best))
    )
    return part[_indices(alive)], part[_indices(kept)]


def _undominated(near: Sequence[int], best: int) -> tuple[int, int]:
    """Return the vertices that no other dominates, and a clique among them like ``best``.

    Another dominates v if it is joined to all that v is joined to, but not to v. In every
    clique it can stand for v, and it does so in ``best``.
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
    """Return the set of one vertex that dominates ``v``, or 0."""
    own = near[v] & alive
    others = alive & ~near[v] & ~(1 << v)
    # A few neighbours of v already rule out nearly all; only the rest is worth a full test.
    for neighbour in islice(_members(own), _FEW):
        others &= near[neighbour]
    return next((1 << other for other in _members(others) if not own & ~near[other]), 0)


def _pieces(joined: Mask) -> list[Indices]:
    """Return the components of the complement."""
    _, label = connected_components(~joined, directed=False)
    order = np.argsort(label, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1)


def _branch(joined: Mask, best: Indices, budget: int) -> tuple[Indices, int, int]:
    """Return a clique, a bound on the largest, and the budget that is left."""
    order = _degeneracy(joined)[0][::-1]
    near = _bits(joined[np.ix_(order, order)])
    found, size = _set(np.argsort(order)[best]), best.size
    stack = [_opened(0, 0, (1 << len(near)) - 1, near, size)]
    budget -= len(near)
    while stack and budget > 0:
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
    """Return a node; candidates with so few colours that they cannot beat ``best`` stay out."""
    order, colours = _coloured(candidates, near, best - size)
    return _Node(chosen, size, candidates, order, colours)


def _coloured(left: int, near: Sequence[int], enough: int) -> tuple[list[int], list[int]]:
    """Colour vertices so that joined ones differ; return those with a colour above ``enough``.

    k colours are a bound on the cliques among the vertices with colours 1 to k.
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
