"""A quiz in which every option has an answer of its own.

A question is a group of radio buttons. Choosing one shows, at that option, whether it is right and
why. This is the style sheet's work: it needs no script, and a screen reader announces the answer.
A letter names each option, for a class that speaks of it and for readers who cannot read a formula
aloud. Text is plain, with $math$, *emphasis* and `code`.

A picture asks one such question at its head, a prediction, which folds when it is answered.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from html import escape
from string import ascii_uppercase

from robust_slam_course.style import variables

# JupyterLab leaves the keys to an element that carries this attribute.
_KEYS = 'data-lm-suppress-shortcuts="true"'
_MARKED = re.compile(
    r"\$(?P<math>[^$]+)\$|`(?P<code>[^`]+)`|\*(?P<em>[^*]+)\*|(?P<apostrophe>(?<=\w)'(?=[a-z]\b))"
)

_STYLE = (
    f":where(html) {{ {variables('light')} }}"
    + """
.rs-quiz fieldset {
  margin: 0.5rem 0; padding: 0.5rem 1rem 0.75rem; border-radius: 0.5rem; min-width: 0;
  border: 1px solid color-mix(in srgb, currentColor 30%, transparent);
}
.rs-quiz legend {
  float: left; width: 100%; margin: 0 0 0.5rem; padding: 0; font-size: inherit; font-weight: 600;
}
.rs-quiz .rs-option {
  clear: both; margin: 0.4rem 0 0; padding: 0 0.75rem; border-radius: 0.3rem;
  border: 1px solid color-mix(in srgb, currentColor 20%, transparent);
}
.rs-quiz .rs-option:has(:checked) { border-color: currentColor; }
.rs-quiz .rs-option:has(:focus-visible) {
  outline: 3px solid var(--rs-estimate); box-shadow: 0 0 0 2px #fff;
}
.rs-quiz label {
  display: flex; gap: 0.6rem; align-items: baseline; margin: 0; padding: 0.35rem 0;
  cursor: pointer;
}
.rs-quiz label span { min-width: 0; }
.rs-quiz input { flex: none; margin: 0; accent-color: var(--rs-estimate); }
.rs-quiz [role="status"] p {
  display: none; margin: 0 0 0.5rem; padding-left: 0.75rem;
  border-left: 4px solid var(--rs-outlier);
}
.rs-quiz [role="status"] p.rs-correct { border-left-color: var(--rs-inlier); }
.rs-quiz label:has(:checked) + [role="status"] p { display: block; }
@media print {
  .rs-quiz fieldset { break-inside: avoid; }
  .rs-quiz .rs-option [role="status"] { display: none; }
  .rs-quiz .rs-option:has(:checked) { border-color: #ccc; }
  .rs-quiz input {
    appearance: none; width: 0.8em; height: 0.8em; border: 1px solid; border-radius: 50%;
  }
}
"""
)


@dataclass(frozen=True)
class Option:
    """A choice, the response to it, and whether it is right.

    Raises:
        ValueError: `text` or `answer` is empty.
    """

    text: str
    answer: str
    correct: bool = False

    def __post_init__(self) -> None:
        check_text("text", self.text)
        check_text(f"answer to {self.text!r}", self.answer)


@dataclass(frozen=True)
class Question:
    """A prompt with at least two options, of which one or several are right.

    Raises:
        ValueError: the prompt is empty, there are fewer than two options, or none is right.
    """

    prompt: str
    options: Sequence[Option]

    def __post_init__(self) -> None:
        check_text("prompt", self.prompt)
        if len(self.options) < 2:
            raise ValueError(f"options: {self.prompt!r} has {len(self.options)}; give it two.")
        if not any(option.correct for option in self.options):
            raise ValueError(f"options: none for {self.prompt!r} is right; mark one correct=True.")


def ask(prompt: str, answers: Mapping[str, str], right: str) -> Question:
    """Return a question with one right option; ``answers`` are by the options' texts.

    Raises:
        ValueError: as ``Option`` and ``Question``.
    """
    return Question(prompt, [Option(text, why, text == right) for text, why in answers.items()])


@dataclass(frozen=True)
class Quiz:
    """Questions that show themselves in a notebook and on a page.

    Raises:
        ValueError: there are no questions.
    """

    questions: Sequence[Question]

    def __post_init__(self) -> None:
        if not self.questions:
            raise ValueError("questions: empty; a quiz needs at least one question.")

    def html(self) -> str:
        """Return the quiz as HTML that needs no script; math is in TeX's inline brackets."""
        questions = "".join(map(_question, self.questions))
        return f'<div class="rs-quiz"><style>{_STYLE}</style>{questions}</div>'

    def _repr_mimebundle_(self, **_: object) -> dict[str, str]:
        prompts = " ".join(question.prompt for question in self.questions)
        return {"text/plain": f"Quiz: {prompts}", "text/html": self.html()}


def _question(question: Question) -> str:
    options = "".join(map(_option, ascii_uppercase, question.options))
    # A form of its own keeps the choice apart from that of every other question, also where the
    # same output is shown twice. Outside a dialog the method "dialog" submits nothing on Enter.
    return (
        f'<form method="dialog" data-question="{_key(question)}">'
        f"<fieldset><legend>{_inline(question.prompt)}</legend>{options}</fieldset></form>"
    )


def _key(question: Question) -> str:
    """Return a name under which a choice is remembered; a question that changes gets another."""
    texts = [question.prompt, *(option.text for option in question.options)]
    return sha256("\n".join(texts).encode()).hexdigest()[:12]


def _option(letter: str, option: Option) -> str:
    verdict, kind = ("✓ Right.", "rs-correct") if option.correct else ("✗ No.", "rs-incorrect")
    return (
        '<div class="rs-option"><label>'
        f'<input type="radio" name="choice" {_KEYS} value="{letter}">'
        f" <span><b>{letter}</b> {_inline(option.text)}</span></label>"
        f'<div role="status"><p class="{kind}"><strong>{verdict}</strong> '
        f"{_inline(option.answer)}</p></div></div>"
    )


def prediction(question: Question) -> str:
    """Return a question with one right answer as a row of buttons that folds to the answer.

    An option's answer begins with "✓ Right: 7." or "✗ You chose 3. The answer is 7." It needs no
    script, only ``canvas/prediction.css``; a live picture has the form wait (``data-waits``) until
    the reader has found the answer by hand. The buttons are check boxes, each of which Tab
    reaches: arrow keys between radio buttons would answer while the reader looks.

    Raises:
        ValueError: there are more than four options, or several are right.
    """
    if len(question.options) > 4 or sum(option.correct for option in question.options) > 1:
        raise ValueError(f"options: {question.prompt!r} needs two to four, of which one is right.")
    (right,) = (option for option in question.options if option.correct)
    letters = dict(zip(ascii_uppercase, question.options, strict=False))
    buttons = [_button(letter, option.text) for letter, option in letters.items()]
    answers = [_revealed(letter, option, right) for letter, option in letters.items()]
    return (
        f'<form class="rs-predict" method="dialog" data-question="{_key(question)}"><fieldset>'
        f"<legend><strong>Predict:</strong> {_inline(question.prompt)}</legend>"
        f'<div class="rs-choices">{"".join(buttons)}</div>'
        f'<div role="status">{"".join(answers)}</div>'
        "</fieldset></form>"
    )


def _button(letter: str, text: str) -> str:
    box = f'<input type="checkbox" name="choice" {_KEYS} value="{letter}">'
    return f"<label>{box}<span>{_inline(text)}</span></label>"


def _revealed(letter: str, chosen: Option, right: Option) -> str:
    mine, truth = f"<b>{_inline(chosen.text)}</b>.", f"<b>{_inline(right.text)}</b>."
    opening = "✓ Right:" if chosen is right else "The answer is"
    wrong = "" if chosen is right else f'<span class="is-wrong">✗ You chose {mine}</span> '
    return (
        f'<p class="rs-now" data-choice="{letter}">You chose {mine} Find out below, or</p>'
        f'<p data-choice="{letter}">{wrong}<span class="is-right">{opening} {truth}</span>'
        f" {_inline(chosen.answer)}</p>"
    )


def _inline(text: str) -> str:
    """Return the text as HTML; math gets the class by which it is found and drawn."""
    return _MARKED.sub(_element, escape(text, quote=False))


def _element(marked: re.Match[str]) -> str:
    kind, text = str(marked.lastgroup), marked[str(marked.lastgroup)]
    if kind == "apostrophe":
        return "’"
    if kind == "math":
        return rf'<span class="math notranslate nohighlight">\({text}\)</span>'
    return f"<{kind}>{text}</{kind}>"


def check_text(argument: str, text: str) -> None:
    """Check that there is something to read, or to hear for those who do not see a page.

    Raises:
        ValueError: there is not.
    """
    if not text.strip():
        raise ValueError(f"{argument}: empty; write a sentence.")
