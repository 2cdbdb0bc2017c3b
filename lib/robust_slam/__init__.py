"""Robust estimation on pose graphs: the reference library of the Robust SLAM course.

One loop, many rules: a weighted least-squares solve, whitened residuals at its
solution, new weights from a rule, and again (``loop``). Import the modules by
name: ``from robust_slam import irls, kernels``.
"""

from __future__ import annotations
