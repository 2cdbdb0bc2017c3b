"""Signs that a file was meant otherwise than it is read: other units, another order, two robots.

No line of such a file is wrong by itself: a covariance in the place of the information is as
good a matrix, and a closure between two drives whose ids are neighbours looks like odometry. What
gives them away are magnitudes that no sensor and no drive has. Each of ``DOUBTS`` looks for one.

Source: derived here.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._words import counted, so_do
from robust_slam.files.graph_file import GraphFile
from robust_slam.graphs.pose_graph import FEW, PoseGraph, deviations, rows_of, spreads
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
ROUNDED = 1e-3
"""Files round; a pose deviates by less (m or rad) from a rotation, or from the plane."""
_AHEAD, _ASTRAY = 0.9, 0.75
"""The mean direction of travel in the robot's frame, of length 1 where it never changes."""


def doubted(file: GraphFile) -> GraphFile:
    """Return ``file`` with a sentence in ``doubts`` for each sign that it was meant otherwise."""
    return replace(file, doubts=tuple(words for each in DOUBTS.values() if (words := each(file))))


def _degrees(file: GraphFile) -> str:
    """Doubt edges that turn by more than a circle."""
    far = np.flatnonzero(np.any(file.turns > 2.0 * np.pi, axis=1))
    if not far.size:
        return ""
    k, more = far[0], so_do(far.size - 1)
    return (
        f"line {file.lines[k]}: edge {file.named(k)} turns by {file.turns[k].max():.4g} rad, more "
        f"than a circle{more}; if these are degrees, multiply them by π/180, and the information "
        "of the rotations by (180/π)²"
    )


def _covariances(file: GraphFile) -> str:
    """Doubt claims that no sensor makes, if the inverse matrices make claims that one does.

    One number for all, such as the identity, is neither: the noise is found, and the map right.
    """
    graph = file.graph
    steps = np.linalg.norm(graph.translation[graph.is_odometry], axis=1)
    step = float(np.median(steps)) if steps.size else np.inf
    inverted = spreads(graph.information, graph.group.DIMENSION)  # as if these were covariances
    claimed, other = (np.median(each, axis=1) for each in (deviations(graph), inverted))
    limits = np.array([_COARSE * step or np.inf, _BLIND])
    position, rotation = (limits < claimed) & (other < limits)
    one_number = np.eye(graph.group.DOF) * graph.information[0, 0, 0]
    if not (rotation or position) or np.all(graph.information == one_number):
        return ""
    words = f"{claimed[0]:.3g} m for steps of {step:.3g} m"
    if rotation:
        words = f"{claimed[1]:.3g} rad, with which a direction is unknown"
    remedy = "if they are covariances, write their inverses, the information"
    return f"the matrices claim a deviation of {words}; {remedy}"


def _w_first(file: GraphFile) -> str:
    """Doubt quaternions of which another order gives small turns, or a steady way ahead."""
    graph, poses = file.graph, _drive(file)
    order, space = "begins with w, write qx qy qz qw", graph.group.DIMENSION == 3
    if file.w_first:
        order = "ends with w, name the columns in a line above"
    kinds = {"odometry": graph.is_odometry & (poses is None), "closures": ~graph.is_odometry}
    for kind, chosen in kinds.items() if space else ():
        if np.sum(chosen) < _SOME:
            continue
        x = np.abs(Rotation.from_matrix(graph.rotation[chosen]).as_quat()[:, 0])
        if np.median(x) > _AHEAD:
            return f"most of the {kind} turns by half a circle about x; if its quaternion {order}"
    if poses is None or not space:
        return ""
    as_read, other = _way(poses), _way(rolled(poses, 1 if file.w_first else -1))
    half = np.abs(poses[0, :, :3] - np.diag([1, -1, -1])).max() < ROUNDED and not file.w_first
    if half and other >= as_read:
        return f"the first pose is turned by half a circle about x; if its quaternion {order}"
    if as_read < _ASTRAY and other > _AHEAD:
        return f"the robot travels in all directions of its frame; if its quaternion {order}"
    return ""


def _drive(file: GraphFile) -> Array | None:
    """Return the poses of a trajectory; the edges of other files have lines."""
    return None if file.lines.size else file.poses


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


def _few_digits(file: GraphFile) -> str:
    """Doubt a trajectory far from the origin that was printed with six digits."""
    graph, poses = file.graph, _drive(file)
    if poses is None:
        return ""
    claimed = float(np.median(deviations(graph)[0][file.odometry]))
    return few_digits("poses", graph.group.translation(poses), claimed)


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


def _same_ids(file: GraphFile) -> str:
    """Doubt steps of which nearly each is measured twice, and otherwise the second time."""
    graph, n = file.graph, file.graph.n
    pairs = np.sort(graph.edges, axis=1) @ [n, 1]
    steps, others = file.odometry, np.flatnonzero(~graph.is_odometry)
    if not steps.size:
        return ""
    order = steps[np.argsort(pairs[steps])]
    place = np.minimum(np.searchsorted(pairs[order], pairs[others]), order.size - 1)
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
        f"line {file.lines[k]} gives edge {file.named(k)} again with other numbers"
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
    far: Mask = (metres > max(0.2 * usual, claimed[0])) | (radians > max(0.2, claimed[1]))
    return far


def _strange_steps(file: GraphFile) -> str:
    """Doubt single steps that are as long, or as precise, as closures between drives."""
    graph, odometry = file.graph, file.odometry
    if odometry.size < FEW:
        return ""
    length = np.linalg.norm(graph.translation[odometry], axis=1)
    usual = float(np.quantile(length, 0.95))
    far = odometry[length > _LEAP * max(usual, np.finfo(float).tiny)]
    edges, why = _unlike(graph, odometry), "claims what closures claim"
    if far.size:
        edges, why = far, f"is {np.max(length) / usual:.0f} times as long as others"
    if not edges.size:
        return ""
    more = f", and {counted(edges.size - 1, 'other')} like it," if edges.size > 1 else ""
    return (
        f"edge {file.named(edges[0])}{more} counts as odometry, because its ids are neighbours, "
        f"but {why}; if it joins two drives, name it as a closure: {file.as_closure(edges[0])}"
    )


def _steps_back(file: GraphFile) -> str:
    """Doubt a few steps that alone lead from the later to the earlier pose."""
    odometry = file.odometry
    back = odometry[file.graph.edges[odometry, 0] > file.graph.edges[odometry, 1]]
    if not 0 < back.size <= 0.05 * odometry.size:
        return ""
    more = f", as {counted(back.size - 1, 'other')}," if back.size > 1 else ""
    return (
        f"edge {file.named(back[0])}{more} leads back where the other steps lead ahead; if it "
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
    alike, foreign = (
        np.all(np.abs(claims[odometry] - usual) < np.log(_UNLIKE) / 4.0, axis=1)
        for usual in (ours, theirs)
    )
    found: Indices = odometry[foreign & (np.sum(alike) > 0.95 * odometry.size)]
    return found


DOUBTS: dict[str, Callable[[GraphFile], str]] = {
    "degrees": _degrees,
    "covariances": _covariances,
    "w first": _w_first,
    "few digits": _few_digits,
    "same ids": _same_ids,
    "strange steps": _strange_steps,
    "steps back": _steps_back,
}
"""Each returns a sentence, or nothing."""
