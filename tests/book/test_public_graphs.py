"""Chapters 03 and 08 with and without the public graphs: what they say is what they computed."""

import os
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import nbformat
import pytest
from jupyter_cache import get_cache
from nbclient import NotebookClient
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_output
from robust_slam.files import datasets
from robust_slam_course.results import read_results
from robust_slam_course.text import CHANGED

from autograder.tests.kernel import leave_out
from chapters._ext import notebooks
from tests.book import prose

NUMBER = re.compile(r"(?<![\w.^])\d+\.\d+|(?<![\w.^])\d{2,}(?!\.?\w)")


@dataclass(frozen=True)
class Section:
    """A section that shows a public graph, and numbers that its text must have.

    They were computed apart from the page; ``derived`` are numbers that no cell prints.
    """

    notebook: str
    graph: str
    cells: str
    with_graph: frozenset[str]
    without: frozenset[str]
    derived: frozenset[str]


SECTIONS = (
    Section(
        "03-irls",
        "intel",
        "intel-.*",
        frozenset({"785", "19.57", "4.12", "0.05", "7.04", "7.01", "0.10"}),
        frozenset({"20", "9.96", "4.32", "0.03", "1.77", "0.05"}),
        frozenset({"2.666"}),
    ),
    Section(
        "08-showcase",
        "CSAIL",
        "public.*",
        frozenset({"128", "12.59", "0.04", "4747.1", "5083.2"}),
        frozenset({"40", "1.55", "0.14", "1345.4", "1377.2"}),
        frozenset({"4.93"}),  # 2.666² ln 2
    ),
)
SWEEP = Section("what-the-measurements-support", "intel", "larger-(load|read)", *[frozenset()] * 3)
HERE = (True, False)
each_section = pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.notebook)
each_way = pytest.mark.parametrize("here", HERE, ids=("with", "without"))


def cells(section: Section) -> list[NotebookNode]:
    """The cells of the section, as they are committed."""
    notebook = nbformat.read(prose.CHAPTERS / f"{section.notebook}.ipynb", as_version=4)
    return [cell for cell in notebook.cells if re.fullmatch(section.cells, cell.id)]


