"""A release names wrong answers to its visible cases, and knows nothing of hidden ones."""

import subprocess
from pathlib import Path

from robust_slam_autograder import cli, self_check
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading import assignment as assignments

from autograder.tests import toy
from solutions.classes import answers

VISIBLE = "assert np.allclose(double([0.25, 3]), [0.5, 6])\n"
HIDDEN = "### BEGIN HIDDEN TESTS\nx = rng.{}(size=5)\nassert np.allclose(double(x), x + x)\n"
HALVED = "import numpy as np\n\ndef double(x):\n    return np.asarray(x) / 2\n"


def labelled(folder: Path, hidden: str) -> Path:
    """A release with labels, of a tree with that hidden test."""
    text = f"{VISIBLE}{HIDDEN.format(hidden)}### END HIDDEN TESTS\n"
    tree = toy.make_tree(folder, value=toy.source_notebook(double_random=text))
    known = folder / "known"
    assert cli.main(["--solutions", str(tree), "misconceptions", "--to", str(known)]) == 0
    (path,) = release(tree, [], folder / "release", misconceptions=known)
    assert tables.read(path.parent / tables.FILE)["double"]
    return path


def test_hidden_cases_leave_no_trace_in_it(tmp_path):
    one, other = (labelled(tmp_path / name, name) for name in ("normal", "exponential"))
    files = [(path.parent / tables.FILE).read_bytes() for path in (one, other)]
    assert files[0] == files[1]


def test_make_release_finds_out_first_how_answers_can_be_wrong():
    done = subprocess.run(["make", "-nB", "release"], capture_output=True, text=True, check=True)
    told = [done.stdout.find(f"autograder {command}") for command in ("misconceptions", "release")]
    assert -1 < told[0] < told[1]


def test_check_says_what_it_looks_like_and_hints_when_asked(tmp_path, capsys):
    path = labelled(tmp_path, "normal")
    config = path.with_name(assignments.CONFIG_NAME)
    hints = 'chapter = "07-toy"\n[hints]\ndouble = ["Look here.", "Compute that.", "The idea."]\n'
    config.write_text(hints + config.read_text(), encoding="utf-8")
    notebook = answers.source_notebook(toy.NAME, path.parents[1])
    answers.write(path, answers.with_answers(notebook, {"double": HALVED}))
    self_check.run(path, hints=2)
    said = capsys.readouterr().out
    assert "It looks as if" in said and "Read again: chapter 07-toy" in said
    assert "Compute that." in said and "The idea." not in said
