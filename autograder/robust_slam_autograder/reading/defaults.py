"""What holds where an assignment's ``autograder.toml`` does not say."""

from __future__ import annotations

DEFAULT_PACKAGES = ("numpy", "scipy", "matplotlib")
"""Packages that student code may import beside the standard library."""
