"""Problems that several chapters return to."""

from __future__ import annotations

import numpy as np
from robust_slam.problems import LinearProblem, chain
from robust_slam_course.quiz import Question

READINGS = np.array([0.1, -0.2, 0.15, -0.1, 5.0])
"""Four inliers and an outlier of 5 m; the chapters give them a sigma of 0.3."""


def three_poses(*closures: float, sigma: float = 0.05, odometry: float = 0.1) -> LinearProblem:
    """The chain of chapter 00: two steps of 1 m, and closures of these lengths over both."""
    ends = [(0, 1), (1, 2)] + [(0, 2)] * len(closures)
    spread = [odometry] * 2 + list(np.broadcast_to(sigma, len(closures)))
    trusted = [True, True] + [False] * len(closures)
    return chain(3, *np.transpose(ends), [1.0, 1.0, *closures], spread, trusted=trusted)


def assert_right_options_are_hidden(questions: list[Question], ratio: float) -> set[int]:
    """Fail if a right option is longer than others by the ratio; return the right places."""
    places = set()
    for question in questions:
        right = [option.correct for option in question.options].index(True)
        lengths = [len(option.text) for option in question.options]
        assert lengths.pop(right) <= ratio * max(lengths), question.prompt
        places.add(right)
    return places
