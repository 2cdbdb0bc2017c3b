"""Cases in one dimension: kernels, locations, lines, chains, and the parts of the solvers."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from robust_slam.estimators import gnc, graduation, irls, kernels
from robust_slam.estimators.result import StopReason
from robust_slam.problems import LinearProblem, LocationProblem
from robust_slam_course.plots.landscapes import minima

NAMES = ["squared", "huber", "cauchy", "geman-mcclure", "tls"]
SURROGATES = {"tls": graduation.tls_surrogate, "tlsWeight": graduation.tls_weight}
SURROGATES |= {"gm": graduation.gm_surrogate, "gmWeight": graduation.gm_weight}


@dataclass(frozen=True)
class Angles:
    """Poses ``(n, 3)``, whose headings count modulo a full turn."""

    poses: np.ndarray


@dataclass(frozen=True)
class Steps:
    """The steps of a history.

    Where it has converged, the last change is close to the tolerance, and rounding may decide
    whether one more step is taken.
    """

    steps: list[dict[str, Any]]
    spare: int


@dataclass(frozen=True)
class Case:
    """What a solver in the page is given, and the answer of the library."""

    given: dict[str, Any]
    expected: dict[str, Any]


def kernel_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Every kernel at random residuals, at its scale and at 0."""
    for name in NAMES * 5:
        c = float(rng.choice([1.0, 2.0, 0.3, np.exp(rng.normal())]))
        u = np.concatenate([[0.0, c, -c, 2 * c, 1e-9, 1e6], c * rng.normal(size=20)])
        kernel = kernels.KERNELS[name](c)
        numbers = {part: getattr(kernel, part)(u) for part in ("rho", "psi", "weight")}
        yield Case({"kernel": name, "c": c, "u": u}, numbers)


def majoriser_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The parabola above the cost of every kernel, and the step of IRLS that it stands for."""
    for name in NAMES * 4:
        z, sigma = rng.normal(0, 2, int(rng.integers(2, 9))), float(np.exp(rng.normal()))
        c, at = float(rng.choice([1.0, 2.576])), float(rng.normal(0, 3))
        kernel, problem = kernels.KERNELS[name](c), LocationProblem(z, sigma)
        weights = kernel.weight(problem.residual_norms(at))
        under = 0.5 * weights * ((at - z) / sigma) ** 2
        floor = np.sum(kernel.rho(problem.residual_norms(at)) - under)
        x = rng.normal(0, 3, 7)
        squares = ((x[:, None] - z) / sigma) ** 2
        lowest = float(problem.solve(weights, at)) if weights.any() else None
        yield Case(
            {"z": z, "sigma": sigma, "kernel": name, "c": c, "at": at, "x": x},
            {"weights": weights, "lowest": lowest, "values": floor + 0.5 * squares @ weights},
        )


def leverage_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The diagonal of the hat matrix of a line."""
    for _ in range(40):
        p = rng.normal(3, 5, int(rng.integers(2, 12)))
        rows = np.column_stack([np.ones(p.size), p])
        yield Case({"p": p}, {"leverages": np.diag(rows @ np.linalg.pinv(rows))})


def surrogate_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The surrogates on both sides of their bounds."""
    for _ in range(40):
        c, mu = float(np.exp(rng.normal())), float(10.0 ** rng.uniform(-4, 4))
        bounds = c * np.sqrt([mu / (mu + 1), (mu + 1) / mu])
        u = np.concatenate([[0.0, c, c / np.sqrt(2)], bounds, rng.normal(0, 2 * c, 12)])
        numbers = {name: formula(u, c, mu) for name, formula in SURROGATES.items()}
        yield Case({"u": u, "c": c, "mu": mu}, numbers)


def location_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Locations by IRLS: every kernel, starts near and far, ties, limits and equal readings."""
    for k in range(140):
        z, sigma = _readings(rng)
        name, c = NAMES[k % len(NAMES)], float(rng.choice([1.0, 2.0, 0.5, 1.345]))
        x0 = [None, 0.0, float(z[0]), float(rng.normal(0, 5))][int(rng.integers(4))]
        limit = int(rng.choice([1, 3, 100, 1000]))
        method = {"name": "irls", "kernel": name, "c": c, "x0": x0}
        yield location_case(z, sigma, method, limit)
    for special, name, c, x0 in SPECIAL_LOCATIONS:
        method = {"name": "irls", "kernel": name, "c": c, "x0": x0}
        yield location_case(special, 1.0, method, 200)


SPECIAL_LOCATIONS: list[tuple[list[float], str, float, float | None]] = [
    ([0.0, 10.0], "tls", 1.0, 5.0),  # all rejected
    ([0.0, 10.0], "tls", 5.0, None),  # both readings exactly at the kink
    ([0.0, 2.0, 4.0], "tls", 2.0, 2.0),  # ties at the kink
    ([1.0, 1.0, 1.0], "cauchy", 1.0, None),  # no residuals
    ([1.0, 1.0, 1.0, 9.0], "tls", 1.0, 1.0),  # the inliers agree exactly
    ([3.0], "geman-mcclure", 1.0, None),  # one reading
    ([0.0, 0.0, 6.0, 6.0], "cauchy", 2.0, None),  # two equal groups
    ([0.1, -0.2, 0.15, -0.1, 5.0], "geman-mcclure", 0.1, 4.0),  # tiny weights
]


