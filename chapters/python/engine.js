/**
 * Python behind four calls; nothing else of the page knows which one it is.
 *
 * `start(progress, first)` resolves when Python is there, with what the code `first` imports.
 * `run(code, progress)` resolves to `{text, shown, error}`: what was printed; a list of
 * `{data, metadata}`, each thing shown by its types; a traceback to read, or null. One runs at a
 * time. Packages are loaded when code imports them: `progress(arrived, wanted)` is told in bytes
 * how much of what was asked for since the start has arrived.
 * `ask({module, question, given, files}, tell)` resolves to what a module of the page answers;
 * `tell(words)` is told what it does.
 * `stop()` ends what runs, and Python with it: what was asked is rejected with `Stopped`, and
 * `start` begins anew.
 */
let worker = null;
let asked = null;

export class Stopped extends Error {}

export function start(progress, first) {
  const own = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
  worker = own;
  // What an ended worker still had to say must not reach, or end, the one after it.
  own.onmessage = ({ data }) => {
    if (own !== worker) return;
    if ("arrived" in data) asked?.progress?.(data.arrived, data.wanted);
    else if ("words" in data) asked?.tell?.(data.words);
    else if ("failed" in data) end(new Error(data.failed));
    else asked.resolve(data.done);
  };
  own.onerror = ({ message }) => {
    if (own === worker) end(new Error(message ?? "The files of Python could not be loaded."));
  };
  return answer({ what: "start", first }, { progress });
}

export function run(code, progress) {
  return answer({ what: "run", code }, { progress });
}

export function ask(question, tell) {
  return answer({ what: "ask", ...question }, { tell });
}

export function stop() {
  end(new Stopped());
}

function answer(question, listeners) {
  worker.postMessage(question);
  return new Promise((resolve, reject) => { asked = { resolve, reject, ...listeners }; });
}

/** After a failure inside Pyodide, too, nothing runs any more: the next start is a new one. */
function end(error) {
  worker?.terminate();
  worker = null;
  asked?.reject(error);
  asked = null;
}
