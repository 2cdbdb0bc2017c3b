"""A batch on a Dask cluster: the marks of one process, whatever becomes of the workers."""

import contextlib
import functools
import json
import os
import pickle
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from distributed import Client
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor import dask_workers as engine
from robust_slam_autograder.executor.dask_workers import Cluster, Unfit
from robust_slam_autograder.executor.trusted import Broken
from robust_slam_autograder.grading import batch, journal, remote, submissions
from robust_slam_autograder.grading.batch import Graded, Terms
from robust_slam_autograder.grading.submissions import Outcome, Submission
from robust_slam_autograder.sandbox import BACK_ENDS, Unsandboxed

from .. import toy
from ..as_user import ROOT
from ..killing import wait_for
from .course import grade as grade_here
from .course import jobs, leave, make_course, same_but_for_time

pytestmark = pytest.mark.rest

SLOW = f"import time\ntime.sleep(0.4)\n{toy.DOUBLE}"


@dataclass
class Machines:
    """A scheduler, and the workers that a test starts."""

    folder: Path
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._file = self.folder / "scheduler.json"
        where = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(self._file)]
        self._start("scheduler", *where)
        # The file is there before it is written.
        wait_for(lambda: self._file.exists() and self._file.read_text().endswith("}"))
        self.address = json.loads(self._file.read_text())["address"]

    def worker(self, *options: str) -> subprocess.Popen[bytes]:
        where = ["--scheduler-file", str(self._file), "--local-directory", str(self.folder)]
        return self._start("worker", *where, "--nthreads", "1", *options)

    def _start(self, what: str, *options: str) -> Any:
        command = [sys.executable, "-m", "dask", what, "--no-dashboard", *options]
        with open(self.folder / f"{what}-{len(self.processes)}.log", "wb") as log:
            process = subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log)
        self.processes.append(process)
        return process

    def stop(self) -> None:
        """Kill them all: what they have started ends with them, and to say goodbye takes long."""
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@pytest.fixture
def machines(tmp_path):
    (tmp_path / "dask").mkdir()
    started = Machines(tmp_path / "dask")
    yield started
    started.stop()


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """A scheduler with two workers, for tests that leave them alive."""
    started = Machines(tmp_path_factory.mktemp("dask"))
    for _ in range(2):
        started.worker("--no-nanny")
    yield started
    started.stop()


def client_of(machines: Machines) -> Client:
    return Client(machines.address, set_as_default=False)


@contextlib.contextmanager
def connected(machines: Machines, workers: int) -> Iterator[Cluster]:
    with engine.connected(machines.address) as found:
        with client_of(machines) as client:
            client.wait_for_workers(workers)
        yield found


def grade(course: Path, workers: Cluster, **options: Any) -> list[Graded]:
    most = len(options.get("given") or jobs(course))
    there = functools.partial(remote.grade, workers)
    return grade_here(course, workers=most, graders=there, **options)


def lines(out: Path) -> Counter[str]:
    """How often the journal says that a submission has its result."""
    parsed = [json.loads(line) for line in (out / journal.LOG_NAME).read_text().splitlines()]
    return Counter(key for what, key, fingerprint in parsed if what == "graded" and fingerprint)


@pytest.mark.sandbox
def test_marks_are_those_of_one_process(tmp_path, two, wall_name):
    """Refusals too, in the same words. A class is graded here and by two workers that start."""
    course = make_course(tmp_path)
    (course / "submitted" / "zoe").symlink_to("ada")
    (course / "submitted" / "yan" / toy.NAME).mkdir(parents=True)
    odd = toy.hand_in(course / "submitted", "xia", toy.answer())
    (odd / f"{toy.NAME}.ipynb").rename(odd / os.fsdecode(b"m\xffine.ipynb"))
    wall = BACK_ENDS[wall_name]
    serial = grade_here(course, "serial", workers=1, wall=wall)
    with connected(two, 2) as workers:
        found = grade(course, workers, wall=wall)
        assert lines(course / "out") == Counter(job.key for job in jobs(course))
        assert all(item.reused for item in grade(course, workers, wall=wall))
    assert same_but_for_time(serial, found)
    assert {item.load().sandbox for item in found} == {wall.name, "none"}


