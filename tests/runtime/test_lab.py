"""An assignment is done in the browser, from the click to the mark.

Chromium reaches this machine alone.
"""

import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from robust_slam_autograder import cli

from solutions.classes import answers
from tests import jupyterlab
from tests.book.taking_hold import PICTURE, follows
from tests.chromium import page_in, served, visiting
from tests.runtime.conftest import RUNTIME, look_for_the_runtime, without_hints

pytestmark = [pytest.mark.browser, pytest.mark.long]

NAME = "00-one-lie"
RELEASED = RUNTIME / "lab" / "files"
EXERCISE = "total_cost"
HALF = """\
def total_cost(x, i, j, z, sigma):
    x = np.asarray(x)
    return np.sum(((x[j] - x[i] - z) / sigma) ** 2) / 2
"""
CHECK = f'from robust_slam_autograder.self_check import check\n\ncheck("{NAME}.ipynb")'
LIVE = """\
import ipywidgets
from IPython.display import display
from robust_slam_course import pictures

slider = ipywidgets.IntSlider(3)
shown = pictures.opening().widget()
first = dict(shown.state)
display(slider, shown)
"""
CLOCK = """\
import time

start, before = time.perf_counter(), time.process_time()
while time.perf_counter() < start + 0.1:
    pass
print(time.process_time() > before)
"""
ASKED = "print(slider.value > 3, shown.state != first)"
MENUS, SIZE = ["File", "Edit", "Run", "Kernel"], {"width": 1400, "height": 1100}
IDLE = ".jp-Notebook-ExecutionIndicator[data-status='idle']"


def released() -> dict[str, Any]:
    """The notebook as the site has it."""
    return json.loads((RELEASED / f"{NAME}.ipynb").read_text("utf-8"))


class Lab:
    """An assignment that is open in JupyterLab in the browser."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.cells = page.locator(".jp-Notebook .jp-Cell")
        self.cells.first.wait_for()
        cells = released()["cells"]
        ids = [cell["metadata"].get("nbgrader", {}).get("grade_id") for cell in cells]
        self.number = {grade_id: number for number, grade_id in enumerate(ids) if grade_id}

    def wait_for_python(self) -> None:
        self.page.locator(".jp-Toolbar-kernelName", has_text="Python").wait_for()
        self.page.locator(IDLE).wait_for(state="attached")

    def type_in(self, sources: Mapping[str, str]) -> None:
        """Replace the text of cells, by their grade ids."""
        for grade_id, text in sources.items():
            jupyterlab.write(self.cells.nth(self.number[grade_id]), text)

    def add_at_the_end(self, text: str) -> int:
        """Add a cell of one's own; gives its number."""
        self.cells.last.click()
        self.page.keyboard.press("Escape")
        number = self.cells.count()
        self.page.keyboard.press("b")
        jupyterlab.write(self.cells.nth(number), text)
        return number

    def run(self, number: int) -> str:
        """Run a cell, wait until it has ended, and give what it says."""
        cell = self.cells.nth(number)
        cell.locator(".jp-InputPrompt").click()
        jupyterlab.run(cell, "Control+Enter")
        self.page.locator(IDLE).wait_for(state="attached")
        return "\n".join(cell.locator(".jp-OutputArea-output").all_inner_texts())

    def save(self) -> None:
        """Save, and wait until it is done."""
        self.page.keyboard.press("Control+s")
        self.page.locator(".lm-TabBar-tab.jp-mod-current:not(.jp-mod-dirty)").wait_for()

    def download(self, folder: Path) -> Path:
        self.page.locator(".lm-MenuBar-item", has_text="File").click()
        with self.page.expect_download() as waiting:
            self.page.locator(".lm-Menu-itemLabel", has_text="Download").first.click()
        path = folder / waiting.value.suggested_filename
        waiting.value.save_as(path)
        return path


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    look_for_the_runtime()
    folder = tmp_path_factory.mktemp("site")
    (folder / "python").mkdir()
    for place in ("python/pyodide", "python/wheels", "lab"):
        (folder / place).symlink_to(RUNTIME / Path(place).name)
    with served(folder) as url:
        yield url


