"""The grader's README speaks of every command, and its first assignment has nothing to fix."""

import argparse
import re
from pathlib import Path

from robust_slam_autograder import lint
from robust_slam_autograder.commands import declare

from . import toy

TEXT = Path(__file__).resolve().parents[1].joinpath("README.md").read_text("utf-8")


def test_every_command_has_a_line_in_the_overview_and_its_exit_statuses_in_the_table():
    commands = argparse.ArgumentParser().add_subparsers()
    declare(commands)
    overview = re.findall(r"^autograder ([a-z-]+)", TEXT, re.M)
    rows = TEXT.split("\n| exit status |")[1].split("\n\n")[0].splitlines()[2:]
    listed = [name for row in rows for name in re.findall(r"`([a-z-]+)`", row.split("|")[1])]
    assert sorted(overview) == sorted(listed) == sorted(commands.choices)


def test_the_first_assignment_has_nothing_to_fix_and_its_answer_has_all_points(tmp_path):
    (example,) = re.findall(r"```python\n# %% (setup.*?)```", TEXT, re.S)
    setup, answer, *tests = (cell.split("\n", 1) for cell in example.split("# %% "))
    cells = [toy.cell(setup[1], "setup", locked=True), toy.cell(answer[1], "mean", solution=True)]
    cells += [toy.test_cell(source, head.split(":")[0], 1) for head, source in tests]
    tree = toy.make_tree(tmp_path, value=toy.notebook(cells))
    assert not lint.lint(tree / toy.NAME / f"{toy.NAME}.ipynb", None)
    assert toy.graded(toy.notebook(cells), toy.assignment(value=toy.notebook(cells))).score == 2
