"""The controls of a canvas: each has a name, finitely many values, and words for them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np


class Control(Protocol):
    """What a canvas asks of a control."""

    @property
    def name(self) -> str:
        """The keyword under which `draw` receives the value."""

    @property
    def label(self) -> str:
        """What stands beside the control."""

    @property
    def states(self) -> tuple[Any, ...]:
        """Every value that the control can have, in order."""

    @property
    def texts(self) -> tuple[str, ...]:
        """The words for each value."""

    @property
    def position(self) -> int:
        """The index of the value to begin with."""


@dataclass(frozen=True)
class Slider:
    """A slider over the numbers `values`; `format` writes one of them, as in "{:g} m".

    With `play` a button lets the values follow each other, from where the slider stands.

    Raises:
        ValueError: no label, no values, or `initial` is not among them.
    """

    name: str
    label: str
    values: Sequence[float]
    initial: float
    format: str = "{:g}"
    play: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        _check_name(self.name)
        check_words("label", self.label)
        _check_some("values", self.states)
        _ = self.position

    @property
    def states(self) -> tuple[float, ...]:
        """The values, as plain numbers."""
        return tuple(np.asarray(self.values).tolist())

    @property
    def texts(self) -> tuple[str, ...]:
        """The formatted values."""
        return tuple(self.format.format(value) for value in self.states)

    @property
    def position(self) -> int:
        """The index of `initial`, which may differ from its value by rounding."""
        near = [k for k, v in enumerate(self.states) if math.isclose(v, self.initial)]
        if not near:
            raise ValueError(
                f"initial: slider {self.name!r} begins at {self.initial}, which is not among its"
                f" values {', '.join(self.texts)}; choose one of them."
            )
        return near[0]


@dataclass(frozen=True)
class Checkbox:
    """A checkbox: False or True."""

    name: str
    label: str
    initial: bool = False

    def __post_init__(self) -> None:
        _check_name(self.name)
        check_words("label", self.label)

    @property
    def states(self) -> tuple[bool, ...]:
        """False, then True."""
        return (False, True)

    @property
    def texts(self) -> tuple[str, ...]:
        """The words off and on."""
        return ("off", "on")

    @property
    def position(self) -> int:
        """0 when it begins unchecked, 1 when checked."""
        return int(self.initial)


@dataclass(frozen=True)
class Choice:
    """A list to choose from: words, or a mapping from the value that `draw` receives to words.

    Raises:
        ValueError: no label, no options, or `initial` is not among them.
    """

    name: str
    label: str
    options: Sequence[str] | Mapping[str, str]
    initial: str

    def __post_init__(self) -> None:
        _check_name(self.name)
        check_words("label", self.label)
        _check_some("options", self.states)
        if self.initial not in self.states:
            raise ValueError(
                f"initial: choice {self.name!r} begins with {self.initial!r}, which is not among"
                f" its options {', '.join(self.states)}; choose one of them."
            )

    @property
    def states(self) -> tuple[str, ...]:
        """The values."""
        return tuple(self.options)

    @property
    def texts(self) -> tuple[str, ...]:
        """The words for the values."""
        options = self.options
        return tuple(options.values()) if isinstance(options, Mapping) else tuple(options)

    @property
    def position(self) -> int:
        """The index of `initial`."""
        return self.states.index(self.initial)


@dataclass(frozen=True)
class Stepper:
    """Buttons that lead through the steps 0, 1, …, `count`, one at a time.

    `draw` receives the number of the step: there are `count` + 1 states. With `play` a
    button lets the steps follow each other.

    Raises:
        ValueError: no label, or `count` is less than 1.
    """

    name: str
    label: str = "Step"
    count: int = field(kw_only=True)
    play: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        _check_name(self.name)
        check_words("label", self.label)
        if self.count < 1:
            raise ValueError(f"count: a stepper needs at least one step, not {self.count}.")

    @property
    def states(self) -> tuple[int, ...]:
        """0, 1, …, `count`."""
        return tuple(range(self.count + 1))

    @property
    def texts(self) -> tuple[str, ...]:
        """How far it is, as in "2 of 5"."""
        return tuple(f"{step} of {self.count}" for step in self.states)

    @property
    def position(self) -> int:
        """0: a stepper begins at the beginning."""
        return 0


def _check_name(name: str) -> None:
    if not name.isidentifier():
        raise ValueError(f"name: {name!r} is no Python name; `draw` takes it as a keyword.")


def check_words(argument: str, text: str) -> None:
    """Check that there is something to read.

    Raises:
        ValueError: there is not.
    """
    if not text.strip():
        raise ValueError(f"{argument}: empty; some hear a page and do not see it, so give words.")


def _check_some(argument: str, states: Sequence[object]) -> None:
    if not states:
        raise ValueError(f"{argument}: empty; a control needs at least one value.")
