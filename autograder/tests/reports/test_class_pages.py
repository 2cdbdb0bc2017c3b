"""The instructor's pages say the numbers in words and tables, and no more than they may."""

import re
from dataclasses import replace

import pytest
from hypothesis import settings
from robust_slam_autograder.markup import one_line, visible
from robust_slam_autograder.reports import class_pages, documents

from ..test_markup import for_any_text
from . import pages, samples
from .pages import MANY, Skeleton, hostile, report
from .samples import case, exercise, result
from .test_class_report import CLASS


@pytest.fixture(scope="module")
def made():
    return pages.of_classes()


def words(page: str) -> str:
    """The page's words, with a space between cells."""
    text = Skeleton(page.replace("<wbr>", "").replace("<", " <")).text
    return " ".join(text.split()).replace(" ,", ",").replace(" ;", ";")


@pytest.mark.parametrize(
    ("share", "said"),
    [(None, "–"), (0, "0 %"), (0.001, "<1 %"), (0.5, "50 %"), (0.999, ">99 %"), (1, "100 %")],
)
def test_nothing_and_everything_are_said_of_these_alone(share, said):
    assert documents.percent(share) == said


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (0.04, "0.0 s"),
        (9.94, "9.9 s"),
        (9.96, "10 s"),
        (59.6, "1 min 00 s"),
        (125, "2 min 05 s"),
        (3599.7, "1 h 00 min"),
    ],
)
def test_durations_are_for_people(seconds, said):
    assert documents.duration(seconds) == said


def test_a_page_says_that_it_is_the_instructors(made):
    for page in made.values():
        assert "For the instructor. " in words(page) and "do not publish it" in words(page)


def test_every_number_of_a_picture_is_in_a_table(made):
    text, shown = words(made["many"]), report(*MANY)
    for found in shown.marks.bins:
        assert f"{found.label} {found.students}" in text
    apply = next(each for each in shown.exercises if each.name.startswith("solve"))
    numbers = (apply.whole, apply.partly, apply.none, apply.missing)
    assert " ".join([apply.name, documents.percent(apply.share), *map(str, numbers)]) in text
    assert f"case-1 visible 5 {apply.cases[1].passed}" in text
    assert f"case-7 hidden 5 {apply.cases[7].passed}" in text


def test_the_commonest_misconceptions_come_first_and_the_index_names_three():
    wrong = exercise("double", "failed", case("random", "No."))
    said = [f"your function adds `{n}`" for n in (4, 3, 3, 2, 2, 2, 1, 1, 1, 1)]
    answers = [replace(wrong, misconception=one) for one in said]
    shown = report(*(result(one, student=f"s{n}") for n, one in enumerate(answers)))
    text = words(class_pages.html(shown))
    assert text.index("looks as if the function adds 1") < text.index("class misunderstood")
    index = words(class_pages.index([shown], pages.chart(), names=True))
    found = re.findall(r"(\d+) of 10 double : it looks as if the function adds (\d)", index)
    assert found == [("4", "1"), ("3", "2"), ("2", "3")]


def shapes(page: str, height: str) -> list[tuple[float, float]]:
    """Where the bars of a height begin, and how wide they are."""
    found = [dict(attrs) for tag, attrs in Skeleton(page).tags if tag == "rect"]
    bars = [one for one in found if one["height"] == height and "x" in one]
    return [(float(one["x"].rstrip("%")), float(one["width"].rstrip("%"))) for one in bars]


def test_parts_and_spreads_are_in_per_cent():
    page = class_pages.html(report(*CLASS))
    assert shapes(page, "100%") == [(0, 50), (50, 25), (75, 25), (0, 100)]
    marks = [replace(result(student=str(n)), score=30 * n, max_score=60) for n in range(3)]
    spread = report(*marks)
    assert shapes(class_pages.index([spread], pages.chart(), names=True), "10") == [(25, 50)]


def test_other_versions_are_told_at_the_top_and_on_the_index(made):
    text = words(made["many"])
    assert "the version that graded most, 40 of 41 submissions" in text
    assert "1 submission: 10 points in all in place of 55; without the exercises" in text
    assert "more than one version of the tests" in words(made["index"])
    assert "version" not in words(made["one"])


