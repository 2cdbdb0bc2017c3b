"""What a drawn map shows, read back from the axes."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from robust_slam.drawing import decision_legend, draw_map, legend_below, map_legend
from robust_slam.graphs.generate import circle, sphere
from robust_slam.palette import PALETTE

from .worlds import with_outliers


@pytest.fixture
def ax():
    return Figure().subplots()


def town():
    return with_outliers(circle, 20, 5, 2, laps=2, closures=4)[:3]


def ends_drawn(ax, colour: str) -> set[tuple[float, ...]]:
    """Return the segments of all lines in a colour, each as (x, y, x, y)."""
    segments = set()
    for line in ax.lines:
        if to_hex(line.get_color()) == colour.lower() and line.get_linestyle() != "None":
            for a, b in pairwise(np.column_stack(line.get_data())):
                if np.all(np.isfinite([a, b])):
                    segments.add(tuple(np.round([*a, *b], 9)))
    return segments


def ends_of(places: np.ndarray, edges: np.ndarray) -> set[tuple[float, ...]]:
    """Return the segments of some edges between places (n, 2), each as (x, y, x, y)."""
    return {tuple(np.round(row, 9)) for row in places[edges].reshape(-1, 4)}


def named(ax) -> dict[str, Line2D]:
    """The lines that the legend names, without their counts."""
    shown = (line for line in ax.lines if not line.get_label().startswith("_"))
    return {line.get_label().partition(" (")[0]: line for line in shown}


def words_below(ax) -> set[str]:
    return {text.get_text() for text in legend_below(ax).get_texts()}


def test_every_edge_is_drawn_once_in_the_colour_of_its_kind(ax):
    graph, wrong, truth = town()
    draw_map(graph, truth, ax, is_outlier=wrong)
    inliers = ~graph.is_odometry & ~wrong
    kinds = {"estimate": graph.is_odometry, "inlier": inliers, "outlier": wrong}
    for colour, chosen in kinds.items():
        assert ends_drawn(ax, PALETTE[colour]) == ends_of(truth[:, :2], graph.edges[chosen])


def test_a_map_has_one_scale_the_truth_is_dotted_and_the_legend_shows_each_kind(ax):
    graph, wrong, truth = town()
    assert draw_map(graph, truth, ax, is_outlier=wrong, truth=truth) is ax
    assert ax.get_aspect() == 1.0
    assert [line.get_linestyle() for line in ax.lines].count(":") == 1
    drawn = {(line.get_color(), line.get_linestyle()) for line in ax.lines}
    assert {(h.get_color(), h.get_linestyle()) for h in map_legend()} <= drawn


def test_a_smaller_weight_is_fainter_and_zero_is_still_seen(ax):
    graph, wrong, truth = town()
    weights = np.where(wrong, 0.0, 1.0)
    draw_map(graph, truth, ax, is_outlier=wrong, weights=weights)
    alphas = {to_hex(line.get_color()): line.get_alpha() for line in ax.lines}
    assert 0.0 < alphas[PALETTE["outlier"].lower()] < 0.3
    assert alphas[PALETTE["inlier"].lower()] == 1.0


def decisions():
    """A map with one mistake of each kind, and the words for every edge."""
    graph, wrong, truth = town()
    kept = ~wrong
    kept[np.flatnonzero(wrong)[0]] = True
    kept[np.flatnonzero(~graph.is_odometry)[0]] = False
    words = np.where(
        graph.is_odometry,
        "odometry",
        np.char.add(np.where(wrong, "outlier, ", "inlier, "), np.where(kept, "kept", "rejected")),
    )
    return graph, wrong, truth, kept, words


@pytest.fixture
def judged(ax):
    graph, wrong, truth, kept, _ = decisions()
    return draw_map(graph, truth, ax, is_outlier=wrong, kept=kept)


def test_decisions_are_counted_in_the_legend_and_have_looks_of_their_own_without_colour(judged):
    names, counts = np.unique(decisions()[-1], return_counts=True)
    assert len(names) == 5
    counted = zip(names, counts, strict=True)
    assert words_below(judged) == {f"{name} ({count})" for name, count in counted}
    looks = {
        (str(line._unscaled_dash_pattern), line.get_linewidth(), line.get_marker())
        for line in named(judged).values()
    }
    assert len(looks) == len(named(judged)) == 5


def test_a_wrong_decision_has_a_marker_at_the_middle_of_its_edge(judged):
    graph, _, truth, _, words = decisions()
    for word, line in named(judged).items():
        if word in ("outlier, kept", "inlier, rejected"):
            marked = np.column_stack(line.get_data())[line.get_markevery()]
            middles = truth[graph.edges[words == word]][:, :, :2].mean(axis=1)
            np.testing.assert_allclose(marked, middles)
        else:
            assert line.get_marker() == "None"


def test_the_legend_of_decisions_names_every_look_that_a_map_draws(ax):
    graph, wrong, truth, kept, _ = decisions()
    draw_map(graph, truth, ax, is_outlier=wrong, kept=kept, truth=truth)
    drawn = {word: (line.get_color(), line.get_linestyle()) for word, line in named(ax).items()}
    drawn["estimated path"] = drawn.pop("odometry")  # which is not counted here
    assert {h.get_label(): (h.get_color(), h.get_linestyle()) for h in decision_legend()} == drawn


def test_without_the_truth_closures_are_kept_or_rejected(ax):
    graph, _, truth, kept, _ = decisions()
    draw_map(graph, truth, ax, kept=kept)
    words = {word.partition(" (")[0] for word in words_below(ax)}
    assert words == {"odometry", "kept", "rejected"}


def test_a_map_in_space_is_seen_from_above(ax):
    graph, truth = sphere(40, np.random.default_rng(6))
    draw_map(graph, truth, ax, truth=truth)
    odometry = ends_of(truth[:, :2, 3], graph.edges[graph.is_odometry])
    assert ends_drawn(ax, PALETTE["estimate"]) == odometry


def test_any_number_of_weights_makes_few_lines_and_loses_no_edge(ax):
    rng = np.random.default_rng(7)
    graph, truth = circle(1000, rng, laps=2, closures=400)
    weights = rng.random(len(graph.edges))
    draw_map(graph, truth, ax, weights=weights)
    assert len(ax.lines) <= 2 * 256 + 1
    drawn = ends_drawn(ax, PALETTE["estimate"]) | ends_drawn(ax, PALETTE["inlier"])
    assert drawn == ends_of(truth[:, :2], graph.edges)


@pytest.mark.parametrize("name", ["poses", "truth", "weights", "is_outlier"])
def test_an_array_of_the_wrong_length_is_named(ax, name):
    graph, _, truth = town()
    arguments = {"poses": truth, name: np.zeros((3, 3))}
    with pytest.raises(ValueError, match=rf"{name}: the shape is \(3, 3\); give "):
        draw_map(graph, ax=ax, **arguments)
