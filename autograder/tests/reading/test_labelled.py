"""Answers are read from their table; a change must fit exactly one place."""

from pathlib import Path

import pytest
from robust_slam_autograder.reading.labelled import Answer, read, replaced

RIGHT = """
[right_sum]
idea = "One line after the other."
code = '''
def area(width, height):
    if width < 0:
        return math.nan
    return width * height
'''
"""


def written(folder: Path, text: str) -> list[Answer]:
    path = folder / "area.toml"
    path.write_text(RIGHT + text, encoding="utf-8")
    return read(path)


def test_an_answer_is_its_code_its_story_and_its_case(tmp_path):
    text = "[wrong_one]\nmisconception = 'Always one.'\ncaught_by = 'area-two'\ncode = 'a = 1'\n"
    right, wrong = written(tmp_path, text)
    assert right.is_right and right.caught_by is None and right.exercise == "area"
    assert right.source.startswith("def area(width, height):\n    if width < 0:\n")
    assert wrong == Answer("area", "wrong_one", "a = 1", "Always one.", "area-two")


def test_changes_are_made_to_an_answer_above(tmp_path):
    text = """
[right_other]
from = "right_sum"
changes = [["width *", "1 * width *"]]

[wrong_both]
misconception = "Two places."
stopped_by = "area-two"
from = "right_other"
changes = [
  ['''
    if width < 0:
        return math.nan
  ''', "width = abs(width)"],
  ["return 1 * width * height", "area = width\\nreturn area"],
]
"""
    _, other, wrong = written(tmp_path, text)
    assert other.is_right and "return 1 * width * height" in other.source
    lines = ["    width = abs(width)", "    area = width", "    return area"]
    assert wrong.source.splitlines()[1:] == lines and wrong.is_visible


ADDS = '[wrong_plus]\nmisconception = "Adds."\ncaught_by = "a"\n'


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (f'{ADDS}from = "right_sum"\nchanges = [["width", "w"]]', "3 times, not once: 'width'"),
        (f'{ADDS}from = "right_sum"\nchanges = [["depth", "w"]]', "occurs 0 times"),
        (f'{ADDS}from = "right_sum"\nchanges = [["", "w"]]', "occurs 0 times"),
        (f'{ADDS}from = "right_sum"\nchanges = [["width *"]]', "a change is a pair"),
        (f'{ADDS}from = "right_none"\nchanges = [["width *", "w"]]', "right_none above it"),
        (f'{ADDS}from = "right_sum"\ncode = "pass"', "either code, or from and changes"),
        (f'{ADDS}code = "pass"\nstopped_by = "b"', "one case, caught_by or stopped_by"),
        (f'{ADDS}code = "pass"\nidea = "c"', "unknown key idea"),
        (f'{ADDS}code = ""', "not empty"),
        ("[wrong_plus]\ncode = 'pass'\n", "a wrong answer names one case"),
        ("[right_plus]\ncode = 'pass'\ncaught_by = 'a'\n", "unknown key caught_by"),
        ("[other]\ncode = 'pass'\n", "an answer is a table"),
        ("[wrong_plus\n", ""),
    ],
)
def test_another_form_is_refused_with_its_file_and_its_name(tmp_path, text, told):
    name = r"\w+: " if told else ""
    with pytest.raises(ValueError, match=rf"area\.toml: {name}.*{told}") as caught:
        written(tmp_path, text)
    assert not told or f"area.toml: {text[1 : text.index(']')]}: " in str(caught.value)


def test_an_occurrence_may_span_lines_of_any_indentation():
    source = "if a:\n    if b:\n        c\nif b:\n    d\n"
    assert replaced(source, "if b:\n    c", "c") == "if a:\n    c\nif b:\n    d\n"
