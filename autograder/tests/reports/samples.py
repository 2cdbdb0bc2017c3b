"""Results and hostile texts for the tests of what students read."""

from typing import Any

from robust_slam_autograder.grading.explain import HERE
from robust_slam_autograder.grading.results import (
    CaseResult,
    Compared,
    Ending,
    ExerciseResult,
    ExerciseStatus,
    Result,
    Words,
    without_grade,
)

HOSTILE = {
    "a script": "<script>document.title = 'taken'</script>",
    "a picture": "<img src=http://127.0.0.1:9/x.png onerror=alert(1)>",
    "the end of a span": '</bdi></p></main><style>*{display:none}</style>"><!--',
    "a template": "{{ page }} {% raw %} ${x}",
    "a link": "](http://evil.example) [x](http://evil.example) ![y](http://evil.example/y.png)",
    "an address": "https://evil.example www.evil.example a@b.example <http://evil.example>",
    "a reference": "[x][y]\n\n[y]: http://evil.example\n[^1]",
    "a mention": "@everyone #1 GH-1 owner/name@0123456",
    "fences": "`` ` ```\n```html\n<b>x</b>\n```",
    "a fence at the end": "x`",
    "a fence at the start": "`x",
    "a bar": "a | b \\| c\\\\| d",
    "blocks": "a\n\n# b\n\n- c\n\n    d\n> e\n\n---\n| f |\n| --- |",
    "entities": "&lt;b&gt; &#64;everyone &commat;",
    "escapes": "\x1b]8;;http://evil.example\x07x\x1b[31m\x00\x7f\x9b",
    "a change of direction": "\u202egnp.exe\u2066\u200f",
    "right to left": "مرحبا שלום",
    "no width": "a\u200bb\ufeffc\u00add",
    "half a character": "\ud800",
    "line ends": "a\r\nb\rc\u2028d\u2029e\x85f\x0bg",
    "a long word": "W" * 10_000,
    "heaps of accents": "a" + "\u0301" * 500,
    "nothing": "   ",
}


def case(
    name: str, message: str = "", ending: Ending | None = None, *, points: int = 5, **fields: Any
) -> CaseResult:
    """A case that failed if it has a message."""
    ending = ending or (Ending.FAILED if message else Ending.PASSED)
    earned = points if ending is Ending.PASSED else 0
    values: dict[str, Any] = {"visible": False, **fields}
    return CaseResult(name, points, earned, ending=ending, message=message, **values)


def exercise(
    name: str, status: ExerciseStatus, *cases: CaseResult, message: str | None = None
) -> ExerciseResult:
    """An exercise of these cases; its message is the first of theirs."""
    score = sum(each.earned for each in cases)
    most = sum(each.points for each in cases)
    first = next((each.message for each in cases if each.message), "")
    return ExerciseResult(name, score, most, status, first if message is None else message, cases)


def result(*exercises: ExerciseResult, student: str = "ada", **fields: Any) -> Result:
    score = sum(each.score for each in exercises)
    most = sum(each.max_score for each in exercises)
    usual: dict[str, Any] = {"reason": "", "sandbox": "none", "seconds": 0.25, **fields}
    return Result(student, "07-toy", score, most, "graded", exercises=exercises, **usual)


def refused(reason: str, *, student: str = "ada") -> Result:
    return without_grade("refused", reason, student=student, assignment="07-toy", max_score=20)


def failed(reason: str, *, student: str = "ada") -> Result:
    return without_grade("failed", reason, student=student, assignment="07-toy", max_score=20)


PASSED = exercise("double", "passed", case("by-hand", visible=True), case("random"))
PARTLY = exercise("apply", "partial", case("by-hand", visible=True), case("twice", "Add the ½."))
SLOW = "Your code ran longer than it may; the rest of this exercise was not run."
SLOW_CASES = [case(name, SLOW, Ending.TIMEOUT) for name in ("second", "third")]
HUNG = exercise("loop", "timeout", case("first"), *SLOW_CASES)
DIED = exercise("exit", "died", case("first", "It ended.", Ending.DIED))
MISSING = exercise("gone", "missing", case("first", "gone is not defined."), message="No cell.")
UNWRITTEN = exercise("stub", "failed", case("first", "Not written."), case("next", "Not written."))
EVERY_STATUS = (PASSED, PARTLY, HUNG, DIED, MISSING, UNWRITTEN)


def compared(text: str, *curves: tuple[float, ...]) -> CaseResult:
    """A visible case that failed, with this text wherever a student's own may stand."""
    values = Compared(text, text, "expected less than", text, "It is NaN.", curves)
    said = "Look at the sum."
    message = f"{said}\n{HERE}f(3) returned {text}; expected less than {text}."
    return case("by-hand", message, visible=True, gist=said, compared=values)


def raised(name: str, error: str, **fields: Any) -> CaseResult:
    """A case whose function raised ``Type: words``."""
    kind = error.partition(":")[0]
    gist, message = (f"Your function raised {text}." for text in (kind, error))
    return case(name, message, words=Words.STUDENT, gist=gist, raised=kind, **fields)


def told(text: str) -> Result:
    """A result that holds a text wherever a student's own may stand."""
    seen = compared(text, (1.0, 2.0, 3.0), (0.0, 2.0, 4.0))
    wrong = exercise("double", "failed", case("by-hand", text), case("random", "x" + text), seen)
    gone = exercise("gone", "missing", case("first", "gone is not defined."), message=text)
    return result(wrong, gone, student=text, reason=text)
