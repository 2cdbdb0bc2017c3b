"""One deck: the marked parts of a built page, each on a slide of reveal.js.

The page is the source, so formulas, figures and live pictures stand on a slide as in the book.
"""

import copy
import json
import re
from collections.abc import Iterable, Iterator
from html import escape

from bs4 import BeautifulSoup, Tag

from chapters._ext.look import once
from tools.slides.marks import PAUSES, WORDS, BadMark, Mark

KINDS = {"formula": "div.math", "table": "table", "list": "ul, ol", "box": ".admonition"}
BLOCKS = "article p, article li, article figcaption"
END = re.compile(r"([.?!](?:</\w+>)*)\s+(?=[A-Z<(“])")
"""Where a sentence ends in the inside of a paragraph."""
OPENS = re.compile(r"<[a-zA-Z](?:[^>]*[^/>])?>(?<!<br>)")
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
        self.sentences = [
            (sentence, _plain(sentence), block)
            for block in article.select(BLOCKS)
            if not block.find(["p", "ul", "ol"])
            for sentence in _sentences(block)
        ]
        self.title = article.select("h1")[0].get_text()
        self.pictures = 0
        self.minutes = 0.0

    def slide(self, mark: Mark, first: bool) -> str:
        """Return one slide.

        Raises:
            BadMark: a sentence, or what is to be shown, is not on the page.
        """
        say = [self._sentence(words, mark) for words in mark.say]
        then = [self._sentence(words, mark) for words in mark.then]
        if mark.code is None:
            block = self._after(say[0][1], mark) if mark.show else None
            kind, shown = mark.show.lstrip("-"), str(block or "")
            say = [(sentence, where) for sentence, where in say if sentence not in shown]
        else:
            block = None
            kind, shown = self._of_cell(self._cell(mark), mark)
        # What answers the slide's question waits for it.
        waits = ' class="fragment"' if mark.ask or kind == "picture" else ""
        head = f"<h{2 - first}{waits}>{escape(mark.title)}</h{2 - first}>"
        if mark.ask and kind != "picture":
            head += f'<p class="ask">{escape(mark.ask)}</p>'
        words = [(f"<p>{sentence}</p>", where) for sentence, where in say]
        words += [(f'<p class="fragment">{sentence}</p>', where) for sentence, where in then]
        # What follows a formula or a table in the text also follows it on the slide.
        over = block if kind in ("formula", "table") else None
        shows = "".join([
            _words(p for p, where in words if not over or _place(where) <= _place(over)),
            f'<div class="show" data-prevent-swipe><div>{shown}</div></div>' if shown else "",
            _words(p for p, where in words if over and _place(where) > _place(over)),
        ])  # fmt: skip
        self.minutes += _minutes(mark, kind)
        return (
            f'<section class="{"first " if first else ""}is-{kind or "words"}">{head}'
            f'<div class="parts">{shows}</div>'
            f'<aside class="notes"><p>{escape(mark.notes)}</p></aside></section>'
        )

    def _sentence(self, words: str, mark: Mark) -> tuple[str, Tag]:
        wanted = _spaces(words)
        found = {s: block for s, plain, block in self.sentences if wanted in plain}
        if len(found) != 1:
            raise BadMark(f"{mark.place}: {len(found)} sentences of the page have {words!r}")
        return next(iter(found.items()))

    def _after(self, block: Tag, mark: Mark) -> Tag:
        kind, back = mark.show.lstrip("-"), mark.show.startswith("-")
        if kind not in KINDS:
            raise BadMark(f"{mark.place}: {mark.show!r} is unknown; use {sorted(KINDS)}")
        of_kind = self.soup.select(f"article :is({KINDS[kind]})")
        inside = block.find_parent(lambda tag: any(tag is each for each in of_kind))
        if isinstance(inside, Tag):
            return inside
        found = [tag for tag in of_kind if (_place(tag) < _place(block)) == back]
        if not found:
            raise BadMark(f"{mark.place}: no {mark.show} on the page")
        chosen = found[-1 if back else 0]
        # The sentence that a formula ends on the page is not on the slide.
        for sign in chosen.select("mo, mi")[-1:] if kind == "formula" else ():
            if sign.get_text() in (",", "."):
                sign.decompose()
        return chosen

    def _cell(self, mark: Mark) -> Tag:
        assert mark.code is not None
        if mark.code >= len(self.cells):
            raise BadMark(f"{mark.place}: the page has {len(self.cells)} cells; make book")
        return self.cells[mark.code]

    def _of_cell(self, cell: Tag, mark: Mark) -> tuple[str, str]:
        """Return the kind of what a cell shows, and its HTML."""
        code, output = cell.select_one(".cell_input"), cell.select_one(".cell_output")
        name, _, number = mark.show.partition(" ")
        if name == "question" and output:
            output = copy.copy(output)
            for k, form in enumerate(output.select("form"), 1):
                if k != int(number or 1):
                    form.decompose()
            return "question", output.decode_contents()
        wanted = {"code": [code], "output": [output], "both": [code, output]}.get(name)
        if not wanted or not all(wanted):
            raise BadMark(f"{mark.place}: the page has no {mark.show} of this cell")
        has = output.select_one if output else lambda _: None
        kind = "picture" if has(".rs-picture") else "figure" if has("figure") else "code"
        if kind == "picture" and output:
            return kind, self._picture(output, mark)
        if kind == "figure" and mark.panels:
            return kind, _panels(output, mark)
        return kind, "".join(str(part) for part in wanted)

    def _picture(self, output: Tag, mark: Mark) -> str:
        """Return a live picture in the mark's state, under its own question or the mark's."""
        shown = copy.copy(output)
        self.pictures += 1
        data = shown.select_one("script[type='application/json']")
        question = shown.select_one(".rs-predict")
        assert data is not None and question is not None
        given = json.loads(data.get_text())
        if unknown := mark.state.keys() - given["state"].keys():
            raise BadMark(f"{mark.place}: the picture's state has no {sorted(unknown)}")
        given["state"] |= mark.state
        given["texts"]["title"] += f", {self.pictures}"  # what it cuts off is found by this name
        data.string = json.dumps(given, ensure_ascii=False).replace("</", "<\\/")
        if mark.ask:
            for part in question.select(".rs-choices > *, [role='status'] > *"):
                part.decompose()
            question.select("legend")[0].string = mark.ask
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


