"""Result files of schema 1, which do not tell how a case ended: it follows from the messages.

The sentences are those of the graders that wrote such files; no other module reads them.
"""

import re
from typing import Any

_HERE = "\nHere, "
_QUOTING = re.compile(
    r"(?:Your function raised |Your cell stops with |The check could not use what came back: )"
    r"(?P<raised>\w+)"
    r"|What your function returned cannot be checked"
    r"|A cell of your own ran longer than it may, or ended the process, and is left out"
)
_OF_THE_GRADER = re.compile(
    r"Not written yet: |A check of this case did not pass\.$|A hidden check of this case did"
    r"|Your code (?:ran longer than it may|ended its whole process); "
    r"|\w+ is not defined in your notebook, or is nothing"
)


def upgraded(exercise: dict[str, Any]) -> dict[str, Any]:
    """Return an exercise of a result file as schema 2 has it."""
    return {**exercise, "cases": [_case(case, exercise) for case in exercise["cases"]]}


def _case(case: dict[str, Any], exercise: dict[str, Any]) -> dict[str, Any]:
    message = case["message"]
    stopped = exercise["status"] in ("timeout", "died") and message == exercise["message"]
    ending = exercise["status"] if stopped else "failed"
    return {**case, "ending": ending if message else "passed", **_told(message)}


def _told(message: str) -> dict[str, str]:
    if quoting := _QUOTING.match(message):
        raised = quoting["raised"] or ""
        return {"words": "student", "gist": f"{quoting[0]}.", "raised": raised}
    words = "grader" if _OF_THE_GRADER.match(message) else "check"
    gist, here, _ = message.partition(_HERE)
    return {"words": words, "gist": gist if here else ""}
