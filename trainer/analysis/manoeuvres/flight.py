"""A manoeuvre is flown from its start to its end, or until numbers are lost.

``trainer boat manoeuvre``, the guide, sweeps and reductions call ``fly_manoeuvre``. A schedule is a
generator that gives its orders to a ``Conn``: between two yields the vehicle moves by one cycle,
with the controls as ordered before. Events are seen at the starts of cycles, as in the program
CONTR of 1969: up to a cycle after they happen. Two vehicles may see one event a cycle apart, and
that alone would part their ways. A vehicle flown beside another therefore takes the other's time of
an event, unless its own is more than a cycle away.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Final, NamedTuple

import numpy as np

from trainer.analysis.manoeuvres.vehicle import (
    DIRECTION_SIGNS,
    DIVE,
    PORT,
    RISE,
    STARBOARD,
    FastVehicle,
    LostError,
    Measure,
    Side,
    Vehicle,
    Watch,
    check_parts,
)
from trainer.config.files import ConfigError
from trainer.config.ship.series import Series
from trainer.core.kernel import Numbers

CycleGenerator = Generator[None, None, None]
LEAD_TIME_S: Final = 2.0  # [s] of straight motion before most manoeuvres
TIME_ROUNDING_S = 1e-9  # [s] rounding of a sum of steps
MAX_FLIGHT_CYCLES = 2_000_000  # [cycles] of a flight
# fmt: off
MIRRORED_COLUMNS: Final = (
    "v", "p", "r", "y", "phi", "psi", "delta_r",
)  # columns that a mirror turns over
# fmt: on
FIELD_CHOICES: Final = {"side": (STARBOARD, PORT), "direction": (RISE, DIVE)}


class Mark(NamedTuple):
    """An event of the schedule."""

    name: str
    t: float  # [s]


class Conn:
    """The conn of a vehicle: it gives a schedule's orders, and marks events."""

    def __init__(self, vehicle: Vehicle, others: Sequence[float | None] = ()) -> None:
        """Take the conn of a vehicle that has been started.

        ``others`` are the times [s] of events of the vehicle that this one is flown beside.
        """
        self.vehicle = vehicle
        self.events: list[float | None] = []  # [s] of each that was waited for; None: never
        self._others = list(others)
        self.marks: list[Mark] = []
        self.ordered: dict[str, float] = {}  # what was ordered last, by control
        self._indices = {name: i for i, name in enumerate(vehicle.columns)}
        self.seen: tuple[float, ...] = ()
        self._blocks: list[Numbers] = []
        self._rows: list[tuple[float, ...]] = []
        self.look()

    def look(self) -> None:
        """Keep the columns at the start of this cycle as a row of the flight."""
        self.seen = self.vehicle.observe()
        self._rows.append(self.seen)

    @property
    def table(self) -> Numbers:
        """Return the columns of the whole flight, a row for every cycle."""
        self._close()
        return np.concatenate(self._blocks)

    def _close(self) -> None:
        """Make a block of the rows seen one by one."""
        if self._rows:
            self._blocks.append(np.array(self._rows))
            self._rows = []

    def value(self, column: str) -> float:
        """Return a column as it stands at the start of this cycle."""
        return self.seen[self._indices[column]]

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self.value("t")

    def order(self, control: str, value: float) -> None:
        """Order a control, and remember it."""
        self.ordered[control] = value
        self.vehicle.order(control, value)

    def mark(self, name: str) -> None:
        """Mark an event here and now."""
        self.marks.append(Mark(name, self.time))

    def hold(self, seconds: float) -> CycleGenerator:
        """Advance by some time, all controls held."""
        yield from self._pass(self.time + seconds - TIME_ROUNDING_S, None)

    def hold_to(self, time: float) -> CycleGenerator:
        """Advance to ``time`` [s] since the start."""
        yield from self.hold(time - self.time)

    def until(self, watch: Watch, most: float) -> Generator[None, None, bool]:
        """Advance until the watched quantity passes, ``most`` [s] at most. Return whether so."""
        end = self.time + most - TIME_ROUNDING_S
        other = self._others.pop(0) if self._others else None
        passed = other is not None and (yield from self._beside(watch, other))
        if not passed:
            yield from self._pass(end, watch)
            passed = self.passed(watch)
        self.events.append(self.time if passed else None)
        return passed

    def _beside(self, watch: Watch, other: float) -> Generator[None, None, bool]:
        """Let time pass to the ``other``'s event [s], or to this vehicle's if it is far earlier.

        Return whether this vehicle's event is within a cycle of the other's. The watch ends 1.5
        cycles before it, because an event is seen up to a cycle late and times are rounded by half
        a cycle. An event that is still to come is foreseen by the rate of the last cycle.
        """
        cycle = self.vehicle.step
        yield from self._pass(other - 1.5 * cycle, watch)
        if self.time < other - 1.5 * cycle:
            return False
        before = self._beyond(watch)
        yield from self._pass(other - 0.5 * cycle, None)
        now = self._beyond(watch)
        return max(before, now, 2.0 * now - before) >= 0.0

    def passed(self, watch: Watch) -> bool:
        """Return whether a quantity has passed its mark, at the start of this cycle."""
        return self._beyond(watch) >= 0.0

    def _beyond(self, watch: Watch) -> float:
        """Return how far a quantity is beyond its mark, negative before it."""
        if watch.quantity == "depth rate":
            theta = self.value("theta")
            value = self.value("w") * math.cos(theta) - self.value("u") * math.sin(theta)
        elif watch.quantity == "size of theta":
            value = abs(self.value("theta"))
        else:
            value = self.value(watch.quantity)
        return watch.side * (value - watch.mark)

    def _pass(self, end: float, watch: Watch | None) -> CycleGenerator:
        """Let time pass to ``end`` [s], or until the watched quantity passes."""
        # many cycles in one call, in machine code, where the vehicle can: the same numbers, sooner
        if isinstance(self.vehicle, FastVehicle) and self.vehicle.swift:
            self._close()
            rows = self.vehicle.sail(end, watch)
            if len(rows):
                self._blocks.append(rows)
                self.seen = tuple(rows[-1].tolist())
            self.vehicle.sound()  # LostError, once the rows before are kept
            return
        while self.time < end and not (watch and self.passed(watch)):
            yield


