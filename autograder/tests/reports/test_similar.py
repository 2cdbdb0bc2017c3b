"""Answers that are nearly one text are found under other names, and nothing else is."""

import re

import pytest
from robust_slam_autograder.grading import results
from robust_slam_autograder.reports import similar

from .. import toy
from . import samples

RELEASED = '''\
def solve(residuals, threshold, start=0.0):
    """Return the weighted mean by iteratively reweighted least squares, ten steps from a start.

    Each residual beyond the threshold counts as little as the threshold over it.
    """
    accepted = [index for index, value in enumerate(residuals) if abs(value) < 10 * threshold]
    raise NotImplementedError
'''
ANSWER = RELEASED.replace(
    "raise NotImplementedError",
    """\
for step in range(10):
        weights = [min(1.0, threshold / max(abs(r - start), 1e-12)) for r in residuals]
        start = sum(w * r for w, r in zip(weights, residuals)) / sum(weights)
    return start""",
)
COPIED = "# All my own work.\n" + re.sub(
    r"\b(step|weights|start|r|w|threshold)\b", r"my_\1", ANSWER
).replace("    return", "    # the end\n    return")
OWN = RELEASED.replace(
    "raise NotImplementedError",
    """\
import numpy as np
    z, x, k = np.asarray(residuals), start, 0
    while k < 10:
        far = np.abs(z - x) > threshold
        w = np.where(far, threshold / np.maximum(np.abs(z - x), 1e-12), 1.0)
        x, k = np.average(z, weights=w), k + 1
    return float(x)""",
)


def found(**texts: str) -> similar.Alike:
    return similar.find({"solve": texts}, {"solve": RELEASED})


def test_a_copy_under_other_names_and_comments_is_found_and_work_of_ones_own_is_not():
    (two,) = found(ada=ANSWER, bob=COPIED, cleo=OWN).two
    (pair,) = two.pairs
    assert (two.students, pair.texts) == (("ada", "bob"), (ANSWER, COPIED))
    assert pair.share > 0.9


def test_who_has_most_exercises_in_common_comes_first():
    texts = {"ada": ANSWER, "bob": COPIED, "cleo": COPIED}
    made = similar.find({"a": texts, "b": {"bob": ANSWER, "cleo": COPIED, "dan": OWN}}, {})
    assert [(two.students, len(two.pairs)) for two in made.two] == [
        (("bob", "cleo"), 2),
        (("ada", "bob"), 1),
        (("ada", "cleo"), 1),
    ]


@pytest.mark.parametrize("text", [RELEASED, "", "def (:", "x" * 30_000, "\x00\ud800'''"])
def test_what_everybody_was_given_is_no_copy_and_odd_texts_are_none(text):
    assert found(ada=text, bob=text, cleo=OWN) == similar.Alike((), ())


def test_what_many_wrote_in_one_way_is_said_and_no_pair_of_theirs_shown():
    many = {f"s{n}": COPIED for n in range(5)}
    assert found(**many, cleo=OWN) == similar.Alike((), (("solve", 5),))


DOUBLE = """\
def double(x):
    # <script>
    total, parts = 0, [part for part in (x, x) if part is not None]
    for number, part in enumerate(parts, start=1):
        total = total + part if number else part
    return total
"""


@pytest.fixture
def report(tmp_path, autograder):
    toy.make_tree(tmp_path)
    for student, text in {"ada": DOUBLE, "bob": DOUBLE, "cleo": toy.DOUBLE}.items():
        toy.hand_in(tmp_path / "submitted", student, toy.answer(text))
        results.write(tmp_path / "graded", samples.result(samples.PASSED, student=student))
    results.write(tmp_path / "graded", samples.refused("It is not JSON.", student="dora"))
    (broken := tmp_path / "submitted" / "dora" / toy.NAME).mkdir(parents=True)
    (broken / f"{toy.NAME}.ipynb").write_text("{")
    where = ("--out", tmp_path / "graded", "--to", tmp_path / "report")
    return lambda *arguments: autograder("report", *where, *arguments)


def test_the_page_shows_both_texts_and_that_they_prove_nothing(tmp_path, report):
    assert report("--similar", "--submitted", tmp_path / "submitted")[0] == 0
    page = (tmp_path / "report" / f"{toy.NAME}.html").read_text()
    section = page[page.index('id="alike"') : page.index('id="attention"')]
    assert "This proves nothing." in section and "<script>" not in section
    assert section.count("# &lt;script&gt;") == 2
    assert "ada" in section and "bob" in section and "cleo" not in section
    assert report()[0] == 0
    assert 'id="alike"' not in (tmp_path / "report" / f"{toy.NAME}.html").read_text()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["--no-names"], "does not go with --no-names"), ([], "say --submitted DIR")],
)
def test_what_cannot_be_compared_is_said(tmp_path, report, arguments, words):
    status, _, err = report("--similar", "--submitted", tmp_path / "none", *arguments)
    assert status == 2 and words in err and not (tmp_path / "report").exists()
