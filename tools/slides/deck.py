"""One deck: the marked parts of a built page, each on a slide of reveal.js.

The page is the source, so formulas, figures and live pictures stand on a slide as in the book.
"""

import copy
import json
import re
from collections.abc import Iterable
from html import escape

from bs4 import BeautifulSoup, Tag

from chapters._ext.look import once
from tools.slides.marks import PAUSES, WORDS, BadMark, Mark

KINDS = {"formula": "div.math", "table": "table", "list": "ul, ol"}
DRAWN = "svg > g > g > g:has(> {}[clip-path])".format
PARTS = {"data": DRAWN(""), "markers": DRAWN("g")}
"""What a figure's axes hold, and neither a frame nor words."""
PAGE = """<!DOCTYPE html>
<html lang="en" data-theme="light">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}: slides</title>
<link rel="icon" href="../_static/favicon.svg">
<link rel="stylesheet" href="../_static/course.css">
<link rel="stylesheet" href="reveal/reveal.css">
<link rel="stylesheet" href="slides.css">
<script defer src="reveal/reveal.js"></script>
<script defer src="reveal/notes.js"></script>
<script defer src="slides.js"></script>
</head>
<body>
<main><div class="reveal"><div class="slides">
{slides}
</div></div></main>
<footer class="foot"><a href="../{page}.html">{course}, chapter {title}</a></footer>
</body>
</html>
"""


def deck(html: str, page: str, marks: Iterable[Mark], course: str) -> tuple[str, float]:
    """Return the deck of a page, such as ``chapters/03-irls``, for ``slides``, and its minutes.

    Raises:
        BadMark: the page does not have what a mark names.
    """
    source = Source(html, page)
    slides = once("\n".join(source.slide(mark, first=not k) for k, mark in enumerate(marks)))
    title, course = escape(source.title), escape(course)
    return PAGE.format(title=title, slides=slides, page=page, course=course), source.minutes


class Source:
    """A built page, to cut from."""

    def __init__(self, html: str, page: str) -> None:
        self.soup = BeautifulSoup(html, "html.parser")
        article = self.soup.select_one("article")
        assert article is not None, f"{page}: the built page has no article"
        for sign in article.select(".headerlink"):
            sign.decompose()
        for link in article.select("a[href]"):
            link["href"] = _from_slides(str(link["href"]), page)
        self.cells = article.select("div.cell:not(.rs-merged)")
        self.title = article.select("h1")[0].get_text()
        self.claims = list[str]()
        self.asked = list[str]()
        self.pictures = 0
        self.minutes = 0.0

    def slide(self, mark: Mark, first: bool) -> str:
        """Return one slide.

        Raises:
            BadMark: a sentence, or what is to be shown, is not on the page.
        """
        if mark.claims:
            kind, shown = "words", "".join(self._claim(words, mark) for words in mark.claims)
        else:
            kind, shown = self._of_text(mark) if mark.code is None else self._of_cell(mark)
        shown, keys = _wait(
            shown, mark, whole=bool(mark.ask) and kind in KINDS and mark.later is None
        )
        # What answers the slide's question waits for it, and comes with the last of the rest.
        asks = mark.ask or kind in ("picture", "question")
        waits = f' class="fragment" data-fragment-index="{max(keys - 1, 0)}"' if asks else ""
        head = f"<h{2 - first}{waits}>{escape(mark.title)}</h{2 - first}>"
        self.claims.append(mark.title)
        self.asked.append(mark.ask or _question(shown))
        if mark.setup:
            head += f'<p class="setup">{escape(mark.setup)}</p>'
        if mark.ask and kind != "picture":
            head += f'<p class="ask">{escape(mark.ask)}</p>'
        opens = f' data-chapter="{escape(self.title)}"' if first else ""
        minutes = _minutes(mark, kind, keys + len(mark.claims))
        notes = f"{escape(mark.notes)} ({minutes:.0f} min)"
        self.minutes += minutes
        return (
            f'<section class="is-{kind}" data-timing="{60 * minutes:.0f}"{opens}>{head}'
            f'<div class="show" data-prevent-swipe><div>{shown}</div></div>'
            f'<aside class="notes"><p>{notes}</p></aside></section>'
        )

    def _claim(self, words: str, mark: Mark) -> str:
        """Return a question of a slide before, which leads there, and its claim, for a key."""
        found = [number for number, claim in enumerate(self.claims) if words in claim]
        if len(found) != 1:
            raise BadMark(f"{mark.place}: {len(found)} slides before it claim {words!r}")
        claim = f'<span class="fragment">{escape(self.claims[found[0]])}</span>'
        return f'<p><a href="#/{found[0]}">{escape(self.asked[found[0]])}</a><br>{claim}</p>'

    def _of_text(self, mark: Mark) -> tuple[str, str]:
        """Return the kind of a block of the text, and its HTML."""
        kind, _, words = mark.show.partition(" ")
        if kind not in KINDS:
            raise BadMark(f"{mark.place}: {mark.show!r} is unknown; use {sorted(KINDS)}")
        blocks = self.soup.select(f"article :is({KINDS[kind]})")
        found = [block for block in blocks if _plain(words) in _plain(block.get_text())]
        if len(found) != 1:
            raise BadMark(f"{mark.place}: {len(found)} times the page has a {mark.show}")
        # The sentence that a formula ends on the page is not on the slide.
        for sign in found[0].select("mo, mi")[-1:] if kind == "formula" else ():
            if sign.get_text() in (",", "."):
                sign.decompose()
        return kind, str(found[0])

    def _of_cell(self, mark: Mark) -> tuple[str, str]:
        """Return the kind of what a cell shows, and its HTML."""
        assert mark.code is not None
        if mark.code >= len(self.cells):
            raise BadMark(f"{mark.place}: the page has {len(self.cells)} cells; make book")
        output = self.cells[mark.code].select_one(".cell_output")
        name, _, number = mark.show.partition(" ")
        if not output or name not in ("output", "question"):
            raise BadMark(f"{mark.place}: the page has no {mark.show} of this cell")
        if name == "question":
            output = copy.copy(output)
            for k, form in enumerate(output.select("form"), 1):
                if k != int(number or 1):
                    form.decompose()
            return "question", output.decode_contents()
        if output.select_one(".rs-picture"):
            return "picture", self._picture(output, mark)
        return "figure", _panels(output, mark) if mark.panels else str(output)

    def _picture(self, output: Tag, mark: Mark) -> str:
        """Return a live picture in the mark's state, under its own question or the mark's."""
        shown = copy.copy(output)
        self.pictures += 1
        data = shown.select_one("script[type='application/json']")
        question = shown.select_one(".rs-predict")
        assert data is not None and question is not None
        given = json.loads(data.get_text())
        if unknown := (mark.state.keys() | mark.answer.keys()) - given["state"].keys():
            raise BadMark(f"{mark.place}: the picture's state has no {sorted(unknown)}")
        given["state"] |= mark.state
        given["answer"] = mark.answer or given["answer"]
        given["texts"]["title"] += f", {self.pictures}"  # what it cuts off is found by this name
        data.string = json.dumps(given, ensure_ascii=False).replace("</", "<\\/")
        if mark.ask:
            for part in question.select(".rs-choices > *, [role='status'] > *"):
                part.decompose()
            question.select("legend")[0].string = mark.ask
            if mark.answer:  # and a key shows it
                question.select("[role='status']")[0].append(self.soup.new_tag("p"))
        return shown.decode_contents()


