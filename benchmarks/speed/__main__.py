"""Print every ratio as a line `ratio NAME VALUE WAY`, after a line that explains it.

Pose graphs are solved in two ways, so they have two ratios: `VALUE numpy VALUE compiled`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import partial

from robust_slam.graphs.datasets import DatasetMissing
from tqdm import tqdm

from benchmarks.speed import descents, graduated, ways
from benchmarks.speed.clock import Figure

GRAPHS = ("CSAIL", "intel", "M3500", "city10000", "sphere2500", "torus3D", "parking-garage")
SPOILED = ("intel", "M3500", "sphere2500")
PERCENT = (10, 30, 50)


def measurements() -> dict[str, Callable[[], Figure | str]]:
    """Return what is measured, by the names of the figures."""
    found: dict[str, Callable[[], Figure | str]] = {"kernels": ways.measure}
    for graph in GRAPHS:
        found[f"gn/{graph}"] = partial(descents.measure, graph)
    for graph in SPOILED:
        for percent in PERCENT:
            found[f"gnc/{graph}/{percent}"] = partial(graduated.measure, graph, percent)
    return found


def chosen(names: list[str], only: list[str]) -> list[str]:
    """Return the names that are in ``only`` or below one of it, all if it is empty.

    Raises:
        ValueError: nothing has one of these names.
    """
    below = {part: [name for name in names if f"{name}/".startswith(f"{part}/")] for part in only}
    for wanted, found in below.items():
        if not found:
            raise ValueError(f"there is no figure {wanted}; the figures are {', '.join(names)}")
    return [name for name in names if not only or any(name in found for found in below.values())]


def main() -> int:
    """Measure; return 0, 1 where a figure could not be had, 2 where there is no such figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="such as gn/intel")
    only = parser.parse_args().only
    everything = measurements()
    try:
        names = chosen(list(everything), only)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    missing = 0
    for name in tqdm(names, unit="figure"):
        try:
            told = line(name, everything[name]())
        except (RuntimeError, DatasetMissing) as error:
            told, missing = f"none for {name}: {error}", missing + 1
        tqdm.write(told)
        sys.stdout.flush()
    return 1 if missing else 0


def line(name: str, found: Figure | str) -> str:
    """Return what is printed: for a ratio its remark, and below it the ratio on a line."""
    if isinstance(found, str):
        return f"{name} {found}"
    return f"  {found.remark}\nratio {name} {found.ratios}"


if __name__ == "__main__":
    sys.exit(main())
