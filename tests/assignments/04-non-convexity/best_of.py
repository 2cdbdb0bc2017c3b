"""Answers to exercise best_of of 04-non-convexity: each body is a cell as handed in."""


def right_loop() -> None:
    """Right: its own descent, and the best so far."""
    import numpy as np

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        best, least = None, np.inf
        for start in starts:
            x = float(start)
            for _ in range(200):
                kept = z[np.abs(z - x) <= c]
                if kept.size:
                    x = float(np.mean(kept))
            total = np.sum(np.minimum((z - x) ** 2, c**2)) / 2
            if total < least:
                best, least = x, total
        return best


def right_argmin() -> None:
    """Right: all the descents at once, then the index of the least cost."""
    import numpy as np

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        x = np.array(starts, dtype=float)
        for _ in range(200):
            kept = np.abs(x[:, None] - z) <= c
            count = kept.sum(axis=1)
            x = np.where(count > 0, kept @ z / np.maximum(count, 1), x)
        costs = np.clip(np.abs(x[:, None] - z), 0, c) ** 2
        return x[np.argmin(costs.sum(axis=1))]


def right_plain_python() -> None:
    """Right: lists, sorted by cost and, where they tie, by place."""

    def best_of(z, c, starts):
        def descend(x):
            kept = [a for a in z if abs(a - x) <= c]
            new = sum(kept) / len(kept) if kept else x
            return x if abs(new - x) < 1e-12 else descend(new)

        ends = [descend(start) for start in starts]
        return sorted((sum(min((a - x) ** 2, c * c) for a in z), x) for x in ends)[0][1]


def right_last_of_the_tied() -> None:
    """Right: counts what is saved against a plateau; of tied ends it takes the last."""
    import numpy as np

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        best, most = 0.0, -1.0
        for start in starts:
            x, kept = float(start), np.abs(z - start) <= c
            while kept.any() and abs(np.mean(z[kept]) - x) > 1e-12:
                x = float(np.mean(z[kept]))
                kept = np.abs(z - x) <= c
            saved = np.sum(c**2 - (z[kept] - x) ** 2)
            if saved >= most:
                best, most = x, saved
        return best


def wrong_mean_of_ends() -> None:
    """Wrong: averages the ends. Stopped by the visible case best_of-by-hand."""
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        return np.mean([descend(z, c, start) for start in starts])


def wrong_median_of_ends() -> None:
    """Wrong: the end in the middle. Stopped by the visible case best_of-by-hand."""
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        return np.median([descend(z, c, start) for start in starts])


def wrong_last_start() -> None:
    """Wrong: each descent overwrites the one before. Stopped by the visible case best_of-order."""

    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        for start in starts:
            best = descend(z, c, start)
        return best


def wrong_strictly_better_than_the_last() -> None:
    """Wrong: compares each end with the one before it, and not with the best so far. Stopped by
    the visible case best_of-order.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        before = np.inf
        for start in starts:
            x = descend(z, c, start)
            total = np.sum(np.minimum((x - z) ** 2, c**2))
            if total < before:
                best = x
            before = total
        return best


def wrong_best_start() -> None:
    """Wrong: descends from the cheapest start alone. Stopped by the visible case
    best_of-end-not-start.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        costs = [np.sum(np.minimum((x - z) ** 2, c**2)) for x in starts]
        return descend(z, c, starts[int(np.argmin(costs))])


def wrong_start_returned() -> None:
    """Wrong: finds the right descent and returns where it began. Stopped by the visible case
    best_of-by-hand.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        ends = [descend(z, c, start) for start in starts]
        costs = [np.sum(np.minimum((x - z) ** 2, c**2)) for x in ends]
        return starts[int(np.argmin(costs))]


def wrong_misprint() -> None:
    """Wrong: on the lesson's flat floors who is kept costs nothing, so the end that keeps the most
    wins, however badly they fit. Caught by best_of-votes.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        ends = [descend(z, c, start) for start in starts]
        return ends[int(np.argmax([np.sum(np.abs(x - z) <= c) for x in ends]))]


def wrong_rejection_is_free() -> None:
    """Wrong: adds up the squares of the kept ones alone, so a plateau costs nothing. Stopped by
    the visible case best_of-by-hand.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        ends = [descend(z, c, start) for start in starts]
        costs = [np.sum(((x - z) ** 2)[np.abs(x - z) <= c]) for x in ends]
        return ends[int(np.argmin(costs))]


def wrong_rejection_costs_c() -> None:
    """Wrong for c other than 1: a rejected measurement costs c and not c². Caught by
    best_of-votes.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        ends = [descend(z, c, start) for start in starts]
        far = [np.abs(x - z) > c for x in ends]
        costs = [np.sum(np.where(f, c, (x - z) ** 2)) for x, f in zip(ends, far)]
        return ends[int(np.argmin(costs))]


def wrong_least_squares_cost() -> None:
    """Wrong: judges the ends by plain least squares. Stopped by the visible case
    best_of-by-hand.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        ends = [descend(z, c, start) for start in starts]
        return min(ends, key=lambda x: np.sum((x - z) ** 2))


def wrong_plateau_is_an_error() -> None:
    """Wrong: skips a descent that nobody pulls, so that some starts have no end at all. Caught by
    best_of-shapes.
    """
    import numpy as np

    def descend(z, c, x):
        kept = z[np.abs(z - x) <= c]
        new = np.mean(kept) if kept.size else x
        return float(x) if abs(new - x) < 1e-12 else descend(z, c, new)

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        ends = [descend(z, c, start) for start in starts]
        ends = [x for x in ends if np.any(np.abs(x - z) <= c)]
        return min(ends, key=lambda x: np.sum(np.minimum((x - z) ** 2, c**2)))


def wrong_first_fifty_starts() -> None:
    """Wrong for many starts: descends from the first fifty alone. Caught by best_of-order."""
    import numpy as np

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)

        def descend(x):
            for _ in range(1000):
                kept = z[np.abs(x - z) <= c]
                if kept.size == 0 or kept.mean() == x:
                    break
                x = kept.mean()
            return x

        ends = [descend(start) for start in starts[:50]]
        return min(ends, key=lambda x: np.sum(np.minimum((x - z) ** 2, c**2)))
