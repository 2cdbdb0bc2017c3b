"""Answers to exercise gnc of 05-gnc: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_steps() -> None:
    """Right: the seven steps one after the other, with the pieces of the weight."""
    import numpy as np

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z = np.array(z, dtype=float)
        s = np.ones(z.size) * sigma
        history = {"mu": [], "weights": [], "x": []}
        x = np.sum(z / s**2) / np.sum(1 / s**2)
        w = np.ones(z.size)
        u_max = np.max(np.abs(z - x) / s)
        mu = mu0
        if mu is None:
            if kind == "gm":
                mu = max(1, 2 * u_max**2 / c**2)
            elif 2 * u_max**2 <= c**2:
                return x, w, history
            else:
                mu = c**2 / (2 * u_max**2 - c**2)
        while True:
            u = np.abs(z - x) / s
            if kind == "gm":
                w = (mu * c**2 / (u**2 + mu * c**2)) ** 2
            else:
                w = np.zeros(z.size)
                w[u**2 <= c**2 * mu / (mu + 1)] = 1
                mid = (u**2 > c**2 * mu / (mu + 1)) & (u**2 < c**2 * (mu + 1) / mu)
                w[mid] = c / u[mid] * np.sqrt(mu * (mu + 1)) - mu
            if np.all(w == 0):
                return x, w, history
            x = np.sum(w * z / s**2) / np.sum(w / s**2)
            history["mu"].append(mu)
            history["weights"].append(w)
            history["x"].append(x)
            if kind == "tls" and set(w.tolist()) <= {0.0, 1.0}:
                return x, w, history
            if kind == "gm" and mu == 1:
                return x, w, history
            mu = mu * factor if kind == "tls" else max(1.0, mu / factor)


def right_plain_python() -> None:
    """Right: no arrays at all, lists everywhere."""
    from math import sqrt

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z = [float(a) for a in z]
        sigmas = [float(s) for s in sigma] if hasattr(sigma, "__len__") else [sigma] * len(z)

        def solve(weights):
            shares = [w / s**2 for w, s in zip(weights, sigmas)]
            return sum(a * b for a, b in zip(shares, z)) / sum(shares)

        def tls(u, mu):
            if u == 0:
                return 1.0
            return min(1.0, max(0.0, c / u * sqrt(mu * (mu + 1)) - mu))

        def gm(u, mu):
            return 1 / (1 + u**2 / (mu * c**2)) ** 2

        weights = [1.0] * len(z)
        x = solve(weights)
        top = 2 * max(abs(a - x) / s for a, s in zip(z, sigmas)) ** 2
        rows = []
        if mu0 is None and kind == "tls" and top <= c**2:
            mu = None
        elif mu0 is not None:
            mu = mu0
        else:
            mu = c**2 / (top - c**2) if kind == "tls" else max(1.0, top / c**2)
        while mu is not None:
            weight = tls if kind == "tls" else gm
            weights = [weight(abs(a - x) / s, mu) for a, s in zip(z, sigmas)]
            if not any(weights):
                break
            x = solve(weights)
            rows.append((mu, weights, x))
            if kind == "tls":
                mu = None if all(w in (0.0, 1.0) for w in weights) else mu * factor
            else:
                mu = None if mu <= 1 else max(mu / factor, 1.0)
        names = ("mu", "weights", "x")
        return x, weights, {name: [row[k] for row in rows] for k, name in enumerate(names)}


def right_schedule_first() -> None:
    """Right: the whole schedule as an array, lstsq for the solves, arrays in the history."""
    import numpy as np

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z = np.asarray(z, dtype=float)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)

        def solve(w):
            row = np.sqrt(w) / s
            return float(np.linalg.lstsq(row[:, None], row * z, rcond=None)[0][0])

        w = np.ones_like(z)
        x = solve(w)
        ratio = 2 * np.max(np.square((z - x) / s)) / c**2
        powers = float(factor) ** np.arange(300)
        if kind == "gm":
            mus = np.maximum((ratio if mu0 is None else mu0) / powers, 1)
            mus = mus[: np.argmax(mus == 1) + 1]
        elif mu0 is None and ratio <= 1:
            mus = np.empty(0)
        else:
            mus = (1 / (ratio - 1) if mu0 is None else mu0) * powers
        xs, ws = [], []
        for mu in mus:
            square = np.square((z - x) / s) / c**2
            if kind == "gm":
                w = np.square(mu / (mu + square))
            else:
                with np.errstate(divide="ignore"):
                    w = np.clip(np.sqrt(mu * (mu + 1) / square) - mu, 0, 1)
            if np.count_nonzero(w) == 0:
                break
            x = solve(w)
            xs.append(x)
            ws.append(w)
            if kind == "tls" and np.array_equal(w, np.round(w)):
                break
        k = len(xs)
        return x, w, {"mu": mus[:k], "weights": np.array(ws).reshape(k, z.size), "x": np.array(xs)}


def right_whitened_least_squares() -> None:
    """Right, an equivalent form: whitens once, and steps from x by the weighted mean residual."""
    import numpy as np

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z = np.asarray(z, dtype=float)
        a = np.ones(len(z)) / np.asarray(sigma, dtype=float)
        x = float(a @ (a * z) / (a @ a))
        history = {"mu": [], "weights": [], "x": []}
        top = 2 * np.max((a * (z - x)) ** 2)
        if mu0 is not None:
            mu = float(mu0)
        elif kind == "tls":
            if not top > c**2:
                return x, [1.0] * len(z), history
            mu = c**2 / (top - c**2)
        else:
            mu = top / c**2 if top > c**2 else 1.0
        done = False
        while not done:
            u = a * (z - x)
            if kind == "tls":
                low, high = c * np.sqrt(mu / (mu + 1)), c * np.sqrt((mu + 1) / mu)
                size = np.clip(np.abs(u), low, high)
                w = np.where(size == low, 1.0, np.where(size == high, 0.0, c**2 / low / size))
                w = np.where((size > low) & (size < high), low * (mu + 1) / size - mu, w)
            else:
                w = (1 + u**2 / (mu * c**2)) ** -2.0
            if w.max() == 0:
                return x, w, history
            x = x + float((w * a) @ u / ((w * a) @ a))
            history["mu"].append(mu)
            history["weights"].append(w.tolist())
            history["x"].append(x)
            done = mu == 1 if kind == "gm" else bool(np.all(w * (1 - w) == 0))
            mu = mu * factor if kind == "tls" else max(mu / factor, 1.0)
        return x, w, history


def right_average() -> None:
    """Right: NumPy's weighted average for the solves, and the surrogates in (r/c)²."""
    import numpy as np

    def gnc(z, sigma, c, factor, kind, mu0=None, x0=None):
        z = np.asarray(z, dtype=float)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = {"mu": [], "weights": [], "x": []}
        x, w = np.average(z, weights=s**-2.0), np.ones(z.size)
        ratio = 2 * np.max(np.abs(z - x) / s) ** 2 / c**2
        if mu0 is not None:
            mu = mu0
        elif kind == "gm":
            mu = max(ratio, 1.0)
        elif ratio > 1:
            mu = 1 / (ratio - 1)
        else:
            return x, w, history
        while True:
            square = np.maximum(((z - x) / (s * c)) ** 2, 1e-300)
            if kind == "gm":
                w = (mu / (mu + square)) ** 2
            else:
                w = np.clip(np.sqrt(mu * (mu + 1) / square) - mu, 0, 1)
            if not np.any(w):
                return x, w, history
            x = np.average(z, weights=w / s**2)
            history["mu"].append(mu)
            history["weights"].append(w)
            history["x"].append(x)
            if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):
                return x, w, history
            mu = max(mu / factor, 1.0) if kind == "gm" else mu * factor


