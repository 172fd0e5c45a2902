"""Outlets of NMEA 0183, as the command line asks: serial, UDP, TCP, a file.

An outlet sends the boat's instruments as sentences to chart plotters, displays and autopilots.
Each is a subscription, so that no tick waits for it, and a station, so that ``who`` lists it with
its orders and losses. Orders are taken as the helm's, on serial lines and at ports of this machine
alone, because the sentences have no room for a token.
"""

import contextlib
import ipaddress
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import click

from trainer.config.files import ConfigError, nearest
from trainer.io.chart import Chart, chart_at
from trainer.io.line import DirectSender, Inbox, JoinedLine, Line, Outbox, writer
from trainer.io.nmea import MAX_HEADED_LETTERS
from trainer.io.outputs import open_new
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.io.serial_line import URL_SCHEMES, LinkError, SerialLine
from trainer.io.server import Server
from trainer.io.udp import Datagrams
from trainer.session.doors.ports import PORT_TIMEOUT_S, Ports
from trainer.session.nmea.orders import NmeaLine, ReaderLine
from trainer.session.nmea.sentences import (
    SENTENCE_NAMES,
    USUAL_NAMES,
    Instrument,
    InstrumentSet,
    SampledDisplay,
    choose_instruments,
    widest,
)
from trainer.session.nmea.transponders import AIS_NAME as AIS
from trainer.session.nmea.transponders import Transponders
from trainer.session.past.options import RunOptions
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import Subscription
from trainer.session.stations.view import Picture

DEFAULT_PORT: Final = 10110  # registered for NMEA 0183
MAX_SILENCE_S: Final = 1.0  # [s] at most: displays blank what they do not hear of
BITS_PER_BYTE: Final = 10  # on a serial line, with a start bit and a stop bit
SENTENCE_CHOICES: Final = (*SENTENCE_NAMES, AIS)  # of --nmea-sentences
MAX_WAITING_AIS: Final = 100  # AIS sentences that may wait for a line, beside the sets
MIN_WAITING_SETS: Final = 2  # sets that may wait for a serial line; more, if a second has more
UNTIMED_KINDS: Final = ("socket",)  # kinds of serial line that have no baud rate
ADDRESS_PATTERN: Final = re.compile(r"(?:\[([^\]]+)\]|([^:\[\]]*))(?::([0-9]{1,5}))?", re.ASCII)


class SteadySubscription(Subscription):
    """A subscription that is served in a freeze too, because displays blank what falls silent."""

    def wait(self, picture: Picture, now: float) -> float:
        """Return the time [s] until the picture may be sent, seen before or not."""
        if self.seen is None:
            return 0.0
        fresh = self.seen is not picture and self.seen != picture
        period = 1.0 / self.rate
        late = 0.0 if fresh else max(MAX_SILENCE_S - period, 0.0)
        return max(self.due + late - now, 0.0)


@dataclass(frozen=True)
class Outlets:
    """The content of every outlet: instruments, rate, and the location and time of the start."""

    instruments: tuple[Instrument, ...]
    rate: float  # [Hz]
    chart: Chart
    start: datetime
    orders: bool = True  # are taken at TCP ports of this machine
    ais: bool = True  # of ships near is sent too

    @property
    def backlog(self) -> int:
        """Return how many sentences may wait for a line. Older ones are of no use."""
        heard = MAX_WAITING_AIS if self.ais else 0
        return max(MIN_WAITING_SETS, math.ceil(self.rate)) * len(self.instruments) + heard

    @property
    def shown(self) -> InstrumentSet:
        """Return the display of the instruments."""
        receiver = Transponders(self.chart, self.start) if self.ais else None
        return InstrumentSet(self.instruments, self.chart, self.start, receiver)


def open_outlets(
    ports: Ports, recording: Recording | NoRecording, options: RunOptions
) -> list[Station]:
    """Return the stations of the outlets that ``options`` ask for; ConfigError."""
    urls, path = options.nmea, options.nmea_record
    if not urls and path is None:
        return []
    names = parse_names(options.nmea_sentences)
    outlets = Outlets(
        choose_instruments(names),
        options.nmea_rate,
        origin(options.origin),
        start_of(recording),
        ais=AIS in names,
    )
    outlets = replace(outlets, orders=options.nmea_orders or not options.token)
    stations = [open_outlet(ports, outlets, url, options.nmea_baud) for url in urls]
    if path is not None:
        stations.append(open_file(ports, outlets, path))
    return stations


def open_outlet(ports: Ports, outlets: Outlets, url: str, baud: int) -> Station:
    """Return the station of one outlet; ConfigError naming what is wrong with it."""
    scheme, separator, rest = url.partition("://")
    kinds = {"udp": open_datagrams, "tcp": open_readers}
    kind = kinds.get(scheme.lower()) if separator else None
    if separator and kind is None and scheme.lower() not in URL_SCHEMES:
        hint = nearest(scheme, (*kinds, *URL_SCHEMES))
        raise ConfigError(f"--nmea {url}: no such kind of outlet{hint}")
    try:
        if kind is not None:
            return kind(ports, outlets, url, *parse_address(rest))
        refuse_crowded(outlets, url, baud)
        return open_serial(ports, outlets, url, baud)
    except LinkError as error:
        raise ConfigError(f"--nmea {url}: {str(error).removeprefix(f'{url}: ')}") from None


