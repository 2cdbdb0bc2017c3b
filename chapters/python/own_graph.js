/** The page *Your own graph*: a file in, Python in a worker, maps and sentences out. */
import { element } from "./element.js";
import * as engine from "./engine.js";
import { kinds, Maps } from "./own_maps.js";

const MODULE = "page_graph";
/** What has to be loaded before the first file; Matplotlib is not needed. */
const FIRST = `import ${MODULE}`;

const page = document.getElementById("own-graph");
const form = page.querySelector("form");
const part = (name) => page.querySelector(`[data-part=${name}]`);
const say = (name) => page.querySelector(`[data-say=${name}]`);
const button = (name) => page.querySelector(`[data-does=${name}]`);
const [status, progress] = ["[role=status]", "progress"].map((name) => page.querySelector(name));
const chosen = page.querySelector("[name=edge]");
const which = page.querySelector("[name=which]");

let started = false;
let running = false;
/** The number of the last case: what an earlier one still says is not heard. */
let turn = 0;
let source = null;
let solved = null;
let maps = null;
let order = [];

/** Show one part of the results, or hide it. */
function show(name, shown = true) {
  part(name).hidden = !shown;
}

function list(place, sentences) {
  place.replaceChildren(...sentences.map((words) => element("li", {}, words)));
  place.hidden = !sentences.length;
}

function table(place, rows) {
  place.replaceChildren(...rows.flatMap(([name, words]) => [
    element("dt", {}, name), element("dd", {}, words),
  ]));
}

/** What is asked of Python while this case is the last one. */
async function ask(question, given = {}, files = {}) {
  return engine.ask({ module: MODULE, question, given, files }, (words) => {
    status.textContent = `${words.charAt(0).toUpperCase()}${words.slice(1)}`;
  });
}

async function start() {
  if (started) return;
  await engine.start((arrived, wanted) => {
    progress.value = arrived / wanted;
    status.textContent = arrived < wanted
      ? `Loading Python, ${Math.round(wanted / 1e6)} MB, once …` : "Starting Python …";
  }, FIRST);
  started = true;
}

/** Do this, with the bar running, until it ends, fails or is stopped. */
async function run(work) {
  turn += 1;
  const own = turn;
  if (running) stop();
  busy(true);
  try {
    await start();
    progress.removeAttribute("value");
    await work();
  } catch (error) {
    if (own === turn) failed(error);
  } finally {
    if (own === turn) busy(false);
  }
}

function failed(error) {
  started = false;
  status.textContent = error instanceof engine.Stopped
    ? "Stopped. What is shown stays."
    : `Python ended: ${error.message} Read the file again to start it again.`;
  if (!say("other").dataset.done) say("other").textContent = "";
}

function stop() {
  engine.stop();
  started = false;
}

function busy(is) {
  running = is;
  button("stop").setAttribute("aria-disabled", !is);
  button("again").setAttribute("aria-disabled", is || source === null);
  progress.toggleAttribute("data-idle", !is);
  progress.value = 0;
}

/** The options, as Python takes them, and the files that go with them. */
async function options(given, files) {
  const value = (name) => form.elements[name].value;
  for (const name of ["unknown", "indefinite", "not_steps"]) given[name] = value(name);
  if (value("metres") && value("radians")) {
    given.odometry = [Number(value("metres")), Number(value("radians"))];
  }
  const [closures] = form.elements.closures.files;
  if (closures) {
    // Both may have the same name.
    given.closures = closures.name === given.name ? `closures-${closures.name}` : closures.name;
    files[given.closures] = new Uint8Array(await closures.arrayBuffer());
  }
}

/** Read a file, or an example of this name, and solve it; a large one if the reader says so. */
function read(from, { anyway = false, thorough = false } = {}) {
  source = from;
  show("results");
  ["wrong", "read", "many", "maps", "answer", "files"].forEach((name) => show(name, false));
  status.textContent = "Reading the file …";
  return run(async () => {
    const [given, files] = [{}, {}];
    if (typeof from === "string") {
      given.example = from;
    } else {
      given.name = from.name;
      files[from.name] = new Uint8Array(await from.arrayBuffer());
      await options(given, files);
    }
    const found = await ask("read", given, files);
    if (found.problem) wrong(found);
    else whatWasRead(found);
    if (found.problem) return;
    show("many", found.many && !anyway);
    if (!found.many || anyway) await solve(thorough);
  });
}

function wrong({ problem, line, lines }, what = "The file cannot be read.") {
  show("wrong");
  say("problem").textContent = problem;
  say("lines").replaceChildren(...lines.map(([number, text]) => (
    element(number === line ? "mark" : "span", {}, `${String(number).padStart(6)}  ${text}\n`)
  )));
  say("lines").parentElement.hidden = !lines.length;
  if (/Options|option /.test(problem)) part("options").open = true;
  status.textContent = `${what} What to write instead is below.`;
}

