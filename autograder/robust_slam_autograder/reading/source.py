"""Reads the text of code cells: magics, the names that a cell defines, what of it runs.

The instructor's cells are read by the grader; the student's only behind the wall,
because reading hostile text takes time and memory too.
"""

import __future__

import ast
import contextlib
import functools
import re
import types
from collections.abc import Iterable, Sequence

CELL_MAGICS_THAT_RUN = frozenset({"time", "timeit", "capture", "prun"})
_CELL_MAGIC = re.compile(r"\s*%%(\w+)[^\n]*\n?")
_MAKES = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Import | ast.ImportFrom
_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)


@functools.lru_cache(512)
def plain_python(source: str) -> str:
    """Rewrite IPython's magics: ``%%time`` and its like leave their cell, others do nothing."""
    source = _without_cell_magic(source)
    try:
        _parsed(source)
    except SyntaxError:
        from IPython.core.inputtransformer2 import TransformerManager

        with contextlib.suppress(Exception):  # text that is no Python at all stays as it is
            return str(TransformerManager().transform_cell(source))
    except _UNREADABLE:
        pass
    return source


def _parsed(source: str) -> ast.Module:
    """Parse; once more where Python 3.11 miscounts the depth, which is no fault of the text."""
    try:
        return ast.parse(source)
    except SystemError:  # python/cpython#106905
        return ast.parse(source)


def _without_cell_magic(source: str) -> str:
    match = _CELL_MAGIC.match(source)
    if not match:
        return source
    # A blank line in the magic's place keeps the lines' numbers.
    return "\n" + source[match.end() :] if match.group(1) in CELL_MAGICS_THAT_RUN else ""


@functools.lru_cache(256)
def compiled(source: str, label: str) -> types.CodeType:
    """Compile an instructor's cell; most are the same in the visible and in the hidden pass.

    Raises:
        SyntaxError: it is no Python.
        ValueError: it is no text that Python reads.
    """
    # `optimize=0`: under `python -O` asserts would be left out, and all tests pass.
    read = functools.partial(compile, filename=label, mode="exec", dont_inherit=True, optimize=0)
    try:
        return read(_without_cell_magic(source))
    except SyntaxError:
        return read(plain_python(source))


def defined_names(source: str) -> list[str]:
    """Return the names of a cell's top level: functions, classes and assigned variables."""
    body = tree_of(source).body
    own = [node for node in body if not isinstance(node, ast.Import | ast.ImportFrom)]
    return [name for node in own for name in _bound_by(node)]


def tree_of(source: str) -> ast.Module:
    """Return the tree of a cell, magics aside; an empty one where it is no Python."""
    try:
        return _parsed(plain_python(source))
    except _UNREADABLE:
        return ast.Module([], [])


def imports(source: str) -> str:
    """Return the import statements of a cell's top level."""
    body = tree_of(source).body
    return "\n".join(ast.unparse(n) for n in body if isinstance(n, ast.Import | ast.ImportFrom))


@functools.lru_cache(512)
def imported_modules(source: str) -> tuple[str, ...]:
    """Return the modules that a cell imports, also within its functions.

    Of ``from a import b`` both a and, in case it is one, a.b.
    """
    found: list[str] = []
    for node in ast.walk(tree_of(source)):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(dict.fromkeys(found))


def defines(source: str, names: Sequence[str]) -> bool:
    """Return whether a cell seems to define one of these names, by the look of its lines."""
    words = "|".join(map(re.escape, names))
    pattern = rf"(?:(?:async\s+)?def|class)\s+(?:{words})\b|(?:{words})\s*(?::[^=\n]*)?=(?!=)"
    return bool(names) and re.search(rf"^(?:{pattern})", source, re.MULTILINE) is not None


def used_names(*statements: ast.stmt) -> set[str]:
    """Return the names that code reads from its module (and, on top, those of attributes)."""
    flags, found = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT, set[str]()
    for one in statements:
        with contextlib.suppress(*_UNREADABLE):
            module = ast.Module([one], [])
            found |= names_read(compile(module, "<names>", "exec", flags, dont_inherit=True))
    return found


def names_read(*codes: types.CodeType) -> set[str]:
    """Return the names that compiled code reads from its module, and those of attributes."""
    found = list(codes)
    names: set[str] = set()
    while found:
        code = found.pop()
        names.update(code.co_names)
        found += [part for part in code.co_consts if isinstance(part, types.CodeType)]
    return names


