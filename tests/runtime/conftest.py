"""Fixtures of these tests."""

from tests.runtime.made import made_runtime

__all__ = ["made_runtime"]
