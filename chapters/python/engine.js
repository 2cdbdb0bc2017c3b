/**
 * Python behind four calls; nothing else of the page knows which one it is.
 *
 * `start(progress, first)` resolves when Python is there and has imported the modules `first`;
 * `progress(bytes)` is told what has arrived.
 * `run(code)` resolves to `{text, shown, error}`: what was printed; a list of `{data, metadata}`,
 * each thing shown by its types; a traceback to read, or null. One runs at a time.
 * `ask({module, question, given, files}, tell)` resolves to what a module of the page answers;
 * `tell(words)` is told what it does.
 * `stop()` ends what runs, and Python with it: what was asked is rejected with `Stopped`, and
 * `start` begins anew.
 */
/** What nearly every chapter imports, so that the wait is over when the first cell runs. */
const FIRST = "matplotlib.pyplot, robust_slam.problems";
let worker = null;
let asked = null;

export class Stopped extends Error {}

export function start(progress, first = FIRST) {
  const address = new URL("worker.js", import.meta.url);
  worker = new Worker(address, { type: "module", name: first });
  worker.onmessage = ({ data }) => {
    if ("bytes" in data) asked?.progress?.(data.bytes);
    else if ("words" in data) asked?.progress?.(data.words);
    else if ("failed" in data) end(new Error(data.failed));
    else asked.resolve(data.done);
  };
  worker.onerror = ({ message }) => {
    end(new Error(message ?? "The files of Python could not be loaded."));
  };
  return answer(progress);
}

export function run(code) {
  worker.postMessage({ code });
  return answer();
}

export function ask(question, tell) {
  worker.postMessage(question);
  return answer(tell);
}

export function stop() {
  end(new Stopped());
}

function answer(progress) {
  return new Promise((resolve, reject) => { asked = { resolve, reject, progress }; });
}

/** After a failure inside Pyodide, too, nothing runs any more: the next start is a new one. */
function end(error) {
  worker?.terminate();
  worker = null;
  asked?.reject(error);
  asked = null;
}