@pytest.fixture(scope="module")
def done(browser, address, tmp_path_factory):
    """A student's way through the first assignment, with one mistake: what each step showed."""
    said: dict[str, Any] = {}
    right = {
        cell["metadata"]["nbgrader"]["grade_id"]: "".join(cell["source"])
        for cell in answers.source_notebook(NAME)["cells"]
        if cell["metadata"].get("nbgrader", {}).get("solution")
    }
    url = f"{address}/lab/lab/index.html?path={NAME}.ipynb"
    with visiting(browser, url, viewport=SIZE, reduced_motion="reduce") as visit:
        lab = Lab(visit.page)
        lab.wait_for_python()
        test = lab.number[f"{EXERCISE}-by-hand"]
        said["start"] = lab.run(lab.number["setup"])
        lab.run(lab.number[EXERCISE])
        said["empty"] = lab.run(test)
        lab.type_in({EXERCISE: HALF})
        lab.run(lab.number[EXERCISE])
        said["wrong"] = lab.run(test)
        lab.type_in({name: text for name, text in right.items() if name != EXERCISE})
        check = lab.add_at_the_end(CHECK)
        lab.save()
        said["check wrong"] = lab.run(check)
        lab.save()
        said["wrong file"] = lab.download(tmp_path_factory.mktemp("wrong"))
        lab.type_in({EXERCISE: right[EXERCISE]})
        lab.run(lab.number[EXERCISE])
        said["right"] = lab.run(test)
        lab.save()
        said["check right"] = lab.run(check)
        lab.save()
        kept = visit.page.evaluate("localStorage.getItem('robust-slam-progress')")
        said["progress"] = json.loads(kept)["assignments"]
        said["file"] = lab.download(tmp_path_factory.mktemp("right"))
        live = lab.add_at_the_end(LIVE)
        lab.run(live)
        said["follows"] = follows(lab.cells.nth(live).locator(PICTURE))
        lab.cells.nth(live).locator(".widget-slider .noUi-base").click()
        said["asked"] = lab.run(lab.add_at_the_end(ASKED))
        endless = lab.add_at_the_end("while True:\n    pass")
        lab.cells.nth(endless).locator(".jp-InputPrompt").click()
        visit.page.keyboard.press("Control+Enter")
        visit.page.locator(IDLE.replace("idle", "busy")).wait_for(state="attached")
        visit.page.locator("[data-command='notebook:interrupt-kernel']").first.click()
        visit.page.get_by_text("Stopped, and Python with it.").first.wait_for()
        visit.page.locator(IDLE).wait_for(state="attached")
        said["clock moves"] = lab.run(lab.add_at_the_end(CLOCK))
        said["outside"] = visit.outside
    return said


