"""What texts say of exercises: the assignment's own, its chapter's, and those of other pages."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from robust_slam_autograder.lint.beside import strangers
from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Found, Subject
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.assignment import CONFIG_NAME

FIRST = "first cell"
_NUMBERS = ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]
_NUMBER = rf"({'|'.join(_NUMBERS)}|\d+)"
_COUNTED = re.compile(rf"\b{_NUMBER} exercises?, {_NUMBER} points? each\b", re.IGNORECASE)
_HEADED = re.compile(r"^##+ (\d+) · .*\((\d+) points?\)", re.MULTILINE)
_ROW = re.compile(r"^\|((?: *`\w+` *,?)+)\|", re.MULTILINE)


def _texts(subject: Subject) -> list[tuple[str, str]]:
    """Cells of text of the notebook and of its chapter, and the book's pages, by their places."""
    own = [cell.source for cell in subject.cells if cell.kind == "markdown"]
    found = [(f"text {k}" if k > 1 else FIRST, text) for k, text in enumerate(own, 1)]
    if subject.book is None:
        return found
    chapter = subject.book / f"{subject.assignment.config.chapter}.ipynb"
    cells = notebook.read(chapter) if chapter.is_file() else ()
    read = [(chapter, cell.source) for cell in cells if cell.kind == "markdown"]
    read += [(page, page.read_text("utf-8")) for page in sorted(subject.book.glob("*.md"))]
    return found + [(f"{path.parent.name}/{path.name}", text) for path, text in read]


@rule("miscounted", "warning", "Texts number the exercises and their points as they are.")
def _miscounted(subject: Subject) -> Iterator[Found]:
    points: Counter[str] = Counter()
    for case in subject.assignment.cases:
        points[subject.assignment.owner(case.exercise)] += int(case.points)
    there = ", ".join(f"{k} ({n} points)" for k, n in enumerate(points.values(), 1))
    own = "\n".join(text for place, text in _texts(subject) if "/" not in place)
    headed = ", ".join(f"{k} ({n} points)" for k, n in _HEADED.findall(own))
    if headed not in ("", there):
        said = f"Headings say {headed}, and the exercises are {there}: correct the headings, and"
        yield Found("statements", f"{said} what names an exercise by its number.")
    for one in _COUNTED.finditer(own):
        if {(_value(one[1]), _value(one[2]))} != {(len(points), n) for n in points.values()}:
            yield Found(FIRST, f"“{one[0]}” is not so, they are {there}: correct this sentence.")


def _value(number: str) -> int:
    return int(number) if number.isdecimal() else _NUMBERS.index(number.lower())


@rule("no-section", "warning", "Each exercise has a heading of its chapter, to read again.")
def _no_section(subject: Subject) -> Iterator[Found]:
    chapter = [text for place, text in _texts(subject) if place.endswith(".ipynb")]
    headings = re.findall(r"^#+ *(.*?) *$", "\n".join(chapter), re.MULTILINE)
    for name in subject.assignment.exercises if headings else ():
        heading = subject.assignment.config.sections.get(name, "")
        if headings.count(heading) != 1:
            said = f"[sections] gives {name} “{heading}”, and has to give one heading of chapter "
            yield Found(CONFIG_NAME, f"{said}{subject.assignment.config.chapter}: put it there.")


@rule("stale-text", "warning", "The chapter's table names each exercise, and no text one of old.")
def _stale_text(subject: Subject) -> Iterator[Found]:
    assignment, texts = subject.assignment, _texts(subject)
    about = [one for one in texts if one[0].endswith(".ipynb") and assignment.name in one[1]]
    rows = " ".join(row for _, text in about for row in _ROW.findall(text))
    named = set(re.findall(r"\w+", rows))
    for name in assignment.exercises if named else ():
        if name not in named:
            said = f"The table of {assignment.name} has no row for {name}: add it."
            yield Found(about[0][0], said)
    gone = (named | {path.stem for path in strangers(subject)}) - {*assignment.names}
    for name in sorted(gone - {*assignment.exercises}):
        word = name.replace("_", "[_ ]")
        for place, text in texts:
            is_own = "/" not in place or (place, text) in about
            mark = "" if place == FIRST or place.endswith(".md") else "`"
            for number, line in enumerate(text.split("\n"), 1):
                found = re.search(rf".{{,30}}{mark}\b{word}\b.{{,30}}", line)
                if found and (is_own or (place.endswith(".md") and assignment.name in line)):
                    said = f"No exercise is {name} any more: change what names it in “{found[0]}”."
                    yield Found(place, said, number)
