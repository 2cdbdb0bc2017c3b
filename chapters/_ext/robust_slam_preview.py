"""What a page says of itself to search engines, and where its address is pasted.

A preview needs the address of the site and of a picture, and so does the list of all pages. Both
follow from the address of the public repository, where _config.yml gives the site no other one;
without any, a page still has its title and description.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import urljoin, urlsplit

from docutils import nodes
from robust_slam_course.plots import opening
from robust_slam_course.style import figure_style
from sphinx.application import Sphinx

PICTURE = "_static/preview.png"
ALT = (
    "Three maps of one drive: without the wrong closure, folded by it, and right again under a"
    " robust kernel."
)
SIZE = (10.0, 5.25)  # inches at 120 dots each: 1200 x 630 pixels, what most previews show
DOTS = 120
SITEMAP = """<?xml version="1.0" encoding="utf-8"?>
<urlset xmlns="http://www.sitemaps.org/schemas/sitemap/0.9">
{rows}</urlset>
"""


def pages_address(app: Sphinx) -> str:
    """The site's own address, or that of the repository's pages on GitHub; empty without one."""
    if app.config.html_baseurl:
        return f"{app.config.html_baseurl.rstrip('/')}/"
    # robust_slam_site leaves only what is https://github.com/OWNER/NAME.
    repository = app.config.html_theme_options["repository_url"]
    owner, _, name = urlsplit(repository).path.strip("/").partition("/")
    return f"https://{owner.lower()}.github.io/{name}/" if repository else ""


def describe(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Give a page a description, if it has none of its own, and the tags of a preview."""
    if page == app.config.root_doc:
        context["docstitle"] = ""  # its own title is the course's
    if doctree is None:
        return
    own = re.search(r'content="([^"]*)" name="description"', context["metatags"])
    content = own[1] if own else _first_sentences(doctree)
    if content and not own:
        context["metatags"] += f'\n<meta content="{content}" name="description" />'
    address, path = pages_address(app), app.builder.get_target_uri(page)
    title = re.sub(r"<[^>]+>", "", context["title"]).replace('"', "&quot;")
    for name, value in _preview(title, content, address, path):
        context["metatags"] += f'\n<meta property="{name}" content="{value}" />'


def _first_sentences(doctree: nodes.document) -> str:
    """The first sentences of a page that need no TeX, as HTML."""
    paragraph = doctree.next_node(nodes.paragraph)
    sentences = re.split(r"(?<=[.?!])\s+", paragraph.astext() if paragraph else "")
    sentences = [sentence for sentence in sentences if not re.search(r"[\\^_]", sentence)]
    return escape(textwrap.shorten(" ".join(sentences), 160, placeholder=" …"))


def _preview(title: str, content: str, address: str, path: str) -> Iterator[tuple[str, str]]:
    """The tags of the Open Graph protocol, names and values as HTML."""
    yield "og:type", "website"
    yield "og:site_name", "Robust SLAM"
    yield "og:title", title
    if content:
        yield "og:description", content
    if address:
        yield "og:url", urljoin(address, path)
        yield "og:image", urljoin(address, PICTURE)
        yield "og:image:alt", escape(ALT)
        yield "twitter:card", "summary_large_image"


def draw_picture(app: Sphinx, exception: Exception | None) -> None:
    """Draw the course's picture for previews, where the site has an address to show it from."""
    path = Path(app.outdir) / PICTURE
    if exception or not pages_address(app):
        return
    with figure_style():
        figure = opening.draw_opening(opening.town())
        figure.set_size_inches(*SIZE)
        figure.savefig(path, dpi=DOTS, facecolor="white")


def list_pages(app: Sphinx, exception: Exception | None) -> None:
    """Write sitemap.xml, where the site has an address."""
    address = pages_address(app)
    if exception or not address:
        return
    places = (urljoin(address, app.builder.get_target_uri(page)) for page in app.env.found_docs)
    rows = "".join(f"<url><loc>{escape(place)}</loc></url>\n" for place in sorted(places))
    (Path(app.outdir) / "sitemap.xml").write_text(SITEMAP.format(rows=rows), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.connect("html-page-context", describe)
    app.connect("build-finished", draw_picture)
    app.connect("build-finished", list_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