def test_the_index_names_what_is_hardest_and_links_to_pages_that_there_are(made):
    text = words(made["index"])
    assert "hardest: broken, 0 % of its points" in text and text.count("hardest") == 1
    links = [dict(attrs)["href"] for tag, attrs in Skeleton(made["index"]).tags if tag == "a"]
    pages = [link for link in links if "toy" not in link and "students/" not in link]
    assert pages == ["many.html", "many.html#misunderstood", "one.html", "no-points.html"]


def test_texts_that_few_got_are_folded_and_the_rest_counted():
    texts = [exercise("e", "failed", case("c", f"Text {n:03}.")) for n in range(40)]
    many = report(*(result(one, student=f"s{n}") for n, one in enumerate(texts)))
    text = class_pages.html(many)
    assert "37 more" in text and "Text 029." in text and "Text 030." not in text
    assert "And 10 more, which 1 student or fewer got each." in text


@pytest.mark.parametrize(("students", "drawn"), [(7, False), (8, True)])
def test_few_marks_are_said_in_a_sentence_and_not_drawn(students, drawn):
    marks = [replace(result(student=f"s{n}"), score=n, max_score=9) for n in range(students)]
    text = class_pages.html(report(*marks))
    assert ("<figure>" in text) == drawn
    said = "7 marks, from 0 to 6 of 9, with the median at 3. A histogram is drawn for 8 or more."
    assert (said in words(text)) == (not drawn)


def test_what_many_misunderstood_is_said_with_its_share(made):
    text = words(made["many"])
    start = text.index("What 40 % of the class misunderstood")
    section = text[start : text.index("Exercises, hardest first")]
    shown = report(*MANY).misunderstood
    assert [hint.text for _, hint in shown] == [pages.COMMON]
    told = shown[0][1].students
    assert told >= 16 and f"{pages.COMMON} {documents.percent(told / 40)}" in section
    assert f"case case-7: {told} of 40 students" in section
    assert "Your function raised" not in section
    for page, said in (("one", False), ("nothing", False), ("no-names", True)):
        assert ("of the class misunderstood" in words(made[page])) == said


def test_the_heat_map_has_every_mark_with_its_number(made):
    table = pages.chart(MANY, MANY[:3])
    text = words(class_pages.index([], table, names=True))
    for row in table.rows:
        numbers = " ".join(square.text for square in row.squares)
        assert f"{row.student} {documents.percent(row.share)} {numbers}" in text


def test_a_students_page_says_the_marks_and_where_there_are_none():
    table = pages.chart(MANY, MANY[:1], [samples.refused("No.", student="student 0")])
    (row,) = [row for row in table.rows if row.student == "student 0"]
    text = words(class_pages.student(row))
    score = f"{MANY[0].score} of {MANY[0].max_score} points"
    assert text.count(score) == 2 and "Refused." in text and "median of the class" in text
    (other,) = [row for row in table.rows if row.student == "zoe"]
    text = words(class_pages.student(other))
    assert "There is no mark yet." in text and "The grader failed." in text
    assert text.count("Not handed in.") == 2


def of_all_kinds(text: str) -> tuple[Skeleton, ...]:
    """The heat map, a student's page and an assignment's, with a text wherever one may be."""
    name = text.encode(errors="ignore").decode() or "x"  # no folder has half a character's name
    table = pages.chart([replace(samples.told(name), student=name)])
    index = class_pages.index([], table, names=True)
    student, assignment = class_pages.student(table.rows[0]), class_pages.html(hostile(text))
    # A name may be broken at an underscore.
    made = tuple(Skeleton(one.replace("<wbr>", "")) for one in (index, student, assignment))
    assert one_line(name) in made[0].text and one_line(name) in made[1].text
    assert made[2].text.count(visible(text)) >= 3
    return made


@pytest.fixture(scope="module")
def harmless():
    return of_all_kinds("harmless")


@settings(max_examples=30)
@for_any_text
@pytest.mark.long
def test_no_text_makes_a_tag(harmless, text):
    if text:
        for mine, other in zip(of_all_kinds(text), harmless, strict=True):
            assert [tag for tag, _ in mine.tags] == [tag for tag, _ in other.tags]
        assert mine.tags == other.tags, "an assignment's page has no address of a name's either"


def test_a_title_is_text():
    title = "<b>Twice</b>"
    shown = replace(report(result(samples.PASSED), page="x"), title=title, assignment=title)
    index = class_pages.index([shown], pages.chart(), names=True)
    for page in (class_pages.html(shown), index):
        assert "<b>" not in page and title in Skeleton(page).text