def commanded(path: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """The lines of the command ``autograder check``, below the one that names the file."""
    folder = path.parent
    (folder / "autograder.toml").write_bytes((RELEASED / NAME / "autograder.toml").read_bytes())
    capsys.readouterr()
    cli.main(["check", str(path)])
    return without_hints(capsys.readouterr().out).strip().split("\n")[1:]


def test_cells_run_and_say_what_is_wrong(done):
    """The first one waits for a student's whole way through an assignment in the browser."""
    assert done["start"] == "" and done["right"] == ""
    assert "NotImplementedError" in done["empty"]
    assert "AssertionError: Only the outlier costs anything: (2/0.05)²." in done["wrong"]


def test_check_says_what_the_command_says(done, capsys):
    steps = ["Where to look", "What to compute by hand", "The idea"]
    hints = ["total_cost: hints for the whole exercise", *steps]
    for shown, file, folded in (("check wrong", "wrong file", hints), ("check right", "file", [])):
        lines = done[shown].strip().split("\n")
        said = commanded(done[file], capsys)
        assert lines[0] == f"Checking {NAME}.ipynb: the visible cases of {NAME}."
        assert lines[1 : len(said) + 1] == said
        assert list(filter(None, lines[len(said) + 1 :])) == folded
    assert "◐ partial  total_cost" in done["check wrong"]
    assert "All visible cases passed" in done["check right"]


def test_the_downloaded_file_is_graded_and_has_full_marks(done, tmp_path, capsys):
    out = tmp_path / "graded"
    marks = {}
    for student, file in (("ada", "file"), ("bob", "wrong file")):
        command = ["grade", str(done[file]), "--student", student, "--assignment", NAME]
        assert cli.main([*command, "--out", str(out), "--seed", "7"]) == 0
        result = json.loads((out / student / f"{NAME}.json").read_text(encoding="utf-8"))
        marks[student] = (result["score"], result["max_score"])
    capsys.readouterr()
    assert marks["ada"][0] == marks["ada"][1] > marks["bob"][0] > 0


def test_the_downloaded_file_has_the_cells_of_the_release(done):
    assert done["file"].name == f"{NAME}.ipynb"
    cells = json.loads(done["file"].read_text(encoding="utf-8"))["cells"]
    before = released()["cells"]
    assert len(cells) == len(before) + 1
    for mine, theirs in zip(cells, before, strict=False):
        assert (mine["id"], mine["cell_type"]) == (theirs["id"], theirs["cell_type"])
        for key, value in theirs["metadata"].items():
            assert mine["metadata"][key] == value
        if not theirs["metadata"].get("nbgrader", {}).get("solution"):
            assert "".join(mine["source"]) == "".join(theirs["source"])


def test_pictures_follow_the_hand_a_loop_is_stopped_and_pages_hear_of_the_check(done):
    assert done["follows"]
    assert done["asked"].strip() == "True True"
    assert done["progress"] == {NAME: {"checked": True}}
    assert done["clock moves"].strip() == "True"
    assert done["outside"] == []


@dataclass(frozen=True)
class Site:
    """A site of one's own, whose assignment can be corrected."""

    lab: Path
    url: str

    def correct(self, release: str) -> None:
        """Publish another release of the assignment."""
        value = released()
        value["cells"][0]["source"] = f"# Corrected: {release}"
        value["metadata"]["robust_slam"] = {"release": release}
        (self.lab / "files" / f"{NAME}.ipynb").write_text(json.dumps(value), "utf-8")
        releases = json.dumps({"notebooks": {f"{NAME}.ipynb": release}})
        (self.lab / "releases.json").write_text(releases, "utf-8")


@pytest.fixture
def site(tmp_path):
    """A site without Python, which would start with each page."""
    look_for_the_runtime()
    lab = tmp_path / "lab"
    lab.mkdir()
    for path in (RUNTIME / "lab").iterdir():
        if path.name == "files":
            shutil.copytree(path, lab / path.name)
        elif path.name == "releases.json":
            shutil.copyfile(path, lab / path.name)
        else:
            (lab / path.name).symlink_to(path)
    with served(tmp_path) as url:
        yield Site(lab, f"{url}/lab/lab/index.html?path={NAME}.ipynb")


@pytest.mark.rest
def test_an_older_copy_stays_beside_the_corrected_assignment(browser, site):
    """JupyterLab opens in the browser four times."""
    with page_in(browser, viewport=SIZE, reduced_motion="reduce") as page:
        question = page.locator("dialog", has_text="has been corrected")
        tabs = page.locator(".lm-DockPanel-tabBar .lm-TabBar-tabLabel")
        corrected = page.locator(".jp-MarkdownCell:visible", has_text="Corrected:")

        def opened() -> Lab:
            page.goto(site.url)
            return Lab(page)

        lab = opened()
        lab.type_in({EXERCISE: HALF})
        lab.save()
        site.correct("first")
        opened()
        question.get_by_role("button", name="Keep mine").click()
        page.reload()
        Lab(page)
        page.wait_for_function("window.jupyterapp.shell.currentWidget.context.isReady")
        expect(page.get_by_text("/ sigma) ** 2) / 2").first).to_be_attached()
        expect(question).to_have_count(0)
        site.correct("second")
        opened()
        question.get_by_role("button", name="Take the new one").click()
        expect(corrected).to_contain_text("second")
        expect(tabs.filter(has_text=f"{NAME}-mine.ipynb")).to_have_count(1)
        mine, new = page.evaluate(
            "(paths) => Promise.all(paths.map(async (path) => (await"
            " jupyterapp.serviceManager.contents.get(path, {content: true})).content))",
            [f"{NAME}-mine.ipynb", f"{NAME}.ipynb"],
        )
        assert HALF.strip() in ["".join(cell["source"]).strip() for cell in mine["cells"]]
        assert new["metadata"]["robust_slam"]["release"] == "second", "nothing is asked again"


@pytest.mark.rest
def test_the_notebook_has_the_page_and_the_menus_that_it_needs(browser, site):
    with page_in(browser, viewport={"width": 390, "height": 800}) as page:
        page.goto(site.url)
        page.locator(".jp-Notebook .jp-Cell").first.wait_for()
        for width in (390, 1280):
            page.set_viewport_size({"width": width, "height": 800})
            notebook = f"document.querySelector('.jp-Notebook').clientWidth > {0.75 * width}"
            page.wait_for_function(notebook)
            expect(page.locator("#jp-left-stack")).to_be_hidden()
            expect(page.locator(".jp-SideBar:visible")).to_have_count(0)
            expect(page.locator(".lm-MenuBar-itemLabel")).to_have_text(MENUS)
