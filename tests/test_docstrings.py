"""What a reader of `lib` may count on: shapes, units, errors and sources are in the docstrings.

Presence of docstrings and of types is ruff's and mypy's business (rules D1 and ANN, strict);
here it is what they say.
"""

import ast
import functools
import re
from collections.abc import Callable, Iterator
from pathlib import Path

LIB = Path(__file__).resolve().parents[1] / "lib" / "robust_slam"
MODULES = sorted(p for p in LIB.rglob("*.py") if not p.name.startswith("_"))
RECORDS = {"errors", "graph_file", "group", "palette", "result"}
TOOLS = {"cli", "drawing", "lines", "progress", "reading", "writing"}
WITHOUT_LITERATURE = RECORDS | TOOLS
"""Modules that hold no method: names, records, files, commands and what pages look like."""
ARRAYS = {"Array", "ArrayLike", "Mask", "Indices"}


def public(body: list[ast.stmt], prefix: str = "") -> Iterator[tuple[str, ast.AST, str]]:
    """Yield name, node and docstring of each public class, function and method."""
    for node in body:
        if not isinstance(node, ast.ClassDef | ast.FunctionDef) or node.name.startswith("_"):
            continue
        text = ast.get_docstring(node) or ""
        yield prefix + node.name, node, text
        if isinstance(node, ast.ClassDef):
            for name, method, told in public(node.body, f"{prefix}{node.name}."):
                yield name, method, f"{told}\n{text}"


@functools.cache
def functions(path: Path) -> list[tuple[str, ast.FunctionDef, str]]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    module = ast.get_docstring(tree) or ""
    return [
        (name, node, f"{text}\n{module}")
        for name, node, text in public(tree.body)
        if isinstance(node, ast.FunctionDef)
    ]


def annotations(node: ast.FunctionDef) -> set[str]:
    given = [a.annotation for a in [*node.args.args, *node.args.kwonlyargs] if a.annotation]
    names = [n for g in [*given, node.returns] if g is not None for n in ast.walk(g)]
    return {n.id for n in names if isinstance(n, ast.Name)}


def raises(node: ast.FunctionDef) -> bool:
    return any(isinstance(inner, ast.Raise) and inner.exc for inner in ast.walk(node))


def lacking(lacks: Callable[[Path, ast.FunctionDef, str], object]) -> list[str]:
    """The functions of all modules whose docstrings lack something."""
    found = ((path, *each) for path in MODULES for each in functions(path))
    return [f"{path.stem}: {name}" for path, name, node, text in found if lacks(path, node, text)]


def test_arrays_have_their_shape_in_the_docstring():
    shape = re.compile(r"``\([^)]*\)``|any shape|that shape|scalar|one (number|value|weight)")
    assert not lacking(lambda _, node, text: annotations(node) & ARRAYS and not shape.search(text))


def test_what_a_function_raises_is_in_its_docstring():
    told = re.compile(r"Raises(:|\n---)")
    assert not lacking(lambda _, node, text: raises(node) and not told.search(text))


def test_every_function_has_a_source_in_its_docstring_or_its_modules():
    source = re.compile(r"Source: |et al\. \d{4}|[A-Z]\w+ (and [A-Z]\w+ )?\d{4}|derived here")
    named = {path for path in MODULES if path.stem not in WITHOUT_LITERATURE}
    assert not lacking(lambda path, _, text: path in named and not source.search(text))


def test_the_package_says_where_everything_is():
    text = ast.get_docstring(ast.parse((LIB / "__init__.py").read_text(encoding="utf-8"))) or ""
    named = set(re.findall(r"``(\w+)``", text))
    modules = {p.stem for p in LIB.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    assert named == {name for name in modules - {"errors"} if not name.startswith("_")}
