"""What a manoeuvre needs of whatever flies it, be it a submarine, a ship or a torpedo."""

from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from trainer.config import ConfigError


class Control(NamedTuple):
    """The limits of one control."""

    low: float  # [rad], of the engine [m/s]
    high: float


class Watch(NamedTuple):
    """A quantity that is looked at until it passes its mark."""

    quantity: str  # a column, "size of theta" or "depth rate", which is without roll
    mark: float  # [rad] or [m/s]
    side: float = 1.0  # 1: at or above the mark is past it, -1: at or below


class LostError(Exception):
    """The vehicle's numbers are beyond all bounds; the text says which and when."""


class Vehicle(Protocol):
    """A vehicle in numbers, advanced cycle by cycle.

    Columns are SI and radians, by the names of ``trainer run --csv``: t u v w p q r x y z phi theta
    psi delta_r ...; a vehicle has those that mean something to it, t u v r x y psi at least.

    Controls: ``rudder`` [rad] from its neutral angle, positive turns to starboard; ``planes`` [rad]
    from theirs, positive raises the bow; ``engine``, the ordered speed [m/s], negative astern.
    """

    @property
    def name(self) -> str:
        """Return what it is called."""
        ...

    @property
    def length(self) -> float:
        """Return its length [m]."""
        ...

    @property
    def step(self) -> float:
        """Return the length of a cycle [s]."""
        ...

    @property
    def columns(self) -> tuple[str, ...]:
        """Return the names of what ``observe`` returns."""
        ...

    @property
    def controls(self) -> Mapping[str, Control]:
        """Return the limits of its controls by name."""
        ...

    def start(self, speed: float) -> None:
        """Begin anew in steady, straight, level motion at ``speed`` [m/s]; at 0 lie still.

        Controls stand at neutral and stay there. ConfigError if that cannot be.
        """
        ...

    def incline(self, heel: float) -> None:
        """Heel it by ``heel`` [rad] as it is, without a rate."""
        ...

    def order(self, control: str, value: float) -> None:
        """Order a control; it acts from the coming cycle on."""
        ...

    def keep(self, quantity: str) -> None:
        """Leave "depth" or "speed" as it is now to automatic control, where there is such."""
        ...

    def observe(self) -> tuple[float, ...]:
        """Return its columns as they stand."""
        ...

    def advance(self) -> None:
        """Advance by one cycle, controls held; LostError if its numbers go astray."""
        ...


@runtime_checkable
class Swift(Protocol):
    """A vehicle that can let many cycles pass at once, with the numbers of as many by one."""

    @property
    def swift(self) -> bool:
        """Return whether it can as it is handled now."""
        ...

    def sail(self, end: float, watch: Watch | None) -> NDArray[np.float64]:
        """Advance to ``end`` [s], or until what is watched passes; return a row for each cycle."""
        ...

    def sound(self) -> None:
        """Check how the last ``sail`` ended; LostError if the numbers went astray in it."""
        ...


def limit(vehicle: Vehicle, control: str) -> float:
    """Return how far [rad] a surface goes to both sides."""
    low, high = vehicle.controls[control]
    return min(-low, high)


def check_controls(vehicle: Vehicle, needed: tuple[str, ...]) -> None:
    """Check that the vehicle has the controls; ConfigError if it lacks one."""
    for control in needed:
        if control not in vehicle.controls:
            known = ", ".join(vehicle.controls)
            raise ConfigError(
                f"{vehicle.name}: the manoeuvre needs a control {control!r}, "
                f"and it has {known} alone"
            )


def check_columns(vehicle: Vehicle, needed: tuple[str, ...]) -> None:
    """Check that the vehicle has the columns; ConfigError if it lacks one."""
    for column in needed:
        if column not in vehicle.columns:
            known = ", ".join(vehicle.columns)
            raise ConfigError(
                f"{vehicle.name}: the manoeuvre is measured by {column}, and it has {known} alone"
            )
