"""``python -m tools.version 0.3.0`` gives the course a new number, wherever one is written.

It is in the three distributions, in ``CITATION.cff`` and, as the heading of what was unreleased,
in ``CHANGELOG.md``. Without a number it prints the present one.
"""

import re
import sys
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PLACES = {
    "lib/pyproject.toml": r'(?m)^version = "(.*)"$',
    "lib/course/pyproject.toml": r'(?m)^version = "(.*)"$',
    "autograder/pyproject.toml": r'(?m)^version = "(.*)"$',
    "CITATION.cff": r"(?m)^version: (.*)$",
}
"""Of each file the line with the number."""
CHANGES = "CHANGELOG.md"
UNRELEASED = "## Unreleased\n"


def current(root: Path = ROOT) -> str:
    """Return the course's version.

    Raises:
        ValueError: the files do not agree.
    """
    found = {
        name: re.findall(line, (root / name).read_text("utf-8")) for name, line in PLACES.items()
    }
    versions = {number for numbers in found.values() for number in numbers}
    if len(versions) != 1:
        raise ValueError(
            f"The files name different versions: {found}. Write one with tools.version."
        )
    return versions.pop()


def raise_to(number: str, root: Path = ROOT) -> None:
    """Write a new version to all files.

    Raises:
        ValueError: it is no version X.Y.Z above the present one, or nothing is unreleased.
    """
    if not re.fullmatch(r"\d+\.\d+\.\d+", number) or _parts(number) <= _parts(current(root)):
        raise ValueError(f"{number} is no version X.Y.Z above {current(root)}, without a v.")
    changes = (root / CHANGES).read_text("utf-8")
    unreleased = changes.partition(UNRELEASED)[2].partition("\n## ")[0]
    if not unreleased.strip():
        raise ValueError(f"{CHANGES} names no change under {UNRELEASED.strip()!r}.")
    headings = f"{UNRELEASED}\n## {number} ({date.today()})\n"
    (root / CHANGES).write_text(changes.replace(UNRELEASED, headings, 1), "utf-8")
    for name, line in PLACES.items():
        text = (root / name).read_text("utf-8")
        old = re.search(line, text)
        assert old is not None  # current() has read it
        (root / name).write_text(text[: old.start(1)] + number + text[old.end(1) :], "utf-8")


def _parts(number: str) -> list[int]:
    return [int(part) for part in number.split(".")]


if __name__ == "__main__":
    if sys.argv[1:]:
        try:
            raise_to(sys.argv[1])
        except ValueError as error:
            sys.exit(str(error))
    print(current())
