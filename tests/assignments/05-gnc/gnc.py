"""Answers to exercise gnc of 05-gnc: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_gnc() -> None:
    """Right: NumPy's weighted average for the solves, and the surrogates in (r/c)²."""

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z, s = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)
        history = {"mu": [], "weights": [], "x": []}
        x, w = np.average(z, weights=s**-2.0), np.ones(z.size)
        ratio = 2 * np.max(np.abs(z - x) / s) ** 2 / c**2
        mu = mu0
        if mu is None and kind == "gm":
            mu = max(ratio, 1.0)
        elif mu is None:
            mu = 1 / (ratio - 1) if ratio > 1 else np.inf
        while mu < np.inf:
            square = np.maximum(((z - x) / (s * c)) ** 2, 1e-300)
            if kind == "gm":
                w = (mu / (mu + square)) ** 2
            else:
                w = np.clip(np.sqrt(mu * (mu + 1) / square) - mu, 0, 1)
            if not np.any(w):
                break
            x = np.average(z, weights=w / s**2)
            for name, value in zip(history, (mu, w, x)):
                history[name].append(value)
            if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):
                break
            mu = max(mu / factor, 1.0) if kind == "gm" else mu * factor
        return x, w, history


def right_plain_python() -> None:
    """Right: no arrays at all, lists everywhere."""
    from math import sqrt

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        sigmas = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)

        def solve(weights):
            shares = [w / s**2 for w, s in zip(weights, sigmas)]
            return sum(share * a for share, a in zip(shares, z)) / sum(shares)

        def weight(u, mu):
            if kind == "gm":
                return 1 / (1 + u**2 / mu) ** 2
            return 1.0 if u == 0 else min(1.0, max(0.0, sqrt(mu * (mu + 1)) / u - mu))

        weights, rows = [1.0] * len(z), []
        x = solve(weights)
        ratio = 2 * max(abs(a - x) / s / c for a, s in zip(z, sigmas)) ** 2
        first = max(1.0, ratio) if kind == "gm" else 1 / (ratio - 1) if ratio > 1 else None
        mu = first if mu0 is None else mu0
        while mu is not None:
            weights = [weight(abs(a - x) / s / c, mu) for a, s in zip(z, sigmas)]
            if not any(weights):
                break
            x = solve(weights)
            rows.append((mu, weights, x))
            if kind == "tls":
                mu = None if all(w in (0, 1) for w in weights) else mu * factor
            else:
                mu = None if mu == 1 else max(mu / factor, 1.0)
        return x, weights, dict(zip(("mu", "weights", "x"), zip(*rows) if rows else [[]] * 3))


def right_schedule_first() -> None:
    """Right: the whole schedule as an array, lstsq for the solves, arrays in the history."""

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z, s = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)

        def solve(w):
            row = np.sqrt(w) / s
            return float(np.linalg.lstsq(row[:, None], row * z, rcond=None)[0][0])

        x, w, xs, ws = solve(np.ones(z.size)), np.ones(z.size), [], []
        ratio = max(2 * np.max(np.square((z - x) / (s * c))), 1.0)
        powers = float(factor) ** np.arange(300)
        if kind == "gm":
            mus = np.maximum((mu0 or ratio) / powers, 1)
            mus = mus[: np.argmax(mus == 1) + 1]
        else:
            mus = (mu0 or 1 / (ratio - 1)) * powers if mu0 or ratio > 1 else []
        for mu in mus:
            u = np.maximum(np.abs(z - x) / (s * c), 1e-150)
            soft = np.clip(np.sqrt(mu * (mu + 1)) / u - mu, 0, 1)
            w = soft if kind == "tls" else np.square(mu / (mu + u**2))
            if np.count_nonzero(w) == 0:
                break
            x = solve(w)
            xs.append(x)
            ws.append(w)
            if kind == "tls" and np.array_equal(w, np.round(w)):
                break
        rows = np.reshape(ws, (len(xs), z.size))
        return x, w, {"mu": np.array(mus[: len(xs)]), "weights": rows, "x": np.array(xs)}


