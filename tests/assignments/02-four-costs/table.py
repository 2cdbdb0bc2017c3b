"""Answers to exercise table of 02-four-costs: each body is a cell as handed in."""


def right_cell_by_cell() -> None:
    """Right: sixteen cells from scalar functions, as a list of rows."""
    import math

    def table(c):
        def square(u):
            return u * u / 2

        def huber(u):
            return u * u / 2 if u <= c else c * u - c * c / 2

        def cauchy(u):
            return c * c / 2 * math.log(1 + u * u / (c * c))

        def tls(u):
            return min(u, c) ** 2 / 2

        weights = [1, min(1, c / 10), 1 / (1 + 100 / c**2), 1 if c >= 10 else 0]
        return [
            [rho(1), rho(10), rho(10) / rho(1), w]
            for rho, w in zip([square, huber, cauchy, tls], weights)
        ]


def right_vectorised() -> None:
    """Right: columns of arrays, put side by side."""
    import numpy as np

    def table(c):
        def cost(u):
            huber = np.where(u <= c, u**2 / 2, c * (u - c / 2))
            return np.array(
                [u**2 / 2, huber, c**2 / 2 * np.log(1 + (u / c) ** 2), min(u, c) ** 2 / 2]
            )

        near, far = cost(1.0), cost(10.0)
        weight = np.array([1, c / max(10.0, c), 1 / (1 + (10 / c) ** 2), np.where(10 <= c, 1, 0)])
        return np.stack([near, far, far / near, weight], axis=1)


def right_library_without_half() -> None:
    """Right: SciPy's Huber function, and TLS on the lesson's scale, without the ½."""
    import numpy as np
    from scipy.special import huber

    def table(c):
        filled = np.empty((4, 4))
        for column, u in enumerate((1.0, 10.0)):
            filled[0, column] = u**2 / 2
            filled[1, column] = huber(c, u)
            filled[2, column] = c**2 * np.log(np.hypot(1, u / c))
            filled[3, column] = min(u**2, c**2)
        filled[:, 2] = filled[:, 1] / filled[:, 0]
        filled[:, 3] = 1, min(1, c / 10), np.cos(np.arctan(10 / c)) ** 2, 10 <= c
        return filled


def wrong_misprint() -> None:
    """Wrong: Cauchy's row typed from the lesson, 2.40 and 6.9. Caught by table-cauchy."""
    import numpy as np

    def table(c):
        u = np.array([1.0, 10.0])
        inner = np.minimum(u, c)
        cost = np.array([u**2 / 2, inner * (u - inner / 2), [0.347, 2.40], inner**2 / 2])
        weight = [1.0, min(1.0, c / 10), 0.0099, float(c >= 10)]
        filled = np.column_stack([cost, cost[:, 1] / cost[:, 0], weight])
        filled[2, 2] = 6.9
        return filled


def wrong_residual_not_squared() -> None:
    """Wrong: Cauchy's logarithm is of 1 + u/c, the lesson's slip as a formula. Caught by
    table-cauchy.
    """
    import numpy as np

    def table(c):
        u = np.array([1.0, 10.0])
        inner = np.minimum(u, c)
        cauchy = c**2 / 2 * np.log1p(u / c)
        cost = np.array([u**2 / 2, inner * (u - inner / 2), cauchy, inner**2 / 2])
        weight = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        return np.column_stack([cost, cost[:, 1] / cost[:, 0], weight])


def wrong_one_threshold_only() -> None:
    """Wrong: the table of c = 1 for every c, but for the weights. Caught by table-huber."""
    import numpy as np

    def table(c):
        cost = np.array([[0.5, 50], [0.5, 9.5], np.log([2, 101]) / 2, [0.5, 0.5]])
        weight = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        return np.column_stack([cost, cost[:, 1] / cost[:, 0], weight])


def wrong_one_is_always_inside() -> None:
    """Wrong for c below 1: takes 1 for an inlier and 10 for an outlier. Caught by table-small."""
    import numpy as np

    def table(c):
        cauchy = c**2 / 2 * np.log1p(np.array([1, 100]) / c**2)
        far = 50 if c > 10 else c * (10 - c / 2)
        cost = np.array([[0.5, 50], [0.5, far], cauchy, [0.5, min(c, 10) ** 2 / 2]])
        weight = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        return np.column_stack([cost, cost[:, 1] / cost[:, 0], weight])


def wrong_ten_is_always_outside() -> None:
    """Wrong for c above 10: takes 10 for an outlier whatever c is. Caught by table-large."""
    import numpy as np

    def table(c):
        u = np.array([1.0, 10.0])
        inner = np.array([min(c, 1.0), c])
        cost = np.array(
            [u**2 / 2, inner * (u - inner / 2), c**2 / 2 * np.log1p((u / c) ** 2), inner**2 / 2]
        )
        weight = [1.0, c / 10, 1 / (1 + (10 / c) ** 2), 0.0]
        return np.column_stack([cost, cost[:, 1] / cost[:, 0], weight])


def wrong_mixed_tls() -> None:
    """Wrong: TLS with the ½ in one column and without it in the other, the ratio kept from the
    same c. Caught by table-tls.
    """
    import numpy as np

    def table(c):
        u = np.array([1.0, 10.0])
        inner = np.minimum(u, c)
        cost = np.array(
            [u**2 / 2, inner * (u - inner / 2), c**2 / 2 * np.log1p((u / c) ** 2), inner**2 / 2]
        )
        ratio = cost[:, 1] / cost[:, 0]
        cost[3, 1] *= 2
        weight = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        return np.column_stack([cost, ratio, weight])


def wrong_ratio_upside_down() -> None:
    """Wrong: divides ρ(1) by ρ(10). Stopped by the visible case table-by-hand."""
    import numpy as np

    def table(c):
        u = np.array([1.0, 10.0])
        inner = np.minimum(u, c)
        cost = np.array(
            [u**2 / 2, inner * (u - inner / 2), c**2 / 2 * np.log1p((u / c) ** 2), inner**2 / 2]
        )
        weight = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        return np.column_stack([cost, cost[:, 0] / cost[:, 1], weight])


def wrong_integers() -> None:
    """Wrong for integer c: an array of the type of c cuts off the fractions. Caught by
    table-integer.
    """
    import numpy as np

    def table(c):
        filled = np.full((4, 4), c)
        for column, u in enumerate((1.0, 10.0)):
            inner = min(u, c)
            filled[:, column] = [
                u**2 / 2,
                inner * (u - inner / 2),
                c**2 / 2 * np.log1p((u / c) ** 2),
                inner**2 / 2,
            ]
        filled[:, 3] = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        filled[:, 2] = filled[:, 1] / filled[:, 0]
        return filled


def wrong_inside_from_fifty() -> None:
    """Wrong for tiny and for huge c: keeps c between 0.1 and 50. Caught by table-cauchy."""
    import numpy as np

    def table(c):
        c = np.clip(c, 0.1, 50.0)
        u = np.array([1.0, 10.0])
        inner = np.minimum(u, c)
        cost = [u**2 / 2, inner * (u - inner / 2), c**2 / 2 * np.log1p((u / c) ** 2), inner**2 / 2]
        weight = [1.0, min(1.0, c / 10), c**2 / (c**2 + 100), 1.0 if c >= 10 else 0.0]
        return np.column_stack([cost, np.divide(*np.transpose(cost)[::-1]), weight])
