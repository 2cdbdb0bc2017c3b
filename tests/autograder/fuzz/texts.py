"""Texts of cells: pieces of Python and of magics, in any order."""

from __future__ import annotations

from hypothesis import strategies as st

PIECES = [
    *("def ", "async ", "class ", "f", "double", "(", ")", "(x)", ":", "\n", "\n", "    ", "\t"),
    *("=", "==", " = 1", ": int", "return ", "lambda ", "import os", "from x import *", "@", ","),
    *("%", "%%", "%%time", "%%bash", "%matplotlib inline", "!ls", "?", "??", "f?", "$", ";", "#"),
    *('"', "'''", '"""', "\\", "\\\n", "f'{", "}'", "{", "[", "]", "1" * 5000, "0x", "1e999"),
    *("\0", "\x0c", "\r", "\ufeff", "\u2028", "é", "ﬁ", "ª", "😀", "\\N{x}", "\\ud800", "μ"),
    *("await ", "yield ", "match x:\n case _:", "global f", "if 1:", "try:", "else:", "pass"),
    *(
        "-" * 500,
        "(" * 250,
        "[" * 250,
        "not " * 300,
        "x." * 300,
        "if 1: " * 60,
        ">>> ",
        "In [1]: ",
    ),
]
SOURCES = st.lists(st.sampled_from(PIECES), max_size=14).map("".join) | st.text(max_size=30)
