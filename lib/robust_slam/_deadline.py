"""A limit on CPU time that several stages share."""

from __future__ import annotations

import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Deadline:
    """The moment ``end`` of the CPU clock, in seconds, at which a computation has to end."""

    end: float

    @classmethod
    def after(cls, seconds: float) -> Deadline:
        """Return the deadline in ``seconds`` of CPU time from now; infinity means never.

        Raises:
            ValueError: ``seconds`` is negative or NaN.
        """
        if not seconds >= 0.0:
            raise ValueError(f"max_seconds is {seconds}; give a number of at least 0")
        return cls(time.process_time() + seconds)

    @property
    def left(self) -> float:
        """The seconds that are left, 0 at least."""
        return max(0.0, self.end - time.process_time())

    @property
    def passed(self) -> bool:
        """Whether no time is left."""
        return self.left == 0.0
