"""A canvas shows each state as its functions draw and describe it, with a kernel and without."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from html import unescape
from html.parser import HTMLParser
from types import SimpleNamespace
from typing import Any

import ipywidgets
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam_course.canvas import Canvas, Checkbox, Choice, Slider, Stepper, live, page

WIDGETS = "application/vnd.jupyter.widget-view+json"
KINDS = {"huber": "Huber's", "tls": "TLS"}


def draw(c: float, lie: bool, kind: str, step: int) -> Figure:
    figure, ax = plt.subplots()
    ax.plot([0, c, 3], [step, 10 * lie, len(kind)])
    return figure


def describe(c: float, lie: bool, kind: str, step: int) -> str:
    return f"c = {c:g}, lie {lie}, {kind}, step {step}"


def table(c: float, lie: bool, kind: str, step: int) -> list[tuple[str, object]]:
    return [("c", c), ("a third", 1 / 3), ("step", step)]


def canvas() -> Canvas:
    """Return a canvas with one control of each kind: 3 · 2 · 2 · 3 = 36 states."""
    controls = [
        Slider("c", "Threshold c", np.linspace(1.0, 2.0, 3), 1.5, format="{:.1f} m"),
        Checkbox("lie", "The lie", initial=True),
        Choice("kind", "Kernel", KINDS, "tls"),
        Stepper("step", count=2, play=True),
    ]
    return Canvas("A trial", controls, draw, describe, table)


def small(**changes: Any) -> Canvas:
    """Return a canvas with a single checkbox."""
    parts = {
        "title": "A trial",
        "controls": [Checkbox("lie", "The lie")],
        "draw": lambda lie: draw(1.0, lie, "", 0),
        "describe": lambda lie: f"lie {lie}",
    }
    return Canvas(**(parts | changes))


@pytest.fixture(scope="module")
def html() -> str:
    return canvas().static_html()


def frames(html: str) -> list[dict[str, Any]]:
    """Return the frames that the script finds in the group."""
    block = re.search(r'<script type="application/json" class="rs-frames">(.*?)</script>', html)
    assert block is not None
    return list(json.loads(block[1]))


class Elements(HTMLParser):
    """The attributes of all elements of a page, by tag."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def of(self, *tags: str) -> list[dict[str, str | None]]:
        return [attributes for tag, attributes in self.found if tag in tags]


def strides(html: str) -> list[int]:
    """Return each control's stride, in the order of the controls."""
    return [
        int(attributes["data-stride"] or 0)
        for _, attributes in Elements(html).found
        if "data-stride" in attributes
    ]


def states() -> Iterator[tuple[tuple[int, ...], dict[str, Any]]]:
    """Return each state: the positions of its controls and their values."""
    values = ([1.0, 1.5, 2.0], [False, True], list(KINDS), [0, 1, 2])
    for positions in itertools.product(*(range(len(v)) for v in values)):
        chosen = [v[k] for v, k in zip(values, positions, strict=True)]
        yield positions, dict(zip(("c", "lie", "kind", "step"), chosen, strict=True))


def test_positions_times_strides_lead_to_the_frame_of_the_state(html: str) -> None:
    found, reach = frames(html), strides(html)
    assert len(found) == 36
    for positions, values in states():
        index = sum(p * stride for p, stride in zip(positions, reach, strict=True))
        assert found[index]["text"] == describe(**values)
        assert found[index]["rows"] == [
            ["c", f"{values['c']:g}"],
            ["a third", "0.333333"],
            ["step", str(values["step"])],
        ]


def test_a_frame_is_what_draw_draws() -> None:
    pictures = {canvas().frame(**values).svg for _, values in itertools.islice(states(), 12)}
    assert len(pictures) == 12
    assert all(picture.startswith("<svg") for picture in pictures)


def test_without_scripts_it_shows_the_initial_state_and_says_so(html: str) -> None:
    first = canvas().frame(c=1.5, lie=True, kind="tls", step=0)
    elements = Elements(html)
    (image,) = elements.of("img")
    assert image["src"] == first.source
    assert image["alt"] == first.text
    assert f"<figcaption>{first.text}</figcaption>" in html
    assert "disabled" in elements.of("fieldset")[0]
    assert "The controls need scripts" in html
    assert elements.of("input")[0]["aria-valuetext"] == "1.5 m"
    assert "checked" in elements.of("input")[1]
    assert [o["value"] for o in elements.of("option") if "selected" in o] == ["1"]


