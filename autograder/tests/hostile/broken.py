"""Files that are no notebook, or hardly one: each is refused in one sentence, or costs its own."""

import json
from collections.abc import Callable
from typing import Any

from .cells import changed, each, in_bytes, in_cell, own_cell
from .entry import Entry
from .target import Notebook

DEEP = 100_000
FOUR = '"nbformat": 4'
OLD = {"nbformat": 3, "nbformat_minor": 0, "metadata": {"name": ""}}
Fields = dict[str, Any]


def _refused(name: str, kind: str, data: Callable[[Notebook], bytes]) -> Entry:
    return in_bytes(name, f"broken: {kind}", "refused", data)


def _bytes(name: str, kind: str, data: bytes) -> Entry:
    return _refused(name, kind, lambda notebook: data)


def _spelt(name: str, kind: str, change: Callable[[str], str], codec: str = "utf-8") -> Entry:
    """A right notebook whose text is changed."""
    return _refused(name, kind, lambda notebook: change(json.dumps(notebook)).encode(codec))


def _made(name: str, kind: str, change: Callable[[Notebook], Notebook]) -> Entry:
    return _refused(name, kind, lambda notebook: json.dumps(change(notebook)).encode())


def _with(name: str, kind: str, **fields: object) -> Entry:
    """A right notebook with other fields at its top."""
    return _made(name, kind, lambda notebook: notebook | fields)


def _with_cell(name: str, kind: str = "types", **fields: object) -> Entry:
    """A right notebook with a first cell of wrong types."""
    first = own_cell("") | fields
    return _made(name, kind, lambda notebook: notebook | {"cells": [first, *notebook["cells"]]})


def _wrong(name: str, kind: str, change: Callable[[Fields], object], **more: Any) -> Entry:
    return changed(name, f"broken: {kind}", "wrong", each(change), **more)


def _text(name: str, kind: str, source: str) -> Entry:
    return Entry(name, f"broken: {kind}", "wrong", in_cell(source, bare=True))


def _large(notebook: Notebook) -> Notebook:
    output = {"output_type": "stream", "name": "stdout", "text": "x" * (60 * 2**20)}
    last = own_cell("") | {"outputs": [output]}
    return notebook | {"cells": [*notebook["cells"], last]}


BROKEN = [
    _spelt("half-a-file", "json", lambda text: text[:500]),
    _spelt("two-files-in-one", "json", lambda text: text * 2),
    _bytes("a-page", "json", b"<!DOCTYPE html><title>Sign in</title>"),
    _bytes("empty", "empty", b""),
    _bytes("white-space", "empty", b" \n" * 1000),
    _bytes("binary", "binary", bytes(range(256)) * 100),
    _bytes("zip", "binary", b"PK\x03\x04" + bytes(10**5)),
    _bytes("deep", "nesting", b"[" * DEEP + b"]" * DEEP),
    _bytes("deep-tables", "nesting", b'{"cells":' * DEEP),
    _bytes("list", "types", b"[]"),
    _bytes("number", "types", b"4"),
    _with("cells-of-numbers", "types", cells=[1, 2]),
    _with("cells-as-a-table", "types", cells={"0": {}}),
    _with("no-cells", "types", cells=None),
    _with_cell("text-of-numbers", source=1),
    _with_cell("text-of-lists", source=[["a"], 3]),
    _with_cell("type-of-a-number", cell_type=3),
    _made("nbformat-3", "nbformat 3", lambda old: OLD | {"worksheets": [{"cells": old["cells"]}]}),
    _with("nbformat-99", "nbformat 99", nbformat=99),
    _with("nbformat-of-lists", "nbformat 99", nbformat=[[[]]]),
    _with("nbformat-text", "nbformat 99", nbformat="4"),
    _spelt("giant-number", "nbformat 99", lambda text: text.replace(FOUR, FOUR[:-1] + "9" * 5000)),
    _spelt("mark-twice", "bom", lambda text: "\ufeff" * 2 + text),
    _spelt("mark-inside", "bom", lambda text: f"{text[:1]}\ufeff{text[1:]}"),
    _wrong("marks-in-cells", "bom", lambda c: c.update(source="\ufeff" + _source(c)), spills=True),
    _spelt("utf-16", "utf-16", str, "utf-16"),
    _spelt("utf-32", "utf-16", str, "utf-32-le"),
    _bytes("latin-1", "utf-16", b'{"cells": "\xe9"}'),
    _wrong("returns-alone", "crlf", lambda cell: cell.update(source=_source(cell, "\r"))),
    _wrong("odd-line-ends", "crlf", lambda cell: cell.update(source=_source(cell, "\r\r\n"))),
    _with("nbformat-nan", "nan", nbformat=float("nan")),
    _with("nbformat-infinite", "nan", nbformat=float("inf")),
    _wrong("nan-in-metadata", "nan", lambda cell: cell["metadata"].update(x=float("nan"))),
    _with_cell("surrogate", "surrogates", source="x = '\ud800'"),
    _wrong("surrogates-in-metadata", "surrogates", lambda c: c["metadata"].update(x="\udfff")),
    _made("sixty-megabytes", "60 MB", _large),
    _with("many-cells", "cells", cells=[own_cell("1")] * 5000),
    _text("syntax-error", "syntax", "<each>\ndef NAME(*args, **kwargs:\n"),
    _text("half-a-string", "syntax", "<reference>\nx = '''never closed\n"),
    _text("null-byte", "syntax", "<reference>\nx = 1\0\n"),
    _text("deep-text", "syntax", "<reference>\nx = " + "-" * DEEP + "1\n"),
    _text("deep-brackets", "syntax", "<reference>\nx = " + "(" * DEEP + "\n"),
    _text("long-text", "syntax", "x = " + "+".join(["1"] * DEEP) + "\n"),
    _text("no-text", "syntax", ""),
    _text("text-that-is-no-code", "syntax", "The answer is six, as anyone can see.\n"),
    _text(
        "wrong-name", "name", "<reference>\n<each>\nNAME = None\ndef not_the_name(*a): return a\n"
    ),
]


def _source(cell: dict[str, Any], end: str = "\n") -> str:
    return "".join(cell["source"]).replace("\n", end)
