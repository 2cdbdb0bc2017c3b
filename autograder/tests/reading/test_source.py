"""What a cell's text defines, and what of a student's own cells runs."""

import ast

import pytest
from robust_slam_autograder.reading import source


def kept(text: str, used: set[str]) -> list[str]:
    tree = ast.parse(text)
    return [ast.unparse(node) for node in tree.body if node in source.helpers([tree], used)]


@pytest.mark.parametrize(
    ("definition", "experiment"),
    [
        ("def f():\n    pass", "print(1)\nx = f()\nfor i in []: pass"),
        ("class C:\n    pass", "C().x = 1"),
        ("@wraps\ndef f():\n    pass", ""),
        # A variable in it is another than one beside it.
        ("def f(x):\n    y = x\n    return y", "x = slow()\ny = slow()"),
        # A choice between imports.
        ("try:\n    import a\nexcept ImportError:\n    a = None", ""),
        ("def g():\n    pass", "try:\n    main()\nexcept ValueError:\n    pass"),
    ],
)
def test_definitions_stay_and_experiments_go(definition, experiment):
    assert kept(f"{definition}\n{experiment}\n", set()) == [definition]


def test_an_import_stays_where_its_name_occurs_in_what_stays():
    text = "import a\nimport b.c\nfrom d import e as f, g\nimport plt\nplt.plot(b, g)\n{}"
    assert kept(text.format(""), set()) == []
    assert kept(text.format(""), {"b", "g"}) == ["import b.c", "from d import e as f, g"]
    function = "def h(x: a) -> 'f':\n    return f(x)"
    both = ["import a", "from d import e as f, g", ast.unparse(ast.parse(function))]
    assert kept(text.format(function), set()) == both
    assert kept(f"from __future__ import annotations\nfrom x import *\n{function}", set())[1:2]
    assert kept("import a, b\nc = a(1)", {"c"}) == ["import a, b", "c = a(1)"]


def test_modules_are_those_of_every_import():
    text = "import a.b as c\ndef f():\n    from d import e\n"
    assert source.imported_modules(text) == ("a.b", "d", "d.e")
    assert source.imported_modules("import (") == ()


def test_a_variable_stays_when_a_chain_of_uses_leads_to_it():
    text = "a = slow()\nb = a + 1\nc = 5\nd = {}\nd['k'] = b\ne = slow()\ndef f():\n    return d\n"
    assert kept(text, {"f"})[:4] == ["a = slow()", "b = a + 1", "d = {}", "d['k'] = b"]
    assert "e = slow()" not in kept(text, {"f"})
    assert "c = 5" in kept(text, {"c"})
    assert kept(text, set()) == ["def f():\n    return d"]


@pytest.mark.parametrize(
    "change",
    [
        "for i in range(3):\n    T[i] = i",
        "for i in range(3):\n    T.append(i)",
        "T.append(2)",
        "with open(p) as f:\n    T = f.read()",
        "if True:\n    print(1)\n    T = 3",
        "while len(T) < 3:\n    T += [1]",
        "print((T := 4))",
        "T = await load()",
        "async with session as T:\n    pass",
        "async for T in session:\n    pass",
        "try:\n    T = load()\nexcept OSError:\n    print(2)",
        "del T[0]",
        "T.sort()",
        "T.inner.items.append(2)",
    ],
)
def test_whatever_changes_a_variable_that_a_solution_reads_stays(change):
    text = f"T = []\n{change}\n"
    assert kept(text, {"T"}) == ["T = []", ast.unparse(ast.parse(change))]
    assert kept(text, set()) == []


@pytest.mark.parametrize(
    "experiment",
    [
        "np.save('a', slow())",
        "plt.plot([T for T in slow()])",
        "for i in range(9):\n    print(slow(i))",
        "show(lambda T: T)",
        "slow(T)",
    ],
)
def test_an_experiment_that_changes_no_variable_goes(experiment):
    text = f"import numpy as np\nimport matplotlib.pyplot as plt\nT = []\n{experiment}\n"
    assert kept(text, {"T", "np", "plt", "slow"})[2:] == ["T = []"]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("def f(x): pass", True),
        ("async def f(x): pass", True),
        ("class f: pass", True),
        ("f = 1", True),
        ("f: int = 1", True),
        ("%%time\ndef f(x):", True),
        ("f == 1", False),
        ("  def f(x): pass", False),
        ("def ff(x): pass", False),
        ("g = f", False),
        ("", False),
    ],
)
def test_a_definition_is_known_by_the_look_of_its_line(text, found):
    assert source.defines(text, ["f"]) is found


def test_names_are_those_that_the_top_level_binds():
    text = "import a\nb = c = 1\n(d, e), f = g\nh: int = 2\nk[0] = l.m = 3\ndef n():\n    o = 1\n"
    assert sorted(source.defined_names(text)) == ["b", "c", "d", "e", "f", "h", "n"]
    assert source.imports(text) == "import a"


def test_magics_become_python_and_keep_the_lines():
    assert source.plain_python("%%time\nx = 1\n") == "\nx = 1\n"
    assert source.plain_python("%%bash\nrm -rf /\n") == ""
    magic = source.plain_python("%matplotlib inline\nx = 1\n!ls\ny = 2\n")
    kinds = [type(node).__name__ for node in ast.parse(magic).body]
    assert kinds == ["Expr", "Assign", "Expr", "Assign"]
    assert magic.split("\n")[1] == "x = 1"


def test_names_that_are_awaited_are_used():
    statements = ast.parse("x = await load(path)\nasync for y in source: pass\n").body
    assert {"load", "path", "source"} <= source.used_names(*statements)


def test_a_count_of_python_that_is_off_once_changes_no_tree(monkeypatch):
    parse, asked = ast.parse, []

    def off_once(text: str) -> ast.Module:
        asked.append(text)
        if len(asked) == 1:
            raise SystemError("AST constructor recursion depth mismatch")
        return parse(text)

    monkeypatch.setattr(ast, "parse", off_once)
    assert ast.unparse(source.tree_of("x = 1")) == "x = 1"


@pytest.mark.parametrize(
    "deep",
    ["x = " + " + ".join(["1"] * 500), "if a: b = 1\n" + "elif a: b = 1\n" * 500],
    ids=["sum", "elif"],
)
def test_a_long_sum_or_many_elifs_cost_nothing(deep):
    own = f"{deep}\ndef helper(): pass\n"
    tree = source.tree_of(own)
    assert tree.body[-1] in source.helpers([tree], {"helper"})
