"""Signs that a file was meant otherwise than it is read: other units, another order, two robots.

No line of such a file is wrong by itself: a covariance in the place of the information is as
good a matrix, and a closure between two drives whose ids are neighbours looks like odometry. What
gives them away are magnitudes that no sensor and no drive has. Each of ``DOUBTS`` looks for one.

Source: derived here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._words import counted, so_do
from robust_slam.files.graph_file import Names, as_closure
from robust_slam.graphs.pose_graph import FEW, PoseGraph, deviations, rows_of
from robust_slam.groups.group import upward

_BLIND = np.pi / np.sqrt(3.0)
"""The deviation (rad) of a direction about which nothing is known: uniform from -π to π."""
_COARSE = 10.0
"""Claimed deviations of a step, in steps, from which on they cannot be meant."""
_LEAP = 10.0
"""Steps so many times longer than 95 % of all are hardly odometry."""
_UNLIKE = 1.5
"""A deviation differs by this factor where a sensor differs, and not by rounding."""
_SOME = 3
"""The smallest number of turns that tell their order."""
_ROUNDED = 1e-3
"""Files round; a pose deviates by less (m or rad) from a rotation, or from the plane."""
_AHEAD, _ASTRAY = 0.9, 0.75
"""The mean direction of travel in the robot's frame, of length 1 where it never changes."""


@dataclass(frozen=True, eq=False)
class Content:
    """What a file was read as: the ``graph``, the ``names`` of its poses, and what was written.

    ``lines`` ``(m,)`` are those of the edges, and ``turns`` ``(m, a)`` the sizes of their angles
    (rad), if there are such. A trajectory has ``poses`` ``(n, …)`` instead, with w first or not.
    """

    graph: PoseGraph
    names: Names
    lines: Indices = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    turns: Array = field(default_factory=lambda: np.empty((0, 0)))
    poses: Array | None = None
    w_first: bool = False

    @property
    def odometry(self) -> Indices:
        """The odometry, ascending."""
        return np.flatnonzero(self.graph.is_odometry)

    def named(self, edge: int) -> str:
        """Return the ids of an edge, such as 7-8."""
        i, j = self.names[self.graph.edges[edge]]
        return f"{i}-{j}"


def doubts(content: Content) -> tuple[str, ...]:
    """Return a sentence for each sign that the file was meant otherwise.

    >>> graph = PoseGraph(2, [[0, 1]], [[1, 0, 0]], np.diag([1e-2, 1e-2, 1e-4]))
    >>> doubts(Content(graph, np.arange(2)))[0][:40]
    'the matrices claim a deviation of 100 ra'
    """
    return tuple(words for doubt in DOUBTS.values() if (words := doubt(content)))


def _degrees(content: Content) -> str:
    """Doubt edges that turn by more than a circle."""
    far = np.flatnonzero(np.any(content.turns > 2.0 * np.pi, axis=1))
    if not far.size:
        return ""
    k, more = far[0], so_do(far.size - 1)
    return (
        f"line {content.lines[k]}: edge {content.named(k)} turns by {content.turns[k].max():.4g} "
        f"rad, more than a circle{more}; if these are degrees, multiply them by π/180, and the "
        "information of the rotations by (180/π)²"
    )


def _covariances(content: Content) -> str:
    """Doubt claims that no sensor makes, if the inverse matrices make claims that one does.

    One number for all, such as the identity, is neither: the noise is found, and the map right.
    """
    graph = content.graph
    steps = np.linalg.norm(graph.translation[graph.is_odometry], axis=1)
    step = float(np.median(steps)) if steps.size else np.inf
    inverse = replace(graph, information=np.asarray(np.linalg.inv(graph.information)))
    claimed, other = (np.median(deviations(each), axis=1) for each in (graph, inverse))
    limits = np.array([_COARSE * step or np.inf, _BLIND])
    position, rotation = (limits < claimed) & (other < limits)
    one_number = np.eye(graph.group.DOF) * graph.information[0, 0, 0]
    if not (rotation or position) or np.all(graph.information == one_number):
        return ""
    words = (
        f"a deviation of {claimed[1]:.3g} rad, with which a direction is unknown"
        if rotation
        else f"a deviation of {claimed[0]:.3g} m for steps of {step:.3g} m"
    )
    return (
        f"the matrices claim {words}; if they are covariances, write their inverses, the "
        "information"
    )


