"""Pictures for assignment 07: the matrix of a graph, its relaxation, what proves a map best.

R ``(d, dn)`` holds the rotations side by side, and the cost is tr(R Q Rᵀ), without ½.
"""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.certificates import sdp
from robust_slam.palette import COLOURS, MARKERS, PALETTE
from scipy.spatial.transform import Rotation

from robust_slam_course.exercises import Settings, draw_beside, draw_truth, picture, shaped
from robust_slam_course.plots import with_gaps

_TOL = 1e-6
_STEP = 2.5  # between the poses of a row
_VERDICTS = {"certified": "inlier", "not certified": "outlier", "not stationary": "muted"}
"""Which colour and marker of the palette stand for a verdict."""


@picture(
    "A block where two poses are joined, and along the diagonal",
    height=3.55, ncols=2, sharey=True,
)  # fmt: skip
def connection_matrix(axes: Sequence[Axes], build: Callable[..., ArrayLike]) -> None:
    """Draw Q of a ring of five poses and one chord in the plane, as a field of colours."""
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0], [1, 3]])
    turn, kappa = _plane(np.array([0.4, -0.9, 1.3, 0.2, -0.6, 2.0])), np.arange(1.0, 7.0)
    truth = sdp.connection_matrix(5, edges, turn, kappa)
    yours = shaped(build(5, *edges.T, turn, kappa), (10, 10))
    for ax, matrix, title in zip(axes, (yours, truth), ("yours", "the truth"), strict=True):
        _draw_blocks(ax, matrix, 5)
        ax.set(title=title, xlabel="pose")
    axes[0].set(ylabel="pose")


@picture("No rotations cost less than the relaxation's value", height=3.6, ncols=2)
def solve_sdp(axes: Sequence[Axes], solve: Callable[[Array, int, int], ArrayLike]) -> None:
    """Draw the relaxation's value beside the cost of the best rotations, on two small graphs."""
    ring, pair = axes
    angles, fine = np.linspace(0.0, np.pi, 11), np.linspace(0.0, np.pi, 121)
    share = np.minimum(fine, np.abs(2.0 * np.pi / 3.0 - fine))  # a third of a turn closes as well
    draw_truth(ring, fine, 12.0 * (1.0 - np.cos(share)), "best rotations")
    values = [_value(solve, _ring(3, angle), 3, 2) for angle in angles]
    ring.plot(angles, values, MARKERS["estimate"], color=PALETTE["estimate"], label="your value")
    ring.set(xlabel="measured turn, rad", ylabel="cost, or value", title="a ring: met")
    weights = np.linspace(0.0, 2.5, 11)
    reach = np.maximum(3.0 * (weights - 1.0), 1.0 - weights)
    draw_truth(pair, weights, 6.0 * (3.0 + weights) - 2.0 * reach, "best rotations")
    values = [_value(solve, _half_turns(k), 2, 3) for k in weights]
    pair.plot(weights, values, MARKERS["estimate"], color=PALETTE["estimate"], label="your value")
    pair.set(xlabel="κ of the fourth measurement", title="two poses in space: a gap")
    ring.legend(loc="upper left", fontsize=9.0)
    ring.set_ylim(top=9.5)


@picture("Every y axis stands a quarter turn left of its x axis", "pose", height=3.2)
def round_solution(ax: Axes, rounding: Callable[[Array, int, int], ArrayLike]) -> None:
    """Draw the axes of six poses in the plane, as pose 0 sees them."""
    n = 6
    truth = _plane(np.array([0.0, 0.7, 1.9, 2.6, -2.2, -0.9]))
    wide = np.hstack(list(truth))
    flat = shaped(rounding(wide.T @ wide, n, 2), (2, 2 * n))
    yours = np.stack(np.split(flat, n, axis=1))
    _draw_axes(ax, truth, "true", COLOURS["grid"].light, 7.0)
    _draw_axes(ax, yours[0].T @ yours, "your", PALETTE["estimate"], 2.0)
    ax.set(aspect="equal", yticks=[], ylim=(-1.2, 2.6))
    ax.set_xticks(_STEP * np.arange(n), [str(k) for k in range(n)])
    ax.legend(ncols=2, loc="upper center")


