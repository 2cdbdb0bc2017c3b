"""What a student reads: plain sentences, the hint and no more."""

import itertools
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.grading.messages import NOT_WRITTEN
from robust_slam_autograder.markup import visible
from robust_slam_autograder.nbgrader import recording
from robust_slam_autograder.reading.assignment import Config
from robust_slam_autograder.reports import documents, feedback

from .. import toy
from ..test_markup import GITHUB, for_any_text
from . import samples
from .pages import SITE, Skeleton, page
from .samples import case, exercise, result

SEED = 20_261
# Tells what it was called with, wherever a message may come from.
TELLS = """\
def double(x):
    raise ValueError(f"<script>{np.asarray(x).tolist()}</script> [x](http://evil.example)")
"""


class TestWords:
    def test_each_status_has_a_meaning_and_all_but_passed_an_advice(self):
        shown = page(result(*samples.EVERY_STATUS))
        words = [each.outcome.split()[1] for each in shown.exercises]
        assert words == ["passed", "partial", "timeout", "died", "missing", "failed"]
        assert all(each.meaning.endswith(".") for each in shown.exercises)
        assert [bool(each.advice) for each in shown.exercises] == [False] + [True] * 5
        assert shown.start == shown.exercises[1]

    def test_a_case_has_a_word_its_points_and_its_message(self):
        (partly,) = page(result(samples.PARTLY)).exercises
        first, second = partly.cases
        assert (first.outcome, first.points, first.message) == ("✓ passed", "5 of 5 points", "")
        assert (second.outcome, second.points) == ("✗ failed", "0 of 5 points")
        assert second.message == "Add the ½."
        assert not first.other_inputs and second.other_inputs
        one = exercise("e", "passed", case("c", points=1))
        assert page(result(one)).exercises[0].points == "1 of 1 point"

    def test_a_message_is_told_once(self):
        (stub,) = page(result(samples.UNWRITTEN)).exercises
        told = [(each.message, each.as_above) for each in stub.cases]
        assert told == [("Not written.", False), ("", True)]
        assert stub.message == ""
        again = exercise("e", "failed", case("a", "x"), case("b", "y"), case("c", "x"))
        assert [c.as_above for c in page(result(again)).exercises[0].cases] == [False, False, True]
        (gone,) = page(result(samples.MISSING)).exercises
        assert gone.message == "No cell.", "no case says it"

    def test_what_is_as_it_was_released_is_not_written_and_was_not_tried_with_other_inputs(self):
        stub = exercise("stub", "failed", *(case(name, NOT_WRITTEN) for name in "ab"))
        (shown,) = page(result(stub)).exercises
        assert (shown.outcome, shown.meaning) == ("✗ not written", "Nothing is written here yet.")
        assert not any(each.other_inputs for each in shown.cases)

    def test_what_comes_after_a_fault_was_not_run(self):
        (hung,) = page(result(samples.HUNG)).exercises
        assert hung.meaning == "A call may work for 10 s, and a cell for 20 s."
        assert [(each.outcome, each.message, each.other_inputs) for each in hung.cases] == [
            ("✓ passed", "", True),
            ("✗ failed", samples.SLOW, True),
            ("✗ not run", "", False),
        ]

    def test_all_passed_is_said_where_hidden_checks_ran_alone(self):
        assert page(result(samples.PASSED)).verdict.startswith("All checks passed")
        shown = page(result(exercise("e", "passed", case("c", visible=True))))
        assert shown.verdict == "Public checks passed: 1 of 1 exercises."
        assert shown.exercises[0].meaning == "The public checks passed."
        assert "All" not in feedback.markdown(shown) + feedback.html(shown)

    def test_a_refusal_has_its_reason_and_the_remedy(self):
        shown = page(samples.refused("a.ipynb is not valid JSON: save it again."))
        assert shown.note == "a.ipynb is not valid JSON: save it again."
        assert (shown.note_kind, shown.score, shown.max_score) == ("Reason", 0, 20)
        assert "hand it in again" in shown.next

    def test_a_student_is_not_told_why_the_grader_failed(self):
        shown = page(samples.failed("The instructor's cell, set-up 1, fails: 0.1234."))
        assert "not to blame" in shown.verdict and "nothing" in shown.next
        assert "0.1234" not in feedback.html(shown) + feedback.markdown(shown)

    @pytest.mark.parametrize("render", [feedback.html, feedback.markdown])
    def test_seconds_and_sandbox_are_in_no_page(self, render):
        slow = result(*samples.EVERY_STATUS, seconds=1234.5, sandbox="bubblewrap")
        assert render(page(slow)) == render(page(replace(slow, seconds=0.25, sandbox="fork")))


