"""What drawn shares show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.robustness import draw_shares

KINDS, RATES = ["random", "local"], ["10", "50", "90"]
SHARES = {
    "bold": [[1.0, 0.25, 0.0], [1.0, 1.0, 1.0]],
    "shy": [[0.5, 0.5, 0.5], [np.nan, 0.0, np.nan]],
}


@pytest.fixture
def shares(ax):
    return draw_shares(ax, KINDS, RATES, SHARES)


def test_the_area_of_a_disc_is_the_share_of_its_ring(shares) -> None:
    pairs = zip(shares.collections[::2], shares.collections[1::2], SHARES.values(), strict=True)
    for rings, discs, values in pairs:
        run = np.ravel(values)[np.isfinite(np.ravel(values))]
        assert (discs.get_widths() / rings.get_widths()) ** 2 == pytest.approx(run)
        assert np.array_equal(rings.get_offsets(), discs.get_offsets())


def test_what_was_not_run_has_no_ring(shares) -> None:
    bold, shy = shares.collections[0].get_offsets(), shares.collections[2].get_offsets()
    assert len(bold) == 6
    assert shy[:, 0].tolist() == bold[[0, 1, 2, 4], 0].tolist()


def test_rows_are_methods_and_columns_kinds_and_rates(shares) -> None:
    assert [label.get_text() for label in shares.get_yticklabels()] == list(SHARES)
    assert [label.get_text() for label in shares.get_xticklabels()] == RATES * 2
    assert [text.get_text() for text in shares.texts] == KINDS
    assert np.all(shares.collections[0].get_offsets()[:, 1] == 0)
    assert np.all(shares.collections[2].get_offsets()[:, 1] == 1)
    assert np.all(np.diff(shares.get_xticks()) == [1, 1, 2, 1, 1])


@pytest.mark.parametrize(
    ("values", "what"), [([[1.0, 1.0, 1.0]], "shape"), ([[0, 0, 0], [0, 0, 1.5]], "from 0 to 1")]
)
def test_shares_that_do_not_fit_are_refused(ax, values: list[list[float]], what: str) -> None:
    with pytest.raises(ValueError, match=what):
        draw_shares(ax, KINDS, RATES, {"odd": values})
