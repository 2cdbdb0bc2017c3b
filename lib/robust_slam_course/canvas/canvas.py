"""The canvas itself: checks what it is given, draws a state, and shows itself."""

from __future__ import annotations

import inspect
import itertools
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from robust_slam_course.canvas import page
from robust_slam_course.canvas.controls import Control, check_words
from robust_slam_course.canvas.frame import Frame, to_svg, to_text
from robust_slam_course.style import figure_style

if TYPE_CHECKING:
    import ipywidgets

MAX_FRAMES = 60


@dataclass(frozen=True)
class Canvas:
    """A picture under controls: pre-rendered on a page, redrawn where a kernel runs.

    Each function takes the controls' values as keywords. `draw` returns the figure,
    `describe` one or two plain sentences (the alternative text and the caption), `table`
    the numbers behind the picture as (name, value) pairs.

    Raises:
        ValueError: no title, no controls, two with one name, or more than 60 states in all.
        TypeError: a function does not take the controls' names.
    """

    title: str
    controls: Sequence[Control]
    draw: Callable[..., Figure]
    describe: Callable[..., str]
    table: Callable[..., Iterable[tuple[str, object]]] | None = None

    def __post_init__(self) -> None:
        check_words("title", self.title)
        _check_controls(self.controls)
        for argument in ("draw", "describe", "table"):
            if getattr(self, argument) is not None:
                _check_takes(argument, getattr(self, argument), self.controls)

    def frame(self, **values: object) -> Frame:
        """Draw one state; each control's name is given one of its values.

        Raises:
            ValueError: a name or a value that no control has, or no words for the picture.
            TypeError: `draw` returns no figure, or `describe` no text.
        """
        _check_values(values, self.controls)
        with figure_style():
            figure = self.draw(**values)
            if not isinstance(figure, Figure):
                raise TypeError(f"draw: it returned {figure!r}; return the matplotlib Figure.")
            svg = to_svg(figure)
        text = self.describe(**values)
        if not isinstance(text, str):
            raise TypeError(f"describe: it returned {text!r}; return a sentence (str).")
        check_words(f"describe, for {values}", text)
        rows = [] if self.table is None else self.table(**values)
        return Frame(svg, text, tuple((str(name), to_text(value)) for name, value in rows))

    def static_html(self) -> str:
        """Return a self-contained group of HTML: native controls over pre-rendered frames.

        Raises:
            ValueError: the frames together are larger than a page should carry.
        """
        names = [control.name for control in self.controls]
        states = itertools.product(*(control.states for control in self.controls))
        frames = [self.frame(**dict(zip(names, state, strict=True))) for state in states]
        return page.group(self.title, self.controls, frames)

    def live(self) -> ipywidgets.VBox:
        """Return the same controls as widgets; every change draws anew in the kernel.

        Raises:
            ModuleNotFoundError: ipywidgets is not installed.
        """
        from robust_slam_course.canvas import live

        return live.view(self.title, self.controls, self.frame)

    def _repr_mimebundle_(self, **_: object) -> dict[str, Any]:
        """Return the static group, and the widgets beside it where someone can move them."""
        bundle: dict[str, Any] = {"text/plain": f"Canvas: {self.title}"}
        bundle["text/html"] = self.static_html()
        if os.environ.get("ROBUST_SLAM_STATIC") or find_spec("ipywidgets") is None:
            return bundle
        from robust_slam_course.canvas import live

        if live.someone_is_there():
            widgets = self.live()._repr_mimebundle_()
            bundle[live.MIME] = widgets[live.MIME]
        return bundle


def _check_controls(controls: Sequence[Control]) -> None:
    names = [control.name for control in controls]
    if not names:
        raise ValueError("controls: empty; a canvas needs at least one control.")
    if len(set(names)) < len(names):
        raise ValueError(f"controls: two have the same name ({', '.join(names)}).")
    counts = [len(control.states) for control in controls]
    if math.prod(counts) > MAX_FRAMES:
        raise ValueError(
            f"controls: {' × '.join(map(str, counts))} = {math.prod(counts)} states, and a page"
            f" carries at most {MAX_FRAMES} frames; give a control fewer values."
        )


def _check_takes(argument: str, function: Callable[..., Any], controls: Sequence[Control]) -> None:
    names = [control.name for control in controls]
    signature = inspect.signature(function)
    try:
        signature.bind(**dict.fromkeys(names))
    except TypeError as error:
        raise TypeError(
            f"{argument}: it takes {signature}, but the controls are named {', '.join(names)};"
            " let it take just these names."
        ) from error


def _check_values(values: Mapping[str, object], controls: Sequence[Control]) -> None:
    known = {control.name: control.states for control in controls}
    if set(values) != set(known):
        raise ValueError(
            f"values: {', '.join(values) or 'none'} given, but the controls are named"
            f" {', '.join(known)}; give each of them once."
        )
    for name, value in values.items():
        if value not in known[name]:
            raise ValueError(f"{name}: {value!r} is not one of {known[name]}.")
