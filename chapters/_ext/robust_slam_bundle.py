"""A page asks for one style sheet and one script, and brings its icons along.

Sphinx, the theme and the extensions link a dozen style sheets and as many scripts, and a font and
a script of half a megabyte for a few icons. When the pages are written, the sheets are joined in
their order and so are the scripts, which then wait until the page is read; the icons' font is cut
down to those that are used and stands inside the sheet.
"""

from __future__ import annotations

import base64
import io
import posixpath
import re
from collections.abc import Iterable
from pathlib import Path

from fontTools import subset
from fontTools.ttLib import TTFont
from sphinx.application import Sphinx

STYLE = "bundle.css"
SCRIPT = "bundle.js"
OPTIONS = "documentation_options.js"
"""Short, and read by the lines of script in the page itself: it becomes one of them."""
SUPERFLUOUS = {
    "scripts/fontawesome.js",  # the icons' font draws them too
    "design-tabs.js",  # no page has tabs
}
SEARCH = {"searchtools.js", "language_data.js", "searchindex.js"}
"""Only the page of search results needs them."""

PLACE = r"(?P<folder>[^\"?]*?)_static/(?P<name>[^\"?]+)(?:\?[^\"]*)?"
LINKED_STYLE = re.compile(
    rf'[ \t]*<link\b(?=[^>]*rel="stylesheet")[^>]*href="{PLACE}"[^>]*>\n?',
)
LINKED_SCRIPT = re.compile(rf'[ \t]*<script\b[^>]*src="{PLACE}"[^>]*></script>\n?')
INDEX = re.compile(r'[ \t]*<script src="[^"]*searchindex\.js[^"]*"[^>]*></script>\n?')
PRELOADED = re.compile(r'[ \t]*<link rel="preload" as="script"[^>]*>\n?')
ICON = re.compile(r'<(?P<tag>i|span) class="(?P<names>(?:[\w-]+ +)*(?:fa|fa-solid|fas|fab)\b)')
ICON_RULE = re.compile(r'(?:\.(fa-[\w-]+):{1,2}before,?)+\{content:"(\\[^"]*)"\}')
ICON_FONT = re.compile(
    r"url\([^)]*/(?P<name>fa-[\w-]+)\.woff2\) format\(\"woff2\"\)"
    r"(?:, ?url\([^)]*\.ttf\) format\(\"truetype\"\))?"
)


def bundle(app: Sphinx, exception: Exception | None) -> None:
    """Join what the pages link, where pages were written."""
    if exception or app.builder.format != "html":
        return
    static = Path(app.outdir) / "_static"
    pages = {path: path.read_text(encoding="utf-8") for path in written(Path(app.outdir))}
    fresh = {path: page for path, page in pages.items() if LINKED_STYLE.search(page)}
    fresh = {path: page for path, page in fresh.items() if f"_static/{STYLE}" not in page}
    if not fresh:
        return
    styles = in_order(linked(LINKED_STYLE, page) for page in fresh.values())
    scripts = in_order(linked(LINKED_SCRIPT, page) for page in fresh.values())
    scripts = [name for name in scripts if name not in SUPERFLUOUS | SEARCH | {OPTIONS}]
    script = ";\n".join(["", *((static / name).read_text("utf-8") for name in scripts)])
    (static / SCRIPT).write_text(script, encoding="utf-8")
    used = set(re.findall(r"\bfa-[a-z0-9-]+", "".join(pages.values()) + script))
    style = with_icons("\n".join(sheet(static, name) for name in styles), used, static)
    (static / STYLE).write_text(style, encoding="utf-8")
    options = (static / OPTIONS).read_text(encoding="utf-8")
    for path, page in fresh.items():
        keep = SEARCH if path.name == "search.html" else set()
        path.write_text(lighter(page, options, keep), encoding="utf-8")


