"""Submissions that are cells of code: templates in text files, filled in for a target.

A file holds entries, each with a head and the text of the victim's cell::

    === name | kind | bound | flag flag …
    text
    --- twin          the same without the trick: what it earns, the entry may earn
    text
    --- own           a cell of the student's own, before the victim's
    text

In a text ``<each>`` … ``<end>`` is repeated for each function, in which NAME is the function
and RIGHT the right one under another name; without ``<each>`` every function answers wrongly.
``<def>`` is ``<each>`` and the head of the function, whose body may stand in the same line.
``<reference>`` is the right source, ``<pipe>`` helpers that write to the pipe itself. ROOT, MARK,
FILE, OWNER and WITHHELD stand for what their names say. ``bare`` leaves out the prelude.
"""

import re
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any, cast, get_args

from .entry import Bound, Entry, Place, Write, hand_in, put
from .target import Notebook, Target

Change = Callable[[Notebook, Target], object]
FOLDER = Path(__file__).with_name("cells")
TAGS = ("<each>", "<def>", "<end>", "<reference>", "<pipe>")
DEF = "<each>\ndef NAME(*args, **kwargs):"
WRONG = f"{DEF} return spoil(RIGHT(*args, **kwargs))\n<end>\n"
FLAGS = {"timeout", "died", "spills", "bare"}
_EACH = re.compile(r"^<each>\n(.*?)(?:^<end>\n|\Z)", re.MULTILINE | re.DOTALL)
_SECTION = re.compile(r"^--- (\w+)\n", re.MULTILINE)

PRELUDE = '''\
import numpy as np
_right = dict(globals())
exec(REFERENCE, _right)
try:
    import ctypes
    ctypes.CDLL(None).prctl(15, b"MARK")  # its name as a process, by which survivors are found
except Exception: pass
def leaves(value, change, _array=np.array):
    """Change every number in what a right answer holds."""
    kind = type(value)
    if kind is tuple: return tuple([leaves(part, change) for part in value])
    if kind is list: return [leaves(part, change) for part in value]
    if kind is dict: return {key: leaves(part, change) for key, part in value.items()}
    if kind is str: return value + "?"
    if value is None: return 1.0
    if kind is type(leaves): return lambda *a, **k: leaves(value(*a, **k), change)
    return change(_array(value, dtype=float))
def spoil(value):
    return leaves(value, lambda part: part + 1)
'''

PIPE = """\
import gc, os, struct
def channel():
    return next(o for o in gc.get_objects() if type(o).__name__ == "Channel")
def send(data):
    os.write(channel()._write_fd, data)
def frame(data):
    send(struct.pack(">I", len(data)) + data)
"""


def fill(template: str, target: Target, place: Place, *, bare: bool = False) -> str:
    """The text of a cell: a template with everything in its place."""
    template = template.replace("<def>", DEF)
    text = template if bare else PRELUDE + template
    if not bare and "<each>" not in template and "<reference>" not in template:
        text += WRONG
    words = {
        "REFERENCE": repr(target.reference),
        "ROOT": str(place.root),
        "MARK": place.mark,
        "FILE": target.file,
        "OWNER": target.victim,
        "WITHHELD": repr(target.assignment.config.withheld),
    }
    text = text.replace("<pipe>\n", PIPE)
    text = _EACH.sub(lambda found: _for_each(found[1], target), text)
    text = re.sub(rf"\b({'|'.join(words)})\b", lambda found: words[found[0]], text)
    return text.replace("<reference>\n", target.reference)


def _for_each(body: str, target: Target) -> str:
    parts = []
    for name in target.functions:
        text = re.sub(r"\bRIGHT\b", f'_right["{name}"]', body)
        parts.append(re.sub(r"\bNAME\b", name, text))
    return "".join(parts)


def in_cell(template: str, *, own: str = "", bare: bool = False) -> Write:
    """A submission whose victim is answered by a template; ``own`` is a cell before it."""

    def write(target: Target, place: Place) -> None:
        notebook = target.solved(fill(template, target, place, bare=bare))
        if own:
            cell = own_cell(fill(own, target, place, bare=True))
            notebook["cells"].insert(target.index(notebook), cell)
        hand_in(notebook, target, place)

    return write


def own_cell(source: str) -> dict[str, Any]:
    empty = {"cell_type": "code", "id": "own", "metadata": {}, "execution_count": None}
    return deepcopy(empty | {"outputs": [], "source": source})


def changed(name: str, kind: str, bound: Bound, change: Change, *, spills: bool = False) -> Entry:
    """A submission whose notebook is changed: a right one for all points, else a wrong one."""

    def write(target: Target, place: Place) -> None:
        notebook = target.solved(None if bound == "full" else fill(WRONG, target, place))
        change(notebook, target)
        hand_in(notebook, target, place)

    return Entry(name, kind, bound, write, spills=spills)


def each(change: Callable[[dict[str, Any]], object]) -> Change:
    return lambda notebook, target: [change(cell) for cell in notebook["cells"]]


def in_bytes(name: str, kind: str, bound: Bound, data: Callable[[Notebook], bytes]) -> Entry:
    return Entry(
        name, kind, bound, lambda target, place: put(data(target.solved()), target, place)
    )


def from_file(path: Path) -> Iterator[Entry]:
    """The entries of one text file, twins beside those that they are twins of."""
    for part in path.read_text(encoding="utf-8").split("\n=== ")[1:]:
        head, _, text = part.partition("\n")
        yield from _entries(head, text)


def _entries(head: str, text: str) -> Iterator[Entry]:
    name, kind, bound, *rest = (word.strip() for word in head.split("|"))
    flags = set(rest[0].split()) if rest else set()
    if flags - FLAGS or bound not in get_args(Bound):
        raise ValueError(f"{name}: {head} has an unknown bound or flag")
    main, *pairs = _SECTION.split(text)
    sections = dict(zip(pairs[::2], pairs[1::2], strict=True))
    bare = "bare" in flags
    twin = f"{name}-plainly" if "twin" in sections else None
    write = in_cell(main, own=sections.get("own", ""), bare=bare)
    ends = next(iter(flags & {"timeout", "died"}), "")
    yield Entry(name, kind, cast(Bound, bound), write, twin, ends, "spills" in flags)
    if twin:
        yield Entry(twin, "", "any", in_cell(sections["twin"], bare=bare))


def all_cells() -> list[Entry]:
    """The entries of every text file of ``cells/``."""
    return [entry for path in sorted(FOLDER.glob("*.txt")) for entry in from_file(path)]
