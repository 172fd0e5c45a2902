"""The set of NMEA 0183 sentences for one tick: names, order and sources.

``outlets`` sends it. The order is the one that gpsd answers whole reports to: position, way, depth,
attitude, heading. The talker is IN, integrated navigation, which every reader takes.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from trainer.core.ballast.tanks import BANKS
from trainer.io.chart import Chart
from trainer.io.nmea import LINE_END, sentence
from trainer.session.nmea.readings import BALLAST_TANKS, WIDEST_READINGS, read_fields
from trainer.session.nmea.transponders import Transponders
from trainer.session.stations.view import Frame

OWN_TALKER: Final = "IN"
SOUNDER_TALKER: Final = "SD"  # the talker of echo sounders
BOAT_DEPTHS: Final = ("INDBT", "INDPT")  # the boat's own depth as if it were a sounding
GAUGES_NOTE: Final = "as the gauges show it"
TRUE_NOTE: Final = "navigation system: true"

Part = str | tuple[str, str]
UTC_TIME: Final = ("UTC hhmmss.ss", "time")
POSITION_FIELDS: Final = (
    ("latitude ddmm.mmmmm", "latitude"),
    ("N or S", "north_or_south"),
    ("longitude dddmm.mmmmm", "longitude"),
    ("E or W", "east_or_west"),
)
TICK_FIELD: Final = ("tick", "tick")
SOUNDING_NOTE: Final = "the ground's depth below the transducer, where there is a ground"


@dataclass(frozen=True)
class Instrument:
    """One sentence: its address, its meaning, its fields with units, and where they come from.

    A part is what a field tells and the name of its reading, or a word that is always there: the
    field is that up to its comma, none for "-".
    """

    address: str
    says: str
    parts: tuple[Part, ...]
    source: str
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
        return self.address.removeprefix(OWN_TALKER).removeprefix(SOUNDER_TALKER)

    @property
    def fields(self) -> tuple[str, ...]:
        """Return the meaning of each field."""
        return tuple(part if isinstance(part, str) else part[0] for part in self.parts)

    def fits(self, seen: dict[str, str]) -> bool:
        """Return whether the sentence is one of a tick's set."""
        return seen["keel"] != "" or not self.ground

    def sentence(self, seen: dict[str, str]) -> str:
        """Return the sentence of a tick."""
        return sentence(self.address, *(text_of(part, seen) for part in self.parts))


def text_of(part: Part, seen: dict[str, str]) -> str:
    """Return a field of a tick."""
    if isinstance(part, str):
        return part.partition(",")[0].removeprefix("-")
    return seen[part[1]]


