"""What runs the cells of a page, tried natively: what cells print, show and raise."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "chapters" / "python"
PROGRAM = """
import json, sys
import page_session
page_session.prepare("{}", print, print)
for line in sys.stdin:
    results = [json.loads(page_session.run(cell)) for cell in json.loads(line)]
    print(json.dumps(results), flush=True)
"""

RUNNING: list[subprocess.Popen[str]] = []
Result = dict[str, object]


@pytest.fixture(scope="module", autouse=True)
def worker():
    """One process for all tests, as a page has one."""
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={"MPLBACKEND": "module://page_figures", "PYTHONPATH": str(SOURCES)},
    ) as running:  # fmt: skip
        RUNNING.append(running)
        yield
        RUNNING.pop()
        running.communicate()


def run(*cells: str) -> list[Result]:
    """Run cells one after the other, as a worker would."""
    stdin, stdout = RUNNING[0].stdin, RUNNING[0].stdout
    assert stdin and stdout
    print(json.dumps(cells), file=stdin, flush=True)
    return json.loads(stdout.readline())


def shown(cell: str) -> list[dict[str, str]]:
    (result,) = run(cell)
    assert result["error"] is None
    things = result["shown"]
    assert isinstance(things, list)
    return [thing["data"] for thing in things]


def test_cells_share_their_names_and_print_in_order():
    first, second = run("a = 2\nprint('one')", "import sys\nprint(a * 3, file=sys.stderr)")
    assert (first["text"], first["shown"], first["error"]) == ("one\n", [], None)
    assert second["text"] == "6\n"


@pytest.mark.parametrize(
    ("cell", "text"),
    [("1 + 1", ["2"]), ("1 + 1;", []), ("a = 1", []), ("None", []), ("[1]\n2", ["2"])],
)
def test_the_value_of_the_last_line_is_shown_unless_a_semicolon_ends_it(cell, text):
    assert [data["text/plain"] for data in shown(cell)] == text


def test_objects_say_how_they_are_shown_and_dataclasses_and_pickles_find_their_module():
    cell = """
class Both:
    def _repr_html_(self): return "<b>x</b>"
    def _repr_mimebundle_(self, **_): return {"text/markdown": "**x**"}
from IPython.display import HTML, Markdown, display
display(Both, HTML("<i>h</i>"))
display(Markdown("m"))
Both()
"""
    kind, html, markdown, both = shown(cell)
    assert set(kind) == {"text/plain"}
    assert html["text/html"] == "<i>h</i>" and markdown["text/markdown"] == "m"
    assert (both["text/html"], both["text/markdown"]) == ("<b>x</b>", "**x**")
    cell = (
        "import pickle\nfrom dataclasses import dataclass\n@dataclass\nclass A:\n    x: int\n"
        "pickle.loads(pickle.dumps(A(3)))"
    )
    assert [data["text/plain"] for data in shown(cell)] == ["A(x=3)"]


@pytest.mark.parametrize("end", ["plt.show()", "figure", "", "display(figure); plt.close()"])
def test_a_figure_is_shown_once_as_svg(end):
    cell = f"from matplotlib import pyplot as plt\nfigure, ax = plt.subplots()\n{end}"
    (data,) = shown(cell)
    assert "<svg" in data["image/svg+xml"]


def test_the_captions_of_a_figure_arrive_and_a_live_picture_is_shown_as_html():
    cell = (
        "from matplotlib import pyplot as plt\nfrom robust_slam_course.plots import captions\n"
        "captions.show(plt.figure(), 'what it is', 'what it shows')"
    )
    (result,) = run(cell)
    (thing,) = result["shown"]
    words = {"figure": {"caption": "what it is"}, "image": {"alt": "what it shows"}}
    assert thing["metadata"] == {"mystnb": words}
    (data,) = shown("from robust_slam_course import pictures\npictures.cycles()")
    assert 'data-picture="cycles"' in data["text/html"]


def error(*cells: str) -> str:
    *_, last = run(*cells)
    return str(last["error"])


def test_a_traceback_names_the_lines_of_cells_and_packages_alone():
    said = error("def f(x):\n    return np.linalg.inv(x)", "import numpy as np\nf([[0.0]])")
    lines = [line for line in said.splitlines() if "File" in line]
    assert lines[0] == '  File "this cell", line 2, in <module>'
    assert lines[1] == '  File "another cell", line 2, in f'
    assert all('File "numpy/' in line for line in lines[2:]) and len(lines) > 2
    assert "    return np.linalg.inv(x)" in said and "    f([[0.0]])" in said
    assert "LinAlgError: Singular matrix" in said.splitlines()[0]


def test_causes_are_told_too_and_a_mistake_in_the_syntax_is_pointed_at():
    cell = "try:\n    1 / 0\nexcept ZeroDivisionError as e:\n    raise ValueError('no') from e"
    said = error(cell)
    assert said.count('File "this cell"') == 2 and "page_session" not in said
    assert "ZeroDivisionError" in said and said.startswith("ValueError: no\n\n")
    said = error("a = 1\nb = = 2")
    assert said.splitlines()[:3] == [
        "SyntaxError: invalid syntax", "", '  File "this cell", line 2',
    ]  # fmt: skip
    assert "b = = 2" in said


@pytest.mark.parametrize(
    ("cells", "line"),
    [(["a = 1\nb = = 2"], 2), (["def f():\n    1 / 0", "\n\nf()"], 3), (["1 + 1"], None)],
)
def test_the_line_of_the_cell_at_which_an_error_arose_is_named(cells, line):
    assert run(*cells)[-1]["line"] == line


@pytest.mark.parametrize("cell", ["!ls", "a = 1\n%matplotlib inline"])
def test_a_notebooks_own_commands_are_named(cell):
    assert error(cell).splitlines()[1].endswith("the page runs Python alone.")


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("import sys\nsys.exit(3)", "SystemExit: 3"),
        ("def f(): f()\nf()", "RecursionError"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("input('how many?')", "write the answer into the code"),
        ("import no_such", "In the page there are NumPy, SciPy, Matplotlib"),
        ("class A:\n    def __repr__(self): return 1 / 0\ndisplay(A())", "ZeroDivisionError"),
    ],
)
def test_the_session_goes_on_after_an_error(cell, words):
    first, second = run(f"print('before')\n{cell}", "1")
    assert words in str(first["error"]) and first["text"] == "before\n"
    assert "page_session" not in str(first["error"])
    assert second["error"] is None and second["shown"]


def test_endless_printing_is_cut_and_text_that_fits_exactly_only_where_more_follows():
    endless, full, more = run(
        "for k in range(50_000): print('x' * 100)",
        "print('x' * 200_000, end='')",
        "print('x' * 200_000, end='')\nprint('y')",
    )
    assert len(str(endless["text"])) < 201_000
    assert str(endless["text"]).endswith("cut after 200,000 characters\n")
    assert full["text"] == "x" * 200_000
    assert str(more["text"]).endswith("x\n… cut after 200,000 characters\n")


def test_a_large_value_does_not_reach_the_page():
    (text,) = shown("'a' * 30_000_000")
    assert len(text["text/plain"]) < 201_000 and "cut after" in text["text/plain"]
    (html,) = shown("from IPython.display import HTML\nHTML('a' * 30_000_000)")
    assert html == {"text/plain": "The text/html of this value is too large for the page."}
