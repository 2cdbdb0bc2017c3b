"""What tests share: a small course, a way to run a command on it, and back ends that work."""

from collections.abc import Callable
from typing import NamedTuple

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.sandbox import BACK_ENDS

from . import kernel, toy


class Done(NamedTuple):
    """How a command ended: exit status, output, errors."""

    status: int
    out: str
    err: str

    def worked(self, *words: str) -> bool:
        """With status 0, and these words in the output."""
        return self.status == 0 and all(word in self.out for word in words)

    def refused(self, *words: str) -> bool:
        """With status 2, these words among the errors, and no output."""
        return (self.status, self.out) == (2, "") and all(word in self.err for word in words)


Run = Callable[..., Done]


@pytest.fixture
def course(tmp_path):
    """A source tree of one assignment, and the right answers of two students."""
    toy.make_tree(tmp_path)
    for student in ("ada", "bob"):
        toy.hand_in(tmp_path / "submitted", student, toy.answer())
    return tmp_path


@pytest.fixture
def autograder(tmp_path, capfd):
    """Run a command on the test's own source tree."""

    def run(*arguments: object) -> Done:
        capfd.readouterr()
        try:
            status = cli.main(["--solutions", str(tmp_path / "solutions"), *map(str, arguments)])
        except SystemExit as error:  # how argparse ends
            status = int(error.code or 0)
        return Done(status, *capfd.readouterr())

    return run


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test that asks for ``wall_name`` runs with the first back end of this machine, or all."""
    if "wall_name" in metafunc.fixturenames:
        usable = kernel.usable()
        names = usable if kernel.is_soak(metafunc.config) else usable[:1]
        metafunc.parametrize("wall_name", names or list(BACK_ENDS), scope="session")
