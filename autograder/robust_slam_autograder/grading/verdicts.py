"""What a status means and what to do about it, in words for students."""

from collections.abc import Mapping, Sequence

from robust_slam_autograder.grading.messages import NOT_WRITTEN
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.reading.assignment import Limits

MEANINGS: Mapping[str, str] = {
    "passed": "Every check passed.",
    "partial": "Some cases passed and some did not.",
    "failed": "No case passed.",
    "missing": "The notebook holds no answer to this exercise.",
    "not written": "Nothing is written here yet.",
    "timeout": "A call may work for {0.call_seconds:g} s, and a cell for {0.cell_seconds:g} s.",
    "died": "Your code ended the whole Python process.",
}

ADVICE: Mapping[str, str] = {
    "passed": "",
    "partial": "Look at the first failed case: its message says where to look.",
    "failed": (
        "Begin with the first case: its message says where to look. Then try it by hand, "
        "with small numbers."
    ),
    "not written": "Replace the line that raises NotImplementedError with your code.",
    "missing": (
        "Define its functions in a cell of your own, under the names that the exercise gives them."
    ),
    "timeout": (
        "Call your function with a small input. Look for a loop that never ends, "
        "and for a step that is repeated more often than it needs to be."
    ),
    "died": "Look for exit() or quit(), endless recursion, or arrays too large for the memory.",
}

FAULTS: Sequence[str] = ("timeout", "died")
SIGNS: Mapping[str, str] = {"passed": "✓", "partial": "◐"}


def sign(status: str) -> str:
    """Return a status with its sign: ✓ for "passed" alone, ◐ for what is right in part."""
    return f"{SIGNS.get(status, '✗')} {status}"


def outcome(exercise: ExerciseResult) -> str:
    """Return an exercise's status, or "not written" where its cell is as it was released."""
    is_stub = all(case.message == NOT_WRITTEN for case in exercise.cases)
    return "not written" if exercise.status == "failed" and is_stub else exercise.status


def meaning(exercise: ExerciseResult, limits: Limits) -> str:
    """Say what an exercise's outcome means."""
    if exercise.status == "passed" and not has_hidden([exercise]):
        return "The public checks passed."
    return MEANINGS[outcome(exercise)].format(limits)


def verdict(result: Result) -> str:
    """Say in one sentence how a submission did."""
    if result.status == "refused":
        return "Not graded."
    if result.status == "failed":
        return "Not graded: the grader itself failed. Your code is not to blame."
    passed = sum(exercise.status == "passed" for exercise in result.exercises)
    count = f"{passed} of {len(result.exercises)} exercises"
    full = passed == len(result.exercises)
    if not has_hidden(result.exercises):
        return f"{'Public checks passed' if full else 'Not all public checks passed'}: {count}."
    return f"All checks passed: {count}." if full else f"Passed: {count}."


def check_verdict(result: Result, hidden: Mapping[str, int] | None) -> str:
    """Say how a student's own check went; it promises no mark.

    Of each exercise it is told how many hidden cases there are; None where that is not known.
    """
    passed = sum(exercise.status == "passed" for exercise in result.exercises)
    total = len(result.exercises)
    said = "All visible cases passed"
    if passed < total:
        said = f"Visible cases passed in {passed} of {total} exercises"
    left = None if hidden is None else sum(hidden.values())
    return f"{said}; {remaining(left)} when it is graded."


def remaining(hidden: int | None) -> str:
    """Say how many hidden cases remain; None where their number is not known."""
    if hidden is None:
        return "hidden cases remain"
    cases = "hidden case remains" if hidden == 1 else "hidden cases remain"
    return f"{hidden or 'no'} {cases}"


def losses(result: Result) -> list[str]:
    """Name the exercises that lost marks, with what ended the code of one."""
    lost = (exercise for exercise in result.exercises if exercise.status != "passed")
    return [e.name + f" ({e.status})" * (e.status in FAULTS) for e in lost]


def failed_cases(exercise: ExerciseResult) -> list[str]:
    """Return names of the cases to look at; none where another status says it all."""
    if exercise.status not in ("partial", "failed"):
        return []
    return [case.name for case in exercise.cases if not case.passed]


def has_hidden(exercises: Sequence[ExerciseResult]) -> bool:
    """Tell whether more was run than students can see: else no more than "public" may be said."""
    return not all(case.visible for exercise in exercises for case in exercise.cases)
