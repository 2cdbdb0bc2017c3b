"""The figures of pages and of sites, as tables in Markdown."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from benchmarks.site.page import Figures
from benchmarks.site.server import Given

NONE = "–"


@dataclass(frozen=True)
class Site:
    """What was measured of a site.

    Attributes:
        folder: its path.
        pages: the figures of each page.
        query: what a query of its search was given.
    """

    folder: str
    pages: Sequence[Figures]
    query: Sequence[Given]

    @property
    def chapters(self) -> list[Figures]:
        """The pages with a number."""
        return [page for page in self.pages if re.match(r"chapters/\d\d-", page.name)]

    @property
    def front(self) -> list[Figures]:
        """The front page, in a list that is empty where it was not measured."""
        return [page for page in self.pages if page.name == "chapters/index"]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def kilobytes(size: float) -> str:
    """Return bytes as kilobytes of 1,000."""
    return f"{size / 1e3:,.0f}"


def number(value: float | None, digits: int = 0) -> str:
    """Return a number, or a dash where there is none."""
    return NONE if value is None else f"{value:,.{digits}f}"


COLUMNS: dict[str, Callable[[Figures], str]] = {
    "page": lambda page: page.name.removeprefix("chapters/"),
    "KB gzipped": lambda page: kilobytes(page.weight),
    "requests": lambda page: str(len(page.given)),
    "main thread, s": lambda page: number(page.tasks, 2),
    "scripts, s": lambda page: number(page.scripts, 2),
    "paint, s": lambda page: number(page.paint, 2),
    "in first response": lambda page: "yes" if page.in_first_response else "no",
    "shift at 1280": lambda page: number(page.shifts[0], 3),
    "shift at 390": lambda page: number(page.shifts[1], 3),
    "axe, light": lambda page: str(page.violations[0].total()),
    "axe, dark": lambda page: str(page.violations[1].total()),
}


def of_pages(site: Site) -> str:
    """Return a table with a page a line."""
    rows = [[column(page) for column in COLUMNS.values()] for page in site.pages]
    return table(list(COLUMNS), rows)


def spread(values: Iterable[float | None], digits: int = 0) -> str:
    """Return the median of values and their ends."""
    there = [value for value in values if value is not None]
    if not there:
        return NONE
    ends = [number(value, digits) for value in (median(there), min(there), max(there))]
    return f"{ends[0]} ({ends[1]} to {ends[2]})"


def largest(site: Site) -> str:
    """Return the three largest files of a chapter, each at its median size."""
    sizes: dict[str, list[int]] = {}
    for page in site.chapters:
        for each in page.given:
            name = "the page" if each.path.endswith(".html") else each.path.rpartition("/")[2]
            sizes.setdefault(name, []).append(each.size)
    most = sorted(sizes, key=lambda name: -median(sizes[name]))[:3]
    return ", ".join(f"{name} {kilobytes(median(sizes[name]))}" for name in most) or NONE


def rules(site: Site, theme: int) -> str:
    """Return the rules that are broken, and at how many elements of how many pages."""
    elements: Counter[str] = Counter()
    on: Counter[str] = Counter()
    for page in site.pages:
        elements.update(page.violations[theme])
        on.update(page.violations[theme].keys())
    said = [f"{rule} {count} on {on[rule]} pages" for rule, count in elements.most_common()]
    return ", ".join(said) or "none"


def _share(pages: Sequence[Figures], what: Callable[[Figures], bool]) -> str:
    return f"{sum(map(what, pages))} of {len(pages)} pages"


LINES: dict[str, Callable[[Site], str]] = {
    "chapter, KB gzipped": lambda site: spread(page.weight / 1e3 for page in site.chapters),
    "chapter, requests": lambda site: spread(len(page.given) for page in site.chapters),
    "front page, KB gzipped": lambda site: spread(page.weight / 1e3 for page in site.front),
    "front page, requests": lambda site: spread(len(page.given) for page in site.front),
    "largest files of a chapter, KB": largest,
    "main thread of a chapter, s": lambda site: spread((p.tasks for p in site.chapters), 2),
    "of it scripts, s": lambda site: spread((p.scripts for p in site.chapters), 2),
    "layout shift at 1280": lambda site: spread((p.shifts[0] for p in site.pages), 3),
    "layout shift at 390": lambda site: spread((p.shifts[1] for p in site.pages), 3),
    "largest contentful paint, s": lambda site: spread((p.paint for p in site.pages), 2),
    "its text in the first response": lambda site: _share(
        site.pages, lambda page: page.in_first_response
    ),
    "axe, light": lambda site: rules(site, 0),
    "axe, dark": lambda site: rules(site, 1),
    "a query of the search, KB": lambda site: kilobytes(sum(each.size for each in site.query)),
}


def summary(sites: Sequence[Site]) -> str:
    """Return a figure a line, a site a column; of several pages the median and the ends."""
    rows = [[name, *(line(site) for site in sites)] for name, line in LINES.items()]
    return table(["", *(site.folder for site in sites)], rows)