def test_a_worker_is_killed_and_another_joins_and_each_has_one_result(
    tmp_path, machines, monkeypatch
):
    """Dask's scheduler and three workers start, and each imports the grader."""
    toy.make_tree(tmp_path)
    for number in range(8):
        toy.hand_in(tmp_path / "submitted", f"{number:02}", toy.answer(SLOW))
    first, _ = (machines.worker("--no-nanny") for _ in range(2))
    reported: list[Graded] = []
    used: list[str] = []
    with client_of(machines) as client:
        client.wait_for_workers(2)
        submit, there = client.submit, client.nthreads
        two = set(there())

        def noted(*arguments: Any, **options: Any) -> Any:
            used.extend(options["workers"])
            return submit(*arguments, **options)

        monkeypatch.setattr(client, "submit", noted)

        def change(graded: Graded) -> None:
            reported.append(graded)
            if len(reported) == 3:
                first.kill()
                machines.worker("--no-nanny")
            elif len(reported) == 4:  # the killed one had its next by then
                wait_for(lambda: set(there()) - two)

        graded = grade(tmp_path, Cluster(client, machines.address), report=change)
    assert [item.load().score for item in graded] == [20] * 8
    assert len(reported) == 8
    assert lines(tmp_path / "out") == Counter(job.key for job in jobs(tmp_path))
    assert len(set(used)) == 3, "the one that joined had no submission"
    assert len(used) == 17, "the one of the killed worker, and no other, was sent again"


def test_a_stop_cancels_what_waits(tmp_path, two):
    toy.make_tree(tmp_path)
    for number in range(8):
        toy.hand_in(tmp_path / "submitted", f"{number:02}", toy.answer())

    def stop(graded: Graded) -> None:
        raise KeyboardInterrupt

    def tasks(dask_scheduler: Any) -> int:
        return len(dask_scheduler.tasks)

    with connected(two, 2) as workers, client_of(two) as client:
        with pytest.raises(KeyboardInterrupt):
            grade(tmp_path, workers, report=stop)
        wait_for(lambda: client.run_on_scheduler(tasks) == 0)
        assert sum(lines(tmp_path / "out").values()) == 1
        assert sum(item.reused for item in grade(tmp_path, workers)) == 1


def test_the_command_says_what_is_missing(course, autograder, monkeypatch):
    where = (course / "submitted" / "ada" / toy.NAME, "--unsandboxed", "--out", course / "out")
    command = ("grade", *where, "--scheduler")
    monkeypatch.setattr(engine, "CONNECT_SECONDS", 0.5)
    for address, why in {
        "tcp://127.0.0.1:9": "No Dask scheduler answers at tcp://127.0.0.1:9 (",
        "127.0.0.1:9": "127.0.0.1:9 is not a scheduler's address: it needs tcp://",
        "tcp://127.0.0.1": "is not a scheduler's address",
        "tls://127.0.0.1:9": "tls://127.0.0.1:9 needs certificates: set distributed.comm.tls.ca",
    }.items():
        assert autograder(*command, address).refused(why)
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert autograder(*command, "tcp://127.0.0.1:9").refused("pip install distributed")
    assert not (course / "out").exists()


def test_the_commands_grade_and_grade_again_on_a_cluster(course, two, autograder):
    options = ("--unsandboxed", "--out", course / "out", "--scheduler", two.address)
    status, said, _ = autograder("grade", course / "submitted" / "ada" / toy.NAME, *options)
    assert status == 0 and "1 graded, 0 refused, 0 failed" in said
    assert toy.result(course / "out", "ada")["score"] == 20
    toy.hand_in(course / "submitted", "ada", toy.answer(toy.DOUBLE.replace("2 *", "3 *")))
    again = ("regrade", toy.NAME, "--submitted", course / "submitted", "--json")
    status, said, _ = autograder(*again, *options)
    (change,) = json.loads(said)["changes"]
    assert status == 0
    assert change["after"]["score"] < change["before"]["score"] == 20


