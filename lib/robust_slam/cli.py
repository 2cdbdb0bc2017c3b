"""The command ``robust-slam``: a map from a g2o file, without its outliers."""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import robust_slam as rs
from robust_slam.errors import NotConverged
from robust_slam.graphs import g2o, trajectories
from robust_slam.pipeline import Answer, solve

_WRITERS: dict[str, Callable[[Path, g2o.G2o, Answer], None]] = {
    ".g2o": lambda path, file, answer: g2o.write(path, answer.graph, answer.poses, file.names),
    ".tum": lambda path, _, answer: trajectories.write_tum(path, answer.poses),
    ".kitti": lambda path, _, answer: trajectories.write_kitti(path, answer.poses),
}
_REFUSED, _NO_CERTIFICATE = 2, 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 for a certified map, 1 for another one, 2 for an error."""
    options = _parser().parse_args(arguments)
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        return _solve(options)
    except (OSError, ValueError, ImportError, NotConverged) as error:
        print(f"robust-slam: {error}", file=sys.stderr)
        return _REFUSED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="robust-slam", description="Robust estimation on pose graphs."
    )
    parser.add_argument("--version", action="version", version=f"robust-slam {rs.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    command = commands.add_parser(
        "solve",
        help="find the map of a g2o file, its outliers and its certificate",
        description="Find the map of a g2o file, its outliers and its certificate. The exit "
        "code is 0 if the map is certified, 1 if not, 2 if something is wrong with the input.",
    )
    command.add_argument("file", type=Path, metavar="FILE", help="a pose graph, FILE.g2o")
    command.add_argument(
        "--out",
        type=_output,
        metavar="FILE",
        help="write the poses: .g2o with all edges, .tum or .kitti",
    )
    command.add_argument(
        "--plot", type=Path, metavar="FILE", help="draw the map: .svg, .png or .pdf"
    )
    command.add_argument(
        "--probability", type=float, default=0.99, help="an inlier passes each test with it (0.99)"
    )
    command.add_argument(
        "--indefinite",
        choices=["raise", "nearest", "isotropic"],
        default="raise",
        help="what becomes of information matrices that are not positive definite (raise)",
    )
    command.add_argument(
        "--unknown",
        choices=["raise", "skip"],
        default="raise",
        help="what becomes of lines with unknown tags, such as landmarks (raise)",
    )
    command.add_argument("--quiet", action="store_true", help="show no progress")
    return parser


def _output(text: str) -> Path:
    path = Path(text)
    if path.suffix not in _WRITERS:
        raise argparse.ArgumentTypeError(f"{text}: end it with {', '.join(_WRITERS)}")
    return path


def _solve(options: argparse.Namespace) -> int:
    file = g2o.read(options.file, indefinite=options.indefinite, unknown=options.unknown)
    print(file.graph.summary())
    if file.repaired.size:
        print(f"{'replaced':<10} {file.repaired.size:,} information matrices")
    for tag, count in file.skipped.items():
        print(f"{'skipped':<10} {count:,} lines {tag}")
    answer = solve(file.graph, options.probability, progress=not options.quiet)
    print(f"\n{answer.summary()}")
    rejected = ", ".join(f"{i}-{j}" for i, j in file.names[file.graph.edges[answer.rejected]][:10])
    if rejected:
        more = ", …" if answer.rejected.size > 10 else ""
        print(f"{'rejected':<8} {answer.rejected.size:,} closures: {rejected}{more}")
    if options.out is not None:
        _WRITERS[options.out.suffix](options.out, file, answer)
        print(f"{'poses':<8} {options.out}")
    if options.plot is not None:
        _plot(options.plot, answer)
        print(f"{'plot':<8} {options.plot}")
    certified = answer.certificate.verdict.value == "certified"
    return 0 if certified else _NO_CERTIFICATE


def _plot(path: Path, answer: Answer) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from robust_slam.drawing import draw_map

    figure, axes = plt.subplots(figsize=(7.0, 7.0))
    draw_map(answer.graph, answer.poses, axes, kept=answer.kept)
    figure.savefig(path, bbox_inches="tight")


if __name__ == "__main__":
    sys.exit(main())
