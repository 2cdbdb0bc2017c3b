"""A hidden case that fails the reference with a few seeds is found among many that pass."""

from tests.assignments.planted import NAME, plant
from tests.assignments.seeds import failures

SOLUTION = """
def half(u):
    ### BEGIN SOLUTION
    return np.divide(u, 2)
    ### END SOLUTION
"""
CASE = """
assert half(2.0) == 1
### BEGIN HIDDEN TESTS
# hint: Divide by 2.
u = rng.integers({values})
assert half(u) == u / 2
assert half(u) > 0
### END HIDDEN TESTS
"""


def test_a_case_that_fails_now_and_then_is_found(tmp_path):
    cases = {"rare": CASE.format(values=100), "one": CASE.format(values="1, 100")}
    plant(tmp_path, "half", SOLUTION, cases)
    found = list(failures(NAME, range(1, 601), jobs=2, tree=tmp_path))
    assert {failure.grade_id for failure in found} == {"half-rare"}
    assert 1 <= len(found) < 30
    assert all(failure.error == "AssertionError" for failure in found)
