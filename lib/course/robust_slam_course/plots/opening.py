"""Draw the course's picture: a map without an outlier, with it, and with a robust kernel."""

from dataclasses import dataclass

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam._arrays import Array, Mask
from robust_slam.drawing import draw_map, map_legend
from robust_slam.estimators import kernels
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem


@dataclass(frozen=True)
class Town:
    """A walk through a town and three maps of it, poses (n, 3) in m, m, rad.

    `graph` has one wrong closure, marked in `is_outlier` (m,). `before` is least squares
    without it, `folded` least squares with it, `robust` the map by Cauchy's kernel, whose
    weights (m,) are `weights`.
    """

    graph: PoseGraph
    is_outlier: Mask
    truth: Array
    before: Array
    folded: Array
    robust: Array
    weights: Array


def town(seed: int = 2) -> Town:
    """Return the walk of chapter 0 and its three maps; the seed draws the walk and the outlier."""
    rng = np.random.default_rng(seed)
    correct, truth = manhattan(100, rng, side=9, turn=0.25, closures=12)
    graph, is_outlier = add_random_closures(correct, 1, rng, poses=truth)
    return three_maps(correct, graph, is_outlier, truth)


def three_maps(correct: PoseGraph, graph: PoseGraph, is_outlier: Mask, truth: Array) -> Town:
    """Return the maps of ``correct`` and of ``graph``, which has outliers too."""
    problem = PoseGraphProblem(graph)
    robust = irls(problem, kernels.cauchy(1.0), tol=1e-6, max_iterations=300)
    return Town(
        graph=graph,
        is_outlier=is_outlier,
        truth=truth,
        before=PoseGraphProblem(correct).initial(),
        folded=problem.initial(),
        robust=robust.x,
        weights=robust.weights,
    )


def draw_opening(scene: Town) -> Figure:
    """Return the picture with its three panels."""
    figure, axes = plt.subplots(1, 3, figsize=(6.0, 2.8), sharex=True, sharey=True)
    panels = (
        ("without the outlier", scene.before, None),
        ("least squares", scene.folded, None),
        ("robust kernel", scene.robust, scene.weights),
    )
    for ax, (title, poses, weights) in zip(axes, panels, strict=True):
        draw_map(
            scene.graph, poses, ax, is_outlier=scene.is_outlier, weights=weights, truth=scene.truth
        )
        ax.set_title(title)
    figure.legend(handles=map_legend(), loc="outside lower center", ncols=2)
    return figure
