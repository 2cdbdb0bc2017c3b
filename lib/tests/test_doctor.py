"""A graph in other units or another order than it is read in is named, and a right one is not."""

from dataclasses import replace

import numpy as np
import pytest
import robust_slam as rs
from robust_slam import cli
from robust_slam.files.doubts import DOUBTS, rolled
from robust_slam.files.formats import TORO
from robust_slam.files.g2o import write
from robust_slam.files.reading import read
from robust_slam.graphs import add_random_closures, circle, manhattan, sphere
from robust_slam.graphs.pose_graph import with_closures
from robust_slam.solver import readings
from scipy.spatial.transform import Rotation

pytestmark = pytest.mark.long

CIRCLE = 180.0 / np.pi


def edge(graph, k, **changed):
    """The graph with other rows at edge ``k``."""
    rows = {name: getattr(graph, name).copy() for name in changed}
    for name, value in changed.items():
        rows[name][k] = value
    return replace(graph, **rows)


def scaled(length, angle=1.0, information=None):
    """The town with other lengths (m) and angles, and information of its own."""
    graph = TOWN
    given = graph.information if information is None else np.broadcast_to(information, (97, 3, 3))
    unit = np.array([length, length, angle])
    return replace(graph, measurement=graph.measurement * unit, information=given)


def claiming(closures, one=None):
    """The town whose odometry claims a third, and its closures what is given; or ``one`` step."""
    given = np.where(TOWN.is_odometry[:, None, None], TOWN.information * 9.0, closures)
    claimed = replace(TOWN, information=given)
    return claimed if one is None else edge(claimed, one, information=closures)


def another(seed, noise):
    """The town, and each step of it once more: of another robot, or of another sensor."""
    rng = np.random.default_rng(seed)
    steps = TOWN.measurement[TOWN.is_odometry]
    other = manhattan(60, rng)[0].measurement[:59] if noise is None else None
    again = steps + noise * rng.normal(size=steps.shape) if other is None else other
    return with_closures(TOWN, TOWN.edges[TOWN.is_odometry], again, TOWN.information[0])


def drive(yaw, w_first=False, origin=(0.0, 0.0), digits=12, way=None):
    """A square as a trajectory of TUM that begins with a heading of ``yaw`` (rad)."""
    heading = yaw + np.pi / 2.0 * (np.arange(40) // 10)
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    place = np.asarray(origin) + np.cumsum(ahead, axis=0)
    rows = []
    for t, (x, y) in enumerate(place):
        z, w = np.sin(heading[t] / 2.0), np.cos(heading[t] / 2.0)
        turn = [w, 0, 0, z] if w_first else [0, 0, z, w]
        rows.append(" ".join(f"{v:.{digits}g}" for v in (t, x, y, 0, *turn)))
    return "\n".join(rows)


def ball(quaternion):
    """A sphere whose edges are turned by a quaternion besides."""
    graph = sphere(60, 1)[0]
    turned = Rotation.from_quat(quaternion).as_matrix()
    moved = graph.group.from_parts(graph.rotation @ turned, graph.translation)
    return replace(graph, measurement=moved)


TOWN = add_random_closures(manhattan(60, 0, closures=30)[0], 8, 0)[0]
EYE = np.eye(3)
STEP = {"measurement": [40.0, 0.0, 0.0]}
FILES = {
    "degrees": [(scaled(1.0, CIRCLE), "if these are degrees"), (scaled(1.0, 1.9), "")],
    "covariances": [
        (scaled(1.0, 1.0, np.linalg.inv(TOWN.information)), "if they are covariances"),
        # The rotation is within reason here, and the position is not.
        (scaled(1.0, 1.0, np.linalg.inv(TOWN.information) * [1, 1, 1e4]), "are covariances"),
        (scaled(0.05, 1.0, EYE), ""),
        (scaled(0.025, 1.0, 10.0 * EYE), ""),
        (scaled(0.05, 1.0, np.diag([3.0, 3.0, 5.0])), ""),
        (scaled(1.0, 1.0, 0.1 * EYE), ""),
    ],
    "w first": [
        (replace(sphere(60, 1)[0], measurement=rolled(sphere(60, 1)[0].measurement, 1)), "with w"),
        (drive(0.7, w_first=True), "begins with w"),
        (drive(0.0, w_first=True), "begins with w"),
        (drive(0.7), ""),
        (drive(np.pi), ""),
        (ball([0.0, 0.0, 1.0, 0.0]), ""),
        (sphere(60, 1)[0], ""),
    ],
    "few digits": [
        (drive(0.7, origin=(5.571e6, 3.1e5), digits=6), "six digits, which is 10 m at 5.571"),
        (drive(0.7, origin=(5.571e6, 3.1e5)), ""),
        (drive(0.7, digits=6), ""),
    ],
    "same ids": [
        (another(5, None), "if two robots have the same ids"),
        (another(5, [0.05, 0.05, 0.02]), ""),
        (another(5, 0.0), ""),
    ],
    "strange steps": [
        (edge(TOWN, 20, **STEP), "edge 20-21 counts as odometry"),
        (claiming(TOWN.information[0], 20), "edge 20-21 counts as odometry"),
        (claiming(TOWN.information[0]), ""),
        (edge(TOWN, 20, measurement=[4.0, 0.0, 0.0]), ""),
    ],
    "steps back": [
        (edge(TOWN, 20, edges=TOWN.edges[20, ::-1]), "edge 21-20 leads back"),
        (replace(TOWN, edges=TOWN.edges[:, ::-1], measurement=TOWN.inverse_measurement), ""),
    ],
}
"""For each doubt files that have it, with its words, and files that look like it and do not."""


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [(name, *each) for name, files in FILES.items() for each in files],
)
def test_a_doubt_is_told_of_the_files_that_have_it_alone(tmp_path, name, content, words):
    if isinstance(content, str):
        (tmp_path / "file").write_text(content)
        found = read(tmp_path / "file", odometry=(0.1, 0.1)).doubts
    else:
        write(tmp_path / "file", content)
        found = read(tmp_path / "file").doubts
    assert (len(found) == 1 and words in found[0]) if words else found == ()


