"""The page *Operate* as a machine reads it: its commands, and the files that it gives.

A fenced block says what it is: ``sh`` holds commands, ``toml`` or ``text`` a file, ``text``
also what a command prints. Remarks that the built page does not show stand right above a block::

    % not run: make lab: it serves until somebody stops it
    % file: class/roster.csv
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from autograder.tests.as_user import ROOT

PAGE = ROOT / "chapters" / "operate.md"
KINDS = ("sh", "text", "toml")
_BLOCK = re.compile(
    r"^(?P<remarks>(?:%[^\n]*\n)*)```(?P<kind>[^\n`]*)\n(?P<body>.*?)^```$", re.M | re.S
)
_NOT_RUN = re.compile(r"% not run: (?P<command>.+?): (?P<reason>.+)")
_FILE = re.compile(r"% file: (?P<name>\S+)")


@dataclass(frozen=True)
class Block:
    line: int
    """Where it begins, counted from 1."""
    kind: str
    body: str
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class Command:
    """A command as the page shows it, continuation lines included, without its comment."""

    line: int
    text: str


@dataclass(frozen=True)
class File:
    """A file that the page gives, to be copied before what follows it."""

    line: int
    name: str
    text: str


Step = Command | File


def blocks(text: str) -> list[Block]:
    return [
        Block(
            text.count("\n", 0, match.start("kind")) + 1,
            match["kind"].strip(),
            match["body"],
            tuple(match["remarks"].splitlines()),
        )
        for match in _BLOCK.finditer(text)
    ]


def commands(block: Block) -> list[Command]:
    """The commands of a block: a line each, or several where a backslash ends the first ones."""
    if block.kind != "sh":
        return []
    found = re.finditer(r"(?:[^\n]*\\\n)*[^\n]+", block.body)
    at = block.line + 1
    shown = [Command(at + block.body.count("\n", 0, m.start()), _bare(m[0])) for m in found]
    return [command for command in shown if command.text]


def _bare(text: str) -> str:
    """A command without the comment at its end, by which it is known in tables."""
    return re.sub(r"(^|\s+)# .*$", "", text, flags=re.M).strip()


def not_run(block: Block) -> dict[str, str]:
    """By command the reason why it is not run here."""
    found = filter(None, map(_NOT_RUN.fullmatch, block.remarks))
    return {match["command"]: match["reason"] for match in found}


def file_name(block: Block) -> str | None:
    """The name under which the page has its reader save a block."""
    found = [match["name"] for match in map(_FILE.fullmatch, block.remarks) if match]
    return found[0] if found else None


def steps(text: str) -> Iterator[Step]:
    """What a reader does from top to bottom, without what is marked as not run."""
    for block in blocks(text):
        name, left_out = file_name(block), not_run(block)
        if name is not None:
            yield File(block.line, name, block.body)
        for command in commands(block):
            if command.text not in left_out:
                yield command


def unknown_remarks(block: Block) -> list[str]:
    """Remarks above a block that say nothing, or speak of what it does not hold."""
    there = {command.text for command in commands(block)}
    return [
        remark
        for remark in block.remarks
        if not _FILE.fullmatch(remark)
        and not ((match := _NOT_RUN.fullmatch(remark)) and match["command"] in there)
    ]


def source(path: Path = PAGE) -> str:
    return path.read_text(encoding="utf-8")
