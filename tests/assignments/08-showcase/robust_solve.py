"""Answers to exercise robust_solve of 08-showcase: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_pieces() -> None:
    """Right: the three pieces of the weight by np.where."""
    import numpy as np

    def robust_solve(graph, c, solve):
        is_odometry = np.asarray(graph["is_odometry"], dtype=bool)
        weights = np.ones(is_odometry.size)
        poses, u = solve(graph, weights, None)
        u = np.asarray(u)
        worst = np.max(u[~is_odometry], initial=0.0)
        if 2 * worst**2 <= c**2:
            return poses, weights
        mu = c**2 / (2 * worst**2 - c**2)
        for _ in range(1000):
            low, high = mu / (mu + 1) * c**2, (mu + 1) / mu * c**2
            middle = c / np.maximum(u, 1e-300) * np.sqrt(mu * (mu + 1)) - mu
            new = np.where(u**2 <= low, 1.0, np.where(u**2 >= high, 0.0, middle))
            weights = np.where(is_odometry, 1.0, new)
            poses, u = solve(graph, weights, poses)
            u = np.asarray(u)
            if np.all((weights == 0) | (weights == 1)):
                break
            mu *= 1.4
        return poses, weights


def right_one_by_one() -> None:
    """Right: plain Python, one closure at a time, lists for arrays."""
    import math

    def robust_solve(graph, c, solve):
        trusted = [bool(own) for own in graph["is_odometry"]]
        weights = [1.0] * len(trusted)
        poses, u = solve(graph, weights, None)
        squares = [2 * float(v) ** 2 for v, own in zip(u, trusted) if not own]
        if not squares or max(squares) <= c * c:
            return poses, weights
        mu = c * c / (max(squares) - c * c)
        while True:
            for k, own in enumerate(trusted):
                if own:
                    continue
                square = float(u[k]) ** 2
                if square <= mu / (mu + 1) * c * c:
                    weights[k] = 1.0
                elif square >= (mu + 1) / mu * c * c:
                    weights[k] = 0.0
                else:
                    weights[k] = c / math.sqrt(square) * math.sqrt(mu * (mu + 1)) - mu
            poses, u = solve(graph, weights, poses)
            if set(weights) <= {0.0, 1.0}:
                return poses, weights
            mu = 1.4 * mu


def right_counted_mu() -> None:
    """Right, an equivalent form: μ is a power of the step's number, and the weight is clipped."""
    import itertools

    import numpy as np

    def robust_solve(graph, c, solve):
        loops = np.flatnonzero(~graph["is_odometry"])
        weights = np.ones(len(graph["is_odometry"]))
        poses, norms = solve(graph, weights.copy(), None)
        u = np.array(norms)[loops] / c
        if loops.size == 0 or np.max(u) <= np.sqrt(0.5):
            return poses, weights
        first = 1 / (2 * np.max(u) ** 2 - 1)
        for step in itertools.count():
            mu = first * 1.4**step
            with np.errstate(divide="ignore"):
                weights[loops] = np.clip(np.sqrt(mu * (mu + 1)) / u - mu, 0.0, 1.0)
            poses, norms = solve(graph, weights.copy(), poses)
            u = np.array(norms)[loops] / c
            if np.isin(weights, (0.0, 1.0)).all():
                return poses, weights


wrong_odometry_doubted = change(
    right_pieces, "np.where(is_odometry, 1.0, new)", "new", stopped_by="robust_solve-map"
)
"""Wrong: weighs the odometry like the closures."""

wrong_start_by_all_norms = change(
    right_pieces, "u[~is_odometry]", "u", stopped_by="robust_solve-trust"
)
"""Wrong: the odometry's norms too decide whether there is something to reject."""

wrong_mu_before_the_solve = change(
    right_pieces, "c**2 /", "1.4 * c**2 /", stopped_by="robust_solve-by-hand"
)
"""Wrong: multiplies μ before the first solve with it."""

wrong_c_for_its_square = change(
    right_pieces,
    "mu / (mu + 1) * c**2, (mu + 1) / mu * c**2",
    "mu / (mu + 1) * c, (mu + 1) / mu * c",
    stopped_by="robust_solve-by-hand",
)
"""Wrong: c where its square belongs, in the knees of the weight."""

wrong_no_middle_piece = change(
    right_pieces,
    "c / np.maximum(u, 1e-300) * np.sqrt(mu * (mu + 1)) - mu",
    "0.0",
    stopped_by="robust_solve-by-hand",
)
"""Wrong: keeps or rejects at once, without the piece between."""

wrong_factor = change(right_pieces, "mu *= 1.4", "mu *= 2", caught_by="robust_solve-rows")
"""Wrong: μ grows by 2."""

wrong_stale_start = change(right_pieces, ", poses", ", None", caught_by="robust_solve-map")
"""Wrong: begins every solve afresh, from no poses."""

wrong_stops_when_converged_once = change(
    right_pieces,
    (
        "poses, u = solve(graph, weights, poses)",
        "before, (poses, u) = poses, solve(graph, weights, poses)",
    ),
    ("break", "return before, weights"),
    stopped_by="robust_solve-by-hand",
)
"""Wrong: the poses of the solve before the last."""

wrong_plain_tls = change(
    right_pieces,
    ("mu = c**2 / (2 * worst**2 - c**2)", "mu = 1e9"),
    ("mu *= 1.4", "mu = 1e9"),
    stopped_by="robust_solve-by-hand",
)
"""Wrong: no graduation: rejects what is past c from the least-squares fit on."""

wrong_misprint_surrogate = change(
    right_pieces,
    (
        "new = np.where(u**2 <= low, 1.0, np.where(u**2 >= high, 0.0, middle))",
        "new = mu * (mu + 1) / (mu + 1 + u**2 / c**2) ** 2",
    ),
    ("np.all((weights == 0) | (weights == 1))", "np.allclose(weights, 1.0, rtol=1e-3)"),
    stopped_by="robust_solve-by-hand",
)
"""Wrong: the weight of the lesson's surrogate, which ends at least squares, outliers and all."""

wrong_misprint_start = change(
    right_pieces, "c**2 / (2 * worst**2 - c**2)", "1.0", stopped_by="robust_solve-by-hand"
)
"""Wrong: starts at μ = 1, as the lesson does, whatever the largest norm is."""

wrong_never_nothing = change(
    right_pieces, "2 * worst**2 <= c**2", "worst == 0", caught_by="robust_solve-nothing"
)
"""Wrong: no look at whether there is something to reject, and μ is negative."""

wrong_twenty_solves = change(right_pieces, "(1000)", "(20)", caught_by="robust_solve-rows")
"""Wrong: stops after twenty solves, though an outlier may be far away."""