def _w_first(content: Content) -> str:
    """Doubt quaternions of which another order gives small turns, or a steady way ahead."""
    graph, poses = content.graph, content.poses
    order, space = "begins with w, write qx qy qz qw", graph.group.DIMENSION == 3
    if content.w_first:
        order = "ends with w, name the columns in a line above"
    kinds = {"odometry": graph.is_odometry & (poses is None), "closures": ~graph.is_odometry}
    for kind, chosen in kinds.items() if space else ():
        if np.sum(chosen) < _SOME:
            continue
        x = np.abs(Rotation.from_matrix(graph.rotation[chosen]).as_quat()[:, 0])
        if np.median(x) > _AHEAD:
            return f"most of the {kind} turns by half a circle about x; if its quaternion {order}"
    if poses is None or poses.ndim == 2:
        return ""
    as_read, other = _way(poses), _way(rolled(poses, 1 if content.w_first else -1))
    half = np.abs(poses[0, :, :3] - np.diag([1, -1, -1])).max() < _ROUNDED and not content.w_first
    if half and other >= as_read:
        return f"the first pose is turned by half a circle about x; if its quaternion {order}"
    if as_read < _ASTRAY and other > _AHEAD:
        return f"the robot travels in all directions of its frame; if its quaternion {order}"
    return ""


def rolled(poses: Array, by: int) -> Array:
    """Return poses ``(n, 3, 4)`` whose quaternions x y z w are moved on by so many places."""
    moved = np.roll(Rotation.from_matrix(poses[:, :, :3].copy()).as_quat(), by, axis=1)
    return np.concatenate([Rotation.from_quat(moved).as_matrix(), poses[:, :, 3:]], axis=2)


def _way(poses: Array) -> float:
    """Return how steady the direction of travel is in the robot's own frame, from 0 to 1."""
    steps = np.diff(poses[:, :, 3], axis=0)
    length = np.linalg.norm(steps, axis=1)
    moving = length > 0.1 * np.median(length)
    ahead = np.einsum("kij,ki->kj", poses[:-1, :, :3][moving], steps[moving])
    mean = np.mean(ahead / length[moving, None], axis=0) if np.any(moving) else np.zeros(3)
    return float(np.linalg.norm(mean))


def _few_digits(content: Content) -> str:
    """Doubt a trajectory far from the origin that was printed with six digits."""
    if content.poses is None:
        return ""
    graph = content.graph
    place = graph.group.translation(content.poses)
    return few_digits("poses", place, float(np.median(deviations(graph)[0][content.odometry])))


def few_digits(what: str, places: Array, claimed: float) -> str:
    """Return a sentence if positions ``(k, d)`` have no digits for what they claim (m)."""
    largest = np.maximum(np.abs(places).max(axis=0, initial=0.0), np.finfo(float).tiny)
    unit = 10.0 ** (np.floor(np.log10(largest)) - 5.0)
    whole = np.all(np.abs(places / unit - np.round(places / unit)) < 1e-6, axis=0)
    coarse = np.flatnonzero(whole & (unit > 2.0 * claimed))
    if not coarse.size:
        return ""
    k = coarse[np.argmax(unit[coarse])]
    return (
        f"the {what} have six digits, which is {unit[k]:g} m at {largest[k]:.6g} m, and claim "
        f"{claimed:.3g} m; print them with more digits, or less an origin nearby"
    )


def _same_ids(content: Content) -> str:
    """Doubt steps of which nearly each is measured twice, and otherwise the second time."""
    graph, n = content.graph, content.graph.n
    pairs = np.sort(graph.edges, axis=1) @ [n, 1]
    steps, others = content.odometry, np.flatnonzero(~graph.is_odometry)
    order = steps[np.argsort(pairs[steps])]
    place = np.minimum(np.searchsorted(pairs[order], pairs[others]), order.size - 1)
    if not order.size:
        return ""
    twice = pairs[order[place]] == pairs[others]
    others, place = others[twice], place[twice]
    first, last = place.min(initial=n), place.max(initial=0)
    if np.unique(place).size < max(FEW, 0.9 * (last - first + 1)):
        return ""
    far = np.flatnonzero(_disagree(graph, order[place], others))
    if far.size < max(3, 0.05 * others.size):
        return ""
    k = others[far[0]]
    return (
        f"line {content.lines[k]} gives edge {content.named(k)} again with other numbers"
        f"{so_do(far.size - 1)}, and nearly each step has two edges; if two robots have the same "
        "ids, add an offset to those of one"
    )


