"""A graph in other units or another order than it is read in is named, and a right one is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import robust_slam as rs
from robust_slam import cli
from robust_slam.graphs import PoseGraph, add_random_closures, circle, manhattan, sphere
from robust_slam.graphs.formats import TORO
from robust_slam.graphs.g2o import write
from robust_slam.graphs.reading import read
from robust_slam.solver import readings

pytestmark = pytest.mark.long

CIRCLE = 180.0 / np.pi


@pytest.fixture(scope="module")
def town() -> PoseGraph:
    rng = np.random.default_rng(0)
    return add_random_closures(manhattan(60, rng, closures=30)[0], 8, rng)[0]


def remarks_on(graph, tmp_path):
    write(tmp_path / "graph.g2o", graph)
    return " ".join(read(tmp_path / "graph.g2o").remarks())


def edge(graph, k, **changed):
    """The graph with other rows at edge ``k``."""
    rows = {name: getattr(graph, name).copy() for name in changed}
    for name, value in changed.items():
        rows[name][k] = value
    return replace(graph, **rows)


class TestTheFile:
    def test_a_right_one_gets_no_remark(self, town, tmp_path):
        assert remarks_on(town, tmp_path) == ""

    def test_degrees_are_named_with_their_line(self, town, tmp_path):
        write(tmp_path / "graph.g2o", town)
        rows = [line.split() for line in (tmp_path / "graph.g2o").read_text().splitlines()]
        for row in rows:
            if row[0] == "EDGE_SE2":
                row[5] = repr(float(row[5]) * CIRCLE)
        (tmp_path / "graph.g2o").write_text("\n".join(map(" ".join, rows)))
        turning = [k for k, row in enumerate(rows, 1) if abs(float(row[5])) > 7.0]
        said = " ".join(read(tmp_path / "graph.g2o").remarks())
        assert f"line {turning[0]}: edge " in said
        assert "if these are degrees" in said

    def test_degrees_are_seen_among_the_three_angles_of_toro(self):
        assert TORO.space.angles == (3, 4, 5)

    @pytest.mark.parametrize("scale", [1.0, 1e4])
    def test_covariances_are_named(self, town, scale, tmp_path):
        # With the second scale the rotation is within reason, and the position is not.
        given = np.linalg.inv(town.information)
        given[:, 2, 2] *= scale
        assert "if they are covariances" in remarks_on(replace(town, information=given), tmp_path)

    def test_a_step_between_two_drives_is_named(self, town, tmp_path):
        long = edge(town, 20, measurement=[40.0, 0.0, 0.0])
        assert "edge 20-21 counts as odometry" in remarks_on(long, tmp_path)
        coarse = replace(town, information=town.information * 9.0)
        closures = np.where(town.is_odometry[:, None, None], coarse.information, town.information)
        told = replace(town, information=closures)
        assert remarks_on(told, tmp_path) == ""
        one = edge(told, 20, information=town.information[-1])
        assert "edge 20-21 counts as odometry" in remarks_on(one, tmp_path)

    def test_a_lone_step_back_is_named(self, town, tmp_path):
        back = edge(town, 20, edges=town.edges[20, ::-1])
        assert "edge 21-20 leads back" in remarks_on(back, tmp_path)

    def test_a_quaternion_that_begins_with_w_is_named(self, tmp_path):
        rows = [f"{t} {t} 0 0 1 0 0 0" for t in range(3)]  # w first, no rotation
        (tmp_path / "drive.tum").write_text("\n".join(rows))
        file = read(tmp_path / "drive.tum", odometry=(0.1, 0.1))
        assert "begins with w" in " ".join(file.doubts)

    def test_the_command_does_not_trust_it(self, town, tmp_path):
        write(tmp_path / "graph.g2o", replace(town, information=np.linalg.inv(town.information)))
        assert cli.main(["solve", str(tmp_path / "graph.g2o"), "--quiet"]) == 1


class TestTheReading:
    @pytest.mark.parametrize("words", readings.READINGS)
    @pytest.mark.parametrize("space", [False, True])
    def test_another_one_is_named_where_it_was_meant(self, town, words, space):
        graph = sphere(60, 1)[0] if space else town
        wrong = rs.solve(readings.READINGS[words](graph), quick=True)
        better = readings.better_reading(wrong)
        assert better is not None
        assert better.words == words
        np.testing.assert_allclose(better.graph.measurement, graph.measurement, atol=1e-12)

    @pytest.mark.parametrize("small", [False, True])
    @pytest.mark.long
    def test_degrees_are_named_without_another_try(self, town, small):
        # Small turns are less than a circle in degrees too, so that no line gives them away.
        round_and_round = circle(400, np.random.default_rng(0), laps=2, closures=60)[0]
        graph = round_and_round if small else town
        assert small == bool(np.abs(graph.measurement[:, 2]).max() < 2.0 * np.pi / CIRCLE)
        unit = np.array([1.0, 1.0, CIRCLE])
        told = graph.information / unit[:, None] / unit
        wrong = rs.solve(replace(graph, measurement=graph.measurement * unit, information=told))
        stages = []
        better = readings.better_reading(wrong, progress=stages.append)
        assert better is not None
        assert better.words == "with rotations and their information in degrees"
        assert len([words for words in stages if words.startswith("the graph is read")]) == 1
        np.testing.assert_allclose(better.graph.information, graph.information)

    def test_none_is_named_where_outliers_are_to_be_rejected(self, town):
        answer = rs.solve(town)
        assert answer.rejected.size >= 8
        stages = []
        assert readings.better_reading(answer, progress=stages.append) is None
        assert stages == []  # neighbours agree best as they are
        assert readings.swapped_closures(answer).size == 0

    def test_a_single_closure_is_named(self, town):
        kept = np.flatnonzero(rs.solve(town).kept & ~town.is_odometry)
        # One a block ahead, whose inverse is a block behind.
        k = int(kept[np.argmin(np.abs(town.measurement[kept, 2]))])
        swapped = edge(town, k, measurement=town.inverse_measurement[k])
        assert readings.swapped_closures(rs.solve(swapped)).tolist() == [k]

    def test_the_command_names_both(self, town, tmp_path, capsys):
        write(tmp_path / "graph.g2o", replace(town, measurement=town.inverse_measurement))
        cli.main(["solve", str(tmp_path / "graph.g2o"), "--quiet", "--readings"])
        said = capsys.readouterr().out
        assert "reading  with i and j swapped in all edges" in said
        assert "; with i and j swapped they fit" in said
