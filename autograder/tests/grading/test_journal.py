"""What a batch remembers survives a kill at any moment, and costs a line for each submission."""

import itertools

import pytest
from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.grading import durable, journal
from robust_slam_autograder.grading.journal import LOG_NAME, RUN_NAME, open_journal

from .disks import full_disk


def test_a_batch_draws_a_secret_seed_and_keeps_it(tmp_path):
    first, other = open_journal(tmp_path / "a", None), open_journal(tmp_path / "b", None)
    assert first.seed != other.seed and first.seed > 2**32
    assert open_journal(tmp_path / "a", None).seed == first.seed
    for name in (RUN_NAME, LOG_NAME):
        assert (tmp_path / "a" / name).stat().st_mode & 0o077 == 0


def test_a_new_seed_begins_a_new_batch(tmp_path):
    run = open_journal(tmp_path, 3)
    run.remember("ada/x", "1")
    assert open_journal(tmp_path, 3).graded == {"ada/x": "1"}
    assert open_journal(tmp_path, 5).graded == {}
    assert open_journal(tmp_path, None) == journal.Journal(tmp_path, 5)


def test_what_is_remembered_is_read_back(tmp_path):
    run = open_journal(tmp_path, 1)
    for key in ("ada/x", "bob/x", "zoë/x", "eve\udcff/x"):
        run.remember(key, f"print of {key!a}")
    run.forget("bob/x")
    run.forget("nobody/x")
    assert open_journal(tmp_path, None) == run
    assert list(run.graded) == ["ada/x", "zoë/x", "eve\udcff/x"]


def test_a_line_that_was_cut_short_counts_for_nothing(tmp_path):
    log = tmp_path / LOG_NAME
    run = open_journal(tmp_path, 1)
    run.remember("ada/x", "1")
    run.remember("bob/x", "2")
    whole = log.read_bytes()
    for length in range(whole.index(b"\n") + 1, len(whole) - 1):
        log.write_bytes(whole[:length])
        again = open_journal(tmp_path, None)
        assert again.graded == {"ada/x": "1"}
        again.remember("cem/x", "3")
        assert open_journal(tmp_path, None).graded == {"ada/x": "1", "cem/x": "3"}


@pytest.mark.parametrize(
    "junk", [b"\0" * 40, b"\xff\xfe", b'["graded", 1, 2]', b"[" * 5000, b"{}"]
)
def test_lines_that_say_nothing_are_passed_over(tmp_path, junk):
    run = open_journal(tmp_path, 1)
    run.remember("ada/x", "1")
    with open(tmp_path / LOG_NAME, "ab") as file:
        file.write(junk + b"\n")
    assert open_journal(tmp_path, None) == run


def test_the_log_grows_by_a_line_for_each_submission(tmp_path):
    """A batch of ten thousand must not write ten thousand times ten thousand lines."""
    run, log = open_journal(tmp_path, 1), tmp_path / LOG_NAME
    sizes = []
    for number in range(1000):
        run.remember(f"{number:04}/x", "f" * 64)
        sizes.append(log.stat().st_size)
    assert {after - before for before, after in itertools.pairwise(sizes)} == {sizes[0]}
    assert len(open_journal(tmp_path, None).graded) == 1000


@pytest.mark.parametrize("text", ["", "[]", '{"seed": "x"}', "{}", "\xff"])
def test_a_batch_that_cannot_be_read_says_so(tmp_path, text):
    (tmp_path / RUN_NAME).write_text(text, encoding="latin-1")
    with pytest.raises(WrongUse, match=r"\.run\.json cannot be read: delete it"):
        open_journal(tmp_path, None)


def test_a_half_file_of_a_killed_run_is_written_over(tmp_path):
    path = tmp_path / "b.json"
    durable.part_of(path).write_text("half of a long te")
    durable.write(path, "new")
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]


def test_a_line_that_does_not_fit_on_the_disk_is_an_error_that_names_the_file(tmp_path):
    run = open_journal(tmp_path, 1)
    run.remember("ada/x", "1")
    with full_disk(100), pytest.raises(GraderFailure, match=r"\.run\.log cannot be written"):
        run.remember("bob/x", "2" * 100)
    assert open_journal(tmp_path, None).graded == {"ada/x": "1"}
