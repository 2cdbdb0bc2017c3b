"""The API page: every public name is on it, and its twins in GTSAM print what they print."""

import doctest
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys

import pytest
import robust_slam as rs
from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, GoogleDocstring

from chapters._ext import notebooks
from tests.book import prose

PAGE = prose.CHAPTERS / "api.md"
MODULES = {"cli", "drawing", "progress", "solver"}
FOLDERS = (
    *("estimators", "graphs", "groups", "files", "descent", "consistency", "certificates"),
    *("factors", "fleet", "incremental"),
)

EXAMPLES = "\n".join(
    re.findall(r"^```python\n(>>>.*?)^```$", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
)


def test_the_examples_and_the_twins_in_gtsam_print_what_they_say():
    test = doctest.DocTestParser().get_doctest(EXAMPLES, {}, PAGE.name, str(PAGE), 0)
    result = doctest.DocTestRunner().run(test)
    assert result.failed == 0 and result.attempted > 90


@pytest.mark.parametrize("folder", ["", *FOLDERS, "problems"])
def test_each_name_has_an_example_that_is_run(folder):
    found = getattr(rs, folder) if folder else rs
    names = dir(found) if hasattr(found, "__all__") else vars(found)
    values = {name: getattr(found, name) for name in names if not name.startswith("_")}
    own = {
        name: value
        for name, value in values.items()
        if name in getattr(found, "__all__", ())
        or getattr(value, "__module__", "") == found.__name__
    }
    assert own
    for name, value in own.items():
        if not inspect.ismodule(value):
            assert ">>>" in (value.__doc__ or "") or re.search(rf"\b{name}\b", EXAMPLES), name


@pytest.mark.parametrize("folder", ["", *FOLDERS])
def test_what_is_listed_is_there_and_in_a_section_and_a_name_elsewhere_is_told(folder):
    found = getattr(rs, folder) if folder else rs
    listed = {name for name in found.__all__ if not name.startswith("_")}
    assert listed <= set(dir(found))
    assert all(getattr(found, name) is not None for name in listed)
    name = "gnc" if folder == "certificates" else "certify"
    with pytest.raises(AttributeError, match=rf"has no {name}; it is robust_slam\.[a-z]+\.{name}"):
        getattr(found, name)
    section = f".. automodule:: robust_slam.{folder}\n   :members:"
    assert not folder or (listed and section in PAGE.read_text("utf-8"))


def test_every_short_name_of_the_library_is_on_the_page():
    listed = set(re.findall(r"robust_slam\.([a-zA-Z_]+)", PAGE.read_text("utf-8")))
    assert {name for name in rs.__all__ if not name.startswith("_")} - listed <= MODULES


def test_what_a_public_docstring_cites_is_public():
    modules = [rs, *(getattr(rs, folder) for folder in FOLDERS)]
    public = {name: getattr(module, name) for module in modules for name in module.__all__}
    shown = set(re.findall(r"\.\. auto.*\.(\w+)$", PAGE.read_text("utf-8"), re.MULTILINE))
    hidden = {
        name
        for info in pkgutil.walk_packages(rs.__path__, "robust_slam.")
        for name, value in vars(importlib.import_module(info.name)).items()
        if getattr(value, "__module__", info.name) == info.name and not inspect.ismodule(value)
    } - {*public, *shown, *dir(rs.problems), *dir(rs.estimators.kernels)}
    for name, value in public.items():
        told = callable(value) and value is not rs.files.GraphFileError
        own = {*dir(value), *(inspect.signature(value).parameters if told else ())}
        cited = re.findall(r"``(?:\w+\.)*(\w+)``", value.__doc__ or "")
        assert not set(cited) & hidden - own, name


def test_names_of_earlier_releases_are_the_same_things():
    for module in ("datasets", "formats", "g2o", "graph_file", "gtsam_graph", "trajectories"):
        now = importlib.import_module(f"robust_slam.files.{module}")
        assert importlib.import_module(f"robust_slam.graphs.{module}") is now
    for module in ("group", "se2", "se3"):
        now = importlib.import_module(f"robust_slam.groups.{module}")
        assert importlib.import_module(f"robust_slam.graphs.{module}") is now
    assert set(rs.files.__all__) | {"se2", "se3"} <= set(rs.graphs.__all__)
    command = [sys.executable, "-m", "robust_slam.graphs.datasets", "--try"]
    ran = subprocess.run(command, env={"CI": "1"}, capture_output=True, check=True)
    assert not ran.stderr


def test_a_property_keeps_its_words_on_both_sides_of_a_colon():
    lines = ["The edges that were kept: what another program should get."]
    written = list(lines)
    notebooks.keep_whole(Sphinx.__new__(Sphinx), "property", "", None, None, written)
    read = GoogleDocstring(written, Config(), what="property", name="clean").lines()
    assert lines[0] in read and not any(line.startswith(":type:") for line in read)
