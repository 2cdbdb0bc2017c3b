"""What the course is called, and how pages are found: by search, and where an address is pasted.

Pagefind makes the index of the pages as they are read: formulas are no longer TeX, and what stands
around the text is left out. A preview needs the address of the site and of a picture, and so do
the list of all pages and the links of the page that a server shows where there is none. The
address is that of the public repository's pages, where _config.yml gives the site no other one;
without any, a page still has its title and description.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import urljoin, urlsplit
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from docutils import nodes
from robust_slam_course.plots import opening
from robust_slam_course.style import figure_style
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.errors import ExtensionError

INDEX = "pagefind"
TEXT = "article"
NO_TEXT = ".headerlink, .prev-next-area, .rs-cited, .cell, .rs-forget, script, style, svg, button"
SECTION = re.compile(
    r'<section (?P<id>id="[^"]+")[^>]*>\s*(?:<span id="[^"]*"></span>)*<(?P<level>h\d)>'
)
"""Pagefind takes the addresses of sections from the headings, Sphinx writes them before these."""
FORMULA = re.compile(r"<math\b.*?</math>", re.DOTALL)

PICTURE = "_static/preview.png"
ALT = (
    "Three maps of one drive: without the wrong closure, folded by it, and right again under a"
    " robust kernel."
)
SIZE = (10.0, 5.25)  # inches at 120 dots each: 1200 x 630 pixels, what most previews show
DOTS = 120

MISSING = "404"
MISSING_TEXT = """<section><h1>{title}</h1>
<p>There is no page at this address. The <a href="{home}">first page</a> lists the chapters; the
<a href="{search}">search</a> finds words in all of them.</p></section>"""


def name_the_course(app: Sphinx, config: Config) -> None:
    """Give the sidebar and the pages the name, the title in _config.yml."""
    config.html_theme_options["logo"]["text"] = escape(config.html_title)
    config.myst_substitutions |= {"course": escape(config.html_title)}


def find_the_address(app: Sphinx, config: Config) -> None:
    """Set the site's own address, and leave out launch buttons that lead nowhere.

    Colab and Binder open what is https://github.com/OWNER/NAME.
    """
    options = config.html_theme_options
    repository = urlsplit(options.get("repository_url") or "")
    names = repository.path.strip("/").removesuffix(".git").split("/")
    if repository.hostname == "github.com" and len(names) == 2:
        options["repository_url"] = f"https://github.com/{'/'.join(names)}"
        config.html_baseurl = (
            config.html_baseurl or f"https://{names[0].lower()}.github.io/{names[1]}/"
        )
    else:
        options |= {"repository_url": "", "launch_buttons": {}}
    config.html_baseurl = config.html_baseurl and f"{config.html_baseurl.rstrip('/')}/"


def describe(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Give a page a description, if it has none of its own, and the tags of a preview."""
    if page == app.config.root_doc:
        context["docstitle"] = ""  # its own title is the course's
    if page == MISSING:
        # It is shown at addresses of any depth: its links begin at the site's own address.
        path = urlsplit(app.config.html_baseurl).path
        base = f'<base href="{path}" />\n' if path else ""
        context["metatags"] = f'{base}<meta name="robots" content="noindex" />'
    if doctree is None:
        return
    own = re.search(r'content="([^"]*)" name="description"', context["metatags"])
    content = own[1] if own else first_sentences(doctree)
    if content and not own:
        context["metatags"] += f'\n<meta content="{content}" name="description" />'
    title = re.sub(r"<[^>]+>", "", context["title"]).replace('"', "&quot;")
    for name, value in preview(app, title, content, app.builder.get_target_uri(page)):
        context["metatags"] += f'\n<meta property="{name}" content="{value}" />'


def first_sentences(doctree: nodes.document) -> str:
    """Return the first sentences of a page that need no TeX, as HTML."""
    paragraph = doctree.next_node(nodes.paragraph)
    sentences = re.split(r"(?<=[.?!])\s+", paragraph.astext() if paragraph else "")
    sentences = [sentence for sentence in sentences if not re.search(r"[\\^_]", sentence)]
    return escape(textwrap.shorten(" ".join(sentences), 160, placeholder=" …"))


