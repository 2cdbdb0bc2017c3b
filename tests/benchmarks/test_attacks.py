"""The comparison of graders: what it counts, and the container that nbgrader runs in."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.attacks import container, evidence, plain, tables
from benchmarks.attacks.container import Outcome
from benchmarks.attacks.evidence import Secrets
from benchmarks.attacks.plain import Plain
from benchmarks.attacks.record import Record, Records
from tests.autograder import toy
from tests.autograder.hostile import catalogue
from tests.autograder.hostile.entry import Entry
from tests.autograder.hostile.target import Target, load
from tests.conftest import leave_out

ALL = {"double-by-hand": 4.0, "double-random": 6.0, "apply-by-hand": 5.0, "apply-twice": 5.0}
PART = ALL | {"double-by-hand": 0.0, "double-random": 0.0}
LINE = "x = rng.normal(size=5)"
SEED = 7
ATTACK = catalogue.ATTACKS[0]
OTHERS = tuple(e for e in catalogue.ATTACKS if e.bound == "wrong" and not e.twin)[1:4]


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Target:
    folder = tmp_path_factory.mktemp("target")
    return load(toy.make_tree(folder), toy.NAME, folder / "release")


class TestTheTables:
    def faults(self, target: Target, record: Record, entry: Entry = ATTACK) -> set[str]:
        baselines = {name: Record(PART) for name in catalogue.BASELINES}
        return set(tables.faults([entry], baselines | {entry.name: record}, target)[entry.name])

    def test_more_than_a_plain_wrong_answer_is_inflated(self, target: Target) -> None:
        some = PART | {"double-by-hand": 4.0}
        assert self.faults(target, Record(PART)) == set()
        assert self.faults(target, Record(some)) == {tables.INFLATED}
        assert self.faults(target, Record(ALL)) == {tables.INFLATED, tables.FULL}

    def test_right_answers_in_a_broken_file_are_no_inflation_but_a_neighbours_are(
        self, target: Target
    ) -> None:
        refused = [entry for entry in catalogue.ATTACKS if entry.bound == "refused"]
        own = next(entry for entry in refused if entry.kind.startswith("broken:"))
        copied = next(entry for entry in refused if entry.kind.startswith("others:"))
        assert self.faults(target, Record(ALL), own) == set()
        assert tables.INFLATED in self.faults(target, Record(ALL), copied)

    def test_a_correct_loss_a_leak_harm_and_a_stop_are_counted(self, target: Target) -> None:
        right = next(entry for entry in catalogue.entries() if entry.kind == "correct: prints")
        record = Record(PART, ("token",), ("the gradebook cannot be read",), "hung")
        assert self.faults(target, record, right) == {"under-graded", "token", "harmed", "stopped"}
        side = tables.Side("it", {right.name: record}, 59.7)
        row = tables.summary([right], [side], target).split("\n")[-1]
        assert row == "| it | 0 (0) | 1 | 0 (0) | 0 | 1 | 1 | 1 | 60 |"


class TestTheEvidence:
    def test_highlighted_code_and_outputs_are_read_as_a_student_reads_them(
        self, target: Target
    ) -> None:
        secret = evidence.secrets(target, SEED, "a-token", one_generator=True)
        page = evidence.text_of_page(
            b'<b>x</b> <span class="o">=</span> rng.normal(<i>size</i>=5)'
        )
        assert evidence.found(evidence.Seen(page, ""), secret) == ("hidden tests",)

    def test_what_a_traceback_shows_is_not_what_the_code_said(self) -> None:
        error = {"output_type": "error", "evalue": "no luck", "traceback": [f"\x1b[31m{LINE}"]}
        notebook = {"cells": [{"outputs": [error]}, {}]}
        every, told = evidence.outputs(json.dumps(notebook).encode())
        assert LINE in every and LINE not in told
        assert "no luck" in told

    def test_one_generator_draws_other_hidden_inputs_than_one_for_each_case(
        self, target: Target
    ) -> None:
        together, apart = (
            evidence.secrets(target, SEED, "", one_generator=one).inputs for one in (True, False)
        )
        assert together and apart and together != apart

    def test_a_new_file_where_all_may_write_is_no_harm_but_in_a_submission_it_is(self) -> None:
        after = {"outside/new": (1,), "submitted/ada/new": (1,), "outside/notes.txt": (2,)}
        found = evidence.changes({"outside/notes.txt": (1,)}, after)
        assert found == ["outside/notes.txt changed", "submitted/ada/new changed"]


class TestABatchOfPlainNbgrader:
    @pytest.fixture()
    def course(self, target: Target, tmp_path: Path) -> Plain:
        return Plain(tmp_path, target, Secrets(set(), set(), "t"), {}, 1)

    def test_dangerous_ones_stand_alone(self) -> None:
        found = plain.groups(catalogue.ATTACKS, 5)
        assert sorted(e.name for g in found for e in g) == sorted(
            e.name for e in catalogue.ATTACKS
        )
        assert all(len(group) == 1 for group in found if any(e.dangerous for e in group))
        assert max(map(len, found)) == 5

    def test_one_that_hangs_goes_on_without_its_culprit(
        self, course: Plain, tmp_path: Path
    ) -> None:
        group = tuple(sorted(OTHERS, key=plain.student_of))
        log = tmp_path / "log"
        names = [plain.FIRST, *(plain.student_of(e) for e in group[:2])]
        log.write_text("".join(f"Creating/updating student with ID '{n}': {{}}\n" for n in names))
        settled = plain.settle(course, group, {}, Outcome({}, log, frozenset({1})))
        assert list(settled.records) == [group[0].name]
        assert settled.again == ((group[1],), (group[2],))

    def test_harm_is_looked_for_one_by_one_and_alone_it_has_an_author(
        self, course: Plain, tmp_path: Path
    ) -> None:
        (tmp_path / "log").write_text("")
        gone = {"submitted/ada/a.ipynb": ("file",)}
        files = {"outside/notes.txt": container.File("file", 0o644, "", b"")}
        outcome = Outcome(files, tmp_path / "log", frozenset())
        assert plain.settle(course, OTHERS, gone, outcome).again == tuple((e,) for e in OTHERS)
        own = {f"submitted/{plain.student_of(OTHERS[0])}/a": ("file",)}
        record = plain.settle(course, OTHERS[:1], gone | own, outcome).records[OTHERS[0].name]
        assert [text for text in record.harmed if text.startswith("submitted")] == [
            "submitted/ada/a.ipynb changed"
        ]


@pytest.mark.sandbox
class TestTheContainer:
    @pytest.fixture()
    def given(self, tmp_path: Path) -> Path:
        problem = container.problem()
        if problem is not None:
            leave_out(f"nbgrader's container does not work here: {problem}")
        tmp_path.chmod(0o755)
        for name in (*container.WATCHED, "autograded/a/b", "feedback"):
            (tmp_path / "course" / name).mkdir(parents=True)
        (tmp_path / "course/outside/notes.txt").write_text("notes")
        return tmp_path

    def run(self, given: Path, *codes: str, stall_seconds: float = 60) -> Outcome:
        steps = [[sys.executable, "-c", code] for code in codes]
        return container.run(given, steps, {"X": "y"}, number=1, stall_seconds=stall_seconds)

    def test_files_come_out_though_everything_was_killed(self, given: Path) -> None:
        kill = "import os; open('outside/new', 'w').write(os.environ['X']); os.kill(-1, 9)"
        outcome = self.run(given, kill)
        assert outcome.files["outside/new"].data == b"y"
        assert outcome.hung == frozenset()

    def test_a_step_that_hangs_is_ended_and_the_next_one_runs(self, given: Path) -> None:
        hang = "import os, signal; os.kill(os.getpid(), signal.SIGSTOP)"
        outcome = self.run(given, hang, "open('outside/next', 'w')", stall_seconds=2)
        assert outcome.hung == {1}
        assert "outside/next" in outcome.files

    def test_nothing_of_the_machine_is_in_it(self, given: Path) -> None:
        (given.parent / "secret").write_text("secret")
        look = f"""
