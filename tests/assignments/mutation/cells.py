"""The mutants of a solution cell between the marks of its solution, and how they are told.

Each is the cell's text with one small change, a slip that a student might make. It is made in
the tree and put back as text at its place, so that a diff shows the change alone. Text in raised
errors is left alone: no case may depend on it.
"""

import ast
import difflib
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

BEGIN, END = "### BEGIN SOLUTION", "### END SOLUTION"
_INSTEAD = (
    *("Add Sub", "Sub Add", "Mult Div", "Div Mult", "FloorDiv Div", "Mod Mult", "Pow Mult"),
    *("MatMult Mult", "BitAnd BitOr", "BitOr BitAnd", "And Or", "Or And", "Eq NotEq", "NotEq Eq"),
    *("Lt LtE GtE", "LtE Lt Gt", "Gt GtE LtE", "GtE Gt Lt"),
    *("In NotIn", "NotIn In", "Is IsNot", "IsNot Is"),
)
INSTEAD: dict[str, list[Any]] = {
    one: [getattr(ast, other) for other in others] for one, *others in map(str.split, _INSTEAD)
}
"""By an operator's name, what may stand in its place."""
PAIRS = (
    *("min max", "any all", "sum mean", "sin cos", "argmin argmax", "minimum maximum"),
    *("floor ceil", "zeros ones", "log log1p", "exp expm1", "sqrt square", "vstack hstack"),
    "logical_and logical_or",
)
"""Functions that are confused."""
NAMES = {"inf": "nan"} | {
    one: other for pair in PAIRS for one, other in itertools.permutations(pair.split())
}
SYMMETRIC = {"clip", "hypot", "isclose", "allclose", "max", "maximum", "min", "minimum"}
"""Functions whose arguments may be swapped; so may those of ``logical_and`` and its like."""
ZEROS = {"np.zeros", "np.zeros_like"}
"""What gives the same with a minus before it."""
STRICT = "strict"
"""zip's argument, which only refuses what no one hands in."""
FAR = 1000.0
"""One more or one less is no change to a number of this size that is no count."""
KEPT = (
    *(ast.FunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom),
    *(ast.Pass, ast.Global, ast.Nonlocal),
)
"""Statements that are not removed: without them Python itself would complain."""


@dataclass(frozen=True)
class Mutant:
    """One change to one solution cell."""

    exercise: str
    """Grade id of the cell."""
    function: str
    """The function at the cell's top level that was changed."""
    source: str
    """The text of the whole cell."""
    line: str
    """The lines that were changed, as they were, without their indentation."""
    becomes: str
    """The same lines as they are."""


def mutants(exercise: str, source: str) -> list[Mutant]:
    """Return all mutants of a cell, in the order of its text.

    Raises:
        ValueError: no solution region is marked in the cell.
    """
    regions = list(_regions(source))
    if not regions:
        raise ValueError(f"{exercise}: no line reads {BEGIN}")
    tree, found = ast.parse(source), []
    for text, line in _changed(source):
        if any(first < line < last for first, last in regions):
            function = _function_at(tree, line)
            told = _changed_lines(source, text)
            found.append(Mutant(exercise, function.name if function else "", text, *told))
    return found


def _regions(source: str) -> Iterator[tuple[int, int]]:
    """First and last line, both marks, of each solution region."""
    first = 0
    for number, line in enumerate(source.split("\n"), start=1):
        if BEGIN in line:
            first = number
        elif END in line:
            yield first, number


def _changed_lines(before: str, after: str) -> tuple[str, str]:
    old, new = before.split("\n"), after.split("\n")
    changes = difflib.SequenceMatcher(None, old, new, autojunk=False).get_opcodes()
    spans = [change for change in changes if change[0] != "equal"]
    line = [text.strip() for text in old[spans[0][1] : spans[-1][2]]]
    becomes = [text.strip() for text in new[spans[0][3] : spans[-1][4]]]
    return "\n".join(line), "\n".join(becomes)


@dataclass(frozen=True)
class Site:
    """A node of a program's tree that may be changed, and where its parent holds it."""

    parent: ast.AST
    field: str
    index: int | None
    node: ast.expr | ast.stmt

    def put(self, node: ast.AST) -> None:
        """Put another node in its place."""
        if self.index is None:
            setattr(self.parent, self.field, node)
        else:
            getattr(self.parent, self.field)[self.index] = node


