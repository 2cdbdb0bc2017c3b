"""Mutants of the grader: small changes that remove a protection, and the test that catches each.

``python -m tests.autograder.mutants [WORD…]`` changes a copy of the grader, one mutant at a time,
and runs its test, which must fail or take longer than ``SECONDS``. First every test must pass on
the grader as it is. With words, only mutants whose file or test contains one of them are tried.
All of them take minutes.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path("autograder/robust_slam_autograder")
TESTS = Path("tests/autograder")
SECONDS = 240
"""For one test. A mutant may hang: that counts as caught."""


@dataclass(frozen=True)
class Mutant:
    """A text that occurs once in a file, its replacement, and the test that then fails."""

    file: str
    old: str
    new: str
    caught_by: str


BATCH = "grading/test_batch.py::test_"
MARKING = "grading/test_marking.py::test_"
SANDBOX = "sandbox/test_sandbox.py::"
SEEN = f"{SANDBOX}TestWhatIsSeen::test_"
SECCOMP = "sandbox/test_seccomp.py::test_"
SESSION = "executor/test_session.py::test_"
TRUSTED = "executor/test_trusted.py::test_"
VIEW = "sandbox/test_view.py::test_"
WATCH = "sandbox/test_watch.py::test_"
WIRE = "protocol/test_wire.py::test_"
USES = f"{WATCH}memory_files_and_threads_of_all_processes_count"

_CHANGES = {
    "sandbox/watch.py": [
        ("threads > 2 * PROCESSES", "threads > 20 * PROCESSES", USES),
        ("info.rss - info.shared", "0", USES),
        ("info.rss - info.shared", "info.rss", USES),
        (", BLOCK)", ", 0)", f"{WATCH}files_on_the_disk_count"),
    ],
    "sandbox/keeper.py": [
        ("    system.forbid_new_privileges()\n", "", f"{SEEN}it_has_no_rights_and_no_files_open"),
        ("    os.closerange(3, 1 << 16)\n", "", f"{SEEN}it_has_no_rights_and_no_files_open"),
        ("    system.install_filter(seccomp.program(shared_disk=shared_disk))\n", "",
         f"{SANDBOX}test_what_is_out_of_reach"),
    ],
    "sandbox/terms.py": [
        ('        "RLIMIT_FSIZE": SCRATCH_BYTES,\n', "", f"{SEEN}the_kernel_limits_each_process"),
        ('        "RLIMIT_NOFILE": 128,\n', "", f"{SEEN}the_kernel_limits_each_process"),
    ],
    "sandbox/fork.py": [
        ('            env=ENVIRONMENT | {"MPLCONFIGDIR": str(view.font_folder())},\n', "",
         f"{SEEN}the_environment_is_the_sandboxs_own"),
    ],
    "sandbox/view.py": [
        (', ".ipynb_checkpoints")', ")",
         f"{VIEW}an_editors_copies_of_a_withheld_module_are_withheld_too"),
        (" if one in rules), False)", " if one in rules), True)",
         f"{VIEW}a_link_in_a_folder_leads_nowhere_else"),
        (", path.resolve()):", ",):", f"{VIEW}a_folder_in_view_is_found_also_through_a_link"),
    ],
    "sandbox/seccomp.py": [
        ("    ((221, 187, 27), (223, 213, 232)),", "", f"{SECCOMP}what_acts_on_others_is_refused"),
        ("_EVICT = (20, 21)", "_EVICT = (20,)", f"{SECCOMP}calls_are_judged_by_their_arguments"),
    ],
    "executor/memory.py": [
        ("(most - KEPT_BACK_BYTES, most))\n    try", "(most, most))\n    try",
         "executor/test_memory.py::test_tests_have_their_share_and_the_grader_keeps_its_own"),
    ],
    "executor/handed_over.py": [
        ("if name not in named:", "if False:",
         "executor/test_handed_over.py::test_what_the_author_did_not_provide_for_is_refused"),
    ],
    "executor/session.py": [
        ("if self.fault or channel is not self._channel:", "if self.fault:",
         f"{SESSION}a_function_that_a_function_returned_has_the_same_deadline"),
        ("not self._channel.is_quiet()", "False",
         f"{SESSION}a_process_that_talks_by_itself_is_replaced_for_the_next_cell"),
    ],
    "executor/budget.py": [
        ("            self._ended += self._running()\n", "",
         "executor/test_budget.py::test_what_an_ended_process_used_stays_used"),
    ],
    "executor/trusted.py": [
        ("    _end_with_the_batch()\n", "",
         f"{TRUSTED}a_killed_batch_takes_its_processes_and_its_folder_with_it"),
    ],
    "protocol/wire.py": [
        ("if depth > MAX_DEPTH:", "if False:", f"{WIRE}a_sender_refuses_what_its_reader_would"),
        ("if len(body) > MAX_PAIR_BYTES:", "if False:", f"{WIRE}hand_written_bytes_are_refused"),
    ],
    "protocol/channel.py": [
        (" if name not in _ENDS_OF_LOOPS)", ")",
         f"{SESSION}nothing_that_a_student_raises_empties_a_loop"),
        ("if not isinstance(kind, str) or type(number) is not int:", "if False:",
         "protocol/test_channel.py::test_a_message_of_another_shape_ends_the_conversation"),
    ],
    "reading/source.py": [
        ("dont_inherit=True, optimize=0", "dont_inherit=True",
         f"{MARKING}asserts_count_under_an_optimising_interpreter"),
    ],
    "grading/allowed.py": [
        ("if shown is not None:", "if False:",
         "grading/test_allowed.py::test_what_student_code_could_read_is_refused"),
    ],
    "executor/guarded.py": [
        ("    signal.setitimer(signal.ITIMER_PROF, max(seconds, 0.001))\n", "",
         f"{BATCH}a_call_that_nothing_interrupts_is_the_students_timeout"),
    ],
    "grading/batch.py": [
        ("at_once > 1 and marked.doubtful", "False", f"{BATCH}a_limit_is_judged_alone"),
        ("            waiting.put(replace(task, seen=named))\n",
         "            ((_, last),) = _marked(run_pass([replace(task, seen=named)], 1))\n"
         "            yield task, last\n"
         "            continue\n",
         f"{BATCH}what_a_hidden_pass_leaves_behind_reaches_no_text"),
    ],
    "grading/tasks.py": [
        ("if job.path.is_symlink():", "if False:", f"{BATCH}a_link_on_the_way_is_refused"),
        ("if job.path.parent.is_symlink():", "if False:", f"{BATCH}a_link_on_the_way_is_refused"),
    ],
    "grading/marking.py": [
        ("missing = not score and owner", "missing = owner",
         f"{MARKING}an_exercise_that_earned_points_is_not_missing"),
        ("one = _Pass(whose, sandbox, run, seed)", "one = _Pass(whose, sandbox, run, 0)",
         f"{MARKING}hidden_inputs_are_drawn_from_the_batchs_seed"),
        ("run, seeds.PUBLIC_SEED, is_visible=True)", "run, 1, is_visible=True)",
         f"{MARKING}visible_checks_draw_from_the_public_seed"),
        ("self._doubtful |= own or", "self._doubtful |=",
         f"{MARKING}what_a_busy_machine_may_be_to_blame_for_is_doubtful"),
    ],
    "grading/cases.py": [
        ("if known or session.fault is None:", "if True:",
         f"{MARKING}a_fault_that_a_test_swallows_is_a_fault"),
        ("        contextlib.redirect_stdout(nowhere),\n", "", f"{MARKING}tests_print_nothing"),
        ("    signal.setitimer(signal.ITIMER_REAL, session.time_left() + ALARM_GRACE)\n", "",
         f"{MARKING}what_computes_for_ever_on_this_side_is_ended"),
    ],
    "markup.py": [
        ('.replace("|", "¦")', "", "test_markup.py::test_a_cell_stays_one_cell"),
        ("|##(?=", "|###(?=", "test_markup.py::test_no_ci_service_obeys_a_line"),
    ],
}  # fmt: skip
MUTANTS = [Mutant(file, *change) for file, changes in _CHANGES.items() for change in changes]


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


def fails(tests: Sequence[str], folder: Path, seconds: float) -> bool:
    """Whether a test fails in a copy of the project, or takes too long.

    Raises:
        RuntimeError: no test was run.
    """
    paths = [str(TESTS / test) for test in tests]
    places = os.pathsep.join(str(folder / name) for name in ("autograder", "lib"))
    pytest = subprocess.Popen(
        [sys.executable, "-B", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *paths],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": places},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        said, _ = pytest.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        return True
    finally:
        with contextlib.suppress(ProcessLookupError):  # what the mutant let live on
            os.killpg(pytest.pid, signal.SIGKILL)
        pytest.wait()
    if pytest.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(tests)}: {said[-2000:]}")
    return pytest.returncode == 1


def copy(folder: Path) -> Path:
    """Copy what git tracks of the project."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, folder / name)
    return folder


def main(words: Sequence[str]) -> int:
    """Try the mutants; exit status 1 where one is not caught, 2 where the words name none."""
    chosen = [
        mutant
        for mutant in MUTANTS
        if not words or any(word in f"{mutant.file} {mutant.caught_by}" for word in words)
    ]
    if not chosen:
        print(f"No mutant's file or test contains {' or '.join(words)}.", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)  # student code is another user
        folder = copy(Path(name))
        tests = list(dict.fromkeys(mutant.caught_by for mutant in chosen))
        if fails(tests, folder, SECONDS * len(tests)):
            print("A test fails on the grader as it is.")
            return 1
        left = 0
        for mutant in chosen:
            path = folder / PACKAGE / mutant.file
            before = path.read_bytes()
            apply(mutant, folder)
            caught = fails([mutant.caught_by], folder, SECONDS)
            path.write_bytes(before)
            left += not caught
            sign = "✓ caught" if caught else "✗ NOT caught"
            print(f"{sign}  {mutant.file}: {mutant.old.strip()}", flush=True)
    print(f"{len(chosen) - left} of {len(chosen)} mutants are caught.")
    return 1 if left else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
