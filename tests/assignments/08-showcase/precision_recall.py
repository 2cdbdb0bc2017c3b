"""Answers to exercise precision_recall of 08-showcase: each body is a cell as handed in."""


def right_counts() -> None:
    """Right: counts with numpy."""
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.array(kept), np.array(true)
        right = np.count_nonzero(kept & true)
        precision = right / np.count_nonzero(kept) if kept.any() else 1
        recall = right / np.count_nonzero(true) if true.any() else 1
        return precision, recall


def right_plain_loop() -> None:
    """Right: one closure at a time, and a list comes back."""

    def precision_recall(kept, true):
        pairs = list(zip(kept, true))
        right = sum(1 for k, t in pairs if k and t)
        chosen = sum(1 for k, _ in pairs if k)
        honest = sum(1 for _, t in pairs if t)
        return [right / chosen if chosen else 1.0, right / honest if honest else 1.0]


def right_means() -> None:
    """Right: the share is a mean over those that were kept, or that are true."""
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.asarray(kept, dtype=bool), np.asarray(true, dtype=bool)
        share = [np.mean(a[b]) if b.any() else 1.0 for a, b in ((true, kept), (kept, true))]
        return np.array(share)


def right_sets() -> None:
    """Right, an equivalent form: sets of indices."""

    def precision_recall(kept, true):
        chosen = {k for k, yes in enumerate(kept) if yes}
        honest = {k for k, yes in enumerate(true) if yes}

        def share(part, whole):
            return len(part & whole) / len(whole) if whole else 1.0

        return share(honest, chosen), share(chosen, honest)


def wrong_swapped() -> None:
    """Wrong: precision and recall in the other order. Stopped by the visible case
    precision_recall-by-hand.
    """
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.asarray(kept, dtype=bool), np.asarray(true, dtype=bool)
        share = [np.mean(a[b]) if b.any() else 1.0 for a, b in ((kept, true), (true, kept))]
        return share[0], share[1]


def wrong_accuracy() -> None:
    """Wrong: the share of all decisions that are right, for precision. Stopped by the visible case
    precision_recall-by-hand.
    """
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.asarray(kept, dtype=bool), np.asarray(true, dtype=bool)
        return np.mean(kept == true), np.sum(kept & true) / np.sum(true) if true.any() else 1.0


def wrong_over_all() -> None:
    """Wrong: divides both by the larger of the two numbers. Stopped by the visible case
    precision_recall-by-hand.
    """
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.asarray(kept, dtype=bool), np.asarray(true, dtype=bool)
        share = np.sum(kept & true) / max(np.sum(kept), np.sum(true))
        return share, share


def wrong_zero_if_none_kept() -> None:
    """Wrong: precision 0 where nothing is kept. Caught by precision_recall-none-kept."""
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.asarray(kept, dtype=bool), np.asarray(true, dtype=bool)
        right = np.sum(kept & true)
        return right / max(np.sum(kept), 1), right / np.sum(true) if true.any() else 1.0


def wrong_zero_by_zero() -> None:
    """Wrong: divides zero by zero, which is NaN. Caught by precision_recall-none-true."""
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.asarray(kept, dtype=bool), np.asarray(true, dtype=bool)
        right = np.float64(np.sum(kept & true))
        with np.errstate(all="ignore"):
            return right / np.sum(kept) if kept.any() else 1.0, right / np.sum(true)


def wrong_lists_added() -> None:
    """Wrong: compares a list with True as a whole. Stopped by the visible case
    precision_recall-by-hand.
    """

    def precision_recall(kept, true):
        right = sum([kept == true])
        return right / max(len(kept), 1), right / max(len(true), 1)
