"""Notebooks that have changed run once, several at a time, and one that fails is not kept."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import nbformat
import pytest
from jupyter_cache import get_cache
from robust_slam.solver import Support

from chapters._ext import names, notebooks
from tests.book import prose

pytestmark = pytest.mark.rest

PRINTS = "print({0}); open('runs.txt', 'a').write('{0} ')"
DEFINES = """
import functools, threading, matplotlib.pyplot as plt

sizes, drawn, cannot = [3], plt.figure(), threading.Lock()
total = functools.cache(lambda x: x + sum(sizes))
"""
SOURCES = {"one": PRINTS.format(1), "two": PRINTS.format(2), "fails": "1 / 0"}


def write(path: Path, source: str) -> Path:
    cell = {"cell_type": "code", "id": "a", "metadata": {}, "source": source}
    cell |= {"outputs": [], "execution_count": None}
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    value = {"nbformat": 4, "nbformat_minor": 5, "metadata": {"kernelspec": kernel}}
    path.write_text(json.dumps(value | {"cells": [cell]}))
    return path


def test_what_has_changed_is_run_and_what_fails_is_not_kept(tmp_path):
    """Four notebooks run, and a kernel starts for each."""
    paths = {name: write(tmp_path / f"{name}.ipynb", text) for name, text in SOURCES.items()}
    paths["text"] = tmp_path / "text.md"
    config = SimpleNamespace(
        execution_mode="cache",
        execution_cache_path=str(tmp_path / "cache"),
        execution_timeout=60,
        execution_allow_errors=False,
    )
    book = SimpleNamespace(mystnb_config=config, doc2path=lambda name: str(paths[name]))
    notebooks.execute(None, book, list(paths))
    cache = get_cache(config.execution_cache_path)
    for name, printed in (("one", "1\n"), ("two", "2\n")):
        _, kept = cache.merge_match_into_notebook(nbformat.read(paths[name], as_version=4))
        assert kept.cells[0].outputs[0]["text"] == printed
    with pytest.raises(KeyError):
        cache.match_cache_notebook(nbformat.read(paths["fails"], as_version=4))
    write(paths["one"], PRINTS.format(3))
    notebooks.execute(None, book, ["one", "two", "text"])
    assert sorted((tmp_path / "runs.txt").read_text().split()) == ["1", "2", "3"]


def test_names_are_kept_as_they_were_after_each_cell(tmp_path):
    sources = (DEFINES, "", "sizes.append(4)")
    cells = [nbformat.v4.new_code_cell(source) for source in sources]
    kernel = {"kernelspec": {"display_name": "Python 3", "name": "python3"}}
    page, cache = tmp_path / "page.ipynb", tmp_path / "cache"
    nbformat.write(nbformat.v4.new_notebook(cells=cells, metadata=kernel), page)
    notebooks.run([str(page)], str(cache), 60)
    first, blank, last = map(dict, names.kept(cache / names.BESIDE, sources))
    assert first["sizes"] == blank["sizes"] == [3] and first["total"](2) == 5
    assert last["sizes"] == [3, 4]
    assert first["drawn"] is None and "cannot" not in first
    with pytest.raises(FileNotFoundError):
        list(names.kept(cache / names.BESIDE, ["sizes = []"]))


def test_the_page_of_a_robot_runs_with_the_library_alone(monkeypatch):
    for name in ("IPython", "robust_slam_course", "robust_slam_course.style"):
        monkeypatch.setitem(sys.modules, name, None)
    page = prose.Chapter("from-your-robot")
    assert page.run(*page.programs)["answer"].support is Support.UNIQUE
