"""A quiz answers every option, marks the right ones, and is plain HTML."""

import pytest
from bs4 import BeautifulSoup
from robust_slam_course.quiz import Option, Question, Quiz

RIGHT = Option("Huber", "Its pull is $k$, for ever.", correct=True)
WRONG = Option("TLS", "It lets go at $|u| > c$.")


def read(quiz: Quiz) -> BeautifulSoup:
    return BeautifulSoup(quiz.html(), "html.parser")


def test_every_option_says_whether_it_is_right_which_several_may_be():
    page = read(Quiz([Question("Which one?", [RIGHT, WRONG])]))
    assert [label.get_text().strip() for label in page("label")] == ["A Huber", "B TLS"]
    right, wrong = (answer.get_text() for answer in page(role="status"))
    assert right.startswith("✓ Right. Its pull is")
    assert wrong.startswith("✗ No. It lets go at")
    both = Question("Which?", [RIGHT, Option("Square", "So does it.", correct=True)])
    assert Quiz([both]).html().count("✓ Right.") == 2


def test_a_question_keeps_its_key_until_its_texts_change():
    def key(question: Question) -> str:
        return str(read(Quiz([question])).find(attrs={"data-question": True})["data-question"])

    one = Question("Which one?", [RIGHT, WRONG])
    explained = Question("Which one?", [RIGHT, Option("TLS", "It is bounded.")])
    assert key(one) == key(explained)
    assert key(one) != key(Question("Which two?", [RIGHT, WRONG]))
    assert key(one) != key(Question("Which one?", [WRONG, RIGHT]))


def test_math_stands_where_mathjax_looks_text_is_no_markup_and_emphasis_is_outside_of_math():
    page = read(Quiz([Question("Is $a<b$ & c?", [RIGHT, WRONG])]))
    assert page.legend.get_text() == r"Is \(a<b\) & c?"
    assert page.legend.find(class_="math").get_text() == r"\(a<b\)"
    assert "<script>" not in Quiz([Question("<script>", [RIGHT, WRONG])]).html()
    html = Quiz([Question("Is *Huber's* `f's` or $a*b's*c$?", [RIGHT, WRONG])]).html()
    assert r"<em>Huber's</em> <code>f's</code>" in html
    assert r"\(a*b's*c\)" in html
    assert "Huber’s" in Quiz([Question("Is it Huber's?", [RIGHT, WRONG])]).html()


def test_a_notebook_shows_html_that_needs_no_script_and_no_address():
    quiz = Quiz([Question("Which one?", [RIGHT, WRONG])])
    html = quiz.html()
    assert "<script" not in html and "http" not in html
    assert quiz._repr_mimebundle_() == {"text/plain": "Quiz: Which one?", "text/html": html}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Option("Cauchy", ""), "answer to 'Cauchy'"),
        (lambda: Option("Cauchy", "  \n"), "answer to 'Cauchy'"),
        (lambda: Question("Which one?", [WRONG, WRONG]), "correct=True"),
        (lambda: Question("Which one?", [RIGHT]), "options"),
        (lambda: Question(" ", [RIGHT, WRONG]), "prompt"),
        (lambda: Quiz([]), "questions"),
    ],
)
def test_what_is_no_quiz_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
