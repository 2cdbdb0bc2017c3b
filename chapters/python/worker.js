import { loadPyodide } from "./pyodide/pyodide.mjs";
import { startPython } from "./python.js";

const here = new URL(".", import.meta.url).href;
const network = self.fetch;
/** The file that could not be loaded, if there is one: Pyodide goes on without it. */
let missing = null;
/** Bytes that have arrived, of those that were asked for. */
let arrived = 0;
let wanted = 0;
/** The sizes of the files that are counted; Python's own come as one number. */
const sizes = new Map([["pyodide.asm.wasm", 0], ["python_stdlib.zip", 0]]);

/**
 * Every file is asked for again, and comes from the browser's cache where it has not changed;
 * what arrives of the large ones is counted.
 */
self.fetch = async (request, options) => {
  const file = String(request.url ?? request).split("/").at(-1);
  want(file);
  const answer = await network(request, { ...options, cache: "no-cache" }).catch((error) => {
    missing ??= file;
    throw error;
  });
  if (!answer.ok) missing ??= file;
  if (sizes.has(file)) count(answer.clone().body);
  return answer;
};

function want(file) {
  wanted += sizes.get(file) ?? 0;
}

function arrive(bytes) {
  arrived += bytes;
  self.postMessage({ arrived, wanted });
}

async function count(body) {
  const reader = body.getReader();
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    arrive(part.value.length);
  }
}

const files = {
  text: async (name) => {
    const text = await (await fetch(here + name)).text();
    if (name.endsWith("page-lock.json")) learn(JSON.parse(text));
    return text;
  },
  bytes: async (name) => new Uint8Array(await (await fetch(here + name)).arrayBuffer()),
  bytesNow: (name) => {
    const request = new XMLHttpRequest();
    want(name.split("/").at(-1));
    request.open("GET", here + name, false);
    request.responseType = "arraybuffer";
    request.send();
    if (request.status !== 200) throw new Error(`The file ${name} could not be loaded.`);
    arrive(request.response.byteLength);
    return new Uint8Array(request.response);
  },
};

/** Take the sizes of files from the list of packages; Python itself is on its way already. */
function learn({ info, packages }) {
  wanted += info.size;
  for (const { file_name: name, size } of Object.values(packages)) {
    sizes.set(name.split("/").at(-1), size);
  }
}

/** What went wrong, in a line. */
function told(error) {
  return missing === null
    ? String(error).trim().split("\n").at(-1)
    : `The file ${missing} could not be loaded. Look at the connection, and try again.`;
}

let python = null;
const does = {
  start: async ({ first }) => {
    python = await startPython(loadPyodide, here, files, first);
    return true;
  },
  run: ({ code }) => python.run(code),
  ask: (asked) => python.ask(asked, (words) => self.postMessage({ words })),
};

self.onmessage = async ({ data: { what, ...given } }) => {
  try {
    self.postMessage({ done: await does[what](given) });
  } catch (error) {
    self.postMessage({ failed: told(error) });
  }
};