class TestValues:
    """What a student's code returned, beside what a visible check expected."""

    def of(self, *curves: tuple[float, ...], text: str = "[0., 2., 0.]") -> feedback.ShownCase:
        (shown,) = page(result(exercise("e", "failed", samples.compared(text, *curves)))).exercises
        return shown.cases[0]

    def test_they_stand_in_a_table_and_once(self):
        shown = self.of()
        assert (shown.sentence, shown.curves) == ("Look at the sum.", None)
        assert shown.values.yours == "[0., 2., 0.]"
        failed = exercise("e", "failed", samples.compared("7"))
        text = Skeleton(feedback.html(page(result(failed)))).text
        assert "returned" not in text and text.count("It is NaN.") == 1
        assert "`  \n  `Here, f(3) returned 7" in feedback.markdown(page(result(failed)))

    def test_the_same_message_again_has_no_second_table(self):
        twice = exercise("e", "failed", samples.compared("7"), samples.compared("7"))
        (shown,) = page(result(twice)).exercises
        assert [c.values is None for c in shown.cases] == [False, True]

    def test_a_long_value_is_cut(self):
        failed = exercise("e", "failed", samples.compared("\x00" * 250))
        text = feedback.html(page(result(failed))).partition("</style>")[2].replace("<", " <")
        words = Skeleton(text).text.split()
        assert max(map(len, words)) == documents.MAX_SHOWN

    def test_rows_are_drawn_from_the_lowest_number_to_the_highest(self):
        drawn = self.of((1, 2, 3), (0, 2, 4)).curves
        height = feedback.CURVE
        assert drawn.yours == ((0, 0.75 * height), (50, 0.5 * height), (100, 0.25 * height))
        assert drawn.expected == ((0, height), (50, 0.5 * height), (100, 0))
        assert (drawn.lowest, drawn.highest) == ("0", "4")

    def test_equal_numbers_are_drawn_in_the_middle_and_endless_ranges_are_not(self):
        flat = self.of((2, 2, 2), (2, 2, 2)).curves
        assert {y for _, y in flat.yours} == {feedback.CURVE / 2}
        assert self.of((1e308, 0, 0), (-1e308, 0, 0)).curves is None

    def test_a_hidden_case_has_none(self):
        """Neither the command that grades nor the page has any: see also test_explain."""
        negative = "def double(x):\n    return abs(2 * np.asarray(x))\n"
        made = page(toy.graded(toy.answer(negative)))
        (random,) = [c for e in made.exercises for c in e.cases if c.name == "random"]
        assert random.message == "Try negative numbers." and random.values is None
        wrong = page(toy.graded(toy.answer("def double(x):\n    return 7\n")))
        assert next(c.values.yours for e in wrong.exercises for c in e.cases if c.values) == "7"


class TestChapter:
    """The way back to the book."""

    def test_with_a_site_it_is_a_link_to_the_section(self):
        shown = page(result(samples.PASSED, samples.PARTLY, samples.HUNG))
        base = f"{SITE}chapters/07-toy.html"
        section = feedback.Reading("chapter 07-toy, “Half, or no half”", f"{base}#half-or-no-half")
        assert [each.reading for each in shown.exercises] == [
            None,
            section,
            feedback.Reading("chapter 07-toy", base),
        ]
        assert f'href="{base}#half-or-no-half"' in feedback.html(shown)
        assert f"](<{base}#half-or-no-half>)" in feedback.markdown(shown)
        (partly,) = page(result(samples.PARTLY), site="../../html").exercises
        assert partly.reading.address == "../../html/chapters/07-toy.html#half-or-no-half"

    def test_without_a_site_it_is_a_name(self):
        shown = page(result(samples.PARTLY), site="")
        html = feedback.html(shown)
        assert "chapter 07-toy, “Half, or no half”" in html
        assert "href=" in html and "07-toy.html" not in html
        assert "](" not in feedback.markdown(shown)
        assert page(result(samples.PARTLY), Config()).exercises[0].reading is None


