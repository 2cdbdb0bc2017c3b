"""Each file that a test of the library reads is read by the page's Python, too."""

import contextlib
import importlib
from pathlib import Path

import numpy as np
import pytest
from robust_slam.factors import reading as of_factors
from robust_slam.graphs import reading

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "lib" / "tests"
ASKED = set()
"""What other modules of this process have asked about, such as public graphs."""
READING = ("doubts", "formats", "g2o", "graph_file", "lines", "matrices", "tagged", "trajectories")


class Narrow:
    """NumPy with whole numbers as they are in a browser, where modules look them up by name."""

    intp = int_ = np.int32

    def __getattr__(self, name):
        return getattr(np, name)


@pytest.fixture(scope="module", autouse=True)
def _as_the_page_reads(request, tmp_path_factory):
    """Ask the page's Python, whose intp has 32 bits, about each file that a test has read."""
    if LIBRARY not in request.path.parents:
        yield
        return
    found = {}
    decoded = reading.decoded

    def noted(content):
        found[content] = None
        return decoded(content)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(reading, "decoded", noted)
        yield
    found = {content: None for content in found if content not in ASKED}
    ASKED.update(found)
    with (
        pytest.MonkeyPatch.context() as patched,
        contextlib.chdir(tmp_path_factory.mktemp("page")),
    ):
        patched.syspath_prepend(str(ROOT / "chapters" / "python"))
        page = importlib.import_module("page_graph")
        given = {"name": "file", "indefinite": "nearest", "unknown": "skip"}

        def answers():
            for content in found:
                Path("file").write_bytes(content)
                yield (answer := page.read(given, str))
                if "how exact" in answer.get("problem", ""):  # a trajectory
                    yield page.read(given | {"odometry": [1, 1]}, str)

        wide = list(answers())
        patched.setattr(of_factors, "np", Narrow())
        for module in READING:
            patched.setattr(f"robust_slam.graphs.{module}.np", Narrow())
        assert list(answers()) == wide
