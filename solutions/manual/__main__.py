"""Print the manual's page of a chapter, or its exam: ``python -m solutions.manual 05 --seed 7``.

The page is ``05.md`` beside this module. Its goals come from the chapter, what students get wrong
from the labelled answers, and the numbers of the exam from the seed: below the heading of each
question a block of TOML has the values to ``draw`` from, the formulas of the answer ``by_hand``,
and how the ``library`` solves it, which ``tests/assignments/test_manual.py`` compares.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from robust_slam_autograder.reading.labelled import is_of_answers, read

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FIELD = re.compile(r"<<(\w+)(?::([^>]+))?>>")
QUESTION = re.compile(
    r"^(### .+?)\n\n```toml\n(.+?)```\n(.+?)(?=^### |\Z)", re.DOTALL | re.MULTILINE
)
_MATHS = vars(math) | {"round": round}


@dataclass(frozen=True)
class Question:
    """One question of an exam, in one variant."""

    title: str
    text: str
    """What is asked, and from ``**Answer.**`` on the answer and the marks."""
    values: Mapping[str, Any]
    """The numbers that were drawn, and those of the answer by hand."""
    library: Mapping[str, str]
    """Expressions, each of which may use the values and the names before it."""

    @property
    def filled(self) -> str:
        """Return the whole text with the numbers in it."""
        return FIELD.sub(lambda field: self._shown(field[1], field[2] or ""), self.text)

    def _shown(self, name: str, spec: str) -> str:
        value = self.values[name]
        if isinstance(value, str):
            return value
        text = (
            ", ".join(map("{:g}".format, value)) if isinstance(value, list) else f"{value:{spec}}"
        )
        return text.replace("-", "−")


def exam(chapter: str, seed: int) -> list[Question]:
    """Return the three questions of a chapter's exam, in the variant of a seed."""
    text = (HERE / f"{chapter}.md").read_text(encoding="utf-8")
    made = []
    for number, found in enumerate(QUESTION.finditer(text)):
        table = tomllib.loads(found[2])
        rng = np.random.default_rng([seed, int(chapter), number])
        values = {k: of[rng.integers(len(of))] for k, of in table["draw"].items()}
        for name, formula in table["by_hand"].items():
            values[name] = eval(formula, _MATHS | values)
        made.append(Question(found[1], found[3].strip(), values, table["library"]))
    return made


def goals(chapter: str) -> str:
    """Return the list that follows *After this chapter you can* in a chapter."""
    (path,) = (ROOT / "chapters").glob(f"{chapter}-*.ipynb")
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    text = "\n\n".join("".join(cell["source"]) for cell in cells)
    return text.partition("After this chapter you can\n\n")[2].partition("\n\n")[0]


def misconceptions(chapter: str) -> str:
    """Return the misconceptions that only a chapter's hidden checks find, by exercise."""
    (folder,) = (ROOT / "tests/assignments").glob(f"{chapter}-*")
    paths = (path for path in sorted(folder.glob("*.toml")) if is_of_answers(path))
    found = [answer for path in paths for answer in read(path)]
    hidden = [answer for answer in found if not answer.is_right and not answer.is_visible]
    return "\n\n".join(
        f"`{exercise}`\n\n" + "\n".join(f"- {answer.story}" for answer in answers)
        for exercise, answers in groupby(hidden, key=lambda answer: answer.exercise)
    )


def page(chapter: str, seed: int) -> str:
    """Return the whole page of a chapter, for the teacher."""
    text = (HERE / f"{chapter}.md").read_text(encoding="utf-8").partition("## Exam\n")[0]
    text = text.replace("<<goals>>", goals(chapter)).replace("<<wrong>>", misconceptions(chapter))
    questions = (f"{each.title}\n\n{each.filled}\n" for each in exam(chapter, seed))
    return f"{text}## Exam, variant {seed}\n\n" + "\n".join(questions)


def sheet(chapter: str, seed: int) -> str:
    """Return the exam of a chapter for students, without answers and marks."""
    asked = (f"{q.title}\n\n{q.filled.partition('**Answer.**')[0]}" for q in exam(chapter, seed))
    return f"## Exam on chapter {chapter}, variant {seed}\n\n" + "".join(asked).strip() + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m solutions.manual", description=__doc__)
    parser.add_argument("chapter", help="its number, such as 05")
    parser.add_argument("--seed", type=int, default=0, help="of the exam's variant")
    parser.add_argument("--sheet", action="store_true", help="the exam alone, without answers")
    asked = parser.parse_args()
    if not (HERE / f"{asked.chapter}.md").is_file():
        parser.error(f"there is no page {asked.chapter}; give a chapter from 00 to 09")
    if asked.seed < 0:
        parser.error(f"the seed {asked.seed} is negative; give 0 or more")
    print((sheet if asked.sheet else page)(asked.chapter, asked.seed), end="")
