"""What a reader sees at once: how long a chapter takes, what it is for, what the next one asks.

The list of pages has its first part open, and that of the page that is read. The map of chapter 0
is folded and unfolds to that of the robust kernel in the last; the page that a server shows where
there is none has the folded one. All of it comes from what is there already:
the words of the page, its list of goals, the questions on the front page, and the course's town.
A page that quotes a chapter's time writes {minutes}`00-one-lie`.
"""

import functools
import re
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from docutils import nodes
from robust_slam_course.plots import opening
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxRole

from . import TEMPLATES

PACE, SHOWN, EXERCISE, PICTURE, STEP = 100, 1, 3, 5, 10
"""Words a minute, for a student to whom the subject is new. Minutes for what is shown (a formula,
a cell's code, a question), for an exercise and for a live picture, and for what is rounded to."""
CHAPTER = re.compile(r"(\d\d)-")
TITLE = re.compile(r"<h1>.*?</h1>", re.DOTALL)
PART = re.compile(r'(<p [^>]*class="caption".*?</p>)\s*(<ul class=".*?</ul>)', re.DOTALL)
GOALS = re.compile(r"<p>(?=[^<]*After this chapter you can</p>)")
SIZE = 100.0


def add(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Add the maps and the line at the head of a chapter, and the questions of its neighbours."""
    if listed := context.get("generate_toctree_html"):
        context["generate_toctree_html"] = lambda **how: in_parts(str(listed(**how)))
    if page == "404":
        context["map"] = drawn(0.0)
    for way in filter(None, (context.get("prev"), context.get("next"))):
        name = PurePosixPath(way["link"]).stem
        if question := questions(app).get(name):
            sign = sign_of(app, int(own[1])) if (own := CHAPTER.match(name)) else ""
            way["title"] += f' <span class="rs-question">{sign}{question}</span>'
    number = CHAPTER.match(PurePosixPath(page).name)
    if doctree is None or number is None:
        return
    body, goals = GOALS.subn('<p id="goals">', context["body"], count=1)
    head = TEMPLATES.get_template("chapter.html")
    known = {"minutes": minutes(app, page), "goals": goals}
    context["body"] = TITLE.sub(lambda title: head.render(known, title=title[0]), body, count=1)


def in_parts(html: str) -> str:
    """Return the list of pages with each part behind its caption: open if it is first or read."""

    def part(match: re.Match[str]) -> str:
        is_open = match.start() == html.find("<p ") or 'class="current' in match[2]
        mark = " open" if is_open else ""
        return f"<details{mark}><summary>{match[1]}</summary>{match[2]}</details>"

    return PART.sub(part, html)


def minutes(app: Sphinx, page: str) -> int:
    """Return how long a chapter, without its assignment, takes a newcomer."""
    every = app.env.get_doctree(page).findall
    words = sum(len(part.astext().split()) for part in every(nodes.paragraph))
    html = [part.astext() for part in every(nodes.raw)]
    shown = sum(part.count("<legend>") for part in html) + len([*every(nodes.math_block)])
    for part in every(nodes.container):
        shown += "cell_input" in part["classes"] and "tag_hide-input" not in part.parent["classes"]
    exercises = sum(bool(re.fullmatch(r"\d+\.", bold.astext())) for bold in every(nodes.strong))
    longer = EXERCISE * exercises + PICTURE * sum("rs-picture" in part for part in html)
    return STEP * round((words / PACE + SHOWN * shown + longer) / STEP)


class Minutes(SphinxRole):
    """A chapter's time, named by its file; it is known when all pages have been read."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Return a place for the time, and let this page follow the chapter's text."""
        page = str(PurePosixPath(self.env.docname).parent / self.text)
        self.env.note_dependency(str(self.env.doc2path(page)))
        return [nodes.inline(self.text, self.text, classes=["rs-minutes"], page=page)], []


def quote_times(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the times where a page quotes them."""
    for node in list(doctree.findall(nodes.inline)):
        if "rs-minutes" in node["classes"]:
            node[:] = [nodes.Text(str(minutes(app, node["page"])))]


def add_maps(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Put the map of each chapter before its link in the front page's table."""
    if page != app.config.root_doc:
        return
    for link in list(doctree.findall(nodes.reference)):
        own = CHAPTER.match(link.get("refuri", ""))
        if own and isinstance(link.parent.parent, nodes.entry):
            link.parent.insert(0, nodes.raw("", sign_of(app, int(own[1])), format="html"))


def chapters(app: Sphinx) -> list[str]:
    """Return the names of the chapters' pages, in their order."""
    return sorted(name for name in app.env.titles if CHAPTER.match(PurePosixPath(name).name))


def sign_of(app: Sphinx, number: int) -> str:
    """Return the map of a chapter; a book of one chapter has the folded one."""
    return drawn(number / max(len(chapters(app)) - 1, 1))


def questions(app: Sphinx) -> dict[str, str]:
    """Return by chapter the question that the front page's table gives it."""
    front = app.env.get_doctree(app.config.root_doc)
    rows = (row.children for row in front.findall(nodes.row))
    return {
        PurePosixPath(target["reftarget"]).name: question.astext()
        for chapter, question, *_ in rows
        for target in chapter.findall(lambda node: "reftarget" in node)
    }


@functools.cache
def _maps() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the folded and the robust map, (n, 2) each, and the poses of the wrong closure."""
    town = opening.town()
    robust, folded = town.robust[:, :2], town.folded[:, :2]
    low, high = (end(np.vstack([robust, folded]), axis=0) for end in (np.min, np.max))
    scale = SIZE / (high - low).max()
    (ends,) = town.graph.edges[town.is_outlier]
    return (folded - low) * scale, (robust - low) * scale, ends


def drawn(share: float) -> str:
    """Return the map and its wrong closure as SVG: folded at 0, the robust kernel's at 1."""
    folded, robust, ends = _maps()
    points = (1 - share) * folded + share * robust
    wide, high = np.vstack([folded, robust]).max(axis=0) + 4
    drive, wrong = (
        " ".join(f"{x:.0f} {high - 2 - y:.0f}" for x, y in part) for part in (points, points[ends])
    )
    return (
        f'<svg class="rs-map" viewBox="-2 -2 {wide:.0f} {high + 2:.0f}" aria-hidden="true">'
        f'<path d="M{drive}"/><path class="rs-is-wrong" d="M{wrong}"/></svg>'
    )


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build, behind what finishes formulas and tables."""
    app.add_role("minutes", Minutes())
    app.connect("doctree-resolved", quote_times)
    app.connect("doctree-resolved", add_maps)
    app.connect("html-page-context", add, priority=700)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
