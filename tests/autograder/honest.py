"""Honest submissions of the toy assignment, each unusual in one way and each right."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.autograder import toy

Write = Callable[[Path], object]
"""Writes the submission into its folder ``submitted/<student>/<assignment>/``."""
Cells = list[dict[str, Any]]

RIGHT = "def double(x):\n    return 2 * np.asarray(x)\n"

SOLUTIONS = {
    "prints": "print('working' * 1000)\n" + RIGHT + "print(double(3))",
    "prints-while-tested": """
def double(x):
    import sys
    print("doubling", x)
    print("doubling", x, file=sys.stderr, flush=True)
    return 2 * np.asarray(x)
""",
    "warns": """
import warnings
def double(x):
    warnings.warn("deprecated", DeprecationWarning)
    return np.asarray(x) + x + np.log(0) * 0 if False else 2 * np.asarray(x)
""",
    "logs": """
import logging
logging.basicConfig(level=logging.DEBUG)
def double(x):
    logging.error("doubling %s", x)
    return 2 * np.asarray(x)
""",
    "plots": """
%matplotlib inline
import matplotlib.pyplot as plt
def double(x):
    return 2 * np.asarray(x)
plt.plot([1, 2], double([1, 2]))
plt.title("doubled")
plt.show()
display(plt.gcf())
""",
    "line-magics": "%load_ext autoreload\n!pip install nothing\nhelp(np.dot)\n"
    + RIGHT
    + "double?\n",
    "cell-magic": "%%time\n" + RIGHT,
    "prompts": ">>> def double(x):\n...     return 2 * np.asarray(x)\n",
    "lambda": "double = lambda x: 2 * np.asarray(x)",
    "callable-object": """
class Doubler:
    def __call__(self, x):
        return 2 * np.asarray(x)
double = Doubler()
""",
    "dataclass": """
from dataclasses import dataclass
@dataclass
class Pair:
    left: np.ndarray
    right: "np.ndarray"
    def total(self) -> np.ndarray:
        return self.left + self.right
def double(x: "float | Pair") -> np.ndarray:
    return Pair(np.asarray(x), np.asarray(x)).total()
""",
    "future-annotations": """
from __future__ import annotations
from dataclasses import dataclass
from typing import get_type_hints
@dataclass
class Pair:
    other: Pair | None
    value: Number
Number = float
get_type_hints(Pair)
def double(x: Later) -> Later:
    return 2 * np.asarray(x)
""",
    "unicode-names": "def zwei(größe, δ=2):\n    return δ * np.asarray(größe)\ndouble = zwei\n",
    "plain-lists": """
def double(x):
    if isinstance(x, (int, float)):
        return 2 * x
    return [2 * value for value in x]
""",
    "tuples": "def double(x):\n    return tuple(2 * np.array(x)) if np.ndim(x) else int(2 * x)\n",
    "long-doubles": "def double(x):\n    return np.longdouble(2) * np.asarray(x)\n",
    "strict-numpy": "np.seterr(all='raise')\nnp.set_printoptions(precision=2)\n" + RIGHT,
    "warnings-are-errors": "import warnings\nwarnings.simplefilter('error')\n" + RIGHT,
    "main-guard": RIGHT + "if __name__ == '__main__':\n    assert double(2) == 4\n",
    "wrong-assert-below": RIGHT + "assert double(2) == 5\n",
    "threads": """
from concurrent.futures import ThreadPoolExecutor
def double(x):
    with ThreadPoolExecutor(4) as pool:
        return np.array(list(pool.map(lambda v: 2 * v, np.ravel(x)))).reshape(np.shape(x))
""",
    "recursion": """
def double(x):
    return np.array([double(value) for value in x]) if np.ndim(x) else x + x
""",
    "shadows-a-builtin": """
def sum(a, b):
    return a + b
def double(x):
    return sum(np.asarray(x), x)
""",
}
THREADED_APPLY = """
from concurrent.futures import ThreadPoolExecutor
def apply(f, x, times):
    history = [x]
    with ThreadPoolExecutor(2) as pool:
        for _ in range(times):
            history.append(pool.submit(f, history[-1]).result())
    return history[-1], history
