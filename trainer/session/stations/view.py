"""The view of one tick, from which the fields of all channels are read.

The thread that ticks hands over a state as bytes (``Picture``), because copying bytes is all that
it has time for. The thread that sends makes a ``Frame`` of it: its numbers by name, and what the
boat's gauges show of them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import InstrumentReadings
from trainer.boat.motion_rates import MotionRates, read_rates
from trainer.boat.world.bottom import keel_of
from trainer.core.casualties import instruments
from trainer.core.state import SOUNDING_COUNT, new_scratch, new_state
from trainer.session.stations.aids import NO_AIDS, ShownAids
from trainer.session.time.ledger import Summary

STATE_BYTES: Final = new_state().nbytes


class Pace(NamedTuple):
    """How time runs, and the other things shown that no state holds."""

    frozen: bool = False
    speed: float = 1.0  # [-] infinity: as fast as it goes
    branch: int = 1  # of the recording
    replaying: bool = False
    told: str = ""  # the last words to the crew, by the order ``tell``
    after: int = 0  # the last order, by which orders to the world are found
    shows_way: bool = False  # the reference crew flies
    aids: ShownAids = NO_AIDS


class Picture(NamedTuple):
    """A tick's output: the whole state as bytes, and how time runs."""

    tick: int
    state: bytes
    pace: Pace


class Fittings(NamedTuple):
    """The scales of tanks, banks and weight: the vessel's constants as plain numbers."""

    capacity: tuple[float, ...]  # [kg] by tank
    bank_volume: tuple[float, ...]  # [m3]
    bank_full: tuple[float, ...]  # [kg]
    gas: float  # [J/kg]
    buoyancy: float  # [N]
    g: float  # [m/s2]
    sail: tuple[float, float]  # [m] its top, body axes x and z
    length: float  # [m]
    keel: float  # [m] below the origin

    @classmethod
    def of(cls, boat: Boat) -> "Fittings":
        """Return the scales of a boat as floats, because its record is slow to read."""
        c = boat.vessel
        return cls(
            tuple(c.capacity.tolist()),
            tuple(c.bank_volume.tolist()),
            tuple(c.bank_full.tolist()),
            float(c.gas),
            float(c.buoyancy),
            float(c.g),
            (float(c.x_sail), float(c.z_sail)),
            float(c.ell),
            keel_of(c),
        )


@dataclass(frozen=True, eq=False)
class Frame:
    """One tick. ``frame[name]`` is a field of the state [SI], by its name in the core.

    Readers use ``boat`` for its constants alone, because its state may be of a later tick already.
    """

    boat: Boat
    fittings: Fittings
    numbers: list[float]
    readings: InstrumentReadings
    pace: Pace
    summary: Callable[[], Summary]
    kept: dict[str, Any] = field(default_factory=dict)  # results that several fields share

    def __getitem__(self, name: str) -> float:
        return self.numbers[STATE_OFFSETS[name]]

    def at(self, block: str, index: int) -> float:
        """Return the number at an index of a block of the state [SI]."""
        return self.numbers[STATE_OFFSETS[block] + index]

    @cached_property
    def ledger(self) -> Summary:
        """Return the summary of the ticks."""
        return self.summary()

    @cached_property
    def rates(self) -> MotionRates:
        """Return the rates of attitude and location at this tick [SI]."""
        return read_rates(self.__getitem__)

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""
        return int(self["tick"])

    @property
    def seconds(self) -> float:
        """Return the time [s] since the start."""
        return self["tick"] * self.boat.method.step

    def height(self, x: float, z: float) -> float:
        """Return the height [m] over the waves of a point in body axes."""
        pitch, heel = self["theta"], self["phi"]
        lifted = x * math.sin(pitch) - z * math.cos(pitch) * math.cos(heel)
        return lifted - self["z"] - self["eta_wave"]

    @property
    def truth(self) -> InstrumentReadings:
        """Return depth [m], heading [rad], speed [m/s] and sounding [m] as they are."""
        under = self.at("bottom", SOUNDING_COUNT // 2)
        sounding = under - self["z"] if self["bottom"] else 0.0
        return InstrumentReadings(self["z"], self["psi"], self["u"], sounding)


class StateReader:
    """A maker of frames. Each thread has its own, because the records within are reused."""

    def __init__(self, boat: Boat, summary: Callable[[], Summary]) -> None:
        """Look at ``boat``; ``summary`` is that of the session's ledger, asked for when shown."""
        self._boat = boat
        self._fittings = Fittings.of(boat)
        self._summary = summary
        self._state, self._scratch = new_state(), new_scratch()

    def frame(self, picture: Picture) -> Frame:
        """Return the frame of a picture; ValueError unless its state is of this core's layout."""
        if len(picture.state) != STATE_BYTES:
            raise ValueError(
                f"a state of {len(picture.state)} bytes; this core's has {STATE_BYTES}"
            )
        whole = np.frombuffer(picture.state)
        self._state["whole"][0] = whole
        instruments(self._state, self._scratch)
        readings = InstrumentReadings(*self._scratch["reading"][0].tolist())
        numbers = whole.tolist()
        return Frame(self._boat, self._fittings, numbers, readings, picture.pace, self._summary)
