"""A canvas: one picture under a few native controls, live with a kernel and without one.

``Canvas`` is the whole of it for a chapter; the controls say which states there are.
``page`` writes the static group that works on any page, ``live`` the widgets of a kernel.
"""

from __future__ import annotations

from robust_slam_course.canvas.canvas import Canvas
from robust_slam_course.canvas.controls import Checkbox, Choice, Slider, Stepper

__all__ = ["Canvas", "Checkbox", "Choice", "Slider", "Stepper"]
