"""Every law of sparse matrices holds with QDLDL and with SciPy in its place."""

import pytest
from robust_slam.descent.sparse import elimination, ldl, simplicial


@pytest.fixture(params=[ldl.Solver, ldl.SuperLU], ids=["QDLDL", "SciPy"], autouse=True)
def solver(request, monkeypatch):
    for module in (elimination, simplicial):
        monkeypatch.setattr(module, "Solver", request.param)
    return request.param
