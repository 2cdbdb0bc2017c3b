"""``autograder report``: from results to pages, without names on demand."""

import re
import shutil
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import pytest
from robust_slam_autograder.grading import results

from .. import toy
from ..reports import samples
from ..reports.pages import Skeleton

STUDENTS = ("ada lovelace", "ben:#1?", "cleo")
OTHER = "08-other"


@pytest.fixture
def graded(tmp_path):
    """A folder with the results of three students in two assignments."""
    out = tmp_path / "graded"
    for student in STUDENTS:
        results.write(out, samples.result(*samples.EVERY_STATUS, student=student))
        other = samples.result(samples.UNWRITTEN, student=student)
        results.write(out, replace(other, assignment=OTHER))
    results.write(out, samples.refused("dora.ipynb is not valid JSON.", student="dora"))
    return tmp_path


@pytest.fixture
def run(tmp_path, autograder):
    places = {"out": "graded", "to": "report", "feedback": "feedback"}
    where = [word for name, at in places.items() for word in (f"--{name}", tmp_path / at)]
    return lambda *arguments: autograder("report", *where, *arguments)


def pages(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder / "report")): path.read_text("utf-8")
        for path in (folder / "report").rglob("*.html")
    }


def links(page: str) -> list[str]:
    return re.findall(r'href="(?!#|data:)([^"]*)"', page)


