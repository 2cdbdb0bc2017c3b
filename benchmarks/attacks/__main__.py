"""Runs both graders on all submissions and prints the tables; see the package."""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from importlib.metadata import version
from pathlib import Path

import numpy as np
from robust_slam_autograder.sandbox import BACK_ENDS
from tqdm import tqdm

from benchmarks.attacks import container, evidence, ours, plain, tables
from benchmarks.attacks.ours import How
from benchmarks.attacks.plain import Plain, Settled
from benchmarks.attacks.record import Records
from benchmarks.attacks.tables import Side
from tests.autograder import toy
from tests.autograder.hostile import catalogue
from tests.autograder.hostile.entry import Entry
from tests.autograder.hostile.target import Target, load

ROOT = Path(__file__).resolve().parents[2]
SEED = 20_260_917
TOKEN = "planted-token-5e5bbf8a"
TOY_SETTINGS = 'withheld = ["xml.dom"]\n'


def main() -> None:
    """Grade what is asked for and print the tables."""
    options = _options()
    problem = container.problem()
    if problem is not None:
        raise SystemExit(f"nbgrader must not grade this without a container: {problem}")
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="attacks-") as folder:
        tree = _tree(options.assignment, Path(folder))
        target = load(tree, options.assignment, Path(folder) / "release")
        entries = _chosen(options)
        sides = _run(options, Path(folder), tree, target, entries)
    print(_header(options, target, entries))
    print(tables.summary(entries, sides, target))
    print(f"\nBy kind, {' / '.join(side.name for side in sides)}:\n")
    print(tables.by_kind(entries, sides, target))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.attacks")
    parser.add_argument("--assignment", default="03-irls", help=f"or {toy.NAME}, a small one")
    parser.add_argument("--only", metavar="KIND", help="kinds that begin so, as in reading")
    parser.add_argument("--sample", type=int, metavar="N", help="so many submissions by chance")
    parser.add_argument("--jobs", type=int, default=2, metavar="N")
    parser.add_argument("--group", type=int, default=8, help="submissions of one nbgrader batch")
    parser.add_argument("--cell-seconds", type=int, default=10, help="for one cell, on both sides")
    parser.add_argument("--sandbox", choices=list(BACK_ENDS), help="the grader's; else the first")
    parser.add_argument("--pace", type=int, default=40, help="right submissions to time")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("build/attacks"),
        metavar="DIR",
        help="keeps what is known: the same command again goes on from there",
    )
    return parser.parse_args()


def _tree(name: str, folder: Path) -> Path:
    return toy.make_tree(folder / "toy", TOY_SETTINGS) if name == toy.NAME else ROOT / "solutions"


def _chosen(options: argparse.Namespace) -> list[Entry]:
    """The submissions that are asked for, with all that they are compared with."""
    entries = [e for e in catalogue.entries() if e.kind and e.kind.startswith(options.only or "")]
    if options.sample is not None and options.sample < len(entries):
        rng = np.random.default_rng(0)
        picked = sorted(rng.choice(len(entries), options.sample, replace=False))
        entries = [entries[n] for n in picked]
    if not entries:
        raise SystemExit(f"There is no kind that begins with {options.only!r}.")
    return [*catalogue.PLAIN, *entries]


def _run(
    options: argparse.Namespace, folder: Path, tree: Path, target: Target, entries: Sequence[Entry]
) -> list[Side]:
    wall = options.sandbox or "default"
    known = Records(options.out / f"{target.name}-{options.cell_seconds}s-{wall}.json")
    course = plain.make(
        folder / "course", tree, target, _secrets(target, True), SEED, options.cell_seconds
    )
    how = How(
        tree,
        target.name,
        SEED,
        _secrets(target, False),
        options.cell_seconds,
        options.jobs,
        options.sandbox,
    )
    pace = options.pace
    per_minute = {
        plain.SIDE: 60 * pace / plain.seconds_for(course, pace, 0),
        ours.SIDE: 60 * pace / ours.seconds_for(how, pace),
    }
    missing = [entry for entry in entries if entry.name not in known.of(ours.SIDE)]
    if missing:
        known.add(ours.SIDE, ours.grade(how, missing))
    missing = [entry for entry in entries if entry.name not in known.of(plain.SIDE)]
    _grade_plainly(course, missing, known, options)
    return [Side(name, known.of(name), pace) for name, pace in per_minute.items()]


def _secrets(target: Target, one_generator: bool) -> evidence.Secrets:
    return evidence.secrets(target, SEED, TOKEN, one_generator=one_generator)


def _grade_plainly(
    course: Plain, entries: Sequence[Entry], known: Records, options: argparse.Namespace
) -> None:
    """Grade batches side by side; what must be graded once more joins the queue."""
    waiting, number = plain.groups(entries, options.group), 0
    running: set[Future[Settled]] = set()
    with (
        ThreadPoolExecutor(options.jobs) as pool,
        tqdm(total=len(entries), unit="submission") as bar,
    ):
        while waiting or running:
            while waiting and len(running) < options.jobs:
                number += 1
                running.add(pool.submit(plain.grade, course, waiting.pop(0), number))
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for settled in (future.result() for future in done):
                known.add(plain.SIDE, settled.records)
                bar.update(len(settled.records))
                waiting += settled.again


def _header(options: argparse.Namespace, target: Target, entries: Sequence[Entry]) -> str:
    names = ("nbgrader", "robust-slam-autograder", "ipykernel", "numpy")
    versions = [f"Python {sys.version.split()[0]}", *(f"{name} {version(name)}" for name in names)]
    bwrap = subprocess.run(["bwrap", "--version"], capture_output=True, text=True).stdout.strip()
    count = sum(bool(entry.kind) for entry in entries)
    back_end = options.sandbox or next(n for n, b in BACK_ENDS.items() if b.problem() is None)
    return "\n".join(
        [
            f"`python -m benchmarks.attacks {shlex.join(sys.argv[1:])}`",
            "",
            f"{count} submissions of {target.name}; {options.cell_seconds} s for a cell; "
            f"{', '.join(versions)}, {bwrap}; sandbox {back_end}; "
            f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors.",
            "",
        ]
    )


if __name__ == "__main__":
    main()
