"""The runtime's files: what is not right is refused by name, and nothing half-written is used."""

import hashlib
import json
import zipfile
from pathlib import Path

import pytest
from robust_slam_autograder.publishing import course as courses

from autograder.tests.as_user import ROOT
from tests.runtime.conftest import RUNTIME, needs_runtime
from tools.runtime import __main__ as door
from tools.runtime import jupyterlite, pyodide, wheels
from tools.runtime.pyodide import RuntimeUnavailable

CONTENT = {"one.wasm": b"one", "two.whl": b"two"}
SUMS = {name: hashlib.sha256(data).hexdigest() for name, data in CONTENT.items()}


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A folder with Pyodide, which is two short files here and is published nowhere."""
    monkeypatch.setattr(pyodide, "checksums", lambda: SUMS)
    monkeypatch.setattr(pyodide, "URL", "http://127.0.0.1:9/")
    folder = tmp_path / "source"
    folder.mkdir()
    for name, data in CONTENT.items():
        (folder / name).write_bytes(data)
    return folder


def fetch(tmp_path: Path, source: Path | None) -> dict[str, bytes]:
    pyodide.fetch(tmp_path / "target", source and str(source))
    return contents(tmp_path)


def contents(tmp_path: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (tmp_path / "target").iterdir()}


def test_a_folder_s_files_are_taken_and_one_that_was_changed_is_replaced(tmp_path, source):
    (tmp_path / "target").mkdir()
    (tmp_path / "target" / "of-an-older-release.whl").touch()
    (tmp_path / "target" / "one.wasm").write_bytes(b"on")
    assert fetch(tmp_path, source) == CONTENT
    assert all(path.stat().st_mode & 0o004 for path in (tmp_path / "target").iterdir())


def test_a_second_run_goes_on_where_the_first_one_stopped(tmp_path, source):
    (source / "two.whl").unlink()
    with pytest.raises(RuntimeUnavailable):
        fetch(tmp_path, source)
    first = tmp_path / "target" / "one.wasm"
    before = first.stat().st_mtime_ns
    (source / "one.wasm").unlink()
    (source / "two.whl").write_bytes(b"two")
    assert fetch(tmp_path, source) == CONTENT and first.stat().st_mtime_ns == before


@pytest.mark.parametrize(
    ("two", "told"),
    [
        (
            b"tw0",
            r"two\.whl: this is not the file of Pyodide .*get it from Pyodide's release again",
        ),
        (None, r"two\.whl: the file is missing; .*PYODIDE"),
    ],
)
def test_another_file_and_a_missing_one_are_named_with_what_to_do(two, told, tmp_path, source):
    (source / "two.whl").unlink()
    if two:
        (source / "two.whl").write_bytes(two)
    with pytest.raises(RuntimeUnavailable, match=told):
        fetch(tmp_path, source)
    assert contents(tmp_path) == {"one.wasm": b"one"}


def test_without_the_folder_or_a_network_it_says_what_to_do(tmp_path, source):
    with pytest.raises(RuntimeUnavailable, match=r"ROBUST_SLAM_PYODIDE names .*no such folder"):
        fetch(tmp_path, source / "nothing")
    with pytest.raises(RuntimeUnavailable, match=r"one\.wasm: .*ROBUST_SLAM_PYODIDE"):
        fetch(tmp_path, None)
    assert contents(tmp_path) == {}


def test_a_run_that_fails_leaves_no_mark_that_all_is_there(tmp_path, monkeypatch):
    (tmp_path / door.READY).touch()
    monkeypatch.setenv(pyodide.FOLDER, str(tmp_path / "nothing"))
    monkeypatch.setattr(door.editor, "build", lambda target: None)  # it waits for a registry
    with pytest.raises(RuntimeUnavailable):
        door.make(runtime=tmp_path)
    assert not (tmp_path / door.READY).exists()


def test_the_labs_notebooks_say_which_python_wrote_them(tmp_path):
    folder = tmp_path / "extensions" / jupyterlite.KERNEL / "static"
    folder.mkdir(parents=True)
    script = folder / "154.js"
    script.write_text(f'info={{name:"python",{jupyterlite.SAYS}"3.8"}},banner:"3.8"')
    jupyterlite.say_python(tmp_path, "3.12.7")
    assert script.read_text().endswith(f'{jupyterlite.SAYS}"3.12.7"}},banner:"3.8"')
    with pytest.raises(RuntimeUnavailable, match="no script of the kernel"):
        jupyterlite.say_python(tmp_path, "3.12.7")


@needs_runtime
class TestMade:
    """What `make runtime` made."""

    def test_each_file_of_pyodide_is_the_one_of_its_own_list(self):
        lock = json.loads((RUNTIME / "pyodide" / wheels.LOCK).read_text(encoding="utf-8"))
        official = {each["file_name"]: each["sha256"] for each in lock["packages"].values()}
        sums = pyodide.checksums()
        packages = {name for name in sums if name.endswith((".whl", ".zip"))}
        packages -= {"python_stdlib.zip"}
        assert len(packages) > 30
        assert {official[name] for name in packages} == {sums[name] for name in packages}
        assert lock["info"]["version"] == pyodide.VERSION
        major, minor, _ = lock["info"]["python"].split(".")
        lab = courses.load(ROOT / "solutions").lab  # what the public does not have
        assert lab in (None, (int(major), int(minor)))
        for name, digest in sums.items():
            data = (RUNTIME / "pyodide" / name).read_bytes()
            assert hashlib.sha256(data).hexdigest() == digest

    @pytest.mark.parametrize("place", ["wheels", "lab"])
    def test_each_added_package_is_there_as_the_list_says(self, place):
        lock = json.loads((RUNTIME / place / wheels.LOCK).read_text(encoding="utf-8"))
        added = [each for each in lock["packages"].values() if "/" in each["file_name"]]
        assert len(added) >= len(wheels.PACKAGES)
        for each in added:
            # The list's addresses start from the site's python/pyodide.
            address = each["file_name"].replace("../../lab/", "../lab/")
            data = (RUNTIME / "pyodide" / address).read_bytes()
            assert hashlib.sha256(data).hexdigest() == each["sha256"]
            assert set(each["depends"]) <= set(lock["packages"])

    def test_the_wheels_that_are_made_here_hold_no_native_code(self):
        lock = json.loads((RUNTIME / "wheels" / wheels.LOCK).read_text(encoding="utf-8"))
        for package in wheels.PACKAGES:
            name = lock["packages"][package.name]["file_name"]
            with zipfile.ZipFile(RUNTIME / "pyodide" / name) as archive:
                names = archive.namelist()
            assert len(names) > 3 and not [n for n in names if n.endswith((".so", ".pyd"))]

    def test_what_pages_load_is_compiled_and_listed_with_its_size(self):
        page = json.loads((RUNTIME / "wheels" / wheels.PAGE_LOCK).read_text(encoding="utf-8"))
        files = {name: each["file_name"] for name, each in page["packages"].items()}
        paths = {name: RUNTIME / "pyodide" / file for name, file in files.items()}
        assert {"numpy", "scipy", "matplotlib", "robust-slam"} <= set(paths)
        assert "ipython" not in paths
        held: list[str] = []
        for name, path in paths.items():
            assert page["packages"][name]["size"] == path.stat().st_size
            with zipfile.ZipFile(path) as archive:
                held += [each for each in archive.namelist() if each[-1] != "/"]
        assert len(held) == len(set(held)), "which of two files stays would be chance"
        own = [paths["robust-slam"], paths["robust-slam-course"]]
        for path in (*own, paths["numpy"], RUNTIME / "wheels" / wheels.PYTHON[1]):
            with zipfile.ZipFile(path) as archive:
                compiled = [n for n in archive.namelist() if n.endswith(".pyc")]
                sources = [n for n in archive.namelist() if n.endswith(".py")]
                data = archive.read(compiled[0])
            # Python 3.12's number, and flags that say: never look at the source.
            assert len(compiled) >= (len(sources) if path in own else 101)
            assert data[:8] == b"\xcb\r\r\n\x01\0\0\0"
