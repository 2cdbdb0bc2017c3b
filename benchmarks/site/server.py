"""A server on this machine that gzips text, as hosts of pages do, and notes what it gave."""

from __future__ import annotations

import functools
import gzip
import http.server
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

TEXT = {".css", ".html", ".js", ".json", ".mjs", ".svg", ".txt", ".xml"}
LEVEL = 6
"""Of gzip, the default of common servers."""


@dataclass(frozen=True)
class Given:
    """An answer: the path and the bytes of its body, after gzip where the file is text."""

    path: str
    size: int


@dataclass
class Served:
    """A folder's address, and what the server gave so far."""

    address: str = ""
    given: list[Given] = field(default_factory=list)

    def take(self) -> list[Given]:
        """Return what was given since the last call."""
        taken, self.given = self.given, []
        return taken


@contextmanager
def serving(folder: Path) -> Iterator[Served]:
    """Serve a folder until the end of the block."""
    served = Served()

    class Handler(_Gzipping):
        def note(self, size: int) -> None:
            served.given.append(Given(self.path.split("?")[0], size))

    handler = functools.partial(Handler, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        served.address = f"http://127.0.0.1:{server.server_port}"
        yield served
        server.shutdown()


class _Gzipping(http.server.SimpleHTTPRequestHandler):
    """Answers with whole files; a browser's own cache keeps them for an hour."""

    def note(self, size: int) -> None:
        """Keep what was given."""
        raise NotImplementedError

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""

    def do_GET(self) -> None:
        """Give a file, as short as it can be."""
        path = Path(self.translate_path(self.path))
        path = path / "index.html" if path.is_dir() else path
        if not path.is_file():
            self.note(0)
            self.send_error(404)
            return
        body = path.read_bytes()
        self.send_response(200)
        if path.suffix in TEXT:
            body = gzip.compress(body, LEVEL, mtime=0)
            self.send_header("Content-Encoding", "gzip")
        self.send_header("Content-Type", self.guess_type(str(path)))
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "max-age=3600")
        self.end_headers()
        self.note(len(body))
        self.wfile.write(body)
