"""Lines that only the instructor has, and files that hold one."""

import contextlib
import io
import json
import re
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from robust_slam_autograder.reading import notebook

TELLING_IN_A_RELEASE = 24
"""A line of a solution that is longer than this is no one's by chance."""
TELLING_IN_A_COURSE = 31
"""In a whole course more lines are alike by chance."""
_SECRET = re.compile(r"BEGIN (SOLUTION|HIDDEN TESTS)[^\n]*\n(.*?)[^\n]*END \1", re.DOTALL)
_IMPORT = re.compile(r"import |from \S+ import ")


def telling_lines(sources: Sequence[str], telling: int = TELLING_IN_A_RELEASE) -> set[str]:
    """Lines longer than ``telling`` that stand in solutions and hidden tests and nowhere else."""
    regions = [match.group(2) for source in sources for match in _SECRET.finditer(source)]
    shown = {line.strip() for source in sources for line in _SECRET.sub("", source).split("\n")}
    hidden = {line.strip() for region in regions for line in region.split("\n")}
    return {line for line in hidden - shown if len(line) > telling}


def secrets_of(source: Path) -> set[str]:
    """Lines of an instructor's notebook that must stand nowhere in a course; imports may."""
    lines = telling_lines([cell.source for cell in notebook.read(source)], TELLING_IN_A_COURSE)
    return {line for line in lines if not _IMPORT.match(line)}


def lines_below(folder: Path) -> Iterator[tuple[str, set[str]]]:
    """Every file's path below the folder and its lines, without the blanks around them.

    Of JSON, and so of notebooks, they are the lines of every text in it; of an archive
    those of all its files.
    """
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        yield path.relative_to(folder).as_posix(), lines_of(path.read_bytes())


def lines_of(data: bytes) -> set[str]:
    """The lines of a file, whatever it is."""
    if zipfile.is_zipfile(io.BytesIO(data)):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return {line for name in archive.namelist() for line in lines_of(archive.read(name))}
    text = data.decode(encoding="utf-8", errors="replace")
    texts = [text]
    if text.lstrip()[:1] in ("{", "["):
        with contextlib.suppress(ValueError, RecursionError):
            texts += _texts_in(json.loads(text))
    return {line.strip() for text in texts for line in text.splitlines()}


def _texts_in(value: Any) -> Iterator[str]:  # noqa: ANN401
    """Every text in a value of JSON, keys too."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        yield from (text for pair in value.items() for part in pair for text in _texts_in(part))
    elif isinstance(value, list):
        yield from (text for part in value for text in _texts_in(part))
