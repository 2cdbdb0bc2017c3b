"""Grades nbgrader notebooks that it does not trust.

Tests run in one process, student code in another; only plain data crosses
between them. ``cli`` is the door, ``grading`` the heart, ``sandbox`` the wall.
"""

import sys

if sys.platform == "win32":
    raise ImportError(
        "robust-slam-autograder runs on Linux and macOS: "
        "on Windows use WSL, or the notebook's own Validate button."
    )
