"""The text of any cell at all is read without harm, and in time that grows as its length."""

import ast
import warnings

import pytest
from hypothesis import strategies as st
from robust_slam_autograder.reading import source

from .running import fuzzed, no_hang

pytestmark = pytest.mark.rest

PIECES = [
    *("def ", "async ", "class ", "f", "double", "(", ")", "(x)", ":", "\n", "\n", "    ", "\t"),
    *("=", "==", " = 1", ": int", "return ", "lambda ", "import os", "from x import *", "@", ","),
    *("%", "%%", "%%time", "%%bash", "%matplotlib inline", "!ls", "?", "??", "f?", "$", ";", "#"),
    *('"', "'''", '"""', "\\", "\\\n", "f'{", "}'", "{", "[", "]", "1" * 5000, "0x", "1e999"),
    *("\0", "\x0c", "\r", "\ufeff", "\u2028", "é", "ﬁ", "ª", "😀", "\\N{x}", "\\ud800", "μ"),
    *("await ", "yield ", "match x:\n case _:", "global f", "if 1:", "try:", "else:", "pass"),
    *("-" * 500, "(" * 250, "[" * 250, "not " * 300, "x." * 300, "if 1: " * 60),
    *(">>> ", "In [1]: "),
]
SOURCES = st.lists(st.sampled_from(PIECES), max_size=14).map("".join) | st.text(max_size=30)
"""Pieces of Python and of magics, in any order."""
NAMES = ["double", "f", "e", "μ"]


@pytest.mark.filterwarnings("ignore")
@fuzzed(400, SOURCES)
def test_any_text_is_read(text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert type(source.defines(text, NAMES)) is bool
        assert all(type(name) is str for name in source.defined_names(text))
        ast.parse(source.imports(text))
        assert type(source.plain_python(text)) is str


LINES = {
    "letters": "x",
    "blanks": " ",
    "tabs": "\t",
    "line ends": "\n",
    "form feeds": "\x0c",
    "names": "double",
    "names and blanks": "double ",
    "names and line ends": "double\n",
    "annotations": "double :",
    "annotated lines": "double:\n",
    "comparisons": "double ==",
    "definitions": "def ",
    "definitions and line ends": "def\n",
    "coroutines": "async ",
    "coroutines and line ends": "async\n",
    "magics": "%%",
}
HEADS = ["", "double", "double:", "def", "async", "async def", "class", "%%", "\n"]


@pytest.mark.parametrize("name", LINES)
def test_long_lines_are_searched_once(name):
    for head in HEADS:
        text = head + LINES[name] * (200_000 // len(LINES[name])) + "!"
        with no_hang():
            assert not source.defines(text, NAMES)
            assert source.defines(f"{text}\nf = 1", NAMES)
