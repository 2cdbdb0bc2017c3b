"""Which files belong to a package, and to everything that it needs.

Read from what pip, conda or Debian recorded about each distribution. Extras are left out, so
that a package which a library uses only if it is there is not there.
"""

import csv
import importlib.metadata
import importlib.util
import sys
import sysconfig
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.machinery import ModuleSpec
from importlib.metadata import Distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import robust_slam_autograder
from robust_slam_autograder.reading.assignment import DEFAULT_PACKAGES
from robust_slam_autograder.student.imports import NOTEBOOK_PACKAGES, is_standard

OWN_PACKAGES = ("msgpack", "numpy")
"""What the untrusted process itself imports, beside ``NOTEBOOK_PACKAGES``."""
_WITHOUT = ("jedi",)
"""Completes what is typed, and IPython does without it: its stubs are half of all files."""
_GRADER = robust_slam_autograder.__name__


@dataclass(frozen=True)
class Packages:
    """Packages with everything that they need."""

    names: tuple[str, ...]
    """Modules at the top level."""
    paths: tuple[Path, ...]
    """Their files and folders, not resolved: what a link leads to is at the link's place."""
    in_place: dict[str, str]
    """Packages that are imported from a source folder (``pip install --editable``) or one file."""
    libraries: tuple[Path, ...]
    """Compiled modules and the libraries that come with them."""
    sites: tuple[Path, ...]
    """The folders of installed packages, for the import path."""


def missing(packages: Iterable[str]) -> list[str]:
    """Say of each of these packages that is not installed here what to do."""
    return [
        f"packages (by default {', '.join(DEFAULT_PACKAGES)}) names {name}, which is not "
        'installed here: install it, or list others, as in packages = ["numpy"].'
        for name in packages
        if not is_standard(name) and _distribution(name) is None and _source_place(name) is None
    ]


@cache
def find(packages: tuple[str, ...]) -> Packages:
    """Find the files of packages, of what they need, and of what the untrusted process needs.

    They are named as they are imported; those that are not installed are passed over.
    """
    wanted = [name for name in packages if not is_standard(name)]
    roots = [_distribution(name) for name in (*wanted, *NOTEBOOK_PACKAGES, *OWN_PACKAGES)]
    closure = _closure(found for found in roots if found is not None)
    sources = dict(package for found in closure for package in _in_place(found))
    for name in wanted:
        if _distribution(name) is None and (place := _source_place(name)) is not None:
            sources[name] = place
    sources[_GRADER] = str(Path(robust_slam_autograder.__file__).resolve().parent)
    entries = {path: None for found in closure for path in _entries(found)}
    libraries = [path for found in closure for path in _compiled(found)]
    libraries += [path for place in sources.values() for path in _shared(Path(place))]
    return Packages(
        names=tuple(dict.fromkeys([*filter(None, map(_module, entries)), *sources])),
        paths=(*entries, *map(Path, sources.values())),
        in_place=sources,
        libraries=tuple(libraries),
        sites=tuple(dict.fromkeys(path.parent for path in entries)),
    )


def _shared(place: Path) -> list[Path]:
    """Find the compiled modules of a source folder, or of the one file."""
    found = place.rglob("*.so") if place.is_dir() else [place]
    return [path for path in found if path.suffix == ".so"]


def _distribution(name: str) -> Distribution | None:
    """Return the distribution that provides a module."""
    found = _named(name)
    if found is not None and name in _provided(found):
        return found
    others = _providers(tuple(sys.path)).get(name)
    return _named(others[0]) if others else None


@cache
def _providers(path: tuple[str, ...]) -> Mapping[str, list[str]]:
    """Return the distributions of each module on the import path, which takes a while."""
    return importlib.metadata.packages_distributions()


def _provided(found: Distribution) -> set[str]:
    names = {_module(path) for path in _entries(found)}
    return {name for name in names if name} | {name for name, _ in _in_place(found)}


def spec_of(name: str) -> ModuleSpec | None:
    """Return where a module is; of its packages only those around it are imported."""
    try:
        return importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None


def _source_place(name: str) -> str | None:
    """Return the folder, or the one file, of a package that no distribution provides.

    It may be on PYTHONPATH, or have been copied among the installed ones.
    """
    if (spec := spec_of(name)) is None:
        return None
    places = list(spec.submodule_search_locations or ()) or [spec.origin or ""]
    return str(Path(places[0]).resolve()) if Path(places[0]).exists() else None


