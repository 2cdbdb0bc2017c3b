"""Whether an assignment's packages are there, and nothing secret is in what they show."""

from collections.abc import Iterable
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.reading.assignment import CONFIG_NAME, Assignment
from robust_slam_autograder.sandbox import Sandbox, Unsandboxed, packages, view


def refuse_unsafe(
    assignments: Iterable[Assignment], folders: Iterable[Path], sandbox: Sandbox
) -> None:
    """Make sure that the packages are installed and that student code sees none of the folders.

    Args:
        assignments: what is graded.
        folders: the source tree, the submissions and the results.
        sandbox: the sandbox; without one there is no question of what it shows.

    Raises:
        WrongUse: names the package, or the first folder that student code could read.
    """
    places = list(dict.fromkeys(folders))
    for allowed in {assignment.config.packages: assignment for assignment in assignments}.values():
        for problem in packages.missing(allowed.config.packages):
            raise WrongUse(f"{allowed.name}/{CONFIG_NAME}: {problem}")
        if isinstance(sandbox, Unsandboxed):
            continue
        for folder in places:
            shown = view.exposing(folder, allowed.config.packages)
            if shown is not None:
                raise WrongUse(
                    f"Student code could read {folder}, which is in {shown}: move it out of there."
                )
