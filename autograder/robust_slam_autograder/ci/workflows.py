"""Workflow files for GitHub and GitLab, filled in for one course."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.publishing.course import COURSE_NAME, Course

ACTIONS = {
    "CHECKOUT": "actions/checkout@08c6903cd8c0fde910a37f88322edcfb5dd907a8 # v5.0.0",
    "PYTHON": "actions/setup-python@a26af69be951a213d495a4c3e4e4022e16d87065 # v5.6.0",
    "UPLOAD": "actions/upload-artifact@ea165f8d65b6e75b540449e92b4886f43607fa02 # v4.6.2",
    "UPLOAD_PAGES": (
        "actions/upload-pages-artifact@56afc609e74202658d3ffba0e8f6dda462b719fa # v3.0.1"
    ),
    "DEPLOY_PAGES": "actions/deploy-pages@d6db90164ac5ed86f2b6aed7e0febac5b3c0c03e # v4.0.5",
}
"""Commits, for a tag can be moved to other code; the comment says which version each is."""

_EVERY_PUSH = "commit it to the repository that students start from; every push is checked."
_PLACEHOLDER = re.compile(r"@([A-Z_]+)@")
_UNFIT = re.compile(r"[\x00-\x1f\x7f]|\$\{\{")


@dataclass(frozen=True)
class Workflow:
    """A file that a machine of others reads."""

    place: str
    """Where it belongs in its repository."""
    then: str
    """What to do next."""


WORKFLOWS = {
    "github-student": Workflow(".github/workflows/public-checks.yml", _EVERY_PUSH),
    "gitlab-student": Workflow(".gitlab-ci.yml", _EVERY_PUSH),
    "github-grading": Workflow(
        ".github/workflows/grading.yml",
        "write your public key to .github/marks.asc (gpg --armor --export YOU), commit both and "
        "the submissions to your private repository, and start it: Actions, Grading, Run "
        "workflow. Read the marks with: gpg --decrypt marks.tar.gz.gpg | tar -xz",
    ),
    "github-course": Workflow(
        ".github/workflows/course.yml",
        "commit it to your private repository, and choose under Settings, Pages, the source "
        "GitHub Actions. A private repository's site is public, and may need a paid plan.",
    ),
}


def fill(name: str, course: Course, install: Sequence[str]) -> str:
    """Return the text of one of ``WORKFLOWS``.

    Students install what ``install`` names as pip takes it, else the course's packages.

    Raises:
        WrongUse: nothing says what students install, or it does not fit into such a file.
    """
    text = template(f"{name}.yml")
    values = {**ACTIONS, "BRANCH": course.repository.branch}
    if "@INSTALL@" in text:
        indent = re.search(r"^( *)@INSTALL@", text, re.MULTILINE)
        between = " \\\n" + (indent.group(1) if indent else "")
        values["INSTALL"] = between.join(map(quoted, install or _from_repository(course)))
    return substitute(text, values)


def template(name: str) -> str:
    """Return a template's text."""
    folder = resources.files(__package__).joinpath("templates")
    return folder.joinpath(*name.split("/")).read_text("utf-8")


def substitute(text: str, values: dict[str, str]) -> str:
    """Put values in their places, ``@NAME@``."""
    return _PLACEHOLDER.sub(lambda match: values[match.group(1)], text)


def quoted(requirement: str) -> str:
    """Return one word of a shell's, for what pip shall install.

    Raises:
        WrongUse: it would be more than a word in a workflow file.
    """
    if not requirement.strip() or _UNFIT.search(requirement):
        raise WrongUse(f"{requirement!r} cannot be installed: name a package as pip takes it.")
    return shlex.quote(requirement)


def _from_repository(course: Course) -> list[str]:
    packages = course.packages()
    if not packages or not course.repository.url:
        raise WrongUse(
            "Nothing says where students install from: write the public course's address into "
            f"repository.url of _config.yml and packages into {COURSE_NAME}, "
            "or add --install WHAT."
        )
    return [course.repository.requirement(name, folder) for name, folder in packages.items()]
