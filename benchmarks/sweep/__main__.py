"""Which methods hold, on which graphs, under which outliers, up to which rate?

Runs that are in the journal are not done again: kill it at any time, and start it again.
Afterwards, or with --write at any time, the tables of what there is go to --table, for tier A,
and to --tiers-table, for all tiers. A row that the journal does not hold whole stays as it is
there. The methods that each row is compared with are always run.

    python -m benchmarks.sweep --jobs 2
"""

from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from robust_slam.files.datasets import DatasetMissing, find
from robust_slam_course.results import Row, read_results
from tqdm import tqdm

from benchmarks import methods
from benchmarks.sweep import journal, seal, summary
from benchmarks.sweep.definition import GENERATED, GRAPHS, TIERS, digest, entered, worlds
from benchmarks.sweep.run import Task, do

ROOT = Path(__file__).parents[2]
JOURNAL = ROOT / "build" / "sweep" / "journal.jsonl"
TABLE = ROOT / "chapters" / "data" / "robustness.csv"
TIERS_TABLE = TABLE.with_name("tiers.csv")


def missing(
    done: dict[journal.Key, journal.Run],
    graphs: Sequence[str],
    names: Collection[str],
    tiers: Sequence[str] = ("A",),
) -> list[Task]:
    """Return what is left to do with these methods on these graphs, a task for each world."""
    tasks = []
    for world in worlds(tiers):
        left = [name for name in entered(world) if name in names and (world, name) not in done]
        if left and world.graph in graphs:
            tasks.append((world, tuple(left)))
    return tasks


def sweep(path: Path, runs: Iterable[journal.Run], total: int) -> None:
    """Note each of ``total`` runs as it ends."""
    tqdm.monitor_interval = 0  # no thread of its own: runs are forked from here
    for run in tqdm(runs, total=total, unit="run"):
        journal.append(path, run)


def main(arguments: Sequence[str] | None = None) -> None:
    """Do what is left, and write the table."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--journal", type=Path, default=JOURNAL)
    parser.add_argument("--table", type=Path, default=TABLE)
    parser.add_argument("--tiers-table", type=Path, default=TIERS_TABLE)
    parser.add_argument("--tiers", nargs="+", choices=TIERS, default=list(TIERS))
    parser.add_argument("--graphs", nargs="+", choices=GRAPHS, default=GRAPHS, metavar="GRAPH")
    known = methods.available()
    parser.add_argument("--methods", nargs="+", choices=known, default=known, metavar="METHOD")
    parser.add_argument("--write", action="store_true", help="run nothing, write the table")
    wanted = parser.parse_args(arguments)
    if not wanted.write:
        graphs = [graph for graph in wanted.graphs if _is_here(graph)]
        names = {*wanted.methods, methods.ORACLE, methods.GNC, methods.SOLVER}
        tasks = missing(journal.read(wanted.journal), graphs, names, wanted.tiers)
        total = sum(len(names) for _, names in tasks)
        sweep(wanted.journal, do(tasks, wanted.jobs), total)
    runs = journal.read(wanted.journal).values()
    for path, table in ((wanted.table, summary.text), (wanted.tiers_table, summary.tiers)):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(table(runs, _before(path)), encoding="utf-8")
        print(f"a table is in {path}")


def _before(path: Path) -> Sequence[Row]:
    """Return the rows of the table that is there, none if they are of other worlds."""
    if not path.exists():
        return ()
    found = read_results(path)
    own = {"version": digest(), "sealed": seal.HASH}
    return found.rows if own.items() <= found.header.items() else ()


def _is_here(graph: str) -> bool:
    if graph in GENERATED:
        return True
    try:
        find(graph)
    except DatasetMissing as error:
        print(f"left out: {error}")
        return False
    return True


if __name__ == "__main__":
    main()
