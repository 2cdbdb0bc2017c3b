"""What an assignment withholds is closed: no other module of the library leads to it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = sorted(ROOT.glob("solutions/*/autograder.toml"))
IMPORTS = grimp.build_graph("robust_slam", "robust_slam_course", cache_dir=None)


def inside(name: str, withheld: list[str]) -> bool:
    return any(f"{name}.".startswith(f"{one}.") for one in withheld)


@pytest.mark.parametrize("config", CONFIGS, ids=lambda path: path.parent.name)
def test_no_module_that_is_left_imports_one_that_is_withheld(config: Path) -> None:
    withheld = tomllib.loads(config.read_text(encoding="utf-8"))["withheld"]
    assert withheld
    assert set(withheld) <= IMPORTS.modules
    left = {name for name in IMPORTS.modules if not inside(name, withheld)}
    found = {name: IMPORTS.find_modules_directly_imported_by(name) for name in left}
    assert not [name for name in left if any(inside(one, withheld) for one in found[name])]
