"""What the page *Your own graph* asks of Python: to read a file, to solve it, to doubt it.

``ask`` takes and returns JSON, and keeps the case, a file and its answer, from one question to
the next. Each answer holds what the page draws and the sentences that it shows; where a file
cannot be read it is the ``problem``, with the lines around it.
"""

import json
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import robust_slam as rs
from robust_slam.certificates.optimality import Verdict
from robust_slam.descent import start
from robust_slam.estimators import irls, kernels
from robust_slam.files.graph_file import GraphFile
from robust_slam.files.trajectories import other_orders
from robust_slam.graphs import PoseGraph, add_random_closures, manhattan, sphere
from robust_slam.graphs.odometry import dead_reckoning
from robust_slam.graphs.pose_graph import relative_poses, residual_norms, residuals_of
from robust_slam.problems import PoseGraphProblem
from robust_slam.solver import Answer, Support
from robust_slam.solver.noise import noise_words, rescaled
from robust_slam.solver.readings import better_reading, swapped_closures

Given = dict[str, Any]
Tell = Callable[[str], object]

MANY = 20_000
"""With more edges the page first says how to do it outside of a browser."""
SECONDS = 20.0
"""The search ends after so long; a thorough one after ten times as long."""
PLAIN_SECONDS = 2.0
"""Least squares end after so long, wherever they are."""
AS_CLAIMED = 0.5, 2.0
"""Noise between these shares of the claims needs no remark, as in ``Answer.notes``."""
AROUND = 2
"""Lines shown before and after the one that is wrong."""
HERE = (
    (r'with unknown="skip"', "under Options"),
    (r'read with indefinite="nearest" or "isotropic"', "choose what to take under Options"),
    (r"odometry=\(0.05, 0.01\) in m and rad", "0.05 m and 0.01 rad, under Options"),
    (r"--closure (\S+), or False in is_odometry \(entry \d+\)", r"write \1 under Options"),
)
"""Remedies of the library as the page has them."""


@dataclass(frozen=True)
class Case:
    """A file as read with these ``options``, and the numbers of steps that are loop closures."""

    path: Path
    options: dict[str, Any]
    not_steps: list[int]
    file: GraphFile
    answer: Answer | None = None


CASES: list[Case] = []
"""The last one alone."""


def ask(question: str, given: str, tell: Tell) -> str:
    """Answer a question of the page, one of ``QUESTIONS``; both are JSON."""
    return json.dumps(QUESTIONS[question](json.loads(given), tell))


def read(given: Given, tell: Tell) -> dict[str, Any]:
    """Read the file ``name``, or write and read the ``example``; say what is in it.

    ``odometry`` (m, rad), ``closures``, ``unknown`` and ``indefinite`` are options of ``rs.read``
    where they are there, and ``not_steps`` are pairs such as 39-1000.
    """
    CASES.clear()
    path = Path(EXAMPLES[given["example"]]() if "example" in given else given["name"])
    names = ("odometry", "closures", "unknown", "indefinite")
    options = {name: given[name] for name in names if given.get(name)}
    tell(f"Reading {path} …")
    try:
        file = rs.read(path, **options)
        not_steps = edges_named(file, given.get("not_steps", ""))
    except (ValueError, OSError) as error:
        return {"name": str(path), **problem(str(error))}
    steps = file.graph.is_odometry.copy()
    steps[not_steps] = False
    file = replace(file, graph=replace(file.graph, is_odometry=steps))
    CASES.append(Case(path, options, not_steps, file))
    graph = file.graph
    return {
        "name": str(path),
        "rows": rows_of(graph.summary(), 10),
        "remarks": [here(words) for words in file.remarks()],
        "command": command(CASES[0]),
        "many": len(graph.edges) > MANY,
        "edges": len(graph.edges),
    }


def edges_named(file: GraphFile, words: str) -> list[int]:
    """Return the odometry between pairs of ids such as ``39-1000, 7-8``."""
    found: list[int] = []
    for pair in re.split(r"[,;\s]+", words.strip()) if words.strip() else []:
        i, _, j = pair.partition("-")
        named = file.steps_between(i, j)
        if not np.any(named):
            raise ValueError(f"{pair}: no odometry joins these ids; give two as in 39-1000")
        found += np.flatnonzero(named).tolist()
    return found


