"""Whether errors are as large as the covariance says: the NEES of many towns and spheres.

The NEES of a pose, eᵀ Σ⁻¹ e, has in the mean its degrees of freedom D where the covariance Σ is
right: 3 in the plane, 6 in space. Each map gives one pose that is drawn at random and the pose
farthest from pose 0. The maps are independent, so the mean over all is inside the printed band in
95 % of all cases, and 95 % of the poses are inside their ellipsoids. With the inliers known
`gauss_newton` makes the map; `rs.solve` finds them and their noise, and the covariance is that
of `answer.precise`. Outliers that it keeps are counted and left in. Of a map whose support is not
*unique* nothing is claimed; such maps are counted, and only the last column has them.

    python -m benchmarks.nees
    python -m benchmarks.nees --runs 1000 --seed 1000
"""

import os
import time
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from dataclasses import dataclass
from functools import partial

# It is read when numpy is first imported.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
import robust_slam as rs
from robust_slam._arrays import Array, Mask
from robust_slam.descent import gauss_newton
from robust_slam.estimators import chi_square_threshold
from robust_slam.graphs import Noise, add_random_closures, manhattan, nees, sphere
from robust_slam.solver import Support
from scipy.special import gammaincinv

RUNS, SEED = 200, 0
POSES, CLOSURES = 60, 15
INSIDE = 0.95
"""The probability of the band, and of the ellipsoid of a pose."""
WORLDS = {"town": partial(manhattan, POSES, closures=CLOSURES), "sphere": partial(sphere, POSES)}
"""What draws a graph of inliers and its true poses: a walk in a town, a way around a sphere."""


@dataclass(frozen=True)
class Setting:
    """One row: a kind of world, its outliers, and how its map is made.

    Attributes:
        name: the row's; it begins with one of ``WORLDS``.
        outliers: how many random closures are added; None where the inliers are known.
        scale: the noise in units of the deviations that are claimed.
    """

    name: str
    outliers: int | None = None
    scale: float = 1.0


SETTINGS = (
    Setting("town, inliers known"),
    Setting("sphere, inliers known"),
    Setting("town, rs.solve, no outlier", 0),
    Setting("town, rs.solve, 6 outliers", 6),
    Setting("town, rs.solve, 15 outliers", 15),
    Setting("town, rs.solve, 6 outliers, noise / 3", 6, 1 / 3),
    Setting("town, rs.solve, 6 outliers, noise x 3", 6, 3.0),
    Setting("sphere, rs.solve, 15 outliers", 15),
)


@dataclass(frozen=True)
class Row:
    """What the maps of a setting have shown.

    ``drawn`` and ``far`` ``(N,)`` are the NEES of the pose drawn and of the farthest, ``unique``
    ``(N,)`` marks maps of unique support, ``freedom`` is D, ``kept`` the number of outliers kept
    in all, and ``seconds`` CPU time.
    """

    setting: Setting
    drawn: Array
    far: Array
    unique: Mask
    freedom: int
    kept: int
    seconds: float


def measure(setting: Setting, runs: int, seed: int = SEED) -> Row:
    """Return the row of ``setting`` over so many worlds, from the ``seed`` on."""
    began, values, kept = time.process_time(), np.empty((runs, 2)), 0
    make = WORLDS[setting.name.partition(",")[0]]
    unique = np.ones(runs, dtype=np.bool_)
    for k in range(runs):
        rng = np.random.default_rng(seed + k)
        graph, truth = make(rng=rng, noise=Noise(scale=setting.scale))
        group = graph.group
        away = np.linalg.norm(group.translation(group.between(truth[0], truth)), axis=-1)
        chosen = [int(rng.integers(1, graph.n)), int(np.argmax(away))]
        if setting.outliers is None:
            poses = gauss_newton(graph, truth)
            covariance = rs.covariance(graph, poses, chosen)
        else:
            mixed, is_outlier = add_random_closures(graph, setting.outliers, rng, poses=truth)
            answer = rs.solve(mixed)
            poses, kept = answer.poses, kept + int(np.sum(answer.kept & is_outlier))
            unique[k] = answer.support is Support.UNIQUE
            covariance = rs.covariance(answer.precise, poses, chosen, answer.weights)
        values[k] = nees(poses, truth, chosen, covariance)
    seconds = time.process_time() - began
    return Row(setting, *values.T, unique, graph.group.DOF, kept, seconds)


def band(freedom: int, runs: int) -> tuple[float, float]:
    """Return where the mean of ``runs`` χ² numbers with ``freedom`` is with probability INSIDE.

    Source: Bar-Shalom, Li and Kirubarajan 2001, section 5.4.
    """
    ends = 0.5 + 0.5 * INSIDE * np.array([-1.0, 1.0])
    low, high = 2.0 * gammaincinv(0.5 * freedom * runs, ends) / runs
    return float(low), float(high)


HEADER = (
    f"{'setting':<38} {'D':>2} {'maps':>5} {'band':>10} {'a pose':>7} {'farthest':>8} "
    f"{'inside':>7} {'outliers kept':>13} {'CPU s':>6} {'all maps':>9}"
)


def line(row: Row) -> str:
    """Return a row of the table."""
    drawn, maps = row.drawn[row.unique], int(row.unique.sum())
    low, high = band(row.freedom, maps)
    inside = np.mean(drawn <= chi_square_threshold(INSIDE, row.freedom) ** 2)
    return (
        f"{row.setting.name:<38} {row.freedom:>2} {maps:>5} {f'{low:.2f}-{high:.2f}':>10} "
        f"{drawn.mean():>7.2f} {row.far[row.unique].mean():>8.2f} {inside:>7.1%} "
        f"{row.kept:>13} {row.seconds:>6.1f} {row.drawn.mean():>9.2f}"
    )


def main() -> None:
    """Measure every setting and print the table."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=RUNS, help="worlds a row (%(default)s)")
    parser.add_argument("--seed", type=int, default=SEED, help="the first seed (%(default)s)")
    wanted = parser.parse_args()
    print(
        f"NEES over {wanted.runs} worlds a row, from seed {wanted.seed} on: {POSES} poses, a town "
        f"with {CLOSURES} closures, a sphere with all; noise {Noise().odometry} of odometry and "
        f"{Noise().closure} of closures, in m and rad\n{HEADER}",
        flush=True,
    )
    for setting in SETTINGS:
        print(line(measure(setting, wanted.runs, wanted.seed)), flush=True)


if __name__ == "__main__":
    main()