@picture(
    "Tight, until the noise is far beyond any sensor's",
    "noise of the measured turns, rad",
    "rounded cost − value,\nover |Q|",
    height=3.7,
)
def is_tight(ax: Axes, judge: Callable[[Array, Array, Array, float], object]) -> None:
    """Draw which of thirty noisy graphs in space are called tight, over their noise."""
    noise = np.linspace(0.05, 1.5, 30)
    answers: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    tight = []
    for level, Q in zip(noise, _noisy(noise), strict=True):
        Z = sdp.solve_sdp(Q, 3).Z
        R = sdp.round_solution(Z, 3)
        gap = (_cost(Q, R) - float(np.sum(Q * Z))) / float(np.linalg.norm(Q, 2))
        place = (level, max(gap, 1e-9))
        answers[_yes(judge(Z.copy(), Q.copy(), R.copy(), _TOL))].append(place)
        if sdp.is_tight(Z, Q, R, _TOL):
            tight.append(place)
    _draw_frames(ax, "o", np.transpose(tight), PALETTE["muted"], "tight")
    ax.lines[-1].set(alpha=0.4)
    for answer, name in ((True, "inlier"), (False, "outlier")):
        points = np.reshape(answers[answer], (-1, 2)).T
        ax.plot(*points, MARKERS[name], color=PALETTE[name], label=f"yours: {answer}")
    ax.axhline(_TOL, color=PALETTE["muted"], linestyle=":", linewidth=1.0)
    ax.text(noise[0], 1.5 * _TOL, "tol", fontsize=9.0)
    ax.set(yscale="log")
    ax.legend(loc="upper left")


@picture("Nothing below 0 proves the best; your λ_min is the thin line", ncols=2, sharey=True)
def certificate(
    axes: Sequence[Axes], certify: Callable[[Array, Array], tuple[ArrayLike, float]]
) -> None:
    """Draw the eigenvalues of S on a ring of five, at the best rotations and once twisted."""
    Q, place = _ring(5, 0.3), np.arange(10)
    for ax, twist, title in zip(axes, (0.0, 1.0), ("the best", "twisted once"), strict=True):
        R = _twisted(twist)
        S, lowest = certify(Q.copy(), R.copy())
        truth, yours = sdp.dense_certificate(Q, R)[1], np.linalg.eigvalsh(shaped(S, (10, 10)))
        draw_beside(ax, place, truth, yours, linestyle="", marker=MARKERS["estimate"])
        ax.axhline(float(lowest), color=PALETTE["estimate"], linewidth=1.0, linestyle="--")
        ax.axhline(0.0, color=PALETTE["truth"], linewidth=1.0, linestyle="-")
        ax.set(xlabel="eigenvalue, by size", xticks=place[::3], title=title)
    axes[0].set(ylabel="eigenvalues of S")
    axes[0].legend(loc="upper left")


@picture(
    "Four stand still, and only one of them is the best",
    "twist of the ring, in full turns",
    "cost",
    height=3.7,
)
def verdict(ax: Axes, judge: Callable[[Array, Array, float], str]) -> None:
    """Draw the verdicts on a ring of five while it is twisted, over what that costs."""
    Q = _ring(5, 0.0)
    fine = np.linspace(0.0, 2.25, 91)
    draw_truth(ax, fine, [_cost(Q, _twisted(t)) for t in fine], "")
    twists = np.array([0.0, 0.2, 0.4, 0.6, 5.0 / 6.0, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2])
    costs = np.array([_cost(Q, _twisted(t)) for t in twists])
    truths = np.array([_library_verdict(Q, _twisted(t)) for t in twists])
    yours = np.array([str(judge(Q.copy(), _twisted(t), _TOL)) for t in twists])
    unknown = set(yours) - set(_VERDICTS)
    if unknown:
        raise ValueError(f"{unknown} is not one of the three verdicts")
    for word, name in _VERDICTS.items():
        at, size = yours == word, 10.0 if name == "muted" else 9.0
        look: Settings = {"color": PALETTE[name], "markersize": size, "label": f"yours: {word}"}
        ax.plot(twists[at], costs[at], MARKERS[name], **look)
    differ = yours != truths
    if np.any(differ):
        wrong = np.array([twists[differ], costs[differ]])
        _draw_frames(ax, "s", wrong, PALETTE["accent"], "the truth is another")
    ax.set(ylim=(-2.0, 52.0))
    ax.legend(loc="upper left")


@picture(
    "The gap never exceeds the bound, and meets it at 0 and at 1",
    "twist of the ring, in full turns",
    "cost above the best",
    height=3.7,
)
def suboptimality(ax: Axes, bound: Callable[[Array, Array], float]) -> None:
    """Draw the bound and the true gap on a ring of five while it is twisted."""
    Q, twists = _ring(5, 0.0), np.linspace(0.0, 1.5, 61)
    places = [_twisted(t) for t in twists]
    yours = [float(bound(Q.copy(), R.copy())) for R in places]
    draw_beside(ax, twists, [sdp.suboptimality(Q, R) for R in places], yours, label="your bound")
    ax.plot(twists, [_cost(Q, R) for R in places], ":", color=PALETTE["truth"], label="the gap")
    ax.legend(loc="upper left")


