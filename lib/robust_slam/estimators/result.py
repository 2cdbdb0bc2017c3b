"""The result of a robust solve: the solution, the reason for stopping, and every step."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Generic, Self, TypeVar

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam._words import counted

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
    - TIME_LIMIT: the time is used up; the weights may not be final.
    """

    CONVERGED = "converged"
    BINARY_WEIGHTS = "binary weights"
    NOTHING_TO_REJECT = "nothing to reject"
    ALL_REJECTED = "all rejected"
    UNDERDETERMINED = "underdetermined"
    ITERATION_LIMIT = "iteration limit"
    TIME_LIMIT = "time limit"


KEPT = 0.5
"""A measurement counts as kept when its weight is above this."""
_ROWS = 12


@dataclass(frozen=True, eq=False, repr=False)
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

    def __repr__(self) -> str:
        mu = "" if self.mu is None else f", mu {self.mu:.4g}"
        return f"<Step: cost {self.cost:.6g}{mu}, {_kept(self.weights)}>"


@dataclass(frozen=True, eq=False, repr=False)
class Result(Generic[X]):
    """The last step, the reason for stopping there, and the history that led to it.

    On a pose graph ``poses`` is another name for x. ``kept`` ``(m,)`` marks the measurements
    whose weight is above ½.
    """

    x: X
    weights: Array
    cost: float
    stop: StopReason
    history: tuple[Step[X], ...]

    @property
    def poses(self) -> X:
        """The solution x: on a pose graph its poses."""
        return self.x

    @property
    def kept(self) -> Mask:
        """The measurements ``(m,)`` whose weight is above ½."""
        return np.asarray(self.weights > KEPT)

    def __repr__(self) -> str:
        steps = counted(len(self.history) - 1, "step")
        end = f"{self.stop.value} after {steps}, cost {self.cost:.6g}"
        return f"<Result: {end}, {_kept(self.weights)}>"

    def summary(self) -> str:
        """Return the history as a table: μ, cost and number of kept measurements.

        A long history is thinned to at most a dozen rows, the first and the last among them.
        """
        shown = np.unique(np.linspace(0, len(self.history) - 1, _ROWS).round().astype(int))
        rows = ["step          mu          cost    kept"]
        for k in shown:
            step = self.history[k]
            mu = "-" if step.mu is None else f"{step.mu:.4g}"
            kept = int(np.sum(step.weights > KEPT))
            rows.append(f"{k:4d}  {mu:>10}  {step.cost:12.6g}  {kept:6d}")
        return "\n".join([*rows, f"stopped: {self.stop.value}"])

    __str__ = summary

    @classmethod
    def ending(cls, history: Sequence[Step[X]], stop: StopReason) -> Self:
        """Return the result whose solution is the last step of ``history``."""
        last = history[-1]
        return cls(last.x, last.weights, last.cost, stop, tuple(history))


def _kept(weights: Array) -> str:
    return f"{int(np.sum(weights > KEPT))} of {weights.size} measurements kept"
