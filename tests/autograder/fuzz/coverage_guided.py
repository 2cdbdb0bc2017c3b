"""Searches for inputs that reach new code: ``python -m tests.autograder.fuzz.coverage_guided``.

The first argument is the target: ``wire``, whose decoder is tried, or ``notebook``, the reader of
notebooks with all that looks at a student's cells before the sandbox. More arguments are
libFuzzer's, such as ``-max_total_time=60``. C libraries tell nothing of their coverage, so that
their counterparts in pure Python read each input too. It needs atheris, as nothing else does:
``.venv/bin/pip install atheris`` (there are wheels for Linux on x86-64).
"""

from __future__ import annotations

import contextlib
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import atheris

FLAGS = ("-timeout=10", "-rss_limit_mb=2048", "-max_len=4096")


def main() -> None:
    """Fuzz one target; libFuzzer says what it found, and ends with a status that is not 0."""
    target, *more = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        tokens, corpus = Path(folder, "tokens"), Path(folder, "corpus")
        corpus.mkdir()
        try_one = TARGETS[target](tokens, corpus)
        atheris.Setup([sys.argv[0], *FLAGS, f"-dict={tokens}", *more, str(corpus)], try_one)
        atheris.Fuzz()


def _prepare(tokens: Path, corpus: Path, seeds: Sequence[bytes], parts: Sequence[bytes]) -> None:
    for number, seed in enumerate(seeds):
        (corpus / f"seed-{number}").write_bytes(seed)
    quoted = ("".join(f"\\x{byte:02x}" for byte in part) for part in parts if len(part) < 64)
    tokens.write_text("".join(f'"{part}"\n' for part in quoted if part))


def fuzz_wire(tokens: Path, corpus: Path) -> Callable[[bytes], None]:
    """What is read is plain data that can be sent again, or refused."""
    with atheris.instrument_imports(include=["robust_slam_autograder", "msgpack.fallback"]):
        import msgpack.fallback
        from robust_slam_autograder.protocol import wire

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
    _prepare(tokens, corpus, seeds, messages.TOKENS)
    return try_one


def fuzz_notebook(tokens: Path, corpus: Path) -> Callable[[bytes], None]:
    """What is read is cells that can be sorted, or refused in a sentence."""
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
    _prepare(tokens, corpus, seeds, notebooks.TOKENS)
    return try_one


TARGETS = {"wire": fuzz_wire, "notebook": fuzz_notebook}


if __name__ == "__main__":
    main()
