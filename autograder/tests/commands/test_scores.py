"""``autograder scores``: a class's table, whatever students hand in."""

import csv
import os
import shlex
import sys

import pytest

GAME = """import sys
score = sys.argv[2]
if "bad" in score:
    sys.exit(f"{score} is bad")
print("outliers,offset")
print(*score.split(":"), sep=",")
sys.exit(len(score) % 2)
"""
HANDED_IN = {"ada": "10:1\n", "ben": "9:25", "eve": "9:25; rm", "dan": "bad", "cleo": "9:5"}


@pytest.fixture
def game(tmp_path):
    """A command that replays scores, which are two numbers."""
    (tmp_path / "game.py").write_text(GAME)
    return shlex.join([sys.executable, str(tmp_path / "game.py")])


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_the_best_come_first_and_what_is_refused_last(tmp_path, autograder, game, kind):
    given = tmp_path / "given"
    if kind == "folder":
        given.mkdir()
        for student, score in HANDED_IN.items():
            (given / f"{student}.txt").write_text(score)
    else:
        lines = (f"{student},{score.strip()}\n" for student, score in HANDED_IN.items())
        given.write_text("\ufeffStudent,Score\n" + "".join(lines), encoding="utf-8")
    to = tmp_path / "table.csv"
    for more in ([], ["--no-names"]):
        assert autograder("scores", given, "--replay", game, "--to", to, *more)[0] == 0
        rows = list(csv.reader(to.read_text().splitlines()))
        whole = [
            ["student", "score", "refused", "outliers", "offset"],
            ["cleo", "9:5", "", "9", "5"],
            ["ben", "9:25", "", "9", "25"],
            ["ada", "10:1", "", "10", "1"],
        ]
        assert rows[:4] == [row[len(more) :] for row in whole]
        refused = {tuple(row[-2:]) for row in rows[4:]}
        assert refused == {("9:25; rm", "no score"), ("bad", "bad is bad")}


def test_each_students_file_is_read_alone_and_shown_in_one_short_line(tmp_path, autograder, game):
    (given := tmp_path / "given").mkdir()
    (given / "mal.txt").symlink_to(__file__)
    (tmp_path / "own.txt").write_text("9:25")
    (given / "hard.txt").hardlink_to(tmp_path / "own.txt")
    os.mkfifo(given / "pipe.txt")
    (given / "=cmd().txt").write_text("9:5")
    (given / "long.txt").write_text("\x1b[2J" + "9" * 10**6)
    lines = [*"12", '"open', "eve,9:5", f"{'e' * 10**6},9:5", "\x1b,bad", "\ufeff@x;9:5"]
    (tmp_path / "lines.csv").write_text("sep=,\n" + "\n".join(lines), encoding="utf-8")
    for path, first in ((given, "'=cmd()"), (tmp_path / "lines.csv", "eve")):
        to = tmp_path / "table.csv"
        assert autograder("scores", path, "--replay", game, "--to", to)[0] == 0
        text = to.read_text()
        rows = list(csv.reader(text.splitlines()))
        assert [row[0] for row in rows[1:] if not row[2]] == [first]
        assert max(len(row) for row in text.splitlines()) < 250
        assert "\x1b" not in text and "import csv" not in text


def test_what_is_not_there_is_named_and_no_score_is_overwritten(tmp_path, autograder, game):
    given = tmp_path / "given.csv"
    given.write_text("ada,10:1\n")
    (link := tmp_path / "link.csv").symlink_to(given)
    for what, said in (
        ([link], "is a link"),
        ([tmp_path / "none"], "correct the path"),
        ([given, "--replay", "no-such-game"], "no command no-such-game"),
        ([given, "--replay", game, "--to", given], "name another file"),
    ):
        code, _, error = autograder("scores", *what)
        assert code == 2 and said in error
    assert given.read_text() == "ada,10:1\n"
