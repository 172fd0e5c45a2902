"""A manoeuvre flown, from its start to its end or to where the numbers were lost."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.study.manoeuvres.conn import Conn, Mark
from trainer.study.manoeuvres.measures import Measure
from trainer.study.manoeuvres.vehicle import (
    LostError,
    Vehicle,
    check_columns,
    check_controls,
)
from trainer.study.series import Series

LONGEST = 2_000_000  # [cycles] of a flight


@dataclass(frozen=True)
class Flight:
    """What a manoeuvre looked like, and its events."""

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
        if time > self.t[-1] + 1e-9:
            return None
        return float(np.interp(time, self.t, self.column(name)))

    def since(self, time: float) -> slice:
        """Return the place of all rows from ``time`` [s] on."""
        return slice(int(np.searchsorted(self.t, time - 1e-9)), None)


@dataclass(frozen=True)
class Manoeuvre(ABC):
    """A schedule and its measures; the fields of each kind are its parameters.

    What ``shows`` names is plotted over time, but "track" y over x; ``angle_deg`` is that of the
    first control needed.
    """

    needs: ClassVar[tuple[str, ...]] = ()  # controls of the vehicle
    compared: ClassVar[tuple[str, ...]] = ()  # columns judged by their change of change
    shows: ClassVar[tuple[str, ...]] = ()
    from_rest: ClassVar[bool] = False

    @abstractmethod
    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield once for every cycle, orders given before."""

    @abstractmethod
    def measures(self, flight: Flight) -> list[Measure]:
        """Return what the flight is measured by."""


def fly(
    vehicle: Vehicle, manoeuvre: Manoeuvre, speed: float, others: Sequence[float | None] = ()
) -> Flight:
    """Return the flight of a manoeuvre that begins at ``speed`` [m/s].

    ``others`` are the events of a flight beside which this one is flown, as ``Conn`` has it.
    ConfigError if the vehicle lacks a control or what is measured, or cannot start so.
    """
    check_controls(vehicle, manoeuvre.needs)
    check_columns(vehicle, manoeuvre.compared)
    vehicle.start(speed)
    conn = Conn(vehicle, others)
    lost, left = "", LONGEST
    try:
        with np.errstate(all="ignore"):  # what is lost is told by the vehicle
            for _ in manoeuvre.schedule(conn):
                vehicle.advance()
                conn.look()
                left -= 1
                if left == 0:
                    raise ConfigError(f"{vehicle.name}: does not end in {LONGEST} cycles")
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
