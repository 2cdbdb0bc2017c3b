"""The API page: every public name is on it, and its twins in GTSAM print what they print."""

import doctest
import re

import pytest
import robust_slam as rs
from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, GoogleDocstring

from chapters._ext import notebooks
from tests.book import prose

PAGE = prose.CHAPTERS / "api.md"
MODULES = {"breaking", "cli", "drawing", "progress", "solver"}
FOLDERS = (
    "estimators",
    "graphs",
    "descent",
    "consistency",
    "certificates",
    "factors",
    "fleet",
    "incremental",
)


def test_the_twins_in_gtsam_give_the_same_results():
    blocks = re.findall(r"^```python\n(>>>.*?)^```$", PAGE.read_text("utf-8"), re.M | re.S)
    assert len(blocks) == 5
    test = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, PAGE.name, str(PAGE), 0)
    result = doctest.DocTestRunner().run(test)
    assert result.failed == 0 and result.attempted > 20


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_folder_has_a_section_with_all_of_its_names(folder):
    assert f".. automodule:: robust_slam.{folder}\n   :members:" in PAGE.read_text("utf-8")
    assert getattr(rs, folder).__all__


def test_every_short_name_of_the_library_is_on_the_page():
    listed = set(re.findall(r"robust_slam\.([a-zA-Z_]+)", PAGE.read_text("utf-8")))
    assert {name for name in rs.__all__ if not name.startswith("_")} - listed <= MODULES


def test_a_property_keeps_its_words_on_both_sides_of_a_colon():
    lines = ["The edges that were kept: what another program should get."]
    written = list(lines)
    notebooks.keep_whole(Sphinx.__new__(Sphinx), "property", "", None, None, written)
    read = GoogleDocstring(written, Config(), what="property", name="clean").lines()
    assert lines[0] in read and not any(line.startswith(":type:") for line in read)