def open_datagrams(ports: Ports, outlets: Outlets, url: str, host: str, port: int) -> Station:
    """Return the station of an outlet by UDP, which hears nothing."""
    sender = Datagrams(host, port)
    ports.stack.callback(sender.close, 0.0)
    return send_to(ports, outlets, JoinedLine(f"nmea {url}", None, sender), "observer")


def open_readers(ports: Ports, outlets: Outlets, url: str, host: str, port: int) -> Station:
    """Return the station of all that come to a TCP port."""
    hub = Server(ports.wake, longest=MAX_HEADED_LETTERS)
    ports.stack.callback(hub.close, PORT_TIMEOUT_S)
    bound_port = hub.listen(host, port)
    role = "helm" if is_local_host(host) and outlets.orders else "observer"
    why = "" if outlets.orders else "; no orders are taken without --nmea-orders: a token is asked"
    why = why if is_local_host(host) else "; no orders are taken from beyond this machine"
    click.echo(f"nmea at tcp://{host}:{bound_port}{why}", err=True)
    return send_to(ports, outlets, ReaderLine(f"nmea {url}", hub, ports.log), role)


def open_serial(ports: Ports, outlets: Outlets, url: str, baud: int) -> Station:
    """Return the station of an outlet on a serial line."""
    port = SerialLine(url, baud, ports.report)
    ports.stack.callback(port.close)
    outbox = Outbox(port.write, outlets.backlog)
    inbox = Inbox(port.read, ports.wake, longest=MAX_HEADED_LETTERS)
    return send_to(ports, outlets, JoinedLine(f"nmea {url}", inbox, outbox, port), "helm")


def open_file(ports: Ports, outlets: Outlets, path: Path) -> Station:
    """Return the station of a file. It has a set at the rate of the boat's own time."""
    try:
        file = open_new(path)
    except FileExistsError:
        raise ConfigError(f"--nmea-record {path}: is there already; give another name") from None
    except OSError as error:
        raise ConfigError(f"--nmea-record {path}: {error.strerror}") from None
    ports.stack.callback(file.close)
    line = JoinedLine(f"nmea {path}", None, DirectSender(writer(file.fileno()), b"\r\n"))
    display = SampledDisplay(outlets.shown, 1.0 / outlets.rate)
    return attend_line(ports, line, Subscription(line, "nmea", 0.0, display), "observer")


def send_to(ports: Ports, outlets: Outlets, line: Line, role: str) -> Station:
    """Return the station of a line that the sets are sent to from now on."""
    return attend_line(
        ports, line, SteadySubscription(line, "nmea", outlets.rate, outlets.shown), role
    )


def attend_line(ports: Ports, line: Line, subscription: Subscription, role: str) -> Station:
    """Return the station of a line with a subscription of its own."""
    ports.sending.add(subscription)
    return Station(NmeaLine(line, ports.wake, ports.log), Access(role), ports.sending, ports.log)


def refuse_crowded(outlets: Outlets, url: str, baud: int) -> None:
    """Raise ConfigError if a serial line cannot carry the sets at their rate."""
    if url.partition("://")[0].lower() in UNTIMED_KINDS:
        return
    (count, size), capacity = widest(outlets.instruments), baud // BITS_PER_BYTE
    if size * outlets.rate > capacity:
        raise ConfigError(
            f"--nmea {url}: {count} sentences of {size} bytes at "
            f"{outlets.rate:g} Hz are {size * outlets.rate:.0f} bytes a second; the line carries "
            f"{capacity} at {baud} baud: give --nmea-rate "
            f"{int(capacity / size * 100.0) / 100.0:g} or less, fewer "
            f"--nmea-sentences or a faster --nmea-baud"
        )


def parse_address(text: str) -> tuple[str, int]:
    """Return host and port of ``HOST[:PORT]``; LinkError."""
    match = ADDRESS_PATTERN.fullmatch(text.rstrip("/"))
    if match is None or not (match[1] or match[2]):
        raise LinkError("say HOST or HOST:PORT after the ://")
    return match[1] or match[2], int(match[3] or DEFAULT_PORT)


def is_local_host(host: str) -> bool:
    """Return whether only this machine can come in at an address."""
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


def parse_names(text: str | None) -> Sequence[str]:
    """Return the names of a list, the usual for none; ConfigError naming the nearest."""
    if text is None:
        return (*USUAL_NAMES, AIS)
    names = [name.strip().upper() for name in text.split(",")]
    for name in names:
        if name not in SENTENCE_CHOICES:
            hint = nearest(name, SENTENCE_CHOICES) or f"; there are {','.join(SENTENCE_CHOICES)}"
            raise ConfigError(f"--nmea-sentences {text}: no sentence {name!r}{hint}")
    return names


def origin(text: str) -> Chart:
    """Return the chart with that origin; ConfigError."""
    try:
        return chart_at(text)
    except ValueError as error:
        raise ConfigError(f"--origin {text}: {error}") from None


def start_of(recording: Recording | NoRecording) -> datetime:
    """Return when the session began: what was recorded, or now, to the second."""
    if isinstance(recording, Recording):
        try:
            return datetime.fromisoformat(recording.header().get("started", ""))
        except ValueError:
            raise ConfigError("recording: its header does not say when it started") from None
    return datetime.now(UTC).replace(microsecond=0)
