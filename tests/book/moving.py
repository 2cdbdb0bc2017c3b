"""Moves the controls of a canvas on a page, by keyboard or by mouse."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from typing import Any
from urllib.parse import unquote

from playwright.sync_api import Locator, Page

Move = Callable[[Locator, int], None]


def frames(canvas: Locator) -> list[dict[str, Any]]:
    return list(json.loads(canvas.locator(".rs-frames").text_content() or "[]"))


def title(canvas: Locator) -> str:
    return str(canvas.get_attribute("aria-label"))


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


def at(control: Locator) -> int:
    """Return the position of a control."""
    place = "c => c.selectedIndex ?? Number(c.type === 'checkbox' ? c.checked : c.value)"
    return int(control.evaluate(place))


def by_keyboard(control: Locator, position: int) -> None:
    """Bring a control from where it is to a position with keys alone."""
    way = position - at(control)
    match kind(control):
        case "checkbox":
            keys, held = ["Space"] * abs(way), control
        case "stepper" if way < 0:
            button(control, "restart").press("Enter")
            keys, held = ["Enter"] * position, button(control, "step")
        case "stepper":
            keys, held = ["Enter"] * way, button(control, "step")
        case "range":
            keys, held = ["ArrowRight" if way > 0 else "ArrowLeft"] * abs(way), control
        case _:
            keys, held = ["ArrowDown" if way > 0 else "ArrowUp"] * abs(way), control
    for key in keys:
        held.press(key)


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


SHOWN = """group => {
  const image = group.querySelector("img");
  const rows = [...group.querySelectorAll("tr")].map(r => [...r.cells].map(c => c.textContent));
  const caption = group.querySelector("figcaption").textContent;
  return {svg: decodeURIComponent(image.src.split(/,(.*)/s)[1]), alt: image.alt, caption, rows};
}"""


def assert_shows(canvas: Locator, frame: dict[str, Any]) -> None:
    """Fail unless picture, alternative text, caption and numbers are those of the frame."""
    svg, text, rows = frame["svg"], frame["text"], frame["rows"]
    assert canvas.evaluate(SHOWN) == {"svg": svg, "alt": text, "caption": text, "rows": rows}


def canvases(page: Page) -> list[Locator]:
    return page.locator(".rs-canvas").all()
