"""Answers to exercise spoil of 09-capstone: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_order() -> None:
    """Right: the first of the closures in a random order."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size + 0.5)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = rng.uniform(0, 2 * np.pi, count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def right_plain_loop() -> None:
    """Right: one outlier at a time, and the mask as a list."""
    import math

    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = [k for k, own in enumerate(graph["is_odometry"]) if not own]
        rows = [list(z) for z in graph["measurement"]]
        count = round(fraction * len(loops))
        outliers = {int(k) for k in rng.choice(loops, count, replace=False)}
        for k in sorted(outliers):
            way, far = rng.uniform(-math.pi, math.pi), rng.uniform(5.0, 10.0)
            rows[k][0] += far * math.cos(way)
            rows[k][1] += far * math.sin(way)
            rows[k][2] = rng.uniform(-math.pi, math.pi)
        return {**graph, "measurement": np.array(rows)}, [k in outliers for k in range(len(rows))]


def right_keys() -> None:
    """Right, an equivalent form: every closure draws a number, and the smallest are outliers;
    directions are normal vectors made one long.
    """
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loop = ~graph["is_odometry"]
        key = np.where(loop, rng.random(loop.size), np.inf)
        mask = np.argsort(np.argsort(key)) < np.rint(fraction * np.sum(loop))
        way = rng.normal(size=(loop.size, 2))
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        moved = graph["measurement"] + np.hstack(
            [way * rng.uniform(5, 10, (loop.size, 1)), way[:, :1]]
        )
        moved[:, 2] = rng.uniform(-np.pi, np.pi, loop.size)
        measurement = np.where(mask[:, None], moved, graph["measurement"])
        return {key: measurement if key == "measurement" else graph[key] for key in graph}, mask


wrong_odometry_too = change(
    right_order,
    'np.logical_not(graph["is_odometry"])',
    'np.ones(len(graph["edges"]))',
    stopped_by="spoil-form",
)
"""Wrong: counts and draws among all edges."""

wrong_behind_the_odometry = change(
    right_order, ".logical_not", '.arange(len(graph["edges"])) >= np.sum', caught_by="spoil-rest"
)
"""Wrong: takes the last edges for the closures, wherever these stand."""

wrong_cut_off = change(right_order, ".size + 0.5", ".size", caught_by="spoil-count")
"""Wrong: cuts the number of outliers off in place of rounding it."""

wrong_coin_for_each = change(
    right_order,
    "int(fraction * loops.size + 0.5)",
    "rng.binomial(loops.size, fraction)",
    caught_by="spoil-count",
)
"""Wrong: tosses a coin for each closure, so that the number is right on average only."""

wrong_always_the_first = change(
    right_order, "rng.permutation(loops)", "loops", caught_by="spoil-seed"
)
"""Wrong: spoils the first of the closures, not drawn ones."""

wrong_one_direction = change(
    right_order,
    "rng.uniform(0, 2 * np.pi, count)",
    "np.full(count, rng.uniform(0, 2 * np.pi))",
    caught_by="spoil-wrong",
)
"""Wrong: all outliers move the same way, and so agree with each other."""

wrong_square_box = change(
    right_order,
    ("far * np.cos(way)", "rng.uniform(5, 7, count)"),
    ("far * np.sin(way)", "rng.uniform(5, 7, count)"),
    caught_by="spoil-wrong",
)
"""Wrong: x and y move by 5 m to 7 m each, so that all outliers point the same way."""

wrong_angle_kept = change(
    right_order,
    "rng.uniform(-np.pi, np.pi, count)",
    "0.9 * measurement[chosen, 2]",
    caught_by="spoil-wrong",
)
"""Wrong: the angle stays as it was measured."""

wrong_whole_turns = change(right_order, "-np.pi, np.pi", "0, 2 * np.pi", stopped_by="spoil-wrong")
"""Wrong: angles from 0 to 2π, which are not within half a turn."""

wrong_honest_about_it = change(
    right_order,
    "return dict(graph,",
    """
    information = graph["information"] * np.where(mask, 0.1, 1.0)[:, None, None]
    return dict(graph, information=information,
    """,
    stopped_by="spoil-rest",
)
"""Wrong: a spoiled closure claims less information, which gives it away."""

wrong_seed_ignored = change(right_order, "(seed)", "()", stopped_by="spoil-seed")
"""Wrong: a generator without a seed."""

wrong_two_directions = change(
    right_order,
    "rng.uniform(0, 2 * np.pi, count)",
    "np.pi * rng.integers(2, size=count)",
    caught_by="spoil-wrong",
)
"""Wrong: moves along x alone, forward or back."""

wrong_four_directions = change(
    right_order,
    "rng.uniform(0, 2 * np.pi, count)",
    "np.pi / 2 * rng.integers(4, size=count)",
    caught_by="spoil-wrong",
)
"""Wrong: moves along x or along y, never between."""
