"""Grading on a cluster: workers grade, the coordinator alone reads and writes.

What travels is bytes: the tests, the seed and the submission there, a result's text back.
A worker needs no shared disk and writes nothing. It takes a submission only where its code and its
sandbox are the coordinator's, and grades it in a trusted process, as a local batch does.
"""

import contextlib
import pickle
from collections.abc import Iterable, Iterator

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.executor.dask_workers import Call, Cluster, Unfit
from robust_slam_autograder.executor.trusted import Broken
from robust_slam_autograder.grading import batch
from robust_slam_autograder.grading.batch import Terms
from robust_slam_autograder.grading.submissions import Outcome, Submission, code_digest
from robust_slam_autograder.sandbox import BACK_ENDS, Sandbox, Unsandboxed

UNSANDBOXED = "unsandboxed"
OTHER_CODE = (
    "its Python, packages or grader are not those of this machine, and a mark must not depend on "
    "the machine: install the same commit from the same requirements-dev.lock, and restart it"
)


def grade(
    cluster: Cluster, terms: Terms, tasks: Iterable[Submission], at_once: int
) -> Iterator[tuple[Submission, Outcome | Broken]]:
    """Run each task's next pass on a worker of the cluster that is fit for it.

    Raises:
        WrongUse: workers know the sandbox by no name.
    """
    code, wanted = code_digest(), name_of(terms.sandbox)

    def call(task: Submission) -> Call:
        parcel = pickle.dumps((task, terms.seed, terms.preload))
        return grade_on_worker, code, wanted, parcel

    for task, answer in cluster.run_each(tasks, call, alone=at_once == 1):
        yield task, _checked(answer, task)


def name_of(sandbox: Sandbox) -> str:
    """Return the name by which a worker finds the same sandbox.

    Raises:
        WrongUse: it has none.
    """
    if isinstance(sandbox, Unsandboxed):
        return UNSANDBOXED
    for name, one in BACK_ENDS.items():
        if one is sandbox:
            return name
    raise WrongUse(f"Workers know no sandbox {sandbox.name}.")


def _checked(answer: object, job: Submission) -> Outcome | Broken:
    """Read a worker's answer, where it is a result of this submission."""
    match answer:
        case Broken(str()):
            return answer
        case str(text):
            with contextlib.suppress(ValueError):
                found = Outcome.from_text(text)
                whose = found.result.student, found.result.assignment
                if whose == (job.student, job.assignment.name):
                    return found
    return Broken("sent back no result")


def grade_on_worker(code: str, sandbox_name: str, parcel: bytes) -> str | Broken | Unfit:
    """Run a submission's next pass and return what it came to, as a text; the worker's part.

    Args:
        code: digest of the coordinator's code; nothing is unpacked where ours differs.
        sandbox_name: where student code runs, here too.
        parcel: a task, the seed and the modules to preload, pickled.
    """
    if code != code_digest():
        return Unfit(OTHER_CODE)
    sandbox = Unsandboxed() if sandbox_name == UNSANDBOXED else BACK_ENDS[sandbox_name]
    problem = sandbox.problem()
    if problem is not None:
        fix = "see `autograder doctor` there, or choose another one for all with --sandbox"
        return Unfit(f"the sandbox {sandbox_name} does not work there ({problem}): {fix}")
    task, seed, preloaded = pickle.loads(parcel)
    ((_, answer),) = batch.processes(Terms(seed, sandbox, preloaded), [task], 1)
    return answer if isinstance(answer, Broken) else answer.as_text()
