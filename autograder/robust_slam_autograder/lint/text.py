"""What texts say of exercises: the assignment's own, its chapter's, and those of other pages."""

import re
from collections import Counter
from collections.abc import Iterator

from robust_slam_autograder.lint.beside import strangers
from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Found, Subject
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.assignment import CONFIG_NAME

FIRST = "first cell"
_WORDS = ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]
_VALUES = {str(k): k for k in range(100)} | {word: k for k, word in enumerate(_WORDS)}
_NUMBER = "|".join(_VALUES)
_COUNTED = re.compile(rf"\b(({_NUMBER}) exercises?, ({_NUMBER}) points? each)\b", re.IGNORECASE)
_HEADED = re.compile(r"^##+ (\d+) · .*\((\d+) points?\)", re.MULTILINE)
_ROW = re.compile(r"^\|((?: *`\w+` *,?)+)\|", re.MULTILINE)


def _texts(subject: Subject) -> list[tuple[str, str]]:
    """Places and texts: cells of the notebook and of its chapter, and what pages say of it."""
    own = [cell.source for cell in subject.cells if cell.kind == "markdown"]
    found = [(f"text {k}" if k > 1 else FIRST, text) for k, text in enumerate(own, 1)]
    if subject.book is None:
        return found
    chapter = subject.book / f"{subject.assignment.config.chapter}.ipynb"
    cells = notebook.read(chapter) if chapter.is_file() else ()
    read = [(chapter, cell.source) for cell in cells if cell.kind == "markdown"]
    for page in sorted(subject.book.glob("*.md")):
        lines = page.read_text("utf-8").split("\n")
        read.append((page, "\n".join(line * (subject.assignment.name in line) for line in lines)))
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
        said = f"Headings say {headed}, and the exercises are {there}: correct the headings or the"
        yield Found("statements", f"{said} points, and what names an exercise by its number.")
    for said, number, each in _COUNTED.findall(own):
        wanted = {(len(points), most) for most in points.values()}
        if {(_VALUES[number.lower()], _VALUES[each.lower()])} != wanted:
            yield Found(FIRST, f"“{said}” is not so, they are {there}: correct it or the points.")


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
    name, known = subject.assignment.name, subject.assignment.exercises
    texts = [one for one in _texts(subject) if not one[0].endswith(".ipynb") or name in one[1]]
    tables = [
        (place, row)
        for place, text in texts
        if place.endswith(".ipynb")
        for row in _ROW.findall(text)
    ]
    named = {word: place for place, row in tables for word in re.findall(r"\w+", row)}
    for each in known if named else ():
        if each not in named:
            yield Found(tables[0][0], f"The table of {name} has no row for {each}: add it.")
    gone = {*named, *(path.stem for path in strangers(subject))} - {*known}
    for each in sorted(gone - {*subject.assignment.names}):
        for place, text in texts:
            mark = "" if place == FIRST or place.endswith(".md") else "`"
            sought = re.compile(rf".{{,30}}{mark}\b{each.replace('_', '[_ ]')}\b.{{,30}}")
            for number, line in enumerate(text.split("\n"), 1):
                if found := sought.search(line):
                    said = f"No exercise is {each} any more: change what names it in “{found[0]}”."
                    yield Found(place, said, number)
