"""The set of NMEA 0183 sentences for one tick: names, order and sources.

The order is the one that gpsd answers whole reports to: position, way, depth, attitude, heading.
The talker is IN, integrated navigation, which every reader takes.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from trainer.core.casualties import SOUNDER_RANGE
from trainer.io.chart import Chart
from trainer.io.nmea import LINE_END, number, sentence
from trainer.session.nmea import readings as tell
from trainer.session.nmea.readings import DILUTION, SATELLITES, WIDEST, Readings, sight
from trainer.session.nmea.transponders import Transponders
from trainer.session.stations.view import Frame

TALKER: Final = "IN"
SOUNDER: Final = "SD"  # the talker of echo sounders
BOAT_DEPTHS: Final = ("INDBT", "INDPT")  # the boat's own depth as if it were a sounding
GAUGES: Final = "as the gauges show it"
TRUE: Final = "navigation system: true"


@dataclass(frozen=True)
class Instrument:
    """One sentence: its address, what it tells, its fields with their units, and from where."""

    address: str
    says: str
    fields: tuple[str, ...]
    source: str
    read: Callable[[Readings], tuple[str, ...]]
    ground: bool = False  # sent only where there is a ground
    asked: bool = False  # sent only where it is named

    @property
    def name(self) -> str:
        """Return what the sentence is chosen by: its formatter, or its whole address.

        A maker's own has no other. The boat's depth is not to be had by the name of a sounding,
        since every display shows it as the depth of the water.
        """
        if self.address in BOAT_DEPTHS:
            return self.address
        return self.address.removeprefix(TALKER).removeprefix(SOUNDER)

    def fits(self, seen: Readings) -> bool:
        """Return whether the sentence is one of a tick's set."""
        return seen.keel is not None or not self.ground

    def sentence(self, seen: Readings) -> str:
        """Return the sentence of a tick."""
        return sentence(self.address, *self.read(seen))


UTC_TIME: Final = "UTC hhmmss.ss"
WHERE: Final = ("latitude ddmm.mmmmm", "N or S", "longitude dddmm.mmmmm", "E or W")

