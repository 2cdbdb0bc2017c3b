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
        not_found: whether it has a page for addresses that are not there.
        sitemap: whether it lists its pages for search engines.
    """

    folder: str
    pages: Sequence[Figures]
    query: Sequence[Given]
    not_found: bool
    sitemap: bool

    @property
    def chapters(self) -> list[Figures]:
        """The pages with a number."""
        return [page for page in self.pages if re.match(r"chapters/\d\d-", page.name)]

    @property
    def front(self) -> list[Figures]:
        """The front page, in a list that is empty where it was not measured."""
        return [page for page in self.pages if page.name == "chapters/index"]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def kilobytes(size: float) -> str:
    """Bytes as kilobytes of 1,000."""
    return f"{size / 1e3:,.0f}"


def number(value: float | None, digits: int = 0) -> str:
    """A number, or a dash where there is none."""
    return NONE if value is None else f"{value:,.{digits}f}"


def parts(given: Iterable[Given]) -> Counter[str]:
    """Bytes by the kind of file."""
    sizes: Counter[str] = Counter()
    for each in given:
        sizes[each.kind] += each.size
    return sizes


COLUMNS: dict[str, Callable[[Figures], str]] = {
    "page": lambda page: page.name.removeprefix("chapters/"),
    "KB": lambda page: kilobytes(page.weight),
    "requests": lambda page: str(len(page.given)),
    "page KB": lambda page: kilobytes(parts(page.given)["page"]),
    "scripts KB": lambda page: kilobytes(parts(page.given)["scripts"]),
    "fonts KB": lambda page: kilobytes(parts(page.given)["fonts"]),
    "main thread s": lambda page: number(page.tasks, 2),
    "scripts s": lambda page: number(page.scripts, 2),
    "shift 1280": lambda page: number(page.shifts[0], 3),
    "shift 390": lambda page: number(page.shifts[1], 3),
    "largest paint s": lambda page: number(page.paint, 2),
    "its text in the first response": lambda page: "yes" if page.in_first_response else "no",
    "axe light": lambda page: str(page.violations[0].total()),
    "axe dark": lambda page: str(page.violations[1].total()),
    "live": lambda page: str(len(page.shown["pictures"])),
    "live KB, raw": lambda page: kilobytes(sum(page.shown["pictures"])),
    "px": lambda page: number(page.shown["height"]),
    "px to the first live": lambda page: number(page.shown["first"]),
    "words": lambda page: number(page.shown["words"]),
    "printed": lambda page: str(page.printed),
    "smallest label": lambda page: number(page.smallest_label, 1),
    "median label": lambda page: number(page.median_label, 1),
    "wide code": lambda page: str(page.wide),
}


def of_pages(site: Site) -> str:
    """One page a line."""
    rows = [[column(page) for column in COLUMNS.values()] for page in site.pages]
    return table(list(COLUMNS), rows)


def spread(values: Iterable[float | None], digits: int = 0) -> str:
    """The median of values and their ends."""
    there = [value for value in values if value is not None]
    if not there:
        return NONE
    ends = [number(value, digits) for value in (median(there), min(there), max(there))]
    return f"{ends[0]} ({ends[1]} to {ends[2]})"


def largest(site: Site) -> str:
    """The three largest files of a chapter, each at its median size."""
    sizes: dict[str, list[int]] = {}
    for page in site.chapters:
        for each in page.given:
            name = "the page" if each.kind == "page" else each.path.rpartition("/")[2]
            sizes.setdefault(name, []).append(each.size)
    most = sorted(sizes, key=lambda name: -median(sizes[name]))[:3]
    return ", ".join(f"{name} {kilobytes(median(sizes[name]))}" for name in most) or NONE


def rules(site: Site, theme: int) -> str:
    """The rules that are broken, and at how many elements of how many pages."""
    elements: Counter[str] = Counter()
    on: Counter[str] = Counter()
    for page in site.pages:
        elements.update(page.violations[theme])
        on.update(page.violations[theme].keys())
    said = [f"{rule} {count} on {on[rule]} pages" for rule, count in elements.most_common()]
    return ", ".join(said) or "none"


def _share(pages: Sequence[Figures], what: Callable[[Figures], bool]) -> str:
    return f"{sum(map(what, pages))} of {len(pages)} pages"


def _is_there(value: bool) -> str:
    return "yes" if value else "no"


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
    "live pictures on chapters": lambda site: str(
        sum(len(page.shown["pictures"]) for page in site.chapters)
    ),
    "live picture, KB raw": lambda site: spread(
        size / 1e3 for page in site.chapters for size in page.shown["pictures"]
    ),
    "px above the first live picture": lambda site: spread(
        page.shown["first"] for page in site.chapters
    ),
    "chapter, px at 1280": lambda site: spread(page.shown["height"] for page in site.chapters),
    "chapter, words with code": lambda site: spread(p.shown["words"] for p in site.chapters),
    "chapter, printed pages": lambda site: spread(page.printed for page in site.chapters),
    "smallest label at 390, px": lambda site: spread((p.smallest_label for p in site.pages), 1),
    "median label at 390, px": lambda site: spread((p.median_label for p in site.pages), 1),
    "wide code boxes of a chapter at 390": lambda site: spread(p.wide for p in site.chapters),
    "a query of the search, KB": lambda site: kilobytes(sum(each.size for each in site.query)),
    "page 404": lambda site: _is_there(site.not_found),
    "sitemap": lambda site: _is_there(site.sitemap),
    "og:image": lambda site: _share(site.pages, lambda page: page.shown["image"]),
    "logo": lambda site: _share(site.pages, lambda page: page.shown["logo"]),
}


def summary(sites: Sequence[Site]) -> str:
    """A figure a line, a site a column; of several pages the median, the least and the most."""
    rows = [[name, *(line(site) for site in sites)] for name, line in LINES.items()]
    return table(["", *(site.folder for site in sites)], rows)
