"""The prose of a file: what is left without code, formulas, links and markup.

Everything that is no prose gives way to ``·`` or to an empty line, so that line numbers stay.
"""

import ast
import io
import json
import re
import tokenize
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_GAP = "·"
"""Stands where code, a formula or an address was: a word of no language."""

_WHOLE_LINES = (
    re.compile(r"\A---\n.*?^---$", re.MULTILINE | re.DOTALL),  # front matter
    re.compile(r"<!--.*?-->", re.DOTALL),
    re.compile(r"^( *)(`{3,}).*?^\1\2 *$", re.MULTILINE | re.DOTALL),  # code
    re.compile(r"\$\$.*?\$\$", re.DOTALL),
    re.compile(r"^ *:{3,}.*?$", re.MULTILINE),  # a directive's first and last line
    re.compile(r"^ *:[\w-]+:.*?$", re.MULTILINE),  # its options
    re.compile(r"^ *\([\w-]+\)=$", re.MULTILINE),  # a label
    re.compile(r"^ *\|?[-:| ]+\|[-:| ]*$", re.MULTILINE),  # the line below a table's head
    re.compile(r"^%.*?$", re.MULTILINE),  # MyST's comments
)
_WITHIN_A_LINE = (
    re.compile(r"(?:\{[\w:-]+\})?(`+)(?!`)(?:(?!\n\n).)+?(?<!`)\1(?!`)", re.S),  # code and roles
    re.compile(r"\$(?:(?!\n\n)[^$])+\$"),
    re.compile(r"<https?://[^>]*>|https?://\S+"),
    re.compile(r"</?\w[^>]*>"),
)
_LINK = re.compile(r"!?\[((?:[^\[\]]|\[[^\]]*\])*)\]\([^)\s]*\)")
_SYNTAX = re.compile(r"\*+|(?<!\w)_+|_+(?!\w)|^ *#+ |^ *> |^ *[-*] ", re.MULTILINE)
_TITLE = re.compile(r"^ *:{3,}\{(?:admonition|dropdown|important|note|table|tip)\} *(.+)$", re.M)
_SCRIPT = re.compile(
    r"/\*+(?P<block>.*?)\*/|//(?P<line>[^\n]*)"
    r"""|(?P<quote>["'`])(?P<string>(?:\\.|(?!(?P=quote)).)*)(?P=quote)""",
    re.DOTALL,
)
_SLOT = re.compile(r"\$\{[^}]*\}|\{[{%#].*?[%#}]\}", re.DOTALL)
_PRAGMA = re.compile(r"#\s*(?:type:|noqa|fmt:|pragma|!|ruff:|mypy:).*")


@dataclass(frozen=True)
class Piece:
    """Prose from one place of the sources.

    ``place`` names the file, and the cell of a notebook; ``line`` is that of the text's first
    line there.
    """

    place: str
    line: int
    text: str


def markdown(text: str) -> str:
    """Return the prose of a Markdown text, line by line."""
    text = _TITLE.sub(r"\1", text)
    for pattern in _WHOLE_LINES:
        text = pattern.sub(_blank, text)
    for pattern in _WITHIN_A_LINE:
        text = _LINK.sub(r"\1", pattern.sub(_gap, text))
    return _SYNTAX.sub("", text)


def of_markdown(path: Path, name: str) -> Iterator[Piece]:
    """Yield the prose of a Markdown file."""
    yield Piece(name, 1, markdown(path.read_text("utf-8")))


def of_notebook(path: Path, name: str) -> Iterator[Piece]:
    """Yield what people read of a notebook, cell by cell."""
    for cell in json.loads(path.read_text("utf-8"))["cells"]:
        for part in read_by_people(cell):
            yield Piece(f"{name}:{cell['id']}", 1, markdown(part))


def read_by_people(cell: Mapping[str, Any]) -> Iterator[str]:
    """Yield a cell's Markdown, a quiz's texts, a figure's caption and alternative text."""
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        yield source
    elif "Question(" in source:
        yield from (text for _, text in _strings(source))
    shown = cell["metadata"].get("mystnb", {})
    yield shown.get("figure", {}).get("caption", "")
    yield shown.get("image", {}).get("alt", "")


def of_python(path: Path, name: str) -> Iterator[Piece]:
    """Yield a module's docstrings, messages and comments; a string without a space is a name."""
    source = path.read_text("utf-8")
    for line, text in [*_strings(source), *_comments(source)]:
        if " " in text:
            yield Piece(name, line, markdown(text))


def of_script(path: Path, name: str) -> Iterator[Piece]:
    """Yield the comments and the texts of a module in JavaScript."""
    source = path.read_text("utf-8")
    for match in _SCRIPT.finditer(source):
        text = next(text for text in match.group("block", "line", "string") if text is not None)
        if " " in text:
            line = source.count("\n", 0, match.start()) + 1
            yield Piece(name, line, markdown(_SLOT.sub(_gap, text)))


def of_template(path: Path, name: str) -> Iterator[Piece]:
    """Yield the prose of a page's template."""
    yield Piece(name, 1, markdown(_SLOT.sub(_gap, path.read_text("utf-8"))))


def _comments(source: str) -> Iterator[tuple[int, str]]:
    """Yield comments, those of adjoining lines as one, so that phrases are whole."""
    first, lines = 0, []
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type != tokenize.COMMENT or _PRAGMA.match(token.string):
            continue
        if lines and token.start[0] != first + len(lines):
            yield first, "\n".join(lines)
            lines = []
        first = first if lines else token.start[0]
        lines.append(token.string.lstrip("# "))
    if lines:
        yield first, "\n".join(lines)


def _strings(source: str) -> Iterator[tuple[int, str]]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value


def _blank(match: re.Match[str]) -> str:
    return "\n" * match[0].count("\n")


def _gap(match: re.Match[str]) -> str:
    return _GAP + _blank(match)


READERS: dict[str, Callable[[Path, str], Iterable[Piece]]] = {
    ".md": of_markdown,
    ".ipynb": of_notebook,
    ".py": of_python,
    ".js": of_script,
    ".html": of_template,
    ".txt": of_template,
}


def read(path: Path, name: str) -> Iterable[Piece]:
    """Return the prose of a file, which its reports call ``name``."""
    return READERS[path.suffix](path, name)
