"""The widgets of a canvas, for a notebook with a kernel: the same controls, drawn anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import ipywidgets as widgets
from IPython.core.getipython import get_ipython

from robust_slam_course.canvas import page
from robust_slam_course.canvas.controls import Checkbox, Choice, Control, Slider, Stepper
from robust_slam_course.canvas.frame import Frame

MIME = "application/vnd.jupyter.widget-view+json"

_BEAT = 900  # ms from one step to the next while playing
_WIDE = {"description_width": "initial"}


def someone_is_there() -> bool:
    """Tell whether a person runs the cell, and not a program that saves the notebook.

    The request that runs a cell says whether it could answer a question (`allow_stdin`
    in Jupyter's messages). An export or a book build could not: what it saves has no
    kernel later, so widgets would be dead there.
    """
    shell = get_ipython()
    kernel = getattr(shell, "kernel", None)
    if kernel is None:
        return False
    request = kernel.get_parent("shell") or {}
    return bool(request.get("content", {}).get("allow_stdin", False))


def view(title: str, controls: Sequence[Control], draw: Callable[..., Frame]) -> widgets.VBox:
    """Return the widgets; `draw` takes the controls' values and returns the frame to show."""
    parts = {control.name: _widget(control) for control in controls}
    picture, numbers = widgets.HTML(), widgets.HTML()

    def show(_: object = None) -> Frame:
        frame = draw(**{name: holder.value for name, (holder, _) in parts.items()})
        picture.value = page.card(frame)
        numbers.value = page.table(frame)
        return frame

    for holder, _ in parts.values():
        holder.observe(show, names="value")
    heading = widgets.HTML(f"<strong>{escape(title)}</strong>")
    rows = [heading, *(shown for _, shown in parts.values()), picture]
    if show().rows:
        rows.append(widgets.Accordion([numbers], titles=("Numbers",)))
    return widgets.VBox(rows)


def _widget(control: Control) -> tuple[widgets.ValueWidget, widgets.Widget]:
    """Return the widget that holds the value, and the one to show."""
    if isinstance(control, Stepper):
        return _stepper(control)
    if isinstance(control, Checkbox):
        box = widgets.Checkbox(control.initial, description=control.label, indent=False)
        return box, box
    kind = widgets.Dropdown if isinstance(control, Choice) else widgets.SelectionSlider
    widget = kind(
        options=list(zip(control.texts, control.states, strict=True)),
        index=control.position,
        description=control.label,
        style=_WIDE,
    )
    if not (isinstance(control, Slider) and control.play):
        return widget, widget
    player = widgets.Play(max=len(control.states) - 1, interval=_BEAT, show_repeat=False)
    player.value = control.position
    widgets.link((player, "value"), (widget, "index"))
    return widget, widgets.HBox([widget, player])


def _stepper(control: Stepper) -> tuple[widgets.ValueWidget, widgets.Widget]:
    holder = widgets.Play(max=control.count, interval=_BEAT, show_repeat=False)
    step = widgets.Button(description=control.label)
    restart = widgets.Button(description="Start again")
    told = widgets.Label(control.texts[0])

    def tell(change: dict[str, int]) -> None:
        told.value = control.texts[change["new"]]

    def forward(_: object) -> None:
        holder.value = min(holder.value + 1, control.count)

    def back(_: object) -> None:
        holder.value = 0

    holder.observe(tell, names="value")
    step.on_click(forward)
    restart.on_click(back)
    buttons = [step, holder, restart, told] if control.play else [step, restart, told]
    return holder, widgets.HBox(buttons)
