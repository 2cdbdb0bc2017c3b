"""Other people's text: readable, and without power over a page, a table or a terminal."""

import unicodedata
from collections.abc import Callable

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from robust_slam_autograder import markup

from .reports.samples import HOSTILE

GITHUB = MarkdownIt("gfm-like")
"""Tables, addresses without brackets and raw HTML, as GitHub reads them."""
# Half characters too, which a student's exception may hold.
ANY_TEXT = st.text(st.characters(), max_size=60) | st.text("`|\\ \n<a", max_size=12)


def for_any_text(test: Callable[..., None]) -> Callable[..., None]:
    """Run a test on each hostile text and on random ones."""
    for text in HOSTILE.values():
        test = example(text=text)(test)
    return given(text=ANY_TEXT)(test)


def spans(markdown: str) -> list[tuple[str, str]]:
    """What a paragraph holds: kinds and contents."""
    tokens = (token for block in GITHUB.parse(markdown) for token in block.children or [])
    return [(token.type, token.content) for token in tokens]


def acts(letter: str) -> bool:
    return unicodedata.category(letter) in {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Größe ½ ‖u‖ 学生 🎓", "Größe ½ ‖u‖ 学生 🎓"),
        ("two\r\nlines\tand a tab", "two\nlines\tand a tab"),
        ("\x1b[31m", "\\x1b[31m"),
        ("\u202egnp.exe", "\\u202egnp.exe"),
        ("\ud800", "\\ud800"),
        ("\U000e0041", "\\U000e0041"),
    ],
)
def test_what_acts_is_written_as_its_code(text, shown):
    assert markup.visible(text) == shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("::error::x", "\\x3a:error::x"),
        (" \t::error::x", "\\x3a:error::x"),
        ("##[error]x", "\\x23#[error]x"),
        ("a ##vso[task.complete]", "a \\x23#vso[task.complete]"),
        ("##teamcity[x]", "\\x23#teamcity[x]"),
        ("std::vector ## a [b]", "std::vector ## a [b]"),
    ],
)
def test_no_ci_service_obeys_a_line(text, shown):
    assert markup.one_line(text) == shown
    assert markup.log_line(text.strip()) == shown


def test_a_name_in_a_message_stays_on_its_line():
    assert markup.log_line("a\n::b\t c\x1b") == "a\\n::b\\t c\\x1b"


@for_any_text
def test_nothing_that_acts_is_left_and_all_else_stays(text):
    shown = markup.visible(text)
    assert not any(acts(letter) for letter in shown if letter not in "\n\t")
    assert shown.encode("utf-8").decode("utf-8") == shown
    if not any(acts(letter) for letter in text):
        assert shown == text
    assert "\n" not in markup.one_line(text)


@for_any_text
def test_a_span_is_one_span_and_holds_the_text(text):
    plain = markup.one_line(text)
    wanted = [("text", "a "), ("code_inline", plain), ("text", " b")]
    assert not plain or spans(f"a {markup.code(text)} b") == wanted


@for_any_text
def test_a_cell_stays_one_cell(text):
    table = f"| a | b |\n| --- | --- |\n| {markup.cell(text)} | end |\n"
    cells = [token for token in GITHUB.parse(table) if token.type == "inline"]
    plain = markup.one_line(text).replace("|", "¦")
    assert [cell.content for cell in cells[:2]] == ["a", "b"] and len(cells) == 4
    assert [child.content for child in cells[2].children or []] == [plain] * bool(plain)
    assert cells[3].content == "end"


@pytest.mark.parametrize(
    "words", ["The four costs", "*c* < 1 | <b> [x](y) `z` ‖u‖² & $c$ \\", "a_b"]
)
def test_an_instructors_words_are_shown_as_they_are(words):
    assert "".join(content for _, content in spans(markup.prose(words))) == words
    assert {kind for kind, _ in spans(markup.prose(words))} <= {"text", "text_special"}
