"""Robust estimation on pose graphs: the reference library of the Robust SLAM course.

Import the modules by name, as in ``from robust_slam import gnc, kernels``.

One loop, many rules: a weighted least-squares solve, whitened residuals at its solution,
new weights from a rule, and again.

- ``kernels``, ``thresholds``: what a residual costs, and from where on it is doubted
- ``loop``, ``result``: the loop, and what it gives back
- ``irls``, ``gnc``, ``switchable``, ``max_mixture``: the rules
- ``location``, ``linear``: problems small enough for a pencil

Pose graphs, in the plane and in space:

- ``se2``, ``se3``, ``group``: the two groups, and what they have in common
- ``pose_graph``: a graph as arrays, with residuals and derivatives
- ``generate``, ``datasets``, ``g2o``, ``gtsam_graph``: where graphs come from and go to
- ``outliers``: wrong closures, put in on purpose
- ``start``, ``gauss_newton``, ``levenberg_marquardt``: first poses, then the descent
- ``sparse``: the linear solves inside
- ``pcm``, ``clique``: closures that agree two by two
- ``distributed``, ``robot``: GNC by a few robots, each with its own part of the graph
- ``metrics``: how good a map is, and how good the choice of closures

Is it the best map there is?

- ``chordal``, ``riemannian_newton``: the quadratic form that certificates speak about
- ``certificate``, ``staircase``: the sparse test, and the way out of a local minimum
- ``sdp``: the same question as a small semidefinite program
- ``pipeline``: pcm -> gnc -> certify, in one function

For pages: ``plots``, ``style``, ``canvas``, ``quiz``.
"""

from __future__ import annotations