class TestWhatAWorkerMayDo:
    def test_it_unpacks_nothing_from_other_code_nor_without_the_wall_that_was_asked_for(
        self, monkeypatch
    ):
        answer = remote.grade_on_worker("0", remote.UNSANDBOXED, b"no pickle")
        assert answer == Unfit(remote.OTHER_CODE)
        monkeypatch.setitem(BACK_ENDS, "fork", toy.Broken())
        answer = remote.grade_on_worker(submissions.code_digest(), "fork", b"no pickle")
        assert isinstance(answer, Unfit) and "(it is not installed)" in answer.why

    def test_a_submission_travels_as_it_was_read(self, tmp_path):
        """What changes on the disk meanwhile has another fingerprint than what was sent."""
        course = make_course(tmp_path)
        leave(course, "ada")
        (job,) = jobs(course)
        fake = Fake({"tcp://a:1": 1})
        sent: list[Submission] = []
        path = job.path / f"{toy.NAME}.ipynb"

        def answer(worker: str, code: str, wall: str, parcel: bytes) -> str:
            sent.append(pickle.loads(parcel)[0])
            path.write_text(path.read_text() + " ")
            passed = batch.run_pass(sent[-1], seed=1, sandbox=Unsandboxed())
            return passed.as_text()

        fake.answer = answer
        grade(course, fake.cluster(), given=[job])
        noted = journal.open_journal(course / "out", 1).graded[job.key]
        assert noted == sent[0].fingerprint
        assert noted != submissions.Fingerprints(1, Unsandboxed()).read(job).fingerprint
        assert [task.data + b"  " for task in sent] == [path.read_bytes()] * 2


@pytest.mark.parametrize(
    "answer", [None, 3, "{}", ("x", "y"), "[" * 100_000, Broken(3), "another's"], ids=range(7)
)
def test_what_is_no_result_of_this_one_is_a_failure_of_the_grader(tmp_path, answer):
    first, second, *_ = jobs(make_course(tmp_path))
    if answer == "another's":
        task = submissions.Fingerprints(1, Unsandboxed()).read(first)
        answer = batch.run_pass(task, seed=1, sandbox=Unsandboxed()).as_text()
        assert taken(answer, first) == Outcome.from_text(answer)
    assert taken(answer, second) == Broken("sent back no result")


@dataclass(eq=False)
class FakeFuture:
    """An answer that is there as soon as somebody wants it."""

    value: Any
    status: str = "finished"

    def add_done_callback(self, call: Callable[[Any], object]) -> None:
        if self.status != "pending":
            call(self)

    def result(self, timeout: float) -> Any:
        if isinstance(self.value, Exception):
            raise self.value
        return self.value


@dataclass
class Fake:
    """A client whose workers answer at once, or not at all."""

    threads: dict[str, int]
    answer: Callable[..., Any] = lambda worker, *arguments: worker
    sent: list[tuple[str, Any]] = field(default_factory=list)

    def cluster(self) -> Cluster:
        return Cluster(self, "tcp://scheduler")

    def nthreads(self) -> dict[str, int]:
        return dict(self.threads)

    def submit(self, function: Any, *arguments: Any, workers: list[str], pure: bool) -> Any:
        (worker,) = workers
        self.sent.append((worker, arguments))
        value = self.answer(worker, *arguments)
        if value == "dies":
            del self.threads[worker]
        return FakeFuture(value, "pending" if value in ("dies", "waits") else "finished")

    def cancel(self, futures: list[Any], force: bool) -> None:
        pass


