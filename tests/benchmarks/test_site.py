"""The benchmark of a site: what it sees on a page, and what it prints."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from benchmarks import site

SHIFT = "setTimeout(() => { document.getElementById('late').style.height = '300px'; }, 200);"
PAGE = f"""<!doctype html><html lang="en"><head><title>t</title><link rel="icon" href="data:,">
</head><body><div id="late"></div><p>Four words stand here.</p><img src="a.png" width="200">
<img src="missing.png"><script>{SHIFT}</script></body></html>"""


@pytest.mark.browser
def test_a_page_is_measured(tmp_path: Path, browser: Browser) -> None:
    (tmp_path / "chapters").mkdir()
    (tmp_path / "chapters" / "00-one.html").write_text(PAGE)
    (tmp_path / "chapters" / "a.png").write_bytes(b"x" * 500)
    with site.serving(tmp_path) as address:
        found = site.measure(browser, tmp_path, address, "00-one")
    assert (found.size, found.requests) == (len(gzip.compress(PAGE.encode())) + 500, 3)
    assert min(found.shifts) > 0.02
    head, row, middle = site.table([found]).splitlines()
    assert row.split()[:3] == ["00-one", "1", "3"]
    assert row.split()[1:] == middle.split()[1:] and len(head) == len(row)
