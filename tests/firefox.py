"""Firefox as the system has it, over WebDriver BiDi, which it speaks without a driver."""

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import websocket

from autograder.tests.kernel import leave_out

SECONDS = 300.0
# Everything but this machine is sent to a proxy that is not there.
SETTINGS = """
user_pref("network.proxy.type", 1);
user_pref("network.proxy.http", "127.0.0.1");
user_pref("network.proxy.http_port", 9);
user_pref("network.proxy.ssl", "127.0.0.1");
user_pref("network.proxy.ssl_port", 9);
user_pref("network.captive-portal-service.enabled", false);
user_pref("network.connectivity-service.enabled", false);
user_pref("app.normandy.enabled", false);
"""


class Firefox:
    """One tab, and what a test does with it."""

    def __init__(self, address: str) -> None:
        self._socket = websocket.create_connection(
            f"{address}/session", timeout=SECONDS, suppress_origin=True
        )
        self._asked = 0
        self._ask("session.new", capabilities={})
        self._tab = self._ask("browsingContext.getTree")["contexts"][0]["context"]

    def _ask(self, method: str, **params: object) -> Any:
        self._asked += 1
        request = {"id": self._asked, "method": method, "params": params}
        self._socket.send(json.dumps(request))
        while (answer := json.loads(self._socket.recv())).get("id") != self._asked:
            pass
        assert answer["type"] == "success", answer
        return answer["result"]

    def goto(self, url: str) -> None:
        self._ask("browsingContext.navigate", context=self._tab, url=url, wait="complete")

    def evaluate(self, script: str) -> Any:
        """Return the value of a script, which may be a promise."""
        done = self._ask(
            "script.evaluate",
            expression=f"Promise.resolve({script}).then((found) => JSON.stringify(found ?? null))",
            target={"context": self._tab},
            awaitPromise=True,
        )
        assert done["type"] == "success", done
        return json.loads(done["result"]["value"])


@contextmanager
def firefox(profile: Path) -> Iterator[Firefox]:
    """Start Firefox with an empty profile and no network, and end it."""
    path = shutil.which("firefox-esr") or shutil.which("firefox")
    if path is None:
        leave_out("firefox is not installed; the pages cannot be looked at with it")
    (profile / "user.js").write_text(SETTINGS, encoding="utf-8")
    command = [path, "--headless", "--no-remote", "--profile", profile]
    with subprocess.Popen(
        [*command, "--remote-debugging-port", "0"],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    ) as running:  # fmt: skip
        try:
            said = (re.search(r"BiDi listening on (\S+)", line) for line in running.stderr or ())
            yield Firefox(next(found[1] for found in said if found))
        finally:
            running.terminate()
