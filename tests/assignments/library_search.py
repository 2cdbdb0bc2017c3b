"""Looks for a function of the allowed libraries that gives a solution's values by itself.

For each function that students write, the calls of the cases and the reference's values are
recorded. Then the public functions, constructors and methods of the course's library, and many
functions of NumPy, SciPy and the standard library, are called with the same arguments, in every
order and choice of them, also after the conversions of ``converted``. Whatever comes out, and
its items and attributes, is compared with the reference's value.

Such a search finds an answer of one call, or of a constructor and one call. It does not find
answers that share only a property with the reference, like random graphs.
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import itertools
import pkgutil
import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache, lru_cache, partial
from typing import Any

import numpy as np
import robust_slam
from robust_slam.graphs import PoseGraph, se3
from scipy import differentiate, linalg, optimize, sparse, special, stats

from tests.assignments.lazy.memory import Raised, Recorder
from tests.assignments.reference import Reference

LIBRARY = "robust_slam"
NOT_SEARCHED = {"cli", "datasets", "drawing", "g2o", "gtsam_graph", "sparse"}
"""Modules of the library that draw, read and write files, or factorise sparse matrices."""
MODULES = ("math", "statistics", "numpy", "numpy.linalg")
NOT_CALLED = {
    # Comparisons and means: to know which is the work.
    *("fmean", "greater", "greater_equal", "less", "less_equal"),
    # They read or write files, or change how NumPy works.
    *("fromfile", "fromregex", "genfromtxt", "info", "load", "loadtxt", "save", "savetxt"),
    *("savez", "savez_compressed", "set_printoptions", "setbufsize", "seterr", "seterrcall"),
    *("show_config", "show_runtime", "test"),
    # They make something as large as an argument says, or take long.
    *("arange", "array_split", "bartlett", "bincount", "blackman", "comb", "diag", "diagflat"),
    *("diag_indices",),
    *("dsplit", "empty", "empty_like", "eye", "factorial", "full", "hamming", "hanning"),
    *("histogram2d", "histogramdd", "hsplit", "identity", "indices", "kaiser", "mask_indices"),
    *("matrix_power", "ones", "pad", "perm", "polyfit", "repeat", "resize", "split", "tile"),
    *("tri", "tril_indices", "triu_indices", "unpackbits", "vander", "vsplit", "zeros"),
}
SPECIAL = ("huber", "pseudo_huber", "kl_div", "rel_entr", "entr", "xlogy", "xlog1py", "boxcox")
SPECIAL = (*SPECIAL, "chdtr", "chdtrc", "chdtri", "erf", "erfc", "erfinv", "expit", "gammainc")
SPECIAL = (*SPECIAL, "gammaincinv", "log_expit", "logit", "logsumexp", "ndtr", "ndtri", "softmax")
LINALG = ("block_diag", "eigh", "eigvalsh", "expm", "lstsq", "null_space", "orth", "polar")
LINALG = (*LINALG, "orthogonal_procrustes", "pinvh", "solve", "subspace_angles", "svd", "toeplitz")
OPTIMIZERS = ("brentq", "fixed_point", "fsolve", "least_squares", "minimize", "minimize_scalar")
DISTRIBUTIONS = ("cauchy", "chi", "chi2", "laplace", "norm", "rayleigh", "t")
METHODS = ("ppf", "isf", "cdf", "sf", "pdf", "logpdf")

TRIED = 2
"""Calls on which every candidate is tried. One that hits is tried on all."""
SHARE = 0.6
"""Of the telling calls that must be right: the rest may be cases that a student adds by hand."""
DISTINCT = 3
"""Different values that must be right. One or two may be a coincidence."""
MOST_ARGUMENTS = 2
"""Those that have a default are left out beyond this number, but for one of the library's."""
LONGEST = 5.0
"""CPU seconds after which a call is given up."""
MOST_ALIKE = 2
"""Objects from one function that are handed on to others."""

Atoms = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Call:
    """One call of a student's function by a case, and what the reference returned."""

    function: str
    arguments: Atoms
    """By the names of the parameters."""
    value: Any


@dataclass(frozen=True)
class Function:
    """A function that a student could import."""

    name: str
    call: Callable[..., Any] = dataclasses.field(compare=False)


