"""Answers to exercise spoil of 09-capstone: each body is a cell as handed in."""


def right_permutation() -> None:
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
    """Right: one lie at a time, and the mask as a list."""
    import math

    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = [k for k, own in enumerate(graph["is_odometry"]) if not own]
        rows = [list(z) for z in graph["measurement"]]
        lies = {int(k) for k in rng.choice(loops, round(fraction * len(loops)), replace=False)}
        for k in sorted(lies):
            way, far = rng.uniform(-math.pi, math.pi), rng.uniform(5.0, 10.0)
            rows[k][0] += far * math.cos(way)
            rows[k][1] += far * math.sin(way)
            rows[k][2] = rng.uniform(-math.pi, math.pi)
        return {**graph, "measurement": np.array(rows)}, [k in lies for k in range(len(rows))]


def right_keys() -> None:
    """Right, an equivalent form: every closure draws a number, and those with the smallest lie;
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
        lie = graph["measurement"] + np.hstack(
            [way * rng.uniform(5, 10, (loop.size, 1)), way[:, :1]]
        )
        lie[:, 2] = rng.uniform(-np.pi, np.pi, loop.size)
        measurement = np.where(mask[:, None], lie, graph["measurement"])
        return {key: measurement if key == "measurement" else graph[key] for key in graph}, mask


def wrong_odometry_too() -> None:
    """Wrong: counts and draws among all edges. Stopped by the visible case spoil-form."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.ones(len(graph["edges"])))
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


def wrong_behind_the_odometry() -> None:
    """Wrong: takes the last edges for the closures, wherever these stand. Caught by
    spoil-rest.
    """
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.arange(len(graph["edges"])) >= np.sum(graph["is_odometry"]))
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


def wrong_cut_off() -> None:
    """Wrong: cuts the number of lies off in place of rounding it. Caught by spoil-count."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = rng.uniform(0, 2 * np.pi, count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_coin_for_each() -> None:
    """Wrong: tosses a coin for each closure, so that the number is right on average only. Caught
    by spoil-count.
    """
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = rng.binomial(loops.size, fraction)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = rng.uniform(0, 2 * np.pi, count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_always_the_first() -> None:
    """Wrong: spoils the first of the closures, not drawn ones. Caught by spoil-seed."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size + 0.5)
        chosen = loops[:count]
        measurement = np.array(graph["measurement"])
        way, far = rng.uniform(0, 2 * np.pi, count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_one_direction() -> None:
    """Wrong: all lies move the same way, and so agree with each other. Caught by spoil-wrong."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size + 0.5)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = np.full(count, rng.uniform(0, 2 * np.pi)), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_square_box() -> None:
    """Wrong: x and y drawn on their own from 5 m to 10 m, so that lies are longer than that and
    all point the same way. Caught by spoil-wrong.
    """
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size + 0.5)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = rng.uniform(0, 2 * np.pi, count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += rng.uniform(5, 7, count)
        measurement[chosen, 1] += rng.uniform(5, 7, count)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_angle_kept() -> None:
    """Wrong: the angle stays as it was measured. Caught by spoil-wrong."""
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
        measurement[chosen, 2] = 0.9 * measurement[chosen, 2]
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_whole_turns() -> None:
    """Wrong: angles from 0 to 2π, which are not within half a turn. Stopped by the visible case
    spoil-wrong.
    """
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
        measurement[chosen, 2] = rng.uniform(0, 2 * np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_honest_about_it() -> None:
    """Wrong: a spoiled closure claims less information, which gives it away. Stopped by the
    visible case spoil-rest.
    """
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
        return dict(
            graph,
            measurement=measurement,
            information=graph["information"] * np.where(mask, 0.1, 1.0)[:, None, None],
        ), mask


def wrong_seed_ignored() -> None:
    """Wrong: a generator without a seed. Stopped by the visible case spoil-seed."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng()
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


def wrong_two_directions() -> None:
    """Wrong: moves along x alone, forward or back. Caught by spoil-wrong."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size + 0.5)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = np.pi * rng.integers(2, size=count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask


def wrong_four_directions() -> None:
    """Wrong: moves along x or along y, never between. Caught by spoil-wrong."""
    import numpy as np

    def spoil(graph, fraction, seed):
        rng = np.random.default_rng(seed)
        loops = np.flatnonzero(np.logical_not(graph["is_odometry"]))
        count = int(fraction * loops.size + 0.5)
        chosen = rng.permutation(loops)[:count]
        measurement = np.array(graph["measurement"])
        way, far = np.pi / 2 * rng.integers(4, size=count), rng.uniform(5, 10, count)
        measurement[chosen, 0] += far * np.cos(way)
        measurement[chosen, 1] += far * np.sin(way)
        measurement[chosen, 2] = rng.uniform(-np.pi, np.pi, count)
        mask = np.zeros(len(measurement), dtype=bool)
        mask[chosen] = True
        return dict(graph, measurement=measurement), mask
