"""A page asks for one style sheet and one script, and brings its icons along.

Sphinx, the theme and the extensions link a dozen style sheets and as many scripts, and a font and
a script of half a megabyte for a few icons. When the pages are written, the sheets are joined in
their order, without the rules for what no page has, and so are the scripts, which then wait until
the page is read; icons become drawings
in the page, and the font is cut down to those that rules write.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable
from pathlib import Path

from fontTools import subset
from sphinx.application import Sphinx

from robust_slam_fonts import cut_down, packed, source
from robust_slam_rules import used_rules, words

STYLE = "bundle.css"
SCRIPT = "bundle.js"
OPTIONS = "documentation_options.js"
"""Short, and read by the lines of script in the page itself: it becomes one of them."""
ICONS = "scripts/fontawesome.js"
"""Half a megabyte of icons; the pages take those that they show."""
SUPERFLUOUS = {ICONS, "design-tabs.js"}
"""What no page needs: none has tabs."""
SEARCH = {"searchtools.js", "language_data.js"}
"""The page of search results loads them where it needs them."""
ALONE = {"search.js"}
"""What one page links stays apart."""

PLACE = r"(?P<folder>[^\"?]*?)_static/(?P<name>[^\"?]+)(?:\?[^\"]*)?"
LINKED_STYLE = re.compile(
    rf'[ \t]*<link\b(?=[^>]*rel="stylesheet")[^>]*href="{PLACE}"[^>]*>\n?',
)
LINKED_SCRIPT = re.compile(rf'[ \t]*<script\b[^>]*src="{PLACE}"[^>]*></script>\n?')
INDEX = re.compile(r'[ \t]*<script src="[^"]*searchindex\.js[^"]*"[^>]*></script>\n?')
PRELOADED = re.compile(r'[ \t]*<link rel="preload" as="script"[^>]*>\n?')
ICON = re.compile(
    r'<(?P<tag>i|span) class="(?P<classes>[^"]*\b(?:fas|fab|fa-solid|fa-brands)\b[^"]*)"'
    r"(?P<more>[^>]*)></(?P=tag)>"
)
DRAWING = re.compile(
    r'"?([\w-]+)"?:\[(\d+),(\d+),\[[^\]]*\],"\w+",(?:"([^"]+)"|\["[^"]*","([^"]+)"\])\]'
)
"""An icon in the theme's script: its name, size, and outline."""
Drawing = tuple[str, str, str]
"""Width, height and outline."""
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
    scripts = [name for name in scripts if name not in SUPERFLUOUS | SEARCH | ALONE | {OPTIONS}]
    script = ";\n".join(["", *((static / name).read_text("utf-8") for name in scripts)])
    (static / SCRIPT).write_text(script, encoding="utf-8")
    options = (static / OPTIONS).read_text(encoding="utf-8")
    icons = drawings((static / ICONS).read_text(encoding="utf-8"))
    pages |= {path: lighter(page, options, icons) for path, page in fresh.items()}
    style = with_icons("\n".join(sheet(static, name) for name in styles), static)
    style = used_rules(style, words([*pages.values(), script, *own_scripts(Path(app.srcdir))]))
    (static / STYLE).write_text(style, encoding="utf-8")
    for path in fresh:
        path.write_text(pages[path], encoding="utf-8")


def own_scripts(source: Path) -> list[str]:
    """The scripts that pages load when something is run in them."""
    return [path.read_text("utf-8") for path in sorted((source / "chapters/python").rglob("*.js"))]


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


def with_icons(style: str, static: Path) -> str:
    """Return the style with the icons that its own rules write, before titles and links.

    Those that pages name are drawings, see ``drawn``.
    """
    style = ICON_RULE.sub("", style)
    signs = {chr(int(code, 16)) for code in re.findall(r"\\([ef][0-9a-f]{3})\b", style)}
    signs |= {sign for sign in style if "\ue000" <= sign <= "\uf8ff"}

    options = subset.Options(layout_features=[], hinting=False)

    def inline(match: re.Match[str]) -> str:
        path = next(static.rglob(f"{match['name']}.woff2"))
        return source(packed(cut_down(path, sorted(map(ord, signs)), options)))

    return ICON_FONT.sub(inline, style)


def lighter(page: str, options: str, icons: dict[str, Drawing]) -> str:
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
        return match[0] if match["name"] in ALONE | {SCRIPT} else ""

    if first:
        page = page[: first.start()] + joined + page[first.start() :]
    page = LINKED_STYLE.sub(lambda match: match[0] if match["name"] == STYLE else "", page)
    for superfluous in (INDEX, PRELOADED):
        page = superfluous.sub("", page)
    page = LINKED_SCRIPT.sub(script, page)
    return ICON.sub(lambda match: drawn(match, icons), page)


def drawings(script: str) -> dict[str, Drawing]:
    """The icons that the theme's script draws; of two with a name the solid one, which is last."""
    found = DRAWING.findall(script)
    return {name: (width, height, one or two) for name, width, height, one, two in found}


def drawn(match: re.Match[str], icons: dict[str, Drawing]) -> str:
    """Return an icon as a drawing, as the theme's script would have put it there."""
    names = [name.removeprefix("fa-") for name in match["classes"].split()]
    width, height, outline = next(icons[name] for name in names if name in icons)
    more = re.sub(r' (title|aria-hidden)="[^"]*"', "", match["more"])
    families = {"fa", "fas", "fab", "fa-solid", "fa-brands"}
    kept = [name for name in match["classes"].split() if name not in families]
    classes = " ".join(["svg-inline--fa", *kept])
    return (
        f'<svg class="{classes}" aria-hidden="true"{more} viewBox="0 0 {width} {height}">'
        f'<path fill="currentColor" d="{outline}"></path></svg>'
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build, behind all that adds files."""
    app.connect("build-finished", bundle, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
