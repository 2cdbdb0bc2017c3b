"""The scripts of a live picture as one text: its modules, in order of dependency.

A browser loads no module from a file, so a page carries the script itself. The modules are
written for this: imports are static and named, and a name is used by one module only, so that
a line of import can be left out and the word ``export`` with it.

Documentation, comments and indents stay in the modules: they would be more than a quarter of
what a page loads.
"""

import re
from functools import cache
from importlib.resources import files
from posixpath import dirname, join, normpath

COURSE = files("robust_slam_course")
_IMPORT = re.compile(r'^import\s*\{[^}]*\}\s*from\s*"(\.[^"]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:function|const|class)\b)", re.MULTILINE)
_ASIDE = re.compile(r"""\s+// [^\n"'`]*$|(?<=[{\n])\n""", re.MULTILINE)
"""A comment behind code, an empty line, and the end of one that opens a block."""
_DOCUMENTATION = re.compile(r"^ *(?:/\*\*.*?\*/\n|//[^\n]*\n)?", re.MULTILINE | re.DOTALL)


@cache
def bundle(name: str) -> str:
    """Return the script of the picture ``name``: a scope that defines ``render``.

    Raises:
        FileNotFoundError: there is no such picture, or a module imports one that is not there.
        ValueError: a module has an import or export of a form that cannot be bundled.
    """
    return "\n".join(modules(name).values())


def modules(name: str) -> dict[str, str]:
    """Return the paths and bodies of the picture's modules in order of dependency.

    Raises:
        FileNotFoundError: as ``bundle``.
        ValueError: as ``bundle``.
    """
    done: dict[str, str] = {}
    known = (f"pictures/{name}.js", f"pictures/{name}/{name}.js")
    _add(next((path for path in known if (COURSE / path).is_file()), known[0]), done)
    return done


def _add(path: str, done: dict[str, str]) -> None:
    """Add the module ``path``, after those that it imports."""
    if path in done:
        return
    source = (COURSE / path).read_text(encoding="utf-8")
    for imported in _IMPORT.findall(source):
        _add(normpath(join(dirname(path), imported)), done)
    body = _EXPORT.sub("", _IMPORT.sub("", _DOCUMENTATION.sub("", source)))
    body = _ASIDE.sub("", body)
    if re.search(r"^(import|export)\b", body, re.MULTILINE):
        raise ValueError(
            f'{path}: write imports as import {{ a, b }} from "./c.js"; and exports as'
            " export function, const or class; other forms cannot be bundled."
        )
    done[path] = body
