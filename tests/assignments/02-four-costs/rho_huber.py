"""Answers to exercise rho_huber of 02-four-costs: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_where() -> None:
    """Right: both pieces of the cost over the whole array, chosen with np.where."""

    def rho_huber(u, k):
        size = np.abs(u)
        return np.where(size <= k, size**2 / 2, k * (size - k / 2))

    def psi_huber(u, k):
        return np.clip(u, -k, k)

    def w_huber(u, k):
        return k / np.maximum(np.abs(u), k)


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
    from scipy.special import huber

    def rho_huber(u, k):
        return huber(k, u)

    def psi_huber(u, k):
        return np.clip(u, -k, k)

    def w_huber(u, k):
        return np.minimum(1.0, k / np.maximum(np.abs(u), 1e-300))


def right_inner_part() -> None:
    """Right, an equivalent formula: with m = min(|u|, k) the cost is m(|u| - m/2)."""

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

    def rho_huber(u, k):
        return np.vectorize(lambda v: v**2 / 2 if abs(v) < k else k * (abs(v) - k / 2), [float])(u)

    def psi_huber(u, k):
        return np.vectorize(lambda v: v if abs(v) < k else np.sign(v) * k, [float])(u)

    def w_huber(u, k):
        return np.vectorize(lambda v: 1 if v == 0 else min(1, k / abs(v)), [float])(u)


wrong_sign = change(
    right_where,
    ("size = np.abs(u)", "size = np.asarray(u)"),
    ("np.clip(u, -k, k)", "np.minimum(u, k)"),
    ("np.maximum(np.abs(u), k)", "np.maximum(u, k)"),
    caught_by="rho_huber-negative",
)
"""Wrong left of zero: compares u with k, not |u|."""

wrong_jump_at_k = change(
    right_where, "k * (size - k / 2)", "k * (size - 0.5)", caught_by="rho_huber-cost"
)
"""Wrong for k other than 1: the line k(|u| - ½) meets the square at k = 1 alone."""

wrong_unit_influence = change(
    right_where,
    "np.clip(u, -k, k)",
    "np.where(np.abs(u) <= k, u, np.sign(u))",
    caught_by="rho_huber-influence",
)
"""Wrong influence past k: takes the sign of u for k times the sign."""

wrong_nan_at_zero = change(
    right_where,
    "k / np.maximum(np.abs(u), k)",
    "np.clip(u, -k, k) / np.asarray(u)",
    caught_by="rho_huber-weight",
)
"""Wrong weight at 0: divides the influence by u as it stands, 0/0."""

wrong_square_everywhere = change(
    right_where,
    ("np.where(size <= k, size**2 / 2, k * (size - k / 2))", "size**2 / 2"),
    ("np.clip(u, -k, k)", "u"),
    ("k / np.maximum(np.abs(u), k)", "np.ones(np.shape(u))"),
    stopped_by="rho_huber-by-hand",
)
"""Wrong past k: keeps the square, so that nothing is robust."""

wrong_integers = change(
    right_where,
    "k / np.maximum(np.abs(u), k)",
    "(k / np.maximum(np.abs(u), k)).astype(np.asarray(u).dtype)",
    caught_by="rho_huber-shapes",
)
"""Wrong for integers: puts the weights into an array of u's own type."""

wrong_flat = change(
    right_where,
    "size = np.abs(u)",
    "size = np.ravel(np.abs(u)) if np.ndim(u) else np.abs(u)",
    caught_by="rho_huber-shapes",
)
"""Wrong shape: returns one long row, whatever the shape of u."""
