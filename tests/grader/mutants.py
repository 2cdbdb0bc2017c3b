"""Mutants of the grader: small changes that remove a protection, and the test that catches each.

``python -m tests.grader.mutants [WORD…]`` tries them, as ``tests/mutants.py`` says. All of
them take minutes.
"""

import sys

from tests.mutants import Mutant, main

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
        ("else most - KEPT_BACK_BYTES", "else most",
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
        ("    guarded.end_with_parent()\n", "",
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
    "grading/exposed_folders.py": [
        ("if shown is not None:", "if False:",
         "grading/test_allowed.py::test_what_student_code_could_read_is_refused"),
    ],
    "executor/guarded.py": [
        ("    signal.setitimer(signal.ITIMER_PROF, max(seconds, 0.001))\n", "",
         f"{BATCH}a_call_that_nothing_interrupts_is_the_students_timeout"),
    ],
    "grading/batch.py": [
        ("at_once > 1 and found.doubtful", "False", f"{BATCH}a_limit_is_judged_alone"),
        ("            between_passes.put(kept, replace(one, seen=found))\n",
         "            ((_, last),) = _ended(run_pass([replace(one, seen=found)], 1))\n"
         "            yield one, last\n"
         "            continue\n",
         f"{BATCH}what_a_hidden_pass_leaves_behind_reaches_no_text"),
    ],
    "grading/submissions.py": [
        ("if one.path.is_symlink():", "if False:", f"{BATCH}a_link_on_the_way_is_refused"),
        ("if one.path.parent.is_symlink():", "if False:", f"{BATCH}a_link_on_the_way_is_refused"),
    ],
    "grading/passes.py": [
        ("missing = not score and owner", "missing = owner",
         f"{MARKING}an_exercise_that_earned_points_is_not_missing"),
        ("        self._seed = seed\n", "        self._seed = 0\n",
         f"{MARKING}hidden_inputs_are_drawn_from_the_batchs_seed"),
        ("_seed: int = seeds.PUBLIC_SEED", "_seed: int = 1",
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
MUTANTS = [
    Mutant(f"autograder/robust_slam_autograder/{file}", old, new, f"autograder/tests/{test}")
    for file, changes in _CHANGES.items()
    for old, new, test in changes
]

if __name__ == "__main__":
    raise SystemExit(main(MUTANTS, sys.argv[1:]))
