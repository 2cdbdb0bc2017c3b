"""Files that are no notebook, or hardly one: each is refused in one sentence, or costs its own."""

import json
from collections.abc import Callable
from typing import Any

from .cells import changed, each, in_bytes, in_cell, own_cell
from .entry import Entry
from .target import Notebook

DEEP = 100_000


def _bytes(name: str, kind: str, data: Callable[[Notebook], bytes]) -> Entry:
    return in_bytes(name, f"broken: {kind}", "refused", data)


def _with(name: str, kind: str, **fields: object) -> Entry:
    """A right notebook with other fields at its top."""
    return _bytes(name, kind, lambda notebook: json.dumps(notebook | fields).encode())


def _with_cell(name: str, kind: str = "types", **fields: object) -> Entry:
    """A right notebook with a first cell of wrong types."""

    def data(notebook: Notebook) -> bytes:
        cells = [own_cell("") | fields, *notebook["cells"]]
        return json.dumps(notebook | {"cells": cells}).encode()

    return _bytes(name, kind, data)


def _wrong(
    name: str, kind: str, change: Callable[[dict[str, Any]], object], *, spills: bool = False
) -> Entry:
    return changed(name, f"broken: {kind}", "wrong", each(change), spills=spills)


def _text(name: str, kind: str, source: str) -> Entry:
    return Entry(name, f"broken: {kind}", "wrong", in_cell(source, bare=True))


def _text_of(value: Notebook) -> str:
    return json.dumps(value)


def _worksheets(notebook: Notebook) -> bytes:
    old = {"nbformat": 3, "nbformat_minor": 0, "metadata": {"name": ""}}
    return json.dumps(old | {"worksheets": [{"cells": notebook["cells"]}]}).encode()


def _large(notebook: Notebook) -> bytes:
    output = {"output_type": "stream", "name": "stdout", "text": "x" * (60 * 2**20)}
    notebook["cells"].append(own_cell("") | {"outputs": [output]})
    return json.dumps(notebook).encode()


def _mark_in_the_middle(notebook: Notebook) -> bytes:
    text = _text_of(notebook).encode()
    return text[:1] + b"\xef\xbb\xbf" + text[1:]


def _replaced(old: str, new: str) -> Callable[[Notebook], bytes]:
    return lambda notebook: _text_of(notebook).replace(old, new, 1).encode()


BROKEN = [
    _bytes("half-a-file", "json", lambda notebook: _text_of(notebook)[:500].encode()),
    _bytes("two-files-in-one", "json", lambda notebook: _text_of(notebook).encode() * 2),
    _bytes("a-page", "json", lambda notebook: b"<!DOCTYPE html><title>Sign in</title>"),
    _bytes("empty", "empty", lambda notebook: b""),
    _bytes("white-space", "empty", lambda notebook: b" \n" * 1000),
    _bytes("binary", "binary", lambda notebook: bytes(range(256)) * 100),
    _bytes("zip", "binary", lambda notebook: b"PK\x03\x04" + bytes(10**5)),
    _bytes("deep", "nesting", lambda notebook: b"[" * DEEP + b"]" * DEEP),
    _bytes("deep-tables", "nesting", lambda notebook: b'{"cells":' * DEEP),
    _bytes("list", "types", lambda notebook: b"[]"),
    _bytes("number", "types", lambda notebook: b"4"),
    _with("cells-of-numbers", "types", cells=[1, 2]),
    _with("cells-as-a-table", "types", cells={"0": {}}),
    _with("no-cells", "types", cells=None),
    _with_cell("text-of-numbers", source=1),
    _with_cell("text-of-lists", source=[["a"], 3]),
    _with_cell("type-of-a-number", cell_type=3),
    _bytes("nbformat-3", "nbformat 3", _worksheets),
    _with("nbformat-99", "nbformat 99", nbformat=99),
    _with("nbformat-of-lists", "nbformat 99", nbformat=[[[]]]),
    _with("nbformat-text", "nbformat 99", nbformat="4"),
    _bytes("giant-number", "nbformat 99", _replaced('"nbformat": 4', '"nbformat": ' + "9" * 5000)),
    _bytes(
        "mark-twice", "bom", lambda notebook: b"\xef\xbb\xbf" * 2 + _text_of(notebook).encode()
    ),
    _bytes("mark-inside", "bom", _mark_in_the_middle),
    _wrong("marks-in-cells", "bom", lambda c: c.update(source="\ufeff" + _source(c)), spills=True),
    _bytes("utf-16", "utf-16", lambda notebook: _text_of(notebook).encode("utf-16")),
    _bytes("utf-32", "utf-16", lambda notebook: _text_of(notebook).encode("utf-32-le")),
    _bytes("latin-1", "utf-16", lambda notebook: b'{"cells": "\xe9"}'),
    _wrong("returns-alone", "crlf", lambda cell: cell.update(source=_source(cell, "\r"))),
    _wrong("odd-line-ends", "crlf", lambda cell: cell.update(source=_source(cell, "\r\r\n"))),
    _bytes("nbformat-nan", "nan", _replaced('"nbformat": 4', '"nbformat": NaN')),
    _with("nbformat-infinite", "nan", nbformat=float("inf")),
    _wrong("nan-in-metadata", "nan", lambda cell: cell["metadata"].update(x=float("nan"))),
    _with_cell("surrogate", "surrogates", source="x = '\ud800'"),
    _wrong("surrogates-in-metadata", "surrogates", lambda c: c["metadata"].update(x="\udfff")),
    _bytes("sixty-megabytes", "60 MB", _large),
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
        "wrong-name",
        "name",
        "<reference>\n<each>\nNAME = None\ndef not_the_name(*args, **kwargs):\n    return args\n",
    ),
]


def _source(cell: dict[str, Any], end: str = "\n") -> str:
    return "".join(cell["source"]).replace("\n", end)
