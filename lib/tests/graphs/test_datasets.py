"""Public graphs are found where they are, checked, and fetched only on demand."""

import hashlib
import sys
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import numpy as np
import pooch
import pytest
from robust_slam.files import datasets, reading
from robust_slam.graphs import generate

STAND_INS = {
    name: f"# {name}\nEDGE_SE2 0 1 {k}.5 0 0 1 0 0 1 0 1\n".encode()
    for k, name in enumerate(("intel", "manhattan"))
}
BOTH = ["intel.g2o", "manhattan.g2o"]


class Files(BaseHTTPRequestHandler):
    """Serves the stand-ins and counts what is asked for."""

    def do_GET(self):
        self.server.asked.append(self.path)
        content = self.server.files.get(self.path.removeprefix("/data/").removesuffix(".g2o"))
        self.send_response(404 if content is None else 200)
        self.send_header("Content-Length", str(len(content or b"")))
        self.end_headers()
        self.wfile.write(content or b"")

    def log_message(self, *_):
        """Print nothing."""


@pytest.fixture
def server():
    """A server on this machine alone, with its ``files``, what was ``asked``, and its ``url``."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Files) as loopback:
        loopback.files, loopback.asked = dict(STAND_INS), []
        loopback.url = f"http://127.0.0.1:{loopback.server_port}/data/"
        thread = Thread(target=partial(loopback.serve_forever, poll_interval=0.01))
        thread.start()
        yield loopback
        loopback.shutdown()
        thread.join()


def close(server):
    server.shutdown()
    server.server_close()


@pytest.fixture(autouse=True)
def machine(tmp_path, monkeypatch):
    """A machine that knows the stand-ins, with an empty cache and no folder of its own."""
    cache = tmp_path / "cache"
    hashes = {name: hashlib.sha256(text).hexdigest() for name, text in STAND_INS.items()}
    monkeypatch.setattr(datasets, "SHA256", datasets.SHA256 | hashes)
    monkeypatch.setattr(pooch, "os_cache", lambda project: cache / project)
    proxies = ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY")
    for variable in (datasets.FOLDER, "CI", *proxies):
        monkeypatch.delenv(variable, raising=False)
    return cache / "robust-slam"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of the user's own, named by the variable."""
    monkeypatch.setenv(datasets.FOLDER, str(tmp_path / "mine"))
    return tmp_path / "mine"


def put(folder, name, content=None):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.g2o"
    path.write_bytes(STAND_INS[name] if content is None else content)
    return path


def contents(folder):
    return sorted(path.name for path in folder.iterdir()) if folder.exists() else []


def test_a_graph_is_found_in_the_folder_of_the_variable_then_in_the_cache(machine, folder):
    assert not datasets.is_here("intel")
    for where in (machine, folder):
        path = put(where, "intel")
        assert datasets.find("intel") == path and datasets.is_here("intel")
    put(folder, "manhattan")
    assert datasets.is_here("M3500")
    put(folder, "manhattan", b"changed")
    with pytest.raises(datasets.DatasetChanged):
        datasets.is_here("manhattan")


def test_a_missing_graph_is_an_error_with_both_ways_out_and_is_not_downloaded(monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("a connection was opened")

    monkeypatch.setattr("socket.socket.connect", refuse)
    assert issubclass(datasets.DatasetMissing, FileNotFoundError)
    ways = "-m robust_slam.files.datasets.*make data.*ROBUST_SLAM_DATA"
    for name in datasets.NAMES:
        with pytest.raises(datasets.DatasetMissing, match=ways):
            datasets.load(name)


def test_an_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match=r"'Intel'; the names are CSAIL, .*torus3D"):
        datasets.load("Intel")


@pytest.mark.parametrize("load", [datasets.load, reading.load])
@pytest.mark.parametrize("where", ["machine", "folder"])
def test_a_file_of_other_content_is_refused_by_its_path(request, where, load):
    path = put(request.getfixturevalue(where), "intel", STAND_INS["intel"] + b"\n")
    with pytest.raises(datasets.DatasetChanged, match="delete the file") as caught:
        load("intel")
    assert str(path) in str(caught.value)


