/**
 * Runs all code cells of chapters in Python of the page, here in Node: `run_cells.mjs FOLDER LIST`
 * with the site's folder `python` and one chapter's list of cells. Writes a JSON array of
 * `{id, cannot, text, shown, error, seconds}` to standard output.
 */
import { readFileSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";

const [folder, list] = process.argv.slice(2);
const at = (name) => pathToFileURL(`${folder}/${name}`).href;
const { loadPyodide } = await import(at("pyodide/pyodide.mjs"));
const { startPython } = await import(at("python.js"));

const text = (path) => readFile(path, "utf8");
const { cells } = JSON.parse(await text(list));
const files = {
  text: (name) => text(`${folder}/${name}`),
  bytes: async (name) => new Uint8Array(await readFile(`${folder}/${name}`)),
  bytesNow: (name) => new Uint8Array(readFileSync(`${folder}/${name}`)),
};
const { run } = await startPython(loadPyodide, `${folder}/`, files, "");
const results = [];
for (const { id, parts, cannot } of cells) {
  const before = process.cpuUsage();
  const result = await run(parts.map(({ code }) => code).join("\n"));
  const { user, system } = process.cpuUsage(before);
  results.push({ id, cannot, ...result, seconds: (user + system) / 1e6 });
}
process.stdout.write(JSON.stringify(results));
