"""The wire to the pages' server without a browser: requests by hand, web sockets, a stub."""

import contextlib
import http.client
import socket
import ssl
import subprocess
import threading
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from helpers.installation import do_without
from helpers.waiting import PATIENCE
from trainer import __version__
from trainer.io.orders.sentences import Sentence, order_sentence, parse_sentence
from trainer.io.server import LISTEN_BACKLOG
from trainer.web.admission import Admission, ConnectionRoom
from trainer.web.bridge import Reach
from trainer.web.front import Front
from trainer.web.gate import Refusals
from trainer.web.server import Certificate, PageServer, application, configuration


@dataclass
class Answered:
    """An answer to a request."""

    status: int
    headers: dict[str, str]
    body: bytes


def request(
    port: int,
    path: str = "/",
    method: str = "GET",
    body: str = "",
    context: ssl.SSLContext | None = None,
    **headers: str,
) -> Answered:
    """Return the answer to a request, whose path and headers go out exactly as given."""
    line: http.client.HTTPConnection
    if context is None:
        line = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    else:
        line = http.client.HTTPSConnection("127.0.0.1", port, timeout=PATIENCE, context=context)
    with contextlib.closing(line):
        line.putrequest(method, path, skip_host="Host" in headers, skip_accept_encoding=True)
        for name, value in headers.items():
            line.putheader(name.replace("_", "-"), value)
        line.putheader("Content-Length", str(len(body)))
        line.endheaders(body.encode())
        got = line.getresponse()
        kept = {name.casefold(): value for name, value in got.getheaders()}
        return Answered(got.status, kept, got.read())


@contextlib.contextmanager
def dialled(
    port: int,
    version: str = __version__,
    cookies: str = "",
    scheme: str = "ws",
    root: str = "",
    **how: Any,
) -> Iterator[ClientConnection]:
    """Yield a page's line, as the script of a page below ``root`` opens it."""
    origin = f"{scheme.replace('ws', 'http')}://127.0.0.1:{port}"
    with connect(
        f"{scheme}://127.0.0.1:{port}{root}/line?version={version}",
        origin=how.pop("origin", origin),
        additional_headers=how.pop("headers", {}) | ({"Cookie": cookies} if cookies else {}),
        open_timeout=PATIENCE,
        max_queue=how.pop("max_queue", None),  # else it reads no more
        close_timeout=1.0,
        ping_interval=None,
        create_connection=PageLine,
        **how,
    ) as line:
        yield line


class PageLine(ClientConnection):
    """A page's line, of which each frame may hold several lines of the session."""

    _lines: tuple[str, ...] = ()

    def recv(self, timeout: float | None = None) -> str:  # type: ignore[override]  # of text alone
        """Return the next line."""
        if not self._lines:
            self._lines = tuple(str(super().recv(timeout)).split("\n"))
        line, *rest = self._lines
        self._lines = tuple(rest)
        return line


def ask(line: ClientConnection, words: str, tag: str = "7") -> tuple[str, ...]:
    """Give an order at a page's line; return the fields of the last answer."""
    line.send(order_sentence(words, tag))
    while True:
        said = hear(line)
        if said and (said.kind, said.tag) == ("TRA", tag) and said.fields[0] != "say":
            return said.fields


def hear(line: ClientConnection) -> Sentence | None:
    """Return the next sentence that comes."""
    return parse_sentence(str(line.recv(PATIENCE)))


@dataclass
class Pages:
    """The pages' server in a thread of this process, with a stub in place of the session."""

    port: int
    told: list[str] = field(default_factory=list)
    sessions: list[socket.socket] = field(default_factory=list)  # our ends, one for each page
    machines: Counter[str] = field(default_factory=Counter)  # connections at once of each
    beats: int = 0

    def reach(self) -> socket.socket:
        """Return the far end of a new line."""
        ours, theirs = socket.socketpair()
        ours.settimeout(PATIENCE)
        self.sessions.append(ours)
        return theirs

    def count_beat(self) -> None:
        """Count a sign of life of the server."""
        self.beats += 1


@contextlib.contextmanager
def pages(
    host: str = "127.0.0.1",
    room: ConnectionRoom = ConnectionRoom(),  # noqa: B008  never changed
    certificate: Certificate | None = None,
    reach: Reach | None = None,
    front: Front | None = None,
    **settings: object,
) -> Iterator[Pages]:
    """Serve the pages of a stub, or of what ``reach`` does; ``settings`` are uvicorn's own."""
    with socket.create_server(("127.0.0.1", 0), backlog=LISTEN_BACKLOG) as listener:
        served = Pages(listener.getsockname()[1])
        refusals = Refusals(served.told.append)
        app = application(reach or served.reach, host, refusals, front)
        config = configuration(app, certificate)
        for name, value in settings.items():
            setattr(config, name, value)
        admission = Admission(room, refusals, front)
        served.machines = admission.machines
        server = PageServer(config, listener, admission, served.count_beat)
        thread = threading.Thread(target=server.run)
        thread.start()
        try:
            while not server.started:
                assert thread.is_alive()
                thread.join(0.01)
            yield served
        finally:
            server.should_exit = True
            thread.join(PATIENCE)
            assert not thread.is_alive()
            for end in served.sessions:
                end.close()


AUTHORITY = """
[ca]
default_ca = here
[here]
database = index.txt
serial = serial
new_certs_dir = .
default_md = sha256
policy = any
[any]
commonName = supplied
"""


def make_certificate_of(folder: Path, begins: str, ends: str) -> tuple[Path, Path]:
    """Return a certificate for a time such as 20200101000000Z, and its key, made by openssl."""
    (folder / "ca.cnf").write_text(AUTHORITY)
    (folder / "index.txt").write_text("")
    (folder / "serial").write_text("01\n")
    ask = "req -newkey rsa:2048 -nodes -subj /CN=127.0.0.1 -keyout key.pem -out asked.pem"
    sign = "ca -batch -config ca.cnf -selfsign -keyfile key.pem -in asked.pem -out cert.pem -notext"
    try:
        for words in (ask, f"{sign} -startdate {begins} -enddate {ends}"):
            subprocess.run(["openssl", *words.split()], check=True, capture_output=True, cwd=folder)
    except FileNotFoundError:
        do_without("no openssl: install the package openssl")
    return folder / "cert.pem", folder / "key.pem"


def make_certificate(folder: Path) -> tuple[Path, Path]:
    """Return a certificate of 127.0.0.1 and its key, made by openssl."""
    cert, key = folder / "cert.pem", folder / "key.pem"
    words = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2"]
    words += ["-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1"]
    try:
        subprocess.run(
            [*words, "-keyout", str(key), "-out", str(cert)], check=True, capture_output=True
        )
    except FileNotFoundError:
        do_without("no openssl: install the package openssl")
    return cert, key
