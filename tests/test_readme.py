"""What the README shows runs as it stands there."""

import re
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from robust_slam.certificates.optimality import Verdict
from robust_slam.graphs import datasets

from autograder.tests.kernel import leave_out

README = (Path(__file__).resolve().parents[1] / "README.md").read_text(encoding="utf-8")


@pytest.fixture
def tour():
    (text,) = re.findall(r"```python\n(.*?)```", README, re.S)
    try:
        datasets.find("intel")
    except datasets.DatasetMissing as missing:
        leave_out(str(missing))
    return text


def taken(tour: str) -> dict[str, Any]:
    """Return what the names of the tour stand for after it."""
    names: dict[str, Any] = {}
    with mpl.rc_context({"backend": "agg"}):
        exec(tour, names)
        plt.close("all")
    return names


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in (0, *range(2, 10)))]
)
@pytest.mark.long
def test_the_tour_rejects_every_outlier_and_ends_certified(tour, seed):
    """It solves Intel, a public graph, with 100 outliers from several starts."""
    end = taken(tour.replace("default_rng(1)", f"default_rng({seed})"))
    answer, is_outlier = end["answer"], end["is_outlier"]
    assert not np.any(answer.kept[is_outlier])
    assert np.mean(answer.kept[~is_outlier]) > 0.99
    assert answer.certificate.verdict is Verdict.CERTIFIED


@pytest.mark.long
@pytest.mark.rest
def test_small_outliers_are_rejected_with_the_noise_that_is_found_alone(tour):
    """It solves Intel with 100 outliers twice: with the noise found and without."""
    local = tour.replace("add_random_closures", "add_local_closures")
    for code, kept in ((local, 0), (local.replace("(spoiled)", "(spoiled, find_noise=False)"), 4)):
        end = taken(code)
        answer, is_outlier = end["answer"], end["is_outlier"]
        assert np.count_nonzero(is_outlier) == 100
        assert np.count_nonzero(answer.kept[is_outlier]) == kept
        assert answer.certificate.verdict is Verdict.CERTIFIED
