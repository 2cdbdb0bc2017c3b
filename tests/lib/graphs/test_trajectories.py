"""TUM's and KITTI's formats, read back by evo."""

from __future__ import annotations

import numpy as np
import pytest
from evo.tools import file_interface
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.trajectories import write_kitti, write_tum

TRUTHS = {"plane": manhattan(30, 0)[1], "space": sphere(30, 0)[1]}


@pytest.mark.parametrize("kind", TRUTHS)
def test_evo_reads_the_same_poses(tmp_path, kind):
    poses = TRUTHS[kind]
    write_tum(tmp_path / "a.tum", poses)
    write_kitti(tmp_path / "a.kitti", poses)
    tum = file_interface.read_tum_trajectory_file(tmp_path / "a.tum")
    kitti = file_interface.read_kitti_poses_file(tmp_path / "a.kitti")
    np.testing.assert_array_equal(tum.timestamps, np.arange(30))
    for one, other in zip(tum.poses_se3, kitti.poses_se3, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    at = np.stack(kitti.poses_se3)
    if kind == "space":
        np.testing.assert_array_equal(at[:, :3], poses)
    else:
        np.testing.assert_array_equal(at[:, :2, 3], poses[:, :2])
        np.testing.assert_allclose(np.arctan2(at[:, 1, 0], at[:, 0, 0]), poses[:, 2], atol=1e-12)
        np.testing.assert_array_equal(at[:, 2], np.broadcast_to([0, 0, 1, 0], (30, 4)))