def problem(message: str) -> dict[str, Any]:
    """Return a message, and the lines around the one that it names."""
    found = re.match(r"(.+?):(\d+): ", message)
    lines: list[tuple[int, str]] = []
    if found:
        text = Path(found[1]).read_text(encoding="utf-8", errors="replace").split("\n")
        number = int(found[2])
        last = min(len(text), number + AROUND)
        lines = [(k, text[k - 1][:200]) for k in range(max(1, number - AROUND), last + 1)]
    return {"problem": here(message), "line": int(found[2]) if found else 0, "lines": lines}


def here(words: str) -> str:
    """Return words of the library with the page's own remedies."""
    for remedy, ours in HERE:
        words = re.sub(remedy, ours, words)
    return words


def rows_of(table: str, width: int) -> list[tuple[str, str]]:
    """Return the lines of a table of the library as pairs of a name and words."""
    return [(line[:width].strip(), line[width:].strip()) for line in table.splitlines()]


def solve(given: Given, tell: Tell) -> dict[str, Any]:
    """Solve the case, and return all that the page shows of it, or a problem.

    It takes longer if it is ``thorough``.
    """
    case, thorough = CASES[0], bool(given.get("thorough"))
    graph, names = case.file.graph, case.file.names
    seconds = SECONDS * (10 if thorough else 1)
    try:
        answer = rs.solve(graph, max_seconds=seconds, progress=tell)
    except ValueError as error:
        return problem(str(error))
    CASES[0] = case = replace(case, answer=answer)
    tell("the map of least squares is found")
    plain = least_squares(graph)
    notes = answer.notes(names)
    axes = longest_axes(graph, answer.poses)
    return {
        "rows": rows_of(answer.summary(names), 8)[: -len(notes) or None],
        "verdict": answer.verdict,
        "trusted": answer.certificate.verdict is Verdict.CERTIFIED
        and answer.support is Support.UNIQUE
        and not case.file.doubts,
        "notes": [*notes, *noise_told(answer), *swapped_told(case)],
        "late": answer.late and not thorough,
        "axes": ["xyz"[axis] for axis in axes],
        "robust": seen(graph, answer.poses, axes),
        "plain": seen(graph, plain, axes),
        "names": [str(name) for name in names],
        "edges": graph.edges.tolist(),
        "steps": graph.is_odometry.tolist(),
        "kept": answer.kept.tolist(),
        "trunk": trunk(answer).tolist(),
        "about": about(case),
        "size": np.round(tested(answer), 3).tolist(),
        "python": python(case),
        "command": command(case),
        "files": written(case),
    }


def reading(given: Given, tell: Tell) -> dict[str, Any]:
    """Ask whether the edges fit better when they are read in another way."""
    answer = CASES[0].answer
    assert answer is not None
    better = better_reading(
        answer, others=other_orders(CASES[0].file), progress=tell, max_seconds=SECONDS
    )
    other = (better.words, better.answer) if better else wider(answer, tell)
    if other is None:
        return {"found": False, "words": "No other reading rejects half as many closures."}
    count, fewer = (f"{one.rejected.size:,}" for one in (answer, other[1]))
    words = f"Read {other[0]}, {fewer} edges would be rejected instead of {count}."
    return {"found": True, "words": f"{words} If the file was meant so, write it so."}


def wider(answer: Answer, tell: Tell) -> tuple[str, Answer] | None:
    """Return the answer with deviations ten times as large, if it rejects half as many edges.

    The noise is found from the closures that are kept, of which there may be too few where the
    deviations are claimed much too small.
    """
    graph, rejected = answer.graph, answer.rejected.size
    if 2 * rejected <= np.sum(~graph.is_odometry):
        return None
    words = "with deviations ten times as large"
    tell(f"the graph is read {words}")
    coarse = replace(graph, information=graph.information / 100.0)
    other = rs.solve(coarse, max_seconds=SECONDS)
    return (words, other) if 2 * other.rejected.size <= rejected else None


