"""Time series of a block as charts, and states as words under a time line.

``drawing`` sends them to Rerun's viewer. A lane is a time line of words, such as which laws of the
autopilot are on: a code for each tick, and a word for each code.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.readings import READING_OFFSETS, read_states
from trainer.boat.sea_orders import FREEZABLE_PARTS
from trainer.core.ballast.tanks import BANKS, BLOWN_TANKS, COMPARTMENTS, PUMPED_TANKS, TANKS
from trainer.core.casualties import KINDS
from trainer.core.kernel import Numbers
from trainer.core.state import MAX_CASUALTIES, VALVES
from trainer.core.surfaces import SURFACES
from trainer.session.rerun.batch import Block, IntArray, TickTimings
from trainer.units import DEGREE, KNOT

TONNE_KG: Final = 1000.0  # [kg]
MICROSECOND_NS: Final = 1000.0  # [ns]
PERCENT: Final = 0.01  # [-]
DEPTH_SIGN: Final = -1.0  # [m] a viewer's numbers grow upwards: 60 m of depth is drawn at -60
PATH_UNITS: Final = {"%": "percent"}  # units that are no part of a path as they are
LEDGER_PATH: Final = "charts/ticks_us"  # work and lateness of the ticks, which no state holds
LEDGER_LABELS: Final = ["work", "lateness"]
CASUALTY_SLOTS: Final = tuple(f"casualty[{i}]" for i in range(MAX_CASUALTIES))
CASUALTY_TICKS: Final = tuple(f"casualty_ticks[{i}]" for i in range(MAX_CASUALTIES))
ACTING_TEXT, CLEARED_TEXT = "acting", "being cleared"
BLOW_SUFFIXES: Final = ("", "", " (emergency)")  # by the position: shut, open, emergency
AUTO_COLOUR, HAND_COLOUR, BROKEN_COLOUR, MENDING_COLOUR = (
    0x56B4E9FF,
    0xE69F00FF,
    0xD55E00FF,
    0xCC79A7FF,
)


class Series(NamedTuple):
    """One line of a chart."""

    name: str
    read: Callable[[Block], Numbers]


@dataclass(frozen=True)
class Chart:
    """Lines over the same time, in one unit; NaN leaves a gap."""

    name: str
    unit: str
    series: tuple[Series, ...]
    note: str = ""  # on the title

    @property
    def path(self) -> str:
        """Return its path among the entities, which tells the unit."""
        return f"charts/{self.name}_{PATH_UNITS.get(self.unit, self.unit)}"

    @property
    def title(self) -> str:
        """Return its name with the unit."""
        return f"{self.name}{self.note} [{self.unit}]"

    @property
    def labels(self) -> list[str]:
        """Return the name of each line."""
        return [each.name for each in self.series]

    def columns(self, block: Block) -> Numbers:
        """Return one column for each line."""
        return np.stack([each.read(block) for each in self.series], axis=1)


def ledger_columns(worked: TickTimings) -> Numbers:
    """Return work and lateness [us] of the ticks that were timed."""
    return np.stack((worked.work, worked.lateness), axis=1) / MICROSECOND_NS


def charts_of(boat: Boat) -> tuple[Chart, ...]:
    """Return the charts for which the boat has values."""
    c, read = boat.vessel, BlockReadings(boat)
    capacity = dict(zip(TANKS, c.capacity.tolist(), strict=True))
    full = dict(zip(BANKS, c.bank_full.tolist(), strict=True))
    # an order that nobody keeps would look like an error of the boat
    depth = _field("true", "z", DEPTH_SIGN), read.series("ordered", "ordered_depth", DEPTH_SIGN)
    heading = _field("true", "psi", DEGREE), read.series("ordered", "ordered_course", DEGREE)
    speed = _field("true", "u", KNOT), read.series("ordered", "ordered_speed", KNOT)
    ground = read.series("speed", "way", KNOT), read.series("drift", "drift", KNOT)
    tanks = [read.series(_words(t), f"{t}_full", PERCENT) for t in BLOWN_TANKS if capacity[t]]
    trim = [read.series(_words(t), t, TONNE_KG) for t in PUMPED_TANKS if capacity[t]]
    names = {t: t.removeprefix("compartment_") for t in COMPARTMENTS if capacity[t]}
    flooded = [read.series(name, f"flood_{name}", TONNE_KG) for name in names.values()]
    banks = [read.series(_words(bank), f"{bank}_full", PERCENT) for bank in BANKS if full[bank]]
    surfaces = [
        read.series(label, name, DEGREE)
        for surface in SURFACES
        if boat.toward[surface]
        for label, name in ((surface, surface), (f"{surface} ordered", f"ordered_{surface}"))
    ]
    charts = (
        Chart("depth", "m", depth, ", downwards"),
        Chart("heading", "deg", heading),
        Chart("speed", "kn", (*speed, _field("turns make", "u_c", KNOT))),
        Chart(
            "attitude",
            "deg",
            (_field("pitch", "theta", DEGREE), _field("heel", "phi", DEGREE)),
        ),
        Chart("surfaces", "deg", tuple(surfaces)),
        Chart("ground", "kn", ground),
        Chart("sea", "m", (_field("above the boat", "eta_wave"), _field("height", "sea_height"))),
        Chart("weight", "t", (read.series("heavier than at rest", "heavy", TONNE_KG),)),
        Chart("ballast", "%", tuple(tanks)),
        Chart("trim", "t", tuple(trim)),
        Chart("flooding", "t", tuple(flooded)),
        Chart("air", "%", tuple(banks)),
    )
    return tuple(chart for chart in charts if chart.series)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _field(name: str, field: str, unit: float = 1.0) -> Series:
    """Return the series of a number of the state, in a unit of that size [SI]."""
    return Series(name, lambda block: block[field] / unit)


class BlockReadings:
    """The readings of a boat in a block, kept for the last one."""

    def __init__(self, boat: Boat) -> None:
        """Read off ``boat``, of which only the constants count."""
        self._boat = boat
        self._block: Block | None = None
        self._rows: Numbers = np.empty((0, 0))

    def read(self, block: Block, name: str) -> Numbers:
        """Return a reading [SI] in each state."""
        if block is not self._block:
            self._block, self._rows = block, read_states(self._boat, block.whole)
        return self._rows[:, READING_OFFSETS[name]]

    def series(self, label: str, name: str, unit: float) -> Series:
        """Return the series of a reading, in a unit of that size [SI]."""
        return Series(label, lambda block: self.read(block, name) / unit)


@dataclass(frozen=True)
class Lane:
    """A time line of words: a code for each tick, a word for each code.

    The word "" leaves the lane empty.
    """

    path: str
    codes: Callable[[Block], IntArray]
    word: Callable[[int], str]
    colours: Mapping[str, int] = field(default_factory=dict)  # of words that have their own


def lanes_of(boat: Boat) -> tuple[Lane, ...]:
    """Return the lanes of the boat, but those of casualties: ``casualty_lanes`` has them."""
    lanes = [
        Lane(
            "lanes/run",
            lambda block: 2 * block.branch + block.replaying,
            lambda code: f"{'replay of ' if code % 2 else ''}branch {code // 2}",
        ),
        *(_by_hand(name) for name in (*SURFACES, "speed") if boat.toward.get(name, 1.0)),
        _several("held", tuple(f"held_{part}" for part in FREEZABLE_PARTS), FREEZABLE_PARTS),
    ]
    if boat.vessel.fitted:
        lanes += [
            Lane("lanes/hover", lambda block: _whole(block["hover"]), ("", "on").__getitem__),
            Lane("lanes/blow", _blow, _describe_blow),
            _several("vents", tuple(f"vent_{name}" for name in VALVES), VALVES),
        ]
    return tuple(lanes)


def casualty_lanes(block: Block) -> list[Lane]:
    """Return a lane for each kind of casualty that occurs in the block."""
    kinds = np.unique(block.several(*CASUALTY_SLOTS)).astype(int)
    return [_casualty(kind) for kind in kinds.tolist() if kind]


def _casualty(kind: int) -> Lane:
    """Return the lane of a kind of casualty."""

    def codes(block: Block) -> IntArray:
        here = block.several(*CASUALTY_SLOTS) == kind
        clearing = here & (block.several(*CASUALTY_TICKS) < 0.0)
        acting = np.any(here & ~clearing, axis=1)
        return np.where(acting, 2, np.where(np.any(clearing, axis=1), 1, 0))

    word = ("", CLEARED_TEXT, ACTING_TEXT).__getitem__
    return Lane(
        f"lanes/{KINDS[kind - 1]}",
        codes,
        word,
        {CLEARED_TEXT: MENDING_COLOUR, ACTING_TEXT: BROKEN_COLOUR},
    )


def _whole(column: np.ndarray) -> IntArray:
    return column.astype(np.int64)


def _by_hand(what: str) -> Lane:
    """Return the lane that says whether a control is worked by hand."""
    word, colours = ("auto", "hand").__getitem__, {"auto": AUTO_COLOUR, "hand": HAND_COLOUR}
    return Lane(f"lanes/{what}", lambda b: _whole(b[f"{what}_by_hand"]), word, colours)


def _several(name: str, fields: tuple[str, ...], names: tuple[str, ...]) -> Lane:
    """Return the lane that lists which of several states hold, each a bit of the code."""
    bits = 2 ** np.arange(len(fields))

    def word(code: int) -> str:
        return ", ".join(name for i, name in enumerate(names) if code & 1 << i)

    return Lane(f"lanes/{name}", lambda b: _whole((b.several(*fields) > 0.0) @ bits), word)


def _blow(block: Block) -> IntArray:
    positions = block.several(*(f"blow_{name}" for name in VALVES))
    return _whole(positions @ 3.0 ** np.arange(len(VALVES)))


def _describe_blow(code: int) -> str:
    """Return which blow valves are open; each is a digit of the code to the base of three."""
    positions = [(name, code // 3**i % 3) for i, name in enumerate(VALVES)]
    return ", ".join(name + BLOW_SUFFIXES[position] for name, position in positions if position)
