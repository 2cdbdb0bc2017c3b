"""Every number under *Right* on the errata page is the number that the library computes."""

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from robust_slam import problems
from robust_slam.estimators import kernels, reweighting, switches
from robust_slam.groups import se2
from scipy.linalg import solve_continuous_are
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial.transform import Rotation

from tests.book.samples import READINGS as Z
from tests.book.samples import gm_weight, lesson_surrogate, listing, three_poses, tls_weight

PAGE = Path(__file__).parents[2] / "chapters" / "errata.md"
NUMBER = re.compile(r"[-−]?[0-9]+(?:\.[0-9]+)?(?:/[0-9]+)?")
Rows = list[list[str]]


def read_tables(text: str) -> dict[str, Rows]:
    """Return the body cells of each `{table}` directive by its `:name:`."""
    tables = {}
    for name, body in re.findall(r":::\{table\}.*?\n:name: (\S+)\n(.*?)\n:::", text, re.S):
        lines = [line for line in body.splitlines() if line.startswith("|")]
        cells = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines]
        tables[name] = [[cell.strip() for cell in row] for row in cells[2:]]
    return tables


TABLES = read_tables(PAGE.read_text(encoding="utf-8"))


def assert_prints(cell: str, expected: list[float]) -> None:
    """Fail unless the numbers of the cell are the expected ones, to their last digit."""
    found = NUMBER.findall(cell.replace("**", "").replace("−", "-"))
    assert len(found) == len(expected), f"{cell!r} prints {found}, expected {expected}"
    for text, value in zip(found, expected, strict=True):
        top, _, bottom = text.partition("/")
        decimals = len(top.partition(".")[2])
        slack = 0.5 * 10.0**-decimals if decimals else 1e-9
        printed = float(top) / float(bottom or 1)
        near = pytest.approx(value, rel=0, abs=slack * (1 + 1e-9))
        assert printed == near, f"{text} in {cell!r}"


THREE = three_poses(2, 0)
INFORMATION = np.diag(1.0 / THREE.sigma**2)
NORMAL = THREE.jacobian.T @ INFORMATION @ THREE.jacobian


def cost(x: list[float] | np.ndarray) -> float:
    return float(np.sum(THREE.residuals(np.asarray(x, dtype=float)) ** 2))


def gradient(x: list[float]) -> list[float]:
    residual = THREE.jacobian @ np.asarray(x) - THREE.measurement
    return list(2.0 * THREE.jacobian.T @ INFORMATION @ residual)


def chapter_0() -> Iterator[list[float]]:
    x = THREE.initial()
    length = x[2] - x[0]
    printed = [0.8, 1.0, 1.2]
    without = three_poses(0).initial()
    parts = THREE.residuals(x) ** 2
    five = problems.chain(5, [0, 1, 2, 3, 1], [1, 2, 3, 4, 3], [1, 1, 1, 1, 0], [0.1] * 4 + [0.05])
    yield [length, length, 0, *x, 1, *(x + 1 - x.mean())]
    yield [cost(printed), *gradient(printed), cost(x), cost(x)]
    yield [length / 2, 100 * length / 2, 100 * (printed[2] - printed[0]) / 2]
    yield [50 + 400, 400, without[2], without[2]]
    yield [np.linalg.matrix_rank(NORMAL), *np.linalg.eigvalsh(NORMAL)]
    yield [cost([0, 1, 2]), cost([0, 1, 2]) - 4 / 0.05**2, parts[3], parts[:3].sum()]
    yield [2, length]
    yield [0, 2, 4, *five.initial()]
    yield []


def estimate(z: np.ndarray, sigma: float, kernel: kernels.Kernel) -> float:
    problem = problems.LocationProblem(z, sigma)
    return float(reweighting.irls(problem, kernel, tol=1e-14, max_iterations=5000).x)


def chapter_1() -> Iterator[list[float]]:
    square, one = kernels.squared(), kernels.huber(1)
    many = np.append(np.zeros(1000), 100.0)
    moved = [estimate(many, 1.0, kernel) for kernel in (square, one, kernels.cauchy(1))]
    pull, price = (float(f(10) / f(1)) for f in (square.psi, square.rho))
    yield [pull, price]
    yield [1, estimate(Z, 0.3, one), Z[:4].mean()]
    costs = [float(square.rho(100)), 1000 * float(square.rho(1))]
    pulls = [float(square.psi(100)), 1000 * float(square.psi(1))]
    yield [*pulls, *costs, 1000, 100, moved[0], 1, moved[1], 1, moved[2]]
    yield []


