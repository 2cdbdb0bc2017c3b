"""The picture of chapter 9 that compares starts and methods: the start, or graduation?"""

from __future__ import annotations

import csv
from importlib.resources import files
from typing import Any

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from robust_slam_course.canvas.picture import Picture
from robust_slam_course.quiz import ask
from robust_slam_course.style import figure_style

_STARTS = ("odometry", "least squares")
_CLAIM = 2  # the place of the true σ among those that are claimed
_METHODS = ("IRLS-TLS", "GNC-TLS", "IRLS-GM", "GNC-GM")


def graduation() -> Picture:
    """Return good maps of two starts and four methods, over odometry noise and claimed σ."""
    data = _counts()
    return Picture(
        name="graduation",
        title="The start, or graduation?",
        question=ask(
            "What saves more maps from 50 % consistent outliers, at 0.05 rad a step?",
            {
                "the start": "From odometry the methods find 20 maps, from least squares 7; GNC"
                " finds 16, IRLS 11.",
                "graduation": "GNC finds 16 maps and IRLS 11, but from odometry the two find 20,"
                " from least squares 7.",
                "both alike": "The start makes a difference of 13 maps (20 against 7), graduation"
                " one of 5 (16 against 11).",
            },
            right="the start",
        ),
        tries=[
            "drag the point up and down. Which method fails first when the claimed σ is too small,"
            " and which one is best when it is eight times too large?",
            "drag the point to noisier odometry. What becomes of the methods that start from least"
            " squares? And with 75 % outliers?",
        ],
        caption=f"The odometry has {data['noises'][0]:g} rad of noise a step and claims its true"
        f" σ, and 50 % of the closures are random outliers. {_told(data, 'random 50')}.",
        state={
            "start": _STARTS[0],
            "kernel": "TLS",
            "kind": "random",
            "percent": "50",
            "noise": 0,
            "claim": _CLAIM,
        },
        answer={"kind": "consistent", "noise": 3},
        data=data,
        still=_counts_still(data, "random 50"),
    )


def _told(data: dict[str, Any], kind: str) -> str:
    """Return the good maps of each method from both starts, for the first noise and claim."""
    starts = " / ".join(data["starts"])
    counts = np.array(data["good"][kind])[:, :, _CLAIM, 0]
    told = [f"{m} {' / '.join(map(str, n))}" for m, n in zip(_METHODS, counts.T, strict=True)]
    return f"Good maps of {data['runs']}, from {starts}: {', '.join(told)}"


def _counts() -> dict[str, Any]:
    """Return the table of `tools/data/graduation.py` for the script.

    Under "good" the counts of each kind and percent of outliers are nested by start, method,
    claimed σ and noise.
    """
    text = files(__package__).joinpath("graduation.csv").read_text(encoding="utf-8")
    first, *lines = text.splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    noises, claims = (sorted({float(row[key]) for row in rows}) for key in ("noise", "claim"))
    place = {(r["kind"], r["percent"], float(r["noise"]), float(r["claim"])): r for r in rows}
    good = {
        f"{kind} {percent}": [
            [
                [
                    [int(place[kind, percent, n, c][f"{m} from {s}"]) for n in noises]
                    for c in claims
                ]
                for m in _METHODS
            ]
            for s in _STARTS
        ]
        for kind in ("random", "consistent")
        for percent in ("50", "75")
    }
    runs = int(first.split(":")[0].rsplit(" ", 1)[1])
    return {
        "starts": _STARTS, "methods": _METHODS, "noises": noises, "claims": claims, "runs": runs,
        "good": good,
    }  # fmt: skip


@figure_style()
def _counts_still(data: dict[str, Any], kind: str) -> Figure:
    """Return the heat maps of both starts."""
    figure, axes = plt.subplots(4, 2, figsize=(5.0, 6.6), sharex=True, sharey=True)
    for s, start in enumerate(data["starts"]):
        for m, method in enumerate(data["methods"]):
            ax, grid = axes[m, s], np.array(data["good"][kind][s][m])
            ax.imshow(grid, origin="lower", cmap="Blues", vmin=0, vmax=data["runs"], aspect="auto")
            ax.set_title(f"{method} from {start}", fontsize=10)
            ax.set_xticks(range(len(data["noises"])), [f"{noise:g}" for noise in data["noises"]])
            ax.set_yticks(range(len(data["claims"])), ["¼", "½", "1", "2", "4", "8"])
            ax.tick_params(labelsize=9, length=0)
            ax.grid(visible=False)
    figure.supxlabel("odometry noise (rad a step)", fontsize=10)
    figure.supylabel("claimed σ / true σ", fontsize=10)
    return figure
