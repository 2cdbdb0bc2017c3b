"""The pages that the tests look at, and a reader of their tags."""

from collections.abc import Sequence
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

from robust_slam_autograder.grading.entered_by_hand import Entered, Entries, Entry
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.lms.marking import Question
from robust_slam_autograder.markup import visible
from robust_slam_autograder.reading.assignment import Config
from robust_slam_autograder.reports import class_pages, class_report, feedback, heat_map
from robust_slam_autograder.reports.class_report import Report, Source
from robust_slam_autograder.reports.heat_map import HeatMap
from robust_slam_autograder.reports.similar import Alike, Pair, Two

from . import samples
from .samples import case, exercise, result

SITE = "https://example.org/course/"
SECTIONS = {"apply": "Half, or no half"}
CONFIG = Config(title="Twice, and *again*", chapter="07-toy", sections=SECTIONS)


class Skeleton(HTMLParser):
    """A page's tags with their attributes, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, Any]] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, attrs))

    def handle_endtag(self, tag: str) -> None:
        self.tags.append((f"/{tag}", None))

    def handle_comment(self, data: str) -> None:
        self.tags.append(("comment", None))

    def handle_data(self, data: str) -> None:
        self.text += data


def page(
    made: Result, config: Config = CONFIG, site: str = SITE, entries: Entries = ()
) -> feedback.Page:
    return feedback.page(made, config, site, entries)


def report(*results: Result, **fields: Any) -> Report:
    known = frozenset(each.student for each in results)
    source = Source("07-toy", "Twice & again", results, students=known, **fields)
    return class_report.report(source)


def chart(*assignments: Sequence[Result]) -> HeatMap:
    """A class in several assignments; every student has a page."""
    sources = []
    for n, results in enumerate(assignments):
        name = f"{n:02}-toy"
        links = {each.student: f"../feedback/{n}.html" for each in results[:2]}
        sources.append(Source(name, "Twice & again", results, page=f"{name}.html", links=links))
    return heat_map.heat_map(sources)


LONG = "A sentence that is long enough to go over the end of a line on every phone, number "

COMMON = "Most students are told this."


def student(n: int) -> Result:
    """One of many, each with another mark and another message."""
    told = [COMMON if k == 7 else f"{LONG}{n % 7}." for k in range(8)]
    said = [text if k > n % 9 else "" for k, text in enumerate(told)]
    cases = [case(f"case-{k}", text, visible=k < 2) for k, text in enumerate(said)]
    status = ("partial", "timeout", "died")[n % 3] if n % 9 < 7 else "passed"
    first = exercise("solve_largest_consistent_set", status, *cases)
    broken = exercise("broken", "failed", samples.raised("first", "E: x"))
    return result(first, broken, samples.PASSED, student=f"student {n}", seconds=n * 7.7)


MANY = (
    *(student(n) for n in range(40)),
    result(samples.PASSED, student="early"),
    samples.refused("07-toy.ipynb is not valid JSON: save it again.", student="ben"),
    samples.failed("It died.", student="zoe"),
)


def hostile(text: str) -> Report:
    """A class whose students wrote this wherever they may."""
    said = samples.told(text)
    others = (samples.refused(text, student=f"b{text}"), replace(said, student=f"a{text}"))
    return report(*others, links={f"b{text}": "b.html"}, **by_people(text, f"b{text}", f"a{text}"))


def by_people(text: str, *students: str) -> dict[str, Any]:
    """Fields of a source that hold a text wherever people may write one."""
    entries = Entry("double", 2, text), Entry(text, 1.5, text, 3), Entry("why", 0, "", 3, True)
    seen = visible(text)  # as ``similar.find`` gives it
    pairs = tuple(Pair(seen, students, share, (seen, seen)) for share in (1.0, 0.8))
    return {
        "by_hand": Entered(dict.fromkeys(students, entries)),
        "markers": dict.fromkeys(students, f"M {text}"),
        "questions": [*map(Question, students, (text, text), ("", text))],
        "alike": Alike((Two(students, pairs),), ((seen, 7),)),
    }


def of_students() -> dict[str, str]:
    texts = samples.HOSTILE.values()
    wrong = [samples.told(text).exercises[0] for text in texts]
    many = [replace(one, name=f"double-{n}") for n, one in enumerate(wrong)]
    pages = {
        "every-status": result(*samples.EVERY_STATUS, reason="A cell was copied."),
        "passed": result(samples.PASSED),
        "refused": samples.refused("07-toy.ipynb is not valid JSON: save it again."),
        "hostile": result(*many, student=" ".join(texts), reason="\n".join(texts)),
        "told": samples.told("A MESSAGE"),
    }
    entries = {
        name: by_people(text, "x", "y")["by_hand"].of("x")
        for name, text in {"hostile": "\n".join(texts), "refused": "Well tried."}.items()
    }
    made = {name: page(one, entries=entries.get(name, ())) for name, one in pages.items()}
    return {name: feedback.html(one) for name, one in made.items()}


def of_classes() -> dict[str, str]:
    links = {each.student: "../feedback/x/07-toy.html" for each in MANY}
    reports = {
        "many": report(*MANY, links=links, page="many.html"),
        "by-people": report(*MANY, **by_people("Two of my signs", "student 1", "student 2")),
        "no-names": report(*MANY, names=False),
        "one": report(result(samples.PASSED), page="one.html"),
        "nothing": report(samples.refused("No.")),
        "no-points": report(result(), page="no-points.html"),
        "class-hostile": hostile("\n".join(samples.HOSTILE.values())),
    }
    listed = [reports[name] for name in ("many", "one", "nothing", "no-points")]
    made = {name: class_pages.html(made) for name, made in reports.items()}
    table = chart(MANY, [result(*samples.EVERY_STATUS, student="student 7")], MANY[::3])
    (one,) = [row for row in table.rows if row.student == "student 7"]
    return made | {
        "index": class_pages.index(listed, table, names=True),
        "student": class_pages.student(one),
    }