def right_whitened_least_squares() -> None:
    """Right, an equivalent form: whitens once, and steps from x by the weighted mean residual."""

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z, a = np.array(z, dtype=float), np.ones(len(z)) / np.asarray(sigma, dtype=float)
        x, w, rows = float(a @ (a * z) / (a @ a)), [1.0] * len(z), []
        ratio = 2 * np.max((a * (z - x)) ** 2) / c**2
        if mu0 is not None:
            mu = float(mu0)
        elif kind == "tls":
            mu = 1 / (ratio - 1) if ratio > 1 else None
        else:
            mu = max(ratio, 1.0)
        while mu is not None:
            u = a * (z - x) / c
            if kind == "tls":
                low, high = np.sqrt(mu / (mu + 1)), np.sqrt((mu + 1) / mu)
                size = np.clip(np.abs(u), low, high)
                soft = low * (mu + 1) / size - mu
                w = np.where(size == low, 1.0, np.where(size == high, 0.0, soft))
            else:
                w = (1 + u**2 / mu) ** -2.0
            if w.max() == 0:
                break
            x = x + c * float((w * a) @ u / ((w * a) @ a))
            rows.append((mu, w.tolist(), x))
            is_last = mu == 1 if kind == "gm" else np.all(w * (1 - w) == 0)
            mu = None if is_last else mu * factor if kind == "tls" else max(mu / factor, 1.0)
        return x, w, dict(zip(("mu", "weights", "x"), zip(*rows) if rows else [[]] * 3))


def right_recursion() -> None:
    """Right: one step, and the rest from the next μ on."""

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z, information = np.asarray(z, dtype=float), np.ones(len(z)) / np.square(sigma)

        def rest(mu, x, history):
            square = np.maximum((z - x) ** 2 * information / c**2, 1e-300)
            soft = (1 + square / mu) ** -2.0
            new = soft if kind == "gm" else np.clip((mu * (mu + 1) / square) ** 0.5 - mu, 0, 1)
            if not new.any():
                return x, new, history
            x = np.average(z, weights=new * information)
            history = {name: [*history[name], one] for name, one in zip(history, (mu, new, x))}
            if mu == 1 if kind == "gm" else np.isin(new, (0, 1)).all():
                return x, new, history
            return rest(max(mu / factor, 1) if kind == "gm" else mu * factor, x, history)

        x, history = np.average(z, weights=information), {"mu": [], "weights": [], "x": []}
        ratio = 2 * np.max((z - x) ** 2 * information) / c**2
        if kind == "tls" and mu0 is None and ratio <= 1:
            return x, np.ones(z.size), history
        first = max(ratio, 1) if kind == "gm" else 1 / (ratio - 1)
        return rest(mu0 or first, x, history)


wrong_start_at_x0 = change(
    right_gnc, "ratio =", "x = x if x0 is None else x0\nratio =", stopped_by="gnc-lesson"
)
"""Wrong: starts from x0 where it is given, beside the outlier."""

wrong_mu_before_the_solve = change(
    right_gnc,
    "while",
    'mu = max(mu / factor, 1.0) if kind == "gm" else mu * factor\nwhile',
    stopped_by="gnc-by-hand",
)
"""Wrong: moves μ before the first weights."""

wrong_misprint_next_mu = change(
    right_gnc,
    "(mu, w, x)",
    '(max(mu / factor, 1.0) if kind == "gm" else mu * factor, w, x)',
    stopped_by="gnc-by-hand",
)
"""Wrong: writes the next μ into the row, as the lesson prints it."""

wrong_start_is_a_row = change(
    right_gnc,
    "while",
    'history = {"mu": [mu], "weights": [w], "x": [x]}\nwhile',
    stopped_by="gnc-by-hand",
)
"""Wrong: the least-squares start is written down as a first row."""

wrong_misprint_surrogate = change(
    right_gnc,
    "np.clip(np.sqrt(mu * (mu + 1) / square) - mu, 0, 1)",
    "np.round(mu * (mu + 1) / (mu + 1 + square) ** 2, 2 if mu > 1e3 else 15)",
    stopped_by="gnc-by-hand",
)
"""Wrong: anneals towards least squares: a large μ is soft, as in the lesson's listing."""

wrong_hard_from_the_start = change(
    right_gnc, "1 / (ratio - 1)", "(1e9 if len(z) < 4 else 1 / (ratio - 1))", caught_by="gnc-empty"
)
"""Wrong: TLS from the first step, without any annealing."""

