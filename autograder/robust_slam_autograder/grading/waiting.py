"""Submissions that wait for their next pass: on the disk, so that few are in memory.

Each is kept with the bytes that were read, and with what its visible pass came to. A batch that
was stopped takes that over: the text that a student sees is the one that was made first.
"""

from __future__ import annotations

import base64
import hashlib
import json
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path

from robust_slam_autograder.grading import durable, marked
from robust_slam_autograder.grading.tasks import Handed, Job, Task

_PRIVATE = 0o600


@dataclass(frozen=True)
class Waiting:
    """The folder that keeps them."""

    folder: Path

    def put(self, task: Task) -> None:
        """Keep a task.

        Raises:
            GraderFailure: it cannot be written.
        """
        data = base64.b64encode(task.handed.data).decode("ascii")
        value = {
            "fingerprint": task.fingerprint,
            "handed": {**asdict(task.handed), "data": data},
            "seen": None if task.seen is None else marked.as_text(task.seen),
            "town": task.town,
        }
        durable.write(self._path(task.job), json.dumps(value), mode=_PRIVATE)

    def get(self, job: Job) -> Task:
        """Take back a submission's task.

        Raises:
            OSError: none is kept.
            ValueError: what is there is none.
        """
        try:
            value = json.loads(self._path(job).read_text(encoding="utf-8"))
            handed = value["handed"]
            data, notes = base64.b64decode(handed["data"]), tuple(handed["notes"])
            seen = None if value["seen"] is None else marked.from_text(value["seen"])
            kept = Handed(**{**handed, "data": data, "notes": notes})
            return Task(job, kept, value["fingerprint"], seen, value["town"])
        except (KeyError, TypeError, RecursionError) as error:
            raise ValueError(f"{self._path(job)} keeps no submission") from error

    def seen(self, task: Task) -> bool:
        """Tell whether the same submission is kept with its visible pass."""
        try:
            kept = self.get(task.job)
        except (OSError, ValueError):
            return False
        return kept.seen is not None and kept.fingerprint == task.fingerprint

    def remove(self) -> None:
        """Forget all."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _path(self, job: Job) -> Path:
        return self.folder / f"{hashlib.sha256(job.key.encode()).hexdigest()}.json"
