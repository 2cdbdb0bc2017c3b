"""Print the manual's page of a chapter, or an exam: ``python -m solutions.manual 05 --seed 7``.

An exam takes the questions of several chapters or some of them, as in ``--exam 03 05.2 08.1``, and
with ``--html`` it is a page for the printer.

The page of a chapter is ``05.md`` beside this module. Its goals come from the chapter, what
students get wrong from the labelled answers, and the numbers of the exam from the seed: below
the heading of each question a block of TOML has the values to ``draw`` from, the formulas of the
answer ``by_hand``, and how the ``library`` solves it, which ``tests/assignments/test_manual.py``
compares.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from markdown_it import MarkdownIt
from robust_slam_autograder.reading.labelled import files, read

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FIELD = re.compile(r"<<(\w+)(?::([^>]+))?>>")
QUESTION = re.compile(
    r"^(### .+?)\n\n```toml\n(.+?)```\n(.+?)(?=^### |\Z)", re.DOTALL | re.MULTILINE
)
PAPER = """<!DOCTYPE html>
<html lang="en"><meta charset="utf-8"><title>Exam</title>
<style>
body { font: 11pt/1.45 Georgia, serif; max-width: 17cm; margin: auto; }
section { break-inside: avoid; padding-bottom: 6cm; }
h2 { font-size: 12pt; }
</style>
"""
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
    (folder,) = (ROOT / "solutions/answers").glob(f"{chapter}-*")
    found = [answer for path in files(folder) for answer in read(path)]
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


def chosen(names: Iterable[str], seed: int) -> list[Question]:
    """Return questions by their names: all of a chapter by "05", and its second by "05.2".

    Raises:
        ValueError: there is no such question.
    """
    questions = []
    for name in names:
        chapter, _, number = name.partition(".")
        if not (HERE / f"{chapter}.md").is_file() or number not in {"", "1", "2", "3"}:
            raise ValueError(f"there is no {name}; give a chapter, 00 to 09, or a question, 05.2")
        whole = exam(chapter, seed)
        questions += [whole[int(number) - 1]] if number else whole
    return questions


def sheet(names: Iterable[str], seed: int) -> str:
    """Return an exam for students, without answers and marks, numbered anew."""
    questions = chosen(names, seed)
    titles = [each.title.partition(". ")[2] for each in questions]
    total = sum(int(points) for title in titles for points in re.findall(r"\((\d) points", title))
    asked = (
        f"## {number}. {title}\n\n{question.filled.partition('**Answer.**')[0].strip()}\n"
        for number, (title, question) in enumerate(zip(titles, questions, strict=True), 1)
    )
    head = f"# Exam, variant {seed}\n\nName: {'_' * 40} Points: ____ of {total}\n\n"
    return head + "\n".join(asked)


def printed(text: str) -> str:
    """Return an exam as a page for the printer, with room to write below each question."""
    html = MarkdownIt().enable("table").render(text)
    return PAPER + re.sub(r"(?s)(<h2>.*?)(?=<h2>|\Z)", r"<section>\1</section>\n", html)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m solutions.manual", description=__doc__)
    parser.add_argument("names", nargs="+", help="a chapter, such as 05, or a question, 05.2")
    parser.add_argument("--seed", type=int, default=0, help="of the exam's variant")
    parser.add_argument("--exam", action="store_true", help="the questions, without answers")
    parser.add_argument("--html", action="store_true", help="an exam as a page for the printer")
    args = parser.parse_args()
    if args.seed < 0:
        parser.error(f"the seed {args.seed} is negative; give 0 or more")
    try:
        if args.exam or args.html:
            text = sheet(args.names, args.seed)
            print(printed(text) if args.html else text, end="")
        elif all(len(name) == 2 for name in args.names) and chosen(args.names, args.seed):
            print("\n".join(page(name, args.seed) for name in args.names), end="")
        else:
            parser.error(f"a page has a whole chapter; give --exam with {' '.join(args.names)}")
    except ValueError as error:
        parser.error(str(error))
