"""Mutants of the grader: small changes that remove a protection, and the test that catches each.

``python -m tests.autograder.mutants [WORD…]`` changes a copy of the grader, one mutant at a time,
and runs its test, which must fail. First every test must pass on the grader as it is. With words,
only mutants whose file or test contains one of them are tried. All of them take minutes.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path("autograder/robust_slam_autograder")
TESTS = Path("tests/autograder")


@dataclass(frozen=True)
class Mutant:
    """A text that occurs once in a file, its replacement, and the test that then fails."""

    file: str
    old: str
    new: str
    caught_by: str


SANDBOX = "sandbox/test_sandbox.py"
MARKING = "grading/test_marking.py"

MUTANTS = (
    # The sandbox.
    Mutant(
        "sandbox/watch.py",
        "threads > 2 * PROCESSES",
        "threads > 20 * PROCESSES",
        "sandbox/test_watch.py::test_threads_of_all_processes_count_to_twice_the_kernels_limit",
    ),
    Mutant(
        "sandbox/keeper.py",
        "    system.forbid_new_privileges()\n",
        "",
        "sandbox/test_sandbox.py::TestWhatIsSeen::test_it_has_no_rights_and_no_files_open",
    ),
    Mutant(
        "sandbox/keeper.py",
        "    os.closerange(3, 1 << 16)\n",
        "",
        "sandbox/test_sandbox.py::TestWhatIsSeen::test_it_has_no_rights_and_no_files_open",
    ),
    Mutant(
        "sandbox/keeper.py",
        "    if program is not None:\n",
        "    if False:\n",
        f"{SANDBOX}::test_what_is_out_of_reach",
    ),
    # The executor and the messages.
    Mutant(
        "executor/memory.py",
        "(most - KEPT_BACK_BYTES, most))\n    try",
        "(most, most))\n    try",
        "executor/test_memory.py::test_tests_have_their_share_and_the_grader_keeps_its_own",
    ),
    Mutant(
        "executor/handed_over.py",
        "        if name not in named:\n",
        "        if False:\n",
        "executor/test_handed_over.py::test_what_the_author_did_not_provide_for_is_refused",
    ),
    Mutant(
        "executor/session.py",
        " if name not in _ENDS_OF_LOOPS)",
        ")",
        "executor/test_session.py::test_nothing_that_a_student_raises_empties_a_loop",
    ),
    Mutant(
        "executor/budget.py",
        "            self._ended += self._running()\n",
        "",
        "executor/test_budget.py::test_what_an_ended_process_used_stays_used",
    ),
    Mutant(
        "student/wire.py",
        "    if depth > MAX_DEPTH:\n",
        "    if False:\n",
        "student/test_wire.py::test_a_sender_refuses_what_its_reader_would",
    ),
    Mutant(
        "student/wire.py",
        "    if len(body) > MAX_PAIR_BYTES:\n",
        "    if False:\n",
        "student/test_wire.py::test_hand_written_bytes_are_refused",
    ),
    Mutant(
        "student/channel.py",
        "    if not isinstance(kind, str) or type(number) is not int:\n",
        "    if False:\n",
        "student/test_channel.py::test_a_message_of_another_shape_ends_the_conversation",
    ),
    # Marks.
    Mutant(
        "grading/marking.py",
        "missing = not score and owner",
        "missing = owner",
        f"{MARKING}::test_an_exercise_that_earned_points_is_not_missing",
    ),
    Mutant(
        "grading/marking.py",
        "cases = _Cases(self.assignment, session, sources, seed)",
        "cases = _Cases(self.assignment, session, sources, PUBLIC_SEED)",
        f"{MARKING}::test_hidden_inputs_are_drawn_from_the_batchs_seed",
    ),
    Mutant(
        "grading/marking.py",
        "sources, PUBLIC_SEED, explain.Calls())",
        "sources, 1, explain.Calls())",
        f"{MARKING}::test_visible_checks_draw_from_the_public_seed",
    ),
    Mutant(
        "grading/marking.py",
        "        if known or session.fault is None:\n",
        "        if True:\n",
        f"{MARKING}::test_a_fault_that_a_test_swallows_is_a_fault",
    ),
    Mutant(
        "grading/marking.py",
        "        contextlib.redirect_stdout(nowhere),\n",
        "",
        f"{MARKING}::test_tests_print_nothing",
    ),
    Mutant(
        "grading/marking.py",
        'exec", dont_inherit=True, optimize=0',
        'exec", dont_inherit=True',
        f"{MARKING}::test_asserts_count_under_an_optimising_interpreter",
    ),
)


def apply(mutant: Mutant, folder: Path) -> None:
    """Change the file in a copy of the project.

    Raises:
        ValueError: the old text does not occur exactly once.
    """
    path = folder / PACKAGE / mutant.file
    text = path.read_text("utf-8")
    if text.count(mutant.old) != 1:
        raise ValueError(
            f"{mutant.file}: {mutant.old!r} must occur exactly once: update the mutant."
        )
    path.write_text(text.replace(mutant.old, mutant.new), "utf-8")


def fails(tests: Sequence[str], folder: Path) -> bool:
    """Whether a test fails in a copy of the project.

    Raises:
        RuntimeError: no test was run.
    """
    paths = [str(TESTS / test) for test in tests]
    places = os.pathsep.join(str(folder / name) for name in ("autograder", "lib"))
    done = subprocess.run(
        [sys.executable, "-B", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *paths],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": places},
        capture_output=True,
        text=True,
    )
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(tests)}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.returncode == 1


def copy(folder: Path) -> Path:
    """Copy what git tracks of the project."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, folder / name)
    return folder


def main(words: Sequence[str]) -> int:
    """Try the mutants; exit status 1 where one is not caught."""
    chosen = [
        mutant
        for mutant in MUTANTS
        if not words or any(word in f"{mutant.file} {mutant.caught_by}" for word in words)
    ]
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)  # student code is another user
        folder = copy(Path(name))
        if fails(list(dict.fromkeys(mutant.caught_by for mutant in chosen)), folder):
            print("A test fails on the grader as it is.")
            return 1
        left = 0
        for mutant in chosen:
            path = folder / PACKAGE / mutant.file
            before = path.read_bytes()
            apply(mutant, folder)
            caught = fails([mutant.caught_by], folder)
            path.write_bytes(before)
            left += not caught
            sign = "✓ caught" if caught else "✗ NOT caught"
            print(f"{sign}  {mutant.file}: {mutant.old.strip()}", flush=True)
    print(f"{len(chosen) - left} of {len(chosen)} mutants are caught.")
    return 1 if left else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
