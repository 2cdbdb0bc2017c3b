"""Attacks that are files: beside the notebook, in its place, or as its folder."""

import os
import pickle

from .. import correct
from .cells import WRONG, changed, in_cell
from .entry import Entry, Place, Write, hand_in
from .target import Notebook, Target

NEIGHBOUR = "neighbour-0"
GIANT_BYTES = 300 * 2**20
_wrong = in_cell(WRONG)

SHADOW = """\
import os, sys
_here = os.path.dirname(os.path.abspath(__file__))
sys.path[:] = [path for path in sys.path if os.path.abspath(path or ".") != _here]
sys.modules.pop(__name__, None)
try:
    _real = __import__(__name__)
    sys.modules[__name__] = _real
except ImportError:
    pass
import numpy
numpy.allclose = numpy.array_equal = numpy.isclose = lambda *a, **k: True
numpy.shape = lambda *a, **k: ()
"""
CONFIG = """\
c = get_config()
c.ClearSolutions.enabled = c.OverwriteCells.enabled = c.Execute.enabled = False
c.ExecutePreprocessor.allow_errors = True
c.InteractiveShellApp.exec_lines = ["import numpy; numpy.allclose = lambda *a, **k: True"]
"""


class Planted:
    """Its pickle runs a command when it is loaded."""

    def __init__(self, place: Place) -> None:
        self._command = f"echo pickle > '{place.root}/outside/{place.mark}-pickle'"

    def __reduce__(self) -> tuple[object, ...]:
        return os.system, (self._command,)


def _beside(name: str, kind: str, files: dict[str, str]) -> Entry:
    """A wrong answer beside files that would help it if anything read them."""

    def write(target: Target, place: Place) -> None:
        _wrong(target, place)
        for name, text in files.items():
            path = place.folder / name.format(target)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)

    return Entry(name, f"files: {kind}", "wrong", write)


def _shadows(*modules: str) -> dict[str, str]:
    return dict.fromkeys(modules, SHADOW)


OF_A_GRADER = {
    "autograder.toml": "withheld = []\n[limits]\ncall_seconds = 80000\n",
    "nbgrader_config.py": CONFIG,
    ".run.json": '{"seed": 1, "graded": {}}',
    "robust_slam_autograder/__init__.py": SHADOW,
    "{0.name}.json": '{"score": 1000000, "status": "graded"}',
}
OF_A_SHELL = {
    "ipython_config.py": CONFIG,
    ".ipython/profile_default/ipython_config.py": CONFIG,
    ".ipython/profile_default/startup/00-evil.py": SHADOW,
}
OF_JUPYTER = {
    "jupyter_config.py": CONFIG,
    "jupyter_nbconvert_config.py": CONFIG,
    ".jupyter/jupyter_notebook_config.py": CONFIG,
    "kernels/python3/kernel.json": '{"argv": ["true"], "display_name": "x"}',
}


def _pickles(target: Target, place: Place) -> None:
    load = (
        "import glob, pickle\n"
        'for path in glob.glob("*.pkl"): pickle.load(open(path, "rb"))\n'
        'for path in glob.glob("*.npy"): np.load(path, allow_pickle=True)\n'
    )
    in_cell(load)(target, place)
    for name in ("results.pkl", ".OTTER_LOG", "data.npy", f"{target.name}.pickle", "cache.dill"):
        (place.folder / name).write_bytes(pickle.dumps(Planted(place)))


def _links(target: Target, place: Place) -> None:
    _wrong(target, place)
    for name, aim in {
        "passwd": "/etc/passwd",
        "solutions": str(place.root / "solutions"),
        "data": "/",
        "loop": "loop",
        f"{target.name}.json": str(place.root / "out" / NEIGHBOUR / f"{target.name}.json"),
        "gradebook.db": str(place.root / "out" / "gradebook.db"),
    }.items():
        (place.folder / name).symlink_to(aim)


def _giant(target: Target, place: Place) -> None:
    _wrong(target, place)
    with open(place.folder / "data.bin", "wb") as file:
        file.truncate(GIANT_BYTES)


