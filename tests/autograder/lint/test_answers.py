"""Answers are read from their file without running it; a change must say exactly one place."""

from __future__ import annotations

from pathlib import Path

import pytest
from robust_slam_autograder.lint.answers import Answer, read, replaced

RIGHT = '''def right_sum() -> None:
    """Right: one line after the other."""
    import math

    def area(width, height):
        if width < 0:
            return math.nan
        return width * height


'''


def written(folder: Path, text: str) -> list[Answer]:
    path = folder / "area.py"
    path.write_text(RIGHT + text, encoding="utf-8")
    return read(path)


def test_a_function_is_its_body_its_story_and_its_case(tmp_path):
    text = 'def wrong_one():\n    """Wrong: always one. Caught by area-two."""\n    area = 1\n'
    right, wrong = written(tmp_path, text)
    assert right.is_right and right.caught_by is None and right.exercise == "area"
    assert right.source.startswith("import math\n\ndef area(width, height):\n    if width < 0:\n")
    assert wrong == Answer("area", "wrong_one", "area = 1\n", "Wrong: always one.", "area-two")


def test_a_change_is_the_right_answer_with_other_text(tmp_path):
    text = (
        'wrong_plus = change(right_sum, "width *", "width +", stopped_by="area-two")\n"""Adds."""'
    )
    right, wrong = written(tmp_path, text)
    assert wrong.source == right.source.replace("*", "+")
    assert (wrong.story, wrong.caught_by, wrong.is_visible) == ("Adds.", "area-two", True)


def test_a_change_may_be_right_and_names_no_case(tmp_path):
    _, other = written(tmp_path, 'right_other = change(right_sum, "width *", "1 * width *")\n')
    assert other.is_right and other.caught_by is None
    with pytest.raises(ValueError, match="a right one none"):
        written(tmp_path, 'right_other = change(right_sum, "width *", "1 *", caught_by="a")\n')


def test_several_lines_stand_where_the_first_one_stood(tmp_path):
    text = '''wrong_both = change(
    right_sum,
    (
        """
        if width < 0:
            return math.nan
        """,
        "width = abs(width)",
    ),
    ("return width * height", "area = width\\nreturn area"),
    caught_by="area-two",
)
"""Two places."""
'''
    _, wrong = written(tmp_path, text)
    lines = ["    width = abs(width)", "    area = width", "    return area"]
    assert wrong.source.splitlines()[3:] == lines


@pytest.mark.parametrize(
    ("call", "told"),
    [
        ('change(right_sum, "width", "w", caught_by="a")', "occurs 3 times, not once: 'width'"),
        ('change(right_sum, "depth", "w", caught_by="a")', "occurs 0 times"),
        ('change(right_sum, "", "w", caught_by="a")', "occurs 0 times"),
        ('change(right_none, "width *", "w", caught_by="a")', "no answer right_none above it"),
        ('change(right_sum, "width *", "w")', "names one case"),
        ('change(right_sum, "width *", "w", caught_by="a", stopped_by="b")', "names one case"),
        ('change(right_sum, "width *", caught_by="a")', "an old text and a new one"),
        ('print(right_sum, "width *", "w", caught_by="a")', "change"),
    ],
)
def test_another_form_is_refused_with_its_place(tmp_path, call, told):
    with pytest.raises(ValueError, match=rf"area\.py:11: wrong_plus: .*{told}"):
        written(tmp_path, f"wrong_plus = {call}\n")


def test_nothing_of_the_file_is_run(tmp_path):
    read_ones = written(tmp_path, "raise SystemExit\n")
    assert [answer.name for answer in read_ones] == ["right_sum"]


def test_an_occurrence_may_span_lines_of_any_indentation():
    source = "if a:\n    if b:\n        c\nif b:\n    d\n"
    assert replaced(source, "if b:\n    c", "c") == "if a:\n    c\nif b:\n    d\n"
