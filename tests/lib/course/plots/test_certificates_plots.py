"""What is drawn of a certificate, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.certificates import (
    draw_climb,
    draw_gaps,
    draw_ring,
    draw_spectrum,
)


def test_eigenvalues_are_sorted_counted_and_told_apart_by_marker(ax) -> None:
    draw_spectrum(ax, [0.0, 3.0, -1.0, 5.0, 1e-9, -1e-9])
    above, at, below, _ = ax.lines
    np.testing.assert_array_equal(above.get_xydata(), [[1, 5], [2, 3]])
    assert list(at.get_xdata()) == [3, 4, 5]
    np.testing.assert_array_equal(below.get_xydata(), [[6, -1]])
    labels = [line.get_label() for line in (above, at, below)]
    assert labels == ["2 above 0", "3 at 0", "1 below 0"]
    assert above.get_marker() != below.get_marker()
    assert at.get_markerfacecolor() == "none"


@pytest.mark.parametrize(("values", "counted"), [([1e6, 2.0], 1), ([1e-6, 2e-7], 2)])
def test_a_nought_is_small_beside_the_largest(ax, values: list[float], counted: int) -> None:
    draw_spectrum(ax, values)
    assert ax.lines[0].get_label() == f"{counted} above 0"


def test_a_ring_says_by_how_much_each_measurement_is_missed(ax) -> None:
    draw_ring(ax, [0.0, np.pi / 2, np.pi], turn=np.pi / 6)
    said = [text.get_text() for text in ax.texts if text.get_text()]
    assert said == ["60°", "60°", "150°"]


def test_a_missing_of_nothing_has_no_sign_and_a_negative_one_a_minus(ax) -> None:
    draw_ring(ax, [0.0, -1e-9, np.radians(-40)], turn=0.0)
    said = [text.get_text() for text in ax.texts if text.get_text()]
    assert said == ["0°", "−40°", "40°"]


def test_an_arrow_points_where_the_pose_looks(ax) -> None:
    draw_ring(ax, [0.0, np.pi / 2], turn=0.0)
    first, second = [text for text in ax.texts if not text.get_text()]
    along, up = np.subtract(first.xy, first.xyann), np.subtract(second.xy, second.xyann)
    np.testing.assert_allclose(along / np.linalg.norm(along), [1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(up / np.linalg.norm(up), [0.0, 1.0], atol=1e-12)


def test_gaps_have_a_line_for_each_draw(ax) -> None:
    gaps = np.array([[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]])
    draw_gaps(ax, [0.1, 0.2, 0.3], gaps, ["A", "B"])
    a, b = ax.lines
    np.testing.assert_array_equal(a.get_ydata(), gaps[:, 0])
    np.testing.assert_array_equal(b.get_ydata(), gaps[:, 1])
    assert (a.get_label(), b.get_label()) == ("A", "B")
    assert a.get_marker() != b.get_marker()
    with pytest.raises(ValueError, match="gaps"):
        draw_gaps(ax, [0.1, 0.2], gaps, ["A", "B"])


def test_a_level_begins_where_the_one_before_it_ended(ax) -> None:
    draw_climb(ax, [[9.0], [9.0, 5.0, 4.0], [4.0, -1e-17]], ranks=(2, 3, 4))
    drawn = [line.get_xydata().tolist() for line in ax.lines[::2]]
    assert drawn == [[[0, 9]], [[0, 9], [1, 5], [2, 4]], [[2, 4], [3, -1e-17]]]
    said = [text.get_text() for text in ax.texts]
    assert said == ["rank 2: 9.00", "rank 3: 4.00", "rank 4: 0.00"]
    with pytest.raises(ValueError, match="ranks"):
        draw_climb(ax, [[9.0]], ranks=(2, 3))
