"""The static group: native controls, the first frame, and a short script that swaps frames.

The group needs no library and carries no id, so that any number of them share a page. With
scripts off it shows the first frame with its words; the script that takes the controls into
use also hides the sentence that says so.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from html import escape
from importlib.resources import files

from robust_slam_course.canvas.controls import Checkbox, Choice, Control, Slider, Stepper
from robust_slam_course.canvas.frame import Frame

MAX_BYTES = 1_500_000

STYLE = (files(__package__) / "canvas.css").read_text(encoding="utf-8")
SCRIPT = (files(__package__) / "canvas.js").read_text(encoding="utf-8")

_PLAY = '<button type="button" data-does="play">Play</button>'


def group(title: str, controls: Sequence[Control], frames: Sequence[Frame]) -> str:
    """Return the HTML of a canvas; `frames` are in the order of the product of the states.

    Raises:
        ValueError: the frames are larger than 1.5 MB together.
    """
    strides = _strides(controls)
    start = sum(c.position * stride for c, stride in zip(controls, strides, strict=True))
    inputs = "".join(map(_control, controls, strides))
    return (
        f'<div class="rs-canvas" role="group" aria-label="{escape(title)}">'
        f"<style>{STYLE}</style>"
        f'<p class="rs-title">{escape(title)}</p>'
        f'<fieldset class="rs-controls" disabled><legend>Controls</legend>{inputs}</fieldset>'
        '<p class="rs-note">The controls need scripts; the picture shows their first state.</p>'
        f"{_figure(frames[start])}"
        f"{_numbers(frames[start])}"
        '<p class="rs-spoken" aria-live="polite"></p>'
        f'<script type="application/json" class="rs-frames">{_block(frames)}</script>'
        f"</div><script>{SCRIPT}</script>"
    )


def card(frame: Frame) -> str:
    """Return the HTML of a frame's picture and caption with the style that they need."""
    return f'<div class="rs-canvas"><style>{STYLE}</style>{_figure(frame)}</div>'


def _figure(frame: Frame) -> str:
    width, height = frame.size
    return (
        f'<figure><img src="{escape(frame.source)}" alt="{escape(frame.text)}"'
        f' width="{width}" height="{height}">'
        f"<figcaption>{escape(frame.text)}</figcaption></figure>"
    )


def table(frame: Frame) -> str:
    """Return the HTML table of a frame's numbers."""
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td>{escape(value)}</td></tr>'
        for name, value in frame.rows
    )
    return f"<table><tbody>{rows}</tbody></table>"


def _numbers(frame: Frame) -> str:
    if not frame.rows:
        return ""
    return f"<details><summary>Numbers</summary>{table(frame)}</details>"


def _strides(controls: Sequence[Control]) -> list[int]:
    counts = [len(control.states) for control in controls]
    return [math.prod(counts[k + 1 :]) for k in range(len(counts))]


def _block(frames: Sequence[Frame]) -> str:
    """Return the frames as JSON that cannot end the script element it stands in."""
    data = [{"svg": frame.svg, "text": frame.text, "rows": frame.rows} for frame in frames]
    block = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    block = block.replace("</", "<\\/").replace("<!", "\\u003c!")
    size = len(block.encode())
    if size > MAX_BYTES:
        raise ValueError(
            f"draw: {len(frames)} frames take {size / 1e6:.1f} MB, and a canvas on a page carries"
            f" at most {MAX_BYTES / 1e6:.1f} MB; draw fewer points or fewer states."
        )
    return block


def _control(control: Control, stride: int) -> str:
    label = f"<span>{escape(control.label)}</span>"
    match control:
        case Checkbox():
            checked = " checked" if control.initial else ""
            box = f'<input type="checkbox" data-stride="{stride}"{checked}>'
            return f"<label>{box}{label}</label>"
        case Choice():
            return f"<label>{label}{_select(control, stride)}</label>"
        case Stepper():
            return _stepper(control, stride)
        case Slider(play=True):
            slider = f"<label>{label}{_range(control, stride)}</label>"
            return f'<span class="rs-stepper">{slider}{_PLAY}</span>'
        case _:
            return f"<label>{label}{_range(control, stride)}</label>"


def _range(control: Control, stride: int) -> str:
    text = escape(control.texts[control.position])
    return (
        f'<input type="range" min="0" max="{len(control.states) - 1}" step="1"'
        f' value="{control.position}" autocomplete="off" aria-valuetext="{text}"'
        f' data-stride="{stride}" data-texts="{_list(control.texts)}">'
        f'<span class="rs-value" aria-hidden="true">{text}</span>'
    )


def _select(control: Control, stride: int) -> str:
    chosen = {control.position: " selected"}
    options = "".join(
        f'<option value="{k}"{chosen.get(k, "")}>{escape(text)}</option>'
        for k, text in enumerate(control.texts)
    )
    return f'<select autocomplete="off" data-stride="{stride}">{options}</select>'


def _stepper(control: Stepper, stride: int) -> str:
    play = _PLAY if control.play else ""
    return (
        f'<span class="rs-stepper"><button type="button" data-does="step">{escape(control.label)}'
        f'</button>{play}<button type="button" data-does="restart">Start again</button>'
        f'<data class="rs-value" value="0" data-stride="{stride}" data-max="{control.count}"'
        f' data-texts="{_list(control.texts)}">{control.texts[0]}</data></span>'
    )


def _list(texts: Sequence[str]) -> str:
    return escape(json.dumps(texts, ensure_ascii=False))
