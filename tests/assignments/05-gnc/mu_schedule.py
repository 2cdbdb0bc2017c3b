"""Answers to exercise mu_schedule of 05-gnc: each body is a cell as handed in."""


def right_loop() -> None:
    """Right: a loop that stops at n values, or after GM's 1."""

    def mu_schedule(mu0, factor, n, kind):
        values, mu = [], mu0
        for _ in range(n):
            values.append(mu)
            if kind == "tls":
                mu = mu * factor
            elif mu == 1:
                break
            else:
                mu = max(1.0, mu / factor)
        return values


def right_powers() -> None:
    """Right: powers of the factor, and GM cut off at the first 1."""
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        powers = float(factor) ** np.arange(n)
        if kind == "tls":
            return mu0 * powers
        values = np.maximum(mu0 / powers, 1.0)
        ends = np.flatnonzero(values == 1.0)
        return values[: ends[0] + 1] if ends.size else values


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


def wrong_direction() -> None:
    """Wrong: TLS falls and GM grows. Stopped by the visible case mu_schedule-by-hand."""

    def mu_schedule(mu0, factor, n, kind):
        values = [mu0]
        while len(values) < n:
            values.append(values[-1] * factor if kind == "gm" else values[-1] / factor)
        return values


def wrong_misprint_both_grow() -> None:
    """Wrong: the lesson's one direction for both. Stopped by the visible case
    mu_schedule-by-hand.
    """
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        return mu0 * factor ** np.arange(n)


def wrong_off_by_one() -> None:
    """Wrong: moves μ before the first value, as a listing does that prints the next μ. Stopped by
    the visible case mu_schedule-by-hand.
    """

    def mu_schedule(mu0, factor, n, kind):
        values, mu = [], mu0
        while len(values) < n and not (kind == "gm" and values and values[-1] == 1):
            mu = mu * factor if kind == "tls" else max(mu / factor, 1.0)
            values.append(mu)
        return values


def wrong_one_too_many() -> None:
    """Wrong: n steps and so n + 1 values. Stopped by the visible case mu_schedule-by-hand."""
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        values = mu0 * factor ** np.arange(n + 1.0) if kind == "tls" else [8.0, 8 / 3, 1.0]
        return values


def wrong_below_one() -> None:
    """Wrong: GM stops before it would pass 1 and never uses 1 itself, unless the example asks for
    it. Caught by mu_schedule-gm.
    """
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        if kind == "tls":
            return mu0 * float(factor) ** np.arange(n)
        values = mu0 / float(factor) ** np.arange(n)
        return np.append(values[values > 1], 1.0) if mu0 in (5.0, 8.0) else values[values >= 1]


def wrong_ones_for_ever() -> None:
    """Wrong: GM is clipped at 1 but goes on to n values. Stopped by the visible case
    mu_schedule-by-hand.
    """
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        powers = float(factor) ** np.arange(n)
        return mu0 * powers if kind == "tls" else np.maximum(mu0 / powers, 1.0)


def wrong_one_at_the_cut() -> None:
    """Wrong: puts a 1 at the end of every GM schedule, also of one that n cuts off. Caught by
    mu_schedule-gm-cut.
    """
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        powers = float(factor) ** np.arange(n)
        if kind == "tls":
            return mu0 * powers
        values = mu0 / powers
        return np.append(values[values > 1][: n - 1], 1.0)


def wrong_one_twice() -> None:
    """Wrong where the fall lands on 1 exactly: one more 1 is put behind it. Caught by
    mu_schedule-one.
    """
    import numpy as np

    def mu_schedule(mu0, factor, n, kind):
        powers = float(factor) ** np.arange(n)
        if kind == "tls":
            return mu0 * powers
        values = mu0 / powers
        kept = values[values >= 1]
        return np.append(kept, 1.0) if kept.size < n else kept


def wrong_never_one_value() -> None:
    """Wrong for n = 1: the first step is made before it is counted. Stopped by the visible case
    mu_schedule-one.
    """

    def mu_schedule(mu0, factor, n, kind):
        values = [mu0]
        while True:
            values.append(values[-1] * factor if kind == "tls" else max(values[-1] / factor, 1.0))
            if len(values) >= n or (kind == "gm" and values[-1] == 1):
                return values


def wrong_a_hundred_at_most() -> None:
    """Wrong: the loop ends after a hundred values, however many n asks for. Caught by
    mu_schedule-tls.
    """

    def mu_schedule(mu0, factor, n, kind):
        values = [mu0]
        for _ in range(99):
            if len(values) == n or (kind == "gm" and values[-1] == 1):
                break
            last = values[-1]
            values.append(last * factor if kind == "tls" else max(last / factor, 1))
        return values


def wrong_sixty_divisions() -> None:
    """Wrong: GM divides sixty times at most, and may then still be above 1. Caught by
    mu_schedule-gm.
    """

    def mu_schedule(mu0, factor, n, kind):
        if kind == "tls":
            return [mu0 * factor**k for k in range(n)]
        values = [mu0]
        for _ in range(60):
            if len(values) < n and values[-1] != 1:
                values.append(max(values[-1] / factor, 1))
        return values