def reached(names: Sequence[str], cells: Iterable[ast.Module]) -> dict[str, list[str]]:
    """Say by name which of the names what it stands for reads, and what that reads, and so on."""
    read: dict[str, set[str]] = {}
    for node in (node for cell in cells for node in cell.body):
        words = {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
        words &= used_names(node)  # without what is an attribute or a local alone
        for name in _bound_by(node):
            read[name] = read.get(name, set()) | words
    found = {}
    for name in names:
        waiting, seen = [name], {name}
        while waiting:
            new = read.get(waiting.pop(), set()) - seen
            seen |= new
            waiting += new
        found[name] = [other for other in names if other in seen - {name}]
    return found


def helpers(cells: Sequence[ast.Module], used: set[str]) -> set[ast.stmt]:
    """Pick the statements of a student's own cells that a solution may need.

    Functions and classes stay, every statement that makes or changes a variable that the
    solutions, or what they use, read, and imports of a name that occurs in any of these. What
    else stands there (a plot and its import, a slow experiment, an error) is no part of the
    answer, and costs no marks. ``used`` are the names that the solution cells read.
    """
    statements = [node for cell in cells for node in cell.body]
    variables = {name for node in statements for name in _changed_by(node, set())}
    variables -= {name for node in statements for name in _defined_by(node)}
    waiting = {node: _changed_by(node, variables) for node in statements}
    kept: set[ast.stmt] = set()
    while found := {node for node, names in waiting.items() if names & used}:
        kept |= found
        waiting = {node: names for node, names in waiting.items() if node not in found}
        used = used | used_names(*found)
    imported = {node for node in statements if isinstance(node, ast.Import | ast.ImportFrom)}
    kept = (kept - imported) | {node for node in statements if _defined_by(node)} - imported
    words = used | {part.id for n in kept for part in ast.walk(n) if isinstance(part, ast.Name)}
    # It may bind more than can be seen, or say how the rest is read.
    known = {*words, "*", *__future__.all_feature_names}
    return kept | {node for node in imported if not known.isdisjoint(_bound_by(node))}


def _defined_by(node: ast.stmt) -> list[str]:
    """Names of imports, functions and classes; to bind them takes no time."""
    return [] if isinstance(node, ast.Assign | ast.AnnAssign) else _bound_by(node)


def _changed_by(node: ast.AST, variables: set[str]) -> set[str]:
    """Names that a statement binds or changes, be it an item or an attribute of theirs.

    A method may change a variable; of a module (``plt.plot``) it changes nothing here.
    """
    found: set[str] = set()
    waiting = [node]  # and no recursion: a long sum is as deep as it is long
    while waiting:
        match node := waiting.pop():
            case ast.stmt() if isinstance(node, _MAKES):
                found.update(_bound_by(node))
                continue
            case ast.Lambda():
                continue
            case ast.comprehension():
                waiting += [node.iter, *node.ifs]  # its own variable lives in it alone
                continue
            case ast.Name() | ast.Attribute() | ast.Subscript() if not isinstance(
                node.ctx, ast.Load
            ):
                found |= _root(node)
            case ast.Call(func=ast.Attribute()):
                found |= _root(node.func) & variables
        waiting += ast.iter_child_nodes(node)
    return found


def _root(node: ast.AST) -> set[str]:
    """The name that ``name.attribute[item]`` begins with; none of a list of names."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return {node.id} if isinstance(node, ast.Name) else set()


def _bound_by(node: ast.stmt) -> list[str]:
    """Names that a statement binds; none where it does more than to bind names."""
    names: list[str] = []
    waiting = [node]  # and no recursion: each elif is within the one before
    while waiting:
        match node := waiting.pop():
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                names.append(node.name)
            case ast.Import() | ast.ImportFrom():
                names += [(alias.asname or alias.name).split(".")[0] for alias in node.names]
            case ast.Assign() | ast.AnnAssign():
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                used = (n for one in targets for n in ast.walk(one) if isinstance(n, ast.Name))
                names += [name.id for name in used if isinstance(name.ctx, ast.Store)]
            case ast.If() | ast.Try():
                # Such as: try one import, except take another.
                handled = [part for one in getattr(node, "handlers", ()) for part in one.body]
                parts = [*ast.iter_child_nodes(node), *handled]
                does = [part for part in parts if isinstance(part, ast.stmt)]
                waiting += [part for part in reversed(does) if not isinstance(part, ast.Pass)]
            case _:
                return []
    return names