def annealed_location_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Locations by GNC: both kernels, several factors."""
    for k in range(150):
        z, sigma = _readings(rng)
        kind = ("tls", "gm")[k % 2]
        options = {"factor": float(rng.choice([1.2, 1.4, 2.0]))}
        x0 = None if rng.random() < 0.6 else float(rng.normal(0, 4))
        c, limit = float(rng.choice([1.0, 2.0, 3.0, 50.0])), int(rng.choice([2, 1000, 1000]))
        method = {"name": "gnc", "c": c, "kind": kind, "x0": x0, "options": options}
        yield location_case(z, sigma, method, limit)
    seven = [0.0, 0.0, 0.0, 0.0, 6.0, 6.0, 30.0]  # where a greater factor ends elsewhere
    for z in (seven, [0.0, 10.0], [1.0, 1.0], [0.0, 0.0, 5.0, 5.0], [-1.0, 0.0, 1.0, 40.0]):
        for factor in (1.2, 1.4):
            options = {"factor": factor}
            method = {"name": "gnc", "c": 2.0, "kind": "tls", "x0": None, "options": options}
            yield location_case(z, 1.0, method, 1000)


def landscape_cases(rng: np.random.Generator) -> Iterator[Case]:
    """The cost over x, and its minima."""
    for k in range(42):
        each, sigma = _readings(rng)
        times = rng.integers(1, 4, size=each.size)
        z = np.repeat(each, times)
        name, c = NAMES[k % len(NAMES)], float(rng.choice([1.0, 2.0, 0.5]))
        span = [float(z.min()) - 2.0, float(z.max()) + 2.0]
        grid = np.linspace(*span, 101)
        cost = kernels.KERNELS[name](c).rho((grid - z[:, None]) / sigma).sum(axis=0)
        rng.uniform(size=8)  # two readings with one Huber cost would have minima by rounding
        given = {"z": each, "times": times, "sigma": sigma, "kernel": name, "c": c}
        expected = {"cost": cost, "minima": minima(cost)}
        yield Case(given | {"span": span, "count": 101}, expected)


def line_cases(rng: np.random.Generator) -> Iterator[Case]:
    """Lines through points, with outliers that may have leverage, and equal points."""
    for k in range(80):
        m = int(rng.integers(2, 12))
        p = rng.choice([0.0, 1.0, 2.0], size=m) if k % 9 == 8 else rng.uniform(0, 5, m)
        y = 0.5 * p + 0.2 * rng.normal(size=m)
        y[: m // 4] += rng.normal(0, 6, m // 4)
        sigma = float(rng.choice([0.2, 1.0]))
        if np.ptp(p) == 0.0:
            continue
        problem = LinearProblem(np.column_stack([np.ones(m), p]), y, sigma)
        given = {"kind": "line", "p": p, "y": y, "sigma": sigma}
        x0 = rng.normal(size=2) if k % 2 else None
        method = random_method(rng, x0, [1.0, 2.385, 3.0])
        yield loop_case(given, problem, method, int(rng.choice([5, 300, 1000])))


def random_method(rng: np.random.Generator, x0: Any, scales: list[float]) -> dict[str, Any]:
    """IRLS or GNC with a kernel, from ``x0``."""
    common = {"c": float(rng.choice(scales)), "x0": x0}
    if rng.random() < 0.6:
        return common | {"name": "gnc", "kind": str(rng.choice(["tls", "gm"]))}
    return common | {"name": "irls", "kernel": str(rng.choice(NAMES))}


def _readings(rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Readings, a few of them outliers, and their deviation."""
    m = int(rng.integers(1, 13))
    sigma = float(rng.choice([0.3, 1.0, rng.uniform(0.1, 2.0)]))
    z = sigma * rng.normal(size=m)
    outliers = int(rng.integers(0, m + 1)) // 2
    z[:outliers] += rng.choice([5.0, 20.0, 1000.0]) * rng.normal(size=outliers)
    return rng.permutation(z), sigma


def location_case(z: Any, sigma: float, method: dict[str, Any], limit: int) -> Case:
    given = {"kind": "location", "z": z, "sigma": sigma}
    return loop_case(given, LocationProblem(z, sigma), method, limit)


Given = dict[str, Any]


def loop_case(given: Given, problem: Any, method: Given, limit: int, tol: float = 0.0) -> Case:
    """The case of a method on a problem, and the library's result."""
    usual = 1e-9 if method["name"] == "gnc" else 1e-12
    options = {"maxIterations": limit, "tol": tol or usual}
    options |= method.get("options", {})
    x0 = problem.guess if isinstance(method["x0"], str) else method["x0"]
    common = {"tol": options["tol"], "max_iterations": limit, **method.get("options", {})}
    if method["name"] == "irls":
        result = irls(problem, kernels.KERNELS[method["kernel"]](method["c"]), x0, **common)
    else:
        result = gnc(problem, method["c"], method["kind"], x0, **common)
    history = [
        {"weights": step.weights, "cost": step.cost, "mu": step.mu, "x": _solution(step.x)}
        for step in result.history
    ]
    expected = {
        "stop": result.stop.value,
        "x": _solution(result.x),
        "weights": result.weights,
        "cost": result.cost,
        "history": Steps(history, spare=int(result.stop is StopReason.CONVERGED)),
    }
    return Case({"problem": given, "method": method | {"options": options}}, expected)


def _solution(x: Any) -> Any:
    return Angles(x) if np.ndim(x) == 2 else x