def test_each_doubt_has_files_and_degrees_are_seen_among_the_three_angles_of_toro():
    assert list(FILES) == list(DOUBTS)
    assert TORO.space.angles == (3, 4, 5)


class TestTheFile:
    def test_degrees_are_named_with_their_line(self, tmp_path):
        write(tmp_path / "graph.g2o", scaled(1.0, CIRCLE))
        rows = [line.split() for line in (tmp_path / "graph.g2o").read_text().splitlines()]
        turning = [k for k, row in enumerate(rows, 1) if abs(float(row[5])) > 7.0]
        assert f"line {turning[0]}: edge " in read(tmp_path / "graph.g2o").doubts[0]

    def test_the_command_does_not_trust_it(self, tmp_path):
        write(tmp_path / "graph.g2o", replace(TOWN, information=np.linalg.inv(TOWN.information)))
        assert cli.main(["solve", str(tmp_path / "graph.g2o"), "--quiet"]) == 1


class TestTheReading:
    @pytest.mark.parametrize("words", readings.READINGS)
    @pytest.mark.parametrize("space", [False, True])
    def test_another_one_is_named_where_it_was_meant(self, words, space):
        graph = sphere(60, 1)[0] if space else TOWN
        wrong = rs.solve(readings.READINGS[words](graph))
        better = readings.better_reading(wrong)
        assert better is not None
        assert better.words == words
        np.testing.assert_allclose(better.graph.measurement, graph.measurement, atol=1e-12)

    @pytest.mark.parametrize("small", [False, True])
    @pytest.mark.long
    def test_degrees_are_named_without_another_try(self, small):
        # Small turns are less than a circle in degrees too, so that no line gives them away.
        round_and_round = circle(400, np.random.default_rng(0), laps=2, closures=60)[0]
        graph = round_and_round if small else TOWN
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

    def test_none_is_named_where_outliers_are_to_be_rejected(self):
        answer = rs.solve(TOWN)
        assert answer.rejected.size >= 8
        stages = []
        assert readings.better_reading(answer, progress=stages.append) is None
        assert stages == []  # neighbours agree best as they are
        assert readings.swapped_closures(answer).size == 0

    def test_a_single_closure_is_named(self):
        kept = np.flatnonzero(rs.solve(TOWN).kept & ~TOWN.is_odometry)
        # One a block ahead, whose inverse is a block behind.
        k = int(kept[np.argmin(np.abs(TOWN.measurement[kept, 2]))])
        swapped = edge(TOWN, k, measurement=TOWN.inverse_measurement[k])
        assert readings.swapped_closures(rs.solve(swapped)).tolist() == [k]

    def test_the_command_names_both(self, tmp_path, capsys):
        write(tmp_path / "graph.g2o", replace(TOWN, measurement=TOWN.inverse_measurement))
        cli.main(["solve", str(tmp_path / "graph.g2o"), "--quiet", "--readings"])
        said = capsys.readouterr().out
        assert "reading  with i and j swapped in all edges" in said
        assert "; with i and j swapped they fit" in said

    def test_quaternions_that_begin_with_w_are_read_so(self):
        graph = sphere(60, 1)[0]
        wrong = rs.solve(replace(graph, measurement=rolled(graph.measurement, 1)))
        better = readings.better_reading(wrong)
        assert better is not None and better.words == "with quaternions that begin with w"
        np.testing.assert_allclose(better.graph.measurement, graph.measurement, atol=1e-12)
