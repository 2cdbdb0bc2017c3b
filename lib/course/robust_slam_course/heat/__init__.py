"""The heat map of the benchmark: methods by shares of outliers, for the kinds and graphs one asks.

It is one table of good maps in percent, sorted by its last column. Without scripts and on paper it
holds all kinds and graphs together; with them tabs choose a kind, chips a graph, and a cell that
is pointed at or focused says its number as a sentence.
"""

import itertools
import json
from collections.abc import Iterable, Mapping
from html import escape
from importlib import resources
from typing import Any

from robust_slam_course.results import Results
from robust_slam_course.style import variables

ALL = "all"
COUNTED = ("good", "runs")
GRAPHS = {"manhattan": "Town", "sphere": "Sphere", "intel": "Intel"}
"""Names of graphs for readers, where they are not the file's."""


class HeatMap:
    """The shares of good maps in some results, as HTML.

    Args:
        results: the benchmark's, with the columns ``method``, ``kind``, ``graph`` and ``percent``.
        limits: methods that are no contestants, shown as they are and in their place.
    """

    def __init__(self, results: Results, limits: Iterable[str] = ()) -> None:
        self.results, self.limits = results, frozenset(limits)

    def table(self) -> dict[str, list[float]]:
        """Return for each method the shares at each percentage and over all, the best first."""
        percents = self.results.names("percent")
        rows = {
            method: [
                *(self.results.share(method=method, percent=percent) for percent in percents),
                self.results.share(method=method),
            ]
            for method in self.results.names("method")
        }
        return dict(sorted(rows.items(), key=lambda row: -row[1][-1]))

    def _repr_html_(self) -> str:
        heads = [*(f"{percent} %" for percent in self.results.names("percent")), "mean"]
        head = "".join(f'<th scope="col">{name}</th>' for name in heads)
        rows = "".join(self._row(method, shares) for method, shares in self.table().items())
        names = self.results.names
        kinds = {ALL: "All kinds"} | {name: name.capitalize() for name in names("kind")}
        graphs = {ALL: "All maps"} | {name: GRAPHS.get(name, name) for name in names("graph")}
        data = json.dumps(self._data(kinds, graphs), separators=(",", ":")).replace("<", "\\u003c")
        style = f":where(html) {{ {variables('light')} }}{_read('heat.css')}"
        return (
            f'<div class="rs-heatmap"><style>{style}</style>'
            f"{_choice('kind', 'Outliers', kinds)}{_choice('graph', 'Map', graphs)}"
            '<p class="rs-said" role="status">Good maps in percent of the runs; the columns are '
            "shares of outliers among the closures.</p>"
            "<table><caption>Good maps in percent, by the share of outliers</caption><thead><tr>"
            f'<th scope="col">Method</th>{head}</tr></thead><tbody>{rows}</tbody></table>'
            f'<script type="application/json">{data}</script><script>{_read("heat.js")}</script>'
            "</div>"
        )

    def _row(self, method: str, shares: Iterable[float]) -> str:
        name, _, start = method.partition(" from ")
        place = f" <small>from {escape(start)}</small>" if start else ""
        limit = ' class="rs-limit"' if method in self.limits else ""
        cells = "".join(
            f'<td style="--share: {share:.2f}">{100 * share:.0f}</td>' for share in shares
        )
        return (
            f'<tr{limit} data-method="{escape(method)}"><th scope="row">{escape(name)}{place}</th>'
            f"{cells}</tr>"
        )

    def _data(self, kinds: Mapping[str, str], graphs: Mapping[str, str]) -> dict[str, Any]:
        """Return names, and by method the counts by kind, graph and percent, in their order."""
        percents = self.results.names("percent")
        rows = {
            tuple(row[name] for name in ("method", "kind", "graph", "percent")): row
            for row in self.results.rows
        }
        counts = {
            method: [
                [int(row[name]) if (row := rows.get((method, *cell))) else 0 for name in COUNTED]
                for cell in itertools.product([*kinds][1:], [*graphs][1:], percents)
            ]
            for method in self.results.names("method")
        }
        return {"counts": counts, "kinds": kinds, "graphs": graphs, "percents": percents}


def _choice(name: str, legend: str, options: Mapping[str, str]) -> str:
    """Return radio buttons, of which the first is chosen; a script shows them."""
    buttons = "".join(
        f'<label><input type="radio" name="rs-{name}" value="{escape(value)}"'
        f"{' checked' if value == ALL else ''}>{escape(label)}</label>"
        for value, label in options.items()
    )
    return f'<fieldset class="rs-choice" hidden><legend>{legend}</legend>{buttons}</fieldset>'


def _read(name: str) -> str:
    return resources.files(__package__).joinpath(name).read_text("utf-8")
