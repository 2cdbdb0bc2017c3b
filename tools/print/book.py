"""One page that holds all pages of the book, for the printer.

Ids get the name of their page, so that links between pages become links in the document, each with
the number of the page to which it leads.
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from urllib.parse import unquote, urljoin

from bs4 import BeautifulSoup, Tag

NAMES = ("for", "aria-labelledby", "aria-describedby", "aria-controls", "headers")
"""Attributes that hold ids."""
AWAY = (
    ".headerlink, .rs-teach, script, noscript, .tag_hide-input > details, .tag_hide-cell,"
    " .rs-merged:not(:has(.cell_output)), .rs-forget, .toctree-wrapper, link"
)
"""What paper has no use for: folded code is one click away on the site."""
SHARED = 3
"""A title that so many chapters have, as *Quiz*, is not in the contents."""
ALONE = ("cheat-sheet",)
"""Pages on paper of their own, as chapters are: others follow one another."""
LONG = 19
"""Lines of code that stay on one page."""
HASH = re.compile(r"(url\(['\"]?#|^#)([^)'\"]+)")
DOCUMENT = """<!DOCTYPE html>
<html lang="en" data-theme="light">
<head><meta charset="utf-8"><title>{title}</title>
<base href="{site}/chapters/">
<link rel="stylesheet" href="../_static/course.css">
<style>{style}</style></head>
<body class="bd-content">
<header class="cover"><h1>{title}</h1>{lead}<p>{author}</p><p>Version {version}</p></header>
<nav class="lines" aria-label="Contents"><h1 id="contents">Contents</h1>{contents}</nav>
{pages}
</body></html>
"""


@dataclass(frozen=True)
class Line:
    """A line of the contents."""

    level: int
    id: str
    title: str
    """As HTML, for a heading may hold a formula."""


class Book:
    """The pages of a site, joined.

    Args:
        site: the built site.
        parts: the captions of the parts, each with its pages, as in ``_toc.yml``.
        about: the title, author and version.
        style: the printer's style sheet.
        drawn: the parts of a page that it draws for its own print, as HTML: rows of its pictures'
            states, in their order, and then its answers.
    """

    def __init__(
        self,
        site: Path,
        parts: Sequence[tuple[str, Sequence[str]]],
        about: Mapping[str, str],
        style: str,
        drawn: Mapping[str, Sequence[str]],
    ) -> None:
        self.site, self.about, self.style, self.drawn = site, about, style, drawn
        self.parts = parts
        self.pages = [page for _, pages in parts for page in pages]
        self.lines: list[Line] = []
        self.articles = {page: self._article(page) for page in self.pages}

    def html(self, numbers: Mapping[str, int]) -> str:
        """Return the document.

        Args:
            numbers: the number of the page on which the element with an id begins, by the id; one
                that is missing is written with three digits, which take as much room.
        """
        pages, heads = [], list[str]()
        captions = {page: caption for caption, files in self.parts for page in files}
        for page, article in self.articles.items():
            for place in article.select("span.rs-at"):
                place.string = f" (p. {numbers.get(str(place['data-to']), 999)})"
            name, head = Path(page).name, article.h1.get_text() if article.h1 else ""
            # Paper begins anew where its head changes, which only these ask for.
            if not (name[0].isdigit() or name in ALONE):
                head = captions[page] or head
            head = " ".join(head.split()).replace("\\", "").replace('"', "'")
            if heads[-1:] != [head]:
                heads.append(head)
            named = f'class="page {name}" style="page: page{len(heads)}"'
            pages.append(f"<section {named}>{article}</section>")
        rules = [
            f'@page page{k} {{ @top-left {{ content: "{head}" }} }}'
            for k, head in enumerate(heads, 1)
        ]
        return DOCUMENT.format(
            title=escape(self.about["title"]),
            author=escape(self.about["author"]),
            version=escape(self.about["version"]),
            lead=self.about.get("lead", ""),
            site=self.site.resolve().as_uri(),
            style=self.style + "\n".join(rules),
            contents="".join(self._contents(numbers)),
            pages="".join(pages),
        )

    def _contents(self, numbers: Mapping[str, int]) -> list[str]:
        captions = {pages[0]: caption for caption, pages in self.parts}
        often = Counter(line.title for line in self.lines if line.level == 2)
        out = []
        for line in self.lines:
            if line.level == 2 and often[line.title] >= SHARED:
                continue
            if line.level == 1 and line.id in captions:
                out.append(f'<p class="part">{escape(captions[line.id])}</p>')
            number = numbers.get(line.id, 999)
            out.append(
                f'<p class="level{line.level}"><a href="#{escape(line.id)}">'
                f"<span>{line.title}</span><span>{number}</span></a></p>"
            )
        return out

    def _article(self, page: str) -> Tag:
        path = self.site / f"{page}.html"
        soup = BeautifulSoup(path.read_text(encoding="utf-8"), "html.parser")
        article = soup.article
        assert article is not None, f"{path} has no article"
        for each in article.select(AWAY):
            if not each.decomposed:
                each.decompose()
        for each in article.select("details"):
            each["open"] = ""
        for code in article.select("pre"):
            if code.get_text().count("\n") > LONG:
                code["class"] = [*code.get_attribute_list("class"), "long"]
        rows = [BeautifulSoup(row, "html.parser") for row in self.drawn.get(page, ())]
        if rows and (answers := rows[-1].select_one(".rs-answers")):
            answers["id"] = "answers"
            for box in article.select("details.sd-dropdown > summary"):
                if box.get_text(strip=True) == "Answer" and box.parent:
                    box.parent.decompose()
            article.append(rows.pop())
        for still, row in zip(article.select(".rs-picture > figure"), rows, strict=False):
            still.replace_with(row)
        for each in article.find_all(True):
            self._rename(each, page)
        for link in article.select("a[href]"):
            self._lead(link, page, soup)
        article["id"] = page
        for heading in article.select("h1, h2"):
            section = heading.parent
            target = page if heading.name == "h1" else str(section["id"]) if section else page
            title = re.sub(r"</?a\b[^>]*>", "", heading.decode_contents())
            self.lines.append(Line(int(heading.name[1]), target, title))
        return article

    def _rename(self, each: Tag, page: str) -> None:
        """Let ids, and what names them, carry the name of their page."""
        if "id" in each.attrs:
            each["id"] = f"{page}--{each['id']}"
        for name, value in list(each.attrs.items()):
            if name in NAMES:
                ids = value if isinstance(value, list) else str(value).split()
                each[name] = " ".join(f"{page}--{one}" for one in ids)
            elif isinstance(value, str) and name != "href" and "#" in value:
                each[name] = HASH.sub(rf"\1{page}--\2", value)
            elif name == "href" and each.name != "a":
                each[name] = HASH.sub(rf"\1{page}--\2", str(value))

    def _lead(self, link: Tag, page: str, soup: BeautifulSoup) -> None:
        """Let a link lead within the document, or away from it; others become text."""
        href = str(link["href"])
        if re.match(r"(https?|mailto):", href):
            return
        file, _, anchor = urljoin(f"{page}.html", href).partition("#")
        target = file.removesuffix(".html")
        if target not in self.pages:
            link.unwrap()
            return
        to = f"{target}--{unquote(anchor)}" if anchor else target
        link["href"] = f"#{to}"
        # Names of functions are looked up in the library's pages, which are in order.
        if target != page and not link.find("code"):
            number = soup.new_tag("span", attrs={"class": "rs-at", "data-to": to})
            link.insert_after(number)
