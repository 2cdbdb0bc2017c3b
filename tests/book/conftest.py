"""The built site, and a server for it."""

import base64
import re

import pytest
import yaml

from tests.book.built_site import ROOT, Site, built
from tests.chromium import served
from tools import fonts

TITLE = yaml.safe_load((ROOT / "_config.yml").read_text(encoding="utf-8"))["title"]
TOC = yaml.safe_load((ROOT / "_toc.yml").read_text(encoding="utf-8"))
LISTED = [page for part in TOC["parts"] for page in part["chapters"]]
BELOW = [page["file"] for above in LISTED for page in above.get("sections", ())]
"""The pages that are not in the menu."""
PAGES = [TOC["root"], *(page["file"] for page in LISTED), *BELOW]
NOTEBOOKS = [page for page in PAGES if (ROOT / f"{page}.ipynb").exists()]
CHAPTERS = [page for page in NOTEBOOKS if re.match(r"chapters/\d\d-", page)]
"""The notebooks with a number; the others are appendices."""
WAYS = ("http", "file")


@pytest.fixture(scope="session")
def site():
    return built()


@pytest.fixture(scope="session")
def address(site):
    """The address of a server on this machine that serves the site."""
    with served(site.folder) as found:
        yield found


def place(site: Site, address: str, page: str, way: str) -> str:
    """The address of a page on the server, or on the disk."""
    return f"{address if way == 'http' else site.folder.as_uri()}/{page}.html"


@pytest.fixture(scope="session")
def carried():
    """The fonts that the style sheet carries, that of formulas last."""
    style = (fonts.MADE / fonts.STYLE).read_text(encoding="utf-8")
    return [base64.b64decode(font) for font in re.findall(r"base64,([^)]*)[)]", style)]