# fmt: off
INSTRUMENTS: Final = (
    Instrument(
        "INRMC",
        "recommended minimum: time, position, way, date",
        (
            UTC_TIME, "A", *POSITION_FIELDS, ("speed over the ground [kn]", "over_ground"),
            ("track [deg true]", "track"), ("date ddmmyy", "date"),
            "-", "-", "E, dead reckoning",
        ),
        TRUE_NOTE,
    ),
    Instrument(
        "PASHR",
        "attitude",
        (
            ("UTC hhmmss.sss", "time_to_ms"), ("heading [deg]", "heading"), "T",
            ("heel [deg], to starboard positive", "heel"),
            ("pitch [deg], bow up positive", "pitch"),
            "-", "-", "-", "-", "0", "0",
        ),
        f"heading {GAUGES_NOTE}, heel and pitch true",
    ),
    Instrument(
        "INGGA",
        "fix, with the depth as altitude",
        (
            UTC_TIME, *POSITION_FIELDS, "6, dead reckoning",
            ("08 satellites", "satellites"), ("dilution 1.0", "dilution"),
            ("altitude [m], below zero when submerged", "altitude"), "M",
            "0.0", "M", "-", "-",
        ),
        f"position true, altitude {GAUGES_NOTE}",
    ),
    Instrument(
        "INVTG",
        "way made over the ground",
        (
            ("track [deg true]", "track"), "T", "-", "M",
            ("speed [kn]", "over_ground"), "N", ("speed [km/h]", "over_ground_kmh"), "K", "E",
        ),
        TRUE_NOTE,
    ),
    Instrument(
        "INDBT",
        "the boat's depth, as if it were a sounding",
        (
            ("depth [ft]", "depth_feet"), "f", ("depth [m]", "depth_shown"), "M",
            ("depth [fathom]", "depth_fathoms"), "F",
        ),
        GAUGES_NOTE,
        asked=True,
    ),
    Instrument(
        "SDDBT",
        SOUNDING_NOTE,
        (
            ("depth [ft]", "sounding_feet"), "f", ("depth [m]", "sounding"), "M",
            ("depth [fathom]", "sounding_fathoms"), "F",
        ),
        GAUGES_NOTE,
        ground=True,
    ),
    Instrument("INHDT", "heading", (("heading [deg true]", "heading"), "T"), GAUGES_NOTE),
    Instrument(
        "INDPT",
        "the boat's depth, as if it were a sounding",
        (("depth [m]", "depth_shown"), "0.0", "-"),
        GAUGES_NOTE,
        asked=True,
    ),
    Instrument(
        "SDDPT",
        SOUNDING_NOTE,
        (
            ("depth [m]", "sounding"), ("offset [m], negative: to the keel", "keel"),
            ("range [m]", "range"),
        ),
        GAUGES_NOTE,
        ground=True,
    ),
    Instrument(
        "INROT", "rate of turn", (("rate [deg/min], to starboard positive", "turn"), "A"), "true"
    ),
    Instrument(
        "INVHW",
        "heading and speed through the water",
        (
            ("heading [deg true]", "heading"), "T", "-", "M",
            ("speed [kn]", "speed"), "N", ("speed [km/h]", "speed_kmh"), "K",
        ),
        GAUGES_NOTE,
    ),
    Instrument(
        "INVDR",
        "current, where it goes to",
        (("set [deg true]", "current"), "T", "-", "M", ("drift [kn]", "drift"), "N"),
        TRUE_NOTE,
        asked=True,
    ),
    Instrument(
        "INVBW",
        "speeds through the water and over the ground",
        (
            ("ahead through the water [kn]", "speed"),
            ("across, to starboard positive [kn]", "across"), "A",
            ("ahead over the ground [kn]", "ahead_over_ground"),
            ("across [kn]", "across_over_ground"), "A", "-", "V", "-", "V",
        ),
        f"ahead through the water {GAUGES_NOTE}, the rest true",
        asked=True,
    ),
    Instrument(
        "INRSA",
        "rudder angle",
        (("angle [deg], right positive", "rudder"), ("A", "rudder_status"), "-", "V"),
        "as it is",
    ),
    Instrument(
        "INROR",
        "rudder ordered, by hand or by the autopilot",
        (
            ("angle [deg], right positive", "ordered_rudder"),
            ("A", "ordered_rudder_status"), "-", "V", "B, bridge",
        ),
        "as ordered",
    ),
    Instrument(
        "INRPM",
        "revolutions of the shaft",
        ("S, shaft", "0, single", ("revolutions [1/min]", "rpm"), "-", "A"),
        "as it is",
    ),
    Instrument(
        "INETL",
        "engine telegraph",
        (
            UTC_TIME, "O, order", ("position 00 to 05 ahead, 12 to 14 astern", "bell"),
            "-", "B, bridge", "0, single",
        ),
        "as rung; empty when speed is kept or turns are ordered",
    ),
    Instrument(
        "INXDR",
        "attitude",
        (
            "A", ("angle [deg], bow up positive", "pitch"), "D", "PITCH",
            "A", ("angle [deg], to starboard positive", "heel"), "D", "ROLL",
        ),
        "true",
    ),
    Instrument(
        "INXDR", "the boat's depth", ("D", ("depth [m]", "depth"), "M", "DEPTH"), GAUGES_NOTE
    ),
    Instrument(
        "INXDR",
        "planes",
        (
            "A", ("angle [deg], rising positive", "stern"), "D", "STERN",
            "A", ("angle [deg], rising positive", "bow"), "D", "BOW",
        ),
        "as they are",
    ),
    Instrument(
        "PXSC",
        "own: motion",
        (
            "M", TICK_FIELD, ("depth [m]", "depth"), ("heading [deg]", "heading"),
            ("speed through the water [kn]", "speed"), ("pitch [deg]", "pitch"),
            ("heel [deg]", "heel"), ("rate of turn [deg/s]", "turn_per_second"),
        ),
        f"depth, heading and speed {GAUGES_NOTE}, the rest true",
    ),
    Instrument(
        "PXSC",
        "own: place",
        (
            "P", TICK_FIELD, ("north of the origin [m]", "north"), ("east of it [m]", "east"),
            ("track [deg]", "track"), ("speed over the ground [kn]", "over_ground"),
        ),
        TRUE_NOTE,
    ),
    Instrument(
        "PXSC",
        "own: surfaces, right and rising positive",
        (
            "C", TICK_FIELD, ("rudder [deg]", "rudder"), ("ordered [deg]", "ordered_rudder"),
            ("stern planes [deg]", "stern"), ("ordered [deg]", "ordered_stern"),
            ("bow planes [deg]", "bow"), ("ordered [deg]", "ordered_bow"),
        ),
        "as they are and as ordered",
    ),
    Instrument(
        "PXSC",
        "own: engine, and what the autopilot keeps",
        (
            "E", TICK_FIELD, ("revolutions [1/min]", "rpm"), ("ordered [1/min]", "ordered_rpm"),
            ("depth kept [m]", "ordered_depth"), ("course kept [deg]", "ordered_course"),
            ("speed kept [kn]", "ordered_speed"),
        ),
        "as they are and as ordered",
    ),
    Instrument(
        "PXSC",
        "own: ballast",
        (
            "B", TICK_FIELD, ("tanks [% full]: forward", "full_forward"),
            *((tank.replace("_", " "), f"full_{tank}") for tank in BALLAST_TANKS[1:]),
        ),
        "as they are",
    ),
    Instrument(
        "PXSC",
        "own: air banks",
        ("A", TICK_FIELD, *((f"{bank} [MPa]", f"air_{bank}") for bank in BANKS)),
        "as they are",
    ),
)
# fmt: on
SENTENCE_NAMES: Final = tuple(dict.fromkeys(instrument.name for instrument in INSTRUMENTS))
USUAL_NAMES: Final = tuple(dict.fromkeys(each.name for each in INSTRUMENTS if not each.asked))


def choose_instruments(names: Iterable[str]) -> tuple[Instrument, ...]:
    """Return the instruments of those names, in the order that they are sent."""
    wanted = frozenset(names)
    return tuple(instrument for instrument in INSTRUMENTS if instrument.name in wanted)


def widest(instruments: Iterable[Instrument]) -> tuple[int, int]:
    """Return sentences and size [bytes] of the longest set that they can make."""
    sent = [each.sentence(WIDEST_READINGS) for each in instruments if each.fits(WIDEST_READINGS)]
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
        seen = read_fields(frame, self._chart, self._start)
        sentences = [each.sentence(seen) for each in self._instruments if each.fits(seen)]
        return sentences + self._receiver.lines(frame) if self._receiver else sentences


class SampledDisplay:
    """A display at a rate of the boat's own time, however fast that goes.

    A recorded file needs it, since nobody waits for its lines.
    """

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
