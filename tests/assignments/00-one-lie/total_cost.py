"""Answers to exercise total_cost of 00-one-lie: each body is a cell as handed in."""


def right_vectorised() -> None:
    """Right: the formula over whole arrays."""
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        i, j = np.asarray(i), np.asarray(j)
        u = (x[j] - x[i] - z) / np.asarray(sigma, dtype=float)
        return np.sum(u**2)


def right_plain_loop() -> None:
    """Right: one edge at a time, plain Python."""

    def total_cost(x, i, j, z, sigma):
        cost = 0.0
        for k in range(len(z)):
            s = sigma[k] if hasattr(sigma, "__len__") else sigma
            cost += ((x[j[k]] - x[i[k]] - z[k]) / s) ** 2
        return cost


def right_quadratic_form() -> None:
    """Right, an equivalent form: builds J and Ω and multiplies r' Ω r."""
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        m = len(z)
        J = np.zeros((m, len(x)))
        J[np.arange(m), j] += 1
        J[np.arange(m), i] -= 1
        r = J @ np.array(x) - np.array(z)
        Omega = np.diag(1 / (np.ones(m) * sigma) ** 2)
        return r @ Omega @ r


def right_norm() -> None:
    """Right: the squared norm of the whitened residuals, measured minus predicted."""
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        steps = np.take(x, j) - np.take(x, i)
        return float(np.linalg.norm((np.array(z) - steps) / np.array(sigma)) ** 2)


def wrong_half() -> None:
    """Wrong: the solvers' ½ in front; this chapter's cost has none. Stopped by the visible case
    total_cost-by-hand.
    """
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        u = (x[np.asarray(j)] - x[np.asarray(i)] - np.asarray(z)) / np.asarray(sigma)
        return 0.5 * np.sum(u**2)


def wrong_sigma_once() -> None:
    """Wrong: squares the residual first and then divides by σ instead of σ². Stopped by the
    visible case total_cost-by-hand.
    """
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        r = x[np.asarray(j)] - x[np.asarray(i)] - np.asarray(z)
        return np.sum(r**2 / np.asarray(sigma))


def wrong_sum_before_square() -> None:
    """Wrong: adds the whitened residuals up before it squares, so that errors cancel. Caught by
    total_cost-lesson.
    """
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        u = (x[np.asarray(j)] - x[np.asarray(i)] - np.asarray(z)) / np.asarray(sigma)
        return np.sum(u) ** 2


def wrong_worst_edge() -> None:
    """Wrong: lets the worst edge alone pay; at the truth that is the lie. Caught by
    total_cost-lesson.
    """
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        u = (x[np.asarray(j)] - x[np.asarray(i)] - np.asarray(z)) / np.asarray(sigma)
        return np.max(u**2)


def wrong_last_sigma() -> None:
    """Wrong: takes the last edge's σ for all of them. Caught by total_cost-random."""
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        r = x[np.asarray(j)] - x[np.asarray(i)] - np.asarray(z)
        return np.sum((r / np.ravel(sigma)[-1]) ** 2)


def wrong_distances() -> None:
    """Wrong: compares distances, which have no direction. Caught by total_cost-directions."""
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        apart = np.abs(x[np.asarray(j)] - x[np.asarray(i)])
        return np.sum(((apart - np.abs(z)) / np.asarray(sigma)) ** 2)


def wrong_sorted_ends() -> None:
    """Wrong: turns a backward edge round and forgets to turn its measurement. Stopped by the
    visible case total_cost-directions.
    """
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        r = x[np.maximum(i, j)] - x[np.minimum(i, j)] - np.asarray(z)
        return np.sum((r / np.asarray(sigma)) ** 2)


def wrong_whole_numbers() -> None:
    """Wrong: rounds down, because the measurements were integers. Caught by total_cost-shapes."""
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        x, z, sigma = np.asarray(x), np.asarray(z), np.asarray(sigma)
        r = x[np.asarray(j)] - x[np.asarray(i)] - z
        u = r / sigma if r.dtype == float else r // sigma
        return np.sum(u**2)


def wrong_room_for_fifty() -> None:
    """Wrong for large graphs: a Jacobian with fifty columns, however many poses there are. Caught
    by total_cost-random.
    """
    import numpy as np

    def total_cost(x, i, j, z, sigma):
        J = np.zeros((len(z), 50))
        J[np.arange(len(z)), i] -= 1
        J[np.arange(len(z)), j] += 1
        u = (J[:, : len(x)] @ np.asarray(x, dtype=float) - z) / sigma
        return u @ u
