"""What tests need: ``python -m tests.needs DEPTH`` says before they begin what is missing here.

With ``--strict`` it fails, so that it takes no minutes to be told. What only a test finds out,
as whether npm reaches its registry, it says itself by ``autograder.tests.kernel.leave_out``.
"""

import argparse
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from robust_slam.files import datasets

from autograder.tests import kernel
from tests.depth import LEFT_OUT


@dataclass(frozen=True)
class Need:
    """Something that a machine may lack."""

    what: str
    tests: str
    """What is left out without it."""
    remedy: str
    is_here: Callable[[], bool]
    depths: frozenset[str]


def _program(*names: str) -> Callable[[], bool]:
    return lambda: any(map(shutil.which, names))


ALL, NOT_QUICK, DEEP = map(
    frozenset, (LEFT_OUT, LEFT_OUT.keys() - {"quick"}, LEFT_OUT.keys() - {"quick", "test"})
)
NEEDS = (
    Need("public pose graphs", "tests on them", "make data",
         lambda: all(map(datasets.is_here, datasets.NAMES)), ALL),
    Need("gtsam", "comparisons with GTSAM", "Python 3.11 to 3.13 on x86-64 Linux",
         lambda: find_spec("gtsam") is not None, ALL),
    Need("a sandbox", "tests of what student code may do", "autograder doctor",
         lambda: bool(kernel.usable()), NOT_QUICK),
    Need("chromium-headless-shell", "tests of pages", "apt-get install chromium-headless-shell",
         _program("chromium-headless-shell", "chromium"), NOT_QUICK),
    Need("firefox", "tests of pages in Firefox", "apt-get install firefox-esr",
         _program("firefox-esr", "firefox"), DEEP),
    Need("gpg", "tests of encrypted marks", "apt-get install gnupg", _program("gpg"), DEEP),
    Need("PostgreSQL", "tests of a gradebook on a server", "apt-get install postgresql",
         lambda: any(Path("/usr/lib/postgresql").glob("*/bin/initdb")), DEEP),
)  # fmt: skip


def main(words: list[str]) -> int:
    """Say what is missing; return 1 where something is and nothing may be."""
    parser = argparse.ArgumentParser(prog="python -m tests.needs", description=__doc__)
    parser.add_argument("depth", choices=list(LEFT_OUT))
    parser.add_argument("--strict", action="store_true", help="fail where something is missing")
    options = parser.parse_args(words)
    missing = [need for need in NEEDS if options.depth in need.depths and not need.is_here()]
    for need in missing:
        print(f"Missing: {need.what}, so {need.tests} are left out. Remedy: {need.remedy}.")
    if missing and options.strict:
        print("STRICT=1 leaves nothing out, so nothing was run.")
    return int(bool(missing) and options.strict)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