def _plane(angles: Array) -> Array:
    """Return rotations (m, 2, 2) of the plane by angles (m,)."""
    c, s = np.cos(angles), np.sin(angles)
    return np.moveaxis(np.array([[c, -s], [s, c]]), -1, 0)


def _ring(n: int, angle: float) -> Array:
    """Return Q (2n, 2n) of a ring in the plane, each pose measured to be turned by the angle."""
    edges = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    return sdp.connection_matrix(n, edges, _plane(np.full(n, angle)))


def _half_turns(kappa: float) -> Array:
    """Return Q (6, 6): two poses in space, three half turns and, with kappa, none at all.

    The three half turns about x, y and z add up to −I, which is not a rotation.
    """
    signs = np.array([[1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0], [1.0, 1.0, 1.0]])
    turns = signs[:, :, None] * np.eye(3)
    return sdp.connection_matrix(2, [[0, 1]] * 4, turns, [1.0, 1.0, 1.0, kappa])


def _noisy(noise: Array) -> list[Array]:
    """Return Q (12, 12) for each noise in rad: all pairs of four poses in space, measured so."""
    rng = np.random.default_rng(4)
    pairs = np.array([[a, b] for a in range(4) for b in range(a)])
    draws = rng.normal(size=(noise.size, len(pairs), 3))
    return [
        sdp.connection_matrix(4, pairs, Rotation.from_rotvec(level * draw).as_matrix())
        for level, draw in zip(noise, draws, strict=True)
    ]


def _twisted(turns: float) -> Array:
    """Return R (2, 10): five poses, each turned by a fifth of so many turns from the last."""
    return np.hstack(list(_plane(0.4 * np.pi * turns * np.arange(5.0))))


def _cost(Q: Array, R: Array) -> float:
    return float(np.sum((R @ Q) * R))


def _library_verdict(Q: Array, R: Array) -> str:
    S, eigenvalues = sdp.dense_certificate(Q, R)
    small = _TOL * float(np.linalg.norm(Q, 2))
    if np.abs(S @ R.T).max() > small:
        return "not stationary"
    return "certified" if eigenvalues[0] >= -small else "not certified"


def _value(solve: Callable[[Array, int, int], ArrayLike], Q: Array, n: int, d: int) -> float:
    return float(np.sum(Q * shaped(solve(Q.copy(), n, d), Q.shape)))


def _yes(answer: object) -> bool:
    """Return a student's yes or no.

    Raises:
        ValueError: it is neither.
    """
    if not isinstance(answer, bool | np.bool_ | int) or answer not in (True, False):
        raise ValueError(f"{answer!r} is neither True nor False")
    return bool(answer)


def _draw_frames(ax: Axes, marker: str, points: Array, color: str, label: str) -> None:
    """Draw empty markers round points (2, k)."""
    empty: Settings = {"markersize": 13.0, "markerfacecolor": "none", "markeredgewidth": 3.0}
    ax.plot(*points, marker, color=color, label=label, **empty)


def _draw_axes(ax: Axes, rotations: Array, whose: str, color: str, width: float) -> None:
    """Draw the axes of rotations (n, 2, 2) in a row, x solid and y dotted."""
    feet = np.column_stack([_STEP * np.arange(len(rotations)), np.zeros(len(rotations))])
    for axis, (name, style) in enumerate((("x", "-"), ("y", ":"))):
        arrows = with_gaps(np.stack([feet, feet + rotations[:, :, axis]], axis=1))
        ax.plot(*arrows, style, color=color, linewidth=width, label=f"{whose} {name} axis")


def _draw_blocks(ax: Axes, matrix: Array, n: int) -> None:
    """Draw a matrix of n × n blocks as colours, with lines between the blocks."""
    d = len(matrix) // n
    ax.imshow(matrix, cmap="PuOr", vmin=-12.0, vmax=12.0)
    for k in range(1, n):
        ax.axhline(d * k - 0.5, color="white", linewidth=2.0, linestyle="-")
        ax.axvline(d * k - 0.5, color="white", linewidth=2.0, linestyle="-")
    ticks = d * np.arange(n) + (d - 1) / 2.0
    names = [str(k) for k in range(n)]
    ax.grid(visible=False)
    ax.set_xticks(ticks, names)
    ax.set_yticks(ticks, names)
