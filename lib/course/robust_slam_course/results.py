"""The results file of the benchmark: what its header states, and shares of good maps.

A line that begins with # is an entry of the header, ``# name: value`` with a value in JSON.
The other lines are CSV, a row for each graph, kind of outliers, rate and method.
"""

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
        """Return a folded table, in Markdown, of what the results depend on."""
        given = self.header["parameters"]
        graphs = self.header["graphs"]
        closures = sorted({graph["closures"] for graph in graphs.values()})
        towns = {"manhattan": "town"}
        seeds = (f"{towns.get(name, name)} {graph['seeds']}" for name, graph in graphs.items())
        chance, width = given["mixture"]
        matched = given["matched mixture"]
        rows = {
            "results": f"version {self.header['version']}, {self.header['runs']} runs",
            "seeds": ", ".join(seeds),
            "correct closures": " or ".join(map(str, closures)),
            "outliers in a group": self.header["group"],
            "good map": f"ATE at most {self.header['good']} m",
            "threshold $c$": f"{given['c']['3']:.3f} in the plane, {given['c']['6']:.3f} in "
            f"space; an inlier is below it with probability {given['probability']}",
            "Gauss–Newton": f"{given['steps']} step for each set of weights",
            "linear solves": f"at most {given['solves']}, of which a start from least squares may "
            f"use {given['solves of the start']}",
            "at rest": f"no norm $u$ changes by more than {given['tol']:g} of $1 + u$",
            "GNC": f"$\\mu$ changes by the factor {given['factor']}; after GNC-GM, IRLS at "
            "$\\mu = 1$",
            "Cauchy": f"constants {given['cauchy']['3']} and {given['cauchy']['6']}, for 95 % "
            "efficiency",
            "switches, DCS": "$\\lambda = \\Phi = c^2$; IRLS-GM from odometry is the closed "
            "form of the switches",
            "max-mixture": f"inlier probability {chance}, outliers {width:g} times as wide; "
            f"matched: {matched:g} times as wide, and the mode changes at $c$",
            "RTAB-Map's rule": f"undoes a closure beyond {given['RTAB-Map']:g} deviations",
            "Kimera-RPGO": f"tests pairs with {given['Kimera-RPGO']:g}",
            "odometry": "trusted, and the start where none is named; GTSAM is told it as known "
            "inliers, with its defaults otherwise",
        }
        lines = "\n".join(f"| {name} | {value} |" for name, value in rows.items())
        return f":::{{dropdown}} All settings\n\n| setting | value |\n|---|---|\n{lines}\n:::"


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
