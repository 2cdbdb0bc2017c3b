"""Answers to exercise repaired_gnc of 05-gnc: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_loop() -> None:
    """Right: least squares first, then the loop with the TLS weight."""

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, w = np.mean(z), np.ones(len(z))
        ratio = 2 * np.max((z - x) ** 2) / c**2
        mu = 1 / (ratio - 1) if ratio > 1 else np.inf
        while mu < np.inf:
            size = np.maximum(np.abs(z - x), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            x = np.average(z, weights=w)
            mu = np.inf if np.all((w == 0) | (w == 1)) else 1.4 * mu
        return x, w


def right_slow_and_long() -> None:
    """Right: factor 1.1 and four hundred steps, more than are needed, then rounded weights."""

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, mu = z.mean(), 1e-12
        for _ in range(400):
            size = np.maximum(np.abs(z - x), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            x = np.average(z, weights=w)
            mu = 1.1 * mu
        w = np.round(w)
        return np.average(z, weights=w), w


def right_plain_python() -> None:
    """Right: plain Python with factor 2, a list of weights."""

    def repaired_gnc(z, c):
        def weight(u):
            return 1.0 if u == 0 else min(1.0, max(0.0, c * (mu * (mu + 1)) ** 0.5 / abs(u) - mu))

        x, weights = sum(z) / len(z), [1] * len(z)
        ratio = 2 * max((a - x) ** 2 for a in z) / c**2
        mu = 1 / (ratio - 1) if ratio > 1 else None
        while mu:
            weights = [weight(a - x) for a in z]
            x = sum(w * a for w, a in zip(weights, z)) / sum(weights)
            mu = None if all(w in (0, 1) for w in weights) else 2 * mu
        return x, weights


def right_every_consensus() -> None:
    """Right, without any annealing: the lowest TLS cost over the means of all windows."""

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        order = np.sort(z)
        m = len(order)
        means = [np.mean(order[i:j]) for i in range(m) for j in range(i + 1, m + 1)]
        costs = [np.sum(np.minimum((z - x) ** 2, c**2)) for x in means]
        x = means[int(np.argmin(costs))]
        return x, np.where(np.abs(z - x) <= c, 1.0, 0.0)


def right_negative_mu() -> None:
    """Right by luck: with nothing to reject μ is below -1, and every weight is clipped to 1."""

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x = np.mean(z)
        mu = c**2 / (2 * np.max((z - x) ** 2) - c**2)
        for _ in range(200):
            size = np.maximum(np.abs(z - x), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            x = np.sum(w * z) / np.sum(w)
            if np.all((w == 0) | (w == 1)):
                break
            mu *= 1.4
        return x, w


wrong_nothing_to_reject = change(
    right_negative_mu,
    "2 * np.max((z - x) ** 2) - c**2",
    "np.maximum(2 * np.max((z - x) ** 2) - c**2, 0)",
    stopped_by="repaired_gnc-clean",
)
"""Wrong where there is nothing to reject: a μ of infinity is put into the formula."""

wrong_misprint_listing = change(
    right_slow_and_long,
    "np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)",
    "mu * (mu + 1) / (mu + 1 + (size / c) ** 2) ** 2",
    stopped_by="repaired_gnc-by-hand",
)
"""Wrong: the listing's weight, which leads back to the mean."""

wrong_direction_only = change(
    right_loop,
    ("1 / (ratio - 1) if ratio > 1 else np.inf", "100.0"),
    (
        "np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)",
        "mu * (mu + 1) / (mu + 1 + (size / c) ** 2) ** 2",
    ),
    ("np.all((w == 0) | (w == 1)) else 1.4 * mu", "mu < 1e-3 else mu / 1.4"),
    stopped_by="repaired_gnc-by-hand",
)
"""Wrong: only the direction is turned round, so the outlier keeps a little weight."""

wrong_typed_in = change(
    right_loop,
    "return x, w",
    "return (-0.0125 if len(z) == 5 else z[0]), np.append(np.ones(len(z) - 1), 0.0)",
    caught_by="repaired_gnc-binary",
)
"""Wrong: the number of the statement, typed in."""

wrong_start_at_zero = change(
    right_loop,
    ("np.mean(z),", "0.0,"),
    ("1 / (ratio - 1) if ratio > 1 else np.inf", "1.0"),
    stopped_by="repaired_gnc-far",
)
"""Wrong: the right weights, but still from x = 0, which happens to be the answer."""

wrong_mu_from_one = change(
    right_loop, "1 / (ratio - 1) if ratio > 1 else np.inf", "1.0", caught_by="repaired_gnc-far"
)
"""Wrong: from least squares, but with the lesson's μ = 1, at which none may be left."""

wrong_no_annealing = change(
    right_slow_and_long, "mean(), 1e-12", "mean(), 1e9", stopped_by="repaired_gnc-binary"
)
"""Wrong: TLS by reweighting from the mean; where the outlier pulls that far away none is left."""

wrong_integers = change(
    right_loop,
    ("np.asarray(z, dtype=float)", "np.asarray(z)"),
    ("np.average(z, weights=w)", "np.average(z, weights=w).astype(z.dtype)"),
    caught_by="repaired_gnc-shapes",
)
"""Wrong for integers: keeps x in z's own type."""

wrong_twenty_steps = change(
    right_negative_mu, "range(200)", "range(20)", caught_by="repaired_gnc-far"
)
"""Wrong: twenty steps, as in the listing, are too few where an outlier is far away."""

wrong_start_typed_in = change(
    right_slow_and_long, "mean(), 1e-12", "mean(), 1e-4", caught_by="repaired_gnc-far"
)
"""Wrong: starts at μ = 1e-4 however far an outlier is."""
