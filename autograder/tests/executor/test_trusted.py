"""Each task in a fresh process, none of which outlives the batch or prints what C prints."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import psutil
import pytest
from robust_slam_autograder.executor import trusted
from robust_slam_autograder.executor.guarded import guarded

from ..killing import kill, wait_until_empty

BATCH = """
import sys
from robust_slam_autograder.executor import trusted
wanted = ["faulty", "wave"]
answers = trusted.run_each(sys.argv[1:], eval, at_once=2, seconds=lambda task: 600, preload=wanted)
print(*(answer for _, answer in answers))
"""


def start(folder: Path, *tasks: str) -> subprocess.Popen[str]:
    """A batch of expressions to evaluate, with a temporary folder of its own."""
    places = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    environment = os.environ | {"TMPDIR": str(folder), "PYTHONPATH": places}
    pipes: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-c", BATCH, *tasks], env=environment, **pipes)


# Nothing written in Python could interrupt the second.
@pytest.mark.parametrize("task", ["__import__('time').sleep(600)", "sum(range(10**13))"])
def test_a_killed_batch_takes_its_processes_and_its_folder_with_it(task):
    with tempfile.TemporaryDirectory(prefix="t") as name:
        batch = start(Path(name), task, task)
        family = psutil.Process(batch.pid)
        # The server of the processes, multiprocessing's tracker, and the two.
        kill(batch, lambda: len(family.children(recursive=True)) >= 4, name)
        wait_until_empty(Path(name))


def test_what_is_wanted_is_imported_once_and_what_fails_then_harms_nobody():
    with tempfile.TemporaryDirectory(prefix="t") as name:
        Path(name, "faulty.py").write_text("raise RuntimeError\n")
        Path(name, "wave.py").write_text("open(__file__ + '.log', 'a').write('imported\\n')\n")
        tasks = ["__import__('sys').modules['wave'].__name__"] * 3
        said, complaint = start(Path(name), *tasks).communicate(timeout=120)
        assert said == "wave wave wave\n", complaint
        assert Path(name, "wave.py.log").read_text() == "imported\n"


def test_tasks_are_taken_when_their_turn_comes():
    taken = []

    def tasks() -> Any:
        for number in range(4):
            taken.append(number)
            yield str(number)

    for done, answer in trusted.run_each(tasks(), float, at_once=1, seconds=lambda task: 60):
        assert answer == float(done) and taken[-1] == int(done)


def test_what_c_prints_in_the_child_reaches_nobody(capfd):
    assert list(guarded(lambda: iter([os.write(1, b"LAPACK") + os.write(2, b"LAPACK")]))) == [12]
    assert capfd.readouterr() == ("", "")
