"""Lines of text as arrays, a tag such as ``EDGE_SE2``, then ids, then numbers; and writing lines.

Blank lines and comments, which start with ``#``, are passed over.
"""

import os
import re
import secrets
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias, TypeVar

import numpy as np

from robust_slam._arrays import Array, Ids, Indices, Mask

Number = TypeVar("Number", int, float)
Unknown: TypeAlias = Literal["raise", "skip"]
ReadId: TypeAlias = Callable[[str], int | None]
"""Return the whole number of an id, or None where the field is not one."""

LARGEST_ID = np.iinfo(np.int64).max
LARGEST = 1e30
"""Beyond it (m or rad) a residual cannot be squared and weighed in double precision."""
_DECIMAL = re.compile(r"[+-]?\d+(,\d+)?([eE][+-]?\d+)?")
_MEANT = {
    "SE3$": "write VERTEX_SE3:QUAT and EDGE_SE3:QUAT, without spaces",
    "PRIOR:": "g2o writes EDGE_SE3_PRIOR i p, and PARAMS_SE3OFFSET p 0 0 0 0 0 0 1 once",
    ":$": "this may be YAML, and a graph is lines of g2o",
    r"^\d": "if it is a time, write it in seconds",
    "SIM3": "it is a similarity, with a scale, and this library estimates rigid poses; apply the "
    "scales and export EDGE_SE3:QUAT",
    "TUTORIAL_": "the tutorial of g2o writes such tags; take TUTORIAL_ out of them",
    ",": "fields are separated by spaces here; put them in place of the commas",
    ";": "fields are separated by spaces here; put them in place of the semicolons",
}
"""What an unknown tag with such letters means, and the remedy."""


