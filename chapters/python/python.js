const HOME = "/home/pyodide";

/**
 * Python with the course's library. `load` is Pyodide's `loadPyodide`, `at` the address of the
 * folder with `pyodide/`, `wheels/` and these modules; `read(name)` gives the text of a file
 * beside this one. `files.json` names those that Python finds in its home. Returns `run(code)`.
 */
export async function startPython(load, at, read) {
  const python = await load({
    indexURL: `${at}pyodide/`,
    lockFileURL: `${at}wheels/pyodide-lock.json`,
    env: { HOME, MPLBACKEND: "module://page_figures" },
    packages: ["robust-slam"],
  });
  for (const name of JSON.parse(await read("files.json"))) {
    const path = `${HOME}/${name}`;
    python.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    python.FS.writeFile(path, await read(name));
  }
  const session = python.pyimport("page_session");
  session.prepare();
  // What nearly every chapter imports, so that the wait is over when the first cell runs.
  python.runPython("import matplotlib.pyplot, robust_slam.problems");
  return (code) => JSON.parse(session.run(code));
}
