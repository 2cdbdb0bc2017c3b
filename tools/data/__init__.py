"""Tables that are computed once for the book's pictures and kept in the repository."""

import json
import os
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

# It is read when numpy is first imported, which the modules here do.
os.environ["OPENBLAS_NUM_THREADS"] = "1"


def make(
    what: str | None, table: Callable[[], dict[str, Any]], told: Callable[[Any], Iterable[str]]
) -> None:
    """Compute a table, print the lines that are ``told`` of it, and write it if asked to."""
    parser = ArgumentParser(description=what, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="write the table to this file")
    out = parser.parse_args().out
    made = table()
    for line in told(made):
        print(line)
    if out:
        out.write_text(json.dumps(made, separators=(",", ":")) + "\n", encoding="utf-8")
