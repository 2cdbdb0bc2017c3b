// Compiles the modules below a folder in place with Pyodide's own Python: node compiled.mjs PYODIDE FOLDER.
// FOLDER/<archive>/a/b.py gets a b.pyc beside it, which never looks for its source.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [pyodide, folder] = process.argv.slice(2).map((path) => resolve(path));
const { loadPyodide } = await import(pathToFileURL(`${pyodide}/pyodide.mjs`));
const python = await loadPyodide({ indexURL: `${pyodide}/` });
python.mountNodeFS("/sources", folder);
python.runPython(`
from pathlib import Path
from py_compile import PycInvalidationMode, compile

LIBRARY = Path("/lib/python3.12")
for archive in Path("/sources").iterdir():
    is_wheel = archive.name.endswith(".whl")
    home = LIBRARY / "site-packages" if is_wheel else LIBRARY.with_name("python312.zip")
    for path in archive.rglob("*.py"):
        told = home / path.relative_to(archive)
        # Templates among them are no Python: they stay as they are.
        compile(path, f"{path}c", str(told), quiet=2, invalidation_mode=PycInvalidationMode.UNCHECKED_HASH)
`);