def curvature(kernel: kernels.Kernel, u: float, step: float = 1e-5) -> float:
    return float((kernel.psi(u + step) - kernel.psi(u - step)) / (2 * step))


def chapter_2() -> Iterator[list[float]]:
    cauchy, tls, huber = kernels.cauchy(1), kernels.tls(1), kernels.huber(1)
    yield [float(cauchy.rho(10))]
    yield [float(cauchy.rho(10) / cauchy.rho(1))]
    yield [float(tls.rho(10) / tls.rho(1))]
    printed_weight = 2 * float(tls.weight(0.5))
    yield [1, tls.rho(1), 10, tls.rho(10), tls.weight(0.5), printed_weight, 1]
    yield [1, -10, tls.rho(-10)]
    yield [1, 10, huber.psi(10), 1e6, huber.psi(1e6)]
    yield [1, 0.8, curvature(cauchy, 0.8), 1.2, curvature(cauchy, 1.2), 2]
    yield [3]


DATA = problems.LocationProblem(Z, 0.3)
RUN = reweighting.irls(DATA, kernels.cauchy(1), max_iterations=1000)


def chapter_3() -> Iterator[list[float]]:
    start, one, two = RUN.history[:3]
    w = one.weights
    fixed = RUN.x
    close = next(k for k, step in enumerate(RUN.history) if abs(step.x - fixed) < 1e-4)
    outlier_at_two = abs(Z[4] - one.x) / 0.3
    alone = reweighting.irls(problems.LocationProblem(Z[:4], 0.3), kernels.cauchy(1)).x
    plain = problems.LocationProblem(Z)
    unwhitened = reweighting.irls(plain, kernels.cauchy(1), start.x).history[1].x
    listing = reweighting.irls(plain, kernels.cauchy(1), 0.0)
    quiz = (0.08 * Z[:4].sum() + 0.006 * Z[4]) / (4 * 0.08 + 0.006)
    yield [5 / 0.3, 0, DATA.residual_norms(start.x)[4]]
    yield [*np.abs(Z[:4] - start.x), *DATA.residual_norms(start.x)[:4]]
    yield list(w[:4])
    yield [float(w[:4] @ Z[:4])]
    yield [w.sum()]
    yield [0.028 / 0.084]
    yield [one.x]
    yield list(w[:4] / w[4])
    yield [0.01, RUN.history[3].x, fixed, 0.0001, close]
    yield [RUN.weights[4], 0.001, math.sqrt(999), 5 / math.sqrt(999)]
    yield [1, w[:4].mean(), 2, outlier_at_two, *two.weights, two.x, quiz]
    yield [Z[:4].mean(), alone, fixed]
    yield [unwhitened]
    yield [4.9, reweighting.irls(DATA, kernels.cauchy(1), 4.9, max_iterations=1000).x]
    yield [0, 1]
    yield [1, 0, listing.x, listing.weights[4]]


def tls_cost(c: float, x: float, z: list[float]) -> float:
    """The cost without the ½."""
    return 2 * float(kernels.tls(c).rho(np.asarray(z) - x).sum())


def lowest(c: float) -> float:
    """Where the TLS cost of readings at 0 and 10 is lowest, from 0 on."""
    return min((0.0, 5.0), key=lambda x: tls_cost(c, x, [0, 10]))


def chapter_4() -> Iterator[list[float]]:
    pair, twenty = [0.0, 10.0], problems.LocationProblem([0.0] * 20 + [10.0])
    middle = np.mean(pair)
    slope = (tls_cost(2, 5 + 1e-3, pair) - tls_cost(2, 5 - 1e-3, pair)) / 2e-3
    switch = math.sqrt(50)
    assert (lowest(switch - 1e-3), lowest(switch + 1e-3)) == (0, 5)
    ends = [(reweighting.irls(twenty, kernels.tls(c), 8.0).x, c) for c in (1, 3, 9, 12)]
    captured, escaped = (
        reweighting.irls(DATA, kernels.cauchy(1), x0, max_iterations=1000).x for x0 in (4.9, 7.0)
    )
    yield [middle, float(kernels.squared().rho(np.asarray(pair) - middle).sum())]
    yield [2, tls_cost(2, 0, pair), 0, 10, tls_cost(2, 5, pair), 5, slope]
    yield [5, 5, switch]
    yield [number for end in ends for number in end]
    yield [captured, 7, 7, escaped]
    yield []