def _minutes(mark: Mark, kind: str) -> float:
    """Return how long a slide takes, said and done."""
    picture = kind == "picture"
    done = ["drag" if picture else "look"]
    if mark.ask:
        done.append("ask")
    elif picture or kind == "question":
        done.append("vote")
    words = " ".join((mark.title, mark.ask, *mark.say, *mark.then, mark.notes)).split()
    return len(words) / WORDS + sum(PAUSES[each] for each in done)


def _sentences(block: Tag) -> Iterator[str]:
    """Give the sentences of a paragraph, of which none ends inside an element."""
    begun = ""
    for piece in END.sub("\\1\0", block.decode_contents()).split("\0"):
        begun = f"{begun} {piece}" if begun else piece
        if len(OPENS.findall(begun)) == begun.count("</"):
            yield begun
            begun = ""
    if begun:
        yield begun


def _words(paragraphs: Iterable[str]) -> str:
    text = "".join(paragraphs)
    return f'<div class="words">{text}</div>' if text else ""


def _place(tag: Tag) -> tuple[int, int]:
    """Return where an element begins in the page's source."""
    return tag.sourceline or 0, tag.sourcepos or 0


def _plain(html: str) -> str:
    text = BeautifulSoup(html, "html.parser").get_text()
    return _spaces(text.translate(str.maketrans("’“”", '\'""')))


def _spaces(text: str) -> str:
    return " ".join(text.split())


def _from_slides(link: str, page: str) -> str:
    """Return a link of a page as it leads from the slides to the same place."""
    if re.match(r"\w+:", link):
        return link
    return f"../{page}.html{link}" if link.startswith("#") else f"../chapters/{link}"