def _changed(source: str) -> Iterator[tuple[str, int]]:
    """Yield a cell with one change and the line where it begins, no two texts alike."""
    tree = ast.parse(source)
    seen = {source}
    for site in _sites(tree):
        line = site.node.lineno
        for variant in _variants(site):
            text = _with(source, tree, site, variant)
            if text is not None and text not in seen:
                seen.add(text)
                yield text, line


def _sites(parent: ast.AST) -> Iterator[Site]:
    for field, value in ast.iter_fields(parent):
        parts = list(enumerate(value)) if isinstance(value, list) else [(None, value)]
        for index, node in parts:
            if isinstance(node, ast.expr | ast.stmt):
                yield Site(parent, field, index, node)
            if isinstance(node, ast.AST) and not isinstance(node, ast.Raise | ast.JoinedStr):
                yield from _sites(node)


def _variants(site: Site) -> Iterator[ast.AST]:
    """What may stand in a node's place."""
    node = site.node
    if isinstance(node, ast.stmt):
        yield from _of_statement(node)
        return
    is_strict = isinstance(site.parent, ast.keyword) and site.parent.arg == STRICT
    if is_strict or isinstance(getattr(node, "ctx", None), ast.Store | ast.Del):
        return
    yield from _of_operator(node)
    yield from _of_constant(node)
    yield from _of_name(node)
    if isinstance(node, ast.Call):
        yield from _of_call(node)
    yield from _of_place(site)


def _of_statement(node: ast.stmt) -> Iterator[ast.AST]:
    is_docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    if not isinstance(node, KEPT) and not is_docstring:
        yield ast.Pass()
    if isinstance(node, ast.AugAssign):
        yield from (ast.AugAssign(node.target, op, node.value) for op in _instead(node.op))
    if isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple):
        parts = node.value.elts
        for n in range(len(parts) - 1):
            swapped = [*parts[:n], parts[n + 1], parts[n], *parts[n + 2 :]]
            yield ast.Return(ast.Tuple(swapped, ast.Load()))


def _instead(op: ast.AST) -> list[Any]:
    return [other() for other in INSTEAD.get(type(op).__name__, [])]


def _of_operator(node: ast.expr) -> Iterator[ast.AST]:
    if isinstance(node, ast.BinOp):
        yield from (ast.BinOp(node.left, op, node.right) for op in _instead(node.op))
        if isinstance(node.op, ast.MatMult):
            yield ast.BinOp(node.right, node.op, node.left)
    elif isinstance(node, ast.BoolOp):
        yield from (ast.BoolOp(op, node.values) for op in _instead(node.op))
    elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.UAdd):
        yield node.operand
    elif isinstance(node, ast.Compare):
        for n, compared in enumerate(node.ops):
            for op in _instead(compared):
                ops = [*node.ops[:n], op, *node.ops[n + 1 :]]
                yield ast.Compare(node.left, ops, node.comparators)


def _of_constant(node: ast.expr) -> Iterator[ast.AST]:
    value = node.value if isinstance(node, ast.Constant) else None
    if isinstance(value, bool):
        yield ast.Constant(not value)
    elif isinstance(value, int | float):
        is_far = isinstance(value, float) and abs(value) >= FAR
        others = (value * 2, value / 2) if is_far else (value + 1, value - 1, value * 2)
        yield from map(ast.Constant, others)


def _of_name(node: ast.expr) -> Iterator[ast.AST]:
    if isinstance(node, ast.Name) and node.id in NAMES:
        yield ast.Name(NAMES[node.id], node.ctx)
    elif isinstance(node, ast.Attribute):
        if node.attr in NAMES:
            yield ast.Attribute(node.value, NAMES[node.attr], node.ctx)
        elif node.attr == "T":
            yield node.value


