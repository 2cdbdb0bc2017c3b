"""What is particular to SE(3): screws, and the order of a tangent vector."""

from __future__ import annotations

import numpy as np
from robust_slam.graphs import se3

from tests.lib.worlds import random_twists


def test_the_exponential_is_the_series_of_the_matrix():
    for xi in random_twists(se3, 20, np.random.default_rng(1)):
        generator = np.zeros((4, 4))
        x, y, z = xi[3:]
        generator[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        generator[:3, 3] = xi[:3]
        term, total = np.eye(4), np.eye(4)
        for k in range(1, 40):
            term = term @ generator / k
            total = total + term
        np.testing.assert_allclose(se3.exp(xi), total[:3], atol=1e-12)
