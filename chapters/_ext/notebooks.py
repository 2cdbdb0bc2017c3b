"""What the notebooks give to their pages, and when they run again.

``python -m chapters._ext.notebooks`` runs them alone, for the book that is built next.

- Notebooks that have changed run before their pages are read, as many at once as cores. One that
  fails is left to MyST-NB, which runs it again and reports the cell.
- They run again when the library, a table of the chapters or what is there of the public graphs
  changes; pages are written again when what finishes them changes.
- What a cell prints stands as it was printed, in however many pieces the kernel sent it.
- A figure is elements of the page, in its font and colours, and may get its caption and its
  alternative text from the cell's output.
- ``{picture}`` and a name is a live picture on a page that is no notebook.
- Docstrings are text for readers of the code, in which |u| is a size and a colon no end of a type.
"""

import hashlib
import os
import re
from collections.abc import Iterable
from enum import EnumType
from html import escape
from pathlib import Path
from typing import Any

import yaml
from docutils import nodes
from docutils.parsers.rst import Directive
from jupyter_cache.cache.main import JupyterCacheBase
from jupyter_cache.executors import load_executor
from markdown_it.tree import SyntaxTreeNode
from myst_nb.core import render
from myst_nb.sphinx_ import SphinxNbRenderer
from nbformat import NotebookNode
from robust_slam.files import datasets
from robust_slam_course import figures, pictures
from robust_slam_course.style import figure_style
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.environment import BuildEnvironment
from sphinx.transforms import SphinxTransform

from . import names

FIGURE = '<div class="rs-figure"'
"""How a figure begins that the course's style draws while the book is built."""
BAR = re.compile(r"(?m)^\s*(?:>>>|\.\.\.).*|``.*?``|(\|)")
"""A bar of a docstring, or an example and code, in which bars stay."""
ROOT = Path(__file__).parents[2]
CACHE = ".jupyter_cache"
"""Where executed notebooks are kept, beside the site."""
MERGE = render.coalesce_streams
RENDER = SphinxNbRenderer._render_nb_cell_code_outputs
"""What MyST-NB does with the outputs of a cell."""


class Cache(JupyterCacheBase):
    """A cache without a limit: to keep it, a process could forget what another one adds."""

    def truncate_caches(self) -> None:
        """Forget nothing."""


def execute(app: Sphinx, env: BuildEnvironment, pages: list[str]) -> None:
    """Run the notebooks among the pages that are about to be read and are not in the cache."""
    config = env.mystnb_config
    paths = [str(env.doc2path(page)) for page in pages]
    paths = [path for path in paths if path.endswith(".ipynb")]
    if config.execution_mode == "cache" and paths:
        run(paths, config.execution_cache_path, config.execution_timeout)


def run(paths: list[str], kept: str, timeout: float) -> None:
    """Run the notebooks that are not in the cache at ``kept``, a cell for ``timeout`` seconds.

    What their names stand for after each cell is kept beside it, as ``names`` tells.
    """
    os.environ["PYTHONSTARTUP"] = str(Path(__file__).with_name("start_kernel.py"))
    os.environ[names.FOLDER] = str(Path(kept, names.BESIDE))
    cache = Cache(kept)
    # From the last one on: the appendices take longest, and no core waits for one in the end.
    for path in sorted(paths, reverse=True):
        cache.add_nb_to_project(path)
    load_executor("local-parallel", cache).run_and_cache(filter_uris=paths, timeout=timeout)


def follow(app: Sphinx, config: Config) -> None:
    """Note what the pages are made of: executed notebooks are kept under its name."""
    config.course_library = library(Path(app.srcdir))
    config.course_extensions = _digest(Path(app.srcdir, "chapters/_ext").glob("*.py"))
    cache = Path(app.outdir).parent / CACHE / config.course_library
    config.nb_execution_cache_path = str(cache)


def run_here(paths: list[Path]) -> Path:
    """Run notebooks of this course as its book does; return where their names are kept."""
    os.environ[figures.BUILD] = "1"
    settings = yaml.safe_load((ROOT / "_config.yml").read_text("utf-8"))["execute"]
    kept = ROOT / "build" / "_build" / CACHE / library(ROOT)
    run([str(path) for path in paths], str(kept), settings["timeout"])
    return kept / names.BESIDE


def library(root: Path) -> str:
    """Return a name for all that the notebooks of a course read."""
    here = [name for name in datasets.SHOWN if datasets.is_here(name)]
    found = [*Path(root, "lib/robust_slam").rglob("*.*"), *Path(root, "lib/course").rglob("*.*")]
    read = [path for path in found if path.suffix in {".py", ".js", ".css", ".csv"}]
    read += Path(root, "chapters/data").glob("*.csv")
    read.append(Path(names.__file__))
    return _digest(read, here)


