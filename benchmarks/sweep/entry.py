"""Enter the benchmark from outside, in any language: graphs go out as files, maps come back.

    python -m benchmarks.sweep.entry write FOLDER --tiers A
    python -m benchmarks.sweep.entry score FOLDER/my-solver --name "my solver"

The first command writes a g2o file for each world into ``FOLDER/worlds``, without a word about
which closures are wrong. A program writes a map for each into a folder of its own: ``WORLD.g2o``
with the vertices, or ``WORLD.tum`` with a line ``id x y z qx qy qz qw`` for each pose. If it also
writes ``seconds.csv``, with lines ``WORLD,CPU seconds``, its time is in the table. The second
command scores the maps; a map that is missing counts as failed. Both commands name the worlds
alike, and the journal remembers the runs, so that the next ``--write`` has them in its tables.
Where the library's solver and the correct edges alone have not been run in these worlds, they are
run as well, because every map is compared with theirs.
"""

import csv
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from robust_slam._arrays import Array
from robust_slam.estimators import chi_square_threshold
from robust_slam.files.g2o import write
from robust_slam.graphs.pose_graph import check_poses
from robust_slam.groups import se2, se3
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from benchmarks import methods
from benchmarks.methods import Made
from benchmarks.sweep import journal, summary
from benchmarks.sweep.__main__ import JOURNAL, missing, sweep
from benchmarks.sweep.definition import GRAPHS, TIERS, World, make, worlds
from benchmarks.sweep.journal import Run
from benchmarks.sweep.run import do

_VERTICES = {"VERTEX_SE2": 3, "VERTEX_SE3:QUAT": 7}
"""Tags of a g2o file, and the numbers behind the id."""


def name_of(world: World) -> str:
    """Return the name of a world's file, such as ``A-manhattan-random-10-0``."""
    parts = [world.tier, *map(str, world[:4]), world.change]
    return "-".join(part for part in parts if part).replace(" ", "_").replace(":", "_")


def write_worlds(folder: Path, chosen: Sequence[World]) -> None:
    """Write a g2o file for each of the ``chosen`` worlds into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    for world in tqdm(chosen, unit="world"):
        write(folder / f"{name_of(world)}.g2o", make(world).graph)


def score_maps(folder: Path, name: str, chosen: Sequence[World]) -> Iterator[Run]:
    """Yield the run of each of the ``chosen`` worlds whose map is in ``folder``, under a name.

    Raises:
        ValueError: a map has another number of poses, or is not a map.
    """
    seconds = _seconds(folder / "seconds.csv")
    for world in chosen:
        stem = name_of(world)
        took = seconds.get(stem, float("nan"))
        paths = [path for end in ("g2o", "tum") if (path := folder / f"{stem}.{end}").exists()]
        if not paths:
            yield Run(world, name, None, took, "no map")
            continue
        made = make(world)
        poses = read_map(paths[0], made)
        c = chi_square_threshold(methods.PROBABILITY, made.graph.group.DOF)
        yield Run(
            world, name, methods.score(made, methods.judged(poses, made.graph, c), took), took
        )


def read_map(path: Path, made: Made) -> Array:
    """Return the poses ``(n, 3)`` or ``(n, 3, 4)`` in a g2o or TUM file, by ascending id.

    Raises:
        ValueError: it does not hold one pose for each of the world, or an entry is not a number.
    """
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines():
        words = line.split()
        if path.suffix == ".g2o" and (not words or words[0] not in _VERTICES):
            continue
        if words and not words[0].startswith("#"):
            rows.append([float(word) for word in words[path.suffix == ".g2o" :]])
    numbers = np.array(sorted(rows), dtype=np.float64)
    if len(numbers) != made.graph.n:
        raise ValueError(f"{path}: {len(numbers)} poses are there; the world has {made.graph.n}")
    return check_poses(str(path), _poses(numbers[:, 1:], made), made.graph)


def _poses(numbers: Array, made: Made) -> Array:
    """Return poses from x, y, θ, or from a position and a quaternion."""
    if numbers.shape[1] == _VERTICES["VERTEX_SE2"]:
        return numbers
    rotation = Rotation.from_quat(numbers[:, 3:])
    if made.graph.group is se2:
        return np.column_stack([numbers[:, :2], rotation.as_euler("zyx")[:, 0]])
    return se3.from_parts(rotation.as_matrix(), numbers[:, :3])


def _seconds(path: Path) -> dict[str, float]:
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {row[0]: float(row[1]) for row in csv.reader(file) if row}


def main(arguments: Sequence[str] | None = None) -> None:
    """Write worlds, or score maps of them."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("write", "score"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tiers", nargs="+", choices=TIERS, default=["A"])
    parser.add_argument("--name", help="what the method is called in the tables")
    parser.add_argument("--journal", type=Path, default=JOURNAL)
    wanted = parser.parse_args(arguments)
    chosen = list(worlds(wanted.tiers))
    if wanted.what == "write":
        write_worlds(wanted.folder / "worlds", chosen)
        return
    if not wanted.name or wanted.name in methods.METHODS:
        parser.error("give --name, a name that no method of the sweep has")
    if not wanted.folder.is_dir():
        parser.error(f"{wanted.folder} is not a folder; give the one with the maps")
    sweep(wanted.journal, score_maps(wanted.folder, wanted.name, chosen), len(chosen))
    others = (methods.ORACLE, methods.SOLVER)
    left = missing(journal.read(wanted.journal), GRAPHS, others, wanted.tiers)
    sweep(wanted.journal, do(left), sum(len(names) for _, names in left))
    runs = journal.read(wanted.journal).values()
    print(summary.beside(runs, wanted.name))


if __name__ == "__main__":
    main()
