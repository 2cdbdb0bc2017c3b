"""Hostile submissions: none gains a mark, learns a secret, harms a neighbour or stops a batch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.sandbox import Bubblewrap

from tests.autograder import hostile, toy
from tests.autograder.hostile import Attack

pytestmark = pytest.mark.sandbox
SEED = 20_261
LIMITS = "[limits]\ncall_seconds = 0.4\ncell_seconds = 1.5\nnotebook_seconds = 30\n"


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory, bubblewrap: Bubblewrap) -> Path:
    """The results of one batch that holds every attack and an honest neighbour."""
    folder = tmp_path_factory.mktemp("hostile")
    tree = toy.make_tree(folder, LIMITS)
    paths = [toy.hand_in(folder / "submitted", "neighbour", toy.answer())]
    for attack in hostile.ATTACKS:
        path = folder / "submitted" / attack.name / toy.NAME
        attack.write(path)
        paths.append(path)
    command = ["--solutions", tree, "grade", *paths, "--out", folder / "out"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COURSE_TOKEN", hostile.TOKEN)
        status = cli.main([*map(str, command), "--jobs", "2", "--seed", str(SEED)])
    (folder / "out" / "status.txt").write_text(str(status))
    return folder / "out"


@pytest.mark.parametrize("attack", hostile.ATTACKS, ids=lambda attack: attack.name)
def test_an_attack_earns_no_more_than_its_honest_part(out: Path, attack: Attack) -> None:
    value = toy.result(out, attack.name)
    assert value["status"] == attack.status, value["reason"]
    assert value["score"] <= attack.most
    assert value["max_score"] == toy.MOST
    if attack.status == "refused":
        assert value["reason"].endswith(".") and value["reason"].count(". ") == 0
    if attack.exercise:
        assert exercise(value, "double")["status"] == attack.exercise


@pytest.mark.parametrize("attack", hostile.ATTACKS, ids=lambda attack: attack.name)
def test_what_is_honest_in_an_attack_keeps_its_marks(out: Path, attack: Attack) -> None:
    """The other exercise is right: a hang, a death or a trick costs its own exercise alone."""
    if attack.status == "graded" and attack.most >= hostile.APPLY_POINTS:
        assert exercise(toy.result(out, attack.name), "apply")["status"] == "passed"


@pytest.mark.parametrize("attack", hostile.ATTACKS, ids=lambda attack: attack.name)
def test_no_result_tells_a_secret(out: Path, attack: Attack) -> None:
    text = (out / attack.name / f"{toy.NAME}.json").read_text("utf-8")
    secrets = [toy.CANARY, hostile.TOKEN, *toy.hidden_inputs(SEED), "hidden input", "hidden start"]
    assert [secret for secret in secrets if secret in text] == []


def test_the_neighbour_is_graded_as_if_alone(out: Path) -> None:
    value = toy.result(out, "neighbour")
    assert value["score"] == toy.MOST
    assert {e["status"] for e in value["exercises"]} == {"passed"}


def test_the_batch_goes_through(out: Path) -> None:
    assert (out / "status.txt").read_text() == "0"
    graded = {path.parent.name for path in out.glob(f"*/{toy.NAME}.json")}
    assert graded == {"neighbour", *(attack.name for attack in hostile.ATTACKS)}


def test_no_process_survives_its_grading(out: Path) -> None:
    assert out.is_dir()
    commands = [
        path.read_bytes() for path in Path("/proc").glob("[0-9]*/cmdline") if readable(path)
    ]
    assert not [text for text in commands if hostile.SLEEPER.encode() in text]


def exercise(value: dict[str, Any], name: str) -> dict[str, Any]:
    (found,) = [e for e in value["exercises"] if e["name"] == name]
    return dict(found)


def readable(path: Path) -> bool:
    try:
        return bool(path.read_bytes())
    except OSError:
        return False
