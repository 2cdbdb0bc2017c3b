"""A pose graph with priors, GPS fixes, landmarks and ranges, as arrays by kind.

Nodes are numbered: poses from 0 to n − 1 as in the pose graph, landmarks from n on. Factors are
numbered too: first the edges of the pose graph, then priors, positions, points and ranges, each
in its own order. A map is one array ``(n + l, 3)`` or ``(n + l, 3, 4)``, in which a landmark is a
pose without rotation.

Source: Dellaert and Kaess 2017, "Factor graphs for robot perception".
"""

from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask, finite, refuse
from robust_slam._words import counted
from robust_slam.factors.models import POINT, RANGE, RELATIVE, Model
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    check_graph,
    check_poses,
    checked_information,
    checked_poses,
)
from robust_slam.groups.group import Group

FRAME = -1
"""The frame of the map among the ends of a factor."""


@dataclass(frozen=True, eq=False)
class Factors:
    """The factors of one kind: ``nodes``, a ``measurement`` of each, and its ``information``.

    ``nodes`` are ``(k,)`` or ``(k, 2)``, and ``information`` ``(k, d, d)`` is the inverse
    covariance, or ``(d, d)`` for all; what each kind measures is told in ``FactorGraph``.
    """

    nodes: ArrayLike
    measurement: ArrayLike
    information: ArrayLike


class Block(NamedTuple):
    """The k factors of one kind, checked: their ``ends`` ``(k, 2)`` are nodes or ``FRAME``.

    ``root`` ``(k, d, d)`` whitens: it is Lᵀ, where Ω = L Lᵀ.
    """

    name: str
    model: Model
    ends: Indices
    measurement: Array
    root: Array