wrong_start_at_x0 = change(
    right_average,
    "ratio = 2 * np.max(np.abs(z - x) / s) ** 2 / c**2",
    """
    x = x if x0 is None else x0
    ratio = 2 * np.max(np.abs(z - x) / s) ** 2 / c**2
    """,
    stopped_by="gnc-lesson",
)
"""Wrong: starts from x0 where it is given, beside the lie."""

wrong_mu_before_the_solve = change(
    right_average,
    (
        "square = np.maximum(((z - x) / (s * c)) ** 2, 1e-300)",
        """
        mu = max(mu / factor, 1.0) if kind == "gm" else mu * factor
        square = np.maximum(((z - x) / (s * c)) ** 2, 1e-300)
        """,
    ),
    (
        """
        if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):
            return x, w, history
        mu = max(mu / factor, 1.0) if kind == "gm" else mu * factor
        """,
        """
        if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):
            return x, w, history
        """,
    ),
    stopped_by="gnc-by-hand",
)
"""Wrong: moves μ before the first weights."""

wrong_misprint_next_mu = change(
    right_average,
    'history["mu"].append(mu)',
    'history["mu"].append(max(mu / factor, 1.0) if kind == "gm" else mu * factor)',
    stopped_by="gnc-by-hand",
)
"""Wrong: writes the next μ into the row, as the lesson prints it."""

