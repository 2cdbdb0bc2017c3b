"""Landmarks, priors and GPS of g2o files: what is read, and what is refused by file and line."""

import numpy as np
import pytest
from robust_slam.factors import FactorGraphProblem, read_factors
from robust_slam.factors.equations import FactorEquations
from robust_slam.files.graph_file import GraphFileError
from robust_slam.groups import se2, se3
from scipy.spatial.transform import Rotation

from ..worlds import assert_same_poses, random_information, random_poses, refused

PLANE = """\
VERTEX_SE2 3 0 0 0
VERTEX_XY 4 2 1
VERTEX_SE2 5 1 0 0.5
VERTEX_XY 1 9 9
EDGE_SE2 3 5 1 0 0.5 4 0 0 4 0 9
EDGE_SE2_XY 3 4 2 1 25 1 16
EDGE_SE2_XY 5 1 7 8 25 0 25
EDGE_PRIOR_SE2 3 0.5 0.25 0.1 9 1 2 8 3 7
EDGE_PRIOR_SE2_XY 5 6 7 3 1 2
"""


def read(folder, text, **options):
    path = folder / "graph.g2o"
    path.write_text(text)
    return read_factors(path, **options)


def test_decimal_commas_are_points_and_vertices_may_be_missing(tmp_path):
    plain = read(tmp_path, PLANE)
    commas = read(tmp_path, PLANE.replace(".", ","))
    np.testing.assert_array_equal(commas.x, plain.x)
    assert commas.notes[0] == "the commas in its numbers are read as decimal points"
    assert "note       the commas" in str(commas)
    assert repr(commas).startswith("<FactorFile: Factor")
    lines = [line for line in PLANE.splitlines() if not line.startswith("VERTEX")]
    file = read(tmp_path, "\n".join(lines))
    assert file.x is None and file.ids.tolist() == [3, 5, 1, 4]


def information(root):
    return np.swapaxes(root, 1, 2) @ root


def test_landmarks_priors_and_positions_of_the_plane_are_read(tmp_path):
    file = read(tmp_path, PLANE)
    assert file.ids.tolist() == [3, 5, 1, 4]
    blocks = {block.name: block for block in file.graph.blocks}
    assert blocks["points"].ends.tolist() == [[0, 3], [1, 2]]
    np.testing.assert_array_equal(blocks["points"].measurement, [[2, 1], [7, 8]])
    np.testing.assert_allclose(information(blocks["points"].root)[0], [[25, 1], [1, 16]])
    assert blocks["priors"].ends.tolist() == [[-1, 0]]
    np.testing.assert_array_equal(blocks["priors"].measurement, [[0.5, 0.25, 0.1]])
    expected = [[9, 1, 2], [1, 8, 3], [2, 3, 7]]
    np.testing.assert_allclose(information(blocks["priors"].root)[0], expected)
    assert blocks["positions"].ends.tolist() == [[-1, 1]]
    np.testing.assert_array_equal(blocks["positions"].measurement, [[6, 7]])
    np.testing.assert_allclose(information(blocks["positions"].root)[0], [[3, 1], [1, 2]])
    assert_same_poses(se2, file.x, np.array([[0, 0, 0], [1, 0, 0.5], [9, 9, 0], [2, 1, 0.0]]))
    assert FactorGraphProblem(file.graph, file.x).initial().shape == (4, 3)


def numbers(*parts):
    return " ".join(repr(float(v)) for part in parts for v in np.ravel(part))


def written(pose):
    return numbers(pose[:, 3], Rotation.from_matrix(pose[:, :3]).as_quat())


def triangle(matrix):
    return numbers(matrix[np.triu_indices(len(matrix))])


def test_a_sensor_of_its_own_place_sees_what_the_robot_would(tmp_path):
    rng = np.random.default_rng(0)
    poses, sensor = random_poses(se3, 2, rng), random_poses(se3, 1, rng)[0]
    place, inner = rng.normal(size=3), random_information(se3, 3, rng)
    eyes = se3.compose(poses, sensor)
    seen = se3.rotation(eyes[0]).T @ (place - se3.translation(eyes[0]))
    prior = se3.compose(eyes[1], se3.exp([0.1, -0.2, 0.1, 0.05, 0.1, -0.05]))
    off = np.array([0.1, 0.2, -0.3])
    text = "\n".join(
        [
            f"PARAMS_SE3OFFSET 2 {written(sensor)}",
            "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1",
            *(f"VERTEX_SE3:QUAT {k} {written(pose)}" for k, pose in enumerate(poses)),
            f"VERTEX_TRACKXYZ 7 {numbers(place)}",
            f"EDGE_SE3:QUAT 0 1 {written(se3.between(*poses))} {triangle(inner[0])}",
            f"EDGE_SE3_TRACKXYZ 0 7 2 {numbers(seen + off)} {triangle(inner[1][:3, :3])}",
            f"EDGE_SE3_PRIOR 1 2 {written(prior)} {triangle(inner[2])}",
            f"EDGE_SE3_XYZ_PRIOR 0 0 {numbers(poses[0, :, 3] + off)} {triangle(np.eye(3))}",
        ]
    )
    file = read(tmp_path, text)
    norms = FactorEquations(file.graph).norms(file.x)
    error = se3.log(se3.between(prior, eyes[1]))
    expected = [0.0, error @ inner[2] @ error, off @ off, off @ inner[1][:3, :3] @ off]
    np.testing.assert_allclose(norms**2, expected, rtol=1e-9, atol=1e-12)