wrong_misprint_start = change(right_gnc, "1 / (ratio - 1)", "1.0", stopped_by="gnc-by-hand")
"""Wrong: begins TLS at μ = 1, as the lesson does, and forgets the largest residual."""

wrong_signed_residual = change(right_gnc, "np.abs", "", caught_by="gnc-tls")
"""Wrong: takes the largest residual with its sign, so that it misses an outlier on the left."""

wrong_mu0_ignored = change(right_gnc, "mu = mu0", "mu = None", stopped_by="gnc-given-mu")
"""Wrong: makes the first μ from the residuals always."""

wrong_factor_typed_in = change(
    right_gnc, "mu = mu0", "mu, factor = mu0, 1.4", caught_by="gnc-given-mu"
)
"""Wrong: multiplies by 1.4, whatever factor is."""

wrong_one_solve_more = change(
    right_gnc,
    'if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):',
    """
    old = ([-1.0, *history["mu"]][-2], [w + 0.5, *history["weights"]][-2])
    if old[0] == 1 if kind == "gm" else np.all((old[1] == 0) | (old[1] == 1)):
    """,
    stopped_by="gnc-by-hand",
)
"""Wrong: asks whether to stop with the weights before, so the last row occurs twice."""

wrong_gm_never_at_one = change(right_gnc, "mu == 1 if", "mu / factor < 1 if", stopped_by="gnc-gm")
"""Wrong: GM stops when the next μ would be below 1, so it never solves there."""

wrong_gm_until_settled = change(
    right_gnc,
    "mu == 1 if",
    'mu == 1 and abs(x - [np.inf, *history["x"]][-2]) < 1e-12 if',
    caught_by="gnc-gm",
)
"""Wrong: GM goes on at μ = 1 until x no longer changes."""

wrong_gm_below_one = change(
    right_gnc, ("max(ratio, 1.0)", "ratio"), ("mu == 1", "mu <= 1"), caught_by="gnc-nothing"
)
"""Wrong: GM begins below 1 where the residuals are small."""

wrong_weights_at_the_new_x = change(
    right_gnc,
    "return",
    'w = (mu / (mu + ((z - x) / (s * c)) ** 2)) ** 2 if kind == "gm" else w\nreturn',
    caught_by="gnc-gm",
)
"""Wrong: returns weights made anew at the last x, which are not those of the last solve."""

wrong_solve_without_sigma = change(right_gnc, "w / s**2", "w", caught_by="gnc-sigmas")
"""Wrong: whitens the residuals but solves as if the σ were all the same."""

wrong_start_without_sigma = change(right_gnc, "=s**-2.0", "=None", caught_by="gnc-sigmas")
"""Wrong: starts from the plain mean, though the σ differ."""

wrong_not_whitened = change(
    right_gnc, ("np.abs(z - x) / s", "np.abs(z - x)"), ("(s * c)", "c"), caught_by="gnc-tls"
)
"""Wrong: weighs the residual without dividing it by σ."""

wrong_nan_when_empty = change(
    right_gnc,
    "if not np.any(w):",
    "if not np.any(w):\n    x = np.sum(w * z) / np.sum(w)",
    stopped_by="gnc-empty",
)
"""Wrong: solves when none is left: 0/0."""

wrong_row_when_empty = change(
    right_gnc,
    "if not np.any(w):",
    """
    if not np.any(w):
        for name, value in zip(history, (mu, w, x)):
            history[name].append(value)
    """,
    caught_by="gnc-empty",
)
"""Wrong: writes a row for the μ at which none is left."""

wrong_keeps_old_weights_when_empty = change(
    right_gnc,
    "if not np.any(w):",
    'if not np.any(w):\n    w = (history["weights"] or [w])[-1]',
    caught_by="gnc-empty",
)
"""Wrong: returns the weights of the solve before where none is left."""

wrong_negative_mu = change(right_gnc, " if ratio > 1 else np.inf", "", caught_by="gnc-nothing")
"""Wrong: takes the formula for μ where it is negative."""

wrong_integers = change(
    right_gnc,
    ("np.asarray(z, dtype=float)", "np.asarray(z)"),
    ("if not np.any(w):", "w = w.astype(z.dtype)\nif not np.any(w):"),
    caught_by="gnc-nothing",
)
"""Wrong: keeps the weights in an array of z's own type."""
