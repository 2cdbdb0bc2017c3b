"""The results file of the benchmark: what its header states, and shares of good maps.

A line that begins with # is an entry of the header, ``# name: value`` with a value in JSON.
The other lines are CSV, a row for each graph, kind of outliers, rate and method.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Row = Mapping[str, str]


@dataclass(frozen=True)
class Results:
    """The header, and the rows with the names of their columns."""

    header: Mapping[str, Any]
    rows: tuple[Row, ...]

    def names(self, column: str) -> list[str]:
        """Return the different entries of a column, in the order of the file."""
        return list(dict.fromkeys(row[column] for row in self.rows))

    def where(self, **wanted: str) -> Iterator[Row]:
        """Yield the rows that have the ``wanted`` entries."""
        return (row for row in self.rows if all(row[key] == wanted[key] for key in wanted))

    def good(self, **wanted: str) -> tuple[int, int]:
        """Return the number of good maps, and of runs, in these rows."""
        rows = list(self.where(**wanted))
        return sum(int(row["good"]) for row in rows), sum(int(row["runs"]) for row in rows)

    def share(self, **wanted: str) -> float:
        """Return the share of good maps in these rows, NaN where nothing was run."""
        good, runs = self.good(**wanted)
        return good / runs if runs else float("nan")

    def conditions(self) -> str:
        """Return a list, in Markdown, of what the results depend on."""
        given = self.header["parameters"]
        graphs = self.header["graphs"]
        closures = sorted({graph["closures"] for graph in graphs.values()})
        seeds = ", ".join(f"{name} {graph['seeds']}" for name, graph in graphs.items())
        chance, width = given["mixture"]
        return (
            f"- These are results {self.header['version']}, of {self.header['runs']} runs.\n"
            f"- The numbers of seeds are {seeds}; each world has "
            f"{' or '.join(map(str, closures))} correct closures, and a group has "
            f"{self.header['group']} outliers.\n"
            f"- A map is good if its ATE is at most {self.header['good']} m.\n"
            f"- An inlier is below the threshold $c$ with probability {given['probability']}, so "
            f"$c$ is {given['c']['3']:.3f} in the plane and {given['c']['6']:.3f} in space.\n"
            f"- Each set of weights has {given['steps']} Gauss–Newton step, and a run has at most "
            f"{given['solves']} linear solves, of which a start from least squares may use "
            f"{given['solves of the start']}. A map is at rest when no norm changes by more than "
            f"{given['tol']:g} of $1 + u$.\n"
            f"- GNC changes $\\mu$ by the factor {given['factor']}, and GNC-GM is followed by "
            f"IRLS at $\\mu = 1$.\n- Cauchy's constants are {given['cauchy']['3']} and "
            f"{given['cauchy']['6']}, for 95 % efficiency, the switches have $\\lambda = c^2$, "
            f"with IRLS-GM from odometry as their closed form, and DCS has $\\Phi = c^2$.\n"
            f"- Max-mixture has the inlier probability {chance} and outliers {width:g} times as "
            f"wide; where it is matched, outliers are {given['matched mixture']:g} times as wide, "
            "and the probability is such that the mode changes at $c$.\n"
            f"- RTAB-Map's rule undoes a closure after an error of {given['RTAB-Map']:g} "
            f"deviations, and Kimera-RPGO tests pairs with {given['Kimera-RPGO']:g}.\n"
            "- The odometry is trusted, which GTSAM, with its defaults otherwise, is told as "
            "known inliers. Where no start is named, it is the odometry."
        )


def read_results(path: str | Path) -> Results:
    """Return the results in a file.

    Raises:
        FileNotFoundError: it is not there.
        ValueError: an entry of the header is not JSON.
    """
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    entries = (line[1:].split(":", 1) for line in lines if line.startswith("#"))
    header = {name.strip(): json.loads(value) for name, value in entries}
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return Results(header, tuple(rows))
