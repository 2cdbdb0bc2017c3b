"""The assignments in JupyterLab in the browser: a static site, made by JupyterLite."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from robust_slam_autograder.publishing.course import hand_in

from tools.runtime import wheels
from tools.runtime.pyodide import RuntimeUnavailable

SOURCES = ("assignments", "build/release")
"""Where released assignments are: the public course has the first, the instructor's the second."""
KERNEL = "@jupyterlite/pyodide-kernel-extension"
PYTHON = "./../python/pyodide/pyodide.js"
"""Pyodide's address, from the site's."""
EXTENSIONS = ("@jupyter-widgets/jupyterlab-manager", "anywidget")
"""Extensions of the environment that the site takes, for widgets and live pictures."""
SAYS = 'pygments_lexer:"ipython3",version:'
"""Before the version that the kernel has saved in notebooks: always 3.8, whatever it runs."""
STARTED = (
    *("ssl", "sqlite3", "micropip", "piplite", "ipykernel", "comm", "pyodide_kernel", "jedi"),
    *("ipython", "matplotlib-fontlist"),
)
"""Packages that the kernel starts with. Whatever it lacks it would look for elsewhere."""
CONFIG = "autograder.toml"
LABELS = "misconceptions.json"
"""What a release has for the student's own check; the second only where it was made."""
README = """\
# Assignments in the browser

1. Open a notebook on the left, here `{name}.ipynb`. Write your functions in the cells that say
   so, and run the cells below each of them with *Shift* and *Enter*. Python starts first, which
   takes a minute.
2. To run all visible checks at once, save the notebook (*Ctrl* and *S*), and run this in a cell of
   your own at its end. It prints what the command `autograder check` prints:

   ```python
   from robust_slam_autograder.self_check import check

   check("{name}.ipynb")
   ```

3. To hand in, choose *File › Download*. {hand_in} Hidden checks are run by your instructor.

**Your work is kept in this browser, on this computer, and nowhere else** until you download it.
It is lost with the browser's data, and when a private window is closed. Download it at the end of
each session.

A loop that does not end: the button ■ above the notebook stops it, and Python with it. What you
wrote stays; run the cells above again.

When an assignment is corrected after you have opened it, you are asked whether you want the new
one; your own copy then stays beside it.

The course's library is version {version}.
"""
SCRIPT = Path(__file__).with_name("lab.js")
RELEASES = "releases.json"
"""Beside the script: the digest of each notebook, which its metadata hold too."""
NEEDLESS = ("view", "tabs", "settings", "help")
"""Menus of JupyterLab that a student does not need."""
_OVERRIDES: dict[str, object] = {
    # `check` reads the saved file. Two saves that meet are not two people's.
    "@jupyterlab/docmanager-extension:plugin": {
        "autosaveInterval": 30,
        "lastModifiedCheckMargin": 10_000,
    },
    "@jupyterlab/apputils-extension:notification": {"fetchNews": "false"},
    # JupyterLite's menu lacks the first; the others hold nothing that an assignment asks for.
    "@jupyterlab/mainmenu-extension:plugin": {
        "menus": [
            {"id": "jp-mainmenu-file", "items": [{"command": "docmanager:download", "rank": 6}]},
            *({"id": f"jp-mainmenu-{name}", "disabled": True} for name in NEEDLESS),
        ]
    },
    # So that the browser's own search finds all cells.
    "@jupyterlab/notebook-extension:tracker": {"windowingMode": "none"},
}


def build(root: Path, runtime: Path, packages: Path) -> None:
    """Make the site of a course in ``runtime/lab``; it expects ``python/`` beside itself.

    JupyterLite is installed in the folder ``packages``.

    Raises:
        RuntimeUnavailable: nothing was released, or JupyterLite fails.
    """
    out = runtime / "lab"
    shutil.rmtree(out, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="jupyterlite-") as temporary:
        site = Path(temporary)
        releases = _copy_assignments(root, site / "files", wheels.version(runtime / "wheels"))
        _write(site / "jupyter_lite_config.json", _build_settings(packages))
        _write(site / "jupyter-lite.json", _settings())
        _write(site / "overrides.json", _OVERRIDES)
        command = [sys.executable, "-m", "jupyterlite_core", "build", "--lite-dir", str(site)]
        command += ["--contents", str(site / "files"), "--output-dir", str(out)]
        environment = os.environ | {"PYTHONPATH": str(packages), "PYTHONNOUSERSITE": "1"}
        done = subprocess.run(
            command, env=environment, cwd=site, capture_output=True, text=True, check=False
        )
    if done.returncode:
        said = (done.stdout + done.stderr).strip().splitlines()
        raise RuntimeUnavailable("\n".join(["JupyterLite could not be built:", *said[-20:]]))
    _write_lock(runtime, out)
    shutil.copyfile(SCRIPT, out / SCRIPT.name)
    _write(out / RELEASES, {"notebooks": releases})
    page = out / "lab" / "index.html"
    script = f'<script type="module" src="../{SCRIPT.name}"></script></head>'
    page.write_text(page.read_text(encoding="utf-8").replace("</head>", script), encoding="utf-8")