"""

OWN_CELLS = {
    "helper-function": ("def helper(x):\n    return np.add(x, x)\n", "double = helper\n"),
    "helper-class": (
        "from dataclasses import dataclass\n@dataclass\nclass By:\n    factor: int = 2\n",
        "def double(x):\n    return By().factor * np.asarray(x)\n",
    ),
    "helper-value": (
        "ROOT = np.sqrt(16)\nFACTOR = ROOT / 2\nprint(FACTOR)\n",
        "def double(x):\n    return FACTOR * np.asarray(x)\n",
    ),
    "helper-import": (
        "try:\n    import no_such_module as fast\nexcept ImportError:\n    fast = None\n"
        "import operator as op\n",
        "def double(x):\n    return op.add(np.asarray(x), x) if fast is None else fast(x)\n",
    ),
    "helper-below-a-missing-import": (
        "import no_such_module\ndef helper(x):\n    return x + x\n",
        "def double(x):\n    return helper(np.asarray(x))\n",
    ),
    "future-in-its-own-cell": (
        "from __future__ import annotations\n",
        "def double(x: Unknown) -> Unknown:\n    return 2 * np.asarray(x)\n",
    ),
    "star-import": ("from numpy import *\n", "def double(x):\n    return 2 * asarray(x)\n"),
    "scratch-error": ("1 / 0\nraise SystemExit\n", RIGHT),
    "scratch-syntax-error": ("def half(\n", RIGHT),
    "scratch-loop": ("while True:\n    pass\n", RIGHT),
    "scratch-experiment": ("x = double(1)\nimport time\ny = time.sleep(1000)\n", RIGHT),
    "scratch-shell": ("!rm -rf /\n%run other.py\n%%bash\n", RIGHT),
}


def _notebook(value: dict[str, Any]) -> Write:
    return lambda folder: toy.write(folder / f"{toy.NAME}.ipynb", value)


def _bytes(change: Callable[[str], bytes]) -> Write:
    def write(folder: Path) -> None:
        folder.mkdir(parents=True)
        text = json.dumps(toy.answer(RIGHT), indent=1, ensure_ascii=False)
        (folder / f"{toy.NAME}.ipynb").write_bytes(change(text))

    return write


def _cells(change: Callable[[Cells], object]) -> Write:
    value = toy.answer(RIGHT)
    change(value["cells"])
    return _notebook(value)


def _with_own_cell(own: str, double: str) -> Write:
    return _cells(lambda c: (c[1].update(source=double), c.insert(1, toy.cell(own))))


def _copy_cell(cells: Cells) -> None:
    cells.insert(1, cells[1] | {"source": "def double(x):\n    return x\n"})


def _split_cell(cells: Cells) -> None:
    cells[1]["source"] = "factor = 2\n"
    cells.insert(2, toy.cell("def double(x):\n    return factor * np.asarray(x)\n"))


def _drop_metadata(cells: Cells) -> None:
    for cell in cells:
        cell["metadata"] = {}


def _lines(cells: Cells) -> None:
    for cell in cells:
        cell["source"] = cell["source"].splitlines(keepends=True)


def _without_kernel(folder: Path) -> None:
    toy.write(folder / f"{toy.NAME}.ipynb", toy.answer(RIGHT) | {"metadata": {}})


def _carriage_returns(cells: Cells) -> None:
    for cell in cells:
        cell["source"] = cell["source"].replace("\n", "\r\n")


SUBMISSIONS: dict[str, Write] = {
    "plain": _notebook(toy.answer()),
    **{name: _notebook(toy.answer(double)) for name, double in SOLUTIONS.items()},
    **{name: _with_own_cell(*cells) for name, cells in OWN_CELLS.items()},
    "calls-back-from-a-thread": _notebook(toy.answer(apply=THREADED_APPLY)),
    "deleted-tests": _cells(lambda cells: cells.pop(2)),
    "deleted-setup": _cells(lambda cells: cells.pop(0)),
    "copied-cell": _cells(_copy_cell),
    "split-cell": _cells(_split_cell),
    "no-metadata": _cells(_drop_metadata),
    "moved-cells": _cells(lambda cells: cells.reverse()),
    "lists-of-lines": _cells(_lines),
    "windows-lines-in-cells": _cells(_carriage_returns),
    "windows-lines": _bytes(lambda text: text.replace("\n", "\r\n").encode()),
    "byte-order-mark": _bytes(lambda text: text.encode("utf-8-sig")),
    "no-kernelspec": _without_kernel,
    "another-name": lambda folder: toy.write(folder / "Homework (1).ipynb", toy.answer(RIGHT)),
}
