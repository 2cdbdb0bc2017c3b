"""The examples in the docstrings of the library run and print what they say."""

from __future__ import annotations

import doctest
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

LIB = Path(__file__).resolve().parents[2] / "lib" / "robust_slam"
CENTRAL = {
    "estimators.reweighting": {"irls"},
    "estimators.graduation": {"gnc"},
    "estimators.kernels": {"cauchy"},
    "estimators.thresholds": {"chi_square_threshold"},
    "estimators.switches": {"switchable", "dcs_switch"},
    "estimators.mixtures": {"max_mixture"},
    "graphs.pose_graph": {"PoseGraph"},
    "graphs.generate": {"circle", "manhattan"},
    "graphs.reading": {"read"},
    "graphs.odometry": {"dead_reckoning", "spanning_tree"},
    "graphs.outliers": {"add_random_closures"},
    "graphs.metrics": {"ate", "precision_recall"},
    "descent.undamped": {"gauss_newton"},
    "descent.damped": {"levenberg_marquardt"},
    "consistency.pairwise": {"pcm"},
    "consistency.cliques": {"max_clique"},
    "certificates.optimality": {"certify"},
    "solver": {"solve"},
    "fleet.rounds": {"solve"},
}
"""The functions and classes of each module that must have an example."""
WITH_EXAMPLES = sorted(
    ".".join(path.relative_to(LIB).with_suffix("").parts)
    for path in LIB.rglob("*.py")
    if ">>>" in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_the_examples_print_what_they_say(module: str) -> None:
    with np.printoptions(suppress=False, precision=8):  # a chapter may have set others
        result = doctest.testmod(import_module(f"robust_slam.{module}"))
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.parametrize("module", CENTRAL)
def test_every_central_function_has_an_example(module: str) -> None:
    found = import_module(f"robust_slam.{module}")
    tests = doctest.DocTestFinder().find(found)
    with_examples = {
        test.name.removeprefix(f"{found.__name__}.") for test in tests if test.examples
    }
    assert with_examples >= CENTRAL[module]
