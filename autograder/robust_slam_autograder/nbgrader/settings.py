"""nbgrader's settings for a course: its folders, and this package in place of its own steps."""

import glob
from pathlib import Path

from nbgrader.coursedir import CourseDirectory
from traitlets.config import Config

from robust_slam_autograder import layout
from robust_slam_autograder.nbgrader import database

STUB = 'raise NotImplementedError("Exercise: write this function, then delete this line.")'
_STEPS = "robust_slam_autograder.nbgrader.steps"


def nbgrader_settings(root: str) -> Config:
    """Return nbgrader's settings for a course whose sources are in ``<root>/solutions``."""
    config = Config()
    config.CourseDirectory.root = str(Path(root).resolve())
    config.CourseDirectory.source_directory = "solutions"
    config.CourseDirectory.release_directory = "build/release"
    config.CourseDirectory.submitted_directory = str(layout.SUBMITTED)
    config.CourseDirectory.autograded_directory = str(layout.AUTOGRADED)
    config.CourseDirectory.feedback_directory = str(layout.FEEDBACK)
    graded = Path(root).resolve() / layout.GRADED
    url = database.chosen(graded)
    config.CourseDirectory.db_url = url.render_as_string(hide_password=False)
    config.SafeExporter.results_directory = str(graded)
    config.ClearSolutions.code_stub = {"python": STUB}
    _put_executor(config)
    return config


def _put_executor(config: Config) -> None:
    """Have nbgrader grade with this package, and show nothing hidden and nothing that acts."""
    course = config.CourseDirectory
    submissions = glob.escape(f"{course.root}/{course.submitted_directory}") + "/*/*/"
    # What else a student hands in, be it a link to a file of the instructor's, is never copied.
    course.ignore = [*CourseDirectory().ignore, f"{submissions}*", f"{submissions}.*"]
    config.Autograde.exporter_class = f"{_STEPS}.SafeExporter"
    config.Autograde.sanitize_preprocessors = []
    config.Autograde.autograde_preprocessors = ["nbgrader.preprocessors.AssignLatePenalties"]
    config.GenerateFeedback.preprocessors = [
        f"{_STEPS}.HideTests",
        "nbgrader.preprocessors.GetGrades",
        "nbconvert.preprocessors.CSSHTMLHeaderPreprocessor",
    ]
    config.ExportApp.plugin_class = "robust_slam_autograder.nbgrader.spreadsheet.SafeCsv"
    filters = "robust_slam_autograder.nbgrader.safe_markdown"
    config.HTMLExporter.filters = {
        "markdown2html": f"{filters}.as_html",
        "highlight_code": f"{filters}.code_as_html",
        "strip_files_prefix": f"{filters}.unchanged",
    }
