"""The mutants of one solution cell: its text with one small change.

Changes are made in the tree and put back as text at their place, so that a diff shows the change
alone. Text in raised errors is left alone: no case may depend on it. Each change is an instance
of a slip that a student might make, and ``slips`` has the sentence for it.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from robust_slam_autograder.misconceptions.slips import Change, Site, Slip, called

OPERATORS: Mapping[type[ast.operator], tuple[type[ast.operator], str]] = {
    ast.Add: (ast.Sub, "sign"),
    ast.Sub: (ast.Add, "sign"),
    ast.Mult: (ast.Div, "quotient"),
    ast.Div: (ast.Mult, "quotient"),
    ast.FloorDiv: (ast.Div, "quotient"),
    ast.Mod: (ast.Mult, "quotient"),
    ast.Pow: (ast.Mult, "twice for square"),
    ast.MatMult: (ast.Mult, "elementwise"),
    ast.BitAnd: (ast.BitOr, "logic"),
    ast.BitOr: (ast.BitAnd, "logic"),
}
"""What may stand in an operator's place, and which slip that is."""
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
_NEAR = ({ast.Lt, ast.LtE}, {ast.Gt, ast.GtE})
"""Comparisons that differ at equality alone."""
PAIRS = (
    ("min", "max", "min max"),
    ("any", "all", "any all"),
    ("sum", "mean", "sum mean"),
    ("sin", "cos", "sin cos"),
    ("argmin", "argmax", "min max"),
    ("minimum", "maximum", "min max"),
    ("floor", "ceil", "floor ceil"),
    ("zeros", "ones", "zeros ones"),
    ("log", "log1p", "log log1p"),
    ("exp", "expm1", "exp expm1"),
    ("sqrt", "square", "sqrt square"),
    ("vstack", "hstack", "vstack hstack"),
    ("logical_and", "logical_or", "logic"),
)
"""Functions that are confused, and which slip that is."""
NAMES = {"inf": ("nan", "inf nan")} | {
    name: (other, kind) for *pair, kind in PAIRS for name, other in (pair, reversed(pair))
}
_LOST = {
    "square": "square lost",
    "sqrt": "root lost",
    "abs": "size lost",
    "log": "logarithm lost",
    "log1p": "logarithm lost",
    "sum": "sum lost",
    "inv": "inverse lost",
    "pinv": "inverse lost",
    "transpose": "transpose lost",
    "copy": "copied",
}
"""Slips where a function is left out."""
_OPTIONS = {"axis": "axis", "keepdims": "axis", "dtype": "integers"}
"""Slips where an argument is left out that was handed in by name."""
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
class Mutant:
    """A solution cell with one change."""

    source: str
    """The text of the whole cell."""
    line: int
    """Where what was changed begins."""
    slip: Slip
    """What a student would have done wrong who had written it."""


Variants = Callable[[Site], Iterator[Change]]
"""What may stand in the place of a node."""


def changed(source: str, variants: Variants) -> Iterator[Mutant]:
    """Yield a cell with one change, in the order of its text, no two texts alike."""
    tree = ast.parse(source)
    seen = {source}
    for site in _sites(tree):
        line = site.node.lineno
        for change in variants(site):
            text = _with(source, tree, site, change.variant)
            if text is not None and text not in seen:
                seen.add(text)
                slip = change.slip(site, _arguments(function_at(tree, line)))
                yield Mutant(text, line, slip)


def _arguments(function: ast.FunctionDef | None) -> frozenset[str]:
    parts = function.args if function else None
    return frozenset(one.arg for one in [*parts.args, *parts.kwonlyargs]) if parts else frozenset()


def _sites(parent: ast.AST) -> Iterator[Site]:
    for field, value in ast.iter_fields(parent):
        parts = list(enumerate(value)) if isinstance(value, list) else [(None, value)]
        for index, node in parts:
            if isinstance(node, ast.expr | ast.stmt):
                yield Site(parent, field, index, node)
            if isinstance(node, ast.AST) and not isinstance(node, ast.Raise | ast.JoinedStr):
                yield from _sites(node)


def variants(site: Site) -> Iterator[Change]:
    """What may stand in a node's place."""
    node = site.node
    if isinstance(node, ast.stmt):
        yield from _of_statement(node)
        return
    is_strict = isinstance(site.parent, ast.keyword) and site.parent.arg == STRICT
    if is_strict or isinstance(getattr(node, "ctx", None), ast.Store | ast.Del):
        return
    yield from _of_operator(node)
    yield from _of_constant(site)
    yield from _of_name(node)
    if isinstance(node, ast.Call):
        yield from _of_call(node)
    yield from _of_place(site)


def _of_statement(node: ast.stmt) -> Iterator[Change]:
    is_docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    if not isinstance(node, KEPT) and not is_docstring:
        lost = "not added" if isinstance(node, ast.AugAssign) else "step lost"
        yield Change("case lost" if isinstance(node, ast.If) else lost, ast.Pass())
    if isinstance(node, ast.AugAssign) and type(node.op) in OPERATORS:
        other, kind = OPERATORS[type(node.op)]
        yield Change(kind, ast.AugAssign(node.target, other(), node.value))
    if isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple):
        parts = node.value.elts
        for n in range(len(parts) - 1):
            swapped = [*parts[:n], parts[n + 1], parts[n], *parts[n + 2 :]]
            yield Change("parts swapped", ast.Return(ast.Tuple(swapped, ast.Load())))


