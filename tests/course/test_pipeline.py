"""The pipeline of chapter 8 records what each of its stages did."""

import numpy as np
from robust_slam.certificates import Verdict
from robust_slam.estimators import chi_square_threshold
from robust_slam.graphs import add_random_closures, manhattan
from robust_slam.graphs.outliers import add_grouped_closures
from robust_slam.graphs.pose_graph import residual_norms
from robust_slam_course.pipeline import solve


def test_closures_that_pcm_rejects_return_where_they_fit_the_map():
    """In this town the odometry is off, and every fourth inlier contradicts the others."""
    clean, truth = manhattan(300, 0, closures=100)
    for add, count in ((add_random_closures, 100), (add_grouped_closures, 10)):
        graph, is_outlier = add(clean, count, 1, poses=truth)
        inliers = ~graph.is_odometry & ~is_outlier
        answer = solve(graph)
        assert np.sum(inliers & ~answer.consistency.kept) > 20
        assert np.sum(inliers & ~answer.kept) <= 2
        assert not np.any(answer.kept & is_outlier)
        assert answer.certificate.verdict is Verdict.CERTIFIED
        before = answer.consistency.kept.copy()
        before[before] = answer.result.kept
        np.testing.assert_array_equal(answer.returned, np.flatnonzero(answer.kept & ~before))
        near = residual_norms(graph, answer.poses) < 0.9 * chi_square_threshold(0.99, 3)
        assert np.all(answer.kept[near])
