"""Searches for inputs that reach new code: ``python -m tests.autograder.fuzz.coverage_guided``.

The targets are the wire's decoder, and the notebook's reader with all that looks at a student's
cells before the sandbox. Their C libraries tell nothing of their coverage, so that their
counterparts in pure Python read each input too. It wants atheris, which nothing else does:
``.venv/bin/pip install atheris`` (there are wheels for Linux on x86-64).
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path

HANG_SECONDS = 10
MOST_MEMORY = 2048
"""In MiB."""
MOST_BYTES = 4096
PROGRESS = re.compile(r"#(\d+)\s+(\w+)\s+cov: (\d+) ft: (\d+)")


def main() -> int:
    """Fuzz one target; 1 where an input was found that it must not fail on."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--runs", type=int, default=-1, help="inputs to try (default: no end)")
    parser.add_argument("--seconds", type=int, default=60, help="how long (default: 60)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if find_spec("atheris") is None:
        parser.error("atheris is not installed: .venv/bin/pip install atheris")
    if options.folder is not None:
        TARGETS[options.target](options.folder, _libfuzzer(options))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        return _report(options.target, Path(folder), _run(Path(folder)))


def _libfuzzer(options: argparse.Namespace) -> list[str]:
    """Arguments of libFuzzer, which atheris drives."""
    flags = {
        "runs": options.runs,
        "max_total_time": options.seconds,
        "seed": options.seed,
        "timeout": HANG_SECONDS,
        "rss_limit_mb": MOST_MEMORY,
        "max_len": MOST_BYTES,
        "dict": options.folder / "tokens",
        "artifact_prefix": f"{options.folder}/found-",
    }
    corpus = options.folder / "corpus"
    return [sys.argv[0], *(f"-{key}={value}" for key, value in flags.items()), str(corpus)]


def _run(folder: Path) -> str:
    """Run the same command in a process that may crash, and give what it wrote."""
    (folder / "corpus").mkdir()
    command = [sys.executable, "-m", __spec__.name, *sys.argv[1:], "--folder", str(folder)]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, errors="replace")
    return done.stderr


def _report(target: str, folder: Path, log: str) -> int:
    """Say what was tried and found."""
    found = sorted(folder.glob("found-*"))
    progress = [match.groups() for match in PROGRESS.finditer(log)]
    started = [step for step in progress if step[1] == "INITED"]
    if started:
        (_, _, edges, features), (inputs, _, more_edges, more_features) = started[0], progress[-1]
        print(
            f"{target}: {int(inputs):,} inputs; coverage {edges} to {more_edges} edges, "
            f"{features} to {more_features} features; "
            f"{len(os.listdir(folder / 'corpus'))} inputs kept"
        )
    for path in found:
        print(f"{path.name}: {path.read_bytes()!r}")
    if found or not started:
        print(log[-4000:])
        return 1
    print("no crash, no hang")
    return 0


def _prepare(folder: Path, seeds: Sequence[bytes], tokens: Sequence[bytes]) -> None:
    for number, seed in enumerate(seeds):
        (folder / "corpus" / f"seed-{number}").write_bytes(seed)
    quoted = ("".join(f"\\x{byte:02x}" for byte in token) for token in tokens if len(token) < 64)
    (folder / "tokens").write_text("".join(f'"{token}"\n' for token in quoted if token))


def _fuzz(arguments: list[str], try_one: Callable[[bytes], None]) -> None:
    import atheris

    atheris.Setup(arguments, try_one)
    atheris.Fuzz()


def fuzz_wire(folder: Path, arguments: list[str]) -> None:
    """What is read is plain data that can be sent again, or refused."""
    import atheris

    with atheris.instrument_imports(include=["robust_slam_autograder", "msgpack.fallback"]):
        import msgpack.fallback
        from robust_slam_autograder.student import wire

    from tests.autograder.fuzz import messages, values
    from tests.autograder.fuzz.test_messages import check

    def read_in_python(data: bytes) -> object:
        most = {"max_array_len": len(data), "max_map_len": len(data)}
        reader = msgpack.fallback.Unpacker(
            strict_map_key=False, object_pairs_hook=list, ext_hook=read_extension, **most
        )
        reader.feed(data)
        with contextlib.suppress(Exception):
            return reader.unpack()

    def read_extension(code: int, body: bytes) -> object:
        return read_in_python(body)

    def try_one(data: bytes) -> None:
        read_in_python(data)
        check(data)

    seeds = [wire.encode(value, values.export) for value in values.EXAMPLES]
    _prepare(folder, seeds, messages.TOKENS)
    _fuzz(arguments, try_one)


def fuzz_notebook(folder: Path, arguments: list[str]) -> None:
    """What is read is cells that can be sorted, or refused in a sentence."""
    import atheris

    with atheris.instrument_imports(include=["robust_slam_autograder"]):
        import robust_slam_autograder.reading.submission  # noqa: F401

    from tests.autograder.fuzz import notebooks
    from tests.autograder.fuzz.test_notebooks import check_cells, check_sorted, parsed

    for function in (json.scanner.py_make_scanner, json.decoder.py_scanstring):
        atheris.instrument_func(function)
    for function in (json.decoder.JSONObject, json.decoder.JSONArray):
        atheris.instrument_func(function)
    decoder = json.JSONDecoder()
    decoder.parse_string = json.decoder.py_scanstring
    decoder.scan_once = json.scanner.py_make_scanner(decoder)

    def try_one(data: bytes) -> None:
        with contextlib.suppress(Exception):
            decoder.decode(data.decode())
        cells = parsed(data)
        check_cells(cells)
        check_sorted(cells)

    seeds = [seed for value in notebooks.VALUES for seed in notebooks.edited(value, 1)]
    _prepare(folder, seeds, notebooks.TOKENS)
    _fuzz(arguments, try_one)


TARGETS = {"wire": fuzz_wire, "notebook": fuzz_notebook}


if __name__ == "__main__":
    sys.exit(main())
