"""A map that grows with the drive, and decides about each closure when it arrives.

Odometry appends poses at no cost. A closure is kept if the map agrees with it, and whenever the
map moves, all closures are decided about again. These decisions begin at the present map, so
descents look further, which find the noise: from the present map when there are a quarter more
closures, and from odometry when there are three times as many. Rejected closures that agree with
each other are forced into the map, and if it costs more with them, a descent from odometry
follows. In a large map a robot must not wait for a descent: each call does a piece of it.

Source: Kaess et al. 2012, "iSAM2", and McGann et al. 2023, "riSAM", for the task; the decisions
are derived here.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from itertools import islice
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._deadline import Deadline
from robust_slam._words import counted
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import (
    ROWS,
    PoseGraph,
    check_graph,
    cost,
    from_checked,
    residual_norms,
    rows_of,
    unreached,
)
from robust_slam.groups.group import group_of
from robust_slam.incremental.decisions import SIZE, State, agreeing, compatible, settled
from robust_slam.incremental.edges import Table, checked, placed
from robust_slam.incremental.window import Window
from robust_slam.progress import stages
from robust_slam.solver import Answer, solve
from robust_slam.solver.candidates import Candidate, Search, Steps, finished
from robust_slam.solver.evidence import evidence, outlier_entropy
from robust_slam.solver.noise import rescaled

VERSION = 2
"""That of a pickled map; it grows with each change of what a map holds."""
_SEARCH = 3.0
"""It descends from odometry when there are so many times the closures of the last time …"""
_REVIEW = 1.25
"""… and from the present map when there are so many times."""
_AT_ONCE = 150
"""With so many edges a call does the whole of it, and from odometry the search of ``solve``."""
_PIECE = 5_000
"""Else it does steps over no more edges than this in all, one at least."""
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
        m = len(graph.edges)
        self._edges = Table(
            **{name: getattr(graph, name) for name in ROWS},
            precise=graph.information,
            number=np.arange(m),
            kept=graph.is_odometry,
            norms=np.full(m, np.nan),
        )
        self._poses = Table(poses=dead_reckoning(graph))
        self._factors: Array = np.ones(4)
        self._next = m
        self._window: Window | None = None
        self._asked = self._searched = self._reviewed = 0
        self._work: Steps[None] | None = None
        self._search()

    @property
    def graph(self) -> PoseGraph:
        """All edges so far that were not removed, in the order of their arrival."""
        return self._graph("information")

    @property
    def poses(self) -> Array:
        """The poses ``(n, 3)`` or ``(n, 3, 4)`` with pose 0 the identity, read-only."""
        return self._poses["poses"]

    @property
    def kept(self) -> Mask:
        """A mask ``(m,)`` of the kept edges of ``graph``, odometry included, read-only."""
        return self._edges["kept"]

    @property
    def numbers(self) -> Indices:
        """The number ``(m,)`` of each edge of ``graph``, as ``add`` returned it, read-only."""
        return self._edges["number"]

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
        group = group_of(self.poses)
        n, rows = checked(len(self.poses), group, edges, measurement, information, is_odometry)
        poses, k = placed(group, self.poses, n, rows), len(rows["edges"])
        numbers = np.arange(self._next, self._next + k)
        self._next += k
        self._poses.append(poses=poses)
        self._edges.append(
            **rows,
            precise=rescaled(from_checked(n, rows), self._factors).information,
            number=numbers,
            kept=rows["is_odometry"],
            norms=np.full(k, np.nan),
        )
        work = self._work
        if k > len(poses):
            self._decide(k, bool(np.sum(rows["is_odometry"]) > len(poses)))
        # A descent that was begun just now waits for the next call: this one has decided.
        for _ in islice(work or (), max(1, _PIECE // len(self.numbers))):
            pass
        return numbers

    def remove(self, edge: int) -> None:
        """Remove the edge with this number, as if it had never arrived.

        Where it was kept, the map is searched for anew.

        Raises:
            ValueError: there is no such edge, it was removed before, or it is odometry without
                which some pose would not be reached.
        """
        graph, numbers = self.graph, self.numbers
        row = int(np.searchsorted(numbers, edge))
        if row == numbers.size or numbers[row] != edge:
            raise ValueError(
                f"edge {edge} was removed before; each edge can be removed once"
                if 0 <= edge < self._next
                else f"there is no edge {edge}; edges are 0 to {self._next - 1}, as add returned"
            )
        loose = unreached(graph, graph.is_odometry & (numbers != edge))
        if loose.size:
            i, j = graph.edges[row].tolist()
            raise ValueError(
                f"edge {edge} ({i}-{j}) is the odometry that leads to pose {loose[0]}; add "
                "odometry in its place before it is removed"
            )
        kept, self._window, self._work = self.kept[row], None, None
        self._edges.remove(row)
        if kept:
            self._search()

    def answer(self, **options: Any) -> Answer:  # noqa: ANN401
        """Return the answer of ``solve`` for ``graph``, with its ``options``, such as progress."""
        probability, find_noise = self._options
        return solve(self.graph, probability, find_noise=find_noise, **options)

    def _graph(self, information: str) -> PoseGraph:
        """Return the graph with the ``information`` as claimed, or ``precise`` with the noise."""
        rows = {name: self._edges[name] for name in ROWS}
        return from_checked(len(self.poses), rows | {"information": self._edges[information]})

    def _decide(self, count: int, moved: bool) -> None:
        """Decide about the last ``count`` edges; ``moved`` where odometry alone moves the map."""
        closures = int(np.sum(~self._edges["is_odometry"]))
        if closures >= max(1, _SEARCH * self._searched):
            if len(self.numbers) <= _AT_ONCE:
                self._search()
                return
            self._searched = closures
            self._review(dead_reckoning(self.graph))
        elif closures >= max(1, _REVIEW * self._reviewed):
            self._review(self.poses)
        graph, window, c = self._graph("precise"), self._window, self._threshold
        new = ~graph.is_odometry
        new[:-count] = False
        norms = self._edges["norms"].copy()
        later = np.isnan(norms)
        norms[later] = residual_norms(rows_of(graph, later), self.poses)
        state = State(self.poses, self.kept, norms)
        asked = ~state.kept & (new | (norms <= _REACH * c))
        agrees = asked & (norms <= c)
        if np.any(asked & ~agrees):
            if window is None or window.size(graph, state.kept | new) > SIZE:
                window = Window(graph, state.poses, state.kept)
            agrees = compatible(window, graph, state, asked, c)
        if np.any(agrees) or moved:
            window, state = settled(window, graph, replace(state, kept=state.kept | agrees), c)
        self._take(state, window)
        far = ~state.kept & (state.norms > _REACH * c)
        if np.any(new & far) and self._work is None:
            agreed = agreeing(graph, far, new & far, self.numbers >= self._asked, c)
            if np.any(agreed):
                self._force(graph, state, agreed)

    def _force(self, graph: PoseGraph, state: State, agreed: Mask) -> None:
        """Take the map with closures that agree if it costs less, or descend from odometry."""
        self._asked, c = int(self.numbers[-1]) + 1, self._threshold
        window, rival = settled(self._window, graph, replace(state, kept=state.kept | agreed), c)
        # Each rejected closure costs ½ c², so each that is kept saves as much.
        saved = c**2 / 2 * float(rival.kept.sum() - state.kept.sum())
        if cost(graph, rival.poses, rival.kept) - saved < cost(graph, state.poses, state.kept):
            self._take(rival, window)
        else:
            self._review(dead_reckoning(self.graph))

    def _search(self) -> None:
        """Take the map of the whole search."""
        found = self._started(dead_reckoning(self.graph)).candidates()
        self._searched = self._reviewed
        self._adopt(max(found, key=lambda one: one.evidence))

    def _review(self, x0: Array) -> None:
        """Begin a descent from ``x0`` ``(n, …)``, or do it at once, unless one is under way."""
        if self._work is None:
            self._work = self._reviewing(self._started(x0))
            if len(self.numbers) <= _AT_ONCE:
                finished(self._work)

    def _reviewing(self, search: Search) -> Steps[None]:
        """Take the map and the noise of the descent of a ``search``, if they explain more."""
        best = yield from search.reviewing()
        m, precise = best.kept.size, rescaled(search.graph, best.found)
        now = evidence(precise, self.poses[: len(search.x0)], self.kept[:m], search.entropy)
        if best.evidence >= now:
            yield
            self._adopt(best)
        self._work = None

    def _adopt(self, best: Candidate) -> None:
        """Take a map, and the deviations that its closures were tested with.

        Poses that came later keep their place beside its last one, and edges their decisions.
        """
        self._factors = best.tested
        self._edges.put(precise=rescaled(self.graph, best.tested).information)
        graph, n, m = self._graph("precise"), len(best.poses), best.kept.size
        moved = graph.group.compose(best.poses[-1], graph.group.inverse(self.poses[n - 1]))
        poses = np.concatenate([best.poses, graph.group.compose(moved, self.poses[n:])])
        kept = np.concatenate([best.kept, self.kept[m:]])
        self._take(State(poses, kept, residual_norms(graph, poses)), None)

    def _started(self, x0: Array) -> Search:
        """Return the search of ``solve`` from ``x0`` ``(n, …)``."""
        graph, odometry = self.graph, self._edges["is_odometry"]
        self._asked, self._reviewed = int(self.numbers[-1]) + 1, int(np.sum(~odometry))
        c, learns, never = self._threshold, self._options[1], Deadline.after(inf)
        entropy, slips = outlier_entropy(graph), np.zeros_like(odometry)
        with stages(False) as tell:
            return Search(graph, x0, odometry, odometry, c, learns, tell, never, entropy, slips)

    def _take(self, state: State, window: Window | None) -> None:
        self._poses.put(poses=state.poses)
        self._edges.put(kept=state.kept, norms=state.norms)
        self._window = window