PRINTED = [(1, 0.80, 0.04), (1.5, 0.86, 0.02), (2.25, 0.92, 0.008), (100, 0.99, 0.0004)]


def gnc(z: list[float], weight: Callable, mus: Iterator[float]) -> list[tuple[float, ...]]:
    """Return μ, first weight, last weight, x for each step of GNC from the mean, c = 2."""
    values, rows = np.asarray(z, dtype=float), []
    x = values.mean()
    for mu in mus:
        w = weight(values - x, 2.0, mu)
        if w.sum() > 0:
            x = w @ values / w.sum()
        rows.append((mu, w[0], w[-1], x))
    return rows


def two_minima(mu: float) -> list[float]:
    def total(x: float) -> float:
        return lesson_surrogate(x, mu) + lesson_surrogate(10 - x, mu)

    options = {"method": "bounded", "options": {"xatol": 1e-9}}
    return [minimize_scalar(total, bounds=half, **options).x for half in ((0, 5), (5, 10))]


def chapter_5() -> Iterator[list[float]]:
    start = 4 / (2 * 5**2 - 4)
    equal = gnc([0, 10], tls_weight, (start * 1.4**k for k in range(4)))
    assert [row[1] for row in equal] == pytest.approx([row[2] for row in equal])
    rejected = next(mu for mu, w, *_ in equal if w == 0)
    tls_costs = [2 * float(kernels.tls(2).rho([x, 10 - x]).sum()) for x in (0, 10)]
    one_minimum = 5**2 * 3 / 2**2 - 1
    yield [10 * out / (inside + out) for _, inside, out in PRINTED[1:3]]
    yield [1.5**11, 1.5**12]
    yield [5, tls_costs[0], 0, tls_costs[1], 10, 5, start, start, rejected, 0]
    yield [2, 10, *(n for mu in (1, 100, 10000) for n in (lesson_surrogate(10, mu), mu))]
    yield [1, 3, 1, *two_minima(1), one_minimum]
    yield from annealing()


def anneal(z: list[float], factor: float = 1.4) -> list[tuple[float, ...]]:
    """GNC-TLS with c = 2 from the mean and the right start of μ, for 60 steps."""
    largest = max(abs(value - np.mean(z)) for value in z)
    start = 4 / (2 * largest**2 - 4)
    return gnc(z, tls_weight, (start * factor**k for k in range(60)))


def annealing() -> Iterator[list[float]]:
    three = anneal([0, 0, 0, 10])
    binary = next(k for k, (_, *w, _) in enumerate(three, 1) if set(w) <= {0.0, 1.0})
    assert math.isclose(1.4**20, 836.68, abs_tol=0.005)
    yield [0, 0, 0, 10, three[0][0], 2 * 7.5**2 / 4, 1]
    yield [20, three[0][0], three[20][0], 0, 1, binary]
    groups = [0, 0, 0, 0, 6, 6, 30]
    fast, slow = (anneal(groups, factor)[-1][-1] for factor in (1.4, 1.2))
    ends = [1.4, fast, tls_cost(2, fast, groups), 1.2, slow, tls_cost(2, slow, groups)]
    yield [*groups, 2, *ends]
    w = tls_weight(Z - 5.0, 1.0, 1.0)
    yield [*Z, 1, 1, w @ Z / w.sum()]
    apart, agreeing = [0, 0, 0, 20, -35, 50, -60], [0, 0, 10, 10, 10]
    end = anneal(agreeing)[-1][-1]
    costs = [tls_cost(2, end, agreeing), 0, tls_cost(2, 0, agreeing)]
    yield [*apart, anneal(apart)[-1][-1], *agreeing, end, *costs]
    yield [*listing(20), listing(80)[0]]


def chapter_6() -> Iterator[list[float]]:
    yield [float(switches.switch(100, 1.0)), 1, 100]
    yield from ([], [], [])


