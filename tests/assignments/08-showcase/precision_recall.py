"""Answers to exercise precision_recall of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_counts() -> None:
    """Right: counts with numpy."""
    import numpy as np

    def precision_recall(kept, true):
        kept, true = np.array(kept, dtype=bool), np.array(true, dtype=bool)
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
        actual = sum(1 for _, t in pairs if t)
        return [right / chosen if chosen else 1.0, right / actual if actual else 1.0]


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
        actual = {k for k, yes in enumerate(true) if yes}

        def share(part, whole):
            return len(part & whole) / len(whole) if whole else 1.0

        return share(actual, chosen), share(chosen, actual)


wrong_swapped = change(
    right_counts, "precision, recall", "recall, precision", stopped_by="precision_recall-by-hand"
)
"""Wrong: precision and recall in the other order."""

wrong_accuracy = change(
    right_counts, "precision,", "np.mean(kept == true),", stopped_by="precision_recall-by-hand"
)
"""Wrong: the share of all decisions that are right, for precision."""

wrong_over_all = change(
    right_counts,
    "return precision, recall",
    "return 2 * [right / max(np.sum(kept), np.sum(true))]",
    stopped_by="precision_recall-by-hand",
)
"""Wrong: divides both by the larger of the two numbers."""

wrong_zero_if_none_kept = change(
    right_counts, "kept.any() else 1", "kept.any() else 0", caught_by="precision_recall-none-kept"
)
"""Wrong: precision 0 where nothing is kept."""

wrong_zero_by_zero = change(
    right_counts,
    "right / np.count_nonzero(true) if true.any() else 1",
    "np.divide(right, np.count_nonzero(true))",
    caught_by="precision_recall-none-true",
)
"""Wrong: divides zero by zero, which is NaN."""

wrong_lists_added = change(
    right_plain_loop,
    "sum(1 for k, t in pairs if k and t)",
    "sum([kept == true])",
    stopped_by="precision_recall-by-hand",
)
"""Wrong: compares a list with True as a whole."""