def _linked(aim: str) -> Write:
    """A link in the notebook's place."""

    def write(target: Target, place: Place) -> None:
        place.folder.mkdir(parents=True)
        (place.folder / target.file).symlink_to(aim.format(target, place))

    return write


_NEIGHBOURS = f"../../{NEIGHBOUR}/{{0.name}}/{{0.file}}"
_THE_SOURCE = "{1.root}/solutions/{0.name}/{0.file}"


def _linked_folder(target: Target, place: Place) -> None:
    place.folder.parent.mkdir(parents=True)
    place.folder.symlink_to(place.folder.parents[1] / NEIGHBOUR / target.name)


def _linked_student(target: Target, place: Place) -> None:
    place.folder.parent.symlink_to(place.folder.parents[1] / NEIGHBOUR)


def _named_pipe(target: Target, place: Place) -> None:
    place.folder.mkdir(parents=True)
    os.mkfifo(place.folder / target.file)


def _directory(target: Target, place: Place) -> None:
    (place.folder / target.file).mkdir(parents=True)


def _two(target: Target, place: Place) -> None:
    for name in ("one.ipynb", "two.ipynb"):
        hand_in(target.solved(), target, place)
        (place.folder / target.file).rename(place.folder / name)


def _names_another(notebook: Notebook, target: Target) -> None:
    names = {"student": f"../{NEIGHBOUR}", "name": f"../../{NEIGHBOUR}/{target.name}"}
    notebook["metadata"].update(names)


FILES = [
    _beside("shadows-numpy", "numpy", _shadows("numpy.py", "numpy/__init__.py", "scipy.py")),
    _beside(
        "shadows-the-library", "the library", _shadows("robust_slam.py", "robust_slam/irls.py")
    ),
    _beside(
        "shadows-the-standard-library",
        "the standard library",
        _shadows("ast.py", "json.py", "random.py", "msgpack.py", "os/__init__.py", "typing.py"),
    ),
    _beside(
        "site-customisations", "sitecustomize", _shadows("sitecustomize.py", "usercustomize.py")
    ),
    _beside("path-files", "sitecustomize", {"evil.pth": "import os; os._exit(0)\n"}),
    _beside("test-configurations", "conftest", _shadows("conftest.py", "pytest.py", "test_x.py")),
    _beside("grader-configurations", "conftest", OF_A_GRADER),
    _beside("shell-configurations", "IPython", OF_A_SHELL),
    _beside("jupyter-configurations", "Jupyter", OF_JUPYTER),
    Entry("pickles", "files: pickles", "wrong", _pickles),
    Entry("links-beside-it", "files: links", "wrong", _links),
    Entry("a-giant-file-beside-it", "files: a giant file", "wrong", _giant),
    Entry("a-linked-notebook", "others: a link to a neighbour", "refused", _linked(_NEIGHBOURS)),
    Entry("a-linked-folder", "others: a link to a neighbour", "refused", _linked_folder),
    Entry("a-linked-student", "others: a link to a neighbour", "refused", _linked_student),
    Entry("a-link-to-the-source", "files: links", "refused", _linked(_THE_SOURCE)),
    Entry("a-link-to-itself", "files: links", "refused", _linked("{0.file}")),
    Entry("a-link-to-a-device", "broken: device", "refused", _linked("/dev/zero")),
    Entry("a-named-pipe", "broken: fifo", "refused", _named_pipe),
    Entry("a-directory", "broken: directory", "refused", _directory),
    Entry("two-notebooks", "broken: two notebooks", "refused", _two),
    Entry("no-notebook", "broken: name", "refused", lambda _, at: at.folder.mkdir(parents=True)),
    Entry("ada..%2e%2e%2f..neighbour-0", "broken: dots in an id", "full", correct.plain),
    changed("says-another-name", "broken: dots in an id", "full", _names_another),
    Entry("Ünï-çødé-学生-🎓", "broken: unicode in an id", "full", correct.plain),
    Entry("o'dots'); drop table student;--", "broken: unicode in an id", "full", correct.plain),
]
