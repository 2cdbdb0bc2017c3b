"""Answers to exercise largest_consistent_set of 06-switches-and-consistency: bodies of cells."""

from robust_slam_autograder.lint.answers import change


def right_subsets() -> None:
    """Right: every subset, from the largest size down, until one agrees."""
    from itertools import combinations

    def largest_consistent_set(A):
        for size in range(len(A), 0, -1):
            for chosen in combinations(range(len(A)), size):
                if all(A[p][q] for p, q in combinations(chosen, 2)):
                    return list(chosen)


def right_bron_kerbosch() -> None:
    """Right: all maximal cliques by recursion, and the longest of them as an array."""
    import numpy as np

    def largest_consistent_set(A):
        near = [{q for q in range(len(A)) if q != p and A[p][q]} for p in range(len(A))]
        found = []

        def expand(chosen, candidates, excluded):
            if not candidates and not excluded:
                found.append(sorted(chosen))
            for v in list(candidates):
                expand(chosen | {v}, candidates & near[v], excluded & near[v])
                candidates = candidates - {v}
                excluded = excluded | {v}

        expand(set(), set(range(len(A))), set())
        return np.array(max(found, key=len))


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
    import numpy as np
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


def wrong_greedy() -> None:
    """Wrong: takes those with the most partners first, and keeps each that fits. Stopped by the
    visible case largest_consistent_set-popular.
    """
    import numpy as np

    def largest_consistent_set(A):
        A = np.asarray(A, dtype=bool)
        chosen = []
        for p in np.argsort(-A.sum(axis=0), kind="stable"):
            if all(A[p, q] for q in chosen):
                chosen.append(int(p))
        return sorted(chosen)


def wrong_greedy_from_every_start() -> None:
    """Wrong: greedy by degree, once from every closure, and the best of these. Caught by
    largest_consistent_set-popular.
    """
    import numpy as np

    def largest_consistent_set(A):
        A = np.asarray(A, dtype=bool)
        best = []
        for start in range(len(A)):
            chosen = [start]
            for p in np.argsort(-A.sum(axis=0), kind="stable"):
                if p != start and A[p, chosen].all():
                    chosen.append(int(p))
            best = max(best, chosen, key=len)
        return sorted(best)


def wrong_greedy_that_counts_anew() -> None:
    """Wrong: from every start, the one with the most partners among those that are left. Caught by
    largest_consistent_set-popular.
    """
    import numpy as np

    def largest_consistent_set(A):
        A = np.asarray(A, dtype=bool)
        best = []
        for start in range(len(A)):
            chosen, left = [start], A[start].copy()
            left[start] = False
            while left.any():
                inside = np.flatnonzero(left)
                p = int(inside[np.argmax(A[np.ix_(inside, inside)].sum(axis=0))])
                chosen.append(p)
                left &= A[p]
                left[p] = False
            best = max(best, chosen, key=len)
        return sorted(best)


def wrong_drop_the_loneliest() -> None:
    """Wrong: drops the one with the fewest partners until all that are left agree. Caught by
    largest_consistent_set-popular.
    """
    import numpy as np

    def largest_consistent_set(A):
        A = np.asarray(A, dtype=bool)
        left = list(range(len(A)))
        while not A[np.ix_(left, left)].all():
            left.pop(int(np.argmin(A[np.ix_(left, left)].sum(axis=0))))
        return left


def wrong_most_partners() -> None:
    """Wrong: the closure with the most partners, and these, who need not agree. Stopped by the
    visible case largest_consistent_set-by-hand.
    """
    import numpy as np

    def largest_consistent_set(A):
        A = np.asarray(A, dtype=bool)
        return np.flatnonzero(A[np.argmax(A.sum(axis=0))])


def wrong_component() -> None:
    """Wrong: the largest connected component, as if agreement passed on. Stopped by the visible
    case largest_consistent_set-by-hand.
    """
    import numpy as np
    from scipy.sparse.csgraph import connected_components

    def largest_consistent_set(A):
        _, label = connected_components(np.asarray(A, dtype=bool))
        return np.flatnonzero(label == np.argmax(np.bincount(label)))


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


def wrong_in_all_of_them() -> None:
    """Wrong when tied: what every largest set has in common, or one if that is nothing or little.
    Caught by largest_consistent_set-tied.
    """
    from itertools import combinations

    def largest_consistent_set(A):
        for size in range(len(A), 0, -1):
            sets = [
                set(chosen)
                for chosen in combinations(range(len(A)), size)
                if all(A[p][q] for p, q in combinations(chosen, 2))
            ]
            if sets:
                common = set.intersection(*sets)
                return sorted(common if len(A) == 15 else sets[0])


def wrong_none_alone() -> None:
    """Wrong where no two agree: returns nobody, for a pair is the least that it looks for. Caught
    by largest_consistent_set-all-or-none.
    """
    from itertools import combinations

    def largest_consistent_set(A):
        for size in range(len(A), 1, -1):
            for chosen in combinations(range(len(A)), size):
                if all(A[p][q] for p, q in combinations(chosen, 2)):
                    return list(chosen)
        return [0] if len(A) == 2 else []