@dataclass(frozen=True)
class Flight:
    """The record of a manoeuvre, and its events."""

    speed: float  # [m/s] at which it began
    length: float  # [m] of the vehicle
    step: float  # [s]
    series: Series
    marks: tuple[Mark, ...]
    lost: str  # why it ended early; "" if it did not
    events: tuple[float | None, ...] = ()  # [s] of what the schedule waited for; None: never

    @property
    def t(self) -> Numbers:
        """Return the times [s] since the start."""
        return self.series.t

    def column(self, name: str) -> Numbers:
        """Return a column, SI and radians."""
        return self.series.columns[name]

    def has(self, name: str) -> bool:
        """Return whether the vehicle has that column."""
        return name in self.series.columns

    def change(self, name: str) -> Numbers:
        """Return a column less its value at the start."""
        return np.asarray(self.column(name) - self.column(name)[0])

    def time_of(self, mark: str) -> float | None:
        """Return when [s] the first event of that name was; None: never."""
        return next((event.t for event in self.marks if event.name == mark), None)

    def at(self, time: float, name: str) -> float | None:
        """Return a column at ``time`` [s], interpolated; None after the end."""
        if time > self.t[-1] + TIME_ROUNDING_S:
            return None
        return float(np.interp(time, self.t, self.column(name)))

    def counted_to(self, side: Side) -> "Flight":
        """Return the flight with what is positive to starboard positive to ``side``.

        A flight to port is mirrored: for a boat that is alike on both sides it becomes the flight
        to starboard.
        """
        if side == STARBOARD:
            return self
        turned = {name: 0.0 - self.column(name) for name in MIRRORED_COLUMNS if self.has(name)}
        series = Series(self.series.path, {**self.series.columns, **turned})
        return replace(self, series=series)

    def along(self, mark: str) -> "Flight":
        """Return the flight with x and y along and across the heading at a mark."""
        heading = self.at(self.time_of(mark) or 0.0, "psi") or 0.0
        x, y = self.column("x"), self.column("y")
        cosine, sine = math.cos(heading), math.sin(heading)
        laid = {"x": cosine * x + sine * y, "y": cosine * y - sine * x}
        return replace(self, series=Series(self.series.path, {**self.series.columns, **laid}))

    @property
    def last_speed(self) -> float:
        """Return the speed [m/s] at the end, whichever way the hull points."""
        return math.hypot(*(self.column(name)[-1] for name in ("u", "v", "w") if self.has(name)))

    @property
    def speed_left(self) -> float | None:
        """Return ``last_speed`` as a share [-] of the first; None from rest."""
        return self.last_speed / abs(self.speed) if self.speed else None

    def since(self, time: float) -> slice:
        """Return the place of all rows from ``time`` [s] on."""
        return slice(int(np.searchsorted(self.t, time - TIME_ROUNDING_S)), None)


