"""The course as students and the public may have it: no solution, no hidden test, no history.

Only files that git tracks and ``course.toml`` lists are copied, and the student release
stands beside them. The copy is looked at before it is put in its place: no telling line of
a solution or a hidden test, and no module that imports one which stays private.
"""

from __future__ import annotations

import ast
import json
import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing import secret_lines, staging
from robust_slam_autograder.publishing.course import COURSE_NAME, Course, Public, Repository, load
from robust_slam_autograder.publishing.files import chosen, tracked
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading import assignment as assignments

_INSTALL = """\
# Where the course's library is missing, as in Colab, install it.
import sys
from importlib.util import find_spec

if {missing}:
    if sys.version_info < {python}:  # noqa: UP036
        # Pip would look for older packages for many minutes.
        have = ".".join(map(str, sys.version_info[:2]))
        raise ImportError(f"The library needs a newer Python than {{have}}.")
{lines}
    if {missing}:
        raise ImportError(
            "The library was not installed. The lines above say whether the "
            "reason is the network or the address."
        )"""


def publish(tree: Path, out: Path) -> list[str]:
    """Write the public course; what was in ``out`` is replaced as a whole.

    Args:
        tree: the instructor's source tree; the course is the folder that it is in.
        out: the folder to write.

    Returns:
        the files that were written, below ``out``.

    Raises:
        WrongUse: ``course.toml`` is wrong, or ``out`` is in use.
        GraderFailure: the copy would tell what is private, or cannot be made; ``out`` stays.
    """
    course = load(tree)
    if course.public is None:
        raise WrongUse(f"{tree / COURSE_NAME} has no [public]: it lists what the public may have.")
    public = course.public
    _refuse_in_use(course, public.assignments, out)
    names = chosen(public, tracked(course.root), tree / COURSE_NAME)
    with staging.made_beside(out) as part:
        made = part / out.resolve().name
        for name in names:
            _copy(course.root / name, made / name)
        if public.readme:
            _copy(tree / public.readme, made / "README.md")
        release(tree, [], made / public.assignments)
        _add_install_cells(made / public.book, course)
        _look_for_secrets(tree, made, public)
        _refuse_private_imports(course.root, made)
        written = sorted(p.relative_to(made).as_posix() for p in made.rglob("*") if p.is_file())
        staging.put(made, out.resolve())
    return written


def _refuse_in_use(course: Course, released: str, out: Path) -> None:
    """Only a public course, an empty folder or nothing may stand where one is written."""
    target = out.resolve()
    if course.root.is_relative_to(target) or target.is_relative_to(course.tree.resolve()):
        raise WrongUse(f"{out} holds the course's own files: --out DIR.")
    if not target.exists():
        return
    if not target.is_dir() or (target / ".git").exists() or (target / course.tree.name).exists():
        raise WrongUse(f"{out} is a repository, or no folder: write elsewhere, --out DIR.")
    if any(target.iterdir()) and not (target / released).is_dir():
        raise WrongUse(f"{out} holds something else than a public course: --out DIR.")


def _copy(source: Path, target: Path) -> None:
    if source.is_symlink() or not source.is_file():
        raise GraderFailure(f"{source} is no plain file: nothing written.")
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(source.read_bytes())
    target.chmod(0o755 if os.access(source, os.X_OK) else 0o644)


def _add_install_cells(book: Path, course: Course) -> None:
    packages = course.install.book
    if course.repository.url and packages:
        for path in sorted(book.glob("*.ipynb")):
            value = json.loads(path.read_text(encoding="utf-8"))
            kinds = [cell["cell_type"] for cell in value["cells"]]
            if "code" in kinds:
                python = max(_python(course.root / folder) for folder in packages.values())
                cell = install_cell(packages, course.repository, python)
                value["cells"].insert(kinds.index("code"), cell)
            text = json.dumps(value, indent=1, ensure_ascii=False)
            path.write_text(f"{text}\n", encoding="utf-8")


def _python(folder: Path) -> tuple[int, int]:
    """Return the oldest Python that a package takes."""
    about = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))
    found = re.search(r">=\s*(\d+)\.(\d+)", about["project"].get("requires-python", ""))
    return (int(found[1]), int(found[2])) if found else (3, 0)


def install_cell(
    packages: Mapping[str, str], repository: Repository, python: tuple[int, int]
) -> dict[str, Any]:
    """A cell that installs packages which are missing; the book does not show it."""
    modules = [package.split("[")[0].replace("-", "_") for package in packages]
    lines = []
    for package, folder in packages.items():
        name, where = repository.requirement(package, folder).split(" @ ")
        # IPython puts the value in: the address makes a long line, and has one of its own.
        lines += [f'    where = "{where}"', f'    %pip install -q "{name} @ {{where}}"']
    missing = f"None in map(find_spec, {json.dumps(modules)})"
    source = _INSTALL.format(missing=missing, python=python, lines="\n".join(lines))
    return {
        "cell_type": "code",
        "execution_count": None,
        "id": "install",
        "metadata": {"tags": ["remove-cell"]},
        "outputs": [],
        "source": source.splitlines(keepends=True),
    }


def _look_for_secrets(tree: Path, made: Path, public: Public) -> None:
    """Look for lines of solutions and hidden tests in the copy, but for those that are known."""
    secrets: dict[str, str] = {}
    for name in assignments.find_names(tree):
        found = secret_lines.secrets_of(assignments.notebook_path(tree / name))
        secrets |= dict.fromkeys(found, name)
    everywhere = {line for lines in public.known.values() for line in lines}
    # Archives last: they hold copies, and a file is easier to change than an archive.
    files = sorted(secret_lines.lines_below(made), key=lambda file: file[0].endswith(".zip"))
    for path, lines in files:
        # An assignment's archive holds the packages' files too.
        is_archive = path.startswith(f"{public.assignments}/") and path.endswith(".zip")
        known = everywhere if is_archive else set(public.known.get(path, ()))
        for line in sorted(lines & secrets.keys() - known):
            raise GraderFailure(
                f"{path} would tell a line of a solution or a hidden test of {secrets[line]} "
                f"({line}): leave the file out in {COURSE_NAME}, change one of the two, or list "
                "the line there under [public.known] if it tells nothing. Nothing written."
            )
    if any(part.name == tree.name for part in made.iterdir()):
        raise GraderFailure(f"The public course would hold {tree.name}: nothing written.")


def _refuse_private_imports(root: Path, made: Path) -> None:
    """Refuse a copy in which a module imports a file of the course that was not copied."""
    seen: set[tuple[str, ...]] = set()
    for path in sorted(made.rglob("*.py")):
        name = path.relative_to(made)
        found = _imported(path.read_text(encoding="utf-8"), name.parent.parts)
        for module in dict.fromkeys(module for module in found if module not in seen):
            seen.add(module)
            for file in _files_of(module):
                if (root / file).is_file() and not (made / file).is_file():
                    raise GraderFailure(
                        f"{name} imports {file}, which stays private: leave both out in "
                        f"{COURSE_NAME}, or none. Nothing written."
                    )


def _imported(source: str, package: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Yield the modules that a file of a package may import, each as the parts of its name."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            module = (*above, *(node.module.split(".") if node.module else ()))
            yield module
            yield from ((*module, alias.name) for alias in node.names)


def _files_of(module: tuple[str, ...]) -> Iterator[str]:
    """Yield where a module and the packages that it is in would stand."""
    for end in range(1, len(module) + 1):
        path = "/".join(module[:end])
        yield f"{path}/__init__.py"
        yield f"{path}.py"
