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
        """Return the sentences, in Markdown, that say what the results depend on."""
        given = self.header["parameters"]
        graphs = self.header["graphs"]
        closures = sorted({graph["closures"] for graph in graphs.values()})
        seeds = ", ".join(f"{name} {graph['seeds']}" for name, graph in graphs.items())
        chance, width = given["mixture"]
        return (
            f"Results {self.header['version']}, {self.header['runs']} runs. "
            f"Correct closures: {' or '.join(map(str, closures))}; "
            f"seeds: {seeds}; outliers in groups of {self.header['group']}. "
            f"A map is good if its ATE is at most {self.header['good']} m. "
            f"Threshold $c$: probability {given['probability']}, "
            f"{given['c']['3']:.3f} in the plane and {given['c']['6']:.3f} in space. "
            f"One set of weights: {given['steps']} Gauss–Newton step. "
            f"Budget: {given['solves']} linear solves, the start included, for which least "
            f"squares has {given['solves of the start']}. "
            f"At rest: no norm changes by more than {given['tol']:g} of $1 + u$. "
            f"GNC: factor {given['factor']}; GNC-GM is followed by IRLS at $\\mu = 1$. "
            f"Cauchy: {given['cauchy']['3']} and {given['cauchy']['6']}, for 95 % efficiency. "
            f"Switches: $\\lambda = c^2$, and IRLS-GM from odometry is their closed form. "
            f"DCS: $\\Phi = c^2$. Max-mixture: inlier probability {chance}, outliers "
            f"{width:g} times as wide; matched, its mode changes at $c$, and outliers are "
            f"{given['matched mixture']:g} times as wide. RTAB-Map's rule undoes a closure after "
            f"an error of {given['RTAB-Map']:g} deviations. Kimera-RPGO: {given['Kimera-RPGO']:g} "
            "for pairs. Odometry is trusted. "
            "GTSAM runs with its defaults and the odometry as known inliers. Where no start "
            "is named, it is the odometry."
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
