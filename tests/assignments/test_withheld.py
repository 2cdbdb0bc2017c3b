"""What an assignment withholds is closed: no other module of the library leads to it."""

import tomllib
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = sorted(ROOT.glob("solutions/*/autograder.toml"))
IMPORTS = grimp.build_graph("robust_slam", "robust_slam_course", cache_dir=None)

ANSWERS = {
    "00": ["graphs.pose_graph", "descent.start", "certificates.chordal", "problems"],
    "02": ["estimators.kernels", "estimators.thresholds"],
    "03": ["estimators.loop", "estimators.graduation", "estimators.kernels"],
    "04": ["estimators.loop", "estimators.graduation"],
    "05": ["estimators.graduation", "estimators.loop", "estimators.reweighting", "problems"],
    "06": ["estimators.switches", "consistency.cliques", "consistency.pairwise"],
    "07": ["certificates.sdp"],
    "08": ["graphs.metrics", "groups.se2", "descent", "estimators.graduation"],
    "09": ["graphs.generate", "graphs.outliers", "certificates.optimality", "solver"],
}
"""Modules of robust_slam with a function that gives a solution's values by itself.

For 00 to 07 they were found by calling every function of the library with the arguments of the
cases; NumPy's and SciPy's answers are allowed by the first cell of the assignments.
"""


def inside(name: str, withheld: list[str]) -> bool:
    return any(f"{name}.".startswith(f"{one}.") for one in withheld)


@pytest.mark.parametrize("config", CONFIGS, ids=lambda path: path.parent.name)
def test_what_would_be_an_answer_is_withheld_and_no_module_that_is_left_imports_it(config):
    withheld = tomllib.loads(config.read_text(encoding="utf-8"))["withheld"]
    assert withheld
    assert set(withheld) <= IMPORTS.modules
    left = {name for name in IMPORTS.modules if not inside(name, withheld)}
    found = {name: IMPORTS.find_modules_directly_imported_by(name) for name in left}
    assert not [name for name in left if any(inside(one, withheld) for one in found[name])]
    modules = {f"robust_slam.{name}" for name in ANSWERS.get(config.parent.name[:2], [])}
    assert modules <= IMPORTS.modules
    assert not [name for name in modules if not inside(name, withheld)]