def written(folder: Path) -> list[Path]:
    """The pages of the book; what was put beside them comes as it is."""
    return sorted([*folder.glob("*.html"), *(folder / "chapters").rglob("*.html")])


def linked(pattern: re.Pattern[str], page: str) -> list[str]:
    """The names below _static/ of what a page links, in its order."""
    return [match["name"] for match in pattern.finditer(page)]


def in_order(lists: Iterable[list[str]]) -> list[str]:
    """All names once, in the order of the longest list, then as they come."""
    ordered = sorted(lists, key=len, reverse=True)
    return list(dict.fromkeys(name for names in ordered for name in names))


def sheet(static: Path, name: str) -> str:
    """A style sheet with what it imports, its addresses as seen from _static/."""
    folder = posixpath.dirname(name)

    def moved(match: re.Match[str]) -> str:
        return f"url({posixpath.normpath(posixpath.join(folder, match['path']))})"

    text = (static / name).read_text(encoding="utf-8")
    text = re.sub(r"url\((['\"]?)(?P<path>(?!['\"]|data:|https?:|#)[^)'\"]+)\1\)", moved, text)
    imported = re.compile(r"@import (['\"])(?P<path>[^'\"]+)\1;")
    return imported.sub(
        lambda match: sheet(static, posixpath.normpath(posixpath.join(folder, match["path"]))),
        text,
    )


def with_icons(style: str, used: set[str], static: Path) -> str:
    """Return the style with the icons that are used, and no others.

    They are those that a page or script names, and those that a rule of the style writes.
    """
    named = {
        code
        for names, code in ((match[0], match[2]) for match in ICON_RULE.finditer(style))
        if used & set(re.findall(r"fa-[\w-]+", names))
    }
    style = ICON_RULE.sub(lambda match: match[0] if match[2] in named else "", style)
    signs = {chr(int(code, 16)) for code in re.findall(r"\\([ef][0-9a-f]{3})\b", style)}
    signs |= {sign for sign in style if "\ue000" <= sign <= "\uf8ff"}

    def inline(match: re.Match[str]) -> str:
        path = next(static.rglob(f"{match['name']}.woff2"))
        data = base64.b64encode(cut_down(path, signs)).decode()
        return f'url(data:font/woff2;base64,{data}) format("woff2")'

    return ICON_FONT.sub(inline, style)


def cut_down(path: Path, signs: set[str]) -> bytes:
    """Return a font with these signs alone, as woff2."""
    font = TTFont(path, recalcTimestamp=False)
    subsetter = subset.Subsetter(subset.Options(layout_features=[], hinting=False))
    subsetter.populate(text="".join(sorted(signs)))
    subsetter.subset(font)
    font.flavor = "woff2"
    target = io.BytesIO()
    font.save(target)
    return target.getvalue()


def lighter(page: str, options: str, keep: set[str]) -> str:
    """Return a page that links the joined style and script in place of their parts."""
    first = LINKED_STYLE.search(page)
    folder = first["folder"] if first else ""
    joined = (
        f'    <link rel="stylesheet" type="text/css" href="{folder}_static/{STYLE}" />\n'
        f'    <script defer src="{folder}_static/{SCRIPT}"></script>\n'
    )

    def script(match: re.Match[str]) -> str:
        if match["name"] == OPTIONS:
            return f"    <script>{options.strip()}</script>\n"
        return match[0] if match["name"] in keep else ""

    if first:
        page = page[: first.start()] + joined + page[first.start() :]
    page = LINKED_STYLE.sub(lambda match: match[0] if match["name"] == STYLE else "", page)
    page = LINKED_SCRIPT.sub(
        lambda match: match[0] if match["name"] == SCRIPT else script(match), page
    )
    if not keep:
        page = INDEX.sub("", page)
    return ICON.sub(lambda match: match[0].replace("<i ", '<i aria-hidden="true" '), PRELOADED.sub("", page))


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build, behind all that adds files."""
    app.connect("build-finished", bundle, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
