"""A pose graph in SE(2) or SE(3), as arrays, with its residuals and its cost.

Edge k = (i, j) measures z = ``measurement[k]``, pose j in the frame of pose i. Its residual is
Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j), the full logarithm, with the information matrix in the same order:
(ρx, ρy, θ) in SE(2), ρ and then the rotation vector in SE(3). D is 3 in SE(2) and 6 in SE(3).

Source: Grisetti et al. 2010, "A tutorial on graph-based SLAM", with the full logarithm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from robust_slam._arrays import Array, Ids, Indices, Mask, finite, mask, refuse, times
from robust_slam._words import counted
from robust_slam.errors import Underdetermined
from robust_slam.groups import se2
from robust_slam.groups.group import Group, group_of, upward
from robust_slam.groups.rotations import check_rotations

FEW = 8
"""The smallest number of steps that tell what is usual."""
ROWS = ("edges", "measurement", "information", "is_odometry")
"""The arrays that have a row for each edge."""


@dataclass(frozen=True, eq=False, repr=False)
class PoseGraph:
    """Relative poses between ``n`` poses, numbered from 0.

    ``edges`` ``(m, 2)`` holds i and j of each edge; ``measurement`` the pose of j in the frame of
    i, ``(m, 3)`` as [x, y, θ] in m, m, rad or ``(m, 3, 4)`` as [R | t]; ``information``
    ``(m, D, D)``, or ``(D, D)`` for all, its inverse covariance; ``is_odometry`` ``(m,)`` tells
    odometry from loop closures, by default one edge from each pose to the next, where there is
    one. The arrays are copied and read-only. Graphs are equal if all numbers are.

    Raises:
        ValueError: a shape is wrong, an entry is not finite, an index is out of range, a matrix is
            not a rotation, or not symmetric and positive definite, or a pose is not connected.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2], [0, 2]], [[1, 0, 0], [1, 0, 0], [1.9, 0, 0]],
    ...                   np.eye(3))
    >>> graph.is_odometry.tolist()
    [True, True, False]
    >>> round(cost(graph, np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]])), 4)
    0.005
    """

    n: int
    edges: Indices
    measurement: Array
    information: Array
    is_odometry: Mask = None  # type: ignore[assignment]  # found where it is not given

    def __post_init__(self) -> None:
        group = group_of(np.asarray(self.measurement))
        checked = checked_rows(self.n, group, {name: getattr(self, name) for name in ROWS})
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        _check_connected(self.n, self.edges)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PoseGraph):
            return NotImplemented
        same = (np.array_equal(getattr(self, name), getattr(other, name)) for name in ROWS)
        return self.n == other.n and all(same)

    def __hash__(self) -> int:
        return hash((self.n, self.edges.tobytes()))

    def __repr__(self) -> str:
        closures = int(np.sum(~self.is_odometry))
        kind = f"SE({self.group.DIMENSION})"
        edges = f"{counted(len(self.edges), 'edge')}, {closures:,} of them closures"
        return f"<PoseGraph: {self.n:,} poses in {kind}, {edges}>"

    def summary(self) -> str:
        """Return a table of poses, sessions, which odometry connects, and edges.

        Their deviations are medians, in m and in degrees, of one axis.
        """
        sessions = int(connected_parts(self.n, self.edges[self.is_odometry]).max()) + 1
        rows = [
            ("poses", f"{self.n:,} in SE({self.group.DIMENSION})"),
            ("sessions", f"{sessions:,}"),
            ("odometry", _described(self, self.is_odometry)),
            ("closures", _described(self, ~self.is_odometry)),
        ]
        return "\n".join(f"{name:<10} {text}" for name, text in rows)

    __str__ = summary

    @property
    def group(self) -> Group:
        """The module ``se2`` or ``se3`` of the poses."""
        return group_of(self.measurement)

    @cached_property
    def odometry_joins_all(self) -> bool:
        """Whether the odometry alone connects every pose to pose 0."""
        return unreached(self, self.is_odometry).size == 0

    @cached_property
    def inverse_measurement(self) -> Array:
        """The pose of i in the frame of j for each edge, ``(m, 3)`` or ``(m, 3, 4)``."""
        inverse = self.group.inverse(self.measurement)
        inverse.flags.writeable = False
        return inverse

    @property
    def rotation(self) -> Array:
        """The rotation matrices ``(m, d, d)`` of the measurements; d is 2 or 3."""
        return self.group.rotation(self.measurement)

    @property
    def translation(self) -> Array:
        """The translations ``(m, d)`` of the measurements, in m."""
        return self.group.translation(self.measurement)


def checked_rows(n: int, group: Group, rows: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """Return the ``rows`` of ``PoseGraph`` by their names, read-only, or raise its errors.

    Whether the edges connect the ``n`` poses is not checked.
    """
    edges, steps = checked_edges(rows["edges"], n), rows["is_odometry"]
    m = len(edges)
    measurement = checked_poses("measurement", rows["measurement"], group, m)
    steps = steps_of(edges, measurement) if steps is None else steps
    return {
        "edges": edges,
        "measurement": measurement,
        "information": checked_information("information: edge", rows["information"], m, group.DOF),
        "is_odometry": mask("is_odometry", steps, m),
    }


def steps_of(edges: Ids, measurement: Array, robots: Ids | None = None) -> Mask:
    """Return which edges ``(m,)`` are odometry, if nothing but their order can tell.

    For each pair of poses whose numbers follow each other it is the first of the ``edges``
    ``(m, 2)`` from the lower to the higher one, or if there is none, the first edge back. Where
    few pairs have several, one whose ``measurement`` ``(m, …)`` is like no other step gives way to
    one that is. ``robots`` ``(n,)`` tell whose each pose is: odometry joins those of one.

    Source: derived here.
    """
    i, j = edges.T
    near = np.abs(j - i) == 1
    near = np.flatnonzero(near if robots is None else near & (robots[i] == robots[j]))
    pair = edges[near].min(axis=1)
    order = near[np.lexsort((near, j[near] < i[near], pair))]
    _, first, count = np.unique(np.sort(pair), return_index=True, return_counts=True)
    chosen, several = order[first], np.flatnonzero(count > 1)
    if several.size and np.sum(count == 1) >= FEW:
        strange = _strangeness(upward(edges, measurement), order, chosen[count == 1])
        for k in several:
            how = strange[first[k] : first[k] + count[k]]
            chosen[k] = order[first[k] + (0 if how[0] <= 1.0 else np.argmin(how))]
    odometry = np.zeros(i.size, dtype=np.bool_)
    odometry[chosen] = True
    return odometry


def _strangeness(ahead: Array, edges: Indices, steps: Indices) -> Array:
    """Return how far ``edges`` are from the three ``steps`` most alike, in ten usual gaps.

    ``ahead`` ``(m, …)`` are the relative poses in one direction, and lengths count in steps.
    """
    group = group_of(ahead)
    place = group.translation(ahead)
    length = float(np.median(np.linalg.norm(place[steps], axis=1))) or 1.0
    seen = np.concatenate([place / length, group.log(ahead)[:, group.DIMENSION :]], axis=1)
    tree = KDTree(seen[steps])
    # Of a step itself the nearest is the step.
    usual = np.quantile(np.asarray(tree.query(seen[steps], k=4)[0])[:, -1], 0.9)
    gaps = np.asarray(tree.query(seen[edges], k=3)[0])[:, -1]
    return np.asarray(gaps / (10.0 * usual + np.finfo(float).tiny))


def from_checked(n: int, rows: Mapping[str, NDArray[Any]]) -> PoseGraph:
    """Return the graph of ``rows`` that ``checked_rows`` has seen, with nothing copied."""
    graph = object.__new__(PoseGraph)
    object.__setattr__(graph, "n", n)
    for name in ROWS:
        rows[name].flags.writeable = False
        object.__setattr__(graph, name, rows[name])
    return graph


def checked_poses(name: str, value: ArrayLike, group: Group, count: int) -> Array:
    """Return ``value`` as poses ``(count, …)`` of ``group``, read-only, or raise a ValueError."""
    poses = finite(name, value, (count, *group.POSE_SHAPE))
    if group is not se2:  # there every angle is valid
        check_rotations(f"{name}: the left part of entry", group.rotation(poses))
    return poses


def checked_edges(value: ArrayLike, n: int) -> Indices:
    """Return ``value`` as edges ``(m, 2)`` between two of ``n`` poses each, read-only.

    Raises:
        ValueError: n is below 2, the shape or the type differs, or an edge joins no two poses.
    """
    edges = np.array(value)
    if n < 2:
        raise ValueError(f"n is {n}; a graph joins at least 2 poses")
    if edges.ndim != 2 or edges.shape[1] != 2:
        raise ValueError(f"edges: the shape is {edges.shape}; give (m, 2)")
    if not np.issubdtype(edges.dtype, np.integer) and edges.size:
        raise ValueError(f"edges: the entries are {edges.dtype}; give whole numbers")
    outside, (i, j) = np.any((edges < 0) | (edges >= n), axis=1), edges.T
    refuse(outside, lambda k: f"edges: edge {k} is {edges[k].tolist()}; poses are 0 to {n - 1}")
    refuse(i == j, lambda k: f"edges: edge {k} joins pose {i[k]} to itself; drop it")
    edges = edges.astype(np.intp)
    edges.flags.writeable = False
    return edges


def checked_information(told: str, value: ArrayLike, m: int, dof: int) -> Array:
    """Return ``value``, or one matrix for all, as information ``(m, dof, dof)``, read-only.

    ``told`` names an entry in the ValueErrors of ``PoseGraph``, such as "information: edge".
    """
    one_for_all = np.shape(value) == (dof, dof)
    each = np.broadcast_to(np.asarray(value), (m, dof, dof)) if one_for_all else value
    information = finite(told.partition(":")[0], each, (m, dof, dof))
    skew = np.abs(information - np.swapaxes(information, 1, 2)).max(axis=(1, 2), initial=0.0)
    size = np.abs(information).max(axis=(1, 2), initial=0.0)
    refuse(skew > 1e-9 * size, lambda k: f"{told} {k} is not symmetric")
    spectrum = np.linalg.eigvalsh(information)
    indefinite, remedy = ~(spectrum[:, 0] > 0.0), "give the inverse of a covariance"
    refuse(indefinite, lambda k: f"{told} {k} is not positive definite; {remedy}")
    beyond, remedy = out_of_range(spectrum), "give metres and radians"
    refuse(beyond, lambda k: f"{told} {k} is outside 1e-60 to 1e60; {remedy}")
    return information


def out_of_range(spectrum: NDArray[np.floating], limit: float = 1e60) -> Mask:
    """Return which spectra ``(k, D)``, ascending, go beyond ±``limit``, or into (0, 1 / limit).

    Beyond 1e60 the determinants of matrices do not fit double precision.
    """
    smallest, largest = spectrum[:, 0], spectrum[:, -1]
    size = np.maximum(largest, -smallest)
    return np.asarray((size > limit) | ((smallest > 0.0) & (smallest < 1.0 / limit)))


def _check_connected(n: int, edges: Indices) -> None:
    loose = connected_parts(n, edges) > 0
    words = f"({loose.sum()} poses are not); add an edge or drop the poses"
    refuse(loose, lambda k: f"edges: pose {k} is not joined to pose 0 {words}")


def unreached(graph: PoseGraph, used: ArrayLike) -> Indices:
    """Return the poses, ascending, that no path of ``used`` edges ``(m,)`` connects to pose 0."""
    edges = check_graph(graph).edges[mask("used", used, len(graph.edges))]
    return np.flatnonzero(connected_parts(graph.n, edges) > 0)


def connected_parts(n: int, edges: Indices) -> Indices:
    """Return for each of ``n`` poses the number ``(n,)`` of its part; ``edges`` are ``(m, 2)``.

    Parts are numbered from 0 in the order of their smallest poses.
    """
    i, j = edges.T
    # Most graphs join each pose to the next one, and this is quickly seen.
    follows = np.zeros(n, dtype=np.bool_)
    follows[np.maximum(i, j)[np.abs(i - j) == 1]] = True
    if np.all(follows[1:]):
        return np.zeros(n, dtype=np.intp)
    adjacency = csr_array((np.ones(i.size), (i, j)), shape=(n, n))
    _, label = connected_components(adjacency, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse], dtype=np.intp)


def deviations(graph: PoseGraph) -> tuple[Array, Array]:
    """Return what edges claim for a coordinate (m) and an axis (rad), ``(m,)`` each."""
    return spreads(np.linalg.inv(graph.information), graph.group.DIMENSION)


def spreads(covariance: ArrayLike, d: int) -> tuple[Array, Array]:
    """Return deviations, of d places (m) and the rest (rad), of covariances ``(m, dof, dof)``."""
    # Where a matrix is nearly singular, its computed inverse may have a negative entry.
    variances = np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0)
    return np.sqrt(variances[:, :d].mean(axis=1)), np.sqrt(variances[:, d:].mean(axis=1))


def precisions(graph: PoseGraph) -> tuple[Array, Array]:
    """Return κ ``(m,)``, without a unit, and τ ``(m,)`` in 1/m², the precisions of each edge.

    In SE(2) κ = Ω_θθ and τ = 2 / tr(Ω_tt⁻¹), in SE(3) κ = 3 / (2 tr(Ω_RR⁻¹)) and
    τ = 3 / tr(Ω_tt⁻¹), where Ω_tt and Ω_RR are blocks of the information, as in SE-Sync. As
    ‖R − I‖²_F ≈ 2 θ², a small angle costs κ · 2 θ²: in SE(3) as much as in the logarithm cost
    without its ½, in SE(2) twice as much.

    Source: Rosen et al. 2019, the appendix on the measurements' concentration parameters.
    """
    d = graph.group.DIMENSION
    turned, tau = graph.information[:, d:, d:], d / _inverse_traces(graph.information[:, :d, :d])
    return turned[:, 0, 0].copy() if d == 2 else 1.5 / _inverse_traces(turned), tau


def _inverse_traces(blocks: Array) -> Array:
    """Return tr(B⁻¹) ``(m,)``: the sum of principal minors of order d − 1 over det B."""
    minors = np.trace(blocks, axis1=1, axis2=2)
    if blocks.shape[-1] == 3:
        # ½ (tr(B)² − tr(B²)), written without cancellation of large terms.
        pairs = [blocks[:, [i, i, j, j], [i, j, i, j]] for i, j in ((0, 1), (0, 2), (1, 2))]
        minors = sum(p[:, 0] * p[:, 3] - p[:, 1] * p[:, 2] for p in pairs)
    return np.asarray(minors / np.linalg.det(blocks))


def _described(graph: PoseGraph, chosen: Mask) -> str:
    """Return the number of the ``chosen`` edges with their typical standard deviations."""
    if not np.any(chosen):
        return "0"
    metres, radians = (np.median(sigma[chosen]) for sigma in deviations(graph))
    return f"{chosen.sum():,}, each within about {metres:.3g} m and {np.degrees(radians):.3g}°"


def check_graph(
    graph: object, name: str = "graph", remedy: str = "for instance load(path)"
) -> PoseGraph:
    """Return ``graph``.

    Raises:
        TypeError: it is not a pose graph; ``name`` is what it was given as.
    """
    if isinstance(graph, PoseGraph):
        return graph
    remedy = "its attribute graph" if hasattr(graph, "graph") else remedy
    if hasattr(graph, "relative"):
        remedy = "its attribute relative, or solve the whole with factors.solve_factors"
    raise TypeError(f"{name} is a {type(graph).__name__}; give a PoseGraph, {remedy}")


def check_poses(name: str, poses: ArrayLike, graph: PoseGraph) -> Array:
    """Return ``poses`` ``(n, 3)`` or ``(n, 3, 4)`` of ``graph`` as a read-only copy.

    Raises:
        TypeError: ``graph`` is not a pose graph, or ``poses`` are not numbers.
        ValueError: the shape differs, an entry is not finite, or a matrix is not a rotation.
    """
    group = check_graph(graph).group
    if poses is None:
        shape = (graph.n, *group.POSE_SHAPE)
        raise TypeError(f"{name} is None; give an array {shape}, such as spanning_tree(graph)")
    return checked_poses(name, poses, group, graph.n)


def check_weights(weights: ArrayLike | None, graph: PoseGraph) -> Array:
    """Return the weights ``(m,)``, all 1 if None.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: the shape differs, or a weight is not finite or negative.
        Underdetermined: the edges with positive weight do not connect all poses.
    """
    m = len(check_graph(graph).edges)
    full = np.ones(m) if weights is None else finite("weights", weights, (m,))
    refuse(full < 0.0, lambda k: f"weights: edge {k} weighs less than 0")
    used = full > 0.0
    if not (np.all(used) or (graph.odometry_joins_all and np.all(used[graph.is_odometry]))):
        check_joined(connected_parts(graph.n, graph.edges[used]), "edge")
    return full


def check_joined(parts: Indices, link: str) -> None:
    """Refuse weights that leave poses loose: their ``parts`` ``(n,)`` are not that of pose 0.

    Raises:
        Underdetermined: no edge, or another ``link``, of positive weight joins them.
    """
    loose = np.flatnonzero(parts != parts[0])
    if loose.size:
        raise Underdetermined(
            f"weights: no {link} of positive weight joins pose {loose[0]} to pose 0 ({loose.size} "
            f"poses are loose); trust the odometry or keep {'an' * (link == 'edge') or 'a'} {link}"
        )


def residuals(graph: PoseGraph, poses: Array) -> Array:
    """Return Log(z⁻¹ ∘ x_i⁻¹ ∘ x_j) ``(m, D)`` in m and rad, not whitened.

    Source: Grisetti et al. 2010, the error function, with the full logarithm.
    """
    return residuals_of(graph, relative_poses(graph, poses))


def relative_poses(graph: PoseGraph, poses: Array) -> Array:
    """Return x_i⁻¹ ∘ x_j for each edge, pose j in the frame of i: ``(m, 3)`` or ``(m, 3, 4)``."""
    i, j = check_graph(graph).edges.T
    return graph.group.between(poses[i], poses[j])


def residuals_of(graph: PoseGraph, relative: Array) -> Array:
    """Return Log(z⁻¹ ∘ p) ``(m, D)`` in m and rad; p, ``relative``, as in ``relative_poses``."""
    return graph.group.log(graph.group.compose(graph.inverse_measurement, relative))


def squared_norms(graph: PoseGraph, poses: Array) -> Array:
    """Return the squared whitened residual rᵀ Ω r of each edge, ``(m,)``, without a unit."""
    r = residuals(graph, poses)
    return np.asarray(np.maximum(np.sum(r * times(graph.information, r), axis=1), 0.0))


def residual_norms(graph: PoseGraph, poses: Array) -> Array:
    """Return the whitened residual norm of each edge, ``(m,)``: the u of a kernel."""
    return np.sqrt(squared_norms(graph, poses))


def cost(graph: PoseGraph, poses: Array, weights: Array | Mask | None = None) -> float:
    """Return ½ Σ w ‖whitened residual‖²; ``weights`` ``(m,)`` are 1 if None."""
    u2 = squared_norms(graph, poses)
    return 0.5 * float(np.sum(u2 if weights is None else weights * u2))


def linearise(graph: PoseGraph, relative: Array, r: Array) -> Array:
    """Return the Jacobians of the residuals as two factors, ``(2, m, D, D)``.

    ``relative`` are the ``relative_poses`` and ``r`` ``(m, D)`` their residuals, perturbed on the
    right, x ∘ Exp(δ). The first factor is J_j = Jr⁻¹(r), the Jacobian by pose j. With the
    second, −Ad(x_j⁻¹ ∘ x_i), that by pose i is J_i = −J_j Ad(x_j⁻¹ ∘ x_i).

    Source: Solà et al. 2018, the chain rule over between, compose and Log.
    """
    group = graph.group
    factors = np.empty((2, *graph.information.shape))
    factors[0] = group.inverse_right_jacobian(r)
    np.negative(group.adjoint(group.inverse(relative)), out=factors[1])
    return factors


def jacobians(graph: PoseGraph, poses: Array) -> tuple[Array, Array]:
    """Return the Jacobians of the residuals by pose i and by pose j, ``(m, D, D)`` each."""
    relative = relative_poses(graph, poses)
    by_j, transfer = linearise(graph, relative, residuals_of(graph, relative))
    return by_j @ transfer, by_j


def select(graph: PoseGraph, used: ArrayLike) -> PoseGraph:
    """Return ``graph`` with only the edges that the mask ``used`` ``(m,)`` marks.

    Raises:
        ValueError: ``used`` is not a boolean mask, or the marked edges do not connect all poses.

    >>> graph = PoseGraph(2, [[0, 1], [1, 0]], [[1, 0, 0], [5, 0, 0]], np.eye(3))
    >>> select(graph, graph.is_odometry)
    <PoseGraph: 2 poses in SE(2), 1 edge, 0 of them closures>
    """
    chosen = mask("used", used, len(check_graph(graph).edges))
    _check_connected(graph.n, graph.edges[chosen])
    return rows_of(graph, chosen)


def rows_of(graph: PoseGraph, used: Mask) -> PoseGraph:
    """Return the edges that ``used`` ``(m,)`` marks, which need not connect all poses."""
    return from_checked(graph.n, {name: getattr(graph, name)[used] for name in ROWS})


def with_closures(
    graph: PoseGraph, edges: ArrayLike, measurement: ArrayLike, information: ArrayLike
) -> PoseGraph:
    """Return ``graph`` with further loop closures appended to its edges.

    ``edges`` ``(k, 2)``, ``measurement`` ``(k, 3)`` or ``(k, 3, 4)``, and ``information``
    ``(k, D, D)``, or ``(D, D)`` for all.

    Raises:
        ValueError: as ``PoseGraph``.

    >>> graph = PoseGraph(3, [[0, 1], [1, 2]], [[1, 0, 0]] * 2, np.eye(3))
    >>> with_closures(graph, [[0, 2]], [[1.9, 0, 0]], 4 * np.eye(3))
    <PoseGraph: 3 poses in SE(2), 3 edges, 1 of them closures>
    """
    ends, group = np.asarray(edges), check_graph(graph).group
    later = (
        ends.reshape(-1, 2),
        np.asarray(measurement).reshape(-1, *group.POSE_SHAPE),
        np.broadcast_to(np.asarray(information), (len(ends), group.DOF, group.DOF)),
        np.zeros(len(ends), dtype=np.bool_),
    )
    given = zip(ROWS, later, strict=True)
    return PoseGraph(graph.n, *(np.concatenate([getattr(graph, k), rows]) for k, rows in given))


def concatenate(
    graphs: Sequence[PoseGraph], edges: ArrayLike, measurement: ArrayLike, information: ArrayLike
) -> PoseGraph:
    """Return one graph of several, such as drives or robots, that further closures join.

    The poses of each graph follow those of the one before: pose k of ``graphs[1]`` becomes
    ``graphs[0].n + k``. The k closures, arrays ``(k, …)`` as in ``with_closures``, are between
    poses as they are then.

    Raises:
        ValueError: as ``PoseGraph``, for instance where no closure joins a graph to the others;
            there are no graphs, or some are in the plane and others in space.

    >>> drive = PoseGraph(2, [[0, 1]], [[1, 0, 0]], np.eye(3))
    >>> both = concatenate([drive, drive], [[1, 2]], [[0, 1, 0]], np.eye(3))
    >>> both.edges.tolist(), both.is_odometry.tolist()
    ([[0, 1], [2, 3], [1, 2]], [True, True, False])
    """
    if len({check_graph(graph).group.DIMENSION for graph in graphs}) != 1:
        raise ValueError("graphs: give at least one, and all in the plane or all in space")
    first = np.cumsum([0, *(graph.n for graph in graphs)])
    rows = {name: np.concatenate([getattr(graph, name) for graph in graphs]) for name in ROWS}
    rows["edges"] += np.repeat(first[:-1], [len(graph.edges) for graph in graphs])[:, None]
    return with_closures(from_checked(int(first[-1]), rows), edges, measurement, information)
