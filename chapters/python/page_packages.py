"""Puts a package in place when it is first imported, and of it only the folders that are.

Pyodide's own loader unpacks packages whole, and starts all their libraries, of which SciPy has
110, before the first line runs. In a worker libraries can start when Python imports them.
"""

import ast
import io
import os
import sys
import zipfile
from collections.abc import Callable, Iterator
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from typing import Any

SITE, LIBRARIES = "/lib/python3.12/site-packages", "/usr/lib"

Read = Callable[[str, bool], Any]
"""Gives the content of a file of the site as JavaScript's bytes. Where the second argument is
false it waits for nothing, and gives None for a file that is not at hand."""


class Missing(BaseException):
    """An import needs files that are not at hand; no package may take it for an ImportError."""

    def __init__(self, files: list[str]) -> None:
        super().__init__(files)
        self.files = files


class Shelf(MetaPathFinder):
    """The packages that code of a page may import.

    Args:
        packages: Pyodide's list: of each package its file, what it is imported as, and on which
            packages it depends. Those that nothing imports come with the packages that need them.
        read: gives the content of a file.
        link: starts a library that packages share, by its path.
        site: the folder for modules.
    """

    def __init__(
        self,
        packages: dict[str, dict[str, Any]],
        read: Read,
        link: Callable[[str], object],
        site: str = SITE,
    ) -> None:
        self._packages, self._read, self._link, self._site = packages, read, link, site
        self._names = {name: key for key, each in packages.items() for name in each["imports"]}
        self._opened: set[str] = set()
        self._folded: dict[str, tuple[zipfile.ZipFile, list[str]]] = {}
        self._may_wait = True

    def find_spec(
        self, name: str, path: object = None, target: object = None
    ) -> ModuleSpec | None:
        """Put in place what the import needs; other finders then find it there."""
        if name in self._names and self._names[name] not in self._opened:
            self._open(self._names[name])
        if name in self._folded:
            self._unfold(name)
        return None

    def missing(self, code: str) -> list[str]:
        """Return files that the imports in the code need and that are not at hand.

        The imports are carried out as far as possible, so that the library's own imports count
        too. With the files at hand, more may be missing.
        """
        files: list[str] = []
        self._may_wait = False
        try:
            for statement in self._imports(code):
                try:
                    exec(compile(ast.Module([statement], []), "<imports>", "exec"), {})
                except Missing as missing:
                    files += missing.files
                except Exception:  # the reader is told when the cell runs
                    continue
        finally:
            self._may_wait = True
        return sorted(set(files))

    def _imports(self, code: str) -> Iterator[ast.stmt]:
        """Yield the imports, but for those of Python's own library."""
        try:
            tree = ast.parse(code)
        except SyntaxError:
            return
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names = [each.name for each in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [str(node.module)]
            else:
                continue
            # What Python has itself needs no file, and may show something, as `import this` does.
            if sys.stdlib_module_names.isdisjoint(name.split(".")[0] for name in names):
                yield node

    def _open(self, key: str) -> None:
        """Put the outermost folder of a package in place, and note what else there is."""
        needs = self._packages[key]["depends"]
        missing = Missing([self._file(each) for each in (key, *needs) if each not in self._opened])
        for each in needs:
            if not self._packages[each]["imports"] and each not in self._opened:
                try:
                    self._open(each)
                except Missing:
                    raise missing from None
        data = self._read(self._file(key), self._may_wait)
        if data is None:
            raise missing
        self._opened.add(key)
        archive = zipfile.ZipFile(io.BytesIO(data.to_bytes()))
        if self._packages[key]["install_dir"] == "dynlib":
            archive.extractall(LIBRARIES)
            for name in archive.namelist():
                self._link(f"{LIBRARIES}/{name}")
            return
        names = [name for name in archive.namelist() if not name.endswith("/")]
        folders = {os.path.dirname(name) for name in names if "/__init__.py" in name}
        for folder in folders:
            # What only holds packages, without being one, has to be there to be found.
            os.makedirs(os.path.dirname(f"{self._site}/{folder}"), exist_ok=True)
            own = [name for name in names if _package_of(name, folders) == folder]
            self._folded[folder.replace("/", ".")] = archive, own
        archive.extractall(self._site, [n for n in names if not _package_of(n, folders)])

    def _file(self, key: str) -> str:
        return str(self._packages[key]["file_name"])

    def _unfold(self, name: str) -> None:
        archive, names = self._folded.pop(name)
        archive.extractall(self._site, names)
        outer = os.path.dirname(f"{self._site}/{name.replace('.', '/')}")
        finder = sys.path_importer_cache.get(outer)
        if finder is not None:
            finder.invalidate_caches()  # it may have looked in the same millisecond


def _package_of(name: str, folders: set[str]) -> str:
    """Return the innermost package that holds a file; data belong to the package above them."""
    folder = os.path.dirname(name)
    while folder and folder not in folders:
        folder = os.path.dirname(folder)
    return folder