def _copy_assignments(root: Path, files: Path, version: str) -> dict[str, str]:
    """Copy the released notebooks, and return the digest of each by its name."""
    folders = [root / name for name in SOURCES if list((root / name).glob("*/*.ipynb"))]
    if not folders:
        raise RuntimeUnavailable("there are no released assignments: make release")
    releases = {}
    for folder in sorted(folders[0].glob("*/")):
        (files / folder.name).mkdir(parents=True)
        for name in (CONFIG, LABELS):
            if (folder / name).is_file():
                shutil.copyfile(folder / name, files / folder.name / name)
        # Beside the folder: a download's name would hold the folder's.
        notebook = f"{folder.name}.ipynb"
        data = (folder / notebook).read_bytes()
        releases[notebook] = hashlib.sha256(data).hexdigest()[:12]
        value = json.loads(data)
        value["metadata"]["robust_slam"] = {"release": releases[notebook]}
        _write(files / notebook, value)
    text = README.format(name=Path(notebook).stem, version=version, hand_in=hand_in(root))
    (files / "README.md").write_text(text, encoding="utf-8")
    return releases


def _build_settings(packages: Path) -> dict[str, object]:
    installed = Path(sys.prefix) / "share" / "jupyter" / "labextensions"
    extensions = [installed / name for name in EXTENSIONS]
    kernel = packages / "share" / "jupyter" / "labextensions" / KERNEL
    return {
        "LiteBuildConfig": {
            "apps": ["lab"],
            "federated_extensions": [str(path) for path in (kernel, *extensions)],
            "ignore_sys_prefix": ["federated_extensions"],
            "no_sourcemaps": True,
            "no_unused_shared_packages": True,
        }
    }


def _settings() -> dict[str, object]:
    python = {
        "pyodideUrl": PYTHON,
        "disablePyPIFallback": True,
        # An option whose name ends with URL is read from the site's own address.
        "loadPyodideOptions": {
            "lockFileURL": "pyodide-lock.json",
            "stdLibURL": "../python/wheels/python_stdlib.zip",
            "packages": list(STARTED),
        },
    }
    return {
        "jupyter-lite-schema-version": 0,
        "jupyter-config-data": {
            "appName": "Robust SLAM",
            "exposeAppInBrowser": True,
            "litePluginSettings": {f"{KERNEL}:kernel": python},
        },
    }


def _write_lock(runtime: Path, out: Path) -> None:
    """Write the list of packages of the site's kernel: the pages' own, and the kernel's."""
    lock = json.loads((runtime / "wheels" / wheels.LOCK).read_text(encoding="utf-8"))
    folder = out / "extensions" / KERNEL / "static" / "pypi"
    for path in sorted(folder.glob("*.whl")):
        name = path.name.split("-")[0].replace("_", "-")
        address = os.path.relpath(path, out)
        lock["packages"][name] = wheels.entry(path, name, f"../../lab/{address}", [], [])
    say_python(out, lock["info"]["python"])
    # The loader reads cells alone, and does not see what the library imports where it needs it.
    lock["packages"]["robust-slam"]["depends"] += ["anywidget", *wheels.ON_PAGES[1:]]
    _write(out / wheels.LOCK, lock)


def say_python(out: Path, version: str) -> None:
    """Have notebooks say which Python wrote them, for the grader's may be an older one.

    Raises:
        RuntimeUnavailable: the kernel has changed, and does not say 3.8 any more.
    """
    for path in (out / "extensions" / KERNEL / "static").glob("*.js"):
        text = path.read_text(encoding="utf-8")
        if f'{SAYS}"3.8"' in text:
            path.write_text(text.replace(f'{SAYS}"3.8"', f'{SAYS}"{version}"'), encoding="utf-8")
            return
    raise RuntimeUnavailable("no script of the kernel says that it is Python 3.8: see say_python")


def _write(path: Path, value: object) -> None:
    path.write_text(json.dumps(value, indent=1), encoding="utf-8")
