"""Each paper that is cited is listed, with one identifier, and each that is listed is cited."""

import json
import re
from collections import Counter
from collections.abc import Iterator

import pytest
from pybtex.database import Entry, parse_file

from tests.book.prose import CHAPTERS

ENTRIES: dict[str, Entry] = dict(parse_file(str(CHAPTERS / "references.bib")).entries)
CITED = re.compile(r"\{cite(?::\w+)?\}`([^`]+)`")
DOI = re.compile(r"10\.\d{4,9}/\S+")
PREPRINT = re.compile(r"10\.48550/arXiv\.\d{4}\.\d{4,5}")
WITHOUT_DOI = {
    "carlone_handbook2026": "https://github.com/SLAM-Handbook-contributors/",
    "geman1985": "https://www.dam.brown.edu/people/geman/",
    "huber1967": "https://projecteuclid.org/euclid.bsmsp/",
    "thrun2005": "https://mitpress.mit.edu/9780262201629/",
}
"""A book that has no DOI yet, and two papers and a book without one, and where they are."""


def texts() -> Iterator[tuple[str, str]]:
    for path in sorted([*CHAPTERS.glob("*.md"), *CHAPTERS.glob("*.ipynb")]):
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".ipynb":
            cells = json.loads(text)["cells"]
            text = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "markdown")
        yield path.stem, text


PAGES = dict(texts())
LISTS = [keys for text in PAGES.values() for keys in CITED.findall(text)]
KEYS = {key.strip() for keys in LISTS for key in keys.split(",")}


@pytest.mark.parametrize("key", sorted(ENTRIES))
def test_an_entry_has_one_identifier(key):
    fields = ENTRIES[key].fields
    assert fields["title"] and fields["year"]
    if key in WITHOUT_DOI:
        assert fields["url"].startswith(WITHOUT_DOI[key])
        return
    assert not {"url", "eprint", "howpublished", "note"} & set(fields), "a DOI is enough"
    assert DOI.fullmatch(fields["doi"])
    assert "arxiv" not in fields["doi"].lower() or PREPRINT.fullmatch(fields["doi"])


def test_no_two_entries_are_one_paper():
    for field in ("doi", "title"):
        values = Counter(
            re.sub(r"\W", "", entry.fields[field].lower())
            for entry in ENTRIES.values()
            if field in entry.fields
        )
        assert [value for value, count in values.items() if count > 1] == []


def test_every_key_that_is_cited_exists_and_every_entry_is_cited():
    assert KEYS ^ set(ENTRIES) == set()
