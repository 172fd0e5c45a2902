"""The transponders of ships near, as the boat's receiver hears them.

``sentences`` adds them. Each reports as often as ITU-R M.1371 says, at times of its own. It is
heard while the boat's antenna is out of the water, as far as the heights of both antennas allow.
"""

import math
from collections.abc import Iterator
from datetime import datetime, timedelta
from itertools import cycle
from typing import Final

from trainer.boat.depths import MAST_RAISED_M
from trainer.boat.world.contacts import ContactState, contacts_in
from trainer.config.world.contacts import SHIP_TYPES
from trainer.io import ais
from trainer.io.ais import Field, PositionReport, ShipParticulars
from trainer.io.chart import Chart
from trainer.session.stations.plot import eye, optics_are_out, periscope
from trainer.session.stations.view import Frame
from trainer.units import KNOT

AIS_NAME: Final = "VDM"  # what it is chosen by, among the sentences
RADIO_RANGE_FACTOR: Final = 4100.0  # [m] of range for the root of an antenna's height [m]
STATIC_PERIOD_S: Final = 360.0  # [s] between two reports of name and size
# [rad/s] at which the heading leaves its mean over 30 s by 5 deg (ITU-R M.1371-5, annex 2)
MIN_TURN_RATE: Final = math.radians(5.0) / 15.0
GOLDEN_RATIO: Final = 0.6180339887498949  # its multiples spread the ships' times evenly
# Up to a speed [kn]: the time [s] between reports of class A, and while the ship turns.
REPORT_PERIODS: Final = ((14.0, 10.0, 10.0 / 3.0), (23.0, 6.0, 2.0), (math.inf, 2.0, 2.0))
SLOW_PERIOD_S: Final = 180.0  # [s] at anchor, and of class B below 2 kn
Messages = tuple[list[Field], ...]


def antenna(frame: Frame) -> float:
    """Return the height [m] of the boat's antenna over the water.

    The antenna is on the head of the periscope; in its well its height is minus infinity. A boat
    without a periscope has a mast, MAST_RAISED_M out of the water at periscope depth. A boat
    without such a depth has the antenna on the sail.
    """
    if periscope(frame):
        over = eye(frame) if optics_are_out(frame) else None
        return -math.inf if over is None else over
    depth = frame.boat.file.run.periscope_depth_m
    if depth is not None:
        return depth + MAST_RAISED_M - frame["z"] - frame["eta_wave"]
    return -(frame.read("over_sail") or 0.0)


def report_interval(ship: ContactState) -> float:
    """Return the time [s] between two position reports."""
    knots = ship.speed / KNOT
    if SHIP_TYPES[ship.type].small:
        return SLOW_PERIOD_S if knots < 2.0 else 30.0
    if ship.status == "at anchor" and knots < 3.0:
        return SLOW_PERIOD_S
    straight, turning = next(pair for most, *pair in REPORT_PERIODS if knots <= most)
    return turning if abs(ship.turning) > MIN_TURN_RATE else straight


def report_count(time: float, every: float, share: float) -> int:
    """Return how many reports there have been by a time [s]; ``share`` shifts them."""
    return math.floor(time / every - share)


class Transponders:
    """The receiver of all ships that are heard, from one frame to the next."""

    def __init__(self, chart: Chart, start: datetime) -> None:
        """Tell of a session that began at ``start``, UTC."""
        self._chart, self._start = chart, start
        self._last: float | None = None  # [s]
        self._sequence = 0
        self._channels = cycle(ais.AIS_CHANNELS)

    def lines(self, frame: Frame) -> list[str]:
        """Return what has been sent since the last frame; nothing where time has gone back."""
        before, now = self._last, frame.seconds
        self._last = now
        contacts, height = contacts_in(frame.boat), antenna(frame)
        if contacts is None or before is None or now <= before or height <= 0.0:
            return []
        own_root, x, y = math.sqrt(height), frame["x"], frame["y"]
        return [
            line
            for ship in contacts.seen(frame.tick)
            if ship.mmsi is not None
            and math.hypot(ship.north - x, ship.east - y)
            <= RADIO_RANGE_FACTOR * (own_root + math.sqrt(ship.mast))
            for messages in self._due(ship, before, now)
            for line in self._sentences(messages)
        ]

    def _due(self, ship: ContactState, before: float, now: float) -> Iterator[Messages]:
        """Yield what of a ship is due, a message or the two parts of one."""
        share = (ship.mmsi or 0) * GOLDEN_RATIO % 1.0
        small = SHIP_TYPES[ship.type].small
        every = report_interval(ship)
        if report_count(now, every, share) > report_count(before, every, share):
            seen = self._report(ship, now)
            yield (ais.position_b(seen) if small else ais.position_a(seen),)
        if report_count(now, STATIC_PERIOD_S, share) > report_count(before, STATIC_PERIOD_S, share):
            ship_particulars = particulars(ship)
            yield ais.static_b(ship_particulars) if small else (ais.static_a(ship_particulars),)

    def _sentences(self, messages: Messages) -> list[str]:
        """Return the sentences of messages, on the two channels in turn.

        Parts go out on one: readers join what comes on the same channel.
        """
        channel = next(self._channels)
        sentences = []
        for fields in messages:
            self._sequence = (self._sequence + 1) % 10
            sentences += ais.sentences(fields, channel, self._sequence)
        return sentences

    def _report(self, ship: ContactState, now: float) -> PositionReport:
        """Return a ship's position report of a moment."""
        latitude, longitude = self._chart.position(ship.north, ship.east)
        return PositionReport(
            mmsi=ship.mmsi or 0,
            latitude=latitude,
            longitude=longitude,
            speed=ship.speed / KNOT,
            course=math.degrees(ship.course),
            heading=math.degrees(ship.heading),
            turning=math.degrees(ship.turning) * 60.0,
            second=(self._start + timedelta(seconds=now)).second,
            status=ais.STATUS_CODES[ship.status],
        )


def particulars(ship: ContactState) -> ShipParticulars:
    """Return a ship's static report: name, type, size. Its antenna is taken as in its middle."""
    ends, sides = round(0.5 * ship.length), round(0.5 * ship.beam)
    return ShipParticulars(
        ship.mmsi or 0,
        ship.name.replace("-", " "),
        SHIP_TYPES[ship.type].ais,
        ends,
        ends,
        sides,
        sides,
        draught=ship.draught,
    )
