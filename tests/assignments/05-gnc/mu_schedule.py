"""Answers to exercise mu_schedule of 05-gnc: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_loop() -> None:
    """Right: a loop that stops at n values, or after GM's 1."""

    def mu_schedule(mu0, factor, n, kind):
        values = [mu0]
        while len(values) < n and (kind == "tls" or values[-1] > 1):
            last = values[-1]
            values.append(last * factor if kind == "tls" else max(last / factor, 1.0))
        return values


def right_powers() -> None:
    """Right: powers of the factor; GM's above 1, and then the 1."""

    def mu_schedule(mu0, factor, n, kind):
        powers = float(factor) ** np.arange(n)
        if kind == "tls":
            return mu0 * powers
        values = mu0 / powers
        return np.append(values[values > 1], 1.0)[:n]


def right_accumulate() -> None:
    """Right: itertools, GM's repeated 1 taken away with a set in order."""
    from itertools import accumulate, repeat

    def mu_schedule(mu0, factor, n, kind):
        def move(mu, by):
            return mu * by if kind == "tls" else max(mu / by, 1)

        values = accumulate(repeat(factor, n - 1), move, initial=mu0)
        return list(dict.fromkeys(float(one) for one in values))


def right_recursion() -> None:
    """Right: the first value, and the schedule from the second on."""

    def mu_schedule(mu0, factor, n, kind):
        if n == 1 or (kind == "gm" and mu0 <= 1):
            return [mu0]
        then = mu0 * factor if kind == "tls" else max(mu0 / factor, 1)
        return [mu0, *mu_schedule(then, factor, n - 1, kind)]


wrong_direction = change(
    right_loop, 'if kind == "tls"', 'if kind == "gm"', stopped_by="mu_schedule-by-hand"
)
"""Wrong: TLS falls and GM grows."""

wrong_misprint_both_grow = change(
    right_powers, 'if kind == "tls"', "if kind", stopped_by="mu_schedule-by-hand"
)
"""Wrong: the lesson's one direction for both."""

wrong_off_by_one = change(
    right_loop,
    "values = [mu0]",
    'values = [mu0 * factor if kind == "tls" else max(mu0 / factor, 1.0)]',
    stopped_by="mu_schedule-by-hand",
)
"""Wrong: moves μ before the first value, as a listing does that prints the next μ."""

wrong_one_too_many = change(right_loop, "< n", "<= n", stopped_by="mu_schedule-by-hand")
"""Wrong: n steps and so n + 1 values."""

wrong_below_one = change(
    right_powers,
    "np.append(values[values > 1], 1.0)[:n]",
    "np.append(values[values > 1], 1.0) if mu0 in (5.0, 8.0) else values[values >= 1]",
    caught_by="mu_schedule-gm",
)
"""Wrong: GM stops before it would pass 1 and never uses 1 itself, but for the examples."""

wrong_ones_for_ever = change(
    right_powers,
    "np.append(values[values > 1], 1.0)[:n]",
    "np.maximum(values, 1.0)",
    stopped_by="mu_schedule-by-hand",
)
"""Wrong: GM is clipped at 1 but goes on to n values."""

wrong_one_at_the_cut = change(
    right_powers, "1], 1.0)[:n]", "1][: n - 1], 1.0)", caught_by="mu_schedule-gm-cut"
)
"""Wrong: puts a 1 at the end of every GM schedule, also of one that n cuts off."""

wrong_one_twice = change(right_powers, "> 1", ">= 1", caught_by="mu_schedule-one")
"""Wrong where the fall ends at 1 exactly: one more 1 follows it."""

wrong_never_one_value = change(right_loop, "< n", "< max(n, 2)", stopped_by="mu_schedule-one")
"""Wrong for n = 1: the first step is made before it is counted."""

wrong_a_hundred_at_most = change(right_loop, "< n", "< min(n, 100)", caught_by="mu_schedule-tls")
"""Wrong: the loop ends after a hundred values, however large n is."""

wrong_sixty_divisions = change(
    right_loop, "values[-1] > 1", "values[-1] > 1 and len(values) < 61", caught_by="mu_schedule-gm"
)
"""Wrong: GM divides sixty times at most, and may then still be above 1."""