def _panels(output: Tag, mark: Mark) -> str:
    """Return a figure's panels, each as a drawing of its own without the others.

    Raises:
        BadMark: the figure does not have so many panels.
    """
    drawing = output.select("svg.rs-wide")[0]
    shown = ""
    for panel in mark.panels:
        one = copy.copy(drawing)
        _, *groups = one.select("g")[0].find_all("g", recursive=False)
        if not 1 <= panel <= len(groups):
            raise BadMark(f"{mark.place}: the figure has {len(groups)} panels, and no {panel}")
        for group in groups[: panel - 1] + groups[panel:]:
            marks = group.find_all("defs")  # which the other panels draw as well
            group.clear()
            group.extend(marks)
        shown += str(one)
    return f'<figure><div class="rs-figure panels">{shown}</div></figure>'


def _wait(html: str, mark: Mark, whole: bool) -> tuple[str, int]:
    """Let what the mark names wait for a key each, or the ``whole``; return how many keys, too."""
    soup = BeautifulSoup(html, "html.parser")
    steps = [[part for part in soup.contents if isinstance(part, Tag)]] if whole else []
    for each in mark.later or ():
        wanted = each.removeprefix("each ")
        parts = soup.select(PARTS.get(wanted, wanted))
        if not parts:
            raise BadMark(f"{mark.place}: nothing that it shows is {each!r}")
        steps += [[part] for part in parts] if each.startswith("each ") else [parts]
    for number, part in ((number, part) for number, parts in enumerate(steps) for part in parts):
        part["class"] = [*part.get_attribute_list("class", []), "fragment"]
        part["data-fragment-index"] = str(number)
    return str(soup), len(steps)


def _minutes(mark: Mark, kind: str, keys: int) -> float:
    """Return how long a slide takes, said and done."""
    asks = "ask" if mark.ask else "vote" if kind in ("picture", "question") else "look"
    words = " ".join((mark.title, mark.setup, mark.ask, mark.notes)).split()
    return len(words) / WORDS + PAUSES[asks] + PAUSES["key"] * keys + mark.work


def _question(shown: str) -> str:
    """Return what a live picture or a quiz asks."""
    asked = BeautifulSoup(shown, "html.parser").select_one("legend")
    return asked.get_text().removeprefix("Predict: ") if asked else ""


def _plain(text: str) -> str:
    """Return a text without spaces and joiners."""
    return re.sub(r"[\s\u2060-\u2064]", "", text)


def _from_slides(link: str, page: str) -> str:
    """Return a link of a page as it leads from the slides to the same place."""
    if re.match(r"\w+:", link):
        return link
    return f"../{page}.html{link}" if link.startswith("#") else f"../chapters/{link}"
