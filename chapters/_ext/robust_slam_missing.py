"""The page that a server shows at an address where there is nothing, 404.html.

It is shown at addresses of any depth, so it says where its links begin: at the site's own address.
Where that is not known, they begin at the page itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

from docutils import nodes
from sphinx.application import Sphinx

from robust_slam_preview import pages_address

PAGE = "404"
TITLE = "Page not found"
TEXT = """<section><h1>{title}</h1>
<p>There is no page at this address. The <a href="{home}">first page</a> lists the chapters; the
<a href="{search}">search</a> finds words in all of them.</p></section>"""


def add_page(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Give the page to the builder."""
    home, search = (
        app.builder.get_relative_uri(PAGE, name) for name in ("chapters/index", "search")
    )
    body = TEXT.format(title=TITLE, home=home, search=search)
    yield PAGE, {"title": TITLE, "body": body}, "page.html"


def begin_at_the_site(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Let the page's links begin at the site's address, and keep it out of search engines."""
    if page != PAGE:
        return
    address = pages_address(app)
    base = f'<base href="{urlsplit(address).path}" />\n' if address else ""
    context["metatags"] = f'{base}<meta name="robots" content="noindex" />'


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.connect("html-collect-pages", add_page)
    app.connect("html-page-context", begin_at_the_site)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
