"""A map that grows with the drive, and decides about each closure when it arrives.

Odometry appends poses at no cost. A closure is kept if the map agrees with it, and whenever the
map moves, all closures are decided about again. These decisions begin at the present map, so
descents look further, which find the noise: from the present map when there are a quarter more
closures, and from odometry when there are three times as many, or where rejected closures agree
with each other. In a large map a robot must not wait for one, so each call does a piece of it.

Source: Kaess et al. 2012, "iSAM2", and McGann et al. 2023, "riSAM", for the task; the decisions
are derived here.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from itertools import islice
from math import inf
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._deadline import Deadline
from robust_slam._words import counted
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, residual_norms, rows_of
from robust_slam.incremental.decisions import SIZE, State, agreeing, compatible, settled
from robust_slam.incremental.edges import Growing, GrowingEdges, placed
from robust_slam.incremental.window import Window
from robust_slam.progress import stages
from robust_slam.solver import Answer, solve
from robust_slam.solver.candidates import Candidate, Search, Steps, evidence_of, finished
from robust_slam.solver.evidence import evidence, outlier_entropy
from robust_slam.solver.noise import rescaled

Scalar = TypeVar("Scalar", bound=np.generic)

VERSION = 1
"""That of a pickled map; it grows with each change of what a map holds."""

_SEARCH = 3.0
"""It descends from odometry when there are so many times the closures of the last time …"""
_REVIEW = 1.25
"""… and from the present map when there are so many times."""
_AT_ONCE = 150
"""With so many edges a call does the whole of it, and from odometry the search of ``solve``."""
_PIECE = 5_000
"""Else it does steps over no more edges than this in all, one at least."""
_GROUP = 3
"""So many rejected closures that agree, and came since the last search, ask for another."""
_REACH = 1.5
"""Rejected closures are asked again while their residual is at most so many thresholds."""


class GrowingMap:
    """The robust map of a graph whose edges arrive one after the other, and may be taken back.

    It begins with the map of ``graph``, whose odometry joins all poses; one edge is enough.
    ``probability`` and ``find_noise`` are those of ``solve``. Odometry is trusted. Where further
    closures contradict one that was kept, it is withdrawn, and one that was rejected returns
    where they confirm it. ``answer`` is the one of ``solve`` for the edges so far. A map can be
    copied and, for a robot that stops, pickled: it goes on where it was.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: odometry does not lead to some pose, or ``probability`` is not inside (0, 1).
        Underdetermined: the edges do not determine the map to working precision; ``add`` and
            ``remove`` raise it as well.

    Source: the task of McGann et al. 2023; the decisions are derived here.

    >>> growing = GrowingMap(PoseGraph(2, [[0, 1]], [[1, 0, 0]], [np.eye(3)], [True]))
    >>> growing.add([[1, 2]], [[1, 0, 0]], np.eye(3)).tolist()
    [1]
    >>> growing.add([[0, 2], [0, 2]], [[2.1, 0, 0], [9, 9, 0]], np.eye(3)).tolist()
    [2, 3]
    >>> growing.kept.tolist()
    [True, True, True, False]
    >>> growing.remove(3)
    >>> growing
    <GrowingMap: 3 poses, 3 of 3 edges kept>
    """

    def __init__(
        self, graph: PoseGraph, probability: float = 0.99, *, find_noise: bool = True
    ) -> None:
        self._threshold = chi_square_threshold(probability, check_graph(graph).group.DOF)
        self._options = probability, find_noise
        self._edges = GrowingEdges(graph)
        self._poses = Growing(dead_reckoning(graph))
        self._kept = Growing(graph.is_odometry)
        self._norms: Array = np.zeros(0)
        self._window: Window | None = None
        self._asked = self._searched = self._reviewed = 0
        self._work: Steps[None] | None = None
        self._search()

    @property
    def graph(self) -> PoseGraph:
        """All edges so far that were not removed, in the order of their arrival."""
        return self._edges.graph

    @property
    def poses(self) -> Array:
        """The poses ``(n, 3)`` or ``(n, 3, 4)`` with pose 0 the identity, read-only."""
        return _still(self._poses.rows)

    @property
    def kept(self) -> Mask:
        """A mask ``(m,)`` of the kept edges of ``graph``, odometry included, read-only."""
        return _still(self._kept.rows)

    @property
    def numbers(self) -> Indices:
        """The number ``(m,)`` of each edge of ``graph``, as ``add`` returned it, read-only."""
        return _still(self._edges.number)

    def __repr__(self) -> str:
        kept = f"{int(self.kept.sum()):,} of {counted(self.kept.size, 'edge')} kept"
        return f"<GrowingMap: {counted(len(self.poses), 'pose')}, {kept}>"

    def __getstate__(self) -> dict[str, object]:
        if self._work is not None:  # of a descent under way nothing can be kept
            finished(self._work)
        return {**vars(self), "_window": None, "version": VERSION}

    def __setstate__(self, state: dict[str, object]) -> None:
        written = state.pop("version", None)
        if written != VERSION:
            raise ValueError(
                f"this GrowingMap was written in version {written} of its file, and the library "
                f"reads {VERSION}; add its edges to a new GrowingMap"
            )
        vars(self).update(state)

    def __copy__(self) -> GrowingMap:
        return deepcopy(self)

    def add(
        self,
        edges: ArrayLike,
        measurement: ArrayLike,
        information: ArrayLike,
        is_odometry: ArrayLike | None = None,
    ) -> Indices:
        """Take further edges, decide about the closures, and return the edges' numbers ``(k,)``.

        ``edges`` ``(k, 2)``, ``measurement`` ``(k, 3)`` or ``(k, 3, 4)``, ``information``
        ``(k, D, D)`` or ``(D, D)`` for all, and ``is_odometry`` ``(k,)`` are as in ``PoseGraph``.
        By default the edges from the pose before to a new pose are odometry. New poses have the
        numbers that follow. Edges that are refused change nothing. Numbers count all edges, those
        of the first graph among them, from 0.

        Raises:
            ValueError: as ``PoseGraph``, or no odometry leads to a new pose.
        """
        n, rows = self._edges.checked(edges, measurement, information, is_odometry)
        poses = placed(self._edges.group, self._poses.rows, n, rows)
        numbers = self._edges.append(n, rows)
        self._poses.append(poses)
        self._kept.append(rows["is_odometry"])
        if numbers.size > len(poses):
            self._decide(numbers.size, bool(np.sum(rows["is_odometry"]) > len(poses)))
        for _ in islice(self._work or (), max(1, _PIECE // len(self._edges.number))):
            pass
        return numbers

    def remove(self, edge: int) -> None:
        """Remove the edge with this number, as if it had never arrived.

        Where it was kept, the map is searched for anew.

        Raises:
            ValueError: there is no such edge, it was removed before, or it is odometry without
                which some pose would not be reached.
        """
        row = self._edges.row_of(edge)
        kept = self._kept.rows[row]
        self._edges.remove(row)
        self._kept = Growing(np.delete(self._kept.rows, row))
        self._norms, self._window, self._work = np.delete(self._norms, row), None, None
        if kept:
            self._search()

    def answer(self, **options: Any) -> Answer:  # noqa: ANN401
        """Return the answer of ``solve`` for ``graph``, with its ``options``, such as progress."""
        probability, find_noise = self._options
        return solve(self.graph, probability, find_noise=find_noise, **options)

    @property
    def _closures(self) -> int:
        return int(np.sum(~self.graph.is_odometry))

    def _decide(self, count: int, moved: bool) -> None:
        """Decide about the last ``count`` edges; ``moved`` where odometry alone moves the map."""
        graph, closures = self.graph, self._closures
        if closures >= max(1, _SEARCH * self._searched):
            if len(graph.edges) <= _AT_ONCE:
                self._search()
                return
            self._searched = closures
            self._review(dead_reckoning(graph))
        elif closures >= max(1, _REVIEW * self._reviewed):
            self._review(self.poses)
        precise = self._edges.precise
        new = ~graph.is_odometry
        new[:-count] = False
        state, window, c = self._state(), self._window, self._threshold
        if window is None or window.size(precise, state.kept | new) > SIZE:
            window = Window(precise, state.poses, state.kept)
        asked = ~state.kept & (new | (state.norms <= _REACH * c))
        agrees = asked & (state.norms <= c)
        if np.any(asked & ~agrees):
            agrees = compatible(window, precise, state, asked, c)
        if np.any(agrees) or moved:
            state = replace(state, kept=state.kept | agrees)
            window, state = settled(window, precise, state, c)
        self._take(state, window)
        far = ~state.kept & (state.norms > _REACH * c)
        if np.any(new & far):
            agreed = agreeing(precise, far, new & far, c)
            if np.sum(agreed & (self._edges.number >= self._asked)) >= _GROUP:
                self._review(dead_reckoning(graph))

    def _state(self) -> State:
        """Return the present map, with the residual norms of edges that came since."""
        precise, poses = self._edges.precise, self._poses.rows
        later = np.arange(len(precise.edges)) >= len(self._norms)
        norms = residual_norms(rows_of(precise, later), poses)
        self._norms = np.concatenate([self._norms, norms])
        return State(poses, self._kept.rows, self._norms)

    def _search(self) -> None:
        """Take the map of the whole search."""
        self._searched = self._closures
        self._adopt(max(self._started(dead_reckoning(self.graph)).candidates(), key=evidence_of))

    def _review(self, x0: Array) -> None:
        """Begin a descent from ``x0`` ``(n, …)``, or do it at once, unless one is under way."""
        if self._work is None:
            self._work = self._reviewing(x0)
            if len(self._edges.number) <= _AT_ONCE:
                finished(self._work)

    def _reviewing(self, x0: Array) -> Steps[None]:
        """Take the map and the noise of a descent from ``x0`` ``(n, …)``, if they explain more."""
        search = self._started(x0)
        best = yield from search.reviewing()
        m, precise = best.kept.size, rescaled(search.graph, best.found)
        now = evidence(precise, self.poses[: len(x0)], self.kept[:m], search.entropy)
        if best.evidence >= now:
            yield
            self._adopt(best)
        self._work = None

    def _adopt(self, best: Candidate) -> None:
        """Take a map, and the deviations that its closures were tested with.

        Poses that came later keep their place beside its last one, and edges their decisions.
        """
        group, n, m = self._edges.group, len(best.poses), best.kept.size
        self._edges.rescale(best.tested)
        poses, kept = self._poses.rows.copy(), self._kept.rows.copy()
        moved = group.compose(best.poses[n - 1], group.inverse(poses[n - 1]))
        poses[:n], poses[n:], kept[:m] = best.poses, group.compose(moved, poses[n:]), best.kept
        norms = residual_norms(self._edges.precise, poses)
        self._take(State(poses, kept, norms), None)

    def _started(self, x0: Array) -> Search:
        """Return the search of ``solve`` from ``x0`` ``(n, …)``."""
        graph = self.graph
        self._asked, self._reviewed = int(self._edges.number[-1]) + 1, self._closures
        with stages(False) as tell:
            return Search(
                graph=graph,
                x0=x0,
                given=graph.is_odometry,
                trusted=graph.is_odometry,
                threshold=self._threshold,
                learns=self._options[1],
                tell=tell,
                deadline=Deadline.after(inf),
                entropy=outlier_entropy(graph),
                slips=np.zeros(len(graph.edges), dtype=np.bool_),
            )

    def _take(self, state: State, window: Window | None) -> None:
        self._poses, self._kept = Growing(state.poses), Growing(state.kept)
        self._norms, self._window = state.norms, window


def _still(rows: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return a read-only view."""
    view = rows.view()
    view.flags.writeable = False
    return view
