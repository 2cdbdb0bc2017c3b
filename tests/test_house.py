"""The rules of the house that a machine can check."""

import json
import re
import subprocess
from pathlib import Path

import nbformat
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
# The public course has assignments/, the release, in place of solutions/.
ASSIGNMENTS = sorted([*ROOT.glob("solutions/*/*.ipynb"), *ROOT.glob("assignments/*/*.ipynb")])
RELEASED = "assignments/"
"""What the public course holds of a release: zips with the course's packages."""
NOTEBOOKS = [*sorted(ROOT.glob("chapters/*.ipynb")), *ASSIGNMENTS]


def tracked(tmp_path: Path) -> list[str]:
    """What git would track, also where there is no history."""
    git = ["git", f"--git-dir={tmp_path / 'git'}", f"--work-tree={ROOT}"]
    subprocess.run([*git, "init", "-q"], capture_output=True, check=True)
    listing = subprocess.run(
        [*git, "ls-files", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return [name for name in listing.stdout.splitlines() if (ROOT / name).is_file()]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_valid_holds_no_outputs_and_its_cells_have_names_that_stay(path):
    notebook = nbformat.read(path, as_version=nbformat.NO_CONVERT)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert notebook.nbformat == 4 and notebook.nbformat_minor >= 5
    assert all(not cell.outputs and cell.execution_count is None for cell in code)
    assert set(notebook.metadata) <= {"kernelspec", "language_info"}
    ids = [cell["id"] for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[a-z][a-z0-9]*([-_][a-z0-9]+)*", name) for name in ids)
    assert not [name for name in ids if re.fullmatch(r"[0-9a-f]{8,}", name)]


def test_the_lock_file_pins_hashes_and_names_no_index():
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    pins = re.findall(r"^([A-Za-z0-9][\w.-]*)==[^\n]*\\\n((?:    --hash=[^\n]*\n)+)", text, re.M)
    assert len(pins) == len(re.findall(r"^[A-Za-z0-9][\w.-]*==", text, re.M)) > 100
    assert "://" not in text and "--index" not in text


def test_generated_files_and_data_are_not_tracked(tmp_path):
    names = tracked(tmp_path)
    assert len(names) > 100
    assert not [name for name in names if name.endswith((".g2o", ".pyc", ".db"))]
    assert not [name for name in names if name.startswith(("build/", "_build/", ".venv/"))]
    written = [name for name in names if not name.startswith(RELEASED)]
    assert not [name for name in written if (ROOT / name).stat().st_size > 700 * 1024]


PRODUCTS = (
    "lib/robust_slam", "lib/course", "autograder/robust_slam_autograder", "chapters", "solutions",
    "tools", "benchmarks",
)  # fmt: skip


@pytest.mark.parametrize("folder", PRODUCTS)
def test_no_product_imports_tests(folder):
    sources = {path: path.read_text("utf-8") for path in (ROOT / folder).rglob("*.py")}
    wanted = re.compile(r"^\s*(from|import)\s+([\w.]+\.)?tests\b|\.tests\b.* import", re.M)
    assert not [path for path, text in sources.items() if wanted.search(text)]
    assert sources or not (ROOT / folder).exists()


def test_the_readme_names_the_chapters_and_make_targets_that_exist():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    toc = yaml.safe_load((ROOT / "_toc.yml").read_text(encoding="utf-8"))
    files = re.findall(r"chapters/(\d\d)-", json.dumps(toc))
    assert files == sorted(path.stem[:2] for path in ROOT.glob("chapters/[0-9]*.ipynb"))
    assert not [number for number in files if f"{number} *" not in readme]
    makefiles = [ROOT / "Makefile", *ROOT.glob("*.mk")]
    makefile = "\n".join(path.read_text(encoding="utf-8") for path in makefiles)
    named = set(re.findall(r"(?:^|`)make ([a-z]+)", readme, re.M))
    assert {"book", "test"} <= named
    assert not [name for name in named if not re.search(rf"^{name}:", makefile, re.M)]
