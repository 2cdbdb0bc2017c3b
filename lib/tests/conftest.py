"""What every test of the library may ask for: both groups, three seeds, and GTSAM."""

import importlib.util
import warnings

import pytest

from .worlds import GROUPS, leave_out


@pytest.fixture(params=GROUPS.values(), ids=GROUPS)
def group(request):
    """SE(2), then SE(3)."""
    return request.param


@pytest.fixture(params=range(3))
def seed(request):
    """Another seed each time; a test that needs more of them is parametrised itself."""
    return request.param


@pytest.fixture(autouse=True)
def _no_warning_escapes():
    """A warning of NumPy or SciPy that a user would see is an error in each test."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        yield


@pytest.fixture(name="gtsam")
def gtsam_itself():
    """The package gtsam, which has wheels for some machines alone."""
    if importlib.util.find_spec("gtsam") is None:
        leave_out("gtsam is not installed; nothing is compared with it")
    import gtsam

    return gtsam
