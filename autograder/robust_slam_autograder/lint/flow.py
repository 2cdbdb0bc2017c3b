"""Follows a student's values through a test cell: which expressions hold what came back.

This is a reading of straight code, as test cells are: branches are taken one after
the other and loop bodies twice. What it cannot see it takes for harmless.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from robust_slam_autograder.lint.nodes import walk

SHAPES = frozenset({"shape", "ndim", "size", "len"})
"""Functions and attributes that tell of a value's shape alone."""
FACTS = SHAPES | {"dtype", "isinstance", "callable", "type", "hasattr", "isfinite", "isnan"}
"""What says something of a value, and is never NaN itself."""
VERDICTS = frozenset({"allclose", "isclose", "array_equal", "array_equiv", "all", "any"})
_NUMBERS = frozenset(
    {"int", "float", "bool", "len", "round", "sum", "min", "max", "mean", "median", "dot", "prod"}
    | {"item", "norm", "std", "var", "ptp", "argmin", "argmax", "brentq", "trace", "det", "str"}
)
"""Functions that make one number of many, unless they are given an axis."""
_ELEMENTWISE = frozenset(
    {"abs", "absolute", "sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "square", "sign"}
    | {"where", "minimum", "maximum", "clip", "arctan2", "power", "ndtri", "gammaincinv"}
    | {"gammainc", "tan", "arctan", "hypot", "floor", "ceil", "asarray", "array", "float64"}
)
_DRAWS = {
    **dict.fromkeys(("random", "standard_normal", "standard_cauchy"), 0),
    **dict.fromkeys(("choice", "exponential", "poisson", "rayleigh", "standard_t"), 1),
    **dict.fromkeys(("uniform", "normal", "integers", "laplace", "beta", "gamma"), 2),
}
"""A generator's methods, with the number of arguments before ``size``."""
_SAME_ARRAY = frozenset({"asarray", "asanyarray", "reshape", "ravel", "view", "squeeze"})
_SAME_ITEMS = frozenset({"zip", "enumerate", "list", "tuple", "reversed", "items", "values"})


@dataclass(frozen=True)
class Value:
    """What is known of an expression."""

    keys: frozenset[str] = frozenset()
    """Which results of the student's it holds: "irls[1]" is what irls returned second."""
    raw: bool = False
    """It is a result as it came back: perhaps a list, perhaps an array."""
    many: bool = False
    """An array or a list, as far as one can see, and not one number."""
    functions: frozenset[str] = frozenset()
    """Student's functions that it may be."""
    shares: frozenset[str] = frozenset()
    """Variables whose array or list it may be."""
    source: ast.expr | None = None
    """What a variable was made from."""

    def item(self, index: int | None) -> Value:
        """One item of it; ``index`` where that is known."""
        suffix = "" if index is None else f"[{index}]"
        keys = frozenset(f"{key}{suffix}" for key in self.keys)
        return Value(keys, raw=self.raw, many=bool(keys), functions=self.functions)


NOTHING = Value()


@dataclass(frozen=True)
class Event:
    """A variable is bound, read, or handed to a student's function."""

    kind: Literal["bound", "read", "handed"]
    name: str
    node: ast.AST


@dataclass
class Flow:
    """What ``follow`` found.

    Attributes:
        values: of each expression.
        calls: calls of the student's functions.
        events: what happens to variables, in order.
        parents: the node around each node.
    """

    values: dict[ast.AST, Value] = field(default_factory=dict)
    calls: set[ast.Call] = field(default_factory=set)
    events: list[Event] = field(default_factory=list)
    parents: dict[ast.AST, ast.AST] = field(default_factory=dict)

    def of(self, node: ast.AST) -> Value:
        """What is known of an expression."""
        return self.values.get(node, NOTHING)

    def around(self, node: ast.AST) -> Iterator[ast.AST]:
        """The nodes around a node, from the inside out."""
        while node in self.parents:
            node = self.parents[node]
            yield node

    def expanded(self, node: ast.AST) -> Iterator[ast.AST]:
        """All nodes of an expression, and of what its variables were made from."""
        waiting, seen = [node], set()
        while waiting:
            for part in walk(waiting.pop()):
                if part in seen:
                    continue
                seen.add(part)
                yield part
                source = self.of(part).source if isinstance(part, ast.Name) else None
                waiting += [source] if source is not None else []


def follow(
    tree: ast.Module,
    functions: Iterable[str],
    variables: Iterable[str],
    modules: Mapping[str, str],
) -> Flow:
    """Follow the student's values through a cell.

    Args:
        tree: the cell.
        functions: names of the student's functions.
        variables: names of the student's variables.
        modules: names that stand for modules, which are no values.
    """
    flow = Flow()
    for node in walk(tree):
        flow.parents |= dict.fromkeys(ast.iter_child_nodes(node), node)
    names = {name: Value(functions=frozenset({name})) for name in functions}
    names |= {name: Value(frozenset({name}), raw=True, many=True) for name in variables}
    _Follower(flow, names, modules).block(tree.body)
    return flow


def last_name(node: ast.expr) -> str:
    """The last part of a function's name: allclose of np.allclose."""
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def _join(values: Iterable[Value]) -> Value:
    found = list(values)
    return Value(
        keys=frozenset().union(*(value.keys for value in found)),
        raw=any(value.raw for value in found),
        many=any(value.many for value in found),
        functions=frozenset().union(*(value.functions for value in found)),
        shares=frozenset().union(*(value.shares for value in found)),
    )


@dataclass
class _Follower:
    flow: Flow
    names: dict[str, Value]
    modules: Mapping[str, str]

    def block(self, statements: Iterable[ast.stmt]) -> None:
        for statement in statements:
            self.statement(statement)

    def statement(self, node: ast.stmt) -> None:
        match node:
            case ast.Assign():
                value = self.value(node.value)
                for target in node.targets:
                    self.bind(target, node.value, value)
            case ast.AnnAssign(value=ast.expr() as made):
                self.bind(node.target, made, self.value(made))
            case ast.AugAssign(target=ast.Name(id=name)):
                before = self.names.get(name, NOTHING)
                self.names[name] = _join([before, self.value(node.value)])
            case ast.For():
                self.value(node.iter)
                for _ in range(2):
                    self.bind_items(node.target, node.iter)
                    self.block(node.body)
                self.block(node.orelse)
            case ast.FunctionDef():
                self.function(node)
            case ast.ClassDef():
                self.names.pop(node.name, None)
            case _:
                self.parts(node)

    def parts(self, node: ast.AST) -> None:
        """Read what a statement of any other kind is made of, in order."""
        for part in ast.iter_child_nodes(node):
            if isinstance(part, ast.expr):
                self.value(part)
            elif isinstance(part, ast.stmt):
                self.statement(part)
            else:
                self.parts(part)

    def function(self, node: ast.FunctionDef) -> None:
        """A helper: whatever it is given may be the student's."""
        outside = dict(self.names)
        for argument in _arguments(node.args):
            self.names[argument] = Value(frozenset({f"{node.name}({argument})"}), many=True)
        self.block(node.body)
        self.names = outside
        self.names.pop(node.name, None)

    def bind(self, target: ast.expr, made: ast.expr, value: Value) -> None:
        match target:
            case ast.Name():
                self.names[target.id] = replace(value, source=made)
                self.flow.events.append(Event("bound", target.id, target))
            case ast.Tuple(elts=targets) | ast.List(elts=targets):
                parts = made.elts if isinstance(made, ast.Tuple | ast.List) else []
                for index, one in enumerate(targets):
                    if len(parts) == len(targets):
                        self.bind(one, parts[index], self.flow.of(parts[index]))
                    else:
                        self.bind(one, made, value.item(index))
            case ast.Starred():
                self.bind(target.value, made, value)
            case _:
                self.value(target)

    def bind_items(self, target: ast.expr, items: ast.expr) -> None:
        """Bind a loop's variables: to each of some written items, or to an item of a value."""
        written = items.elts if isinstance(items, ast.Tuple | ast.List) else []
        if isinstance(target, ast.Tuple) and _rows(written, len(target.elts)):
            for index, one in enumerate(target.elts):
                column = [row.elts[index] for row in written if isinstance(row, ast.Tuple)]
                self.bind_any(one, column)
        elif written:
            self.bind_any(target, written)
        else:
            self.bind(target, items, self.flow.of(items).item(None))

    def bind_any(self, target: ast.expr, items: list[ast.expr]) -> None:
        value = _join(self.flow.of(item) for item in items)
        if isinstance(target, ast.Name):
            self.names[target.id] = value
            self.flow.events.append(Event("bound", target.id, target))
        else:
            self.bind(target, items[0], value)

    def value(self, node: ast.expr) -> Value:
        found = self._value(node)
        self.flow.values[node] = found
        return found

    def _value(self, node: ast.expr) -> Value:
        match node:
            case ast.Name(id=name):
                self.flow.events.append(Event("read", name, node))
                known = self.names.get(name, NOTHING)
                return replace(known, shares=known.shares | {name}) if known.many else known
            case ast.Call():
                return self.call(node)
            case ast.Attribute(value=inner, attr=attribute):
                value = self.value(inner)
                shares = value.shares if attribute == "T" else frozenset()
                return NOTHING if attribute in FACTS else replace(value, shares=shares)
            case ast.Subscript():
                return self.subscript(node)
            case ast.Compare():
                many = [self.value(part).many for part in (node.left, *node.comparators)]
                return Value(many=any(many))
            case ast.Lambda():
                self.inner(node.args, [node.body])
                return NOTHING
            case ast.ListComp() | ast.GeneratorExp() | ast.SetComp() | ast.DictComp():
                return self.comprehension(node)
            case ast.NamedExpr():
                value = self.value(node.value)
                self.bind(node.target, node.value, value)
                return value
            case _:
                return self.compound(node)

    def compound(self, node: ast.expr) -> Value:
        """An expression of several: arithmetic, a display, a choice."""
        parts = [part for part in ast.iter_child_nodes(node) if isinstance(part, ast.expr)]
        value = _join(self.value(part) for part in parts)
        is_display = isinstance(node, ast.List | ast.Set | ast.Dict)
        same = isinstance(node, ast.IfExp | ast.Tuple | ast.Starred)
        return replace(
            value,
            raw=value.raw and same,
            many=value.many or is_display,
            shares=value.shares if same or is_display else frozenset(),
        )

    def inner(self, arguments: ast.arguments, bodies: list[ast.expr]) -> None:
        for default in [*arguments.defaults, *(d for d in arguments.kw_defaults if d)]:
            self.value(default)
        outside = dict(self.names)
        self.names |= dict.fromkeys(_arguments(arguments), NOTHING)
        for body in bodies:
            self.value(body)
        self.names = outside

    def comprehension(
        self, node: ast.ListComp | ast.GeneratorExp | ast.SetComp | ast.DictComp
    ) -> Value:
        outside = dict(self.names)
        for part in node.generators:
            self.value(part.iter)
            self.bind_items(part.target, part.iter)
            for condition in part.ifs:
                self.value(condition)
        made = [node.key, node.value] if isinstance(node, ast.DictComp) else [node.elt]
        value = _join([self.value(one) for one in made])
        self.names = outside
        return Value(value.keys, many=True)

    def subscript(self, node: ast.Subscript) -> Value:
        value, index = self.value(node.value), self.value(node.slice)
        if index.many or any(isinstance(part, ast.Slice) for part in walk(node.slice)):
            return value
        return value.item(_whole_number(node.slice))

    def call(self, node: ast.Call) -> Value:
        function = self.value(node.func)
        handed = [*node.args, *(keyword.value for keyword in node.keywords)]
        arguments = [self.value(argument) for argument in handed]
        if isinstance(node.func, ast.Name | ast.Subscript) and function.functions:
            self.flow.calls.add(node)
            names = {name for value in arguments for name in value.shares}
            self.flow.events += [Event("handed", name, node) for name in sorted(names)]
            return Value(function.functions, raw=True, many=True)
        return self.other_call(node, function, arguments)

    def other_call(self, node: ast.Call, function: Value, arguments: list[Value]) -> Value:
        name = last_name(node.func)
        if name in FACTS | VERDICTS:
            return NOTHING
        owner = node.func.value if isinstance(node.func, ast.Attribute) else None
        is_method = owner is not None and getattr(owner, "id", "") not in self.modules
        given = [*([function] if is_method else []), *arguments]
        joined = _join(given)
        return Value(
            joined.keys,
            many=_makes_many(node, name, given),
            functions=joined.functions if name in _SAME_ITEMS else frozenset(),
            shares=joined.shares if name in _SAME_ARRAY else frozenset(),
        )


def _makes_many(node: ast.Call, name: str, given: list[Value]) -> bool:
    keywords = {keyword.arg for keyword in node.keywords}
    of_many = any(value.many for value in given)
    if name in _DRAWS:
        return "size" in keywords or len(node.args) > _DRAWS[name] or of_many
    if name in _NUMBERS:
        return "axis" in keywords
    if name in _ELEMENTWISE:
        return of_many
    return True


def _arguments(arguments: ast.arguments) -> list[str]:
    every = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    every += [one for one in (arguments.vararg, arguments.kwarg) if one]
    return [argument.arg for argument in every]


def _rows(items: list[ast.expr], length: int) -> bool:
    """Whether written items are tuples of one length."""
    tuples = [item for item in items if isinstance(item, ast.Tuple)]
    return bool(items) and len(tuples) == len(items) and {len(t.elts) for t in tuples} == {length}


def _whole_number(node: ast.expr) -> int | None:
    try:
        value = ast.literal_eval(node)
    except (ValueError, TypeError):
        return None
    return value if type(value) is int else None
