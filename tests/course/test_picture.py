"""A live picture: what it is given, and what a page and a notebook get."""

import gzip
import json
import re
from html import unescape
from typing import Any

import pytest
from matplotlib import pyplot as plt
from robust_slam_course import pictures
from robust_slam_course.canvas import bundle as bundling
from robust_slam_course.canvas import notebook, still
from robust_slam_course.canvas.bundle import bundle
from robust_slam_course.canvas.picture import Picture
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

NAMES = sorted(set(pictures.__all__))
# So that a page with two of them has at most 60 KB.
MOST_BYTES = 30_000


def picture(**changes: Any) -> Picture:
    given = {
        "name": "opening",
        "title": "A </script> & <b>title</b>",
        "question": ask("What <b>?", {"7": "c.", "3": "d."}, right="7"),
        "tries": ["move it"],
        "caption": "What is seen.",
        "state": {"robust": False, "wrong": [[1, 4]]},
        "data": {"text": "</script><!--"},
        "still": plt.figure(),
    }
    return Picture(**(given | changes))


def embedded(html: str) -> dict[str, Any]:
    """The data inside a page."""
    found = re.search(r'<script type="application/json">(.*?)</script>', html, re.S)
    assert found
    return dict(json.loads(found[1]))


class TestPage:
    def test_it_holds_the_words_and_the_data_and_is_the_same_each_time(self):
        html = picture().static_html()
        data = embedded(html)
        assert data["state"] == {"robust": False, "wrong": [[1, 4]]}
        assert data["data"] == {"text": "</script><!--"}
        assert data["texts"] == {"title": picture().title, "tries": ["move it"]}
        assert "A &lt;/script&gt; &amp; &lt;b&gt;title&lt;/b&gt;" in html
        assert html.count("</script>") == 3 and "<!--" not in html
        words = unescape(re.sub(r"<[^>]+>", "", html.split("<script>")[0]))
        assert "Predict: What <b>?" in words and "move it" in words
        assert html.count("What is seen.") == 2, "as the still picture's words and as its caption"
        with figure_style():
            assert pictures.opening().static_html() == pictures.opening().static_html()


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"title": " "}, ValueError, "title: empty"),
        ({"caption": ""}, ValueError, "caption: empty"),
        ({"tries": []}, ValueError, "tries: empty"),
        ({"tries": ["a", ""]}, ValueError, "tries: empty"),
        ({"state": {"x": float("nan")}}, ValueError, "JSON"),
        ({"answer": {"no": 1}}, ValueError, "answer: 'no' is no part of the state"),
        ({"still": 3}, TypeError, "still: 3 is no matplotlib Figure"),
        ({"data": {"x": {1, 2}}}, TypeError, "JSON"),
    ],
    ids=str,
)
def test_what_cannot_be_shown_is_refused(changes, error, message):
    with pytest.raises(error, match=message):
        picture(**changes)


class TestNotebook:
    def test_no_figure_is_left_open_and_a_widget_is_where_a_person_is(self, monkeypatch):
        before = plt.get_fignums()
        pictures.opening().widget()
        assert plt.get_fignums() == before
        assert set(picture()._repr_mimebundle_()) == {"text/plain", "text/html"}
        monkeypatch.setattr(notebook, "someone_is_there", lambda: True)
        assert notebook.MIME in picture()._repr_mimebundle_()
        monkeypatch.setenv("ROBUST_SLAM_STATIC", "1")
        assert notebook.MIME not in picture()._repr_mimebundle_()


class TestBundle:
    def test_a_picture_that_is_not_there_is_named(self):
        with pytest.raises(FileNotFoundError, match="absent"):
            bundle("absent")

    @pytest.mark.parametrize(
        "line", ['import x from "./y.js";', "export default 3;", 'export { a } from "./b.js";']
    )
    def test_a_form_that_cannot_be_bundled_is_refused(self, line, tmp_path, monkeypatch):
        (tmp_path / "pictures").mkdir()
        (tmp_path / "pictures" / "odd.js").write_text(f"{line}\n", encoding="utf-8")
        monkeypatch.setattr(bundling, "COURSE", tmp_path)
        with pytest.raises(ValueError, match=r"pictures/odd\.js: write imports as"):
            bundle.__wrapped__("odd")


@pytest.mark.parametrize("name", NAMES)
def test_each_picture_is_small_and_has_its_words(name):
    with figure_style():
        shown = getattr(pictures, name)()
        html = shown.static_html()
    assert shown.name == name
    assert len(gzip.compress(html.encode())) < MOST_BYTES
    assert len(shown.question.prompt) < 85, "two lines of a phone"
    assert len(shown.caption) > 40


def test_a_still_has_the_size_of_its_figure():
    figure = plt.figure(figsize=(3.0, 1.5))
    svg = still.to_svg(figure)
    assert still.size(svg) == (288, 144)
    assert still.address(svg).startswith("data:image/svg+xml")
    assert not plt.fignum_exists(figure.number)
