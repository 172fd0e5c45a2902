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
from trainer.boat.readings import READING_OFFSETS
from trainer.boat.safe_depth import FlightAhead
from trainer.core.readings import new_readings, write_readings
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
    hands: str = ""  # the axes, and which role has worked each last


class Picture(NamedTuple):
    """A tick's output: the whole state as bytes, and how time runs."""

    tick: int
    state: bytes
    pace: Pace


@dataclass(frozen=True, eq=False)
class Frame:
    """One tick. ``frame[name]`` is a field of the state [SI], by its name in the core.

    Readers use ``boat`` for its constants alone, because its state may be of a later tick already.
    """

    boat: Boat
    numbers: list[float]
    shown: list[float]  # the readings [SI], by READING_OFFSETS
    pace: Pace
    summary: Callable[[], Summary]
    fit_ahead: Callable[[], FlightAhead]  # a boat of the reader's own, fitted out once
    kept: dict[str, Any] = field(default_factory=dict)  # results that several fields share

    def __getitem__(self, name: str) -> float:
        return self.numbers[STATE_OFFSETS[name]]

    def read(self, name: str) -> float | None:
        """Return a reading [SI] by its name in the core, None for nothing to read."""
        value = self.shown[READING_OFFSETS[name]]
        return None if math.isnan(value) else value

    def at(self, block: str, index: int) -> float:
        """Return the number at an index of a block of the state [SI]."""
        return self.numbers[STATE_OFFSETS[block] + index]

    @cached_property
    def ledger(self) -> Summary:
        """Return the summary of the ticks."""
        return self.summary()

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""
        return int(self["tick"])

    @property
    def seconds(self) -> float:
        """Return the time [s] since the start."""
        return self["tick"] * self.boat.method.step

    @property
    def readings(self) -> InstrumentReadings:
        """Return what depth gauge [m], gyro [rad], log [m/s] and sounder [m] read."""
        depth, heading, speed, sounding = self.shown[:4]
        return InstrumentReadings(depth, heading, speed, 0.0 if math.isnan(sounding) else sounding)

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
        self.boat = boat
        self._summary = summary
        self._state, self._scratch = new_state(), new_scratch()
        self._readings = new_readings()

    def frame(self, picture: Picture) -> Frame:
        """Return the frame of a picture; ValueError unless its state is of this core's layout."""
        if len(picture.state) != STATE_BYTES:
            raise ValueError(
                f"a state of {len(picture.state)} bytes; this core's has {STATE_BYTES}"
            )
        whole = np.frombuffer(picture.state)
        self._state["whole"][0] = whole
        records = self._state, self._scratch, self._readings
        write_readings(self.boat.records.vessel, *records)
        shown = self._readings["whole"][0].tolist()
        numbers = whole.tolist()
        return Frame(self.boat, numbers, shown, picture.pace, self._summary, lambda: self._ahead)

    @cached_property
    def _ahead(self) -> FlightAhead:
        return FlightAhead(self.boat)