def _disagree(graph: PoseGraph, steps: Indices, others: Indices) -> Mask:
    """Return which ``others`` ``(k,)`` are far from the ``steps`` between the same poses."""
    group, d = graph.group, graph.group.DIMENSION
    ours, theirs = (upward(graph.edges[k], graph.measurement[k]) for k in (steps, others))
    off = group.log(group.between(ours, theirs))
    metres, radians = (np.linalg.norm(part, axis=1) for part in (off[:, :d], off[:, d:]))
    claimed = 10.0 * np.median(deviations(rows_of(graph, graph.is_odometry)), axis=1)
    usual = np.median(np.linalg.norm(graph.translation[graph.is_odometry], axis=1))
    far = (metres > max(0.2 * usual, claimed[0])) | (radians > max(0.2, claimed[1]))
    return np.asarray(far)


def _strange_steps(content: Content) -> str:
    """Doubt single steps that are as long, or as precise, as closures between drives."""
    graph, odometry = content.graph, content.odometry
    if odometry.size < FEW:
        return ""
    length = np.linalg.norm(graph.translation[odometry], axis=1)
    usual = float(np.quantile(length, 0.95))
    far = odometry[length > _LEAP * max(usual, np.finfo(float).tiny)]
    unlike = _unlike(graph, odometry)
    if far.size:
        why = f"is {np.max(length) / usual:.0f} times as long as others"
        return _closure_words(content, far, why)
    return _closure_words(content, unlike, "claims what closures claim") if unlike.size else ""


def _steps_back(content: Content) -> str:
    """Doubt a few steps that alone lead from the later to the earlier pose."""
    odometry = content.odometry
    back = odometry[content.graph.edges[odometry, 0] > content.graph.edges[odometry, 1]]
    if not 0 < back.size <= 0.05 * odometry.size:
        return ""
    more = f", as {counted(back.size - 1, 'other')}," if back.size > 1 else ""
    return (
        f"edge {content.named(back[0])}{more} leads back where the other steps lead ahead; if it "
        "measures the way ahead, swap its ids"
    )


def _unlike(graph: PoseGraph, odometry: Indices) -> Indices:
    """Return single steps that claim the closures' deviations, where others share their own."""
    closures = np.flatnonzero(~graph.is_odometry)
    if not closures.size:
        return closures
    claims = np.log(np.stack(deviations(graph), axis=1))
    ours, theirs = np.median(claims[odometry], axis=0), np.median(claims[closures], axis=0)
    if np.max(np.abs(ours - theirs)) < np.log(_UNLIKE):
        return closures[:0]
    near = np.log(_UNLIKE) / 4.0
    alike = np.all(np.abs(claims[odometry] - ours) < near, axis=1)
    foreign = np.all(np.abs(claims[odometry] - theirs) < near, axis=1)
    found: Indices = odometry[foreign]
    return found if np.sum(alike) > 0.95 * odometry.size else found[:0]


def _closure_words(content: Content, edges: Indices, why: str) -> str:
    named = content.named(edges[0])
    more = f", and {counted(edges.size - 1, 'other')} like it," if edges.size > 1 else ""
    return (
        f"edge {named}{more} counts as odometry, because its ids are neighbours, but {why}; "
        f"if it joins two drives, name it as a closure: {as_closure(named, edges[0])}"
    )


DOUBTS: dict[str, Callable[[Content], str]] = {
    "degrees": _degrees,
    "covariances": _covariances,
    "w first": _w_first,
    "few digits": _few_digits,
    "same ids": _same_ids,
    "strange steps": _strange_steps,
    "steps back": _steps_back,
}
"""Each returns a sentence, or nothing."""