def rank(blocks: np.ndarray) -> int:
    """The rank of Z for rotations (n, d, d), or for complex numbers (n, 1, 1)."""
    stacked = np.concatenate(list(blocks), axis=1)
    return int(np.linalg.matrix_rank(stacked.conj().T @ stacked))


def chapter_7() -> Iterator[list[float]]:
    turns = np.random.default_rng(7).uniform(-1, 1, (6, 3))
    plane = se2.rotation(np.c_[np.zeros((6, 2)), turns[:, 0]])
    space = Rotation.from_rotvec(turns).as_matrix()
    ranks = [rank(plane), rank(space), rank(np.exp(1j * turns[:, :1])[:, :, np.newaxis])]
    step = math.radians(72)
    gap = se2.rotation([0, 0, step]) - np.eye(2)
    yield ranks
    yield ranks[1:2]
    yield []
    yield [360 / 72, 72, 5 * float(np.sum(gap**2)), 0]
    yield from ([], [], [], [])


def chapter_9() -> Iterator[list[float]]:
    one = np.eye(1)
    steady = solve_continuous_are(0 * one, one, one, one).item()
    printed = brentq(lambda p: 1 - p**2 - p, 0, 1)
    yield [0, 0, 1, steady, printed]
    yield from ([], [], [], [], [], [])


CHAPTERS = {f"errata-{number}": globals()[f"chapter_{number}"] for number in (*range(8), 9)}


@pytest.mark.parametrize("name", CHAPTERS)
def test_right_column_is_what_the_library_computes(name):
    expected = list(CHAPTERS[name]())
    rows = TABLES[name]
    assert len(rows) == len(expected)
    for row, values in zip(rows, expected, strict=True):
        assert_prints(row[1], [float(value) for value in values])


def test_rho_table_is_what_the_kernels_compute():
    names = {"Squared": "squared", "Huber": "huber", "Cauchy": "cauchy", "TLS": "tls"}
    rows = TABLES["errata-rho-table"]
    assert [row[0] for row in rows[::2]] == list(names)
    assert [row[1] for row in rows] == ["p", "r"] * 4
    for printed, right in zip(rows[::2], rows[1::2], strict=True):
        kernel = kernels.KERNELS[names[printed[0]]](1.0)
        low, high = kernel.rho([1.0, 10.0])
        values = [low, high, high / low, float(kernel.weight(10.0))]
        for cell, was, value in zip(right[2:], printed[2:], values, strict=True):
            assert_prints(cell, [value])
            assert cell.startswith("**") == was.startswith("**") == differs(was, value)


def differs(cell: str, value: float) -> bool:
    """Tell whether the printed cell is another number than the value, rounding apart."""
    try:
        assert_prints(cell, [value])
    except AssertionError:
        return True
    return False


AGREEING = [0, 0, 0, 10]
SCHEDULES = {
    "errata-gnc-tls": anneal(AGREEING)[:2],
    "errata-gnc-tls-one": gnc(AGREEING, tls_weight, iter([1.0, 1.5])),
    "errata-gnc-gm": gnc(AGREEING, gm_weight, (max(28.125 / 1.4**k, 1.0) for k in range(11))),
}
"""The last from 2 · 7.5²/4 on."""


@pytest.mark.parametrize("name", SCHEDULES)
def test_schedule_table_is_what_ten_lines_compute(name):
    for row, values in zip(TABLES[name], SCHEDULES[name], strict=True):
        for cell, value in zip(row, values, strict=True):
            assert_prints(cell, [value])


def test_two_readings_against_one_lose_every_weight_at_the_lessons_start():
    _, first, last, _ = gnc([0, 0, 10], tls_weight, iter([1.0]))[0]
    assert (first, last) == (0, 0)
    text = PAGE.read_text(encoding="utf-8")
    assert "with z = 0, 0, 10 the same start gives every weight 0 at once" in text


def test_printed_schedule_is_quoted_with_its_weights_and_a_changed_number_is_noticed():
    for row, values in zip(TABLES["errata-mu-printed"], PRINTED, strict=False):
        for cell, value in zip(row, values, strict=False):
            assert_prints(cell, [value])
    with pytest.raises(AssertionError):
        assert_prints("18/17 = 1.058825", [18 / 17, 18 / 17])


def test_the_page_names_no_table_without_a_test():
    assert set(TABLES) == {*CHAPTERS, *SCHEDULES, "errata-rho-table", "errata-mu-printed"}
