"""Firefox, where it is there, driven over WebDriver BiDi, which it speaks by itself."""

import json
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from helpers.installation import installed
from helpers.pages import free_port
from helpers.waiting import PATIENCE, await_that, once_it_can


@contextmanager
def firefox(profile: Path) -> Iterator["Tab"]:
    """Open a tab of a Firefox of its own; the test is skipped where there is none."""
    program = shutil.which("firefox") or installed("firefox-esr", "firefox-esr")
    port = free_port()
    profile.mkdir()
    words = [program, "--headless", f"--remote-debugging-port={port}", "--profile", str(profile)]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        once_it_can(lambda: socket.create_connection(("127.0.0.1", port), 1.0).close(), OSError)
        with connect(f"ws://127.0.0.1:{port}/session", max_size=None) as line:
            yield Tab(line)
    finally:
        process.kill()
        process.wait(PATIENCE)


class Tab:
    """One tab."""

    def __init__(self, line: ClientConnection) -> None:
        """Begin a session on that line, with one tab."""
        self.line = line
        self.number = 0
        self.ask("session.new", capabilities={"alwaysMatch": {"acceptInsecureCerts": True}})
        self.context = self.ask("browsingContext.create", type="tab")["context"]

    def ask(self, method: str, **how: object) -> dict[str, Any]:
        """Return the result of a command."""
        self.number += 1
        self.line.send(json.dumps({"id": self.number, "method": method, "params": how}))
        while True:
            said = json.loads(self.line.recv(PATIENCE))
            if said.get("id") == self.number:
                assert said["type"] == "success", said
                return dict(said["result"])

    def open(self, url: str) -> None:
        """Open a page, and wait until all of it is there."""
        self.ask("browsingContext.navigate", context=self.context, url=url, wait="complete")

    def await_that(self, script: str) -> None:
        """Wait until a script's expression is true."""
        await_that(lambda: self.evaluate(f"Boolean({script})"), lambda: script)

    def evaluate(self, script: str) -> Any:
        """Return what a script's expression comes to: a string or a number."""
        there = {"context": self.context}
        found = self.ask("script.evaluate", expression=script, target=there, awaitPromise=True)
        assert found["type"] == "success", found
        return found["result"]["value"]
