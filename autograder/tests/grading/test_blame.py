"""What student code breaks costs the student marks; what the grader breaks is its own failure."""

import pytest
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.grading import results
from robust_slam_autograder.sandbox import Launch, Running, Unsandboxed

from .. import toy

CANARY = "STUDENTS_WORDS"
FIND = 'import gc\n(channel,) = [o for o in gc.get_objects() if type(o).__name__ == "Channel"]\n'
RAISES = f"class {CANARY}(Exception): pass\ndef raises(*args): raise {CANARY}('{CANARY}')\n"
WAYS = {
    "raises": RAISES,
    "junk": f"def raises(*args): return ['{CANARY}']\n",
    "mute": f"{RAISES}channel._describe = raises\n",
}
ROUTES = ("kinds", "value", "call", "run", "read")


@pytest.mark.parametrize("way", WAYS)
def test_replaced_entry_points_leave_a_mark_and_no_words(way):
    """Whatever student code makes of the functions that the grader calls by name."""
    replace = "".join(f"channel._named['{name}'] = raises\n" for name in ROUTES)
    result = toy.graded(toy.answer(f"{FIND}{WAYS[way]}{replace}"))
    assert result.status == "graded" and result.score == 0
    assert result.reason == "" and CANARY not in results.as_text(result)


class WorksOnce(Unsandboxed):
    """A back end that starts one process."""

    starts = 0

    def start(self, launch: Launch) -> Running:
        self.starts += 1
        if self.starts > 1:
            raise GraderFailure("The machine is full.")
        return super().start(launch)


def test_a_back_end_that_fails_between_two_cases_is_no_lost_case():
    """The student's code dies, but that no new process starts is the machine's fault."""
    dies = toy.answer("import os\ndef double(x): os._exit(0)\n")
    with pytest.raises(GraderFailure, match="machine is full"):
        toy.graded(dies, wall=WorksOnce())


@pytest.mark.parametrize("cell", ["def (", "assert (", "return 3\n", "await nothing\n"])
def test_a_test_cell_that_does_not_compile_is_the_instructors(cell):
    with pytest.raises(GraderFailure, match="double-random is no Python"):
        toy.graded(toy.answer(), toy.assignment(double_random=cell))
