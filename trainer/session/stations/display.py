"""How a channel is written: a sentence for programs, words for people, or columns.

A subscription holds one display, and calls it with each frame that is due. A display returns the
lines to send.
"""

import math
import textwrap
from collections.abc import Callable
from typing import Final, Protocol

from trainer.boat.casualties import InstrumentReadings
from trainer.boat.crew_orders import CREW_AXES
from trainer.io.orders import sentences
from trainer.io.status_line import StatusView, header, state_line
from trainer.session.stations.aid_channels import AID_CHANNELS
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.panels import Channel
from trainer.session.stations.view import Frame
from trainer.units import KNOT

MAX_LINE_LETTERS: Final = 79  # [characters]
HEADING_PERIOD_LINES: Final = 20  # [lines]


class Display(Protocol):
    """One way to show frames, one after another."""

    def lines(self, frame: Frame) -> list[str]:
        """Return the lines to be sent for this frame."""


class SentenceDisplay:
    """A channel for a program: its names and units once, then its values."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._named = False

    def lines(self, frame: Frame) -> list[str]:
        """Return the values, under their names if these have not been sent.

        The frame keeps the sentence, because thirty stations look at seven channels.
        """
        name, fields = self._channel.name, self._channel.fields
        if (values := frame.kept.get(f"sentence {name}")) is None:
            values = sentences.state(name, frame.tick, frame.seconds, self._channel.values(frame))
            frame.kept[f"sentence {name}"] = values
        if self._named:
            return [values]
        self._named = True
        return [sentences.names(name, [(each.name, each.unit) for each in fields]), values]


class WordDisplay:
    """A channel for a reader: name, value and unit of every field that has one."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel

    def lines(self, frame: Frame) -> list[str]:
        """Return the values in at most 79 columns."""
        return in_words(self._channel, frame)


class TeletypeDisplay:
    """The state in one line, under headings every so often."""

    def __init__(self, shown: Callable[[Frame], InstrumentReadings]) -> None:
        """Show depth, heading and speed as ``shown``: by the gauges, or as they are."""
        self._shown = shown
        self._since_heading = HEADING_PERIOD_LINES  # [lines]

    def lines(self, frame: Frame) -> list[str]:
        """Return the line of state, under headings if they are due."""
        line = state_line(view(frame, self._shown(frame)))
        if self._since_heading < HEADING_PERIOD_LINES:
            self._since_heading += 1
            return [line]
        self._since_heading = 1
        return [header(), line]


def in_words(channel: Channel, frame: Frame) -> list[str]:
    """Return a channel as words, in at most 79 columns."""
    shown = (
        f"{field.name} {words}".replace(" ", "\0")
        for field in channel.fields
        if not field.packed and (words := field.words(frame))
    )
    summary = f"{channel.name}, {frame.seconds:g} s: {', '.join(shown) or 'nothing'}"
    wrapped = textwrap.wrap(
        summary, MAX_LINE_LETTERS, subsequent_indent="  ", break_on_hyphens=False
    )
    return [line.replace("\0", " ") for line in wrapped]


def panel(channels: tuple[str, ...], frame: Frame) -> list[str]:
    """Return the instruments of some channels in words, for the order ``status``."""
    known = (CHANNELS[name] for name in channels if name in CHANNELS)
    shown = (
        each
        for each in known
        if not (all(field.packed for field in each.fields) or each.lack(frame.boat))
        and (each not in AID_CHANNELS or any(each.values(frame)))
    )
    return [line for channel in shown for line in in_words(channel, frame)]


def view(frame: Frame, shown: InstrumentReadings) -> StatusView:
    """Return the line of state in display units, with depth, heading and speed as ``shown``."""
    toward, propulsion = frame.boat.toward, frame.boat.file.propulsion
    planes_by_hand = frame["stern_by_hand"] and frame["bow_by_hand"]
    ordered_heading = None if frame["rudder_by_hand"] else frame["ordered_psi"]
    course = ordered_value(frame, "course", ordered_heading)
    return StatusView(
        time_s=frame.seconds,
        depth_m=shown.depth,
        course_deg=math.degrees(shown.heading) % 360.0,
        speed_kn=shown.speed / KNOT,
        pitch_deg=math.degrees(frame["theta"]),
        heel_deg=math.degrees(frame["phi"]),
        rudder_deg=math.degrees(frame["delta_r"]) * toward["rudder"],
        stern_deg=math.degrees(frame["delta_s"]) * toward["stern"],
        bow_deg=math.degrees(frame["delta_b"]) * toward["bow"],
        rpm=frame["u_c"] * propulsion.rps_per_mps * 60.0,
        ordered_depth_m=ordered_value(
            frame, "depth", None if planes_by_hand else frame["ordered_depth"]
        ),
        ordered_course_deg=None if course is None else math.degrees(course) % 360.0,
        frozen=frame.pace.frozen,
        rudder_manual=bool(frame["rudder_by_hand"]),
        stern_manual=bool(frame["stern_by_hand"]),
        bow_manual=bool(frame["bow_by_hand"]),
    )


def ordered_value(frame: Frame, axis: str, kept: float | None) -> float | None:
    """Return the crew's order on an axis [SI], else what the autopilot keeps."""
    index = CREW_AXES.index(axis)
    return frame.at("crew_order", index) if frame.at("crew_order_tick", index) else kept