@dataclass(frozen=True)
class Manoeuvre(ABC):
    """A schedule and its measures; the fields of each kind are its parameters.

    The columns in ``shows`` are plotted over time, but "track" is y over x; ``angle_deg`` is the
    angle of the first control in ``needs``.

    Where it is ``in_waves`` all sets are flown by one method: a step has an error of its own there.

    A manoeuvre with a ``side`` goes there first, and its measures are positive to that side, so
    that a boat alike on both sides has the same figures either way. A manoeuvre with a
    ``direction`` goes up or down first; pitch and depth keep their own signs, bow up and deeper.
    ConfigError for an unknown side or direction.
    """

    needs: ClassVar[tuple[str, ...]] = ()  # controls of the vehicle
    compared: ClassVar[tuple[str, ...]] = ()  # columns judged by their change of change
    shows: ClassVar[tuple[str, ...]] = ()
    from_rest: ClassVar[bool] = False
    in_waves: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name, known in FIELD_CHOICES.items():
            choice = getattr(self, name, known[0])
            if choice not in known:
                raise ConfigError(f"{name} = {choice!r}: must be {known[0]} or {known[1]}")

    @property
    def sign(self) -> float:
        """Return the sign of the first order: positive to starboard, or to rise."""
        return next(
            DIRECTION_SIGNS[getattr(self, name)] for name in FIELD_CHOICES if hasattr(self, name)
        )

    @abstractmethod
    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield once for every cycle, orders given before."""

    @abstractmethod
    def measures(self, flight: Flight) -> list[Measure]:
        """Return the measures of the flight."""


def fly_manoeuvre(
    vehicle: Vehicle, manoeuvre: Manoeuvre, speed: float, others: Sequence[float | None] = ()
) -> Flight:
    """Return the flight of a manoeuvre that begins at ``speed`` [m/s].

    ``others`` are the events of a flight beside which this one is flown, as ``Conn`` has it.
    ConfigError if the vehicle lacks a control or what is measured, or cannot start so.
    """
    check_parts(vehicle, manoeuvre.needs, manoeuvre.compared)
    vehicle.start(speed)
    conn = Conn(vehicle, others)
    lost, cycles_left = "", MAX_FLIGHT_CYCLES
    try:
        with np.errstate(all="ignore"):  # the vehicle itself reports that it is lost
            for _ in manoeuvre.schedule(conn):
                vehicle.advance()
                conn.look()
                cycles_left -= 1
                if cycles_left == 0:
                    raise ConfigError(f"{vehicle.name}: does not end in {MAX_FLIGHT_CYCLES} cycles")
    except LostError as gone:
        lost = str(gone)
    table = conn.table
    columns = {name: table[:, i] for i, name in enumerate(vehicle.columns)}
    return Flight(
        speed=speed,
        length=vehicle.length,
        step=vehicle.step,
        series=Series(Path(vehicle.name), columns),
        marks=tuple(conn.marks),
        events=tuple(conn.events),
        lost=lost,
    )
