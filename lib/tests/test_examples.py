"""The examples in the docstrings of the library run and print what they say."""

import doctest
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

LIB = Path(__file__).resolve().parents[1] / "robust_slam"
WITH_EXAMPLES = sorted(
    ".".join(path.relative_to(LIB).with_suffix("").parts)
    for path in LIB.rglob("*.py")
    if ">>>" in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_the_examples_print_what_they_say(module):
    with np.printoptions(suppress=False, precision=8):  # a chapter may have set others
        result = doctest.testmod(import_module(f"robust_slam.{module}"))
    assert result.attempted > 0
    assert result.failed == 0
