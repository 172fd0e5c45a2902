"""Zig-zags: a control is thrown to the other side whenever an angle reaches its mark.

``catalogue`` offers them, and experiments for an identification are made of them. The standard
10/10 and 20/20 with the rudder, and the same with planes and pitch. The overshoot is how far the
angle goes on after the control was reversed.
"""

import math
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from trainer.analysis.manoeuvres.flight import LEAD_TIME_S, Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    RISE,
    STARBOARD,
    Direction,
    Measure,
    Side,
    Watch,
    first_time,
    heel_measure,
    largest_value,
    peaks_of,
    share_measure,
    show_only,
)
from trainer.core.kernel import Numbers

SHOWN_PEAKS: Final = 4  # peaks that are reported


@dataclass(frozen=True)
class ThrowOver(Manoeuvre):
    """One control from side to side; all but depth counts to the side first ordered."""

    control: ClassVar[str]
    watched: ClassVar[str]
    called: ClassVar[str]
    rate: ClassVar[str]
    keep: ClassVar[tuple[str, ...]] = ()

    angle_deg: float = 20.0  # control
    execute_deg: float = 20.0  # of what is watched
    duration_s: float = 300.0

    @abstractmethod
    def track(self, flight: Flight) -> list[Measure]:
        """Return how far the vehicle left its first course or depth."""

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the zig-zag; angles count from the start."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        level = conn.value(self.watched)
        angle, execute = math.radians(self.angle_deg), math.radians(self.execute_deg)
        yield from conn.hold(LEAD_TIME_S)
        side = self.sign
        while conn.time < self.duration_s:
            conn.order(self.control, side * angle)
            conn.mark("execute")
            mark = level + side * execute
            watch = Watch(self.watched, mark, side)
            reached = yield from conn.until(watch, self.duration_s - conn.time)
            if not reached:
                return
            side = -side

    def measures(self, flight: Flight) -> list[Measure]:
        """Return executes, peaks, overshoots, rates, crossings, speed and track."""
        angle = self.sign * flight.change(self.watched)
        executes = [mark.t for mark in flight.marks]
        if not executes:
            return [show_only("time of execute 2", "s", None)]
        measures = self._swings(flight.t, angle, executes)
        rates = self.sign * flight.column(self.rate)
        measures += [
            share_measure("largest rate", "rad/s", float(rates.max())),
            share_measure("smallest rate", "rad/s", float(rates.min())),
            share_measure("last speed, of the first", "-", flight.speed_left),
        ]
        if len(executes) > 1:
            measures.insert(0, share_measure("time of execute 2", "s", executes[1] - executes[0]))
        return measures + self.track(flight)

    def _swings(self, t: Numbers, angle: Numbers, executes: list[float]) -> list[Measure]:
        """Return peak, its time and overshoot of the swings, and the zeros between."""
        begin, mark = executes[0], math.radians(self.execute_deg)
        tops = [top for top in peaks_of(t, angle) if abs(top[1]) >= mark][:SHOWN_PEAKS]
        measures = []
        for i, (when, value) in enumerate(tops, start=1):
            measures += [
                share_measure(f"{self.called} peak {i}", "rad", value),
                share_measure(f"time of {self.called} peak {i}", "s", when - begin),
                show_only(f"{self.called} overshoot {i}", "rad", abs(value) - mark),
            ]
            after = t > when
            zero = first_time(t[after], angle[after], 0.0) if after.any() else None
            if zero is not None:
                measures.append(share_measure(f"time of {self.called} zero {i}", "s", zero - begin))
        for i, (when, _) in enumerate(tops[1:], start=2):
            ratio = (when - begin) / (tops[0][0] - begin)
            measures.append(share_measure(f"time of peak {i}, of the first's", "-", ratio))
        return measures


@dataclass(frozen=True)
class ZigZag(ThrowOver):
    """Rudder from side to side."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    compared: ClassVar[tuple[str, ...]] = ("u",)
    shows: ClassVar[tuple[str, ...]] = ("psi", "delta_r", "phi", "u")
    control: ClassVar[str] = "rudder"
    watched: ClassVar[str] = "psi"
    called: ClassVar[str] = "heading"
    rate: ClassVar[str] = "r"
    keep: ClassVar[tuple[str, ...]] = ("depth",)

    side: Side = STARBOARD  # first

    def track(self, flight: Flight) -> list[Measure]:
        """Return the track across the heading at the first order, and the roll.

        The first run to the side is judged. The largest of many runs is not, because it contains
        the mean heading, which depends on the cycle in which each execute was seen.
        """
        flight = flight.counted_to(self.side).along("execute")
        aside = flight.change("y")
        most = float(aside.max())
        runs = [y for _, y in peaks_of(flight.t, aside) if y > 0.5 * most]
        measures = [
            share_measure("first sideways run", "m", runs[0] if runs else None),
            show_only("largest sideways run", "m", most),
        ]
        if flight.has("phi"):
            rolls = flight.column("phi")
            measures += [
                heel_measure("largest roll", float(rolls.max())),
                heel_measure("smallest roll", float(rolls.min())),
            ]
        return measures


@dataclass(frozen=True)
class VerticalZigZag(ThrowOver):
    """Planes to rise and to dive in turns."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    compared: ClassVar[tuple[str, ...]] = ("u",)
    shows: ClassVar[tuple[str, ...]] = ("theta", "delta_s", "z", "u")
    control: ClassVar[str] = "planes"
    watched: ClassVar[str] = "theta"
    called: ClassVar[str] = "pitch"
    rate: ClassVar[str] = "q"

    angle_deg: float = 10.0  # control
    execute_deg: float = 10.0  # pitch
    duration_s: float = 200.0
    direction: Direction = RISE  # first

    def track(self, flight: Flight) -> list[Measure]:
        """Return the first turning points of depth, in metres and in lengths."""
        turned = [mark.t for mark in flight.marks][1:2]  # before it depth may turn as a plane bites
        tops = [
            top for top in peaks_of(flight.t, flight.change("z")) if turned and top[0] > turned[0]
        ]
        first = tops[0][1] if tops else None
        lengths = None if first is None else abs(first) / flight.length
        return [
            share_measure("first depth excursion", "m", first),
            share_measure("first depth excursion, in lengths", "-", lengths),
            show_only("largest depth change", "m", largest_value(flight.change("z"))),
        ]
