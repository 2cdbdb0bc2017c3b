"""The command ``robust-slam``: a map from a file of a pose graph."""

import argparse
import dataclasses
import logging
import os
import sys
from collections.abc import Callable, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np

import robust_slam as rs
from robust_slam._arrays import Array, Indices, Mask
from robust_slam._words import counted, few
from robust_slam.certificates.optimality import MAX_SECONDS, Verdict
from robust_slam.errors import NotConverged
from robust_slam.factors.equations import FactorEquations
from robust_slam.factors.factor_graph import FRAME
from robust_slam.factors.reading import FactorFile, has_factors, read_factors
from robust_slam.factors.solve import solve_factors
from robust_slam.files.graph_file import GraphFile
from robust_slam.files.lines import Unknown, write_lines
from robust_slam.files.matrices import Repair
from robust_slam.files.reading import find, read
from robust_slam.files.trajectories import other_orders
from robust_slam.files.writing import SUFFIXES
from robust_slam.solver import Answer, Support, solve
from robust_slam.solver.readings import better_reading, swapped_closures

Found = TypeVar("Found")
_CLOSED, _INTERRUPTED, _REFUSED, _DOUBTFUL = 141, 130, 2, 1
_HERE = {
    'unknown="skip"': "--unknown skip",
    'indefinite="nearest" or "isotropic"': "--indefinite nearest or --indefinite isotropic",
    "odometry=(0.05, 0.01) in m and rad": "--odometry 0.05 0.01 in m and rad",
}
"""Remedies of the library in the syntax of the command."""
_FILES = {
    "closures": "loop closures of a trajectory, lines of g2o",
    "plot": "draw the map: .svg, .png or .pdf",
    "rejected": "write the ids and the whitened residual of each rejected edge",
}
_CHOICES = {
    "indefinite": (["raise", *get_args(Repair)], "information that is not positive definite"),
    "unknown": (get_args(Unknown), "lines with unknown tags, such as ranges"),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 for a map to be trusted, 1 for another, 2 for an error.

    An interrupt from the keyboard returns 130, a closed pipe 141.
    """
    options = _parser().parse_args(arguments)
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        code: int = options.run(options)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # Who reads the output may close it at any time, as `head` does. What Python writes at
        # its end goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _CLOSED
    except (OSError, ValueError, ImportError, NotConverged) as error:
        words = str(error)
        for remedy, ours in _HERE.items():
            words = words.replace(remedy, ours)
        print(f"robust-slam: {words}", file=sys.stderr)
        return _REFUSED
    except KeyboardInterrupt:
        print("\nrobust-slam: interrupted", file=sys.stderr)
        return _INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="robust-slam", description="Robust estimation on pose graphs."
    )
    parser.add_argument("--version", action="version", version=f"robust-slam {rs.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    command = commands.add_parser(
        "solve",
        help="find the map of a pose graph, its outliers and its certificate",
        description="Find the map of a pose graph, its outliers and its certificate. The exit "
        "code is 0 if the map is optimal for the kept closures, these have unique support, and "
        "nothing in the file looks wrong; 1 if not, as for each file with landmarks, priors or "
        "GPS, for whose map there is no proof; 2 if the file cannot be read.",
    )
    command.add_argument(
        "file",
        metavar="FILE",
        help="a graph of g2o, TORO or PyFactorGraph, a trajectory of TUM, KITTI or EuRoC, or the "
        "name of a public graph",
    )
    command.add_argument(
        "--odometry",
        type=float,
        nargs=2,
        metavar=("M", "RAD"),
        help="the standard deviations of a step of a trajectory",
    )
    command.add_argument(
        "--out",
        type=_output,
        metavar="FILE",
        help="write the poses: .g2o with all edges, .tum or .kitti in the order of the ids",
    )
    command.add_argument(
        "--clean",
        type=partial(_output, suffixes=[".g2o"]),
        metavar="FILE.g2o",
        help="write the kept edges alone, with the noise that was found, and the poses",
    )
    for name, words in _FILES.items():
        command.add_argument(f"--{name}", type=Path, metavar="FILE", help=words)
    command.add_argument(
        "--closure",
        type=_edge,
        action="append",
        default=[],
        metavar="I-J",
        help="the edge between these ids is a loop closure, not odometry; may be repeated",
    )
    command.add_argument(
        "--probability", type=float, default=0.99, help="an inlier passes each test with it (0.99)"
    )
    for name, (choices, what) in _CHOICES.items():
        words = f"what becomes of {what} (raise)"
        command.add_argument(f"--{name}", choices=choices, default="raise", help=words)
    command.add_argument(
        "--max-seconds",
        type=float,
        default=MAX_SECONDS,
        metavar="S",
        help=f"end after about so many seconds of CPU time with the best map ({MAX_SECONDS:g})",
    )
    command.add_argument(
        "--readings",
        action="store_true",
        help="ask as well whether fewer closures are rejected with i and j of edges swapped, "
        "rotations of the other sense, or quaternions that begin with w",
    )
    command.add_argument("--quiet", action="store_true", help="show no progress")
    command.set_defaults(run=_solve)
    return parser


def _output(text: str, suffixes: Sequence[str] = SUFFIXES) -> Path:
    path = Path(text)
    if path.suffix not in suffixes:
        raise argparse.ArgumentTypeError(f"{text}: end it with {', '.join(suffixes)}")
    return path


def _edge(text: str) -> tuple[str, str]:
    i, _, j = text.partition("-")
    if not (i.isalnum() and j.isalnum()):
        raise argparse.ArgumentTypeError(
            f"{text}: give two ids, such as 39-1000; a file of closures is for --closures"
        )
    return i, j


def _solve(options: argparse.Namespace) -> int:
    path = find(options.file)
    for name in ("out", "clean", "plot", "rejected"):
        _check_target(f"--{name}", getattr(options, name), path)
    if options.plot is not None:
        import_module("robust_slam.drawing")  # says before the work where Matplotlib is missing
    if options.unknown == "raise" and has_factors(path):
        return _solve_factors(path, options)
    file = _read(path, options)
    answer = _answered(file, solve, options)
    print(f"\n{answer.summary(file.names)}")
    _print_edges("trusted", answer.bridges.edges, file)
    _print_edges("swapped", swapped_closures(answer), file, " with i and j swapped they fit")
    if options.readings:
        _print_reading(file, answer, options)
    _write(options, file, answer)
    optimal = answer.certificate.verdict is Verdict.CERTIFIED
    trusted = optimal and answer.support is Support.UNIQUE and not file.doubts
    return 0 if trusted else _DOUBTFUL


def _check_target(option: str, target: Path | None, source: Path) -> None:
    """Refuse a file that cannot be written or must not be, before the work."""
    if target is None:
        return
    if not target.parent.is_dir():
        raise FileNotFoundError(f"{option} {target}: there is no folder {target.parent}; make it")
    if target.resolve() == source.resolve():
        raise ValueError(f"{option} {target}: this is the input; give another name")


def _read(path: Path, options: argparse.Namespace) -> GraphFile:
    """Return the file, with the edges of ``--closure`` as closures."""
    file = read(
        path,
        indefinite=options.indefinite,
        unknown=options.unknown,
        odometry=None if options.odometry is None else tuple(options.odometry),
        closures=options.closures,
    )
    odometry = file.graph.is_odometry.copy()
    for i, j in options.closure:
        named = file.steps_between(i, j)
        if not np.any(named):
            raise ValueError(f"--closure {i}-{j}: no odometry joins these ids; drop the option")
        odometry &= ~named
    return dataclasses.replace(file, graph=dataclasses.replace(file.graph, is_odometry=odometry))


def _solve_factors(path: Path, options: argparse.Namespace) -> int:
    """Print and write the map of a file with landmarks, priors or GPS, which has no proof."""
    for name in ("closures", "odometry", "closure", "clean", "readings"):
        if getattr(options, name):
            raise ValueError(
                f"--{name}: it is for relative poses alone, and {path} has landmarks, priors or "
                "GPS; drop it, or leave their lines out with --unknown skip"
            )
    file = read_factors(path)
    answer = _answered(file, solve_factors, options)
    print(f"\n{answer.summary()}")
    relative, ids = file.graph.relative, file.ids
    if options.out is not None:
        rs.save(options.out, relative, answer.poses, names=ids[: relative.n])
        print(f"{'poses':<10} {options.out}, without landmarks, priors and GPS")
    if options.plot is not None:
        _plot(options.plot, relative, answer.poses, answer.kept[: len(relative.edges)])
        print(f"{'plot':<10} {options.plot}")
    if options.rejected is not None:
        norms, ends = FactorEquations(file.graph).norms(answer.x), file.graph.ends
        named = [[str(ids[node]) for node in each if node != FRAME] for each in ends]
        lines = (f"{' '.join(named[k])} {norms[k]:.4g}\n" for k in answer.rejected)
        write_lines(options.rejected, lines)
        print(f"{'rejected':<10} {options.rejected}")
    return _DOUBTFUL


def _answered(
    file: GraphFile | FactorFile, solver: Callable[..., Found], options: argparse.Namespace
) -> Found:
    """Print what is in a file, and return the answer of a solver about it."""
    print(file.summary())
    return solver(file.graph, options.probability, **_limits(options))


def _limits(options: argparse.Namespace) -> dict[str, Any]:
    return {"progress": not options.quiet, "max_seconds": options.max_seconds}


def _print_reading(file: GraphFile, answer: Answer, options: argparse.Namespace) -> None:
    better = better_reading(answer, others=other_orders(file), **_limits(options))
    if better is None:
        print(f"{'reading':<8} no other one rejects half as many closures")
        return
    given, theirs = (counted(each.rejected.size, "edge") for each in (answer, better.answer))
    meant = f"{better.words} {theirs} would be rejected in place of {given}"
    print(f"{'reading':<8} {meant}: if the file was meant so, write it so")


def _print_edges(word: str, edges: Indices, file: GraphFile, behind: str = "") -> None:
    if edges.size:
        named = few(map(file.named, edges.tolist()))
        print(f"{word:<8} {counted(edges.size, 'closure')}: {named}{behind and f';{behind}'}")


def _write(options: argparse.Namespace, file: GraphFile, answer: Answer) -> None:
    for word, path, graph in (("poses", options.out, "graph"), ("clean", options.clean, "clean")):
        if path is not None:
            found = getattr(answer, graph)
            rs.save(path, found, answer.poses, names=file.ids, times=file.times)
            print(f"{word:<8} {path}")
    if options.plot is not None:
        _plot(options.plot, answer.graph, answer.poses, answer.kept)
        print(f"{'plot':<8} {options.plot}")
    if options.rejected is not None:
        ids, sizes = file.names[file.graph.edges], answer.residuals
        lines = (f"{ids[k, 0]} {ids[k, 1]} {sizes[k]:.4g}\n" for k in answer.rejected)
        write_lines(options.rejected, lines)
        print(f"{'edges':<8} {options.rejected}")


def _plot(path: Path, graph: rs.PoseGraph, poses: Array, kept: Mask) -> None:
    from matplotlib.figure import Figure  # with the back end of no window

    figure = Figure(figsize=(7.0, 7.0))
    rs.draw_map(graph, poses, figure.subplots(), kept=kept)
    figure.savefig(path, bbox_inches="tight")


if __name__ == "__main__":
    sys.exit(main())
