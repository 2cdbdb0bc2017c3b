"""The result of a robust solve: the solution, the reason for stopping, and every step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

from robust_slam._arrays import Array

X = TypeVar("X")


class StopReason(Enum):
    """Why the loop ended.

    - CONVERGED: the residuals have settled, or the rule's schedule is complete.
    - BINARY_WEIGHTS: every weight is 0 or 1, so each measurement is kept or rejected. With
      the odometry trusted, all others may be rejected: the map is then dead reckoning.
    - NOTHING_TO_REJECT: no residual of the first solution is large enough for an outlier.
    - ALL_REJECTED: every untrusted measurement has weight 0 and the others do not determine
      x; the result is the previous x.
    - UNDERDETERMINED: some untrusted measurements have positive weight, but no solution
      exists with these weights; the result is the previous x.
    - ITERATION_LIMIT: the iterations are used up; the weights may not be final.
    """

    CONVERGED = "converged"
    BINARY_WEIGHTS = "binary weights"
    NOTHING_TO_REJECT = "nothing to reject"
    ALL_REJECTED = "all rejected"
    UNDERDETERMINED = "underdetermined"
    ITERATION_LIMIT = "iteration limit"


@dataclass(frozen=True)
class Step(Generic[X]):
    """One iteration of the loop.

    ``weights`` ``(m,)`` were computed at the previous x; ``x`` is the solution with them;
    ``cost`` is the robust cost at this ``x``; ``mu`` is the state that the rule used, None
    for a rule without one. Step 0 is the start, with weights 1.
    """

    x: X
    weights: Array
    cost: float
    mu: float | None


@dataclass(frozen=True)
class Result(Generic[X]):
    """The last step, the reason for stopping there, and the history that led to it."""

    x: X
    weights: Array
    cost: float
    stop: StopReason
    history: tuple[Step[X], ...]

    @classmethod
    def ending(cls, history: Sequence[Step[X]], stop: StopReason) -> Result[X]:
        """Return the result whose solution is the last step of ``history``."""
        last = history[-1]
        return cls(last.x, last.weights, last.cost, stop, tuple(history))