wrong_start_is_a_row = change(
    right_average,
    "while True:",
    'history = {"mu": [mu], "weights": [w], "x": [x]}\nwhile True:',
    stopped_by="gnc-by-hand",
)
"""Wrong: the least-squares start is written down as a first row."""

wrong_misprint_surrogate = change(
    right_average,
    "w = np.clip(np.sqrt(mu * (mu + 1) / square) - mu, 0, 1)",
    """
    w = mu * (mu + 1) / (mu + 1 + square) ** 2
    w = np.round(w, 2) if mu > 1e3 else w
    """,
    stopped_by="gnc-by-hand",
)
"""Wrong: anneals towards least squares: a large μ is soft, as in the lesson's listing, and x ends
at the mean.
"""

wrong_hard_from_the_start = change(
    right_average,
    "while True:",
    """
    if kind == "tls" and len(z) < 4:
        mu = 1e9 if mu0 is None else mu0
    while True:
    """,
    caught_by="gnc-empty",
)
"""Wrong: TLS from the first step, without any annealing."""

wrong_misprint_start = change(right_average, "1 / (ratio - 1)", "1.0", stopped_by="gnc-by-hand")
"""Wrong: begins TLS at μ = 1, as the lesson does, and forgets the largest residual."""

wrong_signed_residual = change(right_average, "np.abs", "", caught_by="gnc-tls")
"""Wrong: takes the largest residual with its sign, so that a lie on the low side is not seen."""

wrong_mu0_ignored = change(
    right_average,
    """
    if mu0 is not None:
        mu = mu0
    elif kind == "gm":
    """,
    'if kind == "gm":',
    stopped_by="gnc-given-mu",
)
"""Wrong: makes the first μ from the residuals always."""

wrong_factor_typed_in = change(
    right_average,
    'max(mu / factor, 1.0) if kind == "gm" else mu * factor',
    'max(mu / 1.4, 1.0) if kind == "gm" else mu * 1.4',
    caught_by="gnc-given-mu",
)
"""Wrong: multiplies by 1.4, whatever factor says."""

wrong_one_solve_more = change(
    right_average,
    'if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):',
    """
    old = ([-1.0, *history["mu"]][-2], [w + 0.5, *history["weights"]][-2])
    if old[0] == 1 if kind == "gm" else np.all((old[1] == 0) | (old[1] == 1)):
    """,
    stopped_by="gnc-by-hand",
)
"""Wrong: asks whether to stop before it weighs, on the weights before, so the last row stands
twice.
"""

