"""Answers to exercise make_graph of 09-capstone: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_complex() -> None:
    """Right: round and round a circle, positions as complex numbers."""
    import numpy as np

    def make_graph(n, loops, noise, seed):
        rng = np.random.default_rng(seed)
        angle = 0.5 * np.arange(n)
        truth = np.column_stack([1.45 * np.sin(angle), 1.45 - 1.45 * np.cos(angle), angle])
        first, second = np.triu_indices(n, 2)
        drawn = rng.permutation(first.size)[:loops]
        steps = np.arange(n - 1)
        i = np.concatenate([steps, first[drawn]])
        j = np.concatenate([steps + 1, second[drawn]])
        m = i.size
        gap = (truth[j] - truth[i])[:, :2] @ [1, 1j] * np.exp(-1j * truth[i, 2])
        turn = truth[j, 2] - truth[i, 2]
        sigma = np.array([noise[0], noise[0], noise[1]])
        eta = rng.normal(0.0, sigma, (m, 3))
        bow = np.sinc(eta[:, 2] / np.pi) + 1j * np.sin(eta[:, 2] / 2) * np.sinc(
            eta[:, 2] / 2 / np.pi
        )
        place = gap + np.exp(1j * turn) * (eta[:, :2] @ [1, 1j]) * bow
        z = np.column_stack([place.real, place.imag, turn + eta[:, 2]])
        information = np.zeros((m, 3, 3))
        information[:, [0, 1, 2], [0, 1, 2]] = sigma**-2
        graph = {"n": n, "edges": np.column_stack([i, j]), "measurement": z}
        graph |= {"information": information, "is_odometry": np.arange(m) < n - 1}
        return graph, truth


def right_square_walk() -> None:
    """Right: round a square of 1 m steps, with matrices; draws closures until it has enough."""
    import numpy as np
    from scipy.linalg import expm

    def make_graph(n, loops, noise, seed):
        rng = np.random.default_rng(seed)
        pose, poses = np.eye(3), []
        quarter = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        for _ in range(n):
            poses.append(pose)
            pose = pose @ quarter
        pairs = [(k, k + 1) for k in range(n - 1)]
        while len(pairs) < n - 1 + loops:
            i, j = sorted(int(k) for k in rng.integers(0, n, 2))
            if j > i + 1 and (i, j) not in pairs:
                pairs.append((i, j))
        sigma = np.array([noise[0], noise[0], noise[1]])
        measured = []
        for i, j in pairs:
            x, y, turn = rng.normal(size=3) * sigma
            twist = np.array([[0, -turn, x], [turn, 0, y], [0, 0, 0]])
            z = np.linalg.inv(poses[i]) @ poses[j] @ expm(twist)
            measured.append([z[0, 2], z[1, 2], np.arctan2(z[1, 0], z[0, 0])])
        graph = {
            "n": n,
            "edges": np.array(pairs),
            "measurement": np.array(measured),
            "information": np.array([np.linalg.inv(np.diag(sigma**2))] * len(pairs)),
            "is_odometry": np.array([j == i + 1 for i, j in pairs]),
        }
        truth = [[p[0, 2], p[1, 2], np.arctan2(p[1, 0], p[0, 0])] for p in poses]
        return graph, truth


def right_se2() -> None:
    """Right: to and fro on a line, turning round at its ends, with the library's SE(2)."""
    import numpy as np
    from robust_slam.graphs import se2

    def make_graph(n, loops, noise, seed):
        rng = np.random.default_rng(seed)
        truth = np.array(
            [[[0.0, 1.0, 2.0, 1.0][k % 4], 0.0, np.pi * (k % 4 > 1)] for k in range(n)]
        )
        closures = [(i, j) for i in range(n) for j in range(i + 2, n)]
        chosen = [closures[k] for k in rng.choice(len(closures), loops, replace=False)]
        edges = np.array([(k, k + 1) for k in range(n - 1)] + chosen).reshape(-1, 2)
        seen = se2.between(truth[edges[:, 0]], truth[edges[:, 1]])
        covariance = np.diag([noise[0] ** 2, noise[0] ** 2, noise[1] ** 2])
        eta = rng.multivariate_normal(np.zeros(3), covariance, len(edges))
        information = np.broadcast_to(np.linalg.inv(covariance), (len(edges), 3, 3))
        z = se2.compose(seen, se2.exp(eta))
        return {
            "n": int(n),
            "edges": edges,
            "measurement": z,
            "information": information,
            "is_odometry": edges[:, 1] - edges[:, 0] == 1,
        }, truth


