"""A page asks for one style sheet and one script, which are prepared here.

The theme and the extensions have a dozen of each, and a script of a megabyte and a half for a few
icons. The sheets are joined in their order, with the fonts and colours of the course, and with the
font of the icons cut down to those that pages show.
``chapters/_templates/layout.html`` links the two files that come of it.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from robust_slam_course.style import site_colours
from sphinx.application import Sphinx
from sphinx.util import logging

from . import fonts

LOGGER = logging.getLogger(__name__)
STYLE, SCRIPT = "course.css", "course.js"
SHEETS = (
    "basic.css",
    "styles/pydata-sphinx-theme.css",
    "pygments.css",
    "styles/sphinx-book-theme.css",
    "togglebutton.css",
    "copybutton.css",
    "mystnb.*.css",
    "sphinx-design.min.css",
    "math.css",
    "site.css",
)
SCRIPTS = (
    "doctools.js",
    "sphinx_highlight.js",
    "clipboard.min.js",
    "copybutton.js",
    "scripts/sphinx-book-theme.js",
    "togglebutton.js",
    "print.js",
    "progress.js",
    "scripts/bootstrap.js",
    "scripts/pydata-sphinx-theme.js",
)
"""Files and patterns below _static/, in the order in which a page would link them."""
UNUSED = {"design-tabs.js", "sphinx-thebe.js", "sphinx-thebe.css", "styles/theme.css"}
"""No page has tabs, or a kernel in the cloud; the last one imports the first of the sheets."""
ALONE = {"documentation_options.js"}
"""Short, and read by lines of script in the page itself."""

ICONS = re.compile(r'class="[^"]*\bfa-[^"]*"')
NAME = re.compile(r"\bfa-[\w-]+")
ICON_RULE = re.compile(r'((?:\.fa-[\w-]+:{1,2}before,?)+)\{content:"[^"]*"\}')
"""The rules of the theme's two thousand icons."""
CODE = re.compile(r"\\([ef][0-9a-f]{3})\b|([\ue000-\uf8ff])")
"""An icon that a rule writes."""
ICON_FONT = re.compile(r"url\([^)]*/(fa-[\w-]+)\.woff2\)[^;}]*")


def link(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Leave out of a page what is joined; a file that this module does not know is a warning."""
    known = {posixpath.join("_static", name) for name in (*SHEETS, *SCRIPTS, *UNUSED)}
    kept = []
    for each in (*context["css_files"], *context["script_files"]):
        name = re.sub(r"mystnb\.\w+\.css$", "mystnb.*.css", str(each.filename or ""))
        if name and name not in known | {f"_static/{alone}" for alone in ALONE}:
            LOGGER.warning("look.py does not know %s: add it to its lists", name, location=page)
        if name not in known and "thebe" not in str(each.attributes):
            kept.append(each)
    context["css_files"] = []
    # The theme names some twice.
    context["script_files"] = [each for k, each in enumerate(kept) if each not in kept[:k]]


def write(app: Sphinx, exception: Exception | None) -> None:
    """Write the style sheet and the script that pages link."""
    if exception or app.builder.format != "html":
        return
    static = Path(app.outdir, "_static")
    # It begins with a semicolon: "use strict" of the first file is not for the others.
    script = "".join(f";\n{path.read_text('utf-8')}" for path in files(static, SCRIPTS))
    (static / SCRIPT).write_text(script, encoding="utf-8")
    style = "\n".join(sheet(path, static) for path in files(static, SHEETS))
    pages = (path.read_text("utf-8") for path in written(Path(app.outdir)))
    icons = (icon for page in pages for icon in ICONS.findall(page))
    style = with_icons(style, {name for icon in icons for name in NAME.findall(icon)}, static)
    style = fonts.style_sheet() + site_colours() + style
    (static / STYLE).write_text(style, encoding="utf-8")


def files(static: Path, names: Iterable[str]) -> Iterator[Path]:
    """Give the paths of files by their names; a theme without one of them is another theme."""
    for name in names:
        found = sorted(static.glob(name))
        if not found:
            raise FileNotFoundError(f"{name} is not in {static}: look at the lists in look.py")
        yield from found


def written(folder: Path) -> list[Path]:
    """Return the pages of the book; what was put beside them comes as it is."""
    return sorted([*folder.glob("*.html"), *(folder / "chapters").rglob("*.html")])


def sheet(path: Path, static: Path) -> str:
    """Return a style sheet with its addresses as seen from _static/."""

    def moved(match: re.Match[str]) -> str:
        return f"url({posixpath.normpath(posixpath.join(folder, match['path']))})"

    folder = path.relative_to(static).parent.as_posix()
    local = r"url\((['\"]?)(?P<path>(?!['\"]|data:|https?:|#)[^)'\"]+)\1\)"
    return re.sub(local, moved, path.read_text(encoding="utf-8"))


def with_icons(style: str, shown: set[str], static: Path) -> str:
    """Return a style sheet that carries the icons that pages show and its own rules write."""

    def used(match: re.Match[str]) -> str:
        return match[0] if shown & set(NAME.findall(match[1])) else ""

    def carried(match: re.Match[str]) -> str:
        font = fonts.cut_down(next(static.rglob(f"{match[1]}.woff2")), signs, **fonts.IN_TEXT)
        return fonts.source(font)

    style = ICON_RULE.sub(used, style)
    signs = {int(code, 16) if code else ord(sign) for code, sign in CODE.findall(style)}
    return ICON_FONT.sub(carried, style)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build, behind all that adds files."""
    app.connect("html-page-context", link, priority=900)
    app.connect("build-finished", write, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
