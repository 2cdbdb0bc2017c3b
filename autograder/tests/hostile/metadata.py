"""Attacks that leave the code alone and lie about it: the notebook's metadata and its cells.

All give a plain wrong answer; in none does the lie earn anything.
"""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from .cells import Change, changed, each, own_cell
from .entry import Entry
from .target import Notebook, Target, grade_id_of


def _entry(name: str, kind: str, change: Change) -> Entry:
    return changed(name, f"metadata: {kind}", "wrong", change)


def _fields(cell: dict[str, Any]) -> dict[str, Any]:
    return cell["metadata"].setdefault("nbgrader", {})


def _is_test(cell: dict[str, Any]) -> bool:
    return bool(_fields(cell).get("grade"))


def _each_test(change: Callable[[dict[str, Any]], object]) -> Change:
    return each(lambda cell: change(cell) if _is_test(cell) else None)


def _set(**values: object) -> Change:
    return each(lambda cell: _fields(cell).update(values))


def _tag(*tags: str) -> Change:
    return each(lambda cell: cell["metadata"].update(tags=list(tags)))


def _tests(**values: object) -> Change:
    return _each_test(lambda cell: cell.update(values))


def _retype(cell: dict[str, Any]) -> None:
    cell.update(cell_type="markdown")
    cell.pop("outputs", None)


def _claim_success(cell: dict[str, Any]) -> None:
    result = {"text/plain": "All tests passed: 1000000 points"}
    output = {"output_type": "execute_result", "data": result, "metadata": {}}
    if cell["cell_type"] == "code":
        cell.update(outputs=[output | {"execution_count": 1}] * 3, execution_count=1)


def _retype_solution(kind: str) -> Change:
    return lambda book, target: book["cells"][target.index(book)].update(cell_type=kind)


def _delete_tests(notebook: Notebook, target: Target) -> None:
    notebook["cells"] = [cell for cell in notebook["cells"] if not _is_test(cell)]


def _tests_first(notebook: Notebook, target: Target) -> None:
    notebook["cells"].sort(key=lambda cell: not _is_test(cell))


def _copy_tests(notebook: Notebook, target: Target) -> None:
    tests = filter(_is_test, notebook["cells"])
    notebook["cells"] += [{**deepcopy(cell), "source": "pass"} for cell in tests] * 3


def _solution_as_test(notebook: Notebook, target: Target) -> None:
    cell = notebook["cells"][target.index(notebook)]
    _fields(cell).update(grade_id=target.victim_cases[0].grade_id, grade=True, points=1e6)


def _test_as_solution(cell: dict[str, Any]) -> None:
    _fields(cell).update(solution=True, grade=True)
    cell["source"] = "import numpy\nnumpy.allclose = lambda *a, **k: True"


def _swap_ids(notebook: Notebook, target: Target) -> None:
    ids = [grade_id_of(cell) for cell in notebook["cells"]]
    for cell, grade_id in zip(notebook["cells"], reversed(ids), strict=True):
        _fields(cell).update(grade_id=grade_id)


def _a_set_up_of_its_own(cell: dict[str, Any]) -> None:
    if _fields(cell).get("locked") and not _is_test(cell) and cell["cell_type"] == "code":
        cell["source"] += "\nclass rng:\n    normal = uniform = staticmethod(lambda *a, **k: 0)"
        cell["source"] += "\nnp.allclose = lambda *a, **k: True\n"


def _locked_own_cells(notebook: Notebook, target: Target) -> None:
    cell = own_cell("import numpy\nnumpy.allclose = numpy.shape = lambda *a, **k: True")
    _fields(cell).update(grade_id="more-setup", locked=True, grade=False, solution=False)
    notebook["cells"].insert(0, cell)


def _strange(notebook: Notebook, target: Target) -> None:
    odd = [[1, {}], None, "nbgrader", {"grade_id": [1]}, {"grade_id": 3, "points": "many"}]
    for cell, value in zip(notebook["cells"], odd * 100, strict=False):
        cell["metadata"]["nbgrader"] = value


def _strange_kernel(notebook: Notebook, target: Target) -> None:
    command = ["sh", "-c", "exit 0", "{connection_file}"]
    notebook["metadata"] = {
        "kernelspec": {"name": "../../evil", "argv": command, "language": "bash"},
        "language_info": {"name": "bash", "file_extension": "/../x"},
        "celltoolbar": 3,
        "nbgrader": {"student": "../../neighbour-0", "score": 1e6},
    }


METADATA = [
    _entry("skips-execution", "tags", _tag("skip-execution")),
    _entry("raises-exceptions", "tags", _tag("raises-exception", "nbgrader-pass", "remove_input")),
    _entry("more-points", "points", _set(points=1e9, max_score=1e9, score=1e9)),
    _entry("negative-points", "points", _set(points=-5)),
    _entry("points-that-are-no-number", "points", _set(points=float("nan"))),
    _entry("one-grade-id", "grade ids", lambda cells, aim: _set(grade_id=aim.victim)(cells, aim)),
    _entry("swapped-grade-ids", "grade ids", _swap_ids),
    _entry("a-solution-named-as-a-test", "grade ids", _solution_as_test),
    _entry("odd-grade-ids", "grade ids", _set(grade_id="../../x\0\n")),
    _entry("copied-tests", "grade ids", _copy_tests),
    _entry("unlocked", "locked flags", _set(locked=False)),
    _entry("all-locked", "locked flags", _set(locked=True, solution=False)),
    _entry("a-locked-cell-of-its-own", "locked flags", _locked_own_cells),
    _entry("a-set-up-of-its-own", "locked flags", each(_a_set_up_of_its_own)),
    _entry("tests-as-text", "cell types", _each_test(_retype)),
    _entry("a-solution-as-text", "cell types", _retype_solution("markdown")),
    _entry("a-solution-of-no-type", "cell types", _retype_solution("\0x")),
    _entry("tests-as-solutions", "cell types", _each_test(_test_as_solution)),
    _entry("schema-0", "schema versions", _set(schema_version=0)),
    _entry("schema-99", "schema versions", _set(schema_version=99)),
    _entry("schema-of-nothing", "schema versions", _set(schema_version=None, checksum=0)),
    _entry("strange-metadata", "schema versions", _strange),
    _entry("strange-kernel", "schema versions", _strange_kernel),
    _entry("forged-outputs", "forged outputs", each(_claim_success)),
    _entry("edited-tests", "forged outputs", _tests(source="assert True")),
    _entry("tests-first", "moved tests", _tests_first),
    _entry("tests-emptied", "deleted tests", _tests(source="")),
    _entry("tests-deleted", "deleted tests", _delete_tests),
]