@dataclass(frozen=True)
class Use:
    """A function with the arguments that it is called with: a name, or another use."""

    function: Function | None
    """None for the method of an object."""
    arguments: tuple[str | Use, ...]
    method: tuple[Use, str] | None = None

    def __str__(self) -> str:
        name = f"{self.method[0]}.{self.method[1]}" if self.method else self.function.name
        return f"{name}({', '.join(map(str, self.arguments))})"

    def value(self, atoms: Atoms) -> Any:
        """What comes out for these arguments."""
        given = [
            one.value(atoms) if isinstance(one, Use) else atoms[one] for one in self.arguments
        ]
        if self.method:
            return getattr(self.method[0].value(atoms), self.method[1])(*given)
        return self.function.call(*given, **_keywords(self.function.call, atoms))


@dataclass(frozen=True)
class Hit:
    """A use that gives a solution's values."""

    function: str
    """The student's."""
    library: str
    """The full name of the library's function."""
    use: str
    part: str
    """Which part of the value, and what was done with it."""

    def __str__(self) -> str:
        return f"{self.function} is {self.use}{self.part}"


def recorded(solutions: Reference, seed: int) -> list[Call]:
    """The calls that an assignment's cases make under a seed, hidden checks and all."""
    recorders = {name: Recorder(function) for name, function in solutions.functions.items()}
    for case in solutions.assignment.cases:
        solutions.run(case, seed, recorders)
    return [
        Call(name, _by_name(recorder.function, call.given), call.result)
        for name, recorder in recorders.items()
        for call in recorder.calls.values()
        if not isinstance(call.result, Raised)
    ]


def _by_name(function: Callable[..., Any], given: Atoms) -> dict[str, Any]:
    """Arguments with the names of the function's parameters in place of their numbers."""
    names = list(inspect.signature(function).parameters)
    numbered = {f"argument {n}": name for n, name in enumerate(names, start=1)}
    return {numbered.get(key, key): value for key, value in given.items() if "[" not in key}