def test_without_pooch_the_variable_is_enough(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "pooch", None)
    with pytest.raises(datasets.DatasetMissing):
        datasets.load("intel")
    put(folder, "intel")
    assert datasets.load("intel").n == 2


@pytest.mark.parametrize("module", ["pooch", "tqdm"])
def test_downloading_without_its_packages_names_the_extra(monkeypatch, module):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=f"{module} is missing; install the extra `data`"):
        datasets.download()


def test_a_page_shows_the_public_graph_or_names_the_generated_one(machine):
    made, _ = generate.circle(5, np.random.default_rng(0))
    graph, caption = datasets.load_or_generate("intel", lambda: made)
    assert graph is made
    assert "intel is not on this machine" in caption
    assert "generated" in caption
    put(machine, "intel")
    graph, caption = datasets.load_or_generate("intel", lambda: made)
    assert graph.n == 2
    assert caption == "The graph is the public data set intel."


class TestTry:
    """The quiet download before the book is built."""

    def test_it_fetches_what_is_missing_and_prints_nothing(self, server, machine, capfd):
        put(machine, "intel")
        assert datasets.try_download(STAND_INS, server.url) == [machine / "manhattan.g2o"]
        assert server.asked == ["/data/manhattan.g2o"]
        assert datasets.try_download(STAND_INS, server.url) == []
        assert capfd.readouterr() == ("", "")

    def test_without_a_server_it_gives_up_at_once_and_prints_nothing(self, server, machine, capfd):
        del server.files["intel"]
        assert datasets.try_download(STAND_INS, server.url) == []
        assert server.asked == ["/data/intel.g2o"]
        close(server)
        assert datasets.try_download(STAND_INS, server.url) == []
        assert contents(machine) == []
        assert capfd.readouterr() == ("", "")

    @pytest.mark.parametrize(("value", "fetched"), [("true", 0), ("1", 0), ("false", 1), ("", 1)])
    def test_in_ci_it_is_off(self, server, monkeypatch, value, fetched):
        monkeypatch.setenv("CI", value)
        assert len(datasets.try_download(["intel"], server.url)) == fetched == len(server.asked)

    def test_the_command_never_fails(self, server, machine, monkeypatch, capfd):
        monkeypatch.setattr(datasets.try_download, "__defaults__", (STAND_INS, server.url))
        assert datasets.main(["--try"]) == 0
        assert contents(machine) == BOTH
        server.files.clear()
        assert datasets.main(["--try"]) == 0
        assert capfd.readouterr() == ("", "")


def test_what_is_downloaded_is_loaded_and_not_asked_for_again(server, machine):
    for _ in range(2):
        paths = datasets.download(["intel", "M3500"], base_url=server.url)
        assert paths == [machine / name for name in BOTH]
    assert server.asked == [f"/data/{name}" for name in BOTH]
    assert [path.read_bytes() for path in paths] == list(STAND_INS.values())
    assert datasets.load("intel").n == 2
    assert contents(machine) == BOTH


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda server: server.files.update(intel=b"something else\n"), r"intel\.g2o.*SHA256"),
        (lambda server: server.files.clear(), r"/data/intel\.g2o: 404"),
        (close, "try again"),
    ],
    ids=["wrong hash", "no such file", "no server"],
)
def test_a_failed_download_leaves_nothing_and_names_the_cause(server, machine, spoil, message):
    spoil(server)
    with pytest.raises(datasets.DownloadFailed, match=message):
        datasets.download(["intel"], base_url=server.url)
    assert contents(machine) == []


def test_the_command_downloads_all_graphs_or_fails(server, machine, monkeypatch, capsys):
    monkeypatch.setattr(datasets.download, "__defaults__", (STAND_INS, server.url))
    assert datasets.main() == 0
    printed = capsys.readouterr()
    assert f"2 public graphs are in {machine}" in printed.out
    assert "100%" in printed.err
    assert contents(machine) == BOTH
    monkeypatch.setattr(datasets.download, "__defaults__", (["CSAIL"], server.url))
    assert datasets.main() == 1
    assert "CSAIL.g2o: 404" in capsys.readouterr().err
