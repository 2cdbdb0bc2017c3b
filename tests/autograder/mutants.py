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
BATCH = "grading/test_batch.py"

MUTANTS = (
    # The sandbox.
    Mutant(
        "sandbox/watch.py",
        "threads > 2 * PROCESSES",
        "threads > 20 * PROCESSES",
        "sandbox/test_watch.py::test_threads_of_all_processes_count_to_twice_the_kernels_limit",
    ),
    Mutant(
        "sandbox/watch.py",
        "memory += info.rss - info.shared",
        "memory += 0",
        "sandbox/test_watch.py::test_each_limit_counts",
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
        "    os.environ.clear()\n",
        "",
        "sandbox/test_sandbox.py::TestWhatIsSeen::test_the_environment_is_the_sandboxs_own",
    ),
    Mutant(
        "sandbox/keeper.py",
        "    if program is not None:\n",
        "    if False:\n",
        f"{SANDBOX}::test_what_is_out_of_reach",
    ),
    Mutant(
        "sandbox/inside.py",
        '"RLIMIT_FSIZE": SCRATCH_BYTES',
        '"RLIMIT_FSIZE": 1 << 40',
        f"{SANDBOX}::test_what_is_limited",
    ),
    # The executor and the messages.
    Mutant(
        "executor/memory.py",
        "(most - KEPT_BACK_BYTES, most))\n    try",
        "(most, most))\n    try",
        "executor/test_memory.py::test_tests_have_their_share_and_the_grader_keeps_its_own",
    ),
    Mutant(
        "executor/trusted.py",
        "    _end_with_the_batch()\n",
        "",
        "executor/test_trusted.py::test_a_killed_batch_takes_its_processes_and_its_folder_with_it",
    ),
    Mutant(
        "executor/handed_over.py",
        "        if name not in named:\n",
        "        if False:\n",
        "executor/test_handed_over.py::test_what_the_author_did_not_provide_for_is_refused",
    ),
    Mutant(
        "executor/session.py",
        "if self.fault or channel is not self._channel:",
        "if False:",
        "executor/test_session.py::test_after_a_fault_every_call_fails_until_the_next_cell",
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
        f"{MARKING}::test_the_same_seed_gives_the_same_inputs_and_another_seed_others",
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
    Mutant(
        "grading/marking.py",
        "    signal.setitimer(signal.ITIMER_REAL, session.time_left() + ALARM_GRACE)\n",
        "",
        f"{MARKING}::test_a_test_that_computes_for_ever_is_ended",
    ),
    # The batch, its results, and what others may see.
    Mutant(
        "grading/batch.py",
        "        if at_once > 1 and _ran_into_a_limit(result):\n",
        "        if False:\n",
        f"{BATCH}::test_a_limit_is_judged_alone",
    ),
    Mutant(
        "grading/batch.py",
        "        if at_once > 1 and _ran_into_a_limit(result):\n",
        "        if _ran_into_a_limit(result):\n",
        f"{BATCH}::test_who_was_alone_already_is_not_graded_again",
    ),
    Mutant(
        "grading/batch.py",
        "    if job.path.parent.is_symlink():\n",
        "    if False:\n",
        f"{BATCH}::test_a_link_on_the_way_is_refused",
    ),
    Mutant(
        "grading/batch.py",
        "            run.forget(task.job.key)\n",
        "",
        f"{BATCH}::test_a_regrade_that_is_cut_short_keeps_no_result_of_another_text",
    ),
    Mutant(
        "grading/batch.py",
        "        traceback.print_tb(error.__traceback__)\n",
        "        traceback.print_exception(error)\n",
        f"{BATCH}::test_a_failure_of_the_grader_is_a_result_that_tells_no_secret",
    ),
    Mutant(
        "grading/allowed.py",
        "            if shown is not None:\n",
        "            if False:\n",
        "grading/test_allowed.py::test_what_student_code_could_read_is_refused",
    ),
    Mutant(
        "sandbox/view.py",
        '"__pycache__", ".ipynb_checkpoints")',
        '"__pycache__")',
        "sandbox/test_view.py::test_an_editors_copies_of_a_withheld_module_are_withheld_too",
    ),
    Mutant(
        "sandbox/view.py",
        "inside if _is_shown(inner, rules))",
        "inside)",
        "sandbox/test_view.py::test_a_link_in_a_folder_leads_nowhere_else",
    ),
    Mutant(
        "sandbox/seccomp.py",
        "        *(221, 187, 27),  # fadvise64 readahead mincore\n",
        "",
        "sandbox/test_cgroup.py::test_memory_that_nobody_counts_is_refused",
    ),
    Mutant(
        "markup.py",
        'kind.startswith("C") or kind in _ACTING',
        "kind in _ACTING",
        "test_markup.py::test_what_acts_is_written_as_its_code",
    ),
    # A student's own check.
    Mutant(
        "commands/check.py",
        "return 0 if result.score == result.max_score else 1",
        "return 0",
        "commands/test_cli.py::TestCheck::test_a_wrong_one_does_not",
    ),
    Mutant(
        "grading/verdicts.py",
        "'✓' if status == 'passed' else '✗'",
        "'✓' if status != 'failed' else '✗'",
        "reports/test_summary.py::test_markdown_is_a_table_with_a_word_beside_each_sign",
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
