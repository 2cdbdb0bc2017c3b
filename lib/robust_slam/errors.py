"""The errors that solvers raise when the problem, not its input's form, is at fault."""

from __future__ import annotations


class Underdetermined(ValueError):
    """The measurements with positive weight do not determine x."""


class NotConverged(RuntimeError):
    """A descent has not come to rest within its iterations."""
