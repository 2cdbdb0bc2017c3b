"""All assignments as students get them, made once."""

import pytest
from robust_slam_autograder.publishing.student_release import release

from solutions.classes import answers


@pytest.fixture(scope="session")
def released(tmp_path_factory):
    """Return the folder of a release of all assignments."""
    folder = tmp_path_factory.mktemp("released")
    release(answers.SOLUTIONS, [], folder)
    return folder
