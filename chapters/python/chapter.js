/** The cells of a chapter that the reader has opened, and Python, in which they run. */
import { Cell } from "./cell.js";
import * as engine from "./engine.js";

let chapter = null;

/** Open the cell of the page with this id, and run it; `address` is that of the page's code. */
export async function openCell(id, address) {
  chapter ??= fetch(address, { cache: "no-cache" }).then(async (answer) => {
    if (!answer.ok) throw new Error(`${answer.status}: ${address}`);
    return new Chapter(await answer.json());
  });
  chapter.catch(() => { chapter = null; });
  const opened = await chapter;
  const cell = opened.cells.get(id);
  cell.open();
  opened.run(cell);
}

class Chapter {
  #started = false;
  #busy = null;
  /** Cells that wait for their turn. */
  #waiting = new Set();
  /** The parts that ran in this Python, by name, and the cells whose last run ended with an error. */
  #ran = new Map();
  #failed = new Set();

  constructor({ cells }) {
    this.cells = new Map(cells.map((given) => [given.id, new Cell(given, {
      run: (cell) => this.run(cell),
      stop: (cell) => this.#stop(cell),
      reset: (cell) => this.#reset(cell),
    })]));
    for (const cell of this.cells.values()) if (cell.kept) cell.open();
    addEventListener("pagehide", () => this.cells.forEach((cell) => cell.keep()));
  }

  /** Run a cell, after what stands above it, gives names that it uses and has not run as it is. */
  async run(cell) {
    if (this.#busy === cell) return;
    if (this.#busy) {
      this.#waiting.add(cell);
      cell.wait();
      return;
    }
    this.#busy = cell;
    const [began, needed] = [performance.now(), this.#needed(cell)];
    cell.begin();
    try {
      if (!this.#started) await this.#start(cell, needed);
      const failed = await this.#runAbove(cell, needed);
      cell.say(await this.#runOne(cell.whole, cell, "Running …") ? "It ended with an error." : "Done.");
      if (failed.length) cell.pointTo(failed);
    } catch (error) {
      this.#started = false;
      this.#ran.clear();
      this.#failed.clear();
      cell.say(error instanceof engine.Stopped
        ? `Stopped after ${((performance.now() - began) / 1000).toFixed(0)} s, without output, and Python with it. Run starts it again.`
        : `Python ended: ${error.message} Run starts it again.`);
    } finally {
      this.#busy = null;
      cell.end();
      this.#runNext();
    }
  }

  #runNext() {
    const [next] = this.#waiting;
    if (!next) return;
    this.#waiting.delete(next);
    this.run(next);
  }

  #stop(cell) {
    if (this.#busy === cell) {
      engine.stop();
    } else if (this.#waiting.delete(cell)) {
      cell.end();
      cell.say("");
    }
  }

  /** The parts above whose names a cell uses, and whose names these use. */
  #needed(cell) {
    const all = [...this.cells.values()];
    const above = all.slice(0, all.indexOf(cell)).flatMap((each) => each.parts);
    const [words, found] = [new Set(cell.whole.words), new Set()];
    const isNeeded = (each) => !found.has(each) && each.gives.some((name) => words.has(name));
    for (let next = above.find(isNeeded); next; next = above.find(isNeeded)) {
      found.add(next);
      next.words.forEach((word) => words.add(word));
    }
    return above.filter((each) => found.has(each));
  }

  /** Start Python, with what the cell and those that it needs import. */
  async #start(cell, needed) {
    const code = [...needed, cell].map((each) => each.code).join("\n");
    cell.say("Loading Python …");
    await engine.start((arrived, wanted) => {
      cell.loading(arrived, wanted, "Starting Python …");
    }, code);
    this.#started = true;
  }

  /** Return the needed cells that ended with an error; their other lines may have run. */
  async #runAbove(cell, needed) {
    const above = needed.filter(({ name, code }) => this.#ran.get(name)?.code !== code);
    for (const [k, part] of above.entries()) {
      await this.#runOne(part, cell, `Running the cells above: ${k + 1} of ${above.length} …`);
    }
    // A cell that cannot run to its end has lines that others need.
    const cells = new Set(needed.map((part) => part.cell));
    return [...cells].filter((each) => this.#failed.has(each) && !each.cannot);
  }

  /** Run a part while the cell that the reader has asked for, `asked`, says these words. */
  async #runOne(part, asked, words) {
    const { cell, code } = part;
    asked.say(words);
    const result = await engine.run(code, (...bytes) => asked.loading(...bytes, words));
    this.#ran.set(part.name, part);
    if (result.error) this.#failed.add(cell);
    else this.#failed.delete(cell);
    const changed = [...this.#ran.values()].some((each) => each.isTheReaders);
    if (cell.isOpen) cell.show(result, changed);
    return result.error;
  }

  #reset(cell) {
    this.#stop(cell);
    cell.close();
  }
}
