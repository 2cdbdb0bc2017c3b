"""Python in the pages, where the runtime is there (``make runtime``).

*Edit and run* at the code of a chapter: its page gets a name for each code cell, one small script
and its style. *Your own graph*: its page gets a form, ``chapters/_templates/own_graph.html``, and
its style. All else is in the site's folder ``python`` and is loaded at the first click: the page's
code, the editor, and Python. Without the runtime chapters are as they were, and in place of the
form stands the command that does the same.
"""

import ast
import json
import shutil
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.util import logging

from . import TEMPLATES
from .offers import put_in_place

LOGGER = logging.getLogger(__name__)

SOURCES = Path(__file__).resolve().parents[1] / "python"
"""The scripts of the page and of the worker."""
TABLES = "data"
"""The folder beside the chapters with the tables that they read."""
RUNTIME = "build/runtime"
NEEDED = ("pyodide", "wheels", "editor.js", "editor-licences.txt")
"""What `make runtime` leaves for the pages."""
BYTES = "bytes"
"""The file there with the number of bytes that the engine fetches until the first cell can run."""
MODULES = {"np", "plt", "mpl"}
"""Whose functions are called for what they do elsewhere."""
SAID = {"cannot": "cannot_run_in_the_page", "note": "note_in_the_page"}
"""Keys in a cell's metadata for sentences that the page shows: why the cell cannot run there, and
what differs there."""
OWN_GRAPH = '<div id="own-graph"></div>'
"""The place of the form."""


def look_for_the_runtime(app: Sphinx, config: Config) -> None:
    """Note how much the engine loads: with another number all pages are written again."""
    folder = Path(app.srcdir, RUNTIME)
    is_whole = all((folder / name).exists() for name in (*NEEDED, BYTES))
    config.course_bytes = int((folder / BYTES).read_text()) if is_whole else 0
    if not is_whole:
        LOGGER.info("%s is not complete: no page can run its cells (make runtime).", RUNTIME)


def code_cells(app: Sphinx, page: str) -> dict[int, dict[str, str]]:
    """Return the code cells of a page by their numbers; only notebooks have some."""
    path = Path(app.env.doc2path(page))
    if not app.config.course_bytes or path.suffix != ".ipynb":
        return {}
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return {
        number: {"id": f"code-{cell['id']}", "parts": parts(code)}
        | {name: cell["metadata"][key] for name, key in SAID.items() if key in cell["metadata"]}
        for number, cell in enumerate(cells)
        if cell["cell_type"] == "code" and (code := "".join(cell["source"])) is not None
    }


def parts(code: str) -> list[dict[str, Any]]:
    """Split a cell into parts that run one without another, with the names that each gives.

    A cell that imports, and otherwise calls alone, is split into its statements, because what is
    imported may take seconds to load; any other cell is one part.
    """
    body = ast.parse(code).body
    calls = [_root(each.value) if isinstance(each, ast.Expr) else set() for each in body]
    given = [_imported(each) or call for each, call in zip(body, calls, strict=True)]
    if not all(given) or calls[:1] != [set()]:
        return [{"code": code, "gives": sorted(gives(code))}]
    lines = code.split("\n")
    starts = [0, *(each.lineno - 1 for each in body[1:]), len(lines)]
    return [
        {"code": "\n".join(lines[start:end]), "gives": sorted(names)}
        for names, start, end in zip(given, starts, starts[1:], strict=False)
    ]


def _imported(code: ast.AST) -> set[str]:
    nodes = ast.walk(code)
    return {(n.asname or n.name).split(".")[0] for n in nodes if isinstance(n, ast.alias)}


def gives(code: str) -> set[str]:
    """Return the names that a cell binds or whose values it changes, and some that it may change.

    What a cell imports it does not change later on, and a source of random numbers is another one
    after each use.
    """
    tree = ast.parse(code)
    nodes = list(ast.walk(tree))
    changed = {"rng"} & {node.id for node in nodes if isinstance(node, ast.Name)}
    for node in nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                changed.add(name)
            case ast.Name(id=name, ctx=ast.Store()):
                changed.add(name)
            case ast.Attribute(ctx=ast.Store()) | ast.Subscript(ctx=ast.Store()):
                changed |= _root(node)
            case ast.Expr(value=ast.Call(func=ast.Attribute() as method)):
                changed |= _root(method) - MODULES
    return _imported(tree) | changed


def _root(node: ast.AST) -> set[str]:
    """Return the name before all dots and brackets, if there is one."""
    while isinstance(node, ast.Attribute | ast.Subscript | ast.Call):
        node = node.func if isinstance(node, ast.Call) else node.value
    return {node.id} if isinstance(node, ast.Name) else set()


def name_the_cells(app: Sphinx, doctree: nodes.document, page: str) -> None:
    """Give each code cell on the page the id under which its code is found."""
    if cells := code_cells(app, page):
        for container in doctree.findall(nodes.container):
            if container.get("nb_element") == "cell_code":
                container["ids"].append(cells[container["cell_index"]]["id"])


def add_to_the_page(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Add the script and its style to a page with code, and write the code beside."""
    cells = list(code_cells(app, page).values()) if doctree else []
    if not cells:
        return
    name = f"cells/{Path(page).name}.json"
    target = Path(app.outdir, "python", name)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps({"cells": cells}), encoding="utf-8")
    context["metatags"] += TEMPLATES.get_template("run.html").render(
        folder=context["pathto"]("python", 1),
        cells=name,
        megabytes=round(app.config.course_bytes / 1e6),
        **{
            said: json.dumps({cell["id"]: cell[said] for cell in cells if said in cell})
            for said in SAID
        },
    )


def fill_in_the_form(
    app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: nodes.document | None
) -> None:
    """Put the form into its place, or the command alone where there is no runtime."""
    if OWN_GRAPH not in context.get("body", ""):
        return
    known = {"bytes": app.config.course_bytes, "folder": context["pathto"]("python", 1)}
    form = TEMPLATES.get_template("own_graph.html").render(known)
    context["body"] = context["body"].replace(OWN_GRAPH, form)
    if app.config.course_bytes:
        context["metatags"] += f'\n<link rel="stylesheet" href="{known["folder"]}/own.css" />'


def copy(app: Sphinx, exception: Exception | None) -> None:
    """Put scripts and runtime into the site; without the runtime take away what was there."""
    target = Path(app.outdir, "python")
    if exception:
        return
    if not app.config.course_bytes:
        shutil.rmtree(target, ignore_errors=True)
        return
    found = [path.name for path in SOURCES.glob("*.py")]
    found += [f"{TABLES}/{path.name}" for path in (SOURCES.parent / TABLES).glob("*.csv")]
    put_in_place(SOURCES.parent / TABLES, target / TABLES)
    (target / "files.json").write_text(json.dumps(sorted(found)), encoding="utf-8")
    for path in (*SOURCES.iterdir(), *(Path(app.srcdir, RUNTIME, name) for name in NEEDED)):
        if path.is_file():
            shutil.copyfile(path, target / path.name)
        elif path.name in NEEDED:
            put_in_place(path, target / path.name)
    # Of what is compiled, as it stands among the wheels, Pyodide's own is of no use.
    for path in (target / "wheels").iterdir():
        (target / "pyodide" / path.name).unlink(missing_ok=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the above to the build."""
    app.add_config_value("course_bytes", 0, "html")
    app.connect("config-inited", look_for_the_runtime)
    app.connect("doctree-resolved", name_the_cells)
    app.connect("html-page-context", add_to_the_page)
    app.connect("html-page-context", fill_in_the_form)
    app.connect("build-finished", copy)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
