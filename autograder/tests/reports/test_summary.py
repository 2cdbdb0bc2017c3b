"""A batch's summaries: marks and words; no name where none is wanted."""

import json
from dataclasses import replace
from typing import Any

import pytest
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.reports import summary

from ..test_markup import GITHUB, for_any_text
from . import samples

COUNTS = {"graded": 3, "refused": 1, "failed": 1, "kept": 0}
MARKS = [
    samples.result(samples.PASSED, student="zoe"),
    samples.refused("zoe.ipynb is not valid JSON: save it again.", student="ben"),
    samples.failed("The cell ada-7 fails.", student="dora"),
    samples.result(samples.PASSED, samples.PARTLY, student="ada", reason="zoe.ipynb was taken."),
    samples.result(samples.HUNG, student="cleo", seconds=1234.5),
]


def as_json(marks: list[Result]) -> Any:
    return json.loads(summary.as_json(marks, COUNTS, names=True))


def test_json_has_marks_and_statuses_in_the_batchs_order():
    value = as_json(MARKS[1:])
    assert value["schema"] == 1 and value["counts"] == COUNTS
    assert value["submissions"][0] == {
        "student": "ben",
        "assignment": "07-toy",
        "score": 0,
        "max_score": 20,
        "status": "refused",
        "reason": "zoe.ipynb is not valid JSON: save it again.",
        "exercises": [],
    }
    assert value["submissions"][2]["exercises"] == [
        {"name": "double", "score": 10, "max_score": 10, "status": "passed"},
        {"name": "apply", "score": 5, "max_score": 10, "status": "partial"},
    ]


def test_markdown_is_a_table_with_a_word_beside_each_sign():
    assert summary.as_markdown(MARKS, COUNTS, names=True).splitlines() == [
        "## Grading",
        "",
        "3 graded, 1 refused, 1 failed.",
        "",
        "| student | assignment | mark | outcome |",
        "| --- | --- | --- | --- |",
        "| `zoe` | `07-toy` | 10/10 | ✓ All checks passed: 1 of 1 exercises. |",
        "| `ben` | `07-toy` | 0/20 | ✗ refused: `zoe.ipynb is not valid JSON: save it again.` |",
        "| `dora` | `07-toy` | 0/20 | ✗ failed |",
        "| `ada` | `07-toy` | 15/20 | ✗ lost points in `apply` |",
        "| `cleo` | `07-toy` | 5/15 | ✗ lost points in `loop (timeout)` |",
    ]


RENDERED = pytest.mark.parametrize("render", [summary.as_json, summary.as_markdown])


@RENDERED
def test_without_names_nothing_tells_who_it_was(render):
    shown = render(MARKS, COUNTS, names=False)
    assert not any(name in shown for name in ("ada", "ben", "cleo", "dora", "zoe", "student"))
    assert "refused" in shown and "10" in shown
    assert render(MARKS[::-1], COUNTS, names=False) == shown


@pytest.mark.parametrize("names", [True, False])
@RENDERED
def test_seconds_sandbox_and_messages_are_not_in_it(render, names):
    before = render(MARKS, COUNTS, names=names)
    other = [replace(result, seconds=77.25, sandbox="fork") for result in MARKS]
    assert render(other, COUNTS, names=names) == before
    assert "77.25" not in before and "1234.5" not in before
    assert not any(text in before for text in (samples.SLOW, "Add the ½.", "ada-7"))


def shape(text: str) -> list[str]:
    """The kinds of what the Markdown holds with a text wherever a student's own may stand."""
    marks = [samples.told(text), samples.refused(text, student=text)]
    blocks = GITHUB.parse(summary.as_markdown(marks, COUNTS, names=True))
    return [token.type for block in blocks for token in (block, *(block.children or []))]


@pytest.fixture(scope="module")
def harmless():
    return shape("x")


@for_any_text
def test_a_hostile_text_changes_no_structure(harmless, text):
    if text.split():
        assert shape(text) == harmless
    assert summary.as_json([samples.told(text)], COUNTS, names=True).encode("utf-8")
    assert len(as_json([samples.told(text)])["submissions"]) == 1


def test_a_check_of_ones_own_shows_messages_and_promises_no_mark():
    own = samples.result(*samples.EVERY_STATUS, reason="A cell was copied.", student="")
    text = summary.check_as_markdown(own, {"double": 2, "apply": 1})
    assert text.splitlines()[2:6] == [
        "Visible cases passed in 1 of 6 exercises; 3 hidden cases remain when it is graded.",
        "",
        "Note: `A cell was copied.`",
        "",
    ]
    assert "- ✓ passed `double`\n- ◐ partial `apply` (`twice`): `Add the ½.`\n" in text
    assert "point" not in text and "10" not in text
    passed = summary.check_as_markdown(samples.result(samples.PASSED), None)
    assert "All visible cases passed; hidden cases remain when it is graded." in passed
