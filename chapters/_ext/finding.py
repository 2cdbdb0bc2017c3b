"""What the course is called, and how pages are found: by search, and where an address is pasted.

Pagefind makes the index of the pages as they are read: formulas are no longer TeX, and what stands
around the text is left out. A preview needs the address of the site and of a picture, and so do
the list of all pages and the links of the page that a server shows where there is none. The
address is that of the public repository's pages, where _config.yml gives the site no other one;
without any, a page still has its title and description. ``chapters/_templates`` writes them.
"""

import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
from html import escape
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import urljoin, urlsplit
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from docutils import nodes
from robust_slam_autograder.publishing import wheels
from robust_slam_course.plots import opening
from robust_slam_course.style import figure_style
from sphinx.application import Sphinx
from sphinx.config import Config

from .orient import CHAPTER

INDEX = "pagefind"
NO_TEXT = ".headerlink, .prev-next-area, .cell, .rs-forget, script, style, svg, button"
SECTION = re.compile(
    r'<section (?P<id>id="[^"]+")[^>]*>\s*(?:<span id="[^"]*"></span>)*<(?P<level>h\d)>'
)
"""Pagefind takes the addresses of sections from the headings, Sphinx writes them before these."""
WEIGHT = 0.1
"""Of a page that is no chapter, where a chapter's text has 1 and its headings have up to 7."""
HEADING = 7
DEFINES = "<h1>Symbols<"
DEFINED = re.compile(r"<tr\b[^>]*>\s*<td|<td(?=[^>]*><p><code)")
"""The word or the symbol of a row, and its name in code."""
IMAGE = re.compile(r"<img\b[^>]*>")
"""Pagefind keeps a page's first one and ranks its words as a title's."""
FORMULA = re.compile(r"<math\b.*?</math>", re.DOTALL)
ALONE = re.compile(
    r'(?P<line><div class="math">)<math.*?</math>'
    r"|(?P<cell><t[dh]\b[^>]*><p>)"
    r'(?:<span class="math"><math(?:(?!</math>).)*</math></span>|[\d.,%\s−–-]+)'
    r"(?=[\s\u2060]*</p></t)",
    re.DOTALL,
)
"""A line that is a formula, or a cell that is one or a number: in a result it tells nothing."""
RELATIONS = {*"=≠<>≤≥≈∈→"}
RAISED = str.maketrans("0123456789−", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
PICTURE = "_static/preview.png"
SIZE, DOTS = (10.0, 5.25), 120  # in inches: 1200 x 630 pixels, what most previews show


def name_the_course(app: Sphinx, config: Config) -> None:
    """Give sidebar and pages the name, the title in _config.yml, and their foot the version."""
    options, name = config.html_theme_options, escape(config.html_title)
    options["logo"]["text"] = name
    config.myst_substitutions |= {"course": name, "author": escape(config.author)}
    # That of the library, as students install it: with another one all pages are written again.
    if "{version}" in (foot := options.get("extra_footer", "")):
        version = wheels.version(Path(app.srcdir), "lib")
        options["extra_footer"] = foot.replace("{version}", version)


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
    """Tell the templates the site's address, and what previews say of a page."""
    context["address"] = app.config.html_baseurl
    if page == app.config.root_doc:
        context["docstitle"] = ""  # its own title is the course's
    if doctree:
        own = [each for each in doctree.findall(nodes.meta) if each.get("name") == "description"]
        context["described"] = bool(own)
        context["description"] = own[0]["content"] if own else first_sentences(doctree)


def first_sentences(doctree: nodes.document) -> str:
    """Return the first sentences of a page that need no TeX."""
    paragraph = doctree.next_node(nodes.paragraph)
    sentences = re.split(r"(?<=[.?!])\s+", paragraph.astext() if paragraph else "")
    sentences = [sentence for sentence in sentences if not re.search(r"[\\^_]", sentence)]
    return textwrap.shorten(" ".join(sentences), 160, placeholder=" …")


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
    """Make the index of the search."""
    if exception or app.builder.format != "html":
        return
    made = Path(app.outdir, INDEX)
    shutil.rmtree(made, ignore_errors=True)  # its files are named by what is in them
    # Its own process ends when all files are whole; as a service it is ended when it has answered.
    with tempfile.TemporaryDirectory() as folder:
        for name in sorted(app.env.found_docs):
            page = Path(folder, app.builder.get_target_uri(name))
            page.parent.mkdir(parents=True, exist_ok=True)
            text = Path(app.builder.get_outfilename(name)).read_text("utf-8")
            page.write_text(weighed(name, for_the_index(text)), "utf-8")
        options = {"site": folder, "output-path": made, "root-selector": "article"}
        options["exclude-selectors"] = NO_TEXT
        words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
        subprocess.run([sys.executable, "-m", "pagefind", *words], check=True, capture_output=True)
    for pattern in ("*-ui.*", "*-highlight.js", "*-worker.js"):  # which the site does not use
        for path in made.glob(pattern):
            path.unlink()


def weighed(name: str, page: str) -> str:
    """Return a page that counts less than the chapters, which explain what others use or list.

    Only what a table of words or symbols defines counts as much as a chapter's heading.
    """
    if CHAPTER.match(PurePosixPath(name).name):
        return page
    if DEFINES in page:
        page = DEFINED.sub(rf'\g<0> data-pagefind-weight="{HEADING}"', page)
    return re.sub(r"<(article|h\d)\b", rf'<\1 data-pagefind-weight="{WEIGHT}"', page)


def for_the_index(page: str) -> str:
    """Return a page whose headings have their sections' addresses and whose formulas are text."""
    page = SECTION.sub(r"<section><\g<level> \g<id>>", IMAGE.sub("", page))
    page = ALONE.sub(r"\g<line>\g<cell>", page)
    return FORMULA.sub(lambda match: escape(in_a_line(ElementTree.fromstring(match[0]))), page)


def in_a_line(formula: Element) -> str:
    """Return a formula in MathML as text: a half is 1/2, and not 12, and a square is u²."""
    kind = formula.tag.rpartition("}")[2]
    parts = [part for part in (formula.text or "", *map(in_a_line, formula)) if part.strip()]
    if kind == "mo" and "".join(parts) in RELATIONS:
        return f" {parts[0]} "
    if kind == "msup" and not parts[1].translate(RAISED).isascii():
        return parts[0] + parts[1].translate(RAISED)
    joint = {"mfrac": "/", "msup": "^", "msub": "_"}.get(kind, "")
    return parts[0] if kind in {"mover", "munder"} else joint.join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build; the index is made when the pages are as they stay."""
    app.connect("config-inited", name_the_course)
    app.connect("config-inited", find_the_address)
    app.connect("html-page-context", describe)
    app.connect("build-finished", write_for_engines)
    app.connect("build-finished", index, priority=950)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
