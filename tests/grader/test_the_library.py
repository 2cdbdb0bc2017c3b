"""What the sandbox shows of the course's own library, a package in its source folder."""

import importlib.metadata
from pathlib import Path

import pytest
from robust_slam_autograder.reading.defaults import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import packages

from autograder.tests.sandbox.probing import run
from autograder.tests.sandbox.test_view import SITE, names_shown, shown


def test_extras_are_not_followed():
    """The library solves with cvxpy and compares with gtsam where they are there."""
    assert "cvxpy" in names_shown("cvxpy")
    found = packages.find((*DEFAULT_PACKAGES, "robust_slam"))
    others = {"cvxpy", "evo", "networkx", "nbgrader", "pytest"}
    assert all((SITE / other).exists() for other in others)
    others.add("gtsam")  # not there for every Python
    assert "robust_slam" in found.names and not others & {*found.names}


def test_a_package_in_its_source_folder_is_shown_without_its_surroundings():
    visible = shown(("robust_slam",))
    import robust_slam

    folder = Path(robust_slam.__file__).parent
    assert folder in visible and folder.parent not in visible


ALLOWED = """
import importlib.metadata, zoneinfo
import qdldl, scipy.stats, tqdm.auto
import robust_slam.graphs.se2

def versions():
    names = ("numpy", "robust_slam", "tqdm")
    return [importlib.metadata.version(name) for name in names]
"""


@pytest.mark.sandbox
def test_allowed_packages_can_be_imported(wall):
    """None of these is in memory already, some lie in one file and one in its source folder."""
    allowed = (*DEFAULT_PACKAGES, "qdldl", "robust_slam")
    found = run(wall, "versions", ALLOWED, packages=allowed)
    assert found == [importlib.metadata.version(name) for name in ("numpy", "robust_slam", "tqdm")]
