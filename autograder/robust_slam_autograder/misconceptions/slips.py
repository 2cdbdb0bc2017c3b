"""What a student would have done wrong who had written a mutant, by rule from the change.

A sentence goes on after "It looks as if", names no more of the solution than the arguments that
the statement names, and is true of every change of its kind.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping
from dataclasses import dataclass

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
"""By kind; the braces stand for the argument at the place, or for "something"."""

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


@dataclass(frozen=True)
class Slip:
    """A kind of slip, and where it was made."""

    kind: str
    """A key of ``SENTENCES``."""
    place: str = ""
    """The argument of the function that stands there; empty for none, or for more than one."""

    @property
    def sentence(self) -> str:
        """Return what goes on after "It looks as if"."""
        return SENTENCES[self.kind].format(f"`{self.place}`" if self.place else "something")

    @property
    def is_vague(self) -> bool:
        """Tell whether its sentence needs a place, and has none."""
        return "{}" in SENTENCES[self.kind] and not self.place


def common(slips: Collection[Slip]) -> str:
    """Return the sentence that is true of all; empty where there is none that says anything."""
    if not slips:
        return ""
    kinds = {one.kind for one in slips}
    if len(kinds) == 1:
        first, *others = set(slips)
        shared = Slip(first.kind) if others else first
        if not shared.is_vague:
            return shared.sentence
    return next((told for told, family in FAMILIES.items() if kinds <= family), "")


@dataclass(frozen=True)
class Change:
    """What may stand in a node's place, and which slip that is."""

    kind: str
    """A key of ``SENTENCES``."""
    variant: ast.AST
    about: ast.AST | None = None
    """Of the node what the slip is about, where that is not all of it."""

    def slip(self, site: Site, arguments: frozenset[str]) -> Slip:
        """Return the slip, where the change is made at a site of a function of these arguments."""
        kind = _of_place(site, self.variant) or self.kind
        names = {one.id for one in ast.walk(self.about or site.node) if isinstance(one, ast.Name)}
        places = sorted(names & arguments) if "{}" in SENTENCES[kind] else []
        return Slip(kind, places[0] if len(places) == 1 else "")


def _of_place(site: Site, variant: ast.AST) -> str:
    """Return the kind of a change whose place says more than what is changed; or nothing."""
    parent, field, node = site.parent, site.field, site.node
    is_around = isinstance(variant, ast.UnaryOp) and variant.operand is node
    if is_around or isinstance(node, ast.stmt):
        return ""
    if isinstance(parent, ast.While) and field == "test":
        return "loop"
    if isinstance(parent, ast.If | ast.IfExp) and isinstance(variant, ast.Constant):
        return "case"
    is_range = isinstance(parent, ast.Call) and called(parent) in ("range", "arange")
    is_index = isinstance(parent, ast.Subscript) and field == "slice"
    return "one off" if is_index or (is_range and field == "args") else ""


def called(node: ast.Call) -> str:
    """Return the name of what a call calls, without its module."""
    return ast.unparse(node.func).rpartition(".")[2]