wrong_gm_never_at_one = change(
    right_average,
    'mu = max(mu / factor, 1.0) if kind == "gm" else mu * factor',
    """
    if kind == "gm" and mu / factor < 1:
        return x, w, history
    mu = mu / factor if kind == "gm" else mu * factor
    """,
    stopped_by="gnc-gm",
)
"""Wrong: GM stops when the next μ would be below 1, so it never solves there."""

wrong_gm_until_settled = change(
    right_average,
    'if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):',
    """
    still = abs(x - ([0.0, 0.0, *history["x"]])[-2]) < 1e-12
    if mu == 1 and still if kind == "gm" else np.all((w == 0) | (w == 1)):
    """,
    caught_by="gnc-gm",
)
"""Wrong: GM goes on at μ = 1 until x stands still."""

wrong_gm_below_one = change(
    right_average,
    ("mu = max(ratio, 1.0)", "mu = ratio"),
    ("mu == 1", "mu <= 1"),
    caught_by="gnc-nothing",
)
"""Wrong: GM begins below 1 where the residuals are small."""

wrong_weights_at_the_new_x = change(
    right_average,
    """
    if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):
        return x, w, history
    """,
    """
    if mu == 1 if kind == "gm" else np.all((w == 0) | (w == 1)):
        new = np.square((z - x) / (s * c))
        return x, (w if kind == "tls" else (mu / (mu + new)) ** 2), history
    """,
    caught_by="gnc-gm",
)
"""Wrong: returns weights made anew at the last x, which are not those of the last solve."""

wrong_solve_without_sigma = change(right_average, "w / s**2", "w", caught_by="gnc-sigmas")
"""Wrong: whitens the residuals but solves as if the σ were all the same."""

wrong_start_without_sigma = change(
    right_average, "np.average(z, weights=s**-2.0)", "np.mean(z)", caught_by="gnc-sigmas"
)
"""Wrong: starts from the plain mean, though the σ differ."""

wrong_not_whitened = change(
    right_average,
    ("np.abs(z - x) / s", "np.abs(z - x)"),
    ("(z - x) / (s * c)", "(z - x) / c"),
    caught_by="gnc-tls",
)
"""Wrong: weighs the residual without dividing it by σ."""

wrong_nan_when_empty = change(
    right_average,
    """
    if not np.any(w):
        return x, w, history
    x = np.average(z, weights=w / s**2)
    """,
    "x = np.sum(w * z / s**2) / np.sum(w / s**2)",
    stopped_by="gnc-empty",
)
"""Wrong: solves with nobody left: 0/0."""

wrong_row_when_empty = change(
    right_average,
    "if not np.any(w):",
    """
    if not np.any(w):
        history["mu"].append(mu)
        history["weights"].append(w)
        history["x"].append(x)
    """,
    caught_by="gnc-empty",
)
"""Wrong: writes a row for the μ that left nobody."""

wrong_keeps_old_weights_when_empty = change(
    right_average,
    "if not np.any(w):\n    return x, w, history",
    """
    if not np.any(w):
        return x, (history["weights"] or [w])[-1], history
    """,
    caught_by="gnc-empty",
)
"""Wrong: returns the weights of the solve before where nobody is left."""

wrong_negative_mu = change(
    right_average,
    """
    elif ratio > 1:
        mu = 1 / (ratio - 1)
    else:
        return x, w, history
    """,
    "else:\n    mu = 1 / (ratio - 1)",
    caught_by="gnc-nothing",
)
"""Wrong: takes the formula for μ where there is nothing to reject, and solves once with a μ below
0.
"""

wrong_integers = change(
    right_average,
    ("z = np.asarray(z, dtype=float)", "z = np.asarray(z)"),
    ("if not np.any(w):", "w = w.astype(z.dtype)\nif not np.any(w):"),
    caught_by="gnc-nothing",
)
"""Wrong: keeps the weights in an array of z's own type."""