function whatWasRead({ name, rows, remarks, many, command }) {
  show("read");
  say("name").textContent = name;
  table(say("facts"), rows);
  list(say("remarks"), remarks);
  say("many").textContent = `pip install "./lib[plot]"\n${command}`;
  if (many) status.textContent = "The file is read. It is large: see below.";
}

async function solve(thorough = false) {
  const found = await ask("solve", { thorough });
  if (found.problem) {
    wrong(found, "The file has no map.");
    return;
  }
  solved = found;
  showMaps();
  showAnswer();
  show("files");
  say("python").textContent = solved.python;
  status.textContent = "The map is there. Asking whether another reading fits better …";
  say("other").textContent = "Asking whether the edges fit better when they are read otherwise …";
  delete say("other").dataset.done;
  const other = await ask("reading");
  say("other").textContent = other.words;
  say("other").dataset.done = "";
  status.textContent = "Done.";
}

function showMaps() {
  show("maps");
  const places = Object.fromEntries(
    ["robust", "plain"].map((name) => [name, page.querySelector(`[data-map=${name}]`)]),
  );
  maps = new Maps(places, solved, pick);
  const [across, up] = solved.axes;
  const unseen = [..."xyz"].find((axis) => !solved.axes.includes(axis));
  const isSpace = /SE\(3\)/.test(say("facts").textContent);
  say("view").textContent = isSpace ? `${across} to the right, ${up} up; seen along ${unseen}` : "";
  const { "is-rejected": rejected, "is-kept": closures } = kinds(solved);
  which.value = rejected.length ? "rejected" : closures.length ? "kept" : "steps";
  sort();
}

/** Put the edges that the reader goes through in order, and choose the first. */
function sort() {
  const look = { rejected: "is-rejected", kept: "is-kept", steps: "is-step" }[which.value];
  order = kinds(solved)[look].sort((a, b) => solved.size[b] - solved.size[a]);
  chosen.max = Math.max(0, order.length - 1);
  chosen.value = 0;
  chosen.disabled = !order.length;
  if (order.length) pick(order[0]);
  else say("edge").textContent = "There is none of this kind.";
}

/** Tell of an edge, and mark it and its cycle. */
function pick(k) {
  const length = maps.mark(k);
  const [i, j] = solved.edges[k].map((end) => solved.names[end]);
  const cycle = length
    ? ` Its cycle takes ${length.toLocaleString("en")} ${length > 1 ? "steps" : "step"}.`
    : " Nothing else joins its ends.";
  const words = `Edge ${i}–${j}: ${solved.about[k]}${cycle}`;
  say("edge").textContent = words;
  const place = order.indexOf(k);
  if (place >= 0) chosen.value = place;
  chosen.setAttribute("aria-valuetext", words);
}

function showAnswer() {
  show("answer");
  say("verdict").textContent = `The map is ${solved.verdict}.`;
  say("verdict").dataset.trusted = solved.trusted;
  table(say("found"), solved.rows);
  list(say("notes"), solved.notes);
  show("late", solved.late);
}

function save(kind) {
  const titles = [...page.querySelectorAll("figcaption")].map((each) => each.textContent);
  const text = kind === "maps.svg" ? maps.picture(titles) : solved.files[kind];
  const stem = say("name").textContent.replace(/\.[^.]*$/, "");
  const href = URL.createObjectURL(new Blob([text]));
  element("a", { href, download: `${stem}-${kind}` }).click();
  setTimeout(() => URL.revokeObjectURL(href), 10_000);
}

async function copy() {
  await navigator.clipboard?.writeText(solved.python).catch(() => {});
  button("copy").textContent = "Copied";
  setTimeout(() => { button("copy").textContent = "Copy"; }, 2500);
}

form.addEventListener("submit", (event) => event.preventDefault());
page.querySelector("#own-file").addEventListener("change", ({ target }) => {
  if (target.files.length) read(target.files[0]);
});
for (const each of page.querySelectorAll("[data-example]")) {
  each.addEventListener("click", () => read(each.dataset.example));
}
for (const each of page.querySelectorAll("[data-file]")) {
  each.addEventListener("click", () => save(each.dataset.file));
}
button("stop").addEventListener("click", () => {
  if (running) stop();
});
button("again").addEventListener("click", () => { if (source !== null) read(source); });
button("on").addEventListener("click", () => read(source, { anyway: true }));
button("thorough").addEventListener("click", () => read(source, { anyway: true, thorough: true }));
button("copy").addEventListener("click", copy);
which.addEventListener("change", sort);
chosen.addEventListener("input", () => pick(order[Number(chosen.value)]));

part("all").disabled = false;

// A file that misses the box would else be opened in place of the page.
const box = page.querySelector(".rs-own-drop");
for (const [kind, over] of [["dragover", true], ["dragleave", false], ["drop", false]]) {
  addEventListener(kind, (event) => {
    event.preventDefault();
    box.classList.toggle("is-over", over);
  });
}
addEventListener("drop", (event) => {
  const [file] = event.dataTransfer.files;
  if (file) read(file);
});
