"""What formgrader and feedback show: the student's text, how each case went, and nothing live."""

import json
import resource
import sys
from pathlib import Path
from typing import Any

import nbformat
import pytest
from bs4 import BeautifulSoup
from nbformat.v4 import new_code_cell, new_output
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.nbgrader import graded_notebook
from robust_slam_autograder.nbgrader.safe_markdown import LONGEST, as_html, code_as_html
from robust_slam_autograder.nbgrader.steps import HideTests
from robust_slam_autograder.reading.assignment import Assignment

from .. import toy
from ..as_user import ended
from ..reports.samples import case, exercise, result
from . import course as course_of

pytestmark = pytest.mark.rest


@pytest.fixture
def tests():
    return course_of.with_text()


def graded(message: str) -> Result:
    cases = case("by-hand", points=4, visible=True), case("random", message, points=6)
    return result(exercise("double", "partial", *cases))


def build(tests: Assignment, value: dict[str, Any], made: Result | None = None) -> dict[str, Any]:
    """The page's cells by grade id; the student's own under their texts."""
    data = json.dumps(value).encode()
    handed = Submission("ada", tests, Path(), "ada.ipynb", data)
    page = graded_notebook.build(handed, made or graded("Try it."))
    nbformat.validate(page)
    return {c.metadata.get("nbgrader", {}).get("grade_id") or c.source: c for c in page.cells}


def test_each_case_says_how_it_went(tests):
    cells = build(tests, course_of.answer(), graded("Try \x1b[31mit."))
    said = {name: cell.outputs[0].text for name, cell in cells.items() if cell.get("outputs")}
    assert said == {
        "double-by-hand": "✓ passed: 4 of 4 points\n",
        "double-random": "✗ failed: 0 of 6 points\nTry \\x1b[31mit.\n",
        "apply-by-hand": "✗ not run: 0 of 5 points\n",
        "apply-twice": "✗ not run: 0 of 5 points\n",
    }


def test_missing_cells_come_where_they_belong(tests):
    names = [cell.grade_id for cell in tests.marked]
    assert [name for name in build(tests, toy.answer()) if name in names] == names
    alone = build(tests, toy.notebook([toy.cell(toy.APPLY, "apply", solution=True)]))
    assert [name for name in alone if name in names] == names


def test_metadata_and_outputs_are_the_instructors(tests):
    value = course_of.answer()
    for cell in value["cells"]:
        cell["metadata"]["tags"] = ["skip-execution"]
        cell["metadata"].get("nbgrader", {}).update(points=99, locked=False, schema_version=9)
        if cell["cell_type"] == "code":
            forged = {"text/html": "<script>1</script>"}
            cell["outputs"] = [{"output_type": "display_data", "data": forged, "metadata": {}}]
    for name, cell in build(tests, value).items():
        assert list(cell.metadata) in ([], ["nbgrader"]), name
        assert "script" not in json.dumps(cell.get("outputs", []))
    assert build(tests, value)["why"].metadata.nbgrader.points == 3


def test_test_cells_are_the_instructors_and_show_no_hidden_line(tests):
    value = toy.answer()
    value["cells"][2]["source"] = "assert True"
    cells = build(tests, value)
    assert cells["double-by-hand"].source == toy.DOUBLE_VISIBLE
    assert toy.CANARY not in json.dumps(cells) and course_of.SCHEME not in json.dumps(cells)


def test_an_answer_without_its_grade_id_is_shown_as_the_answer(tests):
    source = "def double(x):\n    return x + x\n"
    assert build(tests, toy.notebook([toy.cell(source)]))["double"].source == source


def test_of_copied_cells_the_last_is_the_answer(tests):
    value = toy.answer()
    value["cells"].append(toy.cell("def double(x):\n    return 2\n", "double", solution=True))
    cells = build(tests, value)
    assert cells["double"].source == "def double(x):\n    return 2\n"
    assert not cells[toy.DOUBLE].metadata


@pytest.mark.parametrize("kind", ["raw", "html", "raw\n<b>"])
def test_raw_cells_are_shown_as_code(tests, kind):
    cell = toy.cell("<script>alert(1)</script>") | {"cell_type": kind}
    assert build(tests, toy.notebook([cell]))[cell["source"]].cell_type == "code"


LIVE = [
    "<script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "<a href='javascript:alert(1)'>x</a>",
    "[x](javascript:alert(1))",
    "[x](JaVaScRiPt&colon;alert(1))",
    "[x](data:text/html;base64,PHNjcmlwdD4=)",
    "![x](https://example.org/pixel.png)",
    "<svg onload=alert(1)>",
    "<iframe srcdoc='<script>alert(1)</script>'></iframe>",
    "<span class='full-credit' id='why'>x</span>",
    "<form action=/formgrader/api/grade/1><input name=x></form>",
    "<style>body { display: none }</style>",
    "$<img src=x onerror=alert(1)>$",
    "```\n</code><script>alert(1)</script>\n```",
    "x <!-- --><script>alert(1)</script>",
    "<details ontoggle=alert(1) open>x</details>",
]


