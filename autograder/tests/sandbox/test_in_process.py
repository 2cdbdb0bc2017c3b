"""A check in one process finds what a check in two finds, and leaves nothing behind."""

import getpass
import os
import sys

import matplotlib.pyplot as plt
import numpy as np
import pytest
from robust_slam_autograder.executor.session import SessionFault, StudentError
from robust_slam_autograder.sandbox import InProcess, Unsandboxed

from .. import sessions

CELLS = (
    "import numpy as np\ndef f(x):\n    return 2 * np.asarray(x)\ndef same(x):\n    return x\n",
    "def g(h, x):\n    return h(h(x))\nvalue = (1, [2.5, 'three'], {'four': np.arange(3)})\n",
    "def stops(x):\n    raise ValueError(f'not {x}')\ndef ends():\n    exit()\n",
)
NAMES = ("f", "g", "same", "value", "stops", "ends", "missing")


@pytest.fixture(params=[InProcess, Unsandboxed], ids=["one process", "two processes"])
def wall(request):
    return request.param()


def test_values_and_functions_cross_as_copies(wall):
    with sessions.started(*CELLS, names=NAMES, wall=wall) as session:
        found = session.bindings()
        assert sorted(found) == ["ends", "f", "g", "same", "stops", "value"]
        np.testing.assert_array_equal(found["f"]([1, 2]), [2, 4])
        given = np.ones(3, dtype=np.float32)
        assert found["f"](given).dtype == np.float64
        assert found["g"](lambda x: x + 1, 3) == 5
        assert found["same"](abs) is abs and found["g"](found["same"], 3) == 3
        assert found["value"][:2] == (1, [2.5, "three"])
        with pytest.raises(TypeError, match="cannot cross"):
            found["f"](object())


def test_nobody_is_asked_for_a_password(wall, monkeypatch):
    """A lab's kernel puts a function of its own there, which waits for an answer."""
    monkeypatch.setattr(getpass, "getpass", lambda *args, **options: "typed")
    with sessions.started("import getpass\na = getpass.getpass('?')", wall=wall) as session:
        (error,) = session.errors.values()
        assert isinstance(error, EOFError)
    assert getpass.getpass() == "typed"


def test_errors_cross_with_their_class_and_line(wall):
    with sessions.started(*CELLS, names=NAMES, wall=wall) as session:
        found = session.bindings()
        with pytest.raises(ValueError, match="not 7") as raised:
            found["stops"](7)
        assert isinstance(raised.value, StudentError) and raised.value.line == 2
        with pytest.raises(StudentError):
            found["ends"]()
        assert found["f"](1) == 2


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("import scipy.optimize", "scipy.optimize is withheld"),
        ("from scipy import optimize", "scipy.optimize is withheld"),
        ("import scipy as sp; sp.optimize", "scipy.optimize is withheld"),
        ("from scipy.spatial import distance", ""),
        ("import sympy", "sympy is not available in this assignment"),
        ("import subprocess", "subprocess is not available in this assignment"),
        ("input()", "EOF when reading a line"),
    ],
)
def test_what_may_be_imported_is_the_same(wall, line, says):
    import scipy.optimize as ours  # the grader's side may have it

    options = {"withheld": ("scipy.optimize",), "packages": ("numpy", "scipy")}
    with sessions.started(f"{line}\ndef f(): pass", wall=wall, **options) as session:
        said = [str(error) for error in session.errors.values()]
    assert len(said) == bool(says) and all(says in text for text in said)
    assert sys.modules["scipy.optimize"] is ours


@pytest.mark.parametrize(
    "ask",
    [
        "import matplotlib\nmatplotlib.use('TkAgg')",
        "from matplotlib import use\nuse('module://no_such.backend', force=True)",
        "import matplotlib.pyplot as plt\nplt.switch_backend('QtAgg')",
        "import matplotlib\nmatplotlib.rcParams['backend'] = 'MacOSX'",
        "%matplotlib gtk4",
    ],
)
def test_every_graphical_back_end_is_agg(wall, ask):
    cell = f"{ask}\nimport matplotlib.pyplot as plt\nplt.figure()\nplt.show()\n"
    get = "def f():\n    return type(plt.gcf().canvas).__name__"
    options, before = {"names": ("f",), "packages": ("matplotlib",)}, plt.switch_backend
    with sessions.started(cell + get, wall=wall, **options) as session:
        assert not session.errors and session.bindings()["f"]() == "FigureCanvasAgg"
    assert plt.switch_backend is before


def test_nothing_is_left_behind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    main, finders, backend = sys.modules["__main__"], list(sys.meta_path), plt.get_backend()
    figures = plt.get_fignums()
    cell = "import matplotlib.pyplot as plt\nplt.figure()\nopen('scratch', 'w').close()\nx = 1"
    with sessions.started(cell, names=("x",), wall=InProcess()) as session:
        assert session.bindings() == {"x": 1} and not session.errors
    assert sys.modules["__main__"] is main and sys.meta_path == finders
    assert plt.get_fignums() == figures and plt.get_backend() == backend
    assert os.getcwd() == str(tmp_path) and not list(tmp_path.iterdir())


def test_after_a_fault_the_next_case_has_a_fresh_notebook():
    with sessions.started("count = []\ndef f():\n    count.append(1)\n    return len(count)",
                          wall=InProcess()) as session:  # fmt: skip
        found = session.bindings()
        assert found["f"]() == 1 and found["f"]() == 2
        session.fail("timeout")
        with pytest.raises(SessionFault):
            found["f"]()
        session.begin()
        assert session.bindings()["f"]() == 1
