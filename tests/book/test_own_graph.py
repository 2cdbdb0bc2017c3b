"""The page *Your own graph*: its doctor names planted faults, and a reader sees and saves a map.

The faults are planted in files and asked of the module of the page; browsers try what a reader
does with it, since each start of Python takes seconds.
"""

import ast
import importlib
import json
import re
import subprocess
import sys
from collections.abc import Callable, ValuesView
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import robust_slam as rs
from playwright.sync_api import Page, expect
from robust_slam.graphs import (
    PoseGraph,
    add_random_closures,
    dead_reckoning,
    g2o,
    manhattan,
    write_tum,
)

from autograder.tests.kernel import leave_out
from chapters._ext import TEMPLATES
from lib.tests import test_bad_input, test_doctor
from lib.tests.graphs import test_formats, test_g2o
from tests.book.test_accessible import complaints
from tests.book.test_pages import TOO_WIDE
from tests.chromium import visiting
from tests.firefox import firefox

SOURCES = Path(__file__).parents[2] / "chapters" / "python"
PAGE = "chapters/your-graph"
Ask = Callable[..., Any]


@pytest.fixture
def ask(tmp_path, monkeypatch):
    """The module of the page, with ``tmp_path`` as its home."""
    monkeypatch.syspath_prepend(str(SOURCES))
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module("page_graph")

    def asked(question: str, **given: object) -> Any:
        return json.loads(module.ask(question, json.dumps(given), lambda words: None))

    return asked


def diagnosis(ask: Ask) -> str:
    """All that the page says of ``graph.g2o``."""
    found = ask("read", name="graph.g2o")
    if "problem" in found:
        return f"{found['problem']} {dict(map(tuple, found['lines'])).get(found['line'], '')}"
    return " ".join([*found["remarks"], *ask("solve")["notes"], ask("reading")["words"]])


@pytest.fixture(scope="module")
def town():
    rng = np.random.default_rng(0)
    graph, truth = manhattan(60, rng, closures=30)
    return add_random_closures(graph, 8, rng, poses=truth)[0]


def between_drives(graph: PoseGraph) -> PoseGraph:
    """Two drives, of which a closure joins the last pose of one to the first of the other."""
    z, own = graph.measurement.copy(), graph.information * 9.0
    z[20] = [40.0, 0.0, 0.0]
    return replace(graph, measurement=z, information=own)


@pytest.mark.long
class TestTheDoctor:
    @pytest.mark.parametrize(
        ("fault", "words"),
        [
            (
                lambda g: replace(g, measurement=g.measurement * [1.0, 1.0, 180.0 / np.pi]),
                "if these are degrees",
            ),
            (
                lambda g: replace(g, measurement=g.inverse_measurement),
                "Read with i and j swapped in all edges, ",
            ),
            (between_drives, "edge 20-21 counts as odometry.*write 20-21 under Options"),
        ],
        ids=["degrees", "swapped", "between-drives"],
    )
    def test_a_planted_fault_is_named(self, fault, words, town, ask):
        unlike = ["are covariances", "degrees", "Read with", "deviations", "counts as odometry"]
        g2o.write("graph.g2o", town)
        before = diagnosis(ask)
        assert not any(word in before for word in unlike), before
        with np.errstate(all="ignore"):
            g2o.write("graph.g2o", fault(town))
        assert re.search(words, diagnosis(ask))

    @pytest.mark.parametrize(
        ("edit", "words"),
        [
            (lambda lines: ["VERTEX_SE2 0 0 0 zero", *lines[1:]], "1: .*VERTEX_SE2 0 0 0 zero"),
            (lambda lines: [*lines, "PRIOR 1 2"], "tag 'PRIOR' is unknown.* out under Options"),
        ],
        ids=["no-number", "unknown"],
    )
    def test_a_broken_line_is_shown_with_a_remedy(self, edit, words, town, ask, tmp_path):
        g2o.write(tmp_path / "graph.g2o", town, np.zeros((town.n, 3)))
        lines = (tmp_path / "graph.g2o").read_text().splitlines()
        (tmp_path / "graph.g2o").write_text("\n".join(edit(lines)))
        assert re.search(words, diagnosis(ask))

    def test_what_no_map_holds_is_said_in_its_place(self, town, ask):
        z = town.measurement.copy()
        z[7] = [1e9, 0.0, 0.0]
        g2o.write("graph.g2o", replace(town, measurement=z))
        assert "problem" not in ask("read", name="graph.g2o")
        assert ask("solve")["problem"].startswith("edge 7, which joins poses 7 and 8, measures 1e")

    def test_noise_is_named_where_too_few_closures_are_kept_to_tell(self, ask):
        rng = np.random.default_rng(2)
        graph, _ = manhattan(200, rng, closures=100)
        graph = replace(graph, information=100.0 * graph.information)
        answer = rs.solve(graph)
        assert answer.noise.max() < 2.0 < answer.rejected.size
        g2o.write("graph.g2o", graph)
        assert "deviations ten times as large, 0 edges" in diagnosis(ask)


