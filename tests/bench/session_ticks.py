"""The cost of a whole session's tick, and the delay of an order over TCP.

``python -m tests.bench --session`` measures it. The boat alone takes a small part of a tick; what
attends to it (recording, subscribers, columns) is the rest. Orders fall anywhere within a tick, as
those of people do; an order acts on the next tick, so half a tick is the least mean delay.
"""

import contextlib
import itertools
import math
import os
import random
import socket
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from bench.batches import BatchCost, Voyage, time_batches
from trainer.analysis.bench.ticks import STANDARD_METHOD, ready_boat, row, trouble_of
from trainer.boat.boat import Boat
from trainer.boat.limits import LimitMonitor
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core.state import STATE
from trainer.io.line import JoinedLine, Outbox, writer
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import Recording
from trainer.io.server import Server
from trainer.io.tables import MOTION_COLUMNS, CsvFile
from trainer.session.crew.agenda import Agenda
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.manning import HandWork
from trainer.session.parts import Monitors
from trainer.session.past.history import History
from trainer.session.session import Session
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import Publisher, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.ledger import Histogram, Spread
from trainer.session.time.pacer import MonotonicClock, Policy
from trainer.session.time.timekeeping import Timekeeping

SUBSCRIBED_CHANNELS: Final = ("steering", "diving", "tanks", "motion", "gauges")
SUBSCRIPTION_RATE_HZ: Final = 10.0  # [Hz]
LAST_LINES_TIMEOUT_S: Final = 0.5  # [s] for the last lines
TIME_SPEED: Final = 10.0  # [-] of time, so that a minute has orders enough
# [ticks] between orders: anywhere within a tick, and one for each at least
PAUSE_TICKS: Final = (1.0, 2.0)
LOCAL_HOST: Final = "127.0.0.1"
RUDDER_ORDERS: Final = ("rudder left full", "rudder right full")


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
    """Run up to ``tick``; ConfigError if the boat is lost, frozen or without power before."""
    session.last_tick = tick
    session.run()
    if trouble := session.control.failure or trouble_of(session.boat, tick, 0):
        method = session.boat.method
        raise ConfigError(
            f"{session.boat.file.path.name} has no place in a benchmark at a step of "
            f"{method.step:g} s with {method.integrator}: {trouble}"
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
        runs = [whole(session) for session in sessions]  # from batch to batch they sail on
        costs = time_batches([Voyage.of(alone, tick), row, *runs])
    boat_cost, row_cost, *rest = costs
    ratio = rest[2].least_ns / rest[0].least_ns
    return SessionTickCost(boat_cost, rest[0], row_cost, rest[1], rest[2], ratio)


@dataclass(frozen=True)
class Latency:
    """The results of a helmsman's orders at a TCP port."""

    orders: int
    tick_s: float  # between ticks
    reply: Spread  # from the order to its answer
    ticks_to_effect_most: int  # until the rudder moved as ordered; 0 if the boat has none


@dataclass
class Callers:
    """The connections that a port accepts."""

    hub: Server
    session: Session
    awaited: bool = True

    def newcomers(self) -> list[Station]:
        """Return the connections that came since the last call."""
        log = self.session.event_log.log
        sending = self.session.sending
        return [Station(line, Access(), sending, log) for line in self.hub.newcomers()]


def time_orders(boat: Boat, seconds: float) -> Latency:
    """Return the delays of a helmsman's orders in ``seconds`` [s], beside attended stations.

    The helmsman is a thread of this process, so that the figures contain its cost. ConfigError if
    the boat loses its numbers.
    """
    period = boat.method.step / TIME_SPEED
    recording, replies = temporary(boat), Histogram()
    with contextlib.ExitStack() as stack:
        session = stack.enter_context(session_of(boat, TIME_SPEED, recording, SUBSCRIBED_CHANNELS))
        hub = Server(session.wake)
        helmsman = stack.enter_context(ThreadPoolExecutor(1))
        stack.callback(hub.close, LAST_LINES_TIMEOUT_S)
        session.attendance.reception = Callers(hub, session)
        steered = helmsman.submit(send_rudder_orders, hub.listen(LOCAL_HOST, 0), period, replies)
        run_to(session, round(seconds / period))
        hub.close(LAST_LINES_TIMEOUT_S)
        states = [np.frombuffer(state, STATE)[0] for _, state in recording.states(recording.branch)]
        order_ticks = [each.tick for each in recording.orders(recording.branch) if each.accepted]
        slowest = max((effect(states[tick:]) for tick in order_ticks[:-1]), default=0)
        return Latency(steered.result(), period, replies.spread(), slowest)


def send_rudder_orders(port: int, period: float, replies: Histogram) -> int:
    """Order the rudder about until the line is closed; return how many orders were answered.

    Ticks are ``period`` [s] apart.
    """
    dice = random.Random(1969)  # noqa: S311  instants, not secrets
    with (
        socket.create_connection((LOCAL_HOST, port)) as line,
        line.makefile(encoding="ascii") as incoming,
    ):
        words = itertools.chain(("role helm",), itertools.cycle(RUDDER_ORDERS))
        for tag, order in enumerate(words):
            begun = time.perf_counter_ns()
            try:
                line.sendall(f"{order_sentence(order, str(tag))}\n".encode("ascii"))
            except OSError:
                return tag - 1
            answers = ((parse_sentence(text), str(tag)) for text in incoming)
            if not any(
                a and (a.kind, a.tag) == ("TRA", own) and a.fields[0] != "say" for a, own in answers
            ):
                return tag - 1
            if tag:
                replies.add(time.perf_counter_ns() - begun)
            time.sleep(period * dice.uniform(*PAUSE_TICKS))
    raise AssertionError


def effect(states: list[np.void]) -> int:
    """Return the ticks from the first until the rudder leaves where it was ordered."""
    was = states[0]["ordered_r"]
    for ticks, (before, after) in enumerate(itertools.pairwise(states), 1):
        wanted = after["ordered_r"] - before["delta_r"]
        if after["ordered_r"] != was and wanted * (after["delta_r"] - before["delta_r"]) > 0.0:
            return ticks
    return len(states)


@dataclass(frozen=True)
class SessionFigures:
    """What a session adds to the boat, and how soon it answers by TCP."""

    attended: SessionTickCost
    latency: Latency


def time_session(file: VesselFile, seconds: float) -> SessionFigures:
    """Return the figures; the boat is steered for ``seconds`` [s]."""

    def ready() -> Boat:
        return ready_boat(file, STANDARD_METHOD, file.run.step_s)

    return SessionFigures(time_attended(ready), time_orders(ready(), seconds))


def lines(figures: SessionFigures) -> list[str]:
    """Return the figures as lines of a page."""
    attended, latency = figures.attended, figures.latency
    most, ratio = latency.ticks_to_effect_most, attended.times_the_bare
    period = f"{1e3 * latency.tick_s:g} ms"
    effect = f"{most} tick{'s' * (most != 1)} at most" if most else "none: this boat has no rudder"
    names = ("boat", "bare session", "recorded", "5 subscribers", "a CSV row")
    costs = (attended.boat, attended.bare, attended.recorded, attended.subscribed, attended.csv_row)
    return [
        "",
        "TICK OF A SESSION, HOT ([ns], by batches; modified lagged adams2)",
        "        " + "".join(f"{name:>14}" for name in names),
        "  median" + "".join(f"{cost.median_ns:>14.0f}" for cost in costs),
        "  least " + "".join(f"{cost.least_ns:>14.0f}" for cost in costs),
        f"  (recorded, with five subscribers at 10 Hz: {ratio:.2f} times the bare one)",
        "",
        f"ORDERS OVER TCP (five subscribers, time x{TIME_SPEED:g}: a tick each {period})",
        row("reply", latency.reply),
        f"    {latency.orders} orders; from order to effect: {effect}",
    ]