def assignments(page: str) -> list[str]:
    """The assignments' pages that an index leads to; the heat map's heads lead there too."""
    found = [link for link in links(page) if not link.startswith("students/")]
    assert set(found) == set(found[: len(found) // 2]), "both tables lead to the same pages"
    return found[: len(found) // 2]


def test_each_assignment_has_a_page_and_the_index_leads_there(graded, run):
    status, out, err = run()
    assert (status, err) == (0, "")
    assert out == f"report on 2 of 2 assignments: {graded / 'report' / 'index.html'}\n"
    found = pages(graded)
    students = {f"students/{student}.html" for student in (*STUDENTS, "dora")}
    assert set(found) == {"index.html", f"{toy.NAME}.html", f"{OTHER}.html", *students}
    assert assignments(found["index.html"]) == [f"{toy.NAME}.html", f"{OTHER}.html"]
    assert links(found[f"{OTHER}.html"]) == ["index.html"]


def test_names_lead_to_students_pages_and_to_the_feedback_that_there_is(graded, run):
    for student in STUDENTS[:2]:
        page = graded / "feedback" / student / f"{toy.NAME}.html"
        page.parent.mkdir(parents=True)
        page.touch()
    assert run()[0] == 0
    folder, found = graded / "report", pages(graded)
    leads = [unquote(link) for link in links(found["index.html"]) if "students/" in link]
    assert leads == [f"students/{student}.html" for student in (*STUDENTS, "dora")]

    def targets(name: str) -> set[Path]:
        return {((folder / name).parent / unquote(link)).resolve() for link in links(found[name])}

    index = (folder / "index.html").resolve()
    theirs = [(graded / "feedback" / s / f"{toy.NAME}.html").resolve() for s in STUDENTS[:2]]
    assert targets(f"{toy.NAME}.html") == {index, *theirs}
    both = [(folder / f"{name}.html").resolve() for name in (toy.NAME, OTHER)]
    assert targets(leads[1]) == {index, *both, theirs[1]}


def test_a_title_is_the_assignments_own(graded, run):
    toy.make_tree(graded, 'title = "Twice, and again"\n')
    assert run()[0] == 0
    assert "<h1>Twice, and again</h1>" in pages(graded)[f"{toy.NAME}.html"]
    assert f"<h1>{OTHER}</h1>" in pages(graded)[f"{OTHER}.html"]


def test_one_page_may_be_made_anew_and_the_index_still_has_all(graded, run):
    status, out, _ = run(OTHER)
    assert status == 0 and out.startswith("report on 1 of 2 assignments")
    shown = {name for name in pages(graded) if "/" not in name}
    assert shown == {"index.html", f"{OTHER}.html"}
    assert assignments(pages(graded)["index.html"]) == [f"{OTHER}.html"]
    assert toy.NAME in pages(graded)["index.html"]
    assert run(toy.NAME)[0] == 0
    assert assignments(pages(graded)["index.html"]) == [f"{toy.NAME}.html", f"{OTHER}.html"]


def test_without_names_no_file_and_no_page_tells_one(graded, run):
    shutil.copytree(graded / "graded", graded / "feedback")
    assert run("--no-names")[0] == 0
    shown = repr(pages(graded))
    assert not [name for name in (*STUDENTS, "dora") if name in shown]
    assert "Refused: 1" in pages(graded)[f"{toy.NAME}.html"]


def test_without_names_the_index_leads_to_no_page_of_before(graded, run):
    assert run()[0] == 0
    assert run(OTHER, "--no-names")[0] == 0
    assert set(links(pages(graded)["index.html"])) == {f"{OTHER}.html"}


@pytest.mark.parametrize(
    ("spoil", "arguments", "sentence"),
    [
        (str, ["09-none"], f"holds no result of 09-none; there are {toy.NAME}, {OTHER}."),
        (str, ["--out", "nowhere"], "nowhere holds no result: grade first"),
        (lambda path: shutil.copy(path, path.with_name("index.json")), [], "named index"),
        (lambda path: path.write_text("{"), [], f"{toy.NAME}.json is no result file"),
    ],
    ids=["no such assignment", "no results", "an assignment named index", "no result"],
)
def test_what_cannot_be_shown_is_told(graded, run, spoil, arguments, sentence):
    spoil(graded / "graded" / "cleo" / f"{toy.NAME}.json")
    assert run(*arguments).refused(sentence)
    assert not (graded / "report").exists()


def test_a_place_that_cannot_be_written_is_named(graded, run):
    (graded / "report").write_text("a file")
    status, out, err = run()
    assert (status, out) == (1, "")
    assert f"{graded / 'report' / toy.NAME}.html cannot be written" in err


MARKING = f"""\
markers = ["Ines", "<b>Omar"]

[takes]
cleo = "Ines"

[questions.{toy.NAME}]
"ada lovelace" = "apply: <i>why</i> none?"
cleo = "double: twice?"

[answers.{toy.NAME}]
cleo = "Looked at again: it stays."
"""


def test_who_marks_whom_and_what_is_asked_is_on_the_page_and_open_ones_on_the_index(graded, run):
    (graded / "marking.toml").write_text(MARKING)
    assert run()[0] == 0
    found = {name: " ".join(Skeleton(text).text.split()) for name, text in pages(graded).items()}
    page = found[f"{toy.NAME}.html"]
    assert "Questions about marks: 1 open" in page and "apply: <i>why</i> none?" in page
    assert page.index("apply: <i>why") < page.index("Looked at again: it stays.")
    # Ada, Ben and Dora in turn, and Cleo as the file says.
    mark = "20 of 55 points"
    assert f"Ines: 3 StudentMark ada lovelace{mark} cleo{mark} dorarefused" in page
    assert f"<b>Omar: 1 StudentMark ben:#1?{mark}" in page
    assert "1 open question" in found["index.html"]
    assert "Questions" not in found[f"{OTHER}.html"]
    assert run("--no-names")[0] == 0
    shown = pages(graded)[f"{toy.NAME}.html"]
    assert "1 open" in shown and not re.search("Ines|Omar|why|Looked at", shown)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('cleo = "Ines"', 'cloe = "Ines"', "takes names cloe, and no student of that name"),
        ('cleo = "Ines"', 'cleo = "Inse"', "cleo is given to 'Inse'; the markers are Ines, <b>"),
        ("[questions.07-toy]", "[questions.08]", "questions names 08, and no assignment"),
        ('cleo = "double: twice?"', "", "answers.07-toy answers cleo, who asks nothing there"),
        ('cleo = "double: twice?"', 'cleo = " "', "questions.07-toy.cleo is a sentence in quotes"),
        ('"Ines", ', "3, ", "markers is a list of names"),
        ("[takes]", "[take]", "unknown key 'take'"),
        ("[takes]", "[takes", "is not valid TOML"),
    ],
)
def test_a_file_of_markers_that_cannot_be_meant_is_refused(graded, run, old, new, words):
    assert old in MARKING
    (graded / "marking.toml").write_text(MARKING.replace(old, new))
    assert run().refused(words, "marking.toml")
    assert not (graded / "report").exists()
