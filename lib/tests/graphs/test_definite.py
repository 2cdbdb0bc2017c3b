"""Indefinite information matrices: what replaces them, and how a file is read with them."""

import re

import numpy as np
import pytest
import robust_slam as rs
from robust_slam.files.g2o import write
from robust_slam.files.graph_file import GraphFileError
from robust_slam.files.matrices import definite
from robust_slam.files.reading import read
from robust_slam.graphs.generate import manhattan


def indefinite(seed, d, count=40):
    rng = np.random.default_rng(seed)
    size = 3 if d == 2 else 6
    matrices = rng.normal(size=(count, size, size))
    return matrices + np.swapaxes(matrices, 1, 2) + np.eye(size)


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("repair", ["nearest", "isotropic"])
def test_the_result_is_positive_definite_wherever_both_blocks_allow_it(d, repair):
    given = indefinite(0, d)
    repaired, empty = definite(given, repair)
    hopeless = [
        max(np.linalg.eigvalsh(m[:d, :d])[-1], 0) == 0
        or max(np.linalg.eigvalsh(m[d:, d:])[-1], 0) == 0
        for m in given
    ]
    np.testing.assert_array_equal(empty, hopeless)
    assert np.linalg.eigvalsh(repaired)[:, 0].min() > 0.0
    np.testing.assert_array_equal(repaired, np.swapaxes(repaired, 1, 2))


def test_no_other_definite_matrix_is_nearer():
    given = np.array([[[2.0, 3.0, 0.0], [3.0, 2.0, 0.0], [0.0, 0.0, 1.0]]])
    near = definite(given, "nearest")[0][0]
    # In the unit of the largest eigenvalue, 5, as both positions have it.
    assert np.linalg.norm(near - given[0]) == pytest.approx(1.0, rel=1e-4)
    rng = np.random.default_rng(2)
    for _ in range(200):
        step = 0.1 * rng.normal(size=(2, 2))
        other = near[:2, :2] + step + step.T
        if np.linalg.eigvalsh(other)[0] > 5e-6:
            assert np.linalg.norm(other - given[0, :2, :2]) >= 1.0 - 1e-4


def test_isotropic_is_one_number_for_each_kind_of_coordinate():
    given = np.diag([1.0, 2.0, 4.0, -5.0, 3.0, 6.0])[None]
    expected = [3 / 1.75] * 3 + [4.0] * 3
    np.testing.assert_allclose(definite(given, "isotropic")[0][0], np.diag(expected))


@pytest.fixture
def file(tmp_path):
    """A file with a third of the information matrices indefinite, and its graph without that."""
    graph, truth = manhattan(40, 0, closures=12)
    path = tmp_path / "third.g2o"
    write(path, graph, truth)
    lines = path.read_text().splitlines()
    edges = [k for k, line in enumerate(lines) if line.startswith("EDGE")]
    for k in edges[::3]:
        fields = lines[k].split()
        fields[7] = str(3.0 * float(fields[6]))  # the mixed entry of x and y
        lines[k] = " ".join(fields)
    path.write_text("\n".join(lines))
    return path, graph


def test_a_file_with_indefinite_matrices_is_refused_with_their_number(file):
    path, graph = file
    third = -(-len(graph.edges) // 3)
    message = rf"third.g2o:41: .*{third} of {len(graph.edges)}.*nearest"
    with pytest.raises(GraphFileError, match=message):
        read(path)


@pytest.mark.parametrize("repair", ["nearest", "isotropic"])
def test_or_read_with_replaced_matrices_that_are_listed(file, repair):
    path, graph = file
    content = read(path, indefinite=repair)
    np.testing.assert_array_equal(content.repaired, np.arange(0, len(graph.edges), 3))
    others = np.arange(len(graph.edges)) % 3 > 0
    np.testing.assert_array_equal(content.graph.information[others], graph.information[others])
    assert rs.solve(content.graph).certificate.verdict.value == "certified"


@pytest.mark.parametrize("half", ["1 0 0 1 0 -1", "1 0 1 1 0 1e-40"])
def test_hopeless_matrices_are_refused_by_line(tmp_path, half):
    path = tmp_path / "two.g2o"
    path.write_text(f"EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 {half}\n")
    with pytest.raises(GraphFileError, match=r"two.g2o:2: .*no positive eigenvalue .*too much"):
        read(path, indefinite="nearest")


LANDMARKS = """PARAMS_SE2OFFSET 0 0 0 0
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1 0 0
VERTEX_XY 9 2 2
FIX 9
EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1
EDGE_SE2_XY 0 9 2 2 1 0 1
EDGE_SE2_XY 1 9 1 2 1 0 1
"""


def test_landmarks_and_parameters_are_refused_or_skipped_and_counted(tmp_path):
    path = tmp_path / "park.g2o"
    path.write_text(LANDMARKS)
    with pytest.raises(GraphFileError, match=r"park.g2o:4: the tag 'VERTEX_XY' is unknown"):
        read(path)
    content = read(path, unknown="skip")
    assert content.skipped == {"PARAMS_SE2OFFSET": 1, "VERTEX_XY": 1, "EDGE_SE2_XY": 2, "FIX": 1}
    assert (content.graph.n, len(content.graph.edges)) == (2, 1)


@pytest.mark.parametrize(("name", "word"), [("indefinite", "fix"), ("unknown", "ignore")])
def test_words_that_read_does_not_know_are_refused(tmp_path, name, word):
    with pytest.raises(ValueError, match=f"{name} is '{word}'; give one of 'raise'"):
        read(tmp_path / "none.g2o", **{name: word})


def test_load_takes_a_path_or_the_name_of_a_public_graph(tmp_path, caplog):
    graph, _ = manhattan(10, 1)
    write(tmp_path / "my.g2o", graph)
    assert rs.load(tmp_path / "my.g2o").n == 10
    write(tmp_path / "gap.g2o", graph, names=[*range(8), 80, 81])
    assert rs.load(tmp_path / "gap.g2o").n == 10
    assert re.search(r"edge 7-80 crosses a gap .*\(entry 7\)", caplog.text)
    with pytest.raises(FileNotFoundError, match=r"nix.g2o: there is no such file.*intel"):
        rs.load("nix.g2o")