def test_the_lines_of_python_do_the_same(town, ask, tmp_path):
    """With a step that is named as a closure, and a file whose name would be code unquoted."""
    name = "it's\na\", exit(3)  # town"
    g2o.write(f"{name}.g2o", between_drives(town))
    assert ["sessions", "2"] in ask("read", name=f"{name}.g2o", not_steps="20-21")["rows"]
    answer = ask("solve")
    nodes = ast.walk(ast.parse(answer["python"]))
    texts = {node.value for node in nodes if isinstance(node, ast.Constant)}
    assert {f"{name}.g2o", f"{name}-clean.g2o"} <= texts
    done = subprocess.run([sys.executable, "-c", answer["python"]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert Path(f"{name}-clean.g2o").read_text() == answer["files"]["clean.g2o"]
    assert "--closure 20-21" in answer["command"]


def test_a_trajectory_takes_closures_and_deviations(town, ask):
    write_tum("drive.tum", dead_reckoning(town))
    g2o.write("loops.g2o", replace(town, is_odometry=~town.is_odometry))
    lines = Path("loops.g2o").read_text().splitlines()[town.n - 1 :]
    Path("loops.g2o").write_text("\n".join(lines))
    assert "0.05 m and 0.01 rad, under Options" in ask("read", name="drive.tum")["problem"]
    ask("read", name="drive.tum", odometry=[0.05, 0.02], closures="loops.g2o")
    answer = ask("solve")
    assert answer["kept"] == rs.solve(town).kept.tolist()
    assert "--odometry 0.05 0.02 --closures loops.g2o" in answer["command"]
    exec(answer["python"], {})
    assert Path("drive-clean.g2o").read_text() == answer["files"]["clean.g2o"]


def test_each_edge_says_why(town, ask):
    g2o.write("graph.g2o", town)
    ask("read", name="graph.g2o")
    answer, own = ask("solve"), rs.solve(town)
    assert answer["kept"] == own.kept.tolist()
    for k, words in enumerate(answer["about"]):
        if town.is_odometry[k]:
            assert words.startswith("odometry, kept")
            continue
        assert words.startswith(f"a loop closure, {'kept' if own.kept[k] else 'rejected'}, since")
        assert (answer["size"][k] <= own.threshold) == own.kept[k]


def texts(value):
    """The files in a module's tables, in what it is parametrised by too."""
    if isinstance(value, str) and "\n" in value:
        yield value
    marks = [mark.args for mark in getattr(value, "pytestmark", ())]
    parts = value.values() if isinstance(value, dict) else value
    for each in (*marks, *(parts if isinstance(parts, list | tuple | ValuesView) else ())):
        yield from texts(each)


READ = """async ([folder, texts, given]) => {
  const engine = await import(`${folder}/engine.js`);
  await engine.start(() => {}, "import page_graph");
  const found = [];
  for (const text of texts) {
    const files = {file: new TextEncoder().encode(text)};
    found.push(await engine.ask({module: "page_graph", question: "read", given, files}));
  }
  engine.stop();
  return found;
}"""


@pytest.fixture(scope="module")
def runtime(site):
    """The site, where it has Python for its pages."""
    if not (site.folder / "python" / "pyodide").is_dir():
        leave_out("the runtime is not there (make runtime); the page cannot read a file")


@pytest.fixture(scope="class")
def visit(runtime, address, browser):
    url = f"{address}/{PAGE}.html"
    with visiting(browser, url, viewport={"width": 1280, "height": 900}) as opened:
        yield opened
        assert opened.outside == [] and opened.complaints == []


SHIFTS = """() => new Promise((opened) => {
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const from = performance.now();
    window.shifts = [];
    new PerformanceObserver((list) => window.shifts.push(...list.getEntries().filter(
      (entry) => !entry.hadRecentInput && entry.startTime > from).map((entry) => entry.value)),
    ).observe({type: "layout-shift", buffered: true});
    opened();
  }));
})"""
"""Records what moves once the place of the results is open, which the reader asked for."""


def saved(page: Page, name: str, folder: Path) -> Path:
    with page.expect_download() as download:
        page.get_by_role("button", name=name).click()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


@pytest.mark.browser
@pytest.mark.rest
class TestThePage:
    def test_a_file_becomes_a_map_that_can_be_asked_and_saved(self, visit, town, tmp_path):
        """Python with SciPy starts in the page and solves a graph; axe-core looks at it twice."""
        page, status = visit.page, visit.page.locator("#own-graph [role=status]")
        g2o.write(tmp_path / "my town.g2o", town)
        page.get_by_label("choose one").set_input_files(tmp_path / "my town.g2o")
        page.evaluate(SHIFTS)
        expect(status).to_have_text("Done.")
        assert sum(page.evaluate("window.shifts")) < 0.01
        own = rs.solve(town)
        expect(page.locator("[data-say=verdict]")).to_have_text(f"The map is {own.verdict}.")
        edge, slider = page.locator("[data-say=edge]"), page.locator("input[name=edge]")
        expect(edge).to_contain_text("a loop closure, rejected")
        assert slider.get_attribute("max") == str(own.rejected.size - 1)
        first = edge.inner_text()
        slider.press("ArrowRight")
        expect(edge).not_to_have_text(first)
        assert slider.get_attribute("aria-valuetext") == edge.inner_text()
        # The pointer finds an edge where its line is.
        box = page.locator("[data-map=robust] path.is-chosen").bounding_box()
        drawn = page.locator("[data-map=robust] svg").bounding_box()
        assert box and drawn
        told = edge.inner_text()
        slider.press("Home")
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        expect(edge).not_to_have_text(first)
        assert told.startswith("Edge")

        clean = rs.read(saved(page, "The cleaned graph", tmp_path))
        assert len(clean.graph.edges) == int(own.kept.sum())
        np.testing.assert_allclose(clean.poses, own.poses, atol=1e-4)
        whole = rs.read(saved(page, "All edges with the poses", tmp_path))
        assert len(whole.graph.edges) == len(town.edges)
        drive = rs.read(saved(page, "The poses (TUM)", tmp_path), odometry=(1.0, 1.0))
        assert drive.graph.n == town.n
        assert "<svg" in saved(page, "The picture", tmp_path).read_text()

        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            assert complaints(page) == set()
        page.set_viewport_size({"width": 390, "height": 800})
        assert page.evaluate(TOO_WIDE) == []

    def test_a_broken_file_and_a_stop(self, visit):
        """Stop ends Python in the page, which then starts again with all its packages."""
        page, status = visit.page, visit.page.locator("#own-graph [role=status]")
        page.get_by_role("button", name="A broken file").press("Enter")
        problem = page.locator("[data-say=problem]")
        expect(problem).to_contain_text("vertex 119 is missing; add its line or drop the edge")
        expect(page.locator("[data-say=lines] mark")).to_contain_text(" 118 119 ")
        page.get_by_role("button", name="A sphere").press("Enter")
        page.locator("[data-say=facts]").get_by_text("SE(3)").wait_for()
        page.get_by_role("button", name="Stop", exact=True).press("Enter")
        expect(status).to_contain_text("Stopped")
        page.get_by_role("button", name="ten times too small").press("Enter")
        expect(page.locator("[data-say=notes]")).to_contain_text("deviations that are too small")

    def test_each_file_is_read_as_outside_of_the_browser(self, visit, address, ask):
        """The whole numbers of Python in the page have 32 bits, and ids have more."""
        tables = [vars(module) for module in (test_bad_input, test_doctor, test_formats, test_g2o)]
        found = sorted({*texts([each for table in tables for each in table.values()])})
        assert len(found) > 100 and any("A10" in text for text in found)
        given = {"name": "file", "unknown": "skip", "indefinite": "nearest", "odometry": [1, 1]}
        expected = []
        for text in found:
            Path("file").write_text(text, newline="")
            expected.append(ask("read", **given))
        assert visit.page.evaluate(READ, [f"{address}/python", found, given]) == expected

    def test_from_a_file_the_command_stands_in_its_place(self, site, open_page):
        visit = open_page((site.folder / f"{PAGE}.html").as_uri())
        shown = visit.page.locator("#own-graph").inner_text()
        assert "Python does not run here" in shown and "robust-slam solve FILE" in shown
        assert "Drop a file" not in shown and visit.complaints == []

    def test_a_site_without_the_runtime_has_the_command_alone(self):
        html = TEMPLATES.get_template("own_graph.html").render(bytes=0, folder="")
        assert "robust-slam solve FILE" in html and not re.search("<form|<script", html)

    @pytest.mark.soak
    def test_firefox_takes_a_file_too(self, runtime, address, town, tmp_path):
        g2o.write(tmp_path / "town.g2o", town)
        text = json.dumps((tmp_path / "town.g2o").read_text())
        script = f"""new Promise((done) => {{
          const moved = new DataTransfer();
          moved.items.add(new File([{text}], "town.g2o"));
          const of = (part) => document.querySelector(`#own-graph ${{part}}`);
          const when = (isSo, then) => (isSo() ? then() : setTimeout(when, 200, isSo, then));
          const said = () => of("[role=status]").textContent;
          when(() => !of("[data-part=all]").disabled, () => {{
            dispatchEvent(new DragEvent("drop", {{dataTransfer: moved}}));
            when(() => /^Done|ended/.test(said()), () => done(said()));
          }});
        }})"""
        with firefox(tmp_path) as fox:
            fox.goto(f"{address}/{PAGE}.html")
            assert fox.evaluate(script) == "Done."
            verdict = "document.querySelector('[data-say=verdict]').textContent"
            assert fox.evaluate(verdict) == f"The map is {rs.solve(town).verdict}."