def _of_operator(node: ast.expr) -> Iterator[Change]:
    if isinstance(node, ast.BinOp):
        op = type(node.op)
        if op in OPERATORS:
            other, kind = OPERATORS[op]
            about = node.left if op is ast.Pow else node
            yield Change(kind, ast.BinOp(node.left, other(), node.right), about)
        if op is ast.MatMult:
            yield Change("order", ast.BinOp(node.right, node.op, node.left))
    elif isinstance(node, ast.BoolOp):
        opposite = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield Change("logic", ast.BoolOp(opposite, node.values))
    elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.UAdd):
        is_truth = isinstance(node.op, ast.Not | ast.Invert)
        yield Change("condition" if is_truth else "negated", node.operand)
    elif isinstance(node, ast.Compare):
        for n, compared in enumerate(map(type, node.ops)):
            for instead in COMPARISONS[compared]:
                kind = "boundary" if {compared, instead} in _NEAR else "side"
                ops = [*node.ops[:n], instead(), *node.ops[n + 1 :]]
                yield Change(kind, ast.Compare(node.left, ops, node.comparators))


def _of_constant(site: Site) -> Iterator[Change]:
    node, parent = site.node, site.parent
    value = node.value if isinstance(node, ast.Constant) else None
    if isinstance(value, bool):
        yield Change("truth value", ast.Constant(not value))
    elif isinstance(value, int | float):
        is_far = isinstance(value, float) and abs(value) >= FAR
        is_power = isinstance(parent, ast.BinOp) and isinstance(parent.op, ast.Pow)
        is_axis = isinstance(parent, ast.keyword) and parent.arg == "axis"
        kind = "exponent" if is_power and site.field == "right" else "constant"
        for other in (value * 2, value / 2) if is_far else (value + 1, value - 1, value * 2):
            yield Change("axis" if is_axis else kind, ast.Constant(other))


def _of_name(node: ast.expr) -> Iterator[Change]:
    if isinstance(node, ast.Name) and node.id in NAMES:
        other, kind = NAMES[node.id]
        yield Change(kind, ast.Name(other, node.ctx))
    elif isinstance(node, ast.Attribute):
        if node.attr in NAMES:
            other, kind = NAMES[node.attr]
            yield Change(kind, ast.Attribute(node.value, other, node.ctx))
        elif node.attr == "T":
            yield Change("transpose lost", node.value)


def _of_call(node: ast.Call) -> Iterator[Change]:
    args, keywords = node.args, node.keywords
    for n, keyword in enumerate(keywords):
        if keyword.arg != STRICT:
            kind = _OPTIONS.get(str(keyword.arg), "option")
            yield Change(kind, ast.Call(node.func, args, keywords[:n] + keywords[n + 1 :]))
    if any(isinstance(arg, ast.Starred) for arg in args):
        return
    name = called(node)
    lost = _LOST.get(name, "function lost")
    if len(args) == 1 and name != "range" and not isinstance(args[0], ast.GeneratorExp):
        yield Change(lost, args[0])  # sqrt(x) becomes x
    elif len(args) >= 2 and name not in SYMMETRIC and not name.startswith("logical_"):
        yield Change("order", ast.Call(node.func, [args[1], args[0], *args[2:]], keywords))
    elif not args and not keywords and isinstance(node.func, ast.Attribute):
        yield Change(lost, node.func.value)  # x.copy() becomes x
    if name in ("range", "arange"):
        for n, arg in enumerate(args):
            for other in _off_by_one(arg):
                changed = ast.Call(node.func, [*args[:n], other, *args[n + 1 :]], keywords)
                yield Change("one off", changed)


def _of_place(site: Site) -> Iterator[Change]:
    """Changes that depend on where an expression stands."""
    parent, node = site.parent, site.node
    if not isinstance(node, ast.expr):
        return
    is_test = isinstance(parent, ast.If | ast.While | ast.IfExp) and site.field == "test"
    is_told_already = isinstance(node, ast.Constant | ast.UnaryOp) or (
        isinstance(node, ast.Compare) and len(node.ops) == 1  # the opposite comparison
    )
    if (is_test or site.field == "ifs") and not is_told_already:
        yield Change("condition", ast.UnaryOp(ast.Not(), node))
    # Of what is returned, and of each part of a tuple that is; and of what a name stands for.
    is_returned = isinstance(parent, ast.Return) or site.field == "elts"
    numbers = (ast.BinOp, ast.Call, ast.Name, ast.Subscript)
    is_computed = isinstance(parent, ast.Assign) and isinstance(node, numbers[:2])
    is_zero = isinstance(node, ast.Call) and ast.unparse(node.func) in ZEROS
    if not is_zero and (is_computed or (is_returned and isinstance(node, numbers))):
        yield Change("negated", ast.UnaryOp(ast.USub(), node))
    if isinstance(node, ast.Slice):
        places = _of_slice(node)
    else:
        is_index = isinstance(parent, ast.Subscript) and site.field == "slice"
        places = _off_by_one(node) if is_index else iter(())
    yield from (Change("one off", other) for other in places)


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
