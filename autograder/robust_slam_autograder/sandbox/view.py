"""What student code finds on its disk: the interpreter, the allowed packages, nothing else."""

import importlib.util
import os
import re
import subprocess
import sys
import sysconfig
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox import packages
from robust_slam_autograder.student.imports import NOT_INSTALLED

_SYSTEM_FILES = ("/etc/ld.so.cache", "/usr/share/zoneinfo", "/usr/lib/locale/C.utf8")
_LOADED_LATER = ("libgcc_s.so.1",)
"""Libraries that the C library opens by itself when a thread ends."""
_OPENS_OTHERS = "libmkl"
"""Libraries that open others of this name when they run."""
_TRACED = re.compile(r"(/\S.*) \(0x[0-9a-f]+\)$")


@dataclass(frozen=True)
class Files:
    """What student code finds on its disk."""

    rules: tuple[tuple[Path, bool], ...]
    """Files and folders, parents first, and whether each is shown. The deepest rule that contains
    a file decides, because packages may be inside the standard library's folder."""
    folders: tuple[Path, ...]
    """It may list these, from which packages are imported, but not read all in them."""
    fonts: tuple[Path, ...]
    """Matplotlib's lists of fonts."""


def files(allowed: tuple[str, ...], withheld: tuple[str, ...]) -> Files:
    """Find what student code may read here: of allowed packages all but withheld modules."""
    hidden = [*_standard_parts(), *(path for name in withheld for path in _files_of(name))]
    lists = (path for path in font_folder().glob("fontlist-v*.json") if path.is_file())
    return Files(
        rules=_rules(_visible(allowed), hidden),
        folders=packages.find(allowed).sites,
        fonts=tuple(lists),
    )


def _rules(visible: Iterable[Path], hidden: Iterable[Path]) -> tuple[tuple[Path, bool], ...]:
    """Order what is shown and what is not, without what the folder around it says already."""
    wanted = dict.fromkeys(visible, True) | dict.fromkeys(hidden, False)
    rules: dict[Path, bool] = {}
    for path in sorted(wanted, key=lambda path: (len(path.parts), path)):
        around = next((rules[parent] for parent in path.parents if parent in rules), False)
        if wanted[path] != around:
            rules[path] = wanted[path]
    return tuple(rules.items())


@cache
def _visible(allowed: tuple[str, ...]) -> tuple[Path, ...]:
    found = packages.find(allowed)
    visible = dict.fromkeys([*_interpreter(), *found.paths])
    libraries = [path for path in _libraries(found) if not within(path, visible)]
    return tuple(path for path in {**visible, **dict.fromkeys(libraries)} if path.exists())


def standard_path() -> list[Path]:
    """Return the folders from which the standard library is imported."""
    return [_standard_library(), _standard_library() / "lib-dynload"]


def _standard_library() -> Path:
    return Path(sysconfig.get_path("stdlib")).resolve()


def _interpreter() -> list[Path]:
    python = Path(os.path.realpath(sys.executable))
    return [python, _standard_library(), *map(Path, _SYSTEM_FILES)]


@cache
def _standard_parts() -> list[Path]:
    """Say what is in the standard library's folder and is not shown."""
    base = _standard_library()
    names = ("site-packages", "dist-packages", *NOT_INSTALLED)
    found = [*(base / name for name in names), *base.glob("config-*")]
    found += base.glob("lib-dynload/_tkinter.*")
    return [path for path in found if path.exists()]


def _libraries(found: packages.Packages) -> list[Path]:
    """Return the system's libraries that the interpreter and the packages load.

    The system's own dynamic loader lists them; it loads everything and runs nothing.
    """
    plain = [*_standard_links(), *_links(found.libraries, found.sites)]
    mkl = [path for path in plain if path.name.startswith(_OPENS_OTHERS)]
    others = [other for path in mkl for other in path.parent.glob(f"{_OPENS_OTHERS}*")]
    return list(dict.fromkeys([*plain, *others]))


@cache
def _standard_links() -> list[Path]:
    """Find the same for all packages."""
    modules = set((_standard_library() / "lib-dynload").glob("*.so"))
    return _links(sorted(modules.difference(_standard_parts())), ())


