"""The commands of ``autograder``, one module each.

A command's module says in its first line what it does, which is its help too. It has ``add``,
which declares its arguments, and ``run``. A new command is a new module and its name in
``COMMANDS``.
"""

import importlib
from collections.abc import Collection
from typing import Any

COMMANDS = (
    *("release", "check", "towns", "collect", "misconceptions", "grade", "regrade", "mark"),
    *("feedback", "report", "export", "doctor", "lint", "public", "init_ci"),
)


def declare(parsers: Any, given: Collection[str] = ()) -> None:  # noqa: ANN401
    """Declare the commands below ``argparse``'s parser of subcommands.

    It is all of them, unless the arguments that are ``given`` name one: that one alone.
    """
    named = [name for name in COMMANDS if name.replace("_", "-") in given]
    for name in named or COMMANDS:
        command = importlib.import_module(f"{__name__}.{name}")
        said = str(command.__doc__).partition(": ")[2].rstrip(".")
        parser = parsers.add_parser(name.replace("_", "-"), help=said)
        command.add(parser)
        parser.set_defaults(run=command.run)