class Fault(Exception):
    """Something wrong in a line, before the file's name is known; line 0 is the whole file."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(f"{line}: {message}" if line else f" {message}")


@dataclass(frozen=True)
class Tag:
    """What stands behind a tag: time stamps and ids, numbers without a use, then numbers.

    A line with ``many`` ids counts as a line for each of them. The last numbers are an upper
    triangle ``half``, if there is one, such as it may be.
    """

    ids: int
    numbers: int
    stamps: int = 0
    many: bool = False
    unused: int = 0
    half: tuple[str, ...] = ()

    @property
    def fields(self) -> int:
        """The number of fields behind the tag."""
        return self.stamps + self.ids + self.unused + self.numbers


Line: TypeAlias = tuple[int, list[str]]
"""The number of a line in its file, and its fields."""


@dataclass(frozen=True, eq=False)
class Rows:
    """The lines of one tag: their numbers in the file, ids ``(k, i)``, and numbers ``(k, p)``."""

    line: Indices
    ids: Ids
    numbers: Array

    def __len__(self) -> int:
        return self.line.size

    def refuse(self, wrong: Mask, words: str | Callable[[int], str]) -> None:
        """Refuse the first line that the mask ``wrong`` ``(k,)`` marks, if there is one.

        Raises:
            Fault: with ``words``, or with those that they make of the number of the row.
        """
        for k in np.flatnonzero(wrong)[:1].tolist():
            raise Fault(int(self.line[k]), words if isinstance(words, str) else words(k))


def decoded(content: bytes) -> str:
    """Return the text of a file; only comments may hold bytes that are not UTF-8.

    Raises:
        Fault: another line is not UTF-8.
    """
    with suppress(UnicodeDecodeError):
        return content.decode("utf-8-sig")
    # Bytes that are not UTF-8 become surrogates; in a comment they do no harm.
    text = content.decode("utf-8-sig", errors="surrogateescape")
    for line, fields in lines_of(text):
        if not "".join(fields).isascii():
            raise Fault(line, "the bytes are not UTF-8 text; save the file as plain text")
    return text


def with_points(text: str) -> tuple[str, tuple[str, ...]]:
    """Return a text whose decimal commas are points, and a sentence if it has such commas.

    It has, where every number with a comma has one alone, and no number has a point.
    """
    if "," not in text:
        return text, ()
    commas = False
    for field in (field for _, fields in lines_of(text) for field in fields):
        if "." in field or ("," in field and not _DECIMAL.fullmatch(field)):
            return text, ()
        commas = commas or "," in field
    note = ("the commas in its numbers are read as decimal points",)
    return (text.replace(",", "."), note) if commas else (text, ())


def lines_of(text: str) -> Iterator[Line]:
    """Yield the lines that hold anything but a comment."""
    for line, content in enumerate(text.split("\n"), start=1):
        fields = content.partition("#")[0].split()
        if fields:
            yield line, fields


def by_tag(
    text: str,
    tags: Mapping[str, Tag],
    passed: Sequence[str],
    unknown: Unknown,
    elsewhere: str = "",
) -> tuple[dict[str, list[Line]], dict[str, int]]:
    """Return the lines of each of the ``tags``, and the number of lines of each skipped tag.

    Tags that begin with a word of ``passed`` are skipped in any case, and ``elsewhere`` ends the
    message about a tag that is unknown.

    Raises:
        Fault: a line has the wrong number of fields, or an unknown tag.
    """
    found: dict[str, list[Line]] = {tag: [] for tag in tags}
    width = {name: tag.fields for name, tag in tags.items()}
    skipped: dict[str, int] = {}
    for line, fields in lines_of(text):
        name, behind = fields[0], len(fields) - 1
        if name not in tags:
            if unknown == "raise" and not name.startswith(tuple(passed)):
                raise Fault(line, _unknown(name, text, tags, elsewhere))
            skipped[name] = skipped.get(name, 0) + 1
        elif behind == width[name]:
            found[name].append((line, fields))
        elif tags[name].many and behind > width[name]:
            found[name] += [(line, [name, field]) for field in fields[1:]]
        else:
            raise Fault(line, _miscounted(name, behind, tags[name]))
    return found, skipped


def _unknown(name: str, text: str, tags: Mapping[str, Tag], elsewhere: str) -> str:
    """Return what is said of a tag; to leave its lines out is a remedy if edges are left."""
    left = any(fields[0] in tags and tags[fields[0]].ids > 1 for _, fields in lines_of(text))
    meant = [words for letters, words in _MEANT.items() if re.search(letters, name)]
    usual = ", ".join(each for each, tag in tags.items() if not tag.unused)
    remedy = ', or leave such lines out with unknown="skip"' if left else ""
    use = meant[0] if meant else f"use {usual}{remedy}{elsewhere}"
    return f"the tag {name[:40]!r} is unknown; {use}"


def _miscounted(name: str, behind: int, tag: Tag) -> str:
    said, last = f"{name} has {behind} fields behind it; give {tag.fields}", len(tag.half)
    if not last:
        return said
    if behind != tag.fields - last:
        return f"{said}, of which the last {last} are half of a matrix, row by row"
    remedy = f"for deviations of 0.1 m and 0.05 rad append {' '.join(tag.half)}"
    return f"{said}: the last {last}, how precise it is, are missing; {remedy}"


def rows_of(lines: Iterable[Line], tag: Tag, read_id: ReadId, ids_are: str) -> Rows:
    """Return the lines of one tag as arrays, or raise a Fault; ``ids_are`` says what an id is."""
    number, ids, numbers = [], [], []
    first, last, end = 1 + tag.stamps, 1 + tag.stamps + tag.ids, 1 + tag.fields
    for line, fields in lines:
        number.append(line)
        for k in range(1, first):
            _read(line, k, fields[k], real, "a number")
        ids.append([_read(line, k, fields[k], read_id, ids_are) for k in range(first, last)])
        behind = [_read(line, k, fields[k], real, "a number") for k in range(last, end)]
        numbers.append(behind[tag.unused :])
    rows = Rows(
        np.array(number, dtype=np.int64),
        np.array(ids, dtype=np.int64).reshape(len(ids), tag.ids),
        np.array(numbers, dtype=np.float64).reshape(len(ids), tag.numbers),
    )
    infinite = ~np.all(np.isfinite(rows.numbers), axis=1)
    rows.refuse(infinite, "a number is not finite; remove NaN and infinity")
    return rows


def check_near(rows: Rows, numbers: Array) -> None:
    """Refuse, by a Fault, positions and angles ``(k, p)`` beyond 1e30, which no map can hold."""
    far = np.any(np.abs(numbers) > LARGEST, axis=1)
    rows.refuse(far, f"a number is beyond {LARGEST:g}; give metres and radians")


def whole(field: str) -> int | None:
    """Return an id of digits only: int() would also accept '+1' and '1_0'."""
    digits = field.isascii() and field.isdigit() and len(field.lstrip("0")) < 20
    return int(field) if digits and int(field) <= LARGEST_ID else None


def real(field: str) -> float | None:
    """Return a number: float() would also accept '1_0' and digits of other scripts."""
    try:
        return float(field) if "_" not in field and field.isascii() else None
    except ValueError:
        return None


def _read(
    line: int, place: int, field: str, read: Callable[[str], Number | None], wanted: str
) -> Number:
    found = read(field)
    if found is None:
        comma = ", with a point in place of the comma" if "," in field and read is real else ""
        raise Fault(line, f"field {place} is {field[:40]!r}; give {wanted}{comma}")
    return found


def write_lines(path: str | os.PathLike[str], lines: Iterable[str]) -> None:
    """Write ``lines`` to a temporary file beside ``path``, then rename it, or raise an OSError."""
    target = Path(path)
    part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    try:
        with part.open("x", encoding="utf-8", newline="\n") as file:
            file.writelines(lines)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)