def taken(answer: Any, job: Submission) -> Outcome | Broken:
    """What a worker's answer for a submission is taken for."""
    fake = Fake({"tcp://a:1": 1}, answer=lambda worker, *arguments: answer)
    task = submissions.Fingerprints(1, Unsandboxed()).read(job)
    ((_, found),) = remote.grade(fake.cluster(), Terms(1, Unsandboxed(), ()), [task], 2)
    return found


def done(fake: Fake, tasks: int, **options: Any) -> list[tuple[int, Any]]:
    return list(fake.cluster().run_each(range(tasks), lambda task: (print, task), **options))


class TestEngine:
    @pytest.fixture(autouse=True)
    def quick(self, monkeypatch):
        """Look often, and lose patience soon."""
        monkeypatch.setattr(engine, "LOOK_SECONDS", 0.01)
        monkeypatch.setattr(engine, "PATIENCE_SECONDS", 0.1)

    @pytest.mark.parametrize("answer", [Unfit("rusty"), ImportError("gone")], ids=repr)
    def test_a_worker_that_is_unfit_or_fails_is_asked_no_more(self, answer, capsys):
        fake = Fake({"tcp://a:1": 1, "tcp://b:1": 1})
        fake.answer = lambda worker, task: answer if "a:" in worker else task
        assert sorted(done(fake, 9)) == [(task, task) for task in range(9)]
        assert sum("a:" in worker for worker, _ in fake.sent) == 1
        assert capsys.readouterr().err.startswith("The worker tcp://a:1 is left out: ")

    def test_several_threads_are_refused_and_nobody_is_waited_for_forever(self):
        with pytest.raises(GraderFailure, match=r"has 4 threads: start it with --nthreads 1"):
            done(Fake({"tcp://a:1": 4}), 1)
        with pytest.raises(GraderFailure, match=r"there is none.*dask worker tcp://scheduler"):
            done(Fake({}), 1)
        assert done(Fake({}), 0) == []

    def test_tasks_are_taken_as_workers_get_free(self):
        fake = Fake({"tcp://a:1": 1, "tcp://b:1": 1}, answer=lambda worker, task: "waits")
        taken: list[int] = []
        tasks = (taken.append(number) or number for number in range(99))
        found = fake.cluster().run_each(tasks, lambda task: (print, task))
        fake.answer = lambda worker, task: task if task == 1 else "waits"
        assert next(found) == (1, 1)
        assert taken == [0, 1]
        assert [worker for worker, _ in fake.sent] == ["tcp://a:1", "tcp://b:1"]

    def test_alone_is_one_on_each_machine(self):
        fake = Fake({"tcp://a:1": 1, "tcp://a:2": 1, "tcp://b:1": 1})
        fake.answer = lambda worker, task: task if task == 1 else "waits"
        found = fake.cluster().run_each(range(9), lambda task: (print, task), alone=True)
        assert next(found) == (1, 1)
        assert [worker for worker, _ in fake.sent] == ["tcp://a:1", "tcp://b:1"]

    def test_who_comes_after_a_killer_is_not_blamed(self):
        """One machine, whose worker comes again each time, as under a nanny."""
        fake = Fake({"tcp://a:1": 1})

        def answer(worker: str, task: int) -> Any:
            assert len(fake.sent) < 50, "a task is sent again for ever"
            if task == 0:
                fake.threads[f"tcp://a:{len(fake.sent) + 1}"] = 1
                return "dies"
            return task if worker in fake.threads else "waits"

        fake.answer = answer
        found = dict(done(fake, 4))
        assert found == {0: Broken("lost its worker 3 times"), 1: 1, 2: 2, 3: 3}

    def test_a_scheduler_that_is_gone_is_told(self):
        fake = Fake({"tcp://a:1": 1})

        def gone() -> dict[str, int]:
            raise OSError

        def last(worker: str, task: int) -> str:
            fake.nthreads = gone
            return "waits"

        fake.answer = last
        with pytest.raises(GraderFailure, match=r"tcp://scheduler is gone: start it again"):
            done(fake, 3)
