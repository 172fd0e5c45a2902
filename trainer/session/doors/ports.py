"""The ports by which stations reach a session: terminal, serial lines, TCP and local sockets.

``run`` opens those that the command line asks for, and closes them at the end. A port that cannot
be opened raises ConfigError, which names its option.
"""

import contextlib
import math
import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import click

from trainer.config.files import ConfigError, nearest
from trainer.io import paths
from trainer.io.connection import OWN_MACHINE, Connection
from trainer.io.line import DirectSender, Inbox, JoinedLine, Line, Outbox, reader, writer
from trainer.io.machine import THIS_MACHINE
from trainer.io.serial_line import LinkError, SerialLine
from trainer.io.server import Server, parse_address, private_folder
from trainer.io.status_line import clock
from trainer.session.past.options import RunOptions
from trainer.session.stations.roles import ROLES, Access, GuessWaits, read_tokens, refuse_open_door
from trainer.session.stations.station import Log, News, Station
from trainer.session.stations.subscriptions import Sender

ROLE_TIMEOUT_S: Final = 10.0  # [s] for a line to give its role, where a token is asked for
PORT_TIMEOUT_S: Final = 0.5  # [s] for ports at the end, and for a pipe at the start


@dataclass
class Lobby:
    """The reception of lines that come by themselves, at the sockets of a server."""

    hub: Server
    admit: Callable[[Connection], Station]
    awaited: bool  # a run that nobody attends to goes on for whoever may come

    def newcomers(self) -> list[Station]:
        """Return the stations that have come since the last call."""
        return [self.admit(line) for line in self.hub.newcomers()]


@dataclass
class Ports:
    """The ports of a session. Each part is closed with the stack."""

    wake: threading.Event
    sending: Sender
    log: Log
    stack: contextlib.ExitStack
    report: Callable[[str], None]  # a line that is lost or back; any thread may call it
    stations: list[Station] = field(default_factory=list)
    addresses: list[str] = field(default_factory=list)  # where lines come in, the nearest first

    def terminal(self, role: str, *, unhurried: bool) -> Station:
        """Return the station of the terminal: a person, who instructs or trains.

        In an ``unhurried`` run, which keeps no time, lines are written at once, and a pipe is read
        first, so that its orders act before the first tick.
        """
        out = writer(1)
        sender = DirectSender(out, b"\n") if unhurried else Outbox(out, line_end=b"\n")
        inbox = Inbox(reader(0), self.wake)
        if unhurried and not os.isatty(0):
            while not inbox.ended:  # a pipe's orders act before the first tick
                inbox.arrived.clear()
                if not inbox.ended and not inbox.arrived.wait(PORT_TIMEOUT_S):
                    break
            inbox.arrived.set()
        return self._person(JoinedLine("console", inbox, sender), Access(role, own=True))

    def console_line(self, url: str, baud: int) -> Station:
        """Return the station of a person at a serial line. ConfigError if it cannot be opened."""
        return self._person(self._serial("--serial", url, baud), Access("instructor"))

    def panel(self, given: str, baud: int) -> Station:
        """Return the station of ``ROLE=URL``, a serial line with that role; ConfigError."""
        role, equals, url = given.partition("=")
        if role not in ROLES or not equals or not url:
            wrong = nearest(role, ROLES) if role not in ROLES else ""
            raise ConfigError(f"--line {given}: say ROLE=URL, such as helm=/dev/ttyUSB0{wrong}")
        return self._station(self._serial("--line", url, baud), Access(role))

    def lobby(self, options: RunOptions) -> Lobby | None:
        """Return where lines come in at the sockets asked for, None for none; ConfigError."""
        address, path = address_or_none(options.listen), address_or_none(options.socket)
        tokens = read_tokens(options.token)
        if address is not None:
            with refusing("--listen"):
                host, port = parse_address(address, f"{paths.DEFAULT_HOST}:{paths.DEFAULT_PORT}")
            refuse_open_door("--listen", host, tokens)
        joinable = math.isfinite(options.speed) and (options.serve or not options.headless)
        at_home = path is None and options.socket is None and joinable  # without being asked for
        if address is None and path is None and not at_home:
            return None
        hub = Server(self.wake, ROLE_TIMEOUT_S if tokens else math.inf)
        self.stack.callback(hub.close, PORT_TIMEOUT_S)
        if address is not None:
            with refusing("--listen"):
                listening_at = f"tcp://{host}:{hub.listen(host, port)}"
                click.echo(f"{paths.LISTENING_TEXT} {listening_at}", err=True)
                self.addresses.append(listening_at)
        if path is not None:
            with refusing("--socket"):
                Path(path).parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                listen_here(hub, Path(path))
                self.addresses.insert(0, path)
        awaited = address is not None or path is not None
        if at_home:
            try:
                private_folder(paths.socket_path().parent)
                listen_here(hub, paths.socket_path())
                self.addresses.insert(0, str(paths.socket_path()))
                awaited = awaited or options.serve
            except (LinkError, OSError) as error:
                click.echo(f"trainer: stations cannot join by themselves: {error}", err=True)

        waits = GuessWaits()

        def admit(line: Connection) -> Station:
            def delay() -> float:
                wait = waits.count(line.machine)
                line.grant(wait)
                return wait

            def here() -> bool:
                return line.machine in (OWN_MACHINE, THIS_MACHINE)

            door = Access(tokens=tokens, entered=line.introduce, delay=delay, here=here)
            return self._station(line, door)

        return Lobby(hub, admit, awaited)

    def nearest(self, options: RunOptions) -> str:
        """Return the address at which pages reach this session; ConfigError if there is none."""
        if self.addresses:
            return self.addresses[0]
        remedy = "give another --socket" if options.socket is None else "leave out --socket none"
        raise ConfigError(f"--web: pages come in at a socket: {remedy}")

    def news_printer(self) -> Callable[[News], None]:
        """Return a function that prints news at the terminal, and never waits for it."""
        out = Outbox(writer(1), line_end=b"\n")
        self.stack.callback(out.close, PORT_TIMEOUT_S)
        return lambda news: out.send(f"{clock(news.seconds)}  {news.kind:9} {news.text}")

    def _serial(self, option: str, url: str, baud: int) -> JoinedLine:
        try:
            line = SerialLine(url, baud, self.report)
        except LinkError as error:
            raise ConfigError(f"{option} {error}") from None
        self.stack.callback(line.close)
        return JoinedLine(url, Inbox(line.read, self.wake), Outbox(line.write), line)

    def _person(self, line: Line, door: Access) -> Station:
        station = self._station(line, door)
        station.type_out()
        return station

    def _station(self, line: Line, door: Access) -> Station:
        return Station(line, door, self.sending, self.log)


def address_or_none(option: str | None) -> str | None:
    """Return an address or path, None for the word ``none``."""
    return None if option in (None, "none") else option


@contextlib.contextmanager
def refusing(option: str) -> Iterator[None]:
    """Raise ConfigError naming the option for what cannot be opened inside the block."""
    try:
        yield
    except (LinkError, OSError) as error:
        raise ConfigError(f"{option} {error}") from None


def listen_here(hub: Server, path: Path) -> None:
    """Listen at a local socket, and print its path."""
    hub.listen_here(path)
    click.echo(f"{paths.LISTENING_TEXT} {path}", err=True)


def keeps_no_time(options: RunOptions) -> bool:
    """Return whether the run keeps no time and nobody can join it."""
    sockets = address_or_none(options.listen), address_or_none(options.socket)
    return math.isinf(options.speed) and sockets == (None, None)