@pytest.mark.parametrize("text", LIVE)
def test_nothing_in_a_students_markdown_comes_to_life(text):
    html = as_html(text)
    elements = BeautifulSoup(html, "html.parser").find_all(True)
    assert {element.name for element in elements} <= {"p", "a", "code", "pre"}
    attributes = {(name, value) for e in elements for name, value in e.attrs.items()}
    assert not {(name, value) for name, value in attributes if name not in ("href", "title")}
    assert not [value for _, value in attributes if not value.startswith("http")]


def test_markup_and_formulas_stay():
    html = as_html("# Why\n\nBecause $a < b$ and **so**.\n\n| x | y |\n|---|---|\n| 1 | `2` |\n")
    for part in ("$a &lt; b$", "<strong>so</strong>", "<td>1</td>", "<code>2</code>", "Why"):
        assert part in html
    assert "¶" not in html


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Mine: ![image.png](attachment:image.png)", "picture left out: image.png"),
        ("![](attachment:a&b.png)", "picture left out: attachment:a&amp;b.png"),
        ("![my *plot*](plot.png)", "picture left out: my <em>plot</em>"),
        (f"![plot](data:image/png;base64,{'A' * 10**6})", "picture left out: plot"),
        ("[![a](attachment:b)](http://c.org)", "picture left out: a"),
    ],
)
def test_a_picture_is_left_out_and_the_text_stays(text, said):
    html = as_html(f"**Before** {text} after")
    assert said in html and "<strong>Before</strong>" in html and "after" in html
    assert len(html) < 500 and not BeautifulSoup(html, "html.parser").find("img")


def test_a_fenced_block_is_shown_as_it_is():
    html = as_html("```html+jinja\n{{ x < 1 }}\n```")
    assert BeautifulSoup(html, "html.parser").pre.get_text() == "{{ x < 1 }}\n"


def test_code_is_coloured_and_long_code_is_plain():
    texts = ("return 1 < 2", "1 < 2 # " + "x" * LONGEST)
    short, long = (BeautifulSoup(code_as_html(text), "html.parser") for text in texts)
    assert short.find("span", string="return")
    assert long.pre.get_text().startswith("1 < 2 # x") and not long.find("span")


SLOW = [
    *("\\begin{a}", "\\\\[ ", "![a](", "*[", "`a", "|a|\n|-|\n", "-\n", "<a><p>", "[a]: b\n"),
    *(" ", "  \n", "..."),
]
"""Repeated, each takes more than linear time somewhere in nbconvert, mistune or Pygments."""
CPU_SECONDS = 60
RENDER = """\
import json, sys
from nbconvert.exporters import HTMLExporter
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook
from robust_slam_autograder.nbgrader.settings import nbgrader_settings
texts = json.load(sys.stdin)
cells = [make(text) for text in texts for make in (new_markdown_cell, new_code_cell)]
exporter = HTMLExporter(config=nbgrader_settings("."))
page, _ = exporter.from_notebook_node(new_notebook(cells=cells))
assert page.count("lastword") == len(cells)
"""


def test_a_page_takes_time_in_proportion_to_its_text():
    """One page is made of cells with up to a million characters each."""
    sizes = {LONGEST - 20: SLOW, 10**5: ["[", "."], 10**6: ["\\begin{a}"]}
    sized = [(size, text) for size, texts in sizes.items() for text in texts]
    made = [f"x{text * (size // len(text))} lastword" for size, text in sized]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS))

    command = [sys.executable, "-c", RENDER]
    done = ended(command, input=json.dumps(made), preexec_fn=limit)
    assert done.returncode == 0, done.stderr[-500:]


def test_feedback_on_what_plain_nbgrader_graded_hides_its_tests():
    cell = new_code_cell(toy.DOUBLE_RANDOM)
    cell.metadata["nbgrader"] = {"grade": True, "solution": False, "grade_id": "double-random"}
    cell.outputs = [new_output("error", ename="E", evalue="", traceback=[toy.DOUBLE_RANDOM])]
    page = nbformat.v4.new_notebook(cells=[cell])
    hidden, _ = HideTests().preprocess(page, {})
    assert hidden.cells[0].source == "assert np.shape(double([1, 2])) == (2,)\n"
    assert hidden.cells[0].outputs == []
