"""What the site needs beyond jupyter-book: it works offline, and follows the library.

- What a cell prints stands as it was printed, in however many pieces the kernel sent it.
- A figure may get its caption and its alternative text from the cell's output.
- Scripts for kernels in the cloud, and scripts that are emitted twice, are dropped.
- Launch buttons need the public repository's address; without one there are none.
- When the library or a table of the chapters changes, the notebooks run again, and so they do
  when a public graph that they show appears or vanishes.
- A build with warnings fails again until they are fixed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from markdown_it.tree import SyntaxTreeNode
from myst_nb.core import render
from myst_nb.sphinx_ import SphinxNbRenderer
from nbformat import NotebookNode
from robust_slam.graphs import datasets
from sphinx.application import Sphinx
from sphinx.config import Config

# Sphinx's search serves pages from the disk alone, where browsers refuse to fetch excerpts.
SEARCH_FROM_DISK = "DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;"

# Paper is white: a page that is dark on the screen is printed light.
PRINT_LIGHT = """
addEventListener("beforeprint", () => {
  const {dataset} = document.documentElement, {theme} = dataset;
  dataset.theme = "light";
  addEventListener("afterprint", () => { dataset.theme = theme; }, {once: true});
});
"""


Merge = Callable[[list[NotebookNode]], list[NotebookNode]]
"""Makes one output of all that a cell prints."""
RenderOutputs = Callable[[SphinxNbRenderer, SyntaxTreeNode, list[NotebookNode]], None]
"""Puts the outputs of a cell on its page."""


def joining(merge: Merge) -> Merge:
    """Join neighbouring pieces of what a cell printed before they are merged.

    A kernel sends what is printed five times a second, in the middle of a line too; myst-nb alone
    would begin a new line there, or leave one empty.
    """

    def joined(outputs: list[NotebookNode]) -> list[NotebookNode]:
        whole: list[NotebookNode] = []
        for output in outputs:
            is_stream = output.output_type == "stream"
            if is_stream and whole and whole[-1].get("name") == output.name:
                whole[-1].text += output.text
            else:
                whole.append(NotebookNode(output))
        return merge(whole)

    return joined


def with_words_of_the_output(render_outputs: RenderOutputs) -> RenderOutputs:
    """Let the metadata of a cell's outputs add to the captions in the cell's own metadata.

    myst-nb knows only the cell's, which cannot follow what the cell computed. See
    ``robust_slam_course.plots.captions``.
    """

    def rendered(
        renderer: SphinxNbRenderer, token: SyntaxTreeNode, outputs: list[NotebookNode]
    ) -> None:
        words = dict(token.meta["metadata"].get("mystnb", {}))
        for output in outputs:
            for key, value in output.get("metadata", {}).get("mystnb", {}).items():
                words[key] = words.get(key, {}) | value
        token.meta["metadata"] = {**token.meta["metadata"], "mystnb": words}
        render_outputs(renderer, token, outputs)

    return rendered


def follow_the_library(app: Sphinx, config: Config) -> None:
    """Keep executed notebooks under a name that changes with all that they read.

    They read the library, the tables, and the public graphs that are on this machine.
    """
    library, data = (Path(app.srcdir) / name for name in ("lib", "chapters/data"))
    digest = hashlib.sha256()
    for path in [*sorted(library.rglob("*.*")), *sorted(data.glob("*.csv"))]:
        if path.suffix in {".py", ".js", ".css", ".csv"}:
            digest.update(path.read_bytes())
    digest.update(repr([name for name in datasets.SHOWN if datasets.is_here(name)]).encode())
    config.robust_slam_library = digest.hexdigest()[:12]
    cache = Path(app.outdir).parent / ".jupyter_cache" / config.robust_slam_library
    config.nb_execution_cache_path = str(cache)


def follow_the_extensions(app: Sphinx, config: Config) -> None:
    """Write all pages again when what finishes them changes."""
    folder = Path(app.srcdir) / "chapters"
    files = [*sorted(folder.glob("_ext/*.py")), *sorted(folder.glob("math/*"))]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in files))
    config.robust_slam_extensions = digest.hexdigest()


def launch_from_the_repository(app: Sphinx, config: Config) -> None:
    """Leave out the launch buttons where no repository is named that Colab and Binder can open."""
    options = config.html_theme_options
    address = urlsplit(options.get("repository_url") or "")
    if address.hostname == "github.com" and len(address.path.strip("/").split("/")) == 2:
        options["repository_url"] = address.geturl().rstrip("/").removesuffix(".git")
    else:
        options |= {"repository_url": "", "launch_buttons": {}}


def drop_scripts(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object
) -> None:
    """Leave out the scripts of thebe, and all but the first of each file."""
    seen: set[str] = set()
    kept = []
    for script in context["script_files"]:
        name = str(getattr(script, "filename", "") or getattr(script, "attributes", ""))
        if "thebe" not in name.lower() and name not in seen:
            kept.append(script)
        seen.add(name)
    context["script_files"] = kept


def forget_if_warned(app: Sphinx, exception: Exception | None) -> None:
    """Let the next build read every page again when this one had warnings.

    Otherwise it would find nothing out of date, say nothing and succeed.
    """
    if app._warncount:
        (Path(app.doctreedir) / "environment.pickle").unlink(missing_ok=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect the above to the build."""
    app.add_config_value("robust_slam_library", "", "env")
    app.add_config_value("robust_slam_extensions", "", "html")
    app.add_js_file(None, body=SEARCH_FROM_DISK)
    app.add_js_file(None, body=PRINT_LIGHT)
    render.coalesce_streams = joining(render.coalesce_streams)
    SphinxNbRenderer._render_nb_cell_code_outputs = with_words_of_the_output(
        SphinxNbRenderer._render_nb_cell_code_outputs
    )
    app.connect("config-inited", follow_the_library)
    app.connect("config-inited", follow_the_extensions)
    app.connect("config-inited", launch_from_the_repository)
    app.connect("html-page-context", drop_scripts, priority=900)
    app.connect("build-finished", forget_if_warned)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
