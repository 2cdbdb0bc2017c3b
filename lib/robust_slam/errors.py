"""The errors of solvers: the problem has no unique solution, or none was found."""

from __future__ import annotations


class Underdetermined(ValueError):
    """The measurements with positive weight do not determine x."""


class NotConverged(RuntimeError):
    """An iteration did not converge within its limit."""
