"""The grader's README speaks of every command."""

import argparse
import re
from pathlib import Path

from robust_slam_autograder.commands import declare


def test_every_command_has_a_line_in_the_overview_and_its_exit_statuses_in_the_table():
    commands = argparse.ArgumentParser().add_subparsers()
    declare(commands)
    text = Path(__file__).resolve().parents[1].joinpath("README.md").read_text("utf-8")
    overview = re.findall(r"^autograder ([a-z-]+)", text, re.M)
    rows = text.split("\n| exit status |")[1].split("\n\n")[0].splitlines()[2:]
    listed = [name for row in rows for name in re.findall(r"`([a-z-]+)`", row.split("|")[1])]
    assert sorted(overview) == sorted(listed) == sorted(commands.choices)