def test_every_control_has_a_name_and_the_group_too(html: str) -> None:
    elements = Elements(html)
    assert elements.of("div")[0]["aria-label"] == "A trial"
    labels = [unescape(text) for text in re.findall(r"<label>.*?<span>(.*?)</span>", html)]
    assert labels == ["Threshold c", "The lie", "Kernel"]
    assert re.findall(r"<button.*?>(.*?)</button>", html) == ["Step", "Play", "Start again"]


def test_a_stepper_plays_only_where_it_is_asked_for() -> None:
    still = Stepper("lie", count=1)
    assert ">Play<" not in small(controls=[still]).static_html()


def test_a_slider_plays_only_where_it_is_asked_for() -> None:
    still, playing = (
        small(controls=[Slider("lie", "Lie", [0, 1, 2], 0, play=play)]).static_html()
        for play in (False, True)
    )
    assert ">Play<" not in still
    assert re.search(r"</label><button [^>]*data-does=\"play\">Play</button></span>", playing)


def test_it_carries_no_id_and_calls_no_address(html: str) -> None:
    outside = [a for _, a in Elements(html).found if "id" in a or "href" in a]
    assert outside == []
    sources = [a["src"] or "" for _, a in Elements(html).found if "src" in a]
    assert all(source.startswith("data:") for source in sources)
    assert not re.search(r"https?://(?!www\.w3\.org/)", html)


def test_the_same_canvas_gives_the_same_bytes() -> None:
    assert small().static_html() == small().static_html()


def test_words_cannot_become_markup() -> None:
    nasty = '</script><!--<script>"&'
    html = small(title=nasty, describe=lambda lie: nasty).static_html()
    assert [frame["text"] for frame in frames(html)] == [nasty, nasty]
    elements = Elements(html)
    assert elements.of("img")[0]["alt"] == elements.of("div")[0]["aria-label"] == nasty
    assert len(elements.of("script")) == 2


def test_without_a_table_there_are_no_numbers() -> None:
    assert "<details>" not in small().static_html()


def test_figures_are_closed() -> None:
    before = plt.get_fignums()
    small().static_html()
    assert plt.get_fignums() == before


class TestLive:
    """The widgets hold the same controls and draw anew."""

    def parts(self, kind: type) -> list[Any]:
        view, found = canvas().live(), []
        waiting: list[Any] = [view]
        while waiting:
            widget = waiting.pop(0)
            waiting.extend(getattr(widget, "children", ()))
            found.append(widget)
        return [widget for widget in found if isinstance(widget, kind)]

    def test_each_control_moves_the_picture_and_the_numbers(self) -> None:
        view = canvas().live()
        _, slider, box, choice, buttons, picture, numbers = view.children
        for move in (
            lambda: setattr(slider, "value", 2.0),
            lambda: setattr(box, "value", False),
            lambda: setattr(choice, "value", "huber"),
            buttons.children[0].click,
        ):
            before = picture.value
            move()
            assert picture.value != before
        assert "c = 2, lie False, huber, step 1" in picture.value
        assert '<th scope="row">step</th><td>1</td>' in numbers.children[0].value

    def test_the_stepper_stops_at_its_last_step_and_starts_again(self) -> None:
        buttons = canvas().live().children[4]
        step, play, restart, told = buttons.children
        for _ in range(5):
            step.click()
        assert (play.value, told.value) == (2, "2 of 2")
        restart.click()
        assert (play.value, told.value) == (0, "0 of 2")

    def test_a_playing_slider_and_its_player_move_together(self) -> None:
        view = small(controls=[Slider("lie", "Lie", [5, 6, 7], 6, play=True)]).live()
        slider, player = view.children[1].children
        assert (player.value, player.max) == (1, 2)
        player.value = 2
        assert slider.value == 7
        assert "lie 7" in view.children[2].value
        slider.value = 5
        assert player.value == 0

    def test_the_words_are_those_of_the_page(self) -> None:
        (choice,) = self.parts(ipywidgets.Dropdown)
        (slider,) = self.parts(ipywidgets.SelectionSlider)
        assert [text for text, _ in choice.options] == list(KINDS.values())
        assert [text for text, _ in slider.options] == ["1.0 m", "1.5 m", "2.0 m"]