wrong_covariance = change(right_complex, "**-2", "**2", stopped_by="make_graph-information")
"""Wrong: the covariance where the information belongs."""

wrong_root_of_the_information = change(
    right_complex, "sigma**-2", "1 / sigma", stopped_by="make_graph-information"
)
"""Wrong: one over σ in place of one over its square."""

wrong_variance_drawn = change(right_complex, "sigma,", "sigma**2,", caught_by="make_graph-noise")
"""Wrong: draws with the variance where the standard deviation belongs."""

wrong_noise_on_the_left = change(
    right_complex,
    "gap + np.exp(1j * turn) * (eta[:, :2] @ [1, 1j]) * bow",
    "(eta[:, :2] @ [1, 1j]) * bow + np.exp(1j * eta[:, 2]) * gap",
    caught_by="make_graph-noise",
)
"""Wrong: the noise comes before the step, Exp(η) ∘ (x_i⁻¹ ∘ x_j), and turns all of it."""

wrong_exact_odometry = change(
    right_complex,
    "rng.normal(0.0, sigma, (m, 3))",
    "rng.normal(0.0, sigma, (m, 3)) * (np.arange(m) >= n - 1)[:, None]",
    caught_by="make_graph-noise",
)
"""Wrong: noise on the closures alone."""

wrong_one_draw_for_all = change(
    right_complex,
    "rng.normal(0.0, sigma, (m, 3))",
    "np.tile(rng.normal(0.0, sigma, 3), (m, 1))",
    caught_by="make_graph-noise",
)
"""Wrong: draws one noise, and every edge has it."""

wrong_uniform_noise = change(
    right_complex,
    "rng.normal(0.0, sigma, (m, 3))",
    "sigma * rng.uniform(-1, 1, (m, 3))",
    caught_by="make_graph-noise",
)
"""Wrong: evenly drawn between −σ and σ, which is too little."""

wrong_backward = change(
    right_complex,
    ("truth[j] - truth[i]", "truth[i] - truth[j]"),
    ("-1j * truth[i, 2]", "-1j * truth[j, 2]"),
    ("truth[j, 2] - truth[i, 2]", "truth[i, 2] - truth[j, 2]"),
    stopped_by="make_graph-noise",
)
"""Wrong: measures pose i as seen from pose j."""

wrong_seed_ignored = change(right_complex, "(seed)", "()", stopped_by="make_graph-seed")
"""Wrong: a generator without a seed."""

wrong_one_seed_for_all = change(right_complex, "(seed)", "(0)", caught_by="make_graph-seed")
"""Wrong: a seed of its own, always the same."""

wrong_far_away = change(
    right_complex,
    "[1.45 * np.sin(angle), 1.45 - 1.45 * np.cos(angle), angle]",
    "[2.9 * np.sin(angle), 2.9 - 2.9 * np.cos(angle), angle]",
    caught_by="make_graph-way",
)
"""Wrong: a circle of twice the size, whose closures span it."""

wrong_pairs_twice = change(
    right_complex,
    "rng.permutation(first.size)[:loops]",
    "rng.integers(0, first.size, loops)",
    caught_by="make_graph-way",
)
"""Wrong: draws closures with replacement, so that some pairs stand twice."""

wrong_uniform_noise_of_the_right_size = change(
    right_complex,
    "rng.normal(0.0, sigma, (m, 3))",
    "sigma * np.sqrt(3) * rng.uniform(-1, 1, (m, 3))",
    caught_by="make_graph-noise",
)
"""Wrong: evenly drawn with standard deviation σ, which is not normal."""

wrong_one_draw_for_three = change(
    right_complex,
    "rng.normal(0.0, sigma, (m, 3))",
    "sigma * rng.normal(size=(m, 1)) * np.ones(3)",
    caught_by="make_graph-noise",
)
"""Wrong: one number an edge is the noise of all its three components."""

wrong_closures_at_the_start = change(
    right_complex, "triu_indices(n, 2)", "triu_indices(min(n, 25), 2)", caught_by="make_graph-way"
)
"""Wrong: draws its closures among the first 25 poses, where there are too few pairs."""
