"""A live picture: what Python knows of it, and how a page or a notebook gets it.

The script of a picture is an ES module with ``render({model, el})``, the convention of
anywidget. In a notebook with a kernel anywidget runs it; on a page a few lines do, with the
data beside them, so that it needs no network. Without scripts, on paper and in exports a
still picture is shown with its words.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from robust_slam_course.canvas import notebook, still
from robust_slam_course.canvas.bundle import bundle
from robust_slam_course.quiz import Question, check_text, prediction
from robust_slam_course.style import variables

if TYPE_CHECKING:
    import anywidget

_DARK = (
    'html[data-theme="dark"] .rs-picture, [data-jp-theme-light="false"] .rs-picture,'
    ' .vscode-dark .rs-picture, html[theme="dark"] .rs-picture'
)
_IDLE = re.compile(r"^\s+|/\*.*?\*/\n?|(?<=:) | (?={)|(?<=[{;},])\n", re.MULTILINE | re.DOTALL)
"""Comments and idle space of the style sheets, which would be a part of every page."""
STYLE = f".rs-picture {{ {variables('light')} }}\n{_DARK} {{ {variables('dark')} }}\n" + "".join(
    _IDLE.sub("", (files(__package__) / f"{name}.css").read_text("utf-8"))
    for name in ("picture", "prediction", "lighting")
)


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture that the reader takes hold of.

    ``name`` is that of its script, ``pictures/<name>.js``, unless it is another picture that
    is embedded again, whose script is then ``script``. ``state`` is what the reader changes,
    ``data`` what stays, both of JSON's values. ``question`` is the reader's prediction, see
    ``quiz.prediction``, and ``tries`` are one thing more to try; ``still`` shows the first state
    and ``caption`` says what it shows. ``answer`` is what differs from the first state where the
    picture shows the answer; where it is empty, the picture is played.

    Raises:
        ValueError: a text is empty, there are no things to try, ``answer`` has what ``state``
            has not, or as ``quiz.prediction``.
        TypeError: ``still`` is no figure, or ``state`` and ``data`` are not of JSON's values.
    """

    name: str
    title: str
    question: Question
    tries: Sequence[str]
    caption: str
    state: Mapping[str, Any]
    data: Mapping[str, Any]
    still: Figure
    answer: Mapping[str, Any] = field(default_factory=dict)
    script: str = ""

    def __post_init__(self) -> None:
        check_text("title", self.title)
        check_text("caption", self.caption)
        for text in self.tries or [""]:
            check_text("tries", text)
        if unknown := self.answer.keys() - self.state.keys():
            raise ValueError(f"answer: {min(unknown)!r} is no part of the state.")
        if not isinstance(self.still, Figure):
            raise TypeError(f"still: {self.still!r} is no matplotlib Figure.")
        # Else a notebook shows the still picture of its own accord, too.
        plt.close(self.still)
        _block(self._traits())

    def _traits(self, *, on_page: bool = False) -> dict[str, Any]:
        texts: dict[str, Any] = {"title": self.title, "tries": list(self.tries)}
        if not on_page:
            texts["question"] = prediction(self.question)
        return {
            "name": self.name, "texts": texts, "state": self.state, "data": self.data,
            "answer": self.answer,
        }  # fmt: skip

    def static_html(self) -> str:
        """Return the picture as HTML that needs nothing else."""
        svg = still.to_svg(self.still)
        tries = (f'<p class="rs-ask">{escape(text)}</p>' for text in self.tries)
        width, height = still.size(svg)
        return (
            f'<style>{STYLE}</style><div class="rs-picture" role="group"'
            f' aria-label="{escape(self.title)}" data-picture="{escape(self.name)}">'
            f'<p class="rs-title">{escape(self.title)}</p>{prediction(self.question)}'
            f'<figure><img src="{escape(still.address(svg))}" alt="{escape(self.caption)}"'
            f' width="{width}" height="{height}">'
            f"<figcaption>{escape(self.caption)}</figcaption></figure>{''.join(tries)}"
            f'<script type="application/json">{_block(self._traits(on_page=True))}</script></div>'
            f"{_scripts(self.name, self.script or self.name)}"
        )

    def widget(self) -> anywidget.AnyWidget:
        """Return the picture as a widget; its ``state`` follows the reader's hand.

        Raises:
            ModuleNotFoundError: anywidget is not installed.
        """
        return _widget_class(self.script or self.name)(**self._traits())

    def _repr_mimebundle_(self, **_: object) -> dict[str, Any]:
        """Return the picture for a page, and the widget beside it where a person runs the cell."""
        found: dict[str, Any] = {"text/plain": f"Picture: {self.title}"}
        found["text/html"] = self.static_html()
        wanted = not os.environ.get("ROBUST_SLAM_STATIC") and find_spec("anywidget")
        if wanted and notebook.someone_is_there():
            shown: Any = self.widget()._repr_mimebundle_()
            # ipywidgets returns the data, anywidget the data and its metadata.
            data = shown[0] if isinstance(shown, tuple) else shown
            found[notebook.MIME] = data[notebook.MIME]
        return found


def _scripts(name: str, script: str) -> str:
    """Return a picture's script, and what brings the picture ``name`` to life with it on a page.

    The first, and the style sheet, are the same in each picture of that script: a page may drop
    all but one.
    """
    return (
        f"<script>(() => {{\n{bundle(script)}\n"
        f"window.rs_{script} = render;\n}})();</script>"
        f"<script>for (const el of document.querySelectorAll("
        f"'[data-picture=\"{name}\"]:not([data-live])')) {{\n"
        "  const given = JSON.parse(el.querySelector('script').textContent);\n"
        "  const model = { get: (key) => given[key], set() {}, save_changes() {} };\n"
        f"  rs_{script}({{ model, el }});\n"
        "}</script>"
    )


@cache
def _widget_class(name: str) -> type[anywidget.AnyWidget]:
    """Return the class of widget for the picture ``name``."""
    import anywidget
    import traitlets

    synced = {key: traitlets.Dict().tag(sync=True) for key in ("texts", "state", "data", "answer")}
    members = {
        "_esm": f"{bundle(name)}\nexport default {{ render }};",
        "_css": STYLE,
        "name": traitlets.Unicode().tag(sync=True),
        **synced,
    }
    return type("PictureWidget", (anywidget.AnyWidget,), members)


def _block(value: Mapping[str, Any]) -> str:
    """Return ``value`` as JSON that cannot end the script element around it."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("</", "<\\/").replace("<!", "\\u003c!")
