"""The commands of ``autograder``, one module each.

A command's module says in its first line what it does, which is its help too. It has ``add``,
which declares its arguments, and ``run``. A new command is a new module and its name in
``COMMANDS``.
"""

from __future__ import annotations

from typing import Any

from robust_slam_autograder.commands import (
    check,
    collect,
    doctor,
    export,
    feedback,
    grade,
    init_ci,
    lint,
    mark,
    misconceptions,
    public,
    regrade,
    release,
    report,
    towns,
)

COMMANDS = (
    release,
    check,
    towns,
    collect,
    misconceptions,
    grade,
    regrade,
    mark,
    feedback,
    report,
    export,
    doctor,
    lint,
    public,
    init_ci,
)


def declare(parsers: Any) -> None:  # noqa: ANN401
    """Declare the commands below ``argparse``'s parser of subcommands."""
    for command in COMMANDS:
        name = command.__name__.rpartition(".")[2].replace("_", "-")
        parser = parsers.add_parser(name, help=str(command.__doc__).partition(": ")[2].rstrip("."))
        command.add(parser)
        parser.set_defaults(run=command.run)