def search(calls: Sequence[Call], withheld: Sequence[str]) -> Iterator[Hit]:
    """Look for answers to one of a student's functions.

    Args:
        calls: the recorded calls of that function.
        withheld: modules of the course's library that students cannot import.
    """
    signal.signal(signal.SIGVTALRM, _stop)
    telling = [call for call in calls if _targets(call)]
    found: set[str] = set()
    for call in telling[:: max(1, len(telling) // TRIED)][:TRIED]:
        for use, value in uses(converted(call.arguments), withheld):
            for part in _matching(value, call):
                hit = Hit(call.function, _library_name(use), str(use), part)
                if str(hit) not in found and _is_answer(use, part, telling):
                    found.add(str(hit))
                    yield hit


def _library_name(use: Use) -> str:
    return _library_name(use.method[0]) if use.method else use.function.name


def _stop(*_: object) -> None:
    raise TimeoutError


def _is_answer(use: Use, part: str, telling: Sequence[Call]) -> bool:
    """Whether most values are right; for one kind of call is enough, where a word tells kinds."""
    groups: dict[str, list[Call]] = {}
    for call in telling:
        words = [value for value in call.arguments.values() if isinstance(value, str)]
        groups.setdefault(str(words), []).append(call)
    return any(_answers(use, part, group) for group in groups.values())


def _answers(use: Use, part: str, group: Sequence[Call]) -> bool:
    right: list[Call] = []
    for number, call in enumerate(group):
        if part in _matching(_again(use, call), call):
            right.append(call)
        elif number + 1 - len(right) > (1 - SHARE) * len(group):
            return False
    values, every = ({_known_by(call) for call in some} for some in (right, group))
    return len(values) >= min(DISTINCT, len(every))


@cache
def _known_by(call: Call) -> str:
    """The same text for calls with the same value."""
    targets = _targets(call)
    return str([one if isinstance(one, str) else one.tolist() for one in targets])


@lru_cache(maxsize=500)
def _again(use: Use, call: Call) -> Any:
    """The value for another call; kept while the parts of the use are looked at."""
    return _value_or_none(lambda: use.value(converted(call.arguments)))


def _value_or_none(call: Callable[[], Any]) -> Any:
    """The value; None for a call that makes no sense or takes long."""
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    try:
        return call()
    except (Exception, SystemExit):  # anything at all may come out of a call that makes no sense
        return None
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


# What is called


def uses(atoms: Atoms, withheld: Sequence[str]) -> Iterator[tuple[Use, Any]]:
    """Every use of every function on these arguments that gives a value, with the value."""
    objects: dict[Use, Any] = {}
    for function in (*library_functions(withheld), *other_functions()):
        for use, value in _applied(function, atoms):
            yield use, value
            alike = [one.function for one in objects].count(function)
            is_new = all(type(one) is not type(value) for one in atoms.values())
            if type(value).__module__.startswith(LIBRARY) and is_new and alike < MOST_ALIKE:
                objects[use] = value
    for use, value in objects.items():
        yield from _methods(use, value, atoms)
    for function in library_functions(withheld):
        yield from _applied(function, atoms, objects)


def _applied(
    function: Function, atoms: Atoms, objects: Mapping[Use, Any] | None = None
) -> Iterator[tuple[Use, Any]]:
    """The function on the arguments; with ``objects``, one of them at least among these."""
    pool: dict[str | Use, Any] = {**atoms, **(objects or {})}
    keywords = _keywords(function.call, atoms)
    for chosen in _choices(function.call, pool):
        if objects is None or any(isinstance(one, Use) for one in chosen):
            given = [pool[one] for one in chosen]
            made = _value_or_none(partial(function.call, *given, **keywords))
            if made is not None:
                yield Use(function, chosen), made


def _methods(use: Use, value: Any, atoms: Atoms) -> Iterator[tuple[Use, Any]]:
    known = {**vars(type(value)), **getattr(value, "__dict__", {})}
    for name in [key for key, one in known.items() if callable(one) and not key.startswith("_")]:
        method = getattr(value, name)
        for chosen in _choices(method, atoms):
            made = _value_or_none(partial(method, *(atoms[one] for one in chosen)))
            if made is not None:
                yield Use(None, chosen, (use, name)), made


def _choices(call: Callable[..., Any], pool: Mapping[Any, Any]) -> Iterator[tuple[Any, ...]]:
    """Arguments from the pool that fit the function's number and kinds of parameters."""
    kinds, needed = _parameters(call)
    for count in range(needed, len(kinds) + 1):
        fitting = [[key for key, value in pool.items() if _fits(value, k)] for k in kinds[:count]]
        for chosen in itertools.product(*fitting):
            if len(set(chosen)) == count:
                yield chosen


@cache
def _parameters(call: Callable[..., Any]) -> tuple[list[str], int]:
    """The annotations of the positional parameters, and how many have no default."""
    if isinstance(call, np.ufunc):
        return [""] * call.nin, call.nin
    try:
        found = inspect.signature(call).parameters.values()
    except (ValueError, TypeError):  # written in C
        return ["", ""], 1
    plain = [one for one in found if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)]
    needed = sum(one.default is one.empty for one in plain)
    kinds = ["" if one.annotation is one.empty else str(one.annotation) for one in plain]
    if any(one.kind is one.VAR_POSITIONAL for one in found):
        kinds += [""] * (MOST_ARGUMENTS - len(kinds))
    optional = 1 if any(kinds) else 0
    return kinds[: max(needed + optional, MOST_ARGUMENTS)], needed


def _keywords(call: Callable[..., Any], atoms: Atoms) -> dict[str, Any]:
    """The arguments that share their name with a parameter that takes names alone."""
    return {name: atoms[name] for name in _keyword_names(call) if name in atoms}


@cache
def _keyword_names(call: Callable[..., Any]) -> list[str]:
    try:
        found = inspect.signature(call).parameters.values()
    except (ValueError, TypeError):
        return []
    return [one.name for one in found if one.kind is one.KEYWORD_ONLY]


def _fits(value: Any, kind: str) -> bool:
    """Whether a value may be meant by a parameter of this annotation."""
    own = type(value).__module__.startswith(LIBRARY)
    if not kind or kind == "Any":
        return not own and not isinstance(value, str) and value is not None
    if own:
        return type(value).__name__ in kind or "Problem[" in kind or "Rule[" in kind
    if "Callable" in kind:
        return callable(value)
    if kind in ("float", "int"):
        return isinstance(value, int | float | np.number)
    if "Array" in kind or kind in ("Indices", "Mask"):
        return isinstance(value, int | float | np.number | list | np.ndarray)
    return isinstance(value, str) and kind in ("str", "Kind")


@cache
def library_functions(withheld: Sequence[str]) -> tuple[Function, ...]:
    """The public functions and classes of the library's modules that are not withheld."""
    walked = pkgutil.walk_packages(robust_slam.__path__, f"{LIBRARY}.")
    names = [one.name for one in walked if NOT_SEARCHED.isdisjoint(one.name.split("."))]
    left = [one for one in names if not any(f"{one}.".startswith(f"{w}.") for w in withheld)]
    return tuple(
        Function(f"{name}.{key}", value)
        for name in left
        for key, value in vars(importlib.import_module(name)).items()
        if callable(value) and not key.startswith("_") and getattr(value, "__module__", "") == name
        if not (isinstance(value, type) and issubclass(value, Exception))
    )


@cache
def other_functions() -> tuple[Function, ...]:
    """Functions of NumPy, SciPy and the standard library."""
    members = [(name, vars(importlib.import_module(name))) for name in MODULES]
    members.append(("scipy.special", {name: getattr(special, name) for name in SPECIAL}))
    members.append(("scipy.linalg", {name: getattr(linalg, name) for name in LINALG}))
    members.append(("scipy.differentiate", {"derivative": differentiate.derivative}))
    members.append(("scipy.optimize", {name: getattr(optimize, name) for name in OPTIMIZERS}))
    for one in DISTRIBUTIONS:
        methods = {name: getattr(getattr(stats, one), name) for name in METHODS}
        members.append((f"scipy.stats.{one}", methods))
    found: dict[int, Function] = {}
    for module, functions in members:
        for key, value in functions.items():
            is_function = callable(value) and not isinstance(value, type)
            if is_function and not key.startswith("_") and key not in NOT_CALLED:
                found.setdefault(id(value), Function(f"{module}.{key}", value))
    return tuple(found.values())


# What it is called with


def converted(arguments: Atoms) -> dict[str, Any]:
    """The arguments, and what a student would make of them in one line."""
    atoms = dict(arguments)
    for convert in (
        _edges,
        _as_graph,
        _rotations_as_graph,
        _line_as_graph,
        _closures_as_graph,
        _whitened,
    ):
        try:
            atoms |= convert(arguments)
        except (KeyError, ValueError, TypeError):
            continue
    return atoms


def _edges(given: Atoms) -> Atoms:
    return {"edges": np.stack([given["i"], given["j"]], axis=1)}


def _as_graph(given: Atoms) -> Atoms:
    return {"PoseGraph(**graph)": PoseGraph(**given["graph"])}


def _line_as_graph(given: Atoms) -> Atoms:
    """Poses on a line are poses in the plane; with x there are poses."""
    z, sigma = np.broadcast_arrays(np.asarray(given["z"], float), given["sigma"])
    n = int(given["n"]) if "n" in given else np.size(given["x"])
    information = (sigma**-2.0)[:, None, None] * np.eye(3)
    edges = _edges(given)["edges"]
    flat = np.stack([z, 0 * z, 0 * z], axis=1)
    made = {"graph of z": PoseGraph(n, edges, flat, information, np.zeros(z.shape, dtype=bool))}
    if "x" in given:
        x = np.asarray(given["x"], float)
        made["poses of x"] = np.stack([x, 0 * x, 0 * x], axis=1)
    return made


def _rotations_as_graph(given: Atoms) -> Atoms:
    turns = np.asarray(given["R_meas"], float)
    m, d = turns.shape[:2]
    kappa = np.broadcast_to(given["kappa"], m)
    if d == 2:
        zero = np.zeros(m)
        measured = np.stack([zero, zero, np.arctan2(turns[:, 1, 0], turns[:, 0, 0])], axis=1)
    else:
        measured = se3.from_parts(turns, np.zeros((m, 3)))
    information = kappa[:, None, None] * np.eye(3 * d - 3)
    edges = _edges(given)["edges"]
    graph = PoseGraph(int(given["n"]), edges, measured, information, np.zeros(m, dtype=bool))
    return {"graph of R_meas": graph}


def _closures_as_graph(given: Atoms) -> Atoms:
    steps = len(given["odometry"])
    edges = np.vstack([[(k, k + 1) for k in range(steps)], given["ends"]])
    covariance = np.vstack([given["odometry_cov"], given["loop_cov"]])
    measured = np.vstack([given["odometry"], given["loops"]])
    is_odometry = np.arange(len(edges)) < steps
    information = np.linalg.inv(covariance)
    return {"graph of loops": PoseGraph(steps + 1, edges, measured, information, is_odometry)}


def _whitened(given: Atoms) -> Atoms:
    z, sigma = np.asarray(given["z"], float), np.asarray(given["sigma"], float)
    made = {"z / sigma": z / sigma, "1 / sigma**2": np.broadcast_to(sigma**-2.0, z.shape)}
    if np.ndim(given.get("x", "")) == 0 and "x" in given:
        made["(z - x) / sigma"] = (z - given["x"]) / sigma
    return made


# What comes out


CHANGES: dict[str, Callable[[Any], Any]] = {
    "": lambda v: v,
    " * 2": lambda v: v * 2,
    " / 2": lambda v: v / 2,
    " * -1": lambda v: -v,
    ", squared": lambda v: v * v,
    ", its root": lambda v: abs(v) ** 0.5,
}


def _matching(value: Any, call: Call) -> list[str]:
    """The parts of a value that are the reference's, or a part of it."""
    targets = _targets(call)
    return [
        label + name
        for label, leaf in leaves(value)
        for target in targets
        for name in _changes(leaf, target)
    ]


def _changes(leaf: Any, target: Any) -> Iterator[str]:
    """What may be done with a part of a value to make it the target."""
    if isinstance(leaf, str) or isinstance(target, str) or leaf.dtype == bool or not leaf.size:
        if _same(leaf, target):
            yield ""
        return
    if leaf.ndim == 2 and leaf.shape[:1] == target.shape and _same(leaf[:, 0], target):
        yield ", first column"
    if leaf.ndim == 2 and leaf.shape[:1] == target.shape and _shifted(leaf[:, 0], target):
        yield ", first column less its own entry"
    if leaf.shape == target.shape:
        first, wanted = float(leaf.flat[0]), float(target.flat[0])
        for name, change in CHANGES.items():
            near = abs(change(first) - wanted) <= 1e-8 + 1e-5 * abs(wanted)
            if near and _same(change(leaf.astype(float)), target):
                yield name


def _shifted(one: Any, two: Any) -> bool:
    gap = one - two
    return one.size > 2 and np.ptp(one) > 0 and bool(np.ptp(gap) <= 1e-5 * np.ptp(one))


@cache
def _targets(call: Call) -> list[Any]:
    """The parts of the reference's value that say something: no argument, no constant."""
    atoms = [leaf for _, leaf in leaves(list(call.arguments.values()))]
    every = [leaf for _, leaf in leaves(call.value)]
    return [one for one in every if not _is_plain(one) and not any(_same(one, a) for a in atoms)]


def _is_plain(leaf: Any) -> bool:
    if isinstance(leaf, str):
        return False
    return leaf.size == 0 or (np.ptp(leaf.astype(float)) == 0 and leaf.flat[0] in (0, 1, np.inf))


def _same(one: Any, two: Any) -> bool:
    if isinstance(one, str) or isinstance(two, str):
        return isinstance(one, str) and isinstance(two, str) and one == two
    return one.shape == two.shape and bool(np.allclose(one, two, rtol=1e-5, atol=1e-8))


def leaves(value: Any, label: str = "") -> list[tuple[str, Any]]:
    """The arrays and strings that a value holds, each with the way to it."""
    if isinstance(value, Enum):
        return leaves(value.value, f"{label}.value")
    if isinstance(value, str):
        return [(label, value)]
    if sparse.issparse(value):
        return [(f"{label}.toarray()", value.toarray())]
    if isinstance(value, bool | int | float | np.generic | np.ndarray):
        array = np.asarray(value)
        return [(label, array)] if array.dtype.kind in "biuf" else []
    if isinstance(value, Mapping):
        return [one for key, each in value.items() for one in leaves(each, f"{label}[{key!r}]")]
    if isinstance(value, tuple | list):
        return _leaves_of_list(value, label)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {one.name: getattr(value, one.name) for one in dataclasses.fields(value)}
        return [one for key, each in fields.items() for one in leaves(each, f"{label}.{key}")]
    return []


def _leaves_of_list(value: Sequence[Any], label: str) -> list[tuple[str, Any]]:
    try:
        array = np.asarray(value)
    except ValueError:  # ragged
        array = np.empty(0, dtype=object)
    if array.dtype.kind in "biuf" and isinstance(value, list):
        return [(label, array)]
    found = [one for k, each in enumerate(value[:8]) for one in leaves(each, f"{label}[{k}]")]
    return found + ([(label, array)] if array.dtype.kind in "biuf" else [])