def least_squares(graph: PoseGraph) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the map with all edges, a few steps from the chordal one."""
    all_edges = np.ones(len(graph.edges), dtype=np.bool_)
    first = start.chordal(graph)
    step = PoseGraphProblem(graph, first, all_edges, steps=1)
    return irls(
        step, kernels.squared(), first, tol=1e-3, max_iterations=30, max_seconds=PLAIN_SECONDS
    ).x


def longest_axes(graph: PoseGraph, poses: np.ndarray[Any, Any]) -> list[int]:
    """Return the two coordinates, ascending, along which a map is longest."""
    extent = np.ptp(graph.group.translation(poses), axis=0)
    return sorted(np.argsort(-extent, kind="stable")[:2].tolist())


def seen(graph: PoseGraph, poses: np.ndarray[Any, Any], axes: list[int]) -> list[list[float]]:
    """Return the positions ``(n, 2)`` (m) along two axes."""
    places: list[list[float]] = np.round(graph.group.translation(poses)[:, axes], 4).tolist()
    return places


def trunk(answer: Answer) -> np.ndarray[Any, Any]:
    """Return the edges ``(m,)`` along which cycles are shown: kept odometry, and bridges."""
    bridges = np.isin(np.arange(len(answer.kept)), answer.bridges.edges)
    return (answer.graph.is_odometry & answer.kept) | bridges


def tested(answer: Answer) -> np.ndarray[Any, Any]:
    """Return the residual of each edge in the deviations with which it was tested, ``(m,)``."""
    return residual_norms(rescaled(answer.graph, answer.best.tested), answer.poses)


def about(case: Case) -> list[str]:
    """Return a sentence about each edge: its residual, and why it was kept or not."""
    answer = case.answer
    assert answer is not None
    graph, d = answer.graph, answer.graph.group.DIMENSION
    off = residuals_of(graph, relative_poses(graph, answer.poses))
    metres, turn = (np.linalg.norm(part, axis=1) for part in (off[:, :d], off[:, d:]))
    size, why = tested(answer), reasons(answer)
    return [
        f"{why[k]} Its residual is {size[k]:.3g} deviations, {metres[k]:.2g} m and "
        f"{np.degrees(turn[k]):.3g}°."
        for k in range(len(why))
    ]


def reasons(answer: Answer) -> list[str]:
    """Return for each edge what became of it, and why."""
    limit = f"{answer.threshold:.3g} deviations"
    kept = f"kept, since it is within {limit}."
    words = np.where(answer.kept, kept, f"rejected, since it is beyond {limit}.").astype(object)
    near = tested(answer) <= answer.threshold
    words[answer.kept & ~near] = f"kept: it was within {limit} when the closures were chosen."
    words[~answer.kept & near] = f"rejected: it was beyond {limit} when the closures were chosen."
    words[answer.graph.is_odometry] = "kept, since odometry is trusted."
    words[answer.bridges.edges] = "trusted, because it joins two sessions."
    alone = [one.edge for one in answer.lone]
    words[alone] = "kept; a part of the map rests on this place alone."
    words[answer.slips] = "given up: the odometry slipped here."
    if answer.rival is not None:
        words[answer.rival & ~answer.kept] = "rejected; a rival map as good as this one keeps it."
    words[answer.misfit.closures] = "rejected, but closer to the map than outliers would be."
    words[swapped_closures(answer)] = "rejected; with i and j swapped it would fit."
    kind = np.where(answer.graph.is_odometry, "odometry, ", "a loop closure, ")
    return [a + b for a, b in zip(kind, words, strict=True)]


def noise_told(answer: Answer) -> list[str]:
    """Return a sentence about deviations that are claimed too small or too large."""
    low, high = AS_CLAIMED
    found = ["too small"] * bool(answer.noise.max() > high)
    found += ["too large"] * bool(answer.noise.min() < low)
    if not found:
        return []
    return [
        f"The file claims deviations that are {' or '.join(found)}: the kept edges show "
        f"{noise_words(answer.noise)}. Multiply σ by it, or divide the information by its square."
    ]


def swapped_told(case: Case) -> list[str]:
    """Return a sentence about closures that fit with i and j swapped, if there are any."""
    answer = case.answer
    assert answer is not None
    edges = swapped_closures(answer)
    if not edges.size:
        return []
    named = ", ".join(f"{i}-{j}" for i, j in case.file.names[answer.graph.edges[edges[:5]]])
    return [f"With i and j swapped these rejected closures fit ({edges.size:,}): {named}."]


def written(case: Case) -> dict[str, str]:
    """Return the files that can be downloaded, by what they are."""
    answer, file = case.answer, case.file
    assert answer is not None
    texts = {}
    graphs = {"clean.g2o": answer.clean, "poses.g2o": answer.graph, "poses.tum": answer.graph}
    for kind, graph in graphs.items():
        path = Path(f"page-graph.{kind}")
        rs.save(path, graph, answer.poses, names=file.ids, times=file.times)
        texts[kind] = path.read_text(encoding="utf-8")
        path.unlink()
    return texts


def python(case: Case) -> str:
    """Return the lines of Python that do the same."""
    given = "".join(f", {name}={value!r}" for name, value in case.options.items())
    lines = [
        "import robust_slam as rs",
        "",
        f"file = rs.read({str(case.path)!r}{given})",
        "answer = rs.solve(file.graph)",
        'print(file.summary(), answer.summary(file.names), sep="\\n\\n")',
        f"rs.save({case.path.stem + '-clean.g2o'!r}, answer.clean, answer.poses, names=file.ids)",
    ]
    if case.not_steps:
        lines[3:4] = [
            "steps = file.graph.is_odometry.copy()",
            f"steps[{case.not_steps}] = False  # these are loop closures",
            "graph = dataclasses.replace(file.graph, is_odometry=steps)",
            lines[3].replace("file.graph", "graph"),
        ]
        lines[:0] = ["import dataclasses", ""]
    return "\n".join(lines)


def command(case: Case) -> str:
    """Return the command that does the same."""
    words = ["robust-slam", "solve", str(case.path)]
    for name, value in case.options.items():
        words += [f"--{name}", *(map(str, value) if isinstance(value, list) else [str(value)])]
    for i, j in case.file.names[case.file.graph.edges[case.not_steps]]:
        words += ["--closure", f"{i}-{j}"]
    return shlex.join([*words, "--readings", "--clean", f"{case.path.stem}-clean.g2o"])


def town() -> str:
    """Write a town of 200 poses, of which 30 closures are wrong."""
    rng = np.random.default_rng(1)
    graph, truth = manhattan(200, rng, closures=70)
    graph, _ = add_random_closures(graph, 30, rng, poses=truth)
    return save("town.g2o", graph)


def precise() -> str:
    """Write a town that claims deviations a tenth as large as its noise."""
    rng = np.random.default_rng(2)
    graph, truth = manhattan(200, rng, closures=200)
    graph, _ = add_random_closures(graph, 15, rng, poses=truth)
    return save("too-precise.g2o", replace(graph, information=100.0 * graph.information))


def ball() -> str:
    """Write a sphere in space with wrong closures."""
    rng = np.random.default_rng(3)
    graph, truth = sphere(250, rng)
    graph, _ = add_random_closures(graph, 30, rng, poses=truth)
    return save("sphere.g2o", graph)


def broken() -> str:
    """Write a town in which a vertex is missing that an edge names."""
    path = Path(town()).rename("broken.g2o")
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[:119] + lines[120:]), encoding="utf-8")
    return str(path)


def save(name: str, graph: PoseGraph) -> str:
    """Write a graph with the poses of its odometry, and return the name of the file."""
    rs.save(name, graph, dead_reckoning(graph))
    return name


EXAMPLES = {"town": town, "precise": precise, "sphere": ball, "broken": broken}
QUESTIONS: dict[str, Callable[[Given, Tell], dict[str, Any]]] = {
    "read": read,
    "solve": solve,
    "reading": reading,
}
