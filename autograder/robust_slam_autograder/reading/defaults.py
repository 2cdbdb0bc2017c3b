"""What holds where an assignment's ``autograder.toml`` does not say."""

from dataclasses import dataclass

DEFAULT_PACKAGES = ("numpy", "scipy", "matplotlib")
"""Packages that student code may import beside the standard library."""


@dataclass(frozen=True)
class Limits:
    """CPU seconds of the student's code and the tests together; see ``executor.budget``."""

    call_seconds: float = 10.0
    """One call of a student's function."""
    cell_seconds: float = 20.0
    """One cell, the student's or a test."""
    notebook_seconds: float = 120.0
    """All of one submission's passes together."""
