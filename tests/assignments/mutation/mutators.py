"""The mutants of one solution cell: its text with one small change.

Changes are made in the tree and put back as text at their place, so that a diff shows the change
alone. Text in raised errors is left alone: no case may depend on it. Each change is an instance
of a slip that a student might make.
"""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator
from dataclasses import dataclass

OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Div,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.MatMult: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
}
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
    ast.FunctionDef,
    ast.ClassDef,
    ast.Import,
    ast.ImportFrom,
    ast.Pass,
    ast.Global,
    ast.Nonlocal,
)
"""Statements that are not removed: without them Python itself would complain."""


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


def changed(source: str) -> Iterator[tuple[str, int]]:
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
    if isinstance(node, ast.AugAssign) and type(node.op) in OPERATORS:
        yield ast.AugAssign(node.target, OPERATORS[type(node.op)](), node.value)
    if isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple):
        parts = node.value.elts
        for n in range(len(parts) - 1):
            swapped = [*parts[:n], parts[n + 1], parts[n], *parts[n + 2 :]]
            yield ast.Return(ast.Tuple(swapped, ast.Load()))


def _of_operator(node: ast.expr) -> Iterator[ast.AST]:
    if isinstance(node, ast.BinOp):
        if type(node.op) in OPERATORS:
            yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
        if isinstance(node.op, ast.MatMult):
            yield ast.BinOp(node.right, node.op, node.left)
    elif isinstance(node, ast.BoolOp):
        opposite = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield ast.BoolOp(opposite, node.values)
    elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.UAdd):
        yield node.operand
    elif isinstance(node, ast.Compare):
        for n, compared in enumerate(map(type, node.ops)):
            for instead in COMPARISONS[compared]:
                ops = [*node.ops[:n], instead(), *node.ops[n + 1 :]]
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


def function_at(tree: ast.Module, line: int) -> ast.FunctionDef | None:
    """Return the function at the top level of a cell that a line stands in."""
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    return next((f for f in functions if f.lineno <= line <= (f.end_lineno or 0)), None)
