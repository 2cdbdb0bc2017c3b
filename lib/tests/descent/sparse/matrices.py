"""Random sparse matrices with the pattern of a graph, and what they are as dense ones."""

import numpy as np
from robust_slam.descent.sparse.pattern import find_pattern

METHODS = ("simplicial", "multifrontal")


def random_edges(n, more, rng):
    """Edges of a connected graph of n poses in no order, some of them twice."""
    name = rng.permutation(n)
    tree = [(name[rng.integers(k)], name[k]) for k in range(1, n)]
    extra = [rng.choice(n, 2, replace=False) for _ in range(more)]
    return np.array([*tree, *extra], dtype=np.intp).reshape(-1, 2)


def edge_blocks(m, block, rng):
    """Positive definite (m, 2, 2, block, block), over both ends twice."""
    root = rng.normal(size=(m, 2 * block, 2 * block + 1))
    full = root @ np.swapaxes(root, 1, 2)
    return full.reshape(m, 2, block, 2, block).transpose(0, 1, 3, 2, 4)


def dense(n, edges, blocks):
    """The sum of the edge blocks, (n·block, n·block)."""
    block = blocks.shape[-1]
    full = np.zeros((n, block, n, block))
    for (i, j), each in zip(edges, blocks, strict=True):
        for a, p in enumerate((i, j)):
            for b, q in enumerate((i, j)):
                full[p, :, q, :] += each[a, b]
    return full.reshape(n * block, n * block)


def as_dense(pattern, total):
    """The matrix that the filled blocks of a pattern mean, pose 0 left out, by pose."""
    n, block = pattern.n, pattern.block
    full = np.zeros((n, block, n, block))
    rows, columns = pattern.order[pattern.row], pattern.order[pattern.column]
    for each, r, c in zip(total, rows, columns, strict=True):
        full[r, :, c, :] = each
        full[c, :, r, :] = each.T
    return full.reshape(n * block, n * block)[block:, block:]


def pattern_by(method, n, edges, block, monkeypatch):
    """The pattern with one of the METHODS, whatever would be quicker."""
    limit = np.inf if method == "simplicial" else -1.0
    monkeypatch.setattr("robust_slam.descent.sparse.pattern.DENSE", limit)
    pattern = find_pattern(n, edges, block)
    assert type(pattern.method).__name__.lower() == method
    return pattern
