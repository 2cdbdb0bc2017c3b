"""Answers to exercise rho_cauchy of 02-four-costs: each body is a cell as handed in."""


def right_vectorised() -> None:
    """Right: the formulas as the chapter writes them."""
    import numpy as np

    def rho_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return c**2 / 2 * np.log(1 + u**2 / c**2)

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return u / (1 + u**2 / c**2)

    def w_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return 1 / (1 + u**2 / c**2)


def right_plain_loops() -> None:
    """Right: the math module, one number at a time, nested lists for nested lists."""
    import math

    def cauchy_each(rule, u):
        try:
            return [cauchy_each(rule, item) for item in u]
        except TypeError:
            return rule(u)

    def rho_cauchy(u, c):
        return cauchy_each(lambda v: c * c / 2 * math.log1p((v / c) ** 2), u)

    def psi_cauchy(u, c):
        return cauchy_each(lambda v: v * c * c / (c * c + v * v), u)

    def w_cauchy(u, c):
        return cauchy_each(lambda v: c * c / (c * c + v * v), u)


def right_hypotenuse() -> None:
    """Right, an equivalent formula: c² times the log of the hypotenuse of 1 and u/c."""
    import numpy as np

    def w_cauchy(u, c):
        return np.cos(np.arctan(np.asarray(u) / c)) ** 2

    def psi_cauchy(u, c):
        return np.multiply(u, w_cauchy(u, c))

    def rho_cauchy(u, c):
        return c * c * np.log(np.hypot(1, np.asarray(u) / c))


def right_library() -> None:
    """Right: SciPy's negative log density of the Cauchy distribution, less its value at 0."""
    import numpy as np
    from scipy.stats import cauchy

    def rho_cauchy(u, c):
        t = np.asarray(u) / c
        return c**2 / 2 * (cauchy.logpdf(0) - cauchy.logpdf(t))

    def psi_cauchy(u, c):
        return np.asarray(u) * cauchy.pdf(np.asarray(u) / c) * np.pi

    def w_cauchy(u, c):
        return cauchy.pdf(np.asarray(u) / c) * np.pi


def wrong_misprint() -> None:
    """Wrong: the lesson's 2.40 at u = 10 is ln(1 + u), without the square and without the ½.
    Stopped by the visible case rho_cauchy-by-hand.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return c**2 * np.log(1 + np.abs(u) / c)

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return u / (1 + (u / c) ** 2)

    def w_cauchy(u, c):
        return 1 / (1 + (np.asarray(u, dtype=float) / c) ** 2)


def wrong_residual_not_squared() -> None:
    """Wrong: takes the logarithm of 1 + |u|/c, which agrees with 1 + u²/c² at u = c alone. Caught
    by rho_cauchy-cost.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return c**2 / 2 * np.log(1 + np.abs(u) / c)

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return u / (1 + (u / c) ** 2)

    def w_cauchy(u, c):
        return 1 / (1 + (np.asarray(u, dtype=float) / c) ** 2)


def wrong_scale_missing() -> None:
    """Wrong for c other than 1: leaves out the c² before the logarithm. Caught by
    rho_cauchy-cost.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return np.log1p((np.asarray(u, dtype=float) / c) ** 2) / 2

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return u / (1 + (u / c) ** 2)

    def w_cauchy(u, c):
        return 1 / (1 + (np.asarray(u, dtype=float) / c) ** 2)


def wrong_chain_rule() -> None:
    """Wrong influence: forgets the inner derivative's 1/c², so that the c² does not cancel. Caught
    by rho_cauchy-influence.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return c**2 / 2 * np.log1p((np.asarray(u, dtype=float) / c) ** 2)

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return c**2 * u / (1 + (u / c) ** 2)

    def w_cauchy(u, c):
        return 1 / (1 + (np.asarray(u, dtype=float) / c) ** 2)


def wrong_weight_without_scale() -> None:
    """Wrong weight for large c: compares u² with c where it should be c². Stopped by the visible
    case rho_cauchy-weight.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return c**2 / 2 * np.log1p((np.asarray(u, dtype=float) / c) ** 2)

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return u / (1 + (u / c) ** 2)

    def w_cauchy(u, c):
        return 1 / (1 + np.asarray(u, dtype=float) ** 2 / c)


def wrong_nan_at_zero() -> None:
    """Wrong weight at 0: divides the influence by u as it stands, 0/0. Caught by
    rho_cauchy-weight.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return c**2 / 2 * np.log1p((np.asarray(u, dtype=float) / c) ** 2)

    def psi_cauchy(u, c):
        u = np.asarray(u, dtype=float)
        return u / (1 + (u / c) ** 2)

    def w_cauchy(u, c):
        return psi_cauchy(u, c) / np.asarray(u, dtype=float)


def wrong_influence_without_sign() -> None:
    """Wrong left of zero: takes |u| everywhere, and loses the direction of the pull. Caught by
    rho_cauchy-negative.
    """
    import numpy as np

    def rho_cauchy(u, c):
        return c**2 / 2 * np.log1p((np.abs(u) / c) ** 2)

    def psi_cauchy(u, c):
        return np.abs(u) / (1 + (np.abs(u) / c) ** 2)

    def w_cauchy(u, c):
        return 1 / (1 + (np.abs(u) / c) ** 2)


def wrong_lists() -> None:
    """Wrong for nested lists: goes through the outer list only. Caught by rho_cauchy-shapes."""
    import math

    def cauchy_each(rule, u):
        return [rule(v) for v in u] if hasattr(u, "__len__") else rule(u)

    def rho_cauchy(u, c):
        return cauchy_each(lambda v: c * c / 2 * math.log1p((v / c) ** 2), u)

    def psi_cauchy(u, c):
        return cauchy_each(lambda v: v / (1 + (v / c) ** 2), u)

    def w_cauchy(u, c):
        return cauchy_each(lambda v: 1 / (1 + (v / c) ** 2), u)