INSTRUMENTS: Final = (
    Instrument(
        "INRMC",
        "recommended minimum: time, position, way, date",
        (
            *(UTC_TIME, "A", *WHERE, "speed over the ground [kn]", "track [deg true]"),
            *("date ddmmyy", "-", "-", "E, dead reckoning"),
        ),
        TRUE,
        tell.rmc_fields,
    ),
    Instrument(
        "INGGA",
        "fix, with the depth as altitude",
        (
            *(UTC_TIME, *WHERE, "6, dead reckoning", f"{SATELLITES} satellites"),
            *(f"dilution {DILUTION}", "altitude [m], below zero when submerged", "M"),
            *("0.0", "M", "-", "-"),
        ),
        f"position true, altitude {GAUGES}",
        tell.fix,
    ),
    Instrument(
        "INVTG",
        "way made over the ground",
        ("track [deg true]", "T", "-", "M", "speed [kn]", "N", "speed [km/h]", "K", "E"),
        TRUE,
        tell.way,
    ),
    Instrument(
        "INDBT",
        "the boat's depth, as if it were a sounding",
        ("depth [ft]", "f", "depth [m]", "M", "depth [fathom]", "F"),
        GAUGES,
        lambda s: tell.depth(max(s.depth, 0.0)),
        asked=True,
    ),
    Instrument(
        "SDDBT",
        "the ground's depth below the transducer, where there is a ground",
        ("depth [ft]", "f", "depth [m]", "M", "depth [fathom]", "F"),
        GAUGES,
        lambda s: tell.depth(s.sounding),
        ground=True,
    ),
    Instrument(
        "PASHR",
        "attitude",
        (
            *("UTC hhmmss.sss", "heading [deg]", "T", "heel [deg], to starboard positive"),
            *("pitch [deg], bow up positive", "-", "-", "-", "-", "0", "0"),
        ),
        f"heading {GAUGES}, heel and pitch true",
        tell.attitude,
    ),
    Instrument(
        "INHDT",
        "heading",
        ("heading [deg true]", "T"),
        GAUGES,
        lambda s: (number(s.heading, 2), "T"),
    ),
    Instrument(
        "INDPT",
        "the boat's depth, as if it were a sounding",
        ("depth [m]", "0.0", "-"),
        GAUGES,
        lambda s: (number(max(s.depth, 0.0), 2), "0.0", ""),
        asked=True,
    ),
    Instrument(
        "SDDPT",
        "the ground's depth below the transducer, where there is a ground",
        ("depth [m]", "offset [m], negative: to the keel", "range [m]"),
        GAUGES,
        lambda s: (number(s.sounding, 2), number(-(s.keel or 0.0), 1), number(SOUNDER_RANGE, 1)),
        ground=True,
    ),
    Instrument(
        "INROT",
        "rate of turn",
        ("rate [deg/min], to starboard positive", "A"),
        "true",
        lambda s: (number(s.turn, 1), "A"),
    ),
    Instrument(
        "INVHW",
        "heading and speed through the water",
        ("heading [deg true]", "T", "-", "M", "speed [kn]", "N", "speed [km/h]", "K"),
        GAUGES,
        tell.water_speed,
    ),
    Instrument(
        "INVDR",
        "current, where it goes to",
        ("set [deg true]", "T", "-", "M", "drift [kn]", "N"),
        TRUE,
        tell.current,
        asked=True,
    ),
    Instrument(
        "INVBW",
        "speeds through the water and over the ground",
        (
            *("ahead through the water [kn]", "across, to starboard positive [kn]", "A"),
            *("ahead over the ground [kn]", "across [kn]", "A", "-", "V", "-", "V"),
        ),
        f"ahead through the water {GAUGES}, the rest true",
        tell.ways,
        asked=True,
    ),
    Instrument(
        "INRSA",
        "rudder angle",
        ("angle [deg], right positive", "A", "-", "V"),
        "as it is",
        lambda s: tell.starboard(s.rudder.angle),
    ),
    Instrument(
        "INROR",
        "rudder ordered, by hand or by the autopilot",
        ("angle [deg], right positive", "A", "-", "V", "B, bridge"),
        "as ordered",
        tell.ror_fields,
    ),
    Instrument(
        "INRPM",
        "revolutions of the shaft",
        ("S, shaft", "0, single", "revolutions [1/min]", "-", "A"),
        "as it is",
        lambda s: ("S", "0", number(s.rpm, 1), "", "A"),
    ),
    Instrument(
        "INETL",
        "engine telegraph",
        (
            *(UTC_TIME, "O, order", "position 00 to 05 ahead, 12 to 14 astern"),
            *("-", "B, bridge", "0, single"),
        ),
        "as rung; empty when speed is kept or turns are ordered",
        tell.telegraph,
    ),
    Instrument(
        "INXDR",
        "attitude",
        (
            *("A", "angle [deg], bow up positive", "D", "PITCH"),
            *("A", "angle [deg], to starboard positive", "D", "ROLL"),
        ),
        "true",
        lambda s: tell.angles(pitch=s.pitch, roll=s.heel),
    ),
    Instrument(
        "INXDR",
        "the boat's depth",
        ("D", "depth [m]", "M", "DEPTH"),
        GAUGES,
        lambda s: ("D", number(s.depth, 2), "M", "DEPTH"),
    ),
    Instrument(
        "INXDR",
        "planes",
        (
            *("A", "angle [deg], rising positive", "D", "STERN"),
            *("A", "angle [deg], rising positive", "D", "BOW"),
        ),
        "as they are",
        lambda s: tell.angles(stern=s.stern.angle, bow=s.bow.angle),
    ),
    Instrument(
        "PXSC",
        "own: motion",
        (
            *("M", "tick", "depth [m]", "heading [deg]", "speed through the water [kn]"),
            *("pitch [deg]", "heel [deg]", "rate of turn [deg/s]"),
        ),
        f"depth, heading and speed {GAUGES}, the rest true",
        tell.motion,
    ),
    Instrument(
        "PXSC",
        "own: place",
        (
            *("P", "tick", "north of the origin [m]", "east of it [m]", "track [deg]"),
            "speed over the ground [kn]",
        ),
        TRUE,
        tell.place,
    ),
    Instrument(
        "PXSC",
        "own: surfaces, right and rising positive",
        (
            *("C", "tick", "rudder [deg]", "ordered [deg]", "stern planes [deg]"),
            *("ordered [deg]", "bow planes [deg]", "ordered [deg]"),
        ),
        "as they are and as ordered",
        tell.controls,
    ),
    Instrument(
        "PXSC",
        "own: engine, and what the autopilot keeps",
        (
            *("E", "tick", "revolutions [1/min]", "ordered [1/min]", "depth kept [m]"),
            *("course kept [deg]", "speed kept [kn]"),
        ),
        "as they are and as ordered",
        tell.engine,
    ),
    Instrument(
        "PXSC",
        "own: ballast",
        (
            *("B", "tick", "tanks [% full]: forward", "mid", "aft", "negative", "trim forward"),
            *("trim aft", "auxiliary", "depth control"),
        ),
        "as they are",
        tell.ballast,
    ),
    Instrument(
        "PXSC",
        "own: air banks",
        ("A", "tick", "main [MPa]", "emergency [MPa]"),
        "as they are",
        tell.air,
    ),
)
NAMES: Final = tuple(dict.fromkeys(instrument.name for instrument in INSTRUMENTS))
USUAL: Final = tuple(dict.fromkeys(each.name for each in INSTRUMENTS if not each.asked))


def choose_instruments(names: Iterable[str]) -> tuple[Instrument, ...]:
    """Return the instruments of those names, in the order that they are sent."""
    wanted = frozenset(names)
    return tuple(instrument for instrument in INSTRUMENTS if instrument.name in wanted)


def widest(instruments: Iterable[Instrument]) -> tuple[int, int]:
    """Return sentences and size [bytes] of the longest set that they can make."""
    sent = [each.sentence(WIDEST) for each in instruments if each.fits(WIDEST)]
    return len(sent), sum(len(each) + LINE_END for each in sent)


class InstrumentSet:
    """A display of frames: one set of sentences for each."""

    def __init__(
        self,
        instruments: tuple[Instrument, ...],
        chart: Chart,
        start: datetime,
        receiver: Transponders | None = None,
    ) -> None:
        """Show those instruments of a session that began at ``start``, UTC; ``receiver`` is AIS."""
        self._instruments, self._receiver = instruments, receiver
        self._chart = chart
        self._start = start

    def lines(self, frame: Frame) -> list[str]:
        """Return the set of one tick, and what ships have sent since the last."""
        seen = sight(frame, self._chart, self._start)
        told = [each.sentence(seen) for each in self._instruments if each.fits(seen)]
        return told + self._receiver.lines(frame) if self._receiver else told


class Sampled:
    """A display at a rate of the boat's own time, however fast that goes."""

    def __init__(self, shown: InstrumentSet, period: float) -> None:
        """Show frames at least ``period`` [s] apart."""
        self._shown = shown
        self._period = period
        self._last = -math.inf  # [s]

    def lines(self, frame: Frame) -> list[str]:
        """Return the set if it is due, as it is when time has gone back."""
        passed = frame.seconds - self._last
        if 0.0 <= passed < self._period * (1.0 - 1e-9):
            return []
        self._last = frame.seconds
        return self._shown.lines(frame)
