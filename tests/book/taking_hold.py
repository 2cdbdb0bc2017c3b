"""Takes hold of a live picture: drags its handles and moves its controls."""

from __future__ import annotations

from collections.abc import Iterator

from playwright.sync_api import CDPSession, Locator, Page

PICTURE = ".rs-picture[data-live]"
_DRAWN = "picture => picture.querySelector('.rs-stage').innerHTML"
_FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def pictures(page: Page) -> list[Locator]:
    """The pictures of a page that are live."""
    return page.locator(PICTURE).all()


def handles(picture: Locator) -> list[str]:
    """The keys of what can be taken hold of; a handle may go and come back by its key."""
    return [
        str(each.get_attribute("data-handle")) for each in picture.locator("[data-handle]").all()
    ]


def controls(picture: Locator) -> Iterator[Locator]:
    """The controls that change the state, but not those that bring it back or link to it."""
    for each in picture.locator("[data-control]").all():
        if each.get_attribute("data-control") not in ("reset", "link"):
            yield each


def drawn(picture: Locator) -> str:
    """What the picture shows, once it has been drawn."""
    picture.page.evaluate(_FRAMES)
    return str(picture.evaluate(_DRAWN))


def words(picture: Locator) -> str:
    return str(picture.locator(".rs-caption").text_content())


def reset(picture: Locator) -> None:
    picture.locator("[data-control=reset]").click()
    picture.page.evaluate(_FRAMES)


def by_keyboard(picture: Locator, key: str, toward: int) -> None:
    """Move a handle three steps with the arrow keys, to the right and up or back."""
    handle = picture.locator(f"[data-handle='{key}']")
    for arrow in ("ArrowRight", "ArrowUp") if toward > 0 else ("ArrowLeft", "ArrowDown"):
        for _ in range(3):
            handle.press(arrow)


def follows(picture: Locator) -> bool:
    """Tell whether the first handle, moved by keys, changes the picture and its words."""
    for toward in (1, -1):
        before = drawn(picture), words(picture)
        by_keyboard(picture, handles(picture)[0], toward)
        after = drawn(picture), words(picture)
        if before[0] != after[0] and before[1] != after[1]:
            return True
    return False


def by_mouse(picture: Locator, key: str, toward: int) -> None:
    """Drag a handle with the mouse."""
    mouse, (x, y) = picture.page.mouse, _middle(picture, key)
    mouse.move(x, y)
    mouse.down()
    for k in range(1, 6):
        mouse.move(x + 14 * k * toward, y - 9 * k * toward)
    mouse.up()


def by_touch(picture: Locator, key: str, toward: int) -> None:
    """Drag a handle with a finger."""
    x, y = _middle(picture, key)
    swipe(picture.page, x, y, 70 * toward, -45 * toward)


def swipe(page: Page, x: float, y: float, right: float, down: float) -> None:
    """Move a finger over the page from a point."""
    session = page.context.new_cdp_session(page)
    _touch(session, "touchStart", x, y)
    for share in (0.2, 0.4, 0.6, 0.8, 1.0):
        _touch(session, "touchMove", x + share * right, y + share * down)
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    session.detach()


def move(control: Locator) -> None:
    """Give a control another value."""
    match control.evaluate("c => c.type"):
        case "range":
            least, now = control.get_attribute("min"), control.input_value()
            control.press("Home" if float(now) > float(least or 0) else "End")
        case "select-one":
            count = control.evaluate("c => c.options.length")
            control.select_option(index=(control.evaluate("c => c.selectedIndex") + 1) % count)
        case _:
            control.click()


def _middle(picture: Locator, key: str) -> tuple[float, float]:
    # The visible mark is in the middle of the handle's target.
    mark = picture.locator(f"[data-handle='{key}']")
    mark.scroll_into_view_if_needed()
    box = mark.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def _touch(session: CDPSession, kind: str, x: float, y: float) -> None:
    session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