@cache
def ran(section: Section, here: bool, empty: Path) -> SimpleNamespace:
    """What the section prints, and what it says in text and captions."""
    path = prose.CHAPTERS / f"{section.notebook}.ipynb"
    notebook = nbformat.read(path, as_version=4)
    wanted = f"imports|{section.cells}"
    if here == datasets.is_here(section.graph):  # as the book has run
        cache = get_cache(notebooks.run_here([path]).parent)
        _, notebook = cache.merge_match_into_notebook(notebook)
    kept = [cell for cell in notebook.cells if re.fullmatch(wanted, cell.id)]
    if here != datasets.is_here(section.graph):
        earlier = "from robust_slam.estimators.thresholds import *\n"
        earlier += "C = chi_square_threshold(0.99, 3)"
        notebook.cells = [new_code_cell(earlier), *kept]
        environment = os.environ | {"MPLCONFIGDIR": matplotlib.get_configdir()}
        environment |= {datasets.FOLDER: str(empty), "XDG_CACHE_HOME": str(empty)}
        resources = {"metadata": {"path": str(prose.CHAPTERS)}}
        NotebookClient(notebook, timeout=300, resources=resources).execute(env=environment)
    outputs = [(cell.id, out) for cell in kept for out in cell.get("outputs", [])]
    words = [out.metadata["mystnb"] for _, out in outputs if "mystnb" in out.get("metadata", {})]
    said = {
        name: out.data["text/markdown"]
        for name, out in outputs
        if "text/markdown" in out.get("data", {})
    }
    return SimpleNamespace(
        printed="".join(out.text for _, out in outputs if out.output_type == "stream"),
        text="\n".join(v for name, v in said.items() if re.fullmatch(section.cells, name)),
        sweep=said.get("larger-read", ""),
        captions=[word["figure"]["caption"] for word in words],
        alts=[word["image"]["alt"] for word in words],
    )


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A function (section, here) -> what the section says, each run once."""
    empty = tmp_path_factory.mktemp("empty")

    def run(section: Section, here: bool) -> SimpleNamespace:
        if here and not datasets.is_here(section.graph):
            leave_out(f"the public graph {section.graph} is not on this machine")
        return ran(section, here, empty)

    return run


def numbers(text: str) -> set[str]:
    return set(NUMBER.findall(re.sub(r"\]\([^)]*\)", "]", text)))  # without addresses


@pytest.mark.rest
@each_way
@each_section
def test_every_number_of_the_text_was_printed(section, here, page):
    """A kernel starts and runs the section, which makes several maps of a graph."""
    shown = page(section, here)
    assert CHANGED not in shown.printed
    said = numbers("\n".join([shown.text, *shown.captions, *shown.alts]))
    assert said - section.derived <= numbers(shown.printed)
    assert said >= (section.with_graph if here else section.without)


@pytest.mark.rest
@each_section
def test_without_the_graph_one_sentence_says_so_and_no_other_names_it(section, page):
    shown = page(section, False)
    name = section.graph.replace("i", "I", 1)
    (sentence,) = [s for s in re.split(r"(?<=\.) ", shown.text) if name in s]
    assert sentence.startswith(f"The public graph {name} is not on this machine (`make data`")
    assert sentence.endswith("so this section shows a generated town instead.")
    assert all(caption.startswith("A generated town") for caption in shown.captions)
    assert all("a generated town" in alt for alt in shown.alts)
    assert name not in "".join([*shown.captions, *shown.alts, shown.printed])


@pytest.mark.rest
@each_section
def test_with_the_graph_the_text_and_the_captions_name_it(section, page):
    shown = page(section, True)
    name = section.graph.replace("i", "I", 1)
    assert f"This is the public graph {name}" in shown.text
    assert all(caption.startswith(f"The public graph {name}") for caption in shown.captions)
    assert "generated" not in "".join([shown.text, *shown.captions, *shown.alts])


@each_section
def test_what_does_not_depend_on_the_graph_claims_nothing_about_it(section):
    static = [cell for cell in cells(section) if cell.cell_type == "markdown"]
    captions = [cell.metadata.get("mystnb", {}) for cell in cells(section)]
    assert static
    assert not [cell for cell in static if re.search("intel|csail", cell.source, re.I)]
    assert not [c for c in captions if "image" in c or "caption" in c.get("figure", {})]


@pytest.mark.rest
@each_way
def test_the_sweep_says_of_intels_odometry_what_it_computed(here, page):
    shown = page(SWEEP, here)
    results = read_results(prose.CHAPTERS / "data" / "robustness.csv")
    good, runs = results.good(method="PCM + GNC-TLS", graph="CSAIL")
    assert f"{good} of {runs} worlds of CSAIL" in " ".join(shown.sweep.split())
    assert ("root mean square of 0.13" in shown.sweep) == here
    assert ("Why is Intel different" in shown.sweep) == here


def test_the_rest_of_a_chapter_prints_no_number_of_a_public_graph():
    for section in SECTIONS:
        static = prose.Chapter(section.notebook).text
        sentences = re.split(r"(?<=[.:;])\s", static)
        named = [s for s in sentences if re.search(r"\b(Intel|CSAIL)\b", s)]
        assert not [s for s in named if prose.decimals(s)]


def rendered(outputs: list[NotebookNode]) -> dict[str, object]:
    """The words of a figure that myst-nb is handed, from a cell that names it."""
    token = SimpleNamespace(meta={"metadata": {"mystnb": {"figure": {"name": "fig-a"}}}})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(notebooks, "RENDER", lambda *_: None)
        notebooks.rendered(None, token, outputs)
    return token.meta["metadata"]["mystnb"]


def test_the_words_of_an_output_join_those_of_its_cell():
    words = {"figure": {"caption": "A town."}, "image": {"alt": "A map."}}
    own = new_output("display_data", metadata={"mystnb": words})
    plain = new_output("stream", text="1 pose")
    figure = {"name": "fig-a", "caption": "A town."}
    assert rendered([plain, own]) == {"figure": figure, "image": {"alt": "A map."}}
    assert rendered([plain]) == {"figure": {"name": "fig-a"}}