@refused(
    ("EDGE_BEARING_SE2_XY 3 4 1 1\n", "10: the tag 'EDGE_BEARING_SE2_XY' is unknown; use .*_SE2_"),
    ("VERTEX_XY 4 0 0\n", "10: vertex 4 is given twice; drop one line"),
    ("VERTEX_XY 6 0 0\n", "10: landmark 6 is in no edge; drop the line"),
    ("VERTEX_XY 5 0 0\n", "10: vertex 5 is a pose as well; renumber it"),
    ("EDGE_SE2_XY 3 8 0 0 1 0 1\n", "10: vertex 8 is missing; add its line"),
    ("EDGE_SE2_XY 4 1 0 0 1 0 1\n", "10: there is no pose 4; add it, or drop the line"),
    ("EDGE_SE2_XY 3 4 0 0 1 2 1\n", "10: the information matrix is not positive definite"),
    ("EDGE_PRIOR_SE2 3 0 0 1 0 1\n", "10: EDGE_PRIOR_SE2 has 6 fields behind it; give 10"),
    ("FIX 4\n", "10: a landmark is fixed; give it a position, or drop the line"),
    ("FIX 3\n", "10: a pose is fixed beside priors or positions, .* give the pose a prior"),
    ("EDGE_SE3_TRACKXYZ 3 4 0 0 0 0 1 0 0 1 0 1\n", r"10: SE\(2\) and SE\(3\) are mixed"),
)
def test_a_wrong_line_is_named_with_its_remedy(tmp_path, wrong, message):
    with pytest.raises(GraphFileError, match=rf"graph\.g2o:{message}"):
        read(tmp_path, PLANE + wrong)


@refused(
    ("EDGE_SE3_TRACKXYZ 0 4 9 0 0 0 1 0 0 1 0 1\n", "2: sensor 9 is missing; add its PARAMS_SE3"),
    (
        "PARAMS_SE3OFFSET 1 0 0 2 0 0 0 1\nEDGE_SE3_XYZ_PRIOR 0 1 0 0 0 1 0 0 1 0 1\n",
        "3: the antenna is not at the robot's origin",
    ),
)
def test_a_sensor_that_is_not_there_is_named(tmp_path, wrong, message):
    edge = f"EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 {triangle(np.eye(6))}\n"
    with pytest.raises(GraphFileError, match=rf"graph\.g2o:{message}"):
        read(tmp_path, edge + wrong)


def test_unknown_lines_are_skipped_on_demand_and_an_edge_that_is_given_twice_is_noted(tmp_path):
    file = read(tmp_path, PLANE + "EDGE_BEARING_SE2_XY 3 4 1 1\n", unknown="skip")
    assert file.skipped == {"EDGE_BEARING_SE2_XY": 1} and file.graph.landmarks == 2
    edge = PLANE.splitlines()[4]
    notes = read(tmp_path, f"{PLANE}{edge}\n").notes
    assert len(notes) == 1 and notes[0].startswith("line 10 gives edge 3-5 once more")


@pytest.mark.parametrize(("digits", "words"), [(6, "six digits, which is 10 m at 5"), (9, "")])
def test_gps_far_away_needs_more_than_six_digits(tmp_path, digits, words):
    steps = [f"EDGE_SE2 {k} {k + 1} 1 0 0 4 0 0 4 0 9\n" for k in range(9)]
    fixes = [f"EDGE_PRIOR_SE2_XY {k} {5.5e6 + k + 0.1:.{digits}g} 0 9 0 9\n" for k in range(9)]
    doubts = read(tmp_path, "".join(steps + fixes)).doubts
    assert (len(doubts) == 1 and words in doubts[0]) if words else doubts == ()
