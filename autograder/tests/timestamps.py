"""What may lie where nbgrader writes when a submission was handed in, and holds no time."""

import os
from collections.abc import Callable
from pathlib import Path

JUNK: dict[str, Callable[[Path], object]] = {
    "words": lambda path: path.write_text("soon"),
    "binary": lambda path: path.write_bytes(b"\xff\xfe\x00"),
    "empty": Path.touch,
    "long": lambda path: path.write_text("9" * 5000),
    "before all time": lambda path: path.write_text("0001-01-01 00:00:00 +2359"),
    "no such zone": lambda path: path.write_text("2026-10-20 23:59:00 Nowhere/Town"),
    "no such hour": lambda path: path.write_text("2026-10-20 25:00:00 UTC"),
    "pipe": os.mkfifo,
    "folder": Path.mkdir,
    "device": lambda path: path.symlink_to("/dev/zero"),
    "dangling link": lambda path: path.symlink_to("nowhere"),
}
