"""Sample pages of the grader: on the site where they are made, and nothing of them elsewhere."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from chapters._ext.offers import REPORT, SAMPLES, SAMPLES_SOURCE, thumbnail

pytestmark = pytest.mark.rest

ROOT = Path(__file__).parents[2]
SETTINGS = """\
extensions = ["myst_parser", "chapters._ext.offers"]
root_doc = "chapters/teach"
myst_enable_extensions = ["attrs_inline"]
"""
HEAT = """\
<table class="heat"><thead><tr><th>Student</th></tr></thead><tbody>
<tr><th>one</th><td>50 %</td><td class="all first">10</td><td class="zero">0</td>
<td class="some first">3</td></tr>
<tr><th>two</th><td>9 %</td><td class="unmarked first" title="refused">-</td>
<td class="most">7</td><td class="all first">10</td></tr>
</tbody><tfoot><tr><th>all</th><td class="first">30 %</td></tr></tfoot></table>
"""
TEXT = f"""# Teach

Before.

```{{samples}}
Look at [the report](../{SAMPLES}/{REPORT}){{.external}}.
```

After.
"""


def build(folder: Path) -> tuple[str, str]:
    """Build a book of this one page; its HTML, and the warnings of the build."""
    (folder / "chapters").mkdir(exist_ok=True)
    (folder / "chapters" / "teach.md").write_text(TEXT, encoding="utf-8")
    (folder / "conf.py").write_text(SETTINGS, encoding="utf-8")
    command = [sys.executable, "-m", "sphinx", "-q", "--no-color", "-b", "html"]
    command += ["-d", str(folder / "doctrees"), str(folder), str(folder / "out")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    page = folder / "out" / "chapters" / "teach.html"
    return page.read_text(encoding="utf-8"), done.stderr


def put(folder: Path) -> None:
    page = folder / SAMPLES_SOURCE / REPORT
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text(f"<!doctype html>\n<title>The report</title>\n{HEAT}", encoding="utf-8")


def test_a_small_heat_map_has_a_square_for_each_of_the_reports():
    shown = thumbnail(HEAT)
    squares = re.findall(r'<rect x="(\d+)" y="(\d+)" [^>]*class="(\w+)"/>', shown)
    levels = ["all", "zero", "some", "unmarked", "most", "all"]
    places = [(x, y) for y in (0, 10) for x in (0, 10, 25)]
    assert [(int(x), int(y)) for x, y, _ in squares] == places
    assert [level for *_, level in squares] == levels
    style = (ROOT / "chapters" / "assets" / "site.css").read_text(encoding="utf-8")
    assert all(f".rs-heat .{level} {{" in style for level in levels)
    assert "2 rows of students" in shown and 'viewBox="0 0 35 20"' in shown


def test_where_they_are_made_the_page_leads_to_them_as_they_come_and_go(tmp_path):
    """Sphinx builds the page three times, each time in a new process."""
    address = f"../{SAMPLES}/{REPORT}"
    target = (tmp_path / "out" / "chapters" / address).resolve()
    made = tmp_path / SAMPLES_SOURCE / REPORT
    for is_there in (False, True, False):
        if is_there:
            put(tmp_path)
        else:
            made.unlink(missing_ok=True)
        html, warnings = build(tmp_path)
        assert "Before." in html and "After." in html and warnings == ""
        assert (f'href="{address}">the report</a>' in html) == is_there
        assert html.count("<rect ") == (6 if is_there else 0)
        assert target.exists() == (tmp_path / "out" / SAMPLES).exists() == is_there
        assert not is_there or target.read_bytes() == made.read_bytes()