def _closure(roots: Iterable[Distribution]) -> list[Distribution]:
    found: dict[str, Distribution] = {}
    waiting = list(roots)
    while waiting:
        one = waiting.pop()
        name, requirements = _described(one)
        if found.setdefault(name, one) is one:
            waiting += _needed(requirements)
    return list(found.values())


@cache
def _described(found: Distribution) -> tuple[str, tuple[str, ...]]:
    """Return a distribution's name and requirements: its metadata is long, so it is read once."""
    metadata = found.metadata
    # Older formats keep the requirements in a file of their own.
    required = metadata.get_all("Requires-Dist") or found.requires or ()
    return canonicalize_name(metadata["Name"]), tuple(required)


def _needed(requirements: Iterable[str]) -> list[Distribution]:
    """Return what is required, less what is not there: the package says so when it is imported."""
    wanted = [
        _named(requirement.name)
        for requirement in map(Requirement, requirements)
        if requirement.name not in _WITHOUT
        and (requirement.marker is None or requirement.marker.evaluate({"extra": ""}))
    ]
    return [found for found in wanted if found is not None]


@cache
def _named(name: str) -> Distribution | None:
    try:
        return importlib.metadata.distribution(name)
    except importlib.metadata.PackageNotFoundError:
        return None


@cache
def _files(found: Distribution) -> tuple[tuple[str, ...], ...]:
    """Split the paths of a distribution's files, as far as they are beside its metadata."""
    record = found.read_text("RECORD")
    if record:
        rows = (tuple(row[0].split("/")) for row in csv.reader(record.splitlines()) if row)
        return tuple(parts for parts in rows if parts[0] not in ("..", "", "__pycache__"))
    # Debian's packages list their modules alone.
    modules = (found.read_text("top_level.txt") or found.name).split()
    site = _site(found)
    there = [path for name in modules for path in (site / name, *site.glob(f"{name}.*"))]
    return tuple((path.name,) for path in there if path.exists())


def _site(found: Distribution) -> Path:
    return Path(str(found.locate_file(""))).resolve()


def place(path: Path) -> Path:
    """Return a path whose parent folder is resolved, while a link at its end stays a link."""
    return path.parent.resolve() / path.name


def _entries(found: Distribution) -> list[Path]:
    """List a distribution's files and folders beside its metadata, less hooks of the start."""
    names = dict.fromkeys(parts[0] for parts in _files(found) if not parts[0].endswith(".pth"))
    return [path for name in names if (path := _site(found) / name).exists()]


def _module(path: Path) -> str | None:
    """Name the module that a file or folder beside the metadata is; None where it is no module."""
    name = path.name.partition(".")[0]
    is_module = path.suffix in (".py", ".so") or (path.is_dir() and "." not in path.name)
    return name if is_module and name.isidentifier() else None


def _compiled(found: Distribution) -> list[Path]:
    return [_site(found).joinpath(*parts) for parts in _files(found) if ".so" in parts[-1]]


def _in_place(found: Distribution) -> list[tuple[str, str]]:
    names = [parts[0] for parts in _files(found) if parts[0].endswith(".pth")]
    hooks = [hook for name in names if (hook := _site(found) / name).is_file()]
    return [(folder.name, str(folder)) for hook in hooks for folder in _source_folders(hook)]


def _source_folders(hook: Path) -> list[Path]:
    """Return the packages of the folders that a ``.pth`` file puts on the import path."""
    lines = hook.read_text(encoding="utf-8").splitlines()
    inits = [
        init for line in lines if line[:1] == "/" for init in Path(line).glob("*/__init__.py")
    ]
    return sorted(init.parent.resolve() for init in inits)


@cache
def packages_in_place() -> tuple[Path, ...]:
    """List the folders of all packages that are imported from their sources, the grader's too."""
    site = Path(sysconfig.get_path("purelib"))
    found = [folder for hook in sorted(site.glob("*.pth")) for folder in _source_folders(hook)]
    return tuple(dict.fromkeys([*found, Path(robust_slam_autograder.__file__).resolve().parent]))