@dataclass(frozen=True, eq=False, repr=False)
class FactorGraph:
    """A pose graph ``relative`` of n poses, ``landmarks`` in number, and further factors.

    Each kind has ``Factors``, with the ``nodes`` and the measurement of:

    - ``priors``: a pose ``(k,)``, measured in the frame of the map, ``(k, 3)`` or ``(k, 3, 4)``
    - ``positions``, such as GPS: a node ``(k,)``, its position in that frame ``(k, d)`` in m
    - ``points``: a pose and a node ``(k, 2)``, the position of the node, a landmark or another
      pose, in the frame of the pose, ``(k, d)`` in m
    - ``ranges``: two nodes ``(k, 2)``, their distance ``(k,)`` in m; the information is ``(k,)``,
      or one number for all, in 1/m²

    where d is 2 in the plane and 3 in space. Without priors and positions pose 0 is held where it
    is, as in a pose graph; with them nothing is held. The edges of ``relative`` have to connect
    all poses, and each landmark needs a factor.

    Raises:
        TypeError: ``relative`` is not a pose graph.
        ValueError: a shape is wrong, an entry is not finite, a node is out of range or no pose,
            a factor joins a node to itself, an information matrix is not symmetric and positive
            definite, a distance is negative, or a landmark is in no factor.

    >>> import numpy as np
    >>> drive = PoseGraph(2, [[0, 1]], [[1, 0, 0]], [np.eye(3)], [True])
    >>> FactorGraph(
    ...     drive,
    ...     landmarks=1,
    ...     positions=Factors([0, 1], [[5, 5], [6, 5]], 4 * np.eye(2)),
    ...     points=Factors([[0, 2], [1, 2]], [[1, 1], [0, 1]], 25 * np.eye(2)),
    ... )
    <FactorGraph: 2 poses in SE(2), 1 landmark, 1 edge, 2 positions, 2 points>
    """

    relative: PoseGraph
    _: KW_ONLY
    landmarks: int = 0
    priors: Factors | None = None
    positions: Factors | None = None
    points: Factors | None = None
    ranges: Factors | None = None

    def __post_init__(self) -> None:
        check_graph(self.relative)
        if self.landmarks < 0:
            raise ValueError(f"landmarks is {self.landmarks}; give their number, 0 at least")
        lost = np.setdiff1d(np.arange(self.n, self.nodes), self.ends)
        if lost.size:
            raise ValueError(
                f"landmarks: landmark {lost[0] - self.n}, node {lost[0]}, is in no factor "
                f"({lost.size} are in none); leave them out"
            )

    def __repr__(self) -> str:
        kinds = ", ".join(self._counts[1:])
        landmarks = f"{counted(self.landmarks, 'landmark')}, " if self.landmarks else ""
        return f"<FactorGraph: {self._counts[0]}, {landmarks}{kinds}>"

    @property
    def _counts(self) -> list[str]:
        poses = f"{self.n:,} poses in SE({self.group.DIMENSION})"
        nouns = {"relative": "edge"} | {name: name[:-1] for name in _KINDS}
        return [poses, *(counted(len(b.ends), nouns[b.name]) for b in self.blocks)]

    @property
    def n(self) -> int:
        """The number of poses."""
        return self.relative.n

    @property
    def nodes(self) -> int:
        """The number of poses and landmarks."""
        return self.relative.n + self.landmarks

    @property
    def group(self) -> Group:
        """The module ``se2`` or ``se3`` of the poses."""
        return self.relative.group

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The factors of each kind that there is, in their order."""
        edges, information = self.relative.edges, self.relative.information
        first = Block("relative", RELATIVE, edges, self.relative.measurement, _root(information))
        given = ((name, getattr(self, name)) for name in _KINDS)
        further = (_block(self, name, one) for name, one in given if one is not None)
        return (first, *(block for block in further if len(block.ends)))

    @cached_property
    def ends(self) -> Indices:
        """The two ends of each factor, ``(m, 2)``: nodes, or ``FRAME``."""
        return np.concatenate([block.ends for block in self.blocks])

    @cached_property
    def dimensions(self) -> Indices:
        """The dimension of the residual of each factor, ``(m,)``."""
        return np.repeat(
            [block.root.shape[-1] for block in self.blocks],
            [len(block.ends) for block in self.blocks],
        ).astype(np.intp)

    @property
    def slices(self) -> dict[str, slice]:
        """Where the factors of each kind are among all: ``kept[graph.slices["points"]]``."""
        stops = np.cumsum([len(block.ends) for block in self.blocks]).tolist()
        starts = [0, *stops[:-1]]
        return {b.name: slice(*at) for b, *at in zip(self.blocks, starts, stops, strict=True)}

    @property
    def is_trusted(self) -> Mask:
        """The factors ``(m,)`` that are trusted unless told otherwise: odometry and priors."""
        trusted = np.zeros(len(self.ends), dtype=np.bool_)
        trusted[self.slices["relative"]] = self.relative.is_odometry
        trusted[self.slices.get("priors", slice(0))] = True
        return trusted

    def positions_of(self, x: Array) -> Array:
        """Return the positions ``(l, d)`` of the landmarks in a map x ``(n + l, …)``."""
        return self.group.translation(x[self.n :])


_KINDS = ("priors", "positions", "points", "ranges")


def _block(graph: FactorGraph, name: str, given: Factors) -> Block:
    group = graph.group
    ends = _ends(f"{name}.nodes", given.nodes, graph, unary=name in ("priors", "positions"))
    model = {"priors": RELATIVE, "ranges": RANGE}.get(name, POINT)
    size = {"priors": group.DOF, "ranges": 1}.get(name, group.DIMENSION)
    measurement = _measurement(group, name, given, len(ends))
    return Block(name, model, ends, measurement, _information(name, given, len(ends), size))


def _measurement(group: Group, name: str, given: Factors, k: int) -> Array:
    told = f"{name}.measurement"
    if name == "priors":
        return checked_poses(told, given.measurement, group, k)
    if name == "ranges":
        distance = finite(told, given.measurement, (k,))
        refuse(distance < 0.0, lambda k: f"{told}: entry {k} is negative")
        return distance[:, None]
    return finite(told, given.measurement, (k, group.DIMENSION))


def _ends(name: str, value: ArrayLike, graph: FactorGraph, unary: bool) -> Indices:
    """Return the ends ``(k, 2)`` of factors; that of a unary one begins in the frame."""
    nodes = np.array(value)
    expected = "(k,)" if unary else "(k, 2)"
    if nodes.ndim != (1 if unary else 2) or (not unary and nodes.shape[1] != 2):
        raise ValueError(f"{name}: the shape is {nodes.shape}; give {expected}")
    if nodes.size and not np.issubdtype(nodes.dtype, np.integer):
        raise ValueError(f"{name}: the entries are {nodes.dtype}; give numbers of nodes")
    pairs = nodes.astype(np.intp).reshape(len(nodes), -1)
    # Of these only a pose has a frame of its own.
    most = np.full(pairs.shape[1], graph.nodes)
    if name in ("priors.nodes", "points.nodes"):
        most[0] = graph.n
    wrong, last = np.any((pairs < 0) | (pairs >= most), axis=1), graph.nodes - 1
    there = f"landmarks {graph.n} to {last}, and what has a frame is a pose"
    there = there if graph.landmarks else "for landmarks give their number, landmarks=…"
    words = f"poses are 0 to {graph.n - 1}, {there}"
    refuse(wrong, lambda k: f"{name}: entry {k} is {nodes[k].tolist()}; {words}")
    if unary:
        return np.concatenate([np.full_like(pairs, FRAME), pairs], axis=1)
    looped = pairs[:, 0] == pairs[:, 1]
    refuse(looped, lambda k: f"{name}: entry {k} joins a node to itself; drop it")
    return pairs


def _information(name: str, given: Factors, k: int, d: int) -> Array:
    """Return the roots ``(k, d, d)`` of the information matrices of factors."""
    matrices = np.asarray(given.information, dtype=np.float64)
    if name == "ranges":
        matrices = matrices.reshape(*matrices.shape, 1, 1)
    return _root(checked_information(f"{name}.information: entry", matrices, k, d))


def _root(information: Array) -> Array:
    return np.swapaxes(np.linalg.cholesky(information), 1, 2)


def check_map(name: str, x: ArrayLike, graph: FactorGraph) -> Array:
    """Return a map x ``(n + l, …)`` of ``graph``, or a ValueError; landmarks lose rotations."""
    full = finite(name, x, (graph.nodes, *graph.group.POSE_SHAPE))
    check_poses(name, full[: graph.n], graph.relative)
    group = graph.group
    places = group.from_parts(np.eye(group.DIMENSION), group.translation(full[graph.n :]))
    return np.concatenate([full[: graph.n], places])


def as_factor_graph(graph: FactorGraph | PoseGraph) -> FactorGraph:
    """Return ``graph``, or that of the edges of a pose graph alone; another one is a TypeError."""
    return graph if isinstance(graph, FactorGraph) else FactorGraph(graph)
