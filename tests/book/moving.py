"""Moves the controls of a canvas on a page, by keyboard or by mouse."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any
from urllib.parse import unquote

from playwright.sync_api import Locator

Move = Callable[[Locator, int], None]


def frames(canvas: Locator) -> list[dict[str, Any]]:
    return list(json.loads(canvas.locator(".rs-frames").text_content() or "[]"))


def controls(canvas: Locator) -> list[Locator]:
    return canvas.locator("[data-stride]").all()


def size(control: Locator) -> int:
    """Return how many values a control has."""
    count = "c => c.options?.length ?? (c.type === 'checkbox' ? 2 : Number(c.max ?? 0) + 1)"
    last = control.get_attribute("data-max")
    return int(last) + 1 if last else int(control.evaluate(count))


def kind(control: Locator) -> str:
    return str(control.evaluate("c => c.type ?? 'stepper'"))


def button(control: Locator, does: str) -> Locator:
    return control.locator(f"xpath=..//*[@data-does='{does}']")


def by_keyboard(control: Locator, position: int) -> None:
    """Bring a control from anywhere to a position with keys alone."""
    match kind(control):
        case "checkbox":
            if control.is_checked() != bool(position):
                control.press("Space")
        case "stepper":
            button(control, "restart").press("Enter")
            for _ in range(position):
                button(control, "step").press("Enter")
        case "range":
            control.press("Home")
            for _ in range(position):
                control.press("ArrowRight")
        case _:
            control.press("Home")
            for _ in range(position):
                control.press("ArrowDown")


def by_mouse(control: Locator, position: int) -> None:
    """Bring a control from anywhere to a position with the mouse alone."""
    match kind(control):
        case "checkbox":
            control.set_checked(bool(position))
        case "stepper":
            button(control, "restart").click()
            for _ in range(position):
                button(control, "step").click()
        case "range":
            control.scroll_into_view_if_needed()
            box, thumb = control.bounding_box(), 16
            assert box is not None
            part = position / (size(control) - 1)
            control.click(position={"x": thumb / 2 + part * (box["width"] - thumb), "y": 12})
        case _:
            control.select_option(index=position)


def sweep(knobs: Sequence[Locator], move: Move) -> Iterator[None]:
    """Bring the controls to every combination of positions, the last one turning fastest."""
    if not knobs:
        yield
        return
    for position in range(size(knobs[0])):
        move(knobs[0], position)
        yield from sweep(knobs[1:], move)


def picture(canvas: Locator) -> str:
    return unquote(canvas.locator("img").get_attribute("src") or "").partition(",")[2]
