"""The cost of a whole session's tick: recording, subscribers and columns beside the boat.

A part of ``trainer dev bench``; ``order_delay`` uses its sessions. The boat alone takes a small
part of a tick; what attends to it is the rest.
"""

import contextlib
import math
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.analysis.bench.tick import BatchCost, time_batches
from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor
from trainer.config.files import ConfigError
from trainer.io.line import JoinedLine, Outbox, writer
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.io.tables import MOTION_COLUMNS, CsvFile
from trainer.session.agenda import Agenda
from trainer.session.crew import CrewTalk
from trainer.session.history import History
from trainer.session.manning import HandWork
from trainer.session.parts import Monitors
from trainer.session.session import Session
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import Publisher, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.pacer import MonotonicClock, Policy
from trainer.session.time.timekeeping import Timekeeping

SUBSCRIBED_CHANNELS: Final = ("steering", "diving", "tanks", "motion", "gauges")
SUBSCRIPTION_RATE_HZ: Final = 10.0  # [Hz]
LAST_LINES_TIMEOUT_S: Final = 0.5  # [s] for the last lines


@dataclass(frozen=True)
class SessionTickCost:
    """The cost of a tick at full speed, by what attends to it."""

    boat: BatchCost  # the core alone
    bare: BatchCost  # a session with nothing attached
    csv_row: BatchCost  # and so much more for a row of a CSV file
    recorded: BatchCost
    subscribed: BatchCost  # recorded, and five subscribers at 10 Hz
    times_the_bare: float  # least over least: interference only adds


@contextlib.contextmanager
def session_of(
    boat: Boat, speed: float, recording: Recording | NoRecording, channels: tuple[str, ...]
) -> Iterator[Session]:
    """Yield a session with one station for each channel, whose lines nobody reads."""
    keeping = Timekeeping.at(MonotonicClock(), boat.method.step, speed, Policy.CATCH_UP)
    publisher = Publisher(Roster(StateReader(boat, keeping.ledger.summary)))
    session = Session(
        boat,
        keeping,
        History(boat, recording),
        publisher,
        Agenda(boat),
        CrewTalk(boat, HandWork(boat)),
        Monitors.over(boat, LimitMonitor()),
    )
    with Path(os.devnull).open("wb", buffering=0) as sink, contextlib.closing(recording):
        for channel in channels:
            out = Outbox(writer(sink.fileno()))
            line, machine = JoinedLine(channel, None, out), channel != "teletype"
            station = Station(line, Access("instructor"), publisher, session.event_log.log)
            station.wishes.begin(channel, SUBSCRIPTION_RATE_HZ, station.role, machine=machine)
            session.event_log.stations.append(station)
        try:
            yield session
        finally:
            publisher.close(LAST_LINES_TIMEOUT_S)
            for station in session.event_log.stations:
                station.close(LAST_LINES_TIMEOUT_S)


def run_to(session: Session, tick: int) -> None:
    """Run up to ``tick``; ConfigError if the boat loses its numbers before."""
    session.last_tick = tick
    session.run()
    if session.control.failure:
        method = session.boat.method
        raise ConfigError(
            f"{session.boat.file.path.name} has no place in a benchmark at a step of "
            f"{method.step:g} s with {method.integrator}: {session.control.failure}"
        )


def temporary(boat: Boat) -> Recording:
    """Return a recording that is gone when closed."""
    return Recording.create(None, {}, boat.records.state.tobytes())


def time_attended(make: Callable[[], Boat]) -> SessionTickCost:
    """Return the cost of a tick of boats under way, by what attends to it."""
    alone, bare, recorded, subscribed = (make() for _ in range(4))
    rows = CsvFile(Path(os.devnull), 1)  # each row at once, as in real time

    def whole(session: Session) -> Callable[[int], None]:
        return lambda count: run_to(session, int(session.boat.state.tick) + count)

    def tick(count: int) -> None:
        for _ in range(count):
            alone.tick()

    def row(count: int) -> None:
        for _ in range(count):
            rows.row(alone.numbers(MOTION_COLUMNS))

    with contextlib.closing(rows), contextlib.ExitStack() as stack:
        sessions = [
            stack.enter_context(session_of(boat, math.inf, recording, channels))
            for boat, recording, channels in (
                (bare, NoRecording(), ()),
                (recorded, temporary(recorded), ()),
                (subscribed, temporary(subscribed), SUBSCRIBED_CHANNELS),
            )
        ]
        costs = time_batches([tick, row, *(whole(session) for session in sessions)])
    boat_cost, row_cost, *rest = costs
    ratio = rest[2].least_ns / rest[0].least_ns
    return SessionTickCost(boat_cost, rest[0], row_cost, rest[1], rest[2], ratio)
