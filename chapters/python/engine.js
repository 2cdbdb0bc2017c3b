/**
 * Python behind three calls; nothing else of the page knows which one it is.
 *
 * `start(progress)` resolves when Python is there; `progress(bytes)` is told what has arrived.
 * `run(code)` resolves to `{text, shown, error}`: what was printed; a list of `{data, metadata}`,
 * each thing shown by its types; a traceback to read, or null. One runs at a time.
 * `stop()` ends what runs, and Python with it: what was asked is rejected with `Stopped`, and
 * `start` begins anew.
 */
let worker = null;
let asked = null;

export class Stopped extends Error {}

export function start(progress) {
  const address = new URL("worker.js", import.meta.url);
  worker = new Worker(address, { type: "module" });
  worker.onmessage = ({ data }) => {
    if ("bytes" in data) asked?.progress?.(data.bytes);
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
