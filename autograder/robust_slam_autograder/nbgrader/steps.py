"""nbgrader's autograde and feedback with this package's executor, by nbgrader's own settings.

``settings.nbgrader_settings`` puts these classes in place of nbgrader's. Student code never runs
in a kernel or in nbgrader's process, and nbgrader opens no notebook that was handed in: the
exporter gives it the one that shows the result.
"""

import glob
import os
from pathlib import Path
from typing import Any

from nbconvert.exporters import NotebookExporter
from nbformat.notebooknode import NotebookNode
from nbgrader.converters.base import NbGraderException
from nbgrader.preprocessors import NbGraderPreprocessor
from traitlets import Bool, Enum, Unicode

from robust_slam_autograder import layout
from robust_slam_autograder.errors import AutograderError, GraderFailure
from robust_slam_autograder.grading import batch, exposed_folders, journal, submissions
from robust_slam_autograder.grading.batch import How
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.nbgrader import gradebook, graded_notebook, own_files
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.assignment import BEGIN_HIDDEN, split_hidden
from robust_slam_autograder.reading.submission import is_student
from robust_slam_autograder.sandbox import BACK_ENDS, choose

Resources = dict[str, Any]


class SafeExporter(NotebookExporter):
    """Grades submissions as ``autograder grade`` does, in place of converting what is in them.

    It makes sure first of all that one can be graded at all.
    """

    results_directory = Unicode(
        str(layout.GRADED),
        help="Where results and the batch's seed are kept, from the course's root.",
    ).tag(config=True)
    sandbox = Enum(
        ["", *BACK_ENDS],
        default_value="",
        help="The sandbox to take; the first that works where empty.",
    ).tag(config=True)
    unsandboxed = Bool(False, help="Trust the submissions: run them without a sandbox.").tag(
        config=True
    )

    def __init__(self, **options: Any) -> None:  # noqa: ANN401
        super().__init__(**options)  # type: ignore[no-untyped-call]
        self._course = self._converter.coursedir
        self._results = Path(self._course.root) / self.results_directory
        self._naming = tables.namer(Path(self._course.root) / layout.MISCONCEPTIONS)
        try:
            self._prepare()
        except AutograderError as error:
            self.log.error("%s", error)
            raise NbGraderException(str(error)) from error

    @property
    def _converter(self) -> Any:  # noqa: ANN401
        return self.parent

    def _prepare(self) -> None:
        # nbgrader makes its exporter when it has listed the submissions and read none of them.
        course = self._course
        source = Path(course.format_path(course.source_directory, ".", course.assignment_id))
        self._sandbox = choose(self.sandbox or None, unsandboxed=self.unsandboxed)
        self._assignment = assignments.load(assignments.notebook_path(source))
        folders = [source, Path(course.root) / course.submitted_directory, self._results]
        labels = Path(course.root) / layout.MISCONCEPTIONS
        folders += [labels] if labels.is_dir() else []
        exposed_folders.refuse_unsafe([self._assignment], folders, self._sandbox)
        with batch.locked(self._results):
            gradebook.declare(course.db_url, self._assignment)
        self._converter.assignments = self._submissions()

    def _submissions(self) -> dict[str, list[str]]:
        """List each submission's folder with its notebook, be that missing or misnamed."""
        course = self._course
        pattern = course.format_path(
            course.submitted_directory, course.student_id, course.assignment_id
        )
        folders = [path for path in glob.glob(pattern) if os.path.isdir(path)]
        plain = [path for path in folders if is_student(Path(path).parent.name)]
        for path in sorted(set(folders) - set(plain)):
            self.log.error("%r names no student: name its folder anew.", path)
        return {path: [f"{path}/{self._assignment.notebook}.ipynb"] for path in plain}

    def from_filename(
        self,
        filename: str,
        resources: Resources | None = None,
        **options: Any,  # noqa: ANN401
    ) -> tuple[Any, Resources]:
        """Grade a submission, record its marks and make the notebook that shows it.

        What nbgrader converts once more is the graded notebook that was made before.
        """
        resources = resources or {}
        student = resources["nbgrader"]["student"]
        if Path(filename).parent == self._folder(self._course.autograded_directory, student):
            return super().from_filename(filename, resources, **options)
        folder = self._folder(self._course.submitted_directory, student)
        job = Submission(student, self._assignment, folder)
        job = submissions.read(job)  # all that follows is of the same bytes
        try:
            made = self._grade(job)
        except AutograderError as error:
            self.log.error("%s", error)
            raise
        resources["outputs"] = own_files.plain(job.path)
        converted: tuple[Any, Resources] = self.from_notebook_node(  # type: ignore[no-untyped-call]
            made, resources, **options
        )
        return converted

    def _grade(self, job: Submission) -> NotebookNode:
        """Grade in a process of its own; a result that is there already and holds is taken over.

        Raises:
            WrongUse: another batch is at work on the same results.
            GraderFailure: the grader itself failed.
        """
        with batch.locked(self._results):
            run = journal.open_journal(self._results, None)
            (graded,) = batch.grade([job], run, How(self._sandbox, self._naming))
            result = graded.load()
            if result.status == "failed":
                raise GraderFailure(result.reason)
            gradebook.record(self._course.db_url, [job.assignment], [result], run.graded)
        if result.status == "refused":
            self.log.warning("Refused, score 0: %s", result.reason)
        return graded_notebook.build(job, result)

    def _folder(self, step: str, student: str) -> Path:
        return Path(self._course.format_path(step, student, self._assignment.name))


class HideTests(NbGraderPreprocessor):  # type: ignore[misc]
    """Cuts hidden tests from feedback, should plain nbgrader have made the graded notebook."""

    def preprocess_cell(
        self, cell: NotebookNode, resources: Resources, index: int
    ) -> tuple[NotebookNode, Resources]:
        """Cut the hidden region, and the output, which may quote it."""
        marks = cell.metadata.get("nbgrader", {})
        if BEGIN_HIDDEN in cell.source and marks.get("grade") and not marks.get("solution"):
            cell.source, _ = split_hidden(cell.source, marks.get("grade_id", ""))
            cell.outputs = []
        return cell, resources
