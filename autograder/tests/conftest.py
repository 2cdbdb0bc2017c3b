"""What tests of the commands share: a small course, and a way to run a command on it."""

from collections.abc import Callable

import pytest
from robust_slam_autograder import cli

from tests.autograder import toy

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def course(tmp_path):
    """A source tree of one assignment, and the right answers of two students."""
    toy.make_tree(tmp_path)
    for student in ("ada", "bob"):
        toy.hand_in(tmp_path / "submitted", student, toy.answer())
    return tmp_path


@pytest.fixture
def autograder(tmp_path, capfd):
    """Run a command on the test's own source tree: exit status, output, errors."""

    def run(*arguments: object) -> tuple[int, str, str]:
        capfd.readouterr()
        try:
            status = cli.main(["--solutions", str(tmp_path / "solutions"), *map(str, arguments)])
        except SystemExit as error:  # how argparse ends
            status = int(error.code or 0)
        return (status, *capfd.readouterr())

    return run