class TestBundle:
    """What a notebook keeps of a canvas."""

    def kernel(self, monkeypatch: pytest.MonkeyPatch, *, allow_stdin: bool) -> None:
        request = {"content": {"allow_stdin": allow_stdin}}
        kernel = SimpleNamespace(get_parent=lambda channel: request)
        monkeypatch.setattr(live, "get_ipython", lambda: SimpleNamespace(kernel=kernel))
        monkeypatch.delenv("ROBUST_SLAM_STATIC", raising=False)

    def test_without_a_kernel_it_is_static(self) -> None:
        assert small()._repr_mimebundle_().keys() == {"text/plain", "text/html"}

    def test_with_somebody_at_the_kernel_it_is_both(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.kernel(monkeypatch, allow_stdin=True)
        bundle = small()._repr_mimebundle_()
        assert bundle.keys() == {"text/plain", "text/html", WIDGETS}
        assert bundle["text/html"] == small().static_html()

    @pytest.mark.parametrize(("allow_stdin", "static"), [(False, ""), (True, "1")])
    def test_an_export_or_the_environment_asks_for_the_static_one(
        self, allow_stdin: bool, static: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        self.kernel(monkeypatch, allow_stdin=allow_stdin)
        monkeypatch.setenv("ROBUST_SLAM_STATIC", static)
        assert WIDGETS not in small()._repr_mimebundle_()


class TestBadInput:
    """Each mistake is named with its argument and its fix."""

    def of_states(self, pairs: int) -> Canvas:
        controls = [Slider("c", "c", range(pairs), 0), Checkbox("lie", "lie")]
        return small(controls=controls, draw=lambda c, lie: None, describe=lambda c, lie: "")

    def test_a_page_carries_sixty_frames_and_no_more(self) -> None:
        self.of_states(30)
        with pytest.raises(ValueError, match=r"31 × 2 = 62 states.*at most 60"):
            self.of_states(31)

    def test_frames_that_are_too_heavy(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(page, "MAX_BYTES", 1000)
        with pytest.raises(ValueError, match="draw: 2 frames take"):
            small().static_html()

    @pytest.mark.parametrize("argument", ["draw", "describe", "table"])
    def test_a_function_that_does_not_take_the_names(self, argument: str) -> None:
        with pytest.raises(TypeError, match=rf"{argument}: it takes \(c\).*named lie"):
            small(**{argument: lambda c: None})

    @pytest.mark.parametrize(
        ("build", "message"),
        [
            (lambda: small(controls=[Checkbox("lie", text) for text in "ab"]), "same name"),
            (lambda: small(controls=[]), "controls: empty"),
            (lambda: small().frame(truth=True), "values: truth given.*named lie"),
            (lambda: small().frame(lie=7), "lie: 7 is not one of"),
            (lambda: Slider("c", "c", [1, 2], 3), "initial: slider 'c'.*1, 2"),
            (lambda: Choice("k", "k", ["a", "b"], "c"), "initial: choice 'k'.*a, b"),
            (lambda: Slider("c", "c", [], 0), "values: empty"),
            (lambda: Stepper("t", count=0), "count"),
            (lambda: Checkbox("the lie", "lie"), "name: 'the lie'"),
            (lambda: small(title=" "), "title: empty"),
            (lambda: Checkbox("lie", ""), "label: empty"),
        ],
        ids=lambda value: value if isinstance(value, str) else "",
    )
    def test_a_control_or_a_canvas_that_makes_no_sense(self, build, message: str) -> None:
        with pytest.raises(ValueError, match=message):
            build()

    @pytest.mark.parametrize(
        ("changed", "error", "message"),
        [
            ({"describe": lambda lie: 3}, TypeError, "describe: it returned 3"),
            ({"draw": lambda lie: None}, TypeError, "draw: it returned None"),
            (
                {"describe": lambda lie: "" if lie else "no lie"},
                ValueError,
                "describe, for {'lie': True}: empty",
            ),
        ],
        ids=["no text", "no figure", "no words"],
    )
    def test_a_function_that_returns_something_else(self, changed, error, message) -> None:
        with pytest.raises(error, match=message):
            small(**changed).static_html()


def test_a_slider_forgives_rounding_of_its_initial_value() -> None:
    assert Slider("c", "c", np.arange(0.1, 0.5, 0.1), 0.3).position == 2
