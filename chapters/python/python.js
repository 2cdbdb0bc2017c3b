const HOME = "/home/pyodide";

/**
 * Python with the course's library, which loads packages when they are imported. `load` is
 * Pyodide's `loadPyodide`, `at` the address of the folder with `pyodide/`, `wheels/` and these
 * modules. `files` reads what is below that address: `text(name)` and `bytes(name)` promise it,
 * `bytesNow(name)` waits for it. `files.json` names those that Python finds in its home. The
 * imports in the code `first` are made while the reader waits.
 * Returns `run(code)`, and `ask(asked, tell)`, which puts `files` there, asks `module` a `question`
 * with what is `given`, and has `tell(words)` told what it does.
 */
export async function startPython(load, at, files, first) {
  const { packages } = JSON.parse(await files.text("wheels/page-lock.json"));
  const shelf = new Shelf(files, packages);
  const [python, names] = await Promise.all([
    load({
      indexURL: `${at}pyodide/`,
      lockFileURL: `${at}wheels/page-lock.json`,
      stdLibURL: `${at}wheels/python_stdlib.zip`,
      env: { HOME, MPLBACKEND: "module://page_figures" },
    }),
    files.text("files.json").then(JSON.parse),
    shelf.fetch(shelf.named(first)),
  ]);
  await Promise.all(names.map(async (name) => {
    const path = `${HOME}/${name}`;
    python.FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    python.FS.writeFile(path, await files.text(name));
  }));
  const session = python.pyimport("page_session");
  const missing = session.prepare(JSON.stringify(packages), shelf.read, (path) => link(python, path));
  const bring = async (code) => {
    while (await shelf.fetch(missing(code)));
  };
  await bring(first);
  return {
    run: async (code) => {
      await bring(code);
      return JSON.parse(session.run(code));
    },
    ask: ({ module, question, given, files: own }, tell) => {
      for (const [name, bytes] of Object.entries(own)) python.FS.writeFile(`${HOME}/${name}`, bytes);
      return JSON.parse(python.pyimport(module).ask(question, JSON.stringify(given), tell));
    },
  };
}

/** The archives of packages that have been fetched and not yet been unpacked. */
class Shelf {
  #files;
  #packages;
  #fetched = new Map();
  #asked = new Set();

  constructor(files, packages) {
    this.#files = files;
    this.#packages = packages;
  }

  /** The archives of what the code imports by name; what those import in turn is not seen. */
  named(code) {
    const found = code.matchAll(/^[ \t]*(?:from|import)[ \t]+(\w+)/gm);
    const imported = new Set([...found].map(([, name]) => name));
    return Object.values(this.#packages)
      .filter(({ imports }) => imports.some((name) => imported.has(name)))
      .flatMap(({ file_name: own, depends }) => [
        own, ...depends.map((name) => this.#packages[name].file_name),
      ]);
  }

  /** Fetch archives that were not asked for before; resolves to whether there were some. */
  async fetch(names) {
    const wanted = [...new Set(names)].filter((name) => !this.#asked.has(name));
    await Promise.all(wanted.map(async (name) => {
      this.#asked.add(name);
      this.#fetched.set(name, await this.#files.bytes(place(name)));
    }));
    return wanted.length > 0;
  }

  read = (name, mayWait) => {
    const bytes = this.#fetched.get(name) ?? (mayWait ? this.#files.bytesNow(place(name)) : null);
    if (bytes) this.#fetched.delete(name);
    return bytes;
  };
}

/** Pyodide's list starts from the folder `pyodide`. */
const place = (name) => name.replace("../", "");

/** Start a library on which others rely: they look for it by its name alone. */
function link({ FS, _module: { LDSO, loadDynamicLibrary } }, path) {
  const fs = { findObject: (name) => FS.analyzePath(name).object, readFile: (name) => FS.readFile(name) };
  loadDynamicLibrary(path, { loadAsync: false, nodelete: true, allowUndefined: true, global: true, fs });
  LDSO.loadedLibsByName[path.split("/").at(-1)] = LDSO.loadedLibsByName[path];
}
