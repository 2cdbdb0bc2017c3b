"""Each number that a page says is what the page computes, and readers may change its data."""

import pytest
from robust_slam_course.text import CHANGED, check_text

from tests.book.conftest import NOTEBOOKS
from tests.book.numbers import check
from tests.book.prose import Chapter
from tests.book.samples import assert_right_options_are_hidden

pytestmark = pytest.mark.long

PAGES = [page.rpartition("/")[2] for page in NOTEBOOKS]


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")  # the tolerance is enough
@pytest.mark.parametrize("name", PAGES)
def test_a_page_says_what_it_computes(name, site):
    """The numbers are those of the run that the built page shows."""
    assert CHANGED not in site.parsed(f"chapters/{name}").get_text()
    assert not check.complaints(name, Chapter(name).text, check.computed(name))


def test_a_wrong_number_and_changed_data_name_their_sentences():
    name, text = "02-four-costs", Chapter("02-four-costs").text
    rows = check.computed(name)
    found = check.complaints(name, text.replace("2.005", "2.015"), rows)
    assert [line[:13] for line in found] == ["2.015 has no ", "not on the pa"]
    found = check.complaints(name, text.replace("2.005", "2.204"), rows)
    assert found == ["not on the page: '2.005'"]
    other = check.computed(name, {"door = np.array([2.03, 1.97": "door = np.array([4.03, 3.97"})
    found = check.complaints(name, text, other)
    assert found[0].startswith("2.005 is 3 now: With whitening, TLS rejects the outlier"), found


@pytest.mark.parametrize(
    ("name", "cell", "data", "other"),
    [
        ("00-one-lie", None, "z = np.array([1.0, 1.0, 2.0, 0.0])", "z = np.array([1, 1, 2, 2.0])"),
        ("00-one-lie", None, "sigma = np.array([0.1, 0.1,", "sigma = np.array([0.2, 0.1,"),
        ("01-m-estimators", "picture-check-text", "by * is_outlier", "by * 0.5 * is_outlier"),
        ("02-four-costs", "table-assert", "KERNELS[name](1.0)", "KERNELS[name](2.0)"),
        ("03-irls", "unfold-run", "-0.1, 5.0]), 0.3", "-0.1, 4.0]), 0.2"),
        ("04-non-convexity", "jump-check", "-0.1, 5.0]", "-0.1, 3.0]"),
        ("05-gnc", "map-chain", "B = np.array([0.0, 0.0, 0.0,", "B = np.array([0.0, 1.0, 0.0,"),
        ("06-switches-and-consistency", "solve-chain-text", "[1.0, 1.0, 2.0,", "[1.0, 1.5, 2.0,"),
        ("07-certificates", "proof-run", "plane([0.3, 0.3, 0.3])", "plane([0.3, 0.4, 0.3])"),
        ("08-showcase", "metrics-ate-text", "on_a_line(0, 2, 7)", "on_a_line(0, 2, 6)"),
    ],
)
def test_where_a_reader_changes_the_data_a_sentence_says_so(name, cell, data, other):
    """As exercise 7 of chapter 00 asks; no cell ends in an error."""
    assert any(data in source for source in Chapter(name).code.values())
    said = []
    for at, _, printed in check.run(name, {data: other}, cell):
        said += [at] if CHANGED in printed else []
        assert printed.count(CHANGED) <= 1
    assert said


def test_all_of_what_is_checked_has_to_hold(capsys):
    check_text(True, [True, True])
    assert not capsys.readouterr().out
    check_text(True, [True, False])
    assert capsys.readouterr().out == f"{CHANGED}\n"


@pytest.mark.parametrize(("name", "ratio"), [("00-one-lie", 1.0), ("08-showcase", 1.3)])
def test_a_quiz_gives_nothing_away_by_place_or_length(name, ratio):
    questions = Chapter(name).questions()
    assert len(questions) >= 5
    assert len(assert_right_options_are_hidden(questions, ratio)) >= 3
