"""What a student would have done wrong who had written a mutant, by rule from the change.

A sentence goes on after "It looks as if", names no more of the solution than the arguments that
the statement names, and is true of every change of its kind.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from robust_slam_autograder.misconceptions.site import Site

SILENT = (
    *("any all", "case", "case lost", "compared with square", "condition lost", "constant"),
    *("copied", "entry", "function lost", "inf nan", "integers", "logic", "loop", "negated"),
    *("not added", "one step", "option", "step lost", "truth value", "zeros ones"),
)
"""Kinds of how the code goes that no value shows: slips of other kinds end alike."""
SENTENCES: Mapping[str, str] = dict.fromkeys(SILENT, "") | {
    "square lost": "{} is not squared where it should be",
    "square added": "{} is squared where it should not be",
    "root lost": "a square root of {} is not taken",
    "root added": "a square root of {} is taken where none belongs, or a square is missing",
    "size lost": "the absolute value of {} is not taken",
    "size added": "the absolute value of {} is taken, which loses its sign",
    "size for square": "the absolute value of {} stands where its square belongs",
    "twice for square": "{} is doubled where it should be squared",
    "power": "a power of {} is wrong",
    "factor lost": "a factor with {} is left out",
    "divisor lost": "something is not divided by a factor with {}",
    "term lost": "a term with {} is left out",
    "sign": "a term is added that should be subtracted, or the other way round",
    "turned round": "a difference is taken the other way round",
    "upside down": "a quotient is upside down",
    "quotient": "something is multiplied by what it should be divided by, or the other way round",
    "elementwise": "a product goes entry by entry where a matrix product belongs",
    "order": "two things stand in the wrong order, in a product or in a call",
    "transpose lost": "a matrix is not transposed that should be, or not made symmetric",
    "inverse lost": "a matrix is not inverted that should be",
    "condition": "two cases are exchanged, or a comparison is the wrong way round",
    "boundary": "something begins or ends one too early or too late, or equality is missed",
    "side": "two cases are exchanged, or a comparison is the wrong way round",
    "bound lost": "a value is not kept within its bounds",
    "bounded": "only a bound is returned, and not what it bounds",
    "axis": "a sum, a mean or a norm does not go along the axis that it should",
    "exponent": "a power in the formula is not the right one",
    "one off": "something begins or ends one too early or too late, or equality is missed",
    "logarithm lost": "a logarithm is not taken",
    "sum lost": "a sum is not taken",
    "flat": "the result is one long row, whatever the shape of what came in",
    "part": "only one of the results is returned",
    "parts swapped": "the results are returned in another order",
    "median": "the median stands in the place of the mean",
    "min max": "the smallest stands where the largest belongs, or the other way round",
    "sum mean": "a sum stands where a mean belongs, or the other way round",
    "largest for sum": "the largest stands where a sum belongs",
    "sum before square": "a sum is squared where squares belong added up",
    "sin cos": "a sine stands where a cosine belongs, or the other way round",
    "floor ceil": "a number is rounded the wrong way",
    "log log1p": "1 is added within a logarithm where it should not be, or is not where it should",
    "exp expm1": "1 is subtracted from an exponential, or is not where it should be",
    "sqrt square": "a square stands where a square root belongs, or the other way round",
    "vstack hstack": "arrays are put side by side that belong below each other, or the reverse",
}
"""By kind; the braces stand for the arguments at the place, or for "something"."""

FAMILIES: Mapping[str, frozenset[str]] = {
    "two cases are exchanged, or a comparison is the wrong way round": frozenset(
        {"condition", "side"}
    ),
    "a square or a root is missing, or stands where none belongs": frozenset(
        {
            "compared with square",
            "exponent",
            "power",
            "root added",
            "root lost",
            "size for square",
            "sqrt square",
            "square added",
            "square lost",
            "twice for square",
        }
    ),
    "a factor is missing or not the right one, or multiplies where it should divide": frozenset(
        {"constant", "divisor lost", "factor lost", "quotient", "sum mean", "upside down"}
    ),
    "an absolute value is missing, or taken where none belongs": frozenset(
        {"size lost", "size added"}
    ),
    "a sign is not the right one": frozenset({"negated", "sign", "turned round"}),
    "a product, a transpose or an order is not the right one": frozenset(
        {"elementwise", "inverse lost", "order", "parts swapped", "transpose lost"}
    ),
    "something begins or ends one too early or too late, or equality is missed": frozenset(
        {"boundary", "one off"}
    ),
}
"""Sentences that are true of several kinds, where these cannot be told apart."""
_LESS = ("boundary", "exponent", "one off", "quotient", "side")
GENERAL = frozenset({*FAMILIES, *(SENTENCES[kind] for kind in _LESS)})
"""Sentences that say less than a fact of the values does."""
_PAIRS = {name: kind for kind in SENTENCES if len(parts := kind.split()) == 2 for name in parts}
_PAIRS |= {
    "argmin": "min max",
    "argmax": "min max",
    "minimum": "min max",
    "maximum": "min max",
    "logical_and": "logic",
    "logical_or": "logic",
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
_ADDED = {"sqrt": "root added", "abs": "size added", "square": "square added"}


@dataclass(frozen=True)
class Slip:
    """A kind of slip, and where it was made."""

    kind: str
    """A key of ``SENTENCES``."""
    place: tuple[str, ...] = ()
    """Arguments of the function that stand there."""

    @property
    def sentence(self) -> str:
        """Return what goes on after "It looks as if"."""
        names = [f"`{name}`" for name in self.place]
        return SENTENCES[self.kind].format(" and ".join(names) or "something")

    @property
    def is_vague(self) -> bool:
        """Tell whether its sentence needs a place, and has none."""
        return "{}" in SENTENCES[self.kind] and not self.place


def common(slips: Collection[Slip]) -> str:
    """Return the sentence that is true of all; empty where there is none that says anything."""
    if not slips:
        return ""
    if len(set(slips)) == 1 or len({one.kind for one in slips}) == 1:
        first = next(iter(slips))
        shared = first if len(set(slips)) == 1 else Slip(first.kind)
        if not shared.is_vague:
            return shared.sentence
    kinds = {one.kind for one in slips}
    return next((told for told, family in FAMILIES.items() if kinds <= family), "")


def slip_of(site: Site, variant: ast.AST, arguments: frozenset[str]) -> Slip:
    """Tell which slip a change is.

    Args:
        site: what was changed.
        variant: what stands there now.
        arguments: of the function that it stands in.
    """
    node = site.node
    kind, part = _kind(site, node, variant)
    names = {one.id for one in ast.walk(part) if isinstance(one, ast.Name)}
    place = tuple(sorted(names & arguments)) if "{}" in SENTENCES[kind] else ()
    return Slip(kind, place if len(place) == 1 else ())


def _kind(site: Site, node: ast.AST, variant: ast.AST) -> tuple[str, ast.AST]:
    if isinstance(node, ast.stmt):
        return _of_statement(node, variant), node
    if isinstance(variant, ast.UnaryOp) and variant.operand is node:
        return ("condition" if isinstance(variant.op, ast.Not) else "negated"), node
    if isinstance(site.parent, ast.While) and site.field == "test":
        return "loop", node
    if isinstance(site.parent, ast.If | ast.IfExp) and isinstance(variant, ast.Constant):
        return "case", node
    if isinstance(node, ast.Slice) or _is_off_by_one(site, variant):
        return "one off", node
    if isinstance(node, ast.Constant):
        return _of_constant(site, node), node
    if (added := _added(node, variant)) is not None:
        return added, node
    if isinstance(node, ast.BinOp):
        return _of_operator(node, variant)
    if isinstance(node, ast.Call):
        return _of_call(node, variant), node
    return _of_other(node, variant), node


def _of_statement(node: ast.stmt, variant: ast.AST) -> str:
    if isinstance(variant, ast.For | ast.While):
        return "one step"
    if isinstance(variant, ast.AugAssign):
        return "sign" if isinstance(variant.op, ast.Add | ast.Sub) else "quotient"
    if isinstance(node, ast.Return) and isinstance(variant, ast.Return):
        if isinstance(variant.value, ast.Call) and not isinstance(node.value, ast.Tuple):
            return "flat"
        return "parts swapped" if isinstance(variant.value, ast.Tuple) else "part"
    if isinstance(node, ast.AugAssign):
        return "not added"
    return "case lost" if isinstance(node, ast.If) else "step lost"


def _is_off_by_one(site: Site, variant: ast.AST) -> bool:
    is_index = isinstance(site.parent, ast.Subscript) and site.field == "slice"
    name = ast.unparse(site.parent.func) if isinstance(site.parent, ast.Call) else ""
    is_range = name.rpartition(".")[2] in ("range", "arange") and site.field == "args"
    return is_index or is_range


def _of_constant(site: Site, node: ast.Constant) -> str:
    if isinstance(node.value, bool):
        return "truth value"
    if isinstance(site.parent, ast.keyword) and site.parent.arg == "axis":
        return "axis"
    is_power = isinstance(site.parent, ast.BinOp) and isinstance(site.parent.op, ast.Pow)
    return "exponent" if is_power and site.field == "right" else "constant"


def _added(node: ast.AST, variant: ast.AST) -> str | None:
    """Tell what was put around a node."""
    if isinstance(variant, ast.BinOp) and isinstance(variant.op, ast.Pow) and variant.left is node:
        return "square added"
    if isinstance(variant, ast.Call) and variant.args and variant.args[0] is node:
        return _ADDED.get(_name(variant))
    return None


def _of_operator(node: ast.BinOp, variant: ast.AST) -> tuple[str, ast.AST]:
    is_power, is_quotient = isinstance(node.op, ast.Pow), isinstance(node.op, ast.Div)
    if variant in (node.left, node.right):
        left_out = node.right if variant is node.left else node.left
        if is_power:
            is_square = isinstance(node.right, ast.Constant) and node.right.value == 2
            return ("square lost" if is_square else "power"), node.left
        if isinstance(node.op, ast.Add | ast.Sub):
            return "term lost", left_out
        if is_quotient:
            return ("divisor lost" if variant is node.left else "factor lost"), left_out
        return "factor lost", left_out
    if isinstance(variant, ast.Call):
        return ("size for square" if _name(variant) == "abs" else "power"), node.left
    if isinstance(variant, ast.BinOp) and variant.left is node.right:
        kinds = {ast.Sub: "turned round", ast.Div: "upside down"}
        return kinds.get(type(node.op), "order"), node
    if is_power:
        return "twice for square", node.left
    kinds = {
        ast.Add: "sign",
        ast.Sub: "sign",
        ast.MatMult: "elementwise",
        ast.BitAnd: "logic",
        ast.BitOr: "logic",
    }
    return kinds.get(type(node.op), "quotient"), node


def _of_call(node: ast.Call, variant: ast.AST) -> str:
    name = _name(node)
    if name == "sum" and isinstance(variant, ast.BinOp):
        return "sum before square"
    if name == "sum" and isinstance(variant, ast.Call) and _name(variant) == "max":
        return "largest for sum"
    if isinstance(variant, ast.Call) and variant.func is node.func:
        left_out = {one.arg for one in node.keywords} - {one.arg for one in variant.keywords}
        if left_out:
            kinds = {"axis": "axis", "keepdims": "axis", "dtype": "integers"}
            return kinds.get(str(left_out.pop()), "option")
        return "order"
    if name == "where":
        return "condition" if isinstance(variant, ast.Call) else "case"
    if name in ("maximum", "minimum", "clip", "max", "min"):
        return "bounded" if variant in node.args[1:] else "bound lost"
    if name in ("mean", "average") and isinstance(variant, ast.Call):
        return "median"
    if name == "square" and variant not in node.args:
        return "size for square" if isinstance(variant, ast.Call) else "twice for square"
    return _LOST.get(name, "function lost")


def _of_other(node: ast.AST, variant: ast.AST) -> str:
    if isinstance(node, ast.Name | ast.Attribute) and isinstance(variant, type(node)):
        name = node.id if isinstance(node, ast.Name) else node.attr
        return _PAIRS.get(name, "transpose lost" if name == "T" else "constant")
    if isinstance(node, ast.Attribute):
        return "transpose lost"
    if isinstance(node, ast.BoolOp):
        return "logic" if isinstance(variant, ast.BoolOp) else "condition lost"
    if isinstance(node, ast.UnaryOp):
        return "condition" if isinstance(node.op, ast.Not | ast.Invert) else "negated"
    if isinstance(node, ast.Compare) and isinstance(variant, ast.Compare):
        return _of_comparison(node, variant)
    return "entry" if isinstance(node, ast.Subscript) else "step lost"


def _of_comparison(node: ast.Compare, variant: ast.Compare) -> str:
    if variant.left is not node.left or variant.comparators != node.comparators:
        return "compared with square"
    pairs = [
        (type(old), type(new))
        for old, new in zip(node.ops, variant.ops, strict=True)
        if old is not new
    ]
    near = {(ast.Lt, ast.LtE), (ast.LtE, ast.Lt), (ast.Gt, ast.GtE), (ast.GtE, ast.Gt)}
    return "boundary" if set(pairs) <= near else "side"


def _name(call: ast.Call) -> str:
    return ast.unparse(call.func).rpartition(".")[2]
