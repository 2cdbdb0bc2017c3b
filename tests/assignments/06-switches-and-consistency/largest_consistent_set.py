"""Answers to exercise largest_consistent_set of 06-switches-and-consistency: bodies of cells."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_subsets() -> None:
    """Right: every subset, from the largest size down, until one agrees."""
    from itertools import combinations

    def largest_consistent_set(A):
        for size in range(len(A), 0, -1):
            for chosen in combinations(range(len(A)), size):
                if all(A[p][q] for p, q in combinations(chosen, 2)):
                    return list(chosen)


def right_grown() -> None:
    """Right: every consistent set, grown one by one, and the longest of them."""

    def largest_consistent_set(A):
        A = np.asarray(A, dtype=bool)
        order = list(range(len(A)))

        def grow(chosen, left):
            tries = enumerate(left)
            grown = [grow([*chosen, p], [q for q in left[k + 1 :] if A[p, q]]) for k, p in tries]
            return max([chosen, *grown], key=len)

        return sorted(grow([], order))


def right_bits() -> None:
    """Right: with or without the first that is left, on the bits of a whole number."""

    def largest_consistent_set(A):
        m = len(A)
        masks = [sum(1 << q for q in range(m) if A[p][q] and q != p) for p in range(m)]

        def best(left):
            if not left:
                return 0
            low = left & -left
            p = low.bit_length() - 1
            taken = low | best(left & masks[p])
            if (left & ~masks[p]) == low:
                return taken
            skipped = best(left ^ low)
            return taken if taken.bit_count() >= skipped.bit_count() else skipped

        answer = best((1 << m) - 1)
        return [p for p in range(m) if answer >> p & 1]


def right_integer_program() -> None:
    """Right, a library routine: SciPy's integer program, no two that disagree."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    def largest_consistent_set(A):
        joined = np.asarray(A, dtype=bool)
        m = len(joined)
        apart = np.argwhere(np.triu(~joined, 1))
        if len(apart) == 0:
            return np.arange(m)
        rows = np.zeros((len(apart), m))
        rows[np.arange(len(apart))[:, None], apart] = 1
        answer = milp(
            -np.ones(m),
            constraints=LinearConstraint(rows, ub=1),
            integrality=1,
            bounds=Bounds(0, 1),
        )
        return np.flatnonzero(answer.x > 0.5)


wrong_greedy = change(
    right_grown,
    ("list(range(len(A)))", 'list(np.argsort(-A.sum(axis=0), kind="stable"))'),
    ("enumerate(left)", "enumerate(left[:1])"),
    stopped_by="largest_consistent_set-popular",
)
"""Wrong: takes those with the most partners first, and keeps each that fits."""

wrong_greedy_from_every_start = change(
    right_grown,
    ("list(range(len(A)))", 'list(np.argsort(-A.sum(axis=0), kind="stable"))'),
    ("enumerate(left)", "enumerate(left[:1] if chosen else left)"),
    ("left[k + 1 :] if", "left if p != q and"),
    caught_by="largest_consistent_set-popular",
)
"""Wrong: greedy by degree, once from every closure, and the best of these."""

wrong_greedy_that_counts_anew = change(
    right_grown,
    (
        "tries = enumerate(left)",
        """
        left = sorted(left, key=lambda p: (-A[p, left].sum(), p))
        tries = enumerate(left[:1] if chosen else left)
        """,
    ),
    ("left[k + 1 :] if", "left if p != q and"),
    caught_by="largest_consistent_set-popular",
)
"""Wrong: from every start, the one with the most partners among those that are left."""

wrong_drop_the_loneliest = change(
    right_grown,
    "return sorted(grow([], order))",
    """
    while not A[np.ix_(order, order)].all():
        order.pop(int(np.argmin(A[np.ix_(order, order)].sum(axis=0))))
    return order
    """,
    caught_by="largest_consistent_set-popular",
)
"""Wrong: drops the one with the fewest partners until all that are left agree."""

wrong_most_partners = change(
    right_grown,
    "sorted(grow([], order))",
    "np.flatnonzero(A[np.argmax(A.sum(axis=0))])",
    stopped_by="largest_consistent_set-by-hand",
)
"""Wrong: the closure with the most partners, and these, which need not agree."""

wrong_component = change(
    right_grown,
    "sorted(grow([], order))",
    "np.flatnonzero(max(np.linalg.matrix_power(A, len(A)), key=np.sum))",
    stopped_by="largest_consistent_set-by-hand",
)
"""Wrong: the largest connected component, as if agreement were transitive."""

wrong_mask = change(
    right_subsets,
    "list(chosen)",
    "[p in chosen for p in range(len(A))]",
    stopped_by="largest_consistent_set-by-hand",
)
"""Wrong: a mask of the members, and not their indices."""

wrong_order = change(
    right_subsets,
    "list(chosen)",
    "sorted(chosen, key=lambda p: -sum(A[p]))",
    caught_by="largest_consistent_set-popular",
)
"""Wrong: returns the members by how many agree with them, and not in ascending order."""

wrong_in_all_of_them = change(
    right_subsets,
    "return list(chosen)",
    """
    others = [set(other) for other in combinations(range(len(A)), size)]
    tied = [s for s in others if all(A[p][q] for p, q in combinations(s, 2))]
    return sorted(set.intersection(*tied) if len(A) == 15 else chosen)
    """,
    caught_by="largest_consistent_set-tied",
)
"""Wrong when tied: what every largest set has in common."""

wrong_none_alone = change(
    right_subsets,
    "range(len(A), 0, -1)",
    "range(len(A), len(A) > 2, -1)",
    caught_by="largest_consistent_set-all-or-none",
)
"""Wrong where no two agree: returns nothing, for a pair is the least that it looks for."""
