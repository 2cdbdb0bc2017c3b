/**
 * Python with the course's library. `load` is Pyodide's `loadPyodide`, `at` the address of the
 * folder with `pyodide/`, `wheels/` and these modules; `read(name)` gives the text of a file
 * beside this one. Returns `run(code)`.
 */
export async function startPython(load, at, read) {
  const python = await load({
    indexURL: `${at}pyodide/`,
    lockFileURL: `${at}wheels/pyodide-lock.json`,
    env: { HOME: "/home/pyodide", MPLBACKEND: "module://page_figures" },
    packages: ["robust-slam"],
  });
  for (const name of ["page_session.py", "page_figures.py"]) {
    python.FS.writeFile(`/home/pyodide/${name}`, await read(name));
  }
  const session = python.pyimport("page_session");
  session.prepare();
  // What nearly every chapter imports, so that the wait is over when the first cell runs.
  python.runPython("import matplotlib.pyplot, robust_slam.problems");
  return (code) => JSON.parse(session.run(code));
}
