"""Rosters: read as the systems write them, or refused with the file and the line."""

import codecs
import re
from pathlib import Path

import pytest
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.lms import roster

PLAIN = "Name,Mail\nÅsa,asa\nBob,bob\n"


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "roster.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        "\ufeff" + PLAIN,
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace("\n", "\r"),
        PLAIN.replace(",", ";"),
        PLAIN.replace(",", "\t"),
        PLAIN.rstrip("\n"),
        '"Name" , "Mail" \nÅsa,asa\nBob,bob\n'.replace(" ", ""),
        PLAIN.replace("Bob", "\n,\nBob"),
        PLAIN.encode("utf-16"),
        codecs.BOM_UTF16_BE + PLAIN.encode("utf-16-be"),
        "\ufeffsep=,\r\n" + PLAIN,
        '"sep=;"\n' + PLAIN.replace(",", ";"),
        "SEP=|\n" + PLAIN.replace(",", "|"),
    ],
)
def test_every_way_of_writing_it_is_one_table(tmp_path, text):
    read = roster.read(written(tmp_path, text))
    assert read.header == ("Name", "Mail")
    assert [row.cells for row in read.rows] == [("Åsa", "asa"), ("Bob", "bob")]


def test_a_line_is_where_it_begins(tmp_path):
    read = roster.read(written(tmp_path, 'Name,Mail\n"two\nlines",x\n\nBob,y\n'))
    assert [row.line for row in read.rows] == [2, 5]


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", 1, "a header and students are wanted"),
        ("Name,Mail\n", 1, "a header and students are wanted"),
        ("Name,Name\na,b\n", 1, "two columns are named 'Name'"),
        ("Name,Mail\na,b\na\n", 3, "1 cells under 2 columns"),
        ("Name,Mail\na,b\na,b,c\n", 3, "3 cells under 2 columns"),
        ('Name,Mail\na,b\n"a,b\n', 3, "this is not CSV"),
        ('Name,Mail\n"a"b,c\n', 2, "this is not CSV"),
        (b"Name,Mail\na,b\n\xc5sa,c\n", 3, "this is not UTF-8"),
        ("Name,Mail\na,b\n".encode("utf-16-le"), 1, "this is not UTF-8"),
        ("sep=;\nName;Mail\na;b\na\n", 4, "1 cells under 2 columns"),
        (f"Name,{'M' * 10**6}\na,b\n", 1, "this is not CSV"),
    ],
)
def test_what_is_no_table_is_named_with_its_line(tmp_path, text, line, words):
    path = written(tmp_path, text)
    with pytest.raises(WrongUse, match=f"{re.escape(str(path))}:{line}: .*{re.escape(words)}"):
        roster.read(path)


def test_a_student_stands_there_once_and_who_has_no_name_there_is_no_one(tmp_path):
    decomposed = "A\u030asa"
    read = roster.read(written(tmp_path, f"{PLAIN}{decomposed},else\nEve,\nDan,\n"))
    assert set(roster.by_key(read, read.rows, 1)) == {"asa", "bob", "else"}
    with pytest.raises(WrongUse, match=r"roster\.csv:4: 'Åsa' stands in line 2 already"):
        roster.by_key(read, read.rows, 0)
