/** Fetches what nearly every cell needs into the browser's cache; nothing of it is started. */
const FIRST = ["numpy", "lazy-loader", "robust-slam", "robust-slam-course"];
const OF_PYTHON = ["pyodide/pyodide.asm.js", "pyodide/pyodide.asm.wasm", "wheels/python_stdlib.zip"];
const SCRIPTS = ["chapter.js", "worker.js"];

const fetched = (name) => fetch(new URL(name, import.meta.url), { priority: "low" });
const { packages } = await (await fetched("wheels/page-lock.json")).json();
const archives = FIRST.map((name) => packages[name].file_name.replace("../", ""));
for (const name of [...OF_PYTHON, ...archives, ...SCRIPTS]) await (await fetched(name)).arrayBuffer();
