"""How deep a jam or a flooding would take the boat, flown ahead.

Each danger comes at once, and her crew answers it after some seconds with orders that stand here.
A page shows the greatest depth on the way, from the present moment, and for each speed the depth
that is safe: from where neither danger takes her beyond test depth. Navies call such a diagram
a safe operating envelope. Sizes and seconds are the project's own estimates.

The flight begins in trim and in a calm, with everything in hand. So it tells a crew nothing that
its gauges do not.
"""

import time
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import insert_casualty
from trainer.boat.helm import obey_order
from trainer.config.boat.casualties import load_casualties
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.units import KNOT

Z_OFFSET: Final = np.array([STATE_OFFSETS["z"]], np.int64)
FLOWN_AFTER_S: Final = 180.0  # [s] after the answer, when a boat that can be saved rises: estimate
SPEED_COUNT: Final = 8  # of the diagram, evenly spaced up to the fastest
DEPTH_HALVINGS: Final = 6  # of the depths from 0 to test depth: to 1/64 of it


class Danger(NamedTuple):
    """A casualty, and how a crew answers it."""

    casualty: str
    severity: float  # [-] of the casualty in the standard table
    answered_s: float  # [s] after it has come
    answers: tuple[str, ...]


STERN_JAM: Final = Danger(
    "stern-hard-over",
    -1.0,  # full dive
    15.0,
    ("bow planes full rise", "bell astern full", "blow main ballast"),
)
AFT_FLOODING: Final = Danger(
    "flooding-aft",
    8.0,  # 400 cm2: a pipe of 22 cm
    30.0,
    ("bow planes full rise", "stern planes full rise", "bell ahead full", "emergency blow"),
)


class Flight(NamedTuple):
    """How the boat goes, by her gauges [SI, rad]."""

    speed: float
    depth: float
    pitch: float = 0.0


class SafeDepth(NamedTuple):
    """The greatest safe depth [m] at a speed [m/s], for each danger, in level flight.

    None for a danger that the boat cannot have.
    """

    speed: float
    jam: float | None
    flooding: float | None


class FlightAhead:
    """A boat of its own, flown into a danger and out of it."""

    def __init__(self, boat: Boat) -> None:
        """Have a boat as ``boat`` is fitted out, with nothing around it."""
        self._boat = boat.another()
        self._boat.sound_by(None)
        self._boat.sea = load_sea("calm")
        self._boat.casualties = load_casualties()  # whatever a table of the user's has
        self._test_depth = boat.file.hull.test_depth_m or 0.0

    def find_deepest(self, flight: Flight, danger: Danger) -> float | None:
        """Return the greatest depth [m] from a flight on if the danger came now.

        None if the boat cannot have it, or cannot be in trim at that speed. Answers that the boat
        lacks are left out.
        """
        boat, (speed, depth, pitch) = self._boat, flight
        try:
            boat.start(speed, depth, 0.0)
        except ConfigError:
            return None
        s = boat.state
        s.by_hand[:] = s.speed_by_hand = s.trim_by_hand = 1.0
        s.theta += pitch
        if isinstance(insert_casualty(boat, danger.casualty, danger.severity, 0.0), Refused):
            return None
        deepest = self._fly(danger.answered_s)
        for text in danger.answers:
            order = parse(text)
            assert isinstance(order, Order)  # noqa: S101 (this module's own words)
            obey_order(boat, order)
        return max(deepest, self._fly(FLOWN_AFTER_S))

    @cached_property
    def safe_depths(self) -> list[SafeDepth]:
        """Return the safe depths by speed, where the boat can be in trim."""
        fastest = self._boat.file.propulsion.max_ordered_speed_kn * KNOT
        speeds = [count / SPEED_COUNT * fastest for count in range(1, SPEED_COUNT + 1)]
        found = [
            SafeDepth(
                speed, *(self._find_safe(speed, danger) for danger in (STERN_JAM, AFT_FLOODING))
            )
            for speed in speeds
        ]
        return [row for row in found if row[1:] != (None, None)]

    def _find_safe(self, speed: float, danger: Danger) -> float | None:
        """Return the greatest depth [m] from which a danger ends above test depth, at a speed."""
        safe, unsafe = 0.0, self._test_depth
        for _ in range(DEPTH_HALVINGS):
            middle = 0.5 * (safe + unsafe)
            if (deepest := self.find_deepest(Flight(speed, middle), danger)) is None:
                return None
            safe, unsafe = (middle, unsafe) if deepest <= self._test_depth else (safe, middle)
            time.sleep(0)  # other threads have their turn
        return unsafe if unsafe == self._test_depth else safe

    def _fly(self, seconds: float) -> float:
        """Fly on; return the greatest depth [m], that of before a tick that failed at most."""
        rows = np.empty((self._boat.ticks_in(seconds), 1))
        begun, depth = self._boat.ticks, float(self._boat.state.z)
        with np.errstate(all="ignore"):
            self._boat.fly(Z_OFFSET, rows)
        return float(rows[: self._boat.ticks - begun].max(initial=depth))
