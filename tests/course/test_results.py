"""The results file of the benchmark, as the pages read it."""

import math

import pytest
from robust_slam_course.results import read_results

TEXT = """# version: "7-abc"
# runs: "9 of 9"
# cpu seconds: 12
graph,kind,percent,method,runs,failed,good
town,random,10,A,3,0,3
town,random,50,A,3,1,1
lake,random,10,"B, jointly",3,0,0
"""


@pytest.fixture
def results(tmp_path):
    path = tmp_path / "results.csv"
    path.write_text(TEXT, encoding="utf-8")
    return read_results(path)


def test_the_header_and_the_rows_are_read_and_good_maps_are_summed(results):
    assert results.header == {"version": "7-abc", "runs": "9 of 9", "cpu seconds": 12}
    assert results.names("method") == ["A", "B, jointly"]
    assert results.names("graph") == ["town", "lake"]
    assert results.good() == (4, 9)
    assert results.good(method="A") == (4, 6)
    assert results.share(method="A", percent="50") == pytest.approx(1 / 3)
    assert math.isnan(results.share(graph="lake", method="A")), "nothing was run"


def test_a_header_that_is_not_json_is_refused(tmp_path):
    path = tmp_path / "old.csv"
    path.write_text("# made by: hand\na,b\n", encoding="utf-8")
    with pytest.raises(ValueError, match="Expecting value"):
        read_results(path)