def _digest(paths: Iterable[Path], more: object = None) -> str:
    digest = hashlib.sha256(repr(more).encode())
    for path in sorted(paths):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def forget_if_warned(app: Sphinx, exception: Exception | None) -> None:
    """Let the next build read every page again when this one had warnings.

    Otherwise it would find nothing out of date, say nothing and succeed.
    """
    if app._warncount:
        Path(app.doctreedir, "environment.pickle").unlink(missing_ok=True)


def merged(outputs: list[NotebookNode]) -> list[NotebookNode]:
    """Merge all that a cell printed, after neighbouring pieces are joined.

    A kernel sends what is printed five times a second, in the middle of a line too; myst-nb alone
    would begin a new line there, or leave one empty.
    """
    whole: list[NotebookNode] = []
    for output in outputs:
        is_stream = output.output_type == "stream"
        if is_stream and whole and whole[-1].get("name") == output.name:
            whole[-1].text += output.text
        else:
            whole.append(NotebookNode(output))
    return MERGE(whole)


def rendered(
    renderer: SphinxNbRenderer, token: SyntaxTreeNode, outputs: list[NotebookNode]
) -> None:
    """Put the outputs of a cell on its page, with captions from their metadata too.

    myst-nb knows only those in the cell's, which cannot follow what the cell computed. See
    ``robust_slam_course.plots.captions``.
    """
    words = dict(token.meta["metadata"].get("mystnb", {}))
    for output in outputs:
        for key, value in output.get("metadata", {}).get("mystnb", {}).items():
            words[key] = words.get(key, {}) | value
    token.meta["metadata"] = {**token.meta["metadata"], "mystnb": words}
    RENDER(renderer, token, outputs)


class InlineFigures(SphinxTransform):
    """Puts figures that are HTML into the page, before the images of a page are collected."""

    default_priority = 10

    def apply(self) -> None:
        """Replace the images of this page that are HTML, for which MyST-NB takes them."""
        for image in list(self.document.findall(nodes.image)):
            path = Path(self.env.srcdir, image["uri"].lstrip("/"))
            html = path.read_text("utf-8") if path.suffix == ".svg" and path.is_file() else ""
            if html.startswith(FIGURE):
                label = escape(image.get("alt", ""))
                html = html.replace(FIGURE, f'{FIGURE} role="img" aria-label="{label}"', 1)
                image.replace_self(nodes.raw("", html, format="html"))


class Picture(Directive):
    """The live picture that is named."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Return the picture as HTML; builds for paper leave it out."""
        name = self.arguments[0]
        if name not in pictures.__all__:
            known = ", ".join(pictures.__all__)
            raise self.error(f"picture: there is none named {name!r}; give one of {known}")
        with figure_style():
            html = getattr(pictures, name)().static_html()
        return [nodes.raw("", html, format="html")]


def escape_bars(
    app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Escape the bars of a docstring's ``lines``, in place: they would mark a substitution."""
    escaped = BAR.sub(lambda part: r"\|" if part[1] else part[0], "\n".join(lines))
    lines[:] = escaped.split("\n")


def keep_whole(
    app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Begin a property with an empty comment: Napoleon takes text before a colon for its type."""
    if what in {"attribute", "property"}:
        lines[:0] = ["..", ""]


def without_arguments(
    app: Sphinx, what: str, name: str, obj: object, *_: object
) -> tuple[str, str] | None:
    """Return no arguments for the class of an enumeration, whose own are Python's."""
    return ("", "") if isinstance(obj, EnumType) else None


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    os.environ[figures.BUILD] = "1"  # tells the notebooks that their figures are for pages
    render.coalesce_streams = merged
    SphinxNbRenderer._render_nb_cell_code_outputs = rendered
    app.add_config_value("course_library", "", "env")
    app.add_config_value("course_extensions", "", "html")
    app.add_transform(InlineFigures)
    app.add_directive("picture", Picture)
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", escape_bars)
    app.connect("autodoc-process-docstring", keep_whole, priority=400)  # before Napoleon, 500
    app.connect("autodoc-process-signature", without_arguments)
    app.connect("config-inited", follow)
    app.connect("env-before-read-docs", execute)
    app.connect("build-finished", forget_if_warned)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    run_here(sorted((ROOT / "chapters").glob("*.ipynb")))
