"""Takes hold of a live picture: drags its handles and moves its controls."""

import json
from collections.abc import Callable, Iterator
from typing import NamedTuple

import pytest
from playwright.sync_api import CDPSession, Locator, Page

PICTURE = ".rs-picture[data-live]"
FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
_SEEN = f"""async (picture) => {{
  await {FRAMES};
  const part = (name) => picture.querySelector(name);
  const drawing = part('.rs-stage').innerHTML, drawn = window.drawings ??= [];
  if (!drawn.includes(drawing)) drawn.push(drawing);
  return [drawn.indexOf(drawing), part('.rs-caption').textContent,
    picture.getBoundingClientRect().height];
}}"""
_CHANGES = """(control) => control.ariaDisabled !== "true" && control.ariaPressed !== "true"
  && !["reset", "link"].includes(control.dataset.control)"""
_RESET = """async (picture) => {
  picture.querySelector('[data-control=reset]').click();
  await new Promise(requestAnimationFrame);
}"""


def pictures(page: Page) -> list[Locator]:
    return page.locator(PICTURE).all()


def handles(picture: Locator) -> list[str]:
    """The keys of what can be taken hold of; a handle may go and come back by its key."""
    return picture.evaluate(
        "picture => Array.from(picture.querySelectorAll('[data-handle]'), h => h.dataset.handle)"
    )


def controls(picture: Locator) -> Iterator[Locator]:
    """The controls that change the state now, but not those that bring it back or link to it."""
    for each in picture.locator("[data-control]").all():
        if each.evaluate(_CHANGES):
            yield each


class Seen(NamedTuple):
    drawing: int  # one number for all that is drawn alike on a page: the drawing is long
    caption: str
    height: float
    """How much of the page it takes, in pixels."""


def seen(picture: Locator) -> Seen:
    """What a picture shows, once it has been drawn."""
    return Seen(*picture.evaluate(_SEEN))


def words(picture: Locator) -> str:
    return str(picture.locator(".rs-caption").text_content())


def reset(picture: Locator) -> None:
    """Press the button that brings the first state back, by a script, which is faster."""
    picture.evaluate(_RESET)


def unfold(picture: Locator) -> None:
    """Open what is folded away below a picture."""
    picture.locator("details").evaluate("more => { more.open = true; }")


def by_keyboard(picture: Locator, key: str, toward: int) -> None:
    """Move a handle three steps with the arrow keys, to the right and up or back.

    It keeps the focus while the picture is drawn again.
    """
    picture.evaluate(f"picture => picture.querySelector({_handle(key)}).focus()")
    for arrow in ("ArrowRight", "ArrowUp") if toward > 0 else ("ArrowLeft", "ArrowDown"):
        for _ in range(3):
            picture.page.keyboard.press(arrow)


def take_hold(picture: Locator, toward: int) -> None:
    """Move the first handle by keyboard, or where there is none, the first control."""
    if keys := handles(picture):
        by_keyboard(picture, keys[0], toward)
    else:
        move(next(controls(picture)))


Way = Callable[[Locator, str, int], None]


def follows(picture: Locator, key: str | None = None, way: Way = by_keyboard) -> bool:
    """Tell whether a handle, by default the first, changes drawing and words, to either side.

    Of a picture without handles it is the first control. The page below it must not move.
    """
    for toward in (1, -1):
        reset(picture)
        first = seen(picture)
        if key is None:
            take_hold(picture, toward)
        else:
            way(picture, key, toward)
        now = seen(picture)
        assert_below_stays(first, now)
        if first.drawing != now.drawing and first.caption != now.caption:
            return True
    return False


def assert_below_stays(first: Seen, now: Seen) -> None:
    """The page below a picture does not move."""
    assert now.height == pytest.approx(first.height, abs=1.0)


def by_mouse(picture: Locator, key: str, toward: int) -> None:
    mouse, (x, y) = picture.page.mouse, middle(picture, key)
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 70 * toward, y - 45 * toward, steps=3)
    mouse.up()


def by_touch(picture: Locator, key: str, toward: int) -> None:
    x, y = middle(picture, key)
    swipe(picture.page, x, y, 70 * toward, -45 * toward)


def swipe(page: Page, x: float, y: float, right: float, down: float) -> None:
    """Move a finger over the page from a point."""
    session = page.context.new_cdp_session(page)
    _touch(session, "touchStart", x, y)
    for share in (0.3, 0.7, 1.0):
        _touch(session, "touchMove", x + share * right, y + share * down)
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    session.detach()


def move(control: Locator) -> None:
    match control.evaluate("c => [c.type, c.value, c.min, c.selectedIndex, c.options?.length]"):
        case ["range", now, least, *_]:
            control.press("Home" if float(now) > float(least or 0) else "End")
        case ["select-one", _, _, chosen, count]:
            control.select_option(index=(chosen + 1) % count)
        case _:
            control.click()


def middle(picture: Locator, key: str) -> tuple[float, float]:
    # The visible mark is in the middle of the handle's target.
    x, y = picture.evaluate(
        f"""picture => {{
          const mark = picture.querySelector({_handle(key)});
          mark.scrollIntoView({{ block: "center", behavior: "instant" }});
          const box = mark.getBoundingClientRect();
          return [box.x + box.width / 2, box.y + box.height / 2];
        }}"""
    )
    return x, y


def _handle(key: str) -> str:
    return json.dumps(f"[data-handle='{key}']")


def _touch(session: CDPSession, kind: str, x: float, y: float) -> None:
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
