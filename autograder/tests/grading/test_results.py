"""Result files: one truth about each case, those of before, and what is no result."""

import json
import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import results
from robust_slam_autograder.reading.assignment import Config, Limits

from .. import toy
from ..reports.samples import HUNG, PARTLY, case, compared, exercise, result

BEFORE = json.loads(Path(__file__).with_name("first_schema.json").read_text("utf-8"))
"""Results as the grader of commit 8c0c81c wrote them."""
UNWRITTEN = "def double(x):\n    raise NotImplementedError\n"
SUBMISSIONS = {
    "ada": toy.answer(),
    "bob": toy.answer("def double(x):\n    raise ValueError('secret')\n"),
    "cem": toy.answer(toy.GUESS, "def apply(f, x, n):\n    while True: pass\n"),
    "dot": toy.answer(UNWRITTEN, "def apply(f, x, n):\n    return x, [x]\n"),
}
VALUES = exercise("values", "failed", compared("7", (1.0, 2.0, 3.0), (0.0, 2.0, 4.0)))
MARKED = result(PARTLY, HUNG, VALUES, student="half \udcff")


def test_a_case_keeps_how_it_ended(tmp_path):
    path = results.write(tmp_path, MARKED)
    value = json.loads(path.read_text("utf-8"))
    assert value["schema"] == 2
    endings = [[one["ending"] for one in each["cases"]] for each in value["exercises"]]
    assert endings == [["passed", "failed"], ["passed", "timeout", "timeout"], ["failed"]]
    assert results.read(path) == MARKED
    assert [file.name for file in path.parent.iterdir()] == ["07-toy.json"]


def test_a_check_without_a_word_of_its_own_is_failed_all_the_same(tmp_path):
    """The ending decides, and neither the message nor the points."""
    silent = case("first", " ", points=0)
    read = results.read(results.write(tmp_path, result(exercise("e", "failed", silent))))
    assert not read.exercises[0].cases[0].passed


@pytest.mark.parametrize("before", BEFORE, ids=SUBMISSIONS)
def test_a_result_of_the_first_schema_is_read_as_if_it_were_graded_now(before, tmp_path):
    path = results.path_of(tmp_path, before["student"], before["assignment"])
    path.parent.mkdir()
    path.write_text(json.dumps(before), encoding="utf-8")
    config = Config(packages=toy.PACKAGES, limits=Limits(call_seconds=0.4, cell_seconds=2))
    now = toy.graded(SUBMISSIONS[before["student"]], toy.assignment(config))
    same = {key: before[key] for key in ("student", "sandbox", "seconds")}
    assert results.read(path) == replace(now, **same)


CURVES = re.compile(r'"curves": \[\s*\[.*?\]\s*\]', re.DOTALL)
SPOILT: dict[str, Callable[[str], str]] = {
    "no JSON": lambda text: text[:1],
    "a list": lambda text: "[]",
    "nested": lambda text: "[" * 100_000,
    "without fields": lambda text: '{"schema": 2}',
    "a number for exercises": lambda text: '{"schema": 2, "exercises": 7}',
    "points in words": lambda text: re.sub('"earned": [0-9]+', '"earned": "many"', text, count=1),
    "points that are none": lambda text: re.sub('"score": [0-9]+', '"score": NaN', text, count=1),
    "points without end": lambda text: re.sub('"points": [0-9]+', f'"points": {10**400}', text),
    "a field of its own": lambda text: text.replace('"reason"', '"why"', 1),
    "points that are not earned": lambda text: re.sub('"earned": 0', '"earned": 5', text, count=1),
    "an exercise's own sum": lambda text: text.replace('"score": 5', '"score": 6', 2),
    "a score of its own": lambda text: text.replace('"score": 10,', '"score": 25,', 1),
    "more than there is": lambda text: text.replace('"max_score": 30', '"max_score": 60', 1),
    "a flag in words": lambda text: text.replace('"visible": true', '"visible": "no"', 1),
    "a number for a text": lambda text: re.sub('"reason": "[^"]*"', '"reason": 7', text, count=1),
    "an ending of its own": lambda text: text.replace('"timeout"', '"lost"'),
    "a status of its own": lambda text: text.replace('"graded"', '"passed"'),
    "a refusal with points": lambda text: text.replace('"graded"', '"refused"'),
    "a newer schema": lambda text: text.replace('"schema": 2', '"schema": 3'),
    "another student's": lambda text: text.replace('"student": "half', '"student": "bob'),
    "another assignment's": lambda text: text.replace("07-toy", "08-toy"),
    "a number for a value": lambda text: text.replace('"yours": "7"', '"yours": 7'),
    "one curve": lambda text: CURVES.sub('"curves": [[1.0, 2.0]]', text),
    "curves of two lengths": lambda text: CURVES.sub('"curves": [[1.0, 2.0], [1.0]]', text),
    "curves of words": lambda text: CURVES.sub('"curves": [["a"], ["b"]]', text),
    "a number for curves": lambda text: CURVES.sub('"curves": 7', text),
    "a value of its own": lambda text: text.replace('"yours"', '"more": "x", "yours"'),
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT)
def test_a_file_that_is_no_result_of_its_place_is_named(spoil, tmp_path):
    path = results.write(tmp_path, MARKED)
    text = path.read_text("utf-8")
    assert spoil(text) != text
    path.write_text(spoil(text), encoding="utf-8")
    with pytest.raises(WrongUse, match=r"07-toy\.json is no result file \(.*\): delete it"):
        results.read_checked(path)


def test_a_result_that_cannot_be_opened_is_named(tmp_path):
    path = results.path_of(tmp_path, "ada", "a")
    os.makedirs(path)
    with pytest.raises(WrongUse, match="Is a directory"):
        results.read_checked(path)
