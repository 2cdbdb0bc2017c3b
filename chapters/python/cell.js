/** One cell of the page: its editor, its buttons and its output. */
import { openEditor } from "./editor.js";
import { element } from "./element.js";
import { drawFormulas } from "./formulas.js";
import { outputs } from "./output.js";

const HINT = "Shift+Enter runs. Escape, then Tab, leaves the editor.";

export class Cell {
  #does;
  #page;
  #editor = null;
  #stored = [];
  #shown = null;
  #given;

  /** `given` has the id, parts, why the cell cannot run and a note, if so; `does` what buttons do. */
  constructor({ id, parts, cannot, note }, does) {
    this.id = id;
    this.given = parts.map(({ code }) => code).join("\n");
    const name = (k) => (parts.length > 1 ? `${id}/${k}` : id);
    this.#given = parts.map(({ code, gives }, k) => this.#part(name(k), code, gives));
    this.cannot = cannot;
    this.note = note ?? "";
    this.#does = does;
    this.#page = document.getElementById(id);
  }

  /** Keep for the next visit what the reader wrote, under the page's own code, which may change. */
  keep(code = this.code) {
    if (this.isOpen) storage((kept) => (code === this.given ? kept.removeItem(this.#place) : kept.setItem(this.#place, code)));
  }

  get kept() {
    return storage((kept) => kept.getItem(this.#place));
  }

  get #place() {
    return `robust-slam-code ${this.id} ${this.given}`;
  }

  get isOpen() {
    return this.#editor !== null;
  }

  /** The code as it stands in the editor, or in the page. */
  get code() {
    return this.#editor?.code() ?? this.given;
  }

  /** The code as one part; of the reader's own, any word may be a name that it gives. */
  get whole() {
    const { code } = this;
    const own = code !== this.given;
    return this.#part(this.id, code, own ? null : this.#given.flatMap(({ gives }) => gives));
  }

  /** What can run without the rest of the cell, where the reader sees none of it. */
  get parts() {
    return this.isOpen ? [this.whole] : this.#given;
  }

  #part(name, code, gives) {
    const words = code.match(/[A-Za-z_]\w*/g) ?? [];
    return { cell: this, name, code, words, gives: gives ?? words, isTheReaders: gives === null };
  }

  open() {
    if (this.isOpen) return this.#editor.focus();
    const input = this.#page.querySelector(".cell_input");
    const parts = makeParts(this.id, this.note);
    this.#shown = { input, was: [...input.children], ...parts };
    input.replaceChildren(parts.editor, parts.bar);
    this.#editor = openEditor({
      parent: parts.editor,
      code: this.kept ?? this.given,
      label: "Code of this cell",
      hint: parts.hint.id,
      run: () => this.#does.run(this),
    });
    // The page has shortcuts of its own, such as a slash for its search.
    parts.editor.addEventListener("keydown", (event) => event.stopPropagation());
    parts.run.addEventListener("click", () => this.#does.run(this));
    parts.stop.addEventListener("click", () => this.#does.stop(this));
    parts.reset.addEventListener("click", () => this.#does.reset(this));
    const output = this.#output();
    this.#stored = [...output.childNodes];
    // On a phone the keyboard would cover what the cell shows.
    (matchMedia("(pointer: coarse)").matches ? parts.run : this.#editor).focus();
  }

  /** Bring back the page's own code and output. */
  close() {
    const { input, was } = this.#shown;
    this.keep(this.given);
    this.#editor.close();
    this.#editor = null;
    this.#output().replaceChildren(...this.#stored);
    input.replaceChildren(...was);
    const button = input.querySelector(".rs-run button");
    button.disabled = false;
    button.focus();
  }

  begin() {
    this.say("");
    // What the page shows stays until there is another output; that of the run before goes.
    if (this.#shown.ran) this.#output().replaceChildren();
    this.#editor.mark(null);
    this.#mark(true);
  }

  wait() {
    this.say("Waiting for the cell that runs …");
    this.#mark(true);
  }

  end() {
    if (!this.isOpen) return;
    this.#mark(false);
    this.#shown.progress.hidden = this.#shown.bytes.hidden = true;
  }

  /** Say in a line what happens. */
  say(text) {
    if (this.isOpen && this.#shown.status.textContent !== text) {
      this.#shown.status.textContent = text;
    }
  }

  /** Say which cells above ended with an error. */
  pointTo(failed) {
    const links = failed.flatMap(({ id }, k) => [
      k ? ", " : "", element("a", { href: `#${id}` }, id.replace(/^code-/, "")),
    ]);
    this.#shown.status.append(` Cells above that ended with an error: `, ...links, ".");
  }

  /** Show how many of the bytes that were asked for have arrived; all: say what follows. */
  loading(arrived, wanted, words) {
    if (!this.isOpen) return;
    const { progress, bytes } = this.#shown;
    const megabytes = (number) => (number / 1e6).toFixed(1);
    const amount = `${megabytes(arrived)} of ${megabytes(wanted)} MB`;
    progress.hidden = bytes.hidden = arrived >= wanted;
    progress.value = arrived / wanted;
    progress.setAttribute("aria-valuetext", amount);
    bytes.textContent = amount;
    this.say(arrived >= wanted ? words : "Loading Python and what is imported …");
  }

  /** Put what a run gave in place of the output; `changed`: some code is not the page's. */
  show(result, changed) {
    this.#shown.ran = true;
    this.#output().replaceChildren(...outputs(result, this.#stored, changed));
    this.#editor.mark(result.line);
    drawFormulas(this.#output());
  }

  #mark(running) {
    const { run, stop } = this.#shown;
    run.setAttribute("aria-disabled", running);
    stop.setAttribute("aria-disabled", !running);
    this.#output().setAttribute("aria-busy", running);
  }

  /** The place for output; a cell that showed nothing has none at first. */
  #output() {
    const found = this.#page.querySelector(".cell_output");
    if (found) return found;
    const made = element("div", { class: "cell_output docutils container" });
    this.#page.append(made);
    return made;
  }
}

/** Use what the browser keeps, if it keeps anything. */
function storage(use) {
  try { return use(localStorage); } catch { return null; }
}

function makeParts(id, note) {
  const button = (name) => element("button", { type: "button", "data-does": name }, name);
  const parts = {
    editor: element("div", { class: "highlight rs-editor" }),
    run: button("Run"),
    stop: button("Stop"),
    reset: button("Reset"),
    progress: element("progress", { max: 1, "aria-label": "Progress" }),
    bytes: element("span", { class: "rs-bytes", "aria-hidden": true }),
    status: element("span", { role: "status" }),
    hint: element("span", { class: "rs-hint", id: `${id}-hint` }, HINT),
  };
  parts.progress.hidden = parts.bytes.hidden = true;
  parts.stop.setAttribute("aria-disabled", true);
  const { run, stop, reset, progress, bytes, status, hint } = parts;
  const shown = [note, run, stop, reset, progress, bytes, status, hint];
  parts.bar = element("div", { class: "rs-run" }, ...shown);
  return parts;
}
