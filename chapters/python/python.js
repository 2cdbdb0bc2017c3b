const HOME = "/home/pyodide";

/**
 * Python with the course's library. `load` is Pyodide's `loadPyodide`, `at` the address of the
 * folder with `pyodide/`, `wheels/` and these modules; `read(name)` gives the text of a file
 * beside this one. `files.json` names those that Python finds in its home; `first` are the modules
 * to import while the reader waits. Returns `run(code)`, and `ask(asked, tell)`, which puts `files`
 * there, asks `module` a `question` with what is `given`, and has `tell(words)` told what it does.
 */
export async function startPython(load, at, read, first) {
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
  python.runPython(`import ${first}`);
  return {
    run: (code) => JSON.parse(session.run(code)),
    ask: ({ module, question, given, files }, tell) => {
      for (const [name, bytes] of Object.entries(files)) python.FS.writeFile(`${HOME}/${name}`, bytes);
      return JSON.parse(python.pyimport(module).ask(question, JSON.stringify(given), tell));
    },
  };
}
