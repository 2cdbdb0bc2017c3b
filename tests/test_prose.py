"""What `make check` finds in the course's language."""

import json
from pathlib import Path

import pytest

from tools.prose import check, text

PAGE = """\
# A page

Text with `lie` as code, $honest$ as a formula, {cite:p}`crowd2020` and
[an address](https://example.org/crowd).

```python
crowd = friends
```

:::{dropdown} A title
:open:
%s
:::
"""


def course(root: Path, text: str, module: str = "") -> list[str]:
    """The findings in a course of one page, one notebook and one module, which hold a text."""
    cells = [
        {"id": "read", "cell_type": "markdown", "source": [text], "metadata": {}},
        {"id": "run", "cell_type": "code", "source": ["crowd = 0"], "metadata": {}},
    ]
    (root / "chapters").mkdir()
    (root / "lib").mkdir()
    (root / "chapters" / "page.md").write_text(PAGE % text, "utf-8")
    (root / "chapters" / "notebook.ipynb").write_text(json.dumps({"cells": cells}), "utf-8")
    (root / "lib" / "module.py").write_text(module, "utf-8")
    return list(check.findings(root))


def test_what_is_no_prose_is_not_read(tmp_path):
    assert course(tmp_path, "One measurement is an outlier.", "crowd = {'friends': 0}\n") == []


def test_a_planted_word_is_found_with_its_place(tmp_path):
    assert course(tmp_path, "Least squares follows the lie.") == [
        "chapters/notebook.ipynb:read:1: words: 'lie'; "
        "write: outlier, wrong closure; of a place: is",
        "chapters/page.md:12: words: 'lie'; write: outlier, wrong closure; of a place: is",
    ]


@pytest.mark.parametrize(
    "planted",
    [
        "Such a map is\nnone.",
        "Friends agree",
        "dear",
        "the strides",
        "She believed it",
        "optimize",
    ],
)
def test_forms_phrases_and_broken_lines_are_found(planted):
    (found,) = check.by_the_list(text.Piece("here", 1, planted))
    assert found.startswith("here:1: words: ")


@pytest.mark.parametrize("planted", ["A Lie group", "if there\nis none", "One lie folds the map"])
def test_allowed_phrases_stand(planted):
    assert list(check.by_the_list(text.Piece("here", 1, planted))) == []


def test_a_planted_fault_is_found_by_the_linter(tmp_path):
    found = course(tmp_path, "The rest is completely full, and very unique.")
    assert [line.split(": ")[1] for line in found if "page.md:12" in line] == [
        "redundancy.misc.garner",
        "uncomparables",
        "weasel_words.very",
    ]
    assert len(found) == 6


@pytest.mark.parametrize(
    "module",
    [
        '"""A honest module."""\n',
        "x = 0  # a timid start\n",
        "# A first step that is timid\n# ends early.\n",
        'raise ValueError(f"{x} believes two")\n',
    ],
)
def test_docstrings_comments_and_messages_are_read(tmp_path, module):
    (found,) = course(tmp_path, "A page.", module)
    assert found.startswith("lib/module.py:1: words: ")


def test_captions_and_alternative_texts_are_read_and_lines_keep_their_numbers():
    shown = {"figure": {"caption": "A lie."}, "image": {"alt": "A map."}}
    cell = {"cell_type": "code", "source": "draw()", "metadata": {"mystnb": shown}}
    assert [*text.read_by_people(cell)] == ["A lie.", "A map."]
    for path in check.ROOT.glob("chapters/*.md"):
        page = path.read_text("utf-8")
        assert text.markdown(page).count("\n") == page.count("\n"), path
