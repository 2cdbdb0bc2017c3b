"""A page asks for one style sheet and one script, in which are its fonts and its icons.

The theme and the extensions have a dozen of each. They are joined in their order, with the fonts
that ``tools/fonts.py`` has prepared, and ``chapters/_templates/layout.html`` links the two files
that come of it.
"""

import base64
import re
from collections.abc import Iterable, Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from fontTools.ttLib import TTFont
from robust_slam_course.style import site_colours
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

PREPARED = Path(__file__).resolve().parents[2] / "build" / "fonts"
"""What ``python -m tools.fonts`` made: a rule for each font of text, a file for each of icons."""
FONTS, STYLE, SCRIPT = "fonts.css", "course.css", "course.js"
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
    "element.js",
    "print.js",
    "progress.js",
    "search.js",
    "sidebar.js",
    "scripts/bootstrap.js",
    "scripts/pydata-sphinx-theme.js",
)
"""Files and patterns below _static/, in the order in which a page would link them."""
UNUSED = ("design-tabs.js", "sphinx-thebe.js", "sphinx-thebe.css", "styles/theme.css")
"""No page has tabs, or a kernel in the cloud; the last one imports the first of the sheets."""

LONG = re.compile(r"<(style|script)>(?:(?!</\1>).){1000,}</\1>", re.DOTALL)
ICON_RULE = re.compile(r'(?:\.fa-[\w-]+:{1,2}before,?)+\{content:"([^"]*)"\}')
"""The rules of the theme's two thousand icons."""
CODE = re.compile(r"\\([ef][0-9a-f]{3})\b|([\ue000-\uf8ff])")
"""An icon that a rule writes."""
ICON_FONT = re.compile(r"url\([^)]*/(fa-[\w-]+\.woff2)\)[^;}]*")


def link(app: Sphinx, page: str, template: str, context: dict[str, Any], *_: object) -> None:
    """Leave out of a page what is joined, and what it has already; other files stay."""
    joined = [f"_static/{name}" for name in (*SHEETS, *SCRIPTS, *UNUSED)]
    for kind in ("css_files", "script_files"):
        context[kind] = [
            each
            for each in dict.fromkeys(context[kind])  # the theme names some twice
            if not any(fnmatch(str(each.filename), name) for name in joined)
            and "thebe" not in str(each.attributes)
        ]
    if "body" in context:
        context["body"] = once(context["body"])


def once(body: str) -> str:
    """Return the body of a page with each long style sheet and script at its first place alone.

    Two pictures of one script would carry it twice, out of the reach of a server's compression.
    """
    known: set[str] = set()

    def kept(match: re.Match[str]) -> str:
        repeated = match[0] in known
        known.add(match[0])
        return "" if repeated else match[0]

    return LONG.sub(kept, body)


def write(app: Sphinx, exception: Exception | None) -> None:
    """Write the style sheet and the script that pages link."""
    if exception or app.builder.format != "html":
        return
    static = Path(app.outdir, "_static")
    # Semicolons, since "use strict" of the first file is not for the others.
    script = "".join(f";\n{text}" for text in texts(static, SCRIPTS))
    (static / SCRIPT).write_text(script, encoding="utf-8")
    style = with_icons("\n".join(texts(static, SHEETS)))
    fonts = (PREPARED / FONTS).read_text(encoding="utf-8")
    (static / STYLE).write_text(fonts + site_colours() + style, encoding="utf-8")


def texts(static: Path, names: Iterable[str]) -> Iterator[str]:
    """Give the texts of files by their names; a theme without one of them is another theme."""
    for name in names:
        found = sorted(static.glob(name))
        if not found:
            raise FileNotFoundError(f"{name} is not in {static}: look at the lists in look.py")
        yield from (path.read_text("utf-8") for path in found)


def with_icons(style: str) -> str:
    """Return a style sheet that carries the prepared icons, without the rules of all others."""
    prepared = {sign for path in PREPARED.glob("fa-*") for sign in TTFont(path).getBestCmap()}
    style = ICON_RULE.sub(lambda rule: rule[0] if codes(rule[1]) <= prepared else "", style)
    if more := codes(style) - prepared:
        raise ValueError(
            f"a style sheet shows {sorted(map(hex, more))}: add them to tools/fonts.py"
        )

    def carried(match: re.Match[str]) -> str:
        data = base64.b64encode((PREPARED / match[1]).read_bytes()).decode()
        return f'url(data:font/woff2;base64,{data}) format("woff2")'

    return ICON_FONT.sub(carried, style)


def codes(style: str) -> set[int]:
    """Return the icons that rules write."""
    return {int(code, 16) if code else ord(sign) for code, sign in CODE.findall(style)}


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build, behind all that adds files.

    Raises:
        ExtensionError: the fonts are not prepared.
    """
    if not (PREPARED / FONTS).is_file():
        raise ExtensionError(f"{PREPARED / FONTS} is not there: run python -m tools.fonts")
    app.connect("html-page-context", link, priority=900)
    app.connect("build-finished", write, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