def _links(modules: Iterable[Path], sites: Sequence[Path]) -> list[Path]:
    """Find what compiled modules load of these folders of packages and of the system."""
    groups: dict[Path, list[str]] = defaultdict(list)
    for path in modules:
        # Relative paths: in the loader's list blanks and colons separate.
        folder = next((site for site in sites if within(path, [site])), path.parent)
        groups[folder].append(f"./{path.relative_to(folder)}")
    lines = [line for folder, names in groups.items() for line in _trace(folder, names)]
    traced = [match[1] for line in lines if (match := _TRACED.search(line))]
    return [Path(os.path.normpath(text)) for text in traced]


def _trace(folder: Path, names: Sequence[str]) -> list[str]:
    plain = [name for name in names if not re.search(r"[\s:]", name)]
    environment = {
        "LC_ALL": "C",
        "LD_TRACE_LOADED_OBJECTS": "1",
        "LD_PRELOAD": ":".join([*_LOADED_LATER, *plain]),
    }
    python = os.path.realpath(sys.executable)
    done = subprocess.run([python], cwd=folder, env=environment, capture_output=True)
    return done.stdout.decode(errors="replace").splitlines()


def _files_of(module: str) -> list[Path]:
    top, *rest = module.split(".")
    spec = importlib.util.find_spec(top)
    if spec is None:
        return []
    if rest:
        folders = [Path(folder, *rest[:-1]) for folder in spec.submodule_search_locations or ()]
    else:
        places = spec.submodule_search_locations or [spec.origin or ""]
        folders = [Path(place).parent for place in places]
    name = module.rpartition(".")[2]
    found = []
    copies = (f"{name}.*", f".{name}.*", f"#{name}.*")  # the last two are editors' own
    # A package may be a link, or be in one.
    plain = [packages.place(folder) for folder in folders]
    for folder in dict.fromkeys([*plain, *(folder.resolve() for folder in folders)]):
        files = (path for pattern in copies for path in folder.glob(pattern))
        found += sorted(path for path in files if path.is_file())
        inside = (folder / one for one in (name, "__pycache__", ".ipynb_checkpoints"))
        found += [path for path in inside if path.is_dir()]
    return found


def font_folder() -> Path:
    """Say where matplotlib keeps its list of fonts, which takes it seconds to make."""
    cache_folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "matplotlib"
    return Path(os.environ.get("MPLCONFIGDIR") or cache_folder)


def readable(found: Files) -> list[tuple[Path, bool]]:
    """Say what of the visible remains without the hidden, as a list of what may be opened.

    Returns:
        paths; and whether all beneath may be read, or the names in the folder alone.
    """
    rules = {path.resolve(): is_shown for path, is_shown in found.rules}
    hidden = [path for path, is_shown in rules.items() if not is_shown]
    waiting = [path for path, is_shown in rules.items() if is_shown]
    opened: dict[Path, bool] = {}
    while waiting:
        path = waiting.pop()
        if path not in opened:
            opened[path] = not any(hid.is_relative_to(path) for hid in hidden)
            if not opened[path]:
                inside = (inner.resolve() for inner in path.iterdir())  # a link may lead out of it
                waiting += (inner for inner in inside if _is_shown(inner, rules))
    return [*((path.resolve(), False) for path in found.folders), *opened.items()]


def _is_shown(path: Path, rules: Mapping[Path, bool]) -> bool:
    """Say what the nearest rule says of a path."""
    return next((rules[one] for one in (path, *path.parents) if one in rules), False)


def exposing(path: Path, allowed: tuple[str, ...]) -> Path | None:
    """Find the visible folder in which a path is, through links too; None where it is hidden.

    The path need not exist; packages are allowed as in ``files``.
    """
    shown = {place: one for one in _visible(allowed) for place in (one, one.resolve())}
    for place in (Path(os.path.abspath(path)), path.resolve()):
        for folder in (place, *place.parents):
            if folder in shown:
                return shown[folder]
    return None


def within(path: Path, folders: Collection[Path]) -> bool:
    """Tell whether a path is one of these folders, or inside one."""
    return any(place in folders for place in (path, *path.parents))
