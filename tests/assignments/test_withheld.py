"""What an assignment withholds is closed: no other module of the library leads to it."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIB = ROOT / "lib" / "robust_slam"
CONFIGS = sorted(ROOT.glob("solutions/*/autograder.toml"))


def module_name(path: Path) -> str:
    parts = path.relative_to(LIB.parent).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


def imports(path: Path) -> set[str]:
    """Every module of the library that a file names in an import statement."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("robust_slam"):
            found |= {str(node.module)} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


IMPORTS = {module_name(path): imports(path) for path in LIB.rglob("*.py")}


def inside(name: str, withheld: list[str]) -> bool:
    return any(name == one or name.startswith(f"{one}.") for one in withheld)


@pytest.mark.parametrize("config", CONFIGS, ids=lambda path: path.parent.name)
def test_no_module_that_is_left_imports_one_that_is_withheld(config: Path) -> None:
    withheld = tomllib.loads(config.read_text(encoding="utf-8"))["withheld"]
    assert withheld
    assert {name for name in withheld if name not in IMPORTS} == set()
    left = {name: names for name, names in IMPORTS.items() if not inside(name, withheld)}
    leaks = {name for name, names in left.items() if any(inside(one, withheld) for one in names)}
    assert not leaks