import os, socket
assert not os.path.exists({str(given.parent / "secret")!r}) and os.getuid() != 0
assert not os.path.exists("/home/x") and len([n for n in os.listdir("/proc") if n.isdigit()]) < 9
assert [name for _, name in socket.if_nameindex()] == ["lo"]
open("outside/looked", "w")
"""
        assert "outside/looked" in self.run(given, look).files

    def test_what_was_given_stays_as_it_was(self, given: Path) -> None:
        deep = given / "course/submitted/ada/x/.deep/deeper"
        deep.mkdir(parents=True)
        (deep / "file").write_text("text")
        before = container.states(given / "course")
        outcome = self.run(given, "open('outside/notes.txt', 'w').write('mine')")
        assert container.states(given / "course") == before
        assert outcome.files["outside/notes.txt"].data == b"mine"
        after = {path: file.state for path, file in outcome.files.items()}
        assert evidence.changes(before, after) == ["outside/notes.txt changed"]


def test_records_survive_and_are_read_back(tmp_path: Path) -> None:
    record = Record({"a": 1.0}, ("token",), ("ada lost a",), "hung")
    Records(tmp_path / "r.json").add("nbgrader", {"one": record})
    more = Records(tmp_path / "r.json")
    more.add("autograder", {"one": replace(record, stopped="")})
    assert Records(tmp_path / "r.json").of("nbgrader") == {"one": record}
    assert Records(tmp_path / "r.json").of("autograder")["one"].stopped == ""
