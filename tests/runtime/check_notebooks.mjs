// Runs `check` on notebooks in Pyodide, as JupyterLab in the browser does, and writes what it prints.
// node check_notebooks.mjs RUNTIME FOLDER: FOLDER holds <name>/<assignment>.ipynb; the output is JSON.
import { readdirSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [runtime, folder] = process.argv.slice(2).map((path) => resolve(path));
const { loadPyodide } = await import(pathToFileURL(`${runtime}/pyodide/pyodide.mjs`));
const said = [];
const python = await loadPyodide({
  indexURL: `${runtime}/pyodide/`,
  lockFileURL: `${runtime}/wheels/pyodide-lock.json`,
  stdout: (line) => said.push(line),
  stderr: (line) => said.push(line),
  env: { HOME: "/home/pyodide", MPLBACKEND: "agg" },
});
python.mountNodeFS("/handed-in", folder);
const start = `
import os
from robust_slam_autograder.self_check import check

def run(name, notebook):
    os.chdir(f"/handed-in/{name}")
    check(notebook)
`;
await python.loadPackagesFromImports(start, { messageCallback() {} });
python.runPython(start);
const run = python.globals.get("run");
const found = {};
for (const name of readdirSync(folder).sort()) {
  const notebook = readdirSync(`${folder}/${name}`).find((file) => file.endsWith(".ipynb"));
  said.length = 0;
  run(name, notebook);
  found[name] = said.join("\n");
}
process.stdout.write(JSON.stringify(found));
