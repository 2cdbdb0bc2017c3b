import { loadPyodide } from "./pyodide/pyodide.mjs";
import { startPython } from "./python.js";

const network = self.fetch;
/** The file that could not be loaded, if there is one: Pyodide goes on without it. */
let missing = null;

/**
 * Every file is asked for again, and comes from the browser's cache where it has not changed;
 * what arrives is counted.
 */
self.fetch = async (request, options) => {
  const file = String(request.url ?? request).split("/").at(-1);
  const answer = await network(request, { ...options, cache: "no-cache" }).catch((error) => {
    missing ??= file;
    throw error;
  });
  if (!answer.ok) missing ??= file;
  count(answer.clone().body);
  return answer;
};

async function count(body) {
  const reader = body.getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    self.postMessage({ bytes: part.value.length });
  }
}

const here = new URL(".", import.meta.url).href;
const read = async (name) => (await fetch(here + name)).text();
const started = startPython(loadPyodide, here, read, self.name);
started.then(
  () => self.postMessage({ done: true }),
  (error) => self.postMessage({ failed: told(error) }),
);

/** What went wrong, in a line. */
function told(error) {
  return missing === null
    ? String(error).trim().split("\n").at(-1)
    : `The file ${missing} could not be loaded. Look at the connection, and try again.`;
}

self.onmessage = async ({ data }) => {
  const { run, ask } = await started;
  const tell = (words) => self.postMessage({ words });
  try {
    self.postMessage({ done: "code" in data ? run(data.code) : ask(data, tell) });
  } catch (error) {
    self.postMessage({ failed: told(error) });
  }
};