@pytest.fixture(scope="module")
def harmless():
    """The tags of a page, and the shape of its Markdown."""
    made = Skeleton(feedback.html(page(samples.told("harmless"))))
    return made.tags, markdown_shape("harmless")


class TestInjection:
    """Whatever a student writes, the page's structure is the same and the text is to be read."""

    @for_any_text
    def test_no_text_makes_a_tag_or_markdown(self, harmless, text):
        if text:
            shown = Skeleton(feedback.html(page(samples.told(text))))
            assert shown.tags == harmless[0]
            assert shown.text.count(visible(text)) >= 4
        if text.split():
            assert markdown_shape(text) == harmless[1]

    def test_markdown_has_the_chapters_links_and_no_others(self):
        text = feedback.markdown(page(samples.told(" ".join(samples.HOSTILE.values()))))
        children = [child for block in GITHUB.parse(text) for child in block.children or []]
        links = [child.attrs["href"] for child in children if child.type == "link_open"]
        assert links == [f"{SITE}chapters/07-toy.html"] * 2
        assert not any(child.type in ("html_inline", "image") for child in children)


def markdown_shape(text: str) -> list[str]:
    blocks = GITHUB.parse(feedback.markdown(page(samples.told(text))))
    return [token.type for block in blocks for token in (block, *(block.children or []))]


class TestCommand:
    @pytest.fixture(scope="class")
    def once(self, tmp_path_factory):
        """A folder with a source tree and results of three students, one of them hostile."""
        folder = tmp_path_factory.mktemp("once")
        settings = 'title = "Twice"\nchapter = "07-toy"\nwithheld = ["xml.dom"]\n'
        tree = toy.make_tree(folder, settings)
        abs_only = toy.answer("def double(x):\n    return 2 * abs(np.asarray(x))\n")
        answers = {"ada": toy.answer(), "ben": abs_only, "<b>cleo": toy.answer(TELLS)}
        paths = [toy.hand_in(folder / "in", name, value) for name, value in answers.items()]
        where = ["--out", folder / "graded", *toy.quickly(), "--seed", SEED]
        command = ["--solutions", tree, "grade", *where, *paths]
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(recording, "record_new", lambda *_: None)
            assert cli.main([*map(str, command)]) == 0
        return folder

    @pytest.fixture
    def graded(self, once, tmp_path):
        return Path(shutil.copytree(once, tmp_path, dirs_exist_ok=True))

    @pytest.fixture
    def run(self, graded, autograder):
        where = ("--out", graded / "graded", "--to", graded / "feedback")
        return lambda *arguments: autograder("feedback", *where, *arguments)

    def test_each_submission_has_two_files(self, graded, run):
        status, out, _ = run("--site", SITE)
        assert status == 0 and out.startswith("feedback on 3 submissions of 3 students: ")
        found = {path.relative_to(graded / "feedback") for path in graded.rglob("feedback/*/*")}
        names = itertools.product(("ada", "ben", "<b>cleo"), (".html", ".md"))
        assert found == {Path(student, toy.NAME + end) for student, end in names}
        text = (graded / "feedback" / "ben" / f"{toy.NAME}.md").read_text(encoding="utf-8")
        assert text.startswith("## Twice: 14 of 20 points\n\nStudent: `ben`\n")
        assert "(0 of 6 points, checked with other inputs too): `Try negative numbers.`" in text
        assert f"{SITE}chapters/07-toy.html" in text

    def test_a_student_may_be_named(self, graded, run):
        assert run("ada")[0] == 0
        assert [path.name for path in (graded / "feedback").iterdir()] == ["ada"]

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (["eve"], "holds no result of eve: grade that submission first"),
            (["--out", "nowhere"], "nowhere holds no result: grade first"),
            (["--site", "javascript:alert(1)"], "an address https://…, or a path"),
        ],
    )
    def test_wrong_use_names_the_remedy(self, graded, run, arguments, sentence):
        assert run(*arguments).refused(sentence)
        assert not (graded / "feedback").exists()
