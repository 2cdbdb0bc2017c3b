"""The pictures of assignment 01 draw what a student's functions return, beside the truth."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.exercises import m_estimators


def influence(rho, u):
    return (rho(u + 1e-5) - rho(u - 1e-5)) / 2e-5


def weight(psi, u):
    safe = np.where(u == 0, 1.0, u)
    return np.where(u == 0, 1.0, psi(safe) / safe)


def location(z, sigma, weight, x0, tol):
    x, previous = x0, np.inf
    while abs(x - previous) > tol:
        share = weight((z - x) / sigma)
        previous, x = x, share @ z / np.sum(share)
    return x


def classify(psi):
    near, far = psi(np.array([1e7, 1e8]))
    if far <= near / 2:
        return "redescending"
    return "unbounded" if far >= 2 * near else "bounded"


CURVES = [influence, weight, location]


@pytest.mark.parametrize("student", CURVES, ids=lambda student: student.__name__)
def test_a_right_answer_lies_on_the_truth(student):
    figure = getattr(m_estimators, student.__name__)(student)
    figure.draw_without_rendering()
    assert [ax.get_title() for ax in figure.axes] == ["squared", "Huber", "Cauchy"]
    for ax in figure.axes:
        truth, yours = ax.lines
        assert (truth.get_label(), yours.get_label()) == ("the truth", "yours")
        np.testing.assert_allclose(yours.get_ydata(), truth.get_ydata(), atol=1e-5)


def test_a_wrong_curve_leaves_the_truth_and_stays_in_the_picture():
    figure = m_estimators.influence(lambda rho, u: rho(u + 1) - rho(u))
    for ax in figure.axes:
        truth, yours = (np.asarray(line.get_ydata()) for line in ax.lines)
        assert np.max(np.abs(yours - truth)) > 0.1


def test_each_word_is_judged():
    def titles(student):
        return [ax.get_title() for ax in m_estimators.classify(student).axes]

    figure = m_estimators.classify(classify)
    figure.draw_without_rendering()
    assert all("\n✓ " in title for title in titles(classify))
    assert titles(lambda psi: "bounded") == [
        "squared\n✗ not bounded",
        "Huber\n✓ bounded",
        "Cauchy\n✗ not bounded",
        "Geman–McClure\n✗ not bounded",
        "Welsch\n✗ not bounded",
        "TLS\n✗ not bounded",
    ]
