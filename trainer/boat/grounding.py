"""The ground as the boat notices it: clearance, how it was touched, and the calls.

``session/exercise/damage_watch`` and ``limits`` call them after a tick, and debriefs ask them of a
recording. The core computes the forces of the ground. These functions say in words what has
happened.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.flown_ticks import FlownTicks, count_before
from trainer.boat.readings import read_rates
from trainer.boat.world.bottom import ground_under, height_of_keel, keel_of
from trainer.config.world.bottom import Bottom, charted_at, is_charted
from trainer.core.bottom import SOUNDING_STATIONS
from trainer.core.state import SOUNDING_COUNT
from trainer.units import KNOT

BOTTOM_NAMES: Final = tuple(f"bottom[{row},{i}]" for row in range(3) for i in range(SOUNDING_COUNT))
BEYOND_KEY: Final = "beyond the chart"  # of an alert
# beside those of conditions and motion
STATE_NAMES: Final = (*BOTTOM_NAMES, "bottom_load", "aground")
# As docs/world.md has it (Aground). The speeds, the pitch and the loads are estimates.
AGROUND_TICKS: Final = 2.0  # [-] ticks in a row in which the ground carries the boat
RECALL_AFLOAT_S: Final = 30.0  # [s] off the ground, after which touching it is news again
HARD_SINK_SPEED: Final = 0.5  # [m/s] into the ground, from which grounding is hard
HARD_WAY: Final = 2.0 * KNOT  # [m/s] over rock
GENTLE_WAY, GENTLE_SINK, GENTLE_PITCH = 0.5, 0.15, math.radians(2.0)  # of a boat laid down on it
SETTLING_TIME_S: Final = 300.0  # [s] within which it then lies there
MIN_GROUND_LOAD_T, MAX_GROUND_LOAD_T = 5.0, 30.0  # [t] that the ground then carries
STOPPED_SCREW_SPEED: Final = 0.1  # [m/s] command speed of a screw that stands

# a number of one moment's state [SI], by its name in the layout
StateReader = Callable[[str], float]
_OFFSETS: Final = {
    **STATE_OFFSETS,
    **{name: STATE_OFFSETS["bottom"] + i for i, name in enumerate(BOTTOM_NAMES)},
}


class GroundTouch(NamedTuple):
    """How a boat came to the ground."""

    normal: float  # [m/s] into it
    way: float  # [m/s] over it
    sink: float  # [m/s] down
    pitch: float  # [rad]

    def is_hard(self, kind: str) -> bool:
        """Return whether the hull suffered on ground of that kind."""
        return self.normal > HARD_SINK_SPEED or (kind == "rock" and self.way > HARD_WAY)

    @property
    def faults(self) -> list[str]:
        """Return what was wrong with the touch, for a boat to be laid down."""
        fault_words = {
            f"way {self.way:.2f} m/s, {GENTLE_WAY:g} at most": self.way >= GENTLE_WAY,
            f"sinking {self.sink:.2f} m/s, {GENTLE_SINK:g} at most": self.sink >= GENTLE_SINK,
            f"pitch {math.degrees(self.pitch):.1f} deg, 2 at most": abs(self.pitch) >= GENTLE_PITCH,
        }
        return [words for words, is_fault in fault_words.items() if is_fault]


def clearance(boat: Boat) -> float:
    """Return the least height [m] of the keel over the ground; infinite without a ground."""
    return height_of_keel(boat.plain, float(boat.vessel.ell), keel_of(boat.vessel))


def touch_of(read: StateReader, length: float) -> GroundTouch:
    """Return how a boat of that ``length`` [m] moves, a moment before it touches."""
    pitch, rates = read("theta"), read_rates(read)
    closing = 0.0
    for i, x in enumerate(SOUNDING_STATIONS):
        down = rates.down - x * length * math.cos(pitch) * read("q")
        slopes = read(f"bottom[1,{i}]"), read(f"bottom[2,{i}]")
        into = down - slopes[0] * rates.north - slopes[1] * rates.east
        closing = max(closing, into / math.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2))
    return GroundTouch(float(closing), float(rates.way), float(rates.down), pitch)


def lies_well(load_t: float, u_c: float) -> bool:
    """Return whether a boat lies on the ground well, by load and command speed [m/s]."""
    return MIN_GROUND_LOAD_T <= load_t <= MAX_GROUND_LOAD_T and abs(u_c) < STOPPED_SCREW_SPEED


class GroundCall(NamedTuple):
    """One call about the ground."""

    text: str
    aground: bool = False  # it was not meant, or not done well
    how: str = ""  # what the exercise then does: a word of GROUNDINGS
    key: str = "aground"  # of its alert


@dataclass
class GroundMonitor:
    """The watch for the ground: off the chart, aground, laid down on it."""

    boat: Boat
    touch: GroundTouch | None = None  # of the last moment off the ground
    off_since: float | None = None  # [s] when it came off, after a call that it is aground
    down_since: float | None = None  # [s] when it was called aground
    laid: bool = False  # it was called whether it lies well
    beyond: bool = False  # the chart
    bottom: Bottom | None = field(init=False)  # the ground there is

    def __post_init__(self) -> None:
        self.bottom = ground_under(self.boat)
        self.reset()

    def reset(self) -> None:
        """Take the boat as it is. Nothing of it is news."""
        bottom, plain = self.bottom, self.boat.plain
        down = plain[STATE_OFFSETS["aground"]] >= AGROUND_TICKS
        self.down_since = self.boat.time if down else None
        self.laid, self.touch, self.off_since = down, None, None
        self.beyond = bottom is not None and not self._charted(bottom)

    def look(self) -> Sequence[GroundCall]:
        """Return what there is to call out after a tick."""
        bottom = self.bottom
        if bottom is None:
            return ()
        calls = [*self._edge(bottom)]
        ticks = self.boat.plain[STATE_OFFSETS["aground"]]
        if ticks == 0.0:
            self._afloat()
        elif ticks >= AGROUND_TICKS:
            calls += self._lying() if self.down_since is not None else self._aground(bottom)
        return [call._replace(how=bottom.grounding) for call in calls]

    @property
    def holding(self) -> set[str]:
        """Return the keys of the alerts called that hold still."""
        beyond = {BEYOND_KEY} if self.beyond else set()
        return beyond if self.down_since is None else beyond | {"aground"}

    def quiet_ticks(self, _boat: Boat, flown: FlownTicks) -> int:
        """Return after how many ticks there may be something to call, or all of them."""
        bottom = self.bottom
        if bottom is None:
            return len(flown)
        if self.down_since is not None:
            return 0
        beyond = ~charted_at(bottom, flown["x"], flown["y"])
        return count_before((beyond != self.beyond) | (flown["aground"] >= AGROUND_TICKS))

    def pass_over(self, boat: Boat, flown: FlownTicks) -> None:
        """Take these ticks as seen, in which there was nothing to call."""
        off = np.flatnonzero(flown["aground"] == 0.0)
        if self.bottom is not None and off.size:
            last = flown.rows[off[-1]].tolist()
            self.touch = touch_of(lambda name: last[_OFFSETS[name]], float(boat.vessel.ell))

    def _charted(self, bottom: Bottom) -> bool:
        plain = self.boat.plain
        return is_charted(bottom, plain[STATE_OFFSETS["x"]], plain[STATE_OFFSETS["y"]])

    def _edge(self, bottom: Bottom) -> list[GroundCall]:
        was, self.beyond = self.beyond, not self._charted(bottom)
        if self.beyond and not was:
            return [
                GroundCall("BEYOND THE CHART: the ground is taken as at its edge", key=BEYOND_KEY)
            ]
        return []

    def _afloat(self) -> None:
        """Remember the motion; after RECALL_AFLOAT_S the next touch is news again."""
        boat = self.boat
        plain = boat.plain
        # in the first tick that carries load the ground has slowed the boat already
        self.touch = touch_of(lambda name: plain[_OFFSETS[name]], float(boat.vessel.ell))
        if self.down_since is None:
            return
        self.off_since = boat.time if self.off_since is None else self.off_since
        if boat.time - self.off_since > RECALL_AFLOAT_S:
            self.down_since = self.off_since = None

    def _aground(self, bottom: Bottom) -> list[GroundCall]:
        boat, touch = self.boat, self.touch or GroundTouch(0.0, 0.0, 0.0, 0.0)
        self.down_since, self.laid = boat.time, not bottom.bottoming
        load = self._load()
        how = f"{touch.normal:.2f} m/s into {bottom.kind}, way {touch.way / KNOT:.1f} kn, "
        how += f"load {load:.0f} t"
        if touch.is_hard(bottom.kind):
            return [GroundCall(f"HARD AGROUND: {how}", aground=True)]
        if not bottom.bottoming:
            return [GroundCall(f"AGROUND: {how}", aground=True)]
        faults = ", ".join(touch.faults)
        self.laid = bool(faults)
        return [GroundCall(f"on the ground: {how}: {faults or 'well done'}", aground=bool(faults))]

    def _lying(self) -> list[GroundCall]:
        """Return whether a boat that was laid down lies as it should, once that can be said."""
        self.off_since = None  # only time off the ground without a touch counts
        if self.laid or self.down_since is None:
            return []
        load, u_c = self._load(), self.boat.plain[STATE_OFFSETS["u_c"]]
        screw = "stopped" if abs(u_c) < STOPPED_SCREW_SPEED else "turns"
        load_text = f"{load:.0f} t on the ground, screw {screw}"
        if lies_well(load, u_c):
            self.laid = True
            return [GroundCall(f"lies on the ground: {load_text}")]
        if self.boat.time - self.down_since > SETTLING_TIME_S:
            self.laid = True
            return [
                GroundCall(f"does not lie on the ground within 5 min: {load_text}", aground=True)
            ]
        return []

    def _load(self) -> float:
        """Return what the ground carries [t]."""
        return self.boat.plain[STATE_OFFSETS["bottom_load"]] / float(self.boat.vessel.g) / 1000.0
