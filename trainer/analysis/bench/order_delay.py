"""The delay of an order over TCP, to its answer and to its effect.

A part of ``trainer dev bench``. Orders fall anywhere within a tick, as those of people do; an order
acts on the next tick, so that half a tick is the least mean delay.
"""

import contextlib
import itertools
import random
import socket
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.bench.session_tick import (
    LAST_LINES_TIMEOUT_S,
    SUBSCRIBED_CHANNELS,
    run_to,
    session_of,
    temporary,
)
from trainer.boat.boat import Boat
from trainer.core.state import STATE
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.io.server import Server
from trainer.session.session import Session
from trainer.session.stations.roles import Access
from trainer.session.stations.station import Station
from trainer.session.time.ledger import Histogram, Spread

TIME_SPEED: Final = 10.0  # [-] of time, so that a minute has orders enough
# [ticks] between orders: anywhere within a tick, and one for each at least
PAUSE_TICKS: Final = (1.0, 2.0)
LOCAL_HOST: Final = "127.0.0.1"
RUDDER_ORDERS: Final = ("rudder left full", "rudder right full")


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


def time_orders(boat: Boat, seconds: int, progress: Callable[[int], None]) -> Latency:
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
        session.progress = progress
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
