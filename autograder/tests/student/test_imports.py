"""What student code may import, and the one sentence that it gets for everything else."""

import sys

import pytest
from robust_slam_autograder.reading.assignment import DEFAULT_PACKAGES
from robust_slam_autograder.student import imports
from robust_slam_autograder.student.imports import refusal

from ..as_user import ended

ALLOWED = ["numpy", "numpy.linalg", "scipy.optimize", "matplotlib.pyplot", "mpl_toolkits.mplot3d"]
ALLOWED += ["math", "collections.abc", "concurrent.futures", "threading", "asyncio", "sqlite3"]
ALLOWED += ["__future__", "__main__", "IPython.display", "tqdm.auto", "urllib.parse", "http"]
REFUSED = ["gtsam", "evo.core", "networkx", "robust_slam", "pytest", "no_such_module"]
REFUSED += ["ctypes", "_ctypes", "ctypes.util", "socket", "subprocess", "urllib.request"]
REFUSED += ["tkinter", "test.support", "http.client", "nbgrader", "numpy_typing_compat"]


@pytest.mark.parametrize("module", ALLOWED)
def test_what_is_allowed_by_default(module):
    assert refusal(module, DEFAULT_PACKAGES) is None


@pytest.mark.parametrize("module", REFUSED)
def test_the_sentence_names_the_module_and_what_is_allowed(module):
    sentence = refusal(module, DEFAULT_PACKAGES)
    assert sentence is not None and sentence.startswith(f"{module} is not available")
    assert "numpy, scipy, matplotlib" in sentence and sentence.count(". ") == 0


@pytest.mark.parametrize("module", ["robust_slam.graphs.se2", "ctypes.util", "urllib.request"])
def test_an_assignment_may_allow_more(module):
    assert refusal(module, ("numpy", module.partition(".")[0])) is None


def test_an_empty_list_allows_the_standard_library_alone():
    assert refusal("math", ()) is None and refusal("numpy", ()) is not None


def run_as_student(text: str, *packages: str, withheld: tuple[str, ...] = ()) -> object:
    names = {"__builtins__": imports.student_builtins(packages, withheld)}
    exec(compile(text, "cell", "exec"), names)
    return names.get("found")


@pytest.mark.parametrize(
    "text",
    [
        "import networkx",
        "import networkx as nx",
        "from networkx import Graph",
        "import numpy, networkx",
        "from urllib import request",
        "def f():\n    import networkx\nf()",
        "exec('import networkx')",
        "__import__('networkx')",
        "import pytest",  # which is in memory already
    ],
)
def test_every_form_of_import_is_judged(text):
    with pytest.raises(ModuleNotFoundError, match=r"is not available in this assignment"):
        run_as_student(text, *DEFAULT_PACKAGES)


def test_packages_import_what_they_need():
    """Pillow is not allowed, and matplotlib draws with it."""
    run_as_student("import PIL", "PIL")
    text = "import matplotlib.image\nfound = matplotlib.image.PIL.__name__"
    assert run_as_student(text, "matplotlib") == "PIL"


def test_the_module_of_a_cell_is_as_ever_but_for_imports():
    text = "import builtins\nfound = set(dir(builtins)) - set(dir(__builtins__))"
    assert run_as_student(text) == set()


def test_other_packages_seem_not_to_be_installed():
    """So that a library that uses one where it is there does in a server as behind the wall."""
    text = (
        "import importlib.metadata, importlib.util, sys\n"
        "from robust_slam_autograder.student.imports import Installed\n"
        "Installed(['numpy'], {}, sys.path[1:4]).install()\n"
        "import numpy, sysconfig\n"
        "importlib.metadata.version('numpy')\n"
        "assert importlib.util.find_spec('networkx') is None\n"
        "sysconfig.get_config_vars()\n"  # reads a module whose name depends on the machine
        "try:\n    import networkx\nexcept ModuleNotFoundError as error:\n    print(error)\n"
    )
    said = ended([sys.executable, "-c", text])
    assert said.stdout.strip() == "No module named 'networkx'", said.stderr