def preview(app: Sphinx, title: str, content: str, path: str) -> Iterator[tuple[str, str]]:
    """Give the tags of the Open Graph protocol, names and values as HTML."""
    address = app.config.html_baseurl
    yield "og:type", "website"
    yield "og:site_name", escape(app.config.html_title)
    yield "og:title", title
    if content:
        yield "og:description", content
    if address:
        yield "og:url", urljoin(address, path)
        yield "og:image", urljoin(address, PICTURE)
        yield "og:image:alt", escape(ALT)
        yield "twitter:card", "summary_large_image"


def add_the_missing_page(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Give the builder the page that a server shows where there is none."""
    home, search = (
        app.builder.get_relative_uri(MISSING, name) for name in ("chapters/index", "search")
    )
    title = "Page not found"
    body = MISSING_TEXT.format(title=title, home=home, search=search)
    yield MISSING, {"title": title, "body": body}, "page.html"


def write_for_engines(app: Sphinx, exception: Exception | None) -> None:
    """Draw the picture of previews and list the pages, where the site has an address."""
    address = app.config.html_baseurl
    if exception or not address:
        return
    with figure_style():
        figure = opening.draw_opening(opening.town())
        figure.set_size_inches(*SIZE)
        figure.savefig(Path(app.outdir, PICTURE), dpi=DOTS, facecolor="white")
    pages = ElementTree.Element("urlset", xmlns="http://www.sitemaps.org/schemas/sitemap/0.9")
    for page in sorted(app.env.found_docs):
        entry = ElementTree.SubElement(ElementTree.SubElement(pages, "url"), "loc")
        entry.text = urljoin(address, app.builder.get_target_uri(page))
    ElementTree.ElementTree(pages).write(Path(app.outdir, "sitemap.xml"), "utf-8", True)


def index(app: Sphinx, exception: Exception | None) -> None:
    """Make the index of the search.

    Raises
    ------
    ExtensionError
        Pagefind failed; with what it printed.
    """
    if exception or app.builder.format != "html":
        return
    site = Path(app.outdir)
    shutil.rmtree(site / INDEX, ignore_errors=True)  # its files are named by what is in them
    with tempfile.TemporaryDirectory() as temporary:
        for name in app.env.found_docs:
            source = Path(app.builder.get_outfilename(name))
            target = Path(temporary) / source.relative_to(site)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(for_the_index(source.read_text("utf-8")), encoding="utf-8")
        command = [sys.executable, "-m", "pagefind", "--site", temporary]
        command += ["--output-path", str(site / INDEX)]
        command += ["--root-selector", TEXT, "--exclude-selectors", NO_TEXT]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ExtensionError(f"Pagefind made no index:\n{done.stdout}{done.stderr}")
    for pattern in ("*-ui.*", "*-highlight.js"):  # for which the site has its own
        for path in (site / INDEX).glob(pattern):
            path.unlink()


def for_the_index(page: str) -> str:
    """Return a page whose headings have their sections' addresses and whose formulas are text."""
    page = SECTION.sub(r"<section><\g<level> \g<id>>", page)
    return FORMULA.sub(lambda match: escape(in_a_line(ElementTree.fromstring(match[0]))), page)


def in_a_line(formula: Element) -> str:
    """Return a formula in MathML as text: a half is 1/2, and not 12."""
    parts = [formula.text or "", *map(in_a_line, formula)]
    joint = {"mfrac": "/", "msup": "^"}.get(formula.tag.rpartition("}")[2], "")
    return joint.join(part for part in parts if part.strip())


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build; the index is made when the pages are as they stay."""
    app.connect("config-inited", name_the_course)
    app.connect("config-inited", find_the_address)
    app.connect("html-page-context", describe)
    app.connect("html-collect-pages", add_the_missing_page)
    app.connect("build-finished", write_for_engines)
    app.connect("build-finished", index, priority=950)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
