"""Answers to exercise repaired_gnc of 05-gnc: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_own_loop() -> None:
    """Right: least squares first, then the loop with the TLS weight."""
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, w = np.mean(z), np.ones(len(z))
        u_max = np.max(np.abs(z - x))
        if 2 * u_max**2 <= c**2:
            return x, w
        mu = c**2 / (2 * u_max**2 - c**2)
        while True:
            size = np.maximum(np.abs(z - x), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            x = np.sum(w * z) / np.sum(w)
            if np.all((w == 0) | (w == 1)):
                return x, w
            mu *= 1.4


def right_slow_and_long() -> None:
    """Right: factor 1.1 and four hundred steps, more than are needed, then rounded weights."""
    import numpy as np

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
    from math import inf, sqrt

    def repaired_gnc(z, c):
        x = sum(z) / len(z)
        weights = [1] * len(z)
        top = 2 * max((a - x) ** 2 for a in z)
        mu = c**2 / (top - c**2) if top > c**2 else inf
        while mu < inf:
            weights = [
                1.0 if a == x else min(1.0, max(0.0, c * sqrt(mu * (mu + 1)) / abs(a - x) - mu))
                for a in z
            ]
            x = sum(w * a for w, a in zip(weights, z)) / sum(weights)
            mu = inf if all(w in (0, 1) for w in weights) else 2 * mu
        return x, weights


def right_every_consensus() -> None:
    """Right, without any annealing: the lowest TLS cost over the means of all windows."""
    import numpy as np

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
    import numpy as np

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
    "mu = c**2 / (2 * np.max((z - x) ** 2) - c**2)",
    """
    top = 2 * np.max((z - x) ** 2)
    mu = c**2 / (top - c**2) if top > c**2 else np.inf
    """,
    stopped_by="repaired_gnc-clean",
)
"""Wrong where there is nothing to reject: a μ of infinity is put into the formula."""


def wrong_misprint_listing() -> None:
    """Wrong: the listing as it stands, which walks back to the mean. Stopped by the visible case
    repaired_gnc-by-hand.
    """
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, mu = 0.0, 1.0
        for _ in range(20):
            u = z - x
            w = c**4 * mu * (mu + 1) / ((mu + 1) * c**2 + u**2) ** 2
            x = np.sum(w * z) / np.sum(w)
            mu = 1.4 * mu
        return x, w


def wrong_direction_only() -> None:
    """Wrong: only the direction is turned round, so the lie keeps a little weight. Stopped by the
    visible case repaired_gnc-by-hand.
    """
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, mu = np.mean(z), 100.0
        while mu > 1e-3:
            u = z - x
            w = c**4 * mu * (mu + 1) / ((mu + 1) * c**2 + u**2) ** 2
            x = np.sum(w * z) / np.sum(w)
            mu = mu / 1.4
        return x, w


def wrong_typed_in() -> None:
    """Wrong: the number of the statement, typed in. Caught by repaired_gnc-binary."""
    import numpy as np

    def repaired_gnc(z, c):
        weights = np.ones(len(z))
        weights[-1] = 0.0
        return (-0.0125 if len(z) == 5 else z[0]), weights


def wrong_start_at_zero() -> None:
    """Wrong: the right weights, but still from x = 0, which happens to be the answer. Stopped by
    the visible case repaired_gnc-far.
    """
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, mu = 0.0, 1.0
        for _ in range(60):
            size = np.maximum(np.abs(z - x), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            x = np.sum(w * z) / np.sum(w)
            mu *= 1.4
        return x, w


def wrong_mu_from_one() -> None:
    """Wrong: from least squares, but with the lesson's μ = 1, at which nobody may be left. Caught
    by repaired_gnc-far.
    """
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x, mu = np.mean(z), 1.0
        for _ in range(60):
            size = np.maximum(np.abs(z - x), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            if not np.any(w):
                break
            x = np.sum(w * z) / np.sum(w)
            mu *= 1.4
        return x, w


def wrong_no_annealing() -> None:
    """Wrong: TLS by reweighting from the mean; where the lie pulls that far away nobody is left.
    Stopped by the visible case repaired_gnc-binary.
    """
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z, dtype=float)
        x = np.mean(z)
        for _ in range(50):
            w = np.where(np.abs(z - x) <= c, 1.0, 0.0)
            if not np.any(w):
                break
            x = np.average(z, weights=w)
        return x, w


def wrong_integers() -> None:
    """Wrong for integers: keeps x in an array of z's own type. Caught by repaired_gnc-shapes."""
    import numpy as np

    def repaired_gnc(z, c):
        z = np.asarray(z)
        x, w = np.zeros(1, dtype=z.dtype), np.ones(len(z))
        x[0] = round(float(np.mean(z))) if z.dtype.kind == "i" else np.mean(z)
        top = 2 * np.max((z - x) ** 2)
        mu = c**2 / (top - c**2) if top > c**2 else np.inf
        while mu < np.inf:
            size = np.maximum(np.abs(z - x[0]), 1e-12)
            w = np.clip(c / size * np.sqrt(mu * (mu + 1)) - mu, 0, 1)
            x[0] = np.average(z, weights=w)
            mu = np.inf if np.all((w == 0) | (w == 1)) else 1.4 * mu
        return x[0], w


wrong_twenty_steps = change(
    right_negative_mu,
    """
    x = np.mean(z)
    mu = c**2 / (2 * np.max((z - x) ** 2) - c**2)
    for _ in range(200):
    """,
    """
    x, w = np.mean(z), np.ones(z.size)
    ratio = 2 * np.max((z - x) ** 2) / c**2
    if ratio <= 1:
        return x, w
    mu = 1 / (ratio - 1)
    for _ in range(20):
    """,
    caught_by="repaired_gnc-far",
)
"""Wrong: twenty steps, as in the listing, are too few where an outlier is far away."""

wrong_start_typed_in = change(
    right_slow_and_long,
    (
        "x, mu = z.mean(), 1e-12\nfor _ in range(400):",
        "x, mu = z.mean(), 1e-4\nfor _ in range(300):",
    ),
    ("x = np.average(z, weights=w)", "x = np.average(z, weights=w) if np.any(w) else x"),
    ("np.average(z, weights=w), w", "(np.average(z, weights=w) if np.any(w) else x), w"),
    caught_by="repaired_gnc-far",
)
"""Wrong: starts at μ = 1e-4 however far an outlier is."""
