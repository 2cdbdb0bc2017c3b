"""The page's modules can be joined in one scope: unique names, plain imports and exports."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

JS = Path(__file__).resolve().parents[3] / "lib/robust_slam_course/canvas/js"
MODULES = sorted(JS.rglob("*.js"))
IMPORT = re.compile(r'import \{\s*\w+(?:,\s*\w+)*,?\s*\} from "(\.{1,2}/[\w./]+\.js)";')
DECLARED = re.compile(
    r"^(?:export )?(?:async )?(?:function\*?|const|let|var|class) +(\{[^}]*\}|\[[^\]]*\]|\w+)",
    re.M,
)


def code(path: Path) -> str:
    """A module's text without its comments."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"/\*.*?\*/|^\s*//.*?$", "", text, flags=re.S | re.M)


def names(path: Path) -> list[str]:
    """The names that a module declares at the start of a line."""
    return [name for found in DECLARED.findall(code(path)) for name in re.findall(r"\w+", found)]


def exported(path: Path) -> set[str]:
    return set(
        re.findall(r"^export (?:async )?(?:function\*?|const|class) (\w+)", code(path), re.M)
    )


def test_no_two_modules_declare_the_same_name() -> None:
    counts = Counter(name for path in MODULES for name in names(path) if name != "render")
    assert len(counts) > 50
    assert not [name for name, count in counts.items() if count > 1]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(JS)))
def test_imports_and_exports_have_the_form_that_the_bundler_reads(path: Path) -> None:
    text = code(path)
    imports = list(re.finditer(IMPORT, text))
    assert len(imports) == len(re.findall(r"^\s*import\b", text, re.M))
    assert "import(" not in text
    for match in imports:
        source = (path.parent / match[1]).resolve()
        listed = set(re.findall(r"\w+", match[0].split("}")[0].removeprefix("import")))
        assert listed <= exported(source), (match[1], listed - exported(source))
    every = re.findall(r"\bexport\b[^\n]*", text)
    assert all(
        re.match(r"export (?:async )?(?:function\*?|const|class) \w+", line) for line in every
    )

    # Else an import would have a side effect.
    starts = re.findall(r"^(?![\s})\]])(\S+)", text, re.M)
    assert set(starts) <= {"import", "export", "function", "const", "class", "async", "function*"}