def _of_call(node: ast.Call) -> Iterator[ast.AST]:
    args, keywords = node.args, node.keywords
    for n, keyword in enumerate(keywords):
        if keyword.arg != STRICT:
            yield ast.Call(node.func, args, keywords[:n] + keywords[n + 1 :])
    if any(isinstance(arg, ast.Starred) for arg in args):
        return
    name = ast.unparse(node.func).rpartition(".")[2]
    if len(args) == 1 and name != "range" and not isinstance(args[0], ast.GeneratorExp):
        yield args[0]  # sqrt(x) becomes x
    elif len(args) >= 2 and name not in SYMMETRIC and not name.startswith("logical_"):
        yield ast.Call(node.func, [args[1], args[0], *args[2:]], keywords)
    elif not args and not keywords and isinstance(node.func, ast.Attribute):
        yield node.func.value  # x.copy() becomes x
    if name in ("range", "arange"):
        for n, arg in enumerate(args):
            for other in _off_by_one(arg):
                yield ast.Call(node.func, [*args[:n], other, *args[n + 1 :]], keywords)


def _of_place(site: Site) -> Iterator[ast.AST]:
    """Changes that depend on where an expression stands."""
    parent, node = site.parent, site.node
    if not isinstance(node, ast.expr):
        return
    is_test = isinstance(parent, ast.If | ast.While | ast.IfExp) and site.field == "test"
    is_told_already = isinstance(node, ast.Constant | ast.UnaryOp) or (
        isinstance(node, ast.Compare) and len(node.ops) == 1  # the opposite comparison
    )
    if (is_test or site.field == "ifs") and not is_told_already:
        yield ast.UnaryOp(ast.Not(), node)
    # Of what is returned, and of each part of a tuple that is; and of what a name stands for.
    is_returned = isinstance(parent, ast.Return) or site.field == "elts"
    numbers = (ast.BinOp, ast.Call, ast.Name, ast.Subscript)
    is_computed = isinstance(parent, ast.Assign) and isinstance(node, numbers[:2])
    is_zero = isinstance(node, ast.Call) and ast.unparse(node.func) in ZEROS
    if not is_zero and (is_computed or (is_returned and isinstance(node, numbers))):
        yield ast.UnaryOp(ast.USub(), node)
    if isinstance(node, ast.Slice):
        yield from _of_slice(node)
    elif isinstance(parent, ast.Subscript) and site.field == "slice":
        yield from _off_by_one(node)


def _of_slice(node: ast.Slice) -> Iterator[ast.expr]:
    lower, upper = node.lower, node.upper
    for other in [ast.Constant(1)] if lower is None else _off_by_one(lower):
        yield ast.Slice(other, upper, node.step)
    for other in [ast.Constant(-1)] if upper is None else _off_by_one(upper):
        yield ast.Slice(lower, other, node.step)


def _off_by_one(node: ast.expr) -> Iterator[ast.expr]:
    """A place one further and one before; constants are changed as such."""
    if isinstance(node, ast.Name | ast.BinOp | ast.Call):
        yield ast.BinOp(node, ast.Add(), ast.Constant(1))
        yield ast.BinOp(node, ast.Sub(), ast.Constant(1))


def _with(source: str, tree: ast.Module, site: Site, variant: ast.AST) -> str | None:
    """The cell with the variant in the site's place; None where it cannot be written there."""
    text = ast.unparse(ast.fix_missing_locations(variant))
    site.put(variant)
    try:
        meant = ast.unparse(tree)
    finally:
        site.put(site.node)
    for written in (text, f"({text})"):
        changed = _replaced(source, site.node, written)
        try:
            # As text, for the tree of -1 is not the one that was put together here.
            if ast.unparse(ast.parse(changed)) == meant:
                return changed
        except SyntaxError:
            continue
    return None


def _replaced(source: str, node: ast.expr | ast.stmt, text: str) -> str:
    lines = source.encode().split(b"\n")
    last = (node.end_lineno or node.lineno) - 1
    before = b"\n".join([*lines[: node.lineno - 1], lines[node.lineno - 1][: node.col_offset]])
    after = b"\n".join([lines[last][node.end_col_offset :], *lines[last + 1 :]])
    return (before + text.encode() + after).decode()


def _function_at(tree: ast.Module, line: int) -> ast.FunctionDef | None:
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    return next((f for f in functions if f.lineno <= line <= (f.end_lineno or 0)), None)
