"""The door to a Dask cluster: workers grade, the coordinator alone reads and writes.

What travels is bytes: the tests, the seed and the submission there, the text of a result file
back. A worker needs no shared disk and writes nothing. It takes a submission only where its code
and its wall are the coordinator's, and grades it in a trusted process, as a local batch does.
"""

from __future__ import annotations

import functools
import pickle
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.executor import trusted
from robust_slam_autograder.executor.dask_workers import Call, Cluster, Unfit, may_have_children
from robust_slam_autograder.executor.trusted import Broken
from robust_slam_autograder.grading import batch, results
from robust_slam_autograder.grading.batch import Handed, Job, Start, Task
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.sandbox import BACK_ENDS, Sandbox, Unsandboxed

UNSANDBOXED = "unsandboxed"
OTHER_CODE = (
    "its Python, packages or grader are not those of this machine, and a mark must not depend on "
    "the machine: install the same commit from the same requirements.lock, and restart it"
)
Answer = tuple[str, str]
""""result" and the text of its file, or "broken" and how."""


@dataclass(frozen=True)
class Parcel:
    """All that a worker needs to grade one submission."""

    job: Job
    handed: Handed
    seed: int
    seconds: float
    """What its trusted process may take."""
    preload: tuple[str, ...]


@dataclass(frozen=True)
class _Packed:
    """A task that has been read, with the digest of just that text."""

    task: Task
    parcel: bytes


def door(cluster: Cluster, jobs: Sequence[Job], seed: int, wall: Sandbox) -> Start:
    """Make ready to grade on a cluster: bound to one, this is a ``batch.Door``.

    Raises:
        WrongUse: the wall is none that workers know by a name.
    """
    wanted, digest_of = name_of(wall), batch.Fingerprints(seed, wall).as_read
    preload = (*batch.preload(jobs), __name__)

    def pack(task: Task) -> _Packed:
        job, _ = task
        handed = batch.read(job)
        parcel = Parcel(job, handed, seed, batch.patience(job), preload)
        return _Packed((job, digest_of(job, handed)), pickle.dumps(parcel))

    def call(packed: _Packed) -> Call:
        return grade_on_worker, batch.code_digest(), wanted, packed.parcel

    def start(
        tasks: Iterable[Task], *, at_once: int
    ) -> Iterator[tuple[Task, Result | trusted.Broken]]:
        for packed, answer in cluster.run(map(pack, tasks), call, alone=at_once == 1):
            yield packed.task, _checked(answer, packed.task[0])

    return start


def name_of(wall: Sandbox) -> str:
    """The name by which a worker finds the same wall.

    Raises:
        WrongUse: it has none.
    """
    if isinstance(wall, Unsandboxed):
        return UNSANDBOXED
    for name, one in BACK_ENDS.items():
        if one is wall:
            return name
    raise WrongUse(f"Workers know no sandbox {wall.name}.")


def _checked(answer: object, job: Job) -> Result | Broken:
    """A worker's answer, where it is a result of this submission."""
    match answer:
        case Broken():
            return answer
        case ("broken", str(how)):
            return Broken(how)
        case ("result", str(text)):
            try:
                result = results.from_text(text)
            except (ValueError, KeyError, TypeError, AttributeError):
                return Broken("sent back no result")
            if (result.student, result.assignment) == (job.student, job.assignment.name):
                return result
    return Broken("sent back no result")


def grade_on_worker(code: str, wall_name: str, parcel: bytes) -> Answer | Unfit:
    """Grade a submission; the worker's part.

    Args:
        code: digest of the coordinator's code; nothing is unpacked where ours differs.
        wall_name: where student code runs, here too.
        parcel: a pickled ``Parcel``.
    """
    if code != batch.code_digest():
        return Unfit(OTHER_CODE)
    wall = Unsandboxed() if wall_name == UNSANDBOXED else BACK_ENDS[wall_name]
    problem = wall.problem()
    if problem is not None:
        mend = "see `autograder doctor` there, or choose another one for all with --sandbox"
        return Unfit(f"the sandbox {wall_name} does not work there ({problem}): {mend}")
    may_have_children()
    found: Parcel = pickle.loads(parcel)
    ((_, answer),) = trusted.run(
        [found],
        functools.partial(_grade, wall=wall),
        at_once=1,
        seconds=lambda task: task.seconds,
        preload=found.preload,
    )
    if isinstance(answer, Broken):
        return "broken", answer.how
    return "result", results.as_text(answer)


def _grade(parcel: Parcel, *, wall: Sandbox) -> Result:
    return batch.grade_one(parcel.job, parcel.seed, wall, parcel.handed)
