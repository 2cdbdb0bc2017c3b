"""Break the map: attacks, the table of the best, and a class's scores, whatever is handed in."""

import csv
import json
import os
from importlib.resources import files
from itertools import islice

import numpy as np
import pytest
from robust_slam.graphs import pose_graph
from robust_slam_course.pictures.breaking import rules
from robust_slam_course.pictures.breaking.__main__ import main
from robust_slam_course.pictures.breaking.best import best

from lib.tests.worlds import refused

TABLE = json.loads(files("robust_slam_course.pictures.breaking").joinpath("best.json").read_text())


def test_all_closures_of_an_attack_fit_a_town_whose_part_has_moved():
    what = rules.attack("C:gnc:2-10:-1,2:3")
    graph, truth, _ = rules.town("C")
    moved = truth.copy()
    moved[10:13, :2] += [-1, 2]
    norms = pose_graph.residual_norms(rules.attacked(what), moved)
    np.testing.assert_allclose(norms[len(graph.edges) :], 0, atol=1e-9)


def test_attacks_come_in_the_order_of_their_ranks_and_none_twice():
    found = [str(each) for each in islice(rules.attacks("A", "gm"), 5000)]
    ranks = [rules.attack(score).rank for score in found]
    assert ranks == sorted(ranks) and len(set(found)) == len(found) == 4440


@pytest.mark.parametrize("name", TABLE)
def test_the_best_score_fools_its_solver(name, capsys):
    score = TABLE[name]["score"]
    if score is None:
        assert TABLE[name]["tried"] == len(list(rules.attacks(*name.split(":"))))
        return
    assert main(["replay", score]) == 0
    head, told = capsys.readouterr().out.splitlines()
    assert head.startswith("town,solver,result,outliers,offset")
    assert told.startswith(f"{name.replace(':', ',')},fooled,")


@pytest.mark.parametrize("solver", ["squares", pytest.param("gnc", marks=pytest.mark.soak)])
def test_no_attack_in_town_a_has_a_better_score(solver):
    assert best("A", solver) == TABLE[f"A:{solver}"]


@refused(
    ("A:gnc", "is no score; copy it again"),
    ("D:gnc:0-9:0,1:2", "town D: there is none; give A or B or C"),
    ("A:huber:0-9:0,1:2", "solver huber: there is none"),
    ("A:gnc:0-9:0,1:6", "6 closures: give 1 to 5"),
    ("A:gnc:9-0:0,1:2", "the earlier first, the later at most 10"),
    ("A:gnc:0-11:0,1:2", "the earlier first, the later at most 10"),
    ("A:gnc:0-9:0,0:2", "not both 0"),
    ("A:gnc:0-9:0,3:2", "from -2 to 2"),
)
def test_what_is_no_attack_is_refused_with_what_to_give(wrong, message, capsys):
    assert main(["replay", wrong]) == 2
    assert message in capsys.readouterr().err


HANDED_IN = {
    "ada": "A:gnc:2-9:1,1:3\n",
    "ben": "A:gnc:2-9:1,1:1",
    "eve": "A:gnc:2-9:1,1:1; rm",
    "cleo": TABLE["A:gnc"]["score"],
}


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_the_best_come_first_and_what_is_refused_last(tmp_path, kind, capsys):
    given, to = tmp_path / "given", tmp_path / "table.csv"
    if kind == "folder":
        given.mkdir()
        for student, score in HANDED_IN.items():
            (given / f"{student}.txt").write_text(score)
    else:
        lines = (f"{student},{score.strip()}\n" for student, score in HANDED_IN.items())
        given.write_text("\ufeffStudent,Score\n" + "".join(lines), encoding="utf-8")
    for more in ([], ["--no-names"]):
        assert main(["scores", str(given), "--to", str(to), *more]) == 0
        rows = list(csv.reader(to.read_text().splitlines()))
        assert rows[0][1 - len(more) :][:4] == ["score", "refused", "town", "solver"]
        scores = [row[1 - len(more)] for row in rows[1:]]
        assert scores[0] == HANDED_IN["cleo"] and scores[-1] == HANDED_IN["eve"]
        assert "is no score" in rows[-1][-1] and "fooled" in rows[1]
        assert any("cleo" in row for row in rows) != bool(more)
    assert "3 scores were replayed, and 1 refused" in capsys.readouterr().out


def test_each_students_file_is_read_alone_and_shown_in_one_short_line(tmp_path):
    (given := tmp_path / "given").mkdir()
    (given / "mal.txt").symlink_to(__file__)
    (tmp_path / "own.txt").write_text(HANDED_IN["ben"])
    (given / "hard.txt").hardlink_to(tmp_path / "own.txt")
    os.mkfifo(given / "pipe.txt")
    (given / "=cmd().txt").write_text(HANDED_IN["ben"])
    (given / "long.txt").write_text("\x1b[2J" + "9" * 10**6)
    score = HANDED_IN["ben"]
    lines = ["1", '"open', f"eve,{score}", f"{'e' * 10**6},{score}", "\x1b,x", f"\ufeff@x;{score}"]
    (tmp_path / "lines.csv").write_text("sep=,\n" + "\n".join(lines), encoding="utf-8")
    for path, first in ((given, ["'=cmd()"]), (tmp_path / "lines.csv", ["eve", "?@x"])):
        to = tmp_path / "table.csv"
        assert main(["scores", str(path), "--to", str(to)]) == 0
        text = to.read_text()
        rows = list(csv.reader(text.splitlines()))
        assert [row[0] for row in rows[1:] if not row[2]] == first
        assert max(len(row) for row in text.splitlines()) < 350
        assert "\x1b" not in text and "import csv" not in text


def test_what_is_not_there_is_named_and_no_score_is_overwritten(tmp_path, capsys):
    given, quoted = tmp_path / "given.csv", tmp_path / "quoted.csv"
    given.write_text(f"ada,{HANDED_IN['ben']}\n")
    quoted.write_bytes(f'"Doe, ""J""";"{HANDED_IN["ben"]}"\r\n'.encode("utf-16"))
    (tmp_path / "latin.csv").write_bytes("Jörg,x".encode("latin-1"))
    (link := tmp_path / "link.csv").symlink_to(given)
    for what, said in (
        ([link], "is a link"),
        ([tmp_path / "none"], "No such file"),
        ([tmp_path / "latin.csv"], "save it as CSV UTF-8"),
        ([given, "--to", given], "name another file"),
    ):
        assert main(["scores", *map(str, what)]) == 2
        assert said in capsys.readouterr().err
    assert given.read_text() == f"ada,{HANDED_IN['ben']}\n"
    assert main(["scores", str(quoted), "--to", str(tmp_path / "to.csv")]) == 0
    assert '"Doe, ""J""","A:gnc' in (tmp_path / "to.csv").read_text()
