"""Both sides of a conversation in one process, where there is no other to be had.

What crosses is copied as it is between processes, so the same values cross and the same
errors are raised.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from robust_slam_autograder.protocol.channel import ChannelClosed, Conversation

Around = Callable[[], AbstractContextManager[None]]
"""What is done around the code of one side."""


class End(Conversation):
    """One side; it works while the other one waits."""

    def __init__(self, around: Around, **options: Any) -> None:  # noqa: ANN401
        """Make one side.

        Args:
            around: entered before a function of this side is called, and left after it.
            options: as in ``Conversation``.
        """
        super().__init__(**options)
        self._around = around
        self._inbox: deque[bytes] = deque()
        self._other = self

    def join(self, other: End) -> None:
        """Connect the two sides."""
        self._other, other._other = other, self

    def look_at_the_time(self) -> None:
        """Raise DeadlineExceeded where this side has waited for as long as it may."""
        self._time_left()

    def is_quiet(self) -> bool:
        """Tell whether no message has come in unasked."""
        return not self._inbox

    def _send(self, payload: bytes) -> None:
        self._other._inbox.append(payload)

    def _arrive(self) -> bytes:
        while not self._inbox:
            self._other._answer_one()
        return self._inbox.popleft()

    def _answer_one(self) -> None:
        kind, number, *rest = self._receive()
        if kind != "call":
            raise ChannelClosed("an answer to no question")
        with self._around():
            self._answer(number, *rest)
