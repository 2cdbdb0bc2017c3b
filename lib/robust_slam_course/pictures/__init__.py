"""The live pictures of the course: each function returns one for a page or a notebook."""

from __future__ import annotations

from robust_slam_course.pictures.maps import opening

__all__ = ["opening"]
