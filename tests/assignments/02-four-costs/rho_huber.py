"""Answers to exercise rho_huber of 02-four-costs: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_where() -> None:
    """Right: both pieces over the whole array, chosen with np.where."""
    import numpy as np

    def rho_huber(u, k):
        u = np.abs(np.asarray(u, dtype=float))
        return np.where(u <= k, u**2 / 2, k * (u - k / 2))

    def psi_huber(u, k):
        u = np.asarray(u, dtype=float)
        return np.where(np.abs(u) <= k, u, k * np.sign(u))

    def w_huber(u, k):
        size = np.abs(np.asarray(u, dtype=float))
        with np.errstate(divide="ignore"):
            return np.where(size <= k, 1.0, k / size)


def right_plain_loops() -> None:
    """Right: plain Python, nested lists for nested lists and floats for numbers."""

    def huber_each(rule, u):
        if hasattr(u, "__len__"):
            return [huber_each(rule, item) for item in u]
        return rule(u)

    def rho_huber(u, k):
        return huber_each(lambda v: v * v / 2 if abs(v) <= k else k * abs(v) - k * k / 2, u)

    def psi_huber(u, k):
        return huber_each(lambda v: max(-k, min(k, v)), u)

    def w_huber(u, k):
        return huber_each(lambda v: 1 if abs(v) <= k else k / abs(v), u)


def right_library() -> None:
    """Right: SciPy's Huber function, a clip, and a quotient that cannot divide by zero."""
    import numpy as np
    from scipy.special import huber

    def rho_huber(u, k):
        return huber(k, u)

    def psi_huber(u, k):
        return np.clip(u, -k, k)

    def w_huber(u, k):
        return np.minimum(1.0, k / np.maximum(np.abs(u), 1e-300))


def right_inner_part() -> None:
    """Right, an equivalent formula: with m = min(|u|, k) the cost is m(|u| - m/2)."""
    import numpy as np

    def inner_part(u, k):
        u = np.array(u, dtype=float)
        return u, np.minimum(np.abs(u), k)

    def rho_huber(u, k):
        u, m = inner_part(u, k)
        return m * (abs(u) - 0.5 * m)

    def psi_huber(u, k):
        u, m = inner_part(u, k)
        return np.copysign(m, u)

    def w_huber(u, k):
        u, m = inner_part(u, k)
        return np.divide(m, abs(u), out=np.ones_like(u), where=u != 0)


def right_vectorised_scalars() -> None:
    """Right: one number at a time under np.vectorize, with a float as output type."""
    import numpy as np

    def rho_huber(u, k):
        return np.vectorize(lambda v: v**2 / 2 if abs(v) < k else k * (abs(v) - k / 2), [float])(u)

    def psi_huber(u, k):
        return np.vectorize(lambda v: v if abs(v) < k else np.sign(v) * k, [float])(u)

    def w_huber(u, k):
        return np.vectorize(lambda v: 1 if v == 0 else min(1, k / abs(v)), [float])(u)


def wrong_sign() -> None:
    """Wrong left of zero: compares u with k, not |u|. Caught by rho_huber-negative."""
    import numpy as np

    def rho_huber(u, k):
        u = np.asarray(u, dtype=float)
        return np.where(u <= k, u**2 / 2, k * (u - k / 2))

    def psi_huber(u, k):
        return np.minimum(u, k)

    def w_huber(u, k):
        return k / np.maximum(np.asarray(u, dtype=float), k)


def wrong_jump_at_k() -> None:
    """Wrong for k other than 1: the line k(|u| - ½) meets the square at k = 1 alone and jumps at
    every other k. Caught by rho_huber-cost.
    """
    import numpy as np

    def rho_huber(u, k):
        u = np.abs(np.asarray(u, dtype=float))
        return np.where(u <= k, u**2 / 2, k * (u - 0.5))

    def psi_huber(u, k):
        return np.clip(np.asarray(u, dtype=float), -k, k)

    def w_huber(u, k):
        return k / np.maximum(np.abs(np.asarray(u, dtype=float)), k)


wrong_unit_influence = change(
    right_where,
    ("k * np.sign(u)", "np.sign(u)"),
    (
        """
        size = np.abs(np.asarray(u, dtype=float))
        with np.errstate(divide="ignore"):
            return np.where(size <= k, 1.0, k / size)
        """,
        "return k / np.maximum(np.abs(np.asarray(u, dtype=float)), k)",
    ),
    caught_by="rho_huber-influence",
)
"""Wrong influence past k: takes the sign of u for k times the sign."""


def wrong_nan_at_zero() -> None:
    """Wrong weight at 0: divides the influence by u as it stands, 0/0. Caught by
    rho_huber-weight.
    """
    import numpy as np

    def rho_huber(u, k):
        u = np.abs(np.asarray(u, dtype=float))
        return np.where(u <= k, u**2 / 2, k * (u - k / 2))

    def psi_huber(u, k):
        return np.clip(np.asarray(u, dtype=float), -k, k)

    def w_huber(u, k):
        u = np.asarray(u, dtype=float)
        return np.clip(u, -k, k) / u


wrong_square_everywhere = change(
    right_library,
    ("import numpy as np\nfrom scipy.special import huber", "import numpy as np"),
    ("return huber(k, u)", "return np.square(u) / 2"),
    ("return np.clip(u, -k, k)", "return u"),
    ("return np.minimum(1.0, k / np.maximum(np.abs(u), 1e-300))", "return np.ones(np.shape(u))"),
    stopped_by="rho_huber-by-hand",
)
"""Wrong past k: keeps the square, so that nothing is robust."""


def wrong_integers() -> None:
    """Wrong for integers: fills an array of u's own type, which cuts off the fractions. Caught by
    rho_huber-shapes.
    """
    import numpy as np

    def like_u(u, values):
        filled = np.zeros_like(u)
        filled[...] = values
        return filled

    def rho_huber(u, k):
        size = np.abs(u)
        return like_u(u, np.where(size <= k, size**2 / 2, k * (size - k / 2)))

    def psi_huber(u, k):
        return like_u(u, np.clip(u, -k, k))

    def w_huber(u, k):
        return like_u(u, k / np.maximum(np.abs(u), k))


def wrong_flat() -> None:
    """Wrong shape: returns one long row, whatever the shape of u. Caught by rho_huber-shapes."""
    import numpy as np

    def as_row(u, values):
        return values if np.ndim(u) == 0 else np.ravel(values)

    def rho_huber(u, k):
        size = np.abs(np.asarray(u, dtype=float))
        return as_row(u, np.where(size <= k, size**2 / 2, k * (size - k / 2)))

    def psi_huber(u, k):
        return as_row(u, np.clip(np.asarray(u, dtype=float), -k, k))

    def w_huber(u, k):
        return as_row(u, k / np.maximum(np.abs(np.asarray(u, dtype=float)), k))
