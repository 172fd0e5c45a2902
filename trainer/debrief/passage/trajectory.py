"""A passage: what was flown to the end of a branch, as arrays by tick.

``read_passage`` reads it once from a recording, with the past from which the branch began.
Measures, marks and charts then work on whole columns, because a loop over the ticks of hours would
take minutes. Columns have the names that fields of the state have in the core, in SI units.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.boat.casualties import scale_of
from trainer.boat.crew_orders import CREW_AXES
from trainer.boat.grounding import STATE_NAMES
from trainer.boat.readings import MOTION_NAMES, WATER_NAMES, read_rates
from trainer.boat.world.bottom import ground_under, heights_of_keel, keel_of
from trainer.boat.world.scope import Mast, periscope_of
from trainer.config.exercise.condition import ANGLE_UNITS, PLANT_QUANTITIES, STATE_QUANTITIES
from trainer.config.exercise.derived import DERIVED_QUANTITIES, Condition
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.exercise.score_rules import (
    COURSE_QUANTITY,
    ORDERED_QUANTITIES,
    MeasuredQuantity,
    ScoreRule,
)
from trainer.config.files import ConfigError
from trainer.core.bottom import SOUNDING_STATIONS as STATIONS
from trainer.core.kernel import Numbers
from trainer.core.sea.free_surface import DECK_REACH
from trainer.core.state import MAX_CASUALTIES
from trainer.io.recording.recording import RecordedEvent, RecordedOrder, RecordedTick, Recording
from trainer.session.past.layout import numbers_of
from trainer.session.stations.alerts import Alert

RowMask = NDArray[np.bool_]  # which ticks of a passage

BATCH_TICKS: Final = 2000  # [ticks] read at once
BLOCK_ROWS: Final = 16_000  # [rows] after which fields that stand still are let go
NEVER_S: Final = 1e18  # [s]
CASUALTY_SLOTS: Final = tuple(f"casualty[{i}]" for i in range(MAX_CASUALTIES))
CASUALTY_AMOUNTS: Final = tuple(f"casualty_amount[{i}]" for i in range(MAX_CASUALTIES))
# fields of the state beside those that conditions are about
# fmt: off
PASSAGE_FIELDS: Final = (
    *MOTION_NAMES, "x", "y", "held_position",
    "weight", "ordered_depth", "ordered_psi", "ordered_speed",
    "ordered_r", "ordered_s", "ordered_b", "command_r", "command_s", "command_b",
    "rudder_by_hand", "stern_by_hand", "bow_by_hand", "speed_by_hand", "hover",
    "blow_forward", "blow_mid", "blow_aft", "sea_height", "held_depth",
    *CASUALTY_SLOTS,
    *CASUALTY_AMOUNTS,
)
# fmt: on
# what is ordered to the crew, and the tick after which it was; older recordings have none
CREW_ORDERS: Final = {
    axis: (f"crew_{axis}", f"crew_order_tick[{i}]") for i, axis in enumerate(CREW_AXES)
}
NEWER_COLUMNS: Final = (
    *(name for both in CREW_ORDERS.values() for name in both),
    *STATE_NAMES,
    *WATER_NAMES,
    *(quantity.field for quantity in PLANT_QUANTITIES.values()),
    "battery_spent",
)
NEEDED_COLUMNS: Final = tuple(
    dict.fromkeys(
        (
            *(
                quantity.field
                for name, quantity in STATE_QUANTITIES.items()
                if quantity.field != "tick" and name not in PLANT_QUANTITIES
            ),
            *PASSAGE_FIELDS,
        )
    )
)
PASSAGE_COLUMNS: Final = tuple(dict.fromkeys((*NEEDED_COLUMNS, *NEWER_COLUMNS)))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The passage that was flown. Every array has one number for each tick, the start first."""

    boat: Boat  # for what it is; nothing of it that moves is looked at
    limits: ExerciseLimits
    orders: tuple[RecordedOrder, ...]
    ticks: NDArray[np.int64]
    columns: Mapping[str, Numbers]  # fields of the state [SI] by their names in the core
    lateness: Numbers  # [ns], NaN where nobody measured it
    work: Numbers  # [ns]
    marks: tuple[RecordedEvent, ...] = ()  # moments that somebody has marked
    alerts: tuple[Alert, ...] = ()  # of a session's run, as they became

    @property
    def seconds(self) -> Numbers:
        """Return the time [s] since the start."""
        return self.ticks.astype(np.float64) * self.boat.method.step

    def has(self, quantity: str) -> bool:
        """Return whether the boat has the part that the quantity belongs to."""
        return has_quantity(self.boat, quantity)

    def series(self, quantity: str) -> Numbers:
        """Return a quantity that the boat has [SI]; a course is not wrapped."""
        if quantity in DERIVED_QUANTITIES:
            return QUANTITY_FUNCTIONS[quantity](self)
        field = STATE_QUANTITIES[quantity].field
        column = self.ticks.astype(np.float64) if field == "tick" else self.columns[field]
        return column / scale_of(self.boat, quantity)

    def measured(self, what: MeasuredQuantity) -> Numbers:
        """Return a quantity in its unit."""
        return self.series(what.name) / what.size

    def off(self, what: MeasuredQuantity, target: float | None) -> Numbers:
        """Return how far a quantity is above its target, both in its unit.

        With None the target is the order at each tick. A course goes the short way round.
        """
        aim = self.columns[ORDERED_QUANTITIES[what.name]] / what.size if target is None else target
        off = self.measured(what) - aim
        if what.name != COURSE_QUANTITY:
            return off
        round_about = 360.0 * ANGLE_UNITS["deg"] / what.size
        return (off + 0.5 * round_about) % round_about - 0.5 * round_about

    def ordered(self, axis: str) -> Numbers:
        """Return the order to the crew on an axis [SI] at each tick, NaN without."""
        value, stamp = (self.columns[field] for field in CREW_ORDERS[axis])
        return np.where(stamp != 0.0, value, np.nan)

    def holds(self, condition: Condition) -> RowMask:
        """Return at which ticks a condition holds."""
        value = self.series(condition.quantity)
        if condition.quantity == COURSE_QUANTITY:
            value = value % math.tau
        above = condition.sense * (value - condition.threshold)
        return above > 0.0 if condition.strict else above >= 0.0

    def between(self, begin: float | None, end: float | None) -> RowMask:
        """Return the ticks from ``begin`` to ``end`` [s], both included; None: all."""
        slack = 1e-6 * self.boat.method.step
        after = self.seconds >= (begin or 0.0) - slack
        return after & (self.seconds <= (NEVER_S if end is None else end) + slack)

    def row(self, tick: int) -> int:
        """Return the row of a tick, or of the first one after it."""
        return min(int(np.searchsorted(self.ticks, tick)), self.ticks.size - 1)

    @property
    def holes(self) -> tuple[tuple[float, float], ...]:
        """Return the times [s] of ticks between which none was recorded."""
        seconds = self.seconds
        last = np.flatnonzero(np.diff(self.ticks) > 1)
        return tuple(zip(seconds[last].tolist(), seconds[last + 1].tolist(), strict=True))


def hole_words(holes: Sequence[tuple[float, float]]) -> str:
    """Return between which times [s] no tick was recorded, in words."""
    stretches = (f"between {last:g} s and {next_:g} s" for last, next_ in holes)
    return f"no tick was recorded {', '.join(stretches)}"


def row_stretches(rows: RowMask) -> Iterator[tuple[int, int]]:
    """Yield each stretch of rows: its first one, and the one after it."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], rows, [False])).astype(int)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def heaviness(trajectory: Trajectory) -> Numbers:
    """Return weight less buoyancy [kg], as if the boat were all under water."""
    c = trajectory.boat.vessel
    depth, layers = trajectory.columns["z"], int(c.layers)
    change = -c.g * c.compressibility * (np.maximum(depth, 0.0) - c.reference_depth)
    if layers:
        denser = np.interp(depth, c.layer_depth[:layers], c.layer_density[:layers])
        change = change + c.buoyancy * denser / c.rho
    heavy: Numbers = (trajectory.columns["weight"] - c.buoyancy - change) / c.g
    return heavy


def shown_height(trajectory: Trajectory) -> Numbers:
    """Return the height [m] of the highest part of sail and deck above the sea."""
    vessel, column = trajectory.boat.vessel, trajectory.columns
    sine, cosine = np.sin(column["theta"]), np.cos(column["theta"])
    upright = cosine * np.cos(column["phi"])
    reach = DECK_REACH * float(vessel.ell)
    points = (
        (float(vessel.x_sail), float(vessel.z_sail)),
        (reach, float(vessel.z_deck)),
        (-reach, float(vessel.z_deck)),
    )
    lifted: Numbers = np.max([x * sine - z * upright for x, z in points], axis=0)
    return lifted - column["z"] - column["eta_wave"]


def eye_heights(trajectory: Trajectory, *, up: bool = False) -> Numbers:
    """Return the height [m] of the periscope's head over the waves. ``up``: as if all out.

    It is NaN for a boat without one.
    """
    scope, column = periscope_of(trajectory.boat), trajectory.columns
    if scope is None:
        return np.full(trajectory.ticks.size, np.nan)
    out = scope.raised(Mast()).out if up else scope.over(trajectory.ticks)[0]
    return scope.heights_over(column.__getitem__, out)


def keel_clearance(trajectory: Trajectory) -> Numbers:
    """Return the least height [m] of the keel over the ground."""
    vessel, column = trajectory.boat.vessel, trajectory.columns.__getitem__
    grounds = [column(f"bottom[0,{i}]") for i in range(len(STATIONS))]
    return heights_of_keel(grounds, column, float(vessel.ell), keel_of(vessel))


def over_ground(trajectory: Trajectory) -> Numbers:
    """Return the speed [m/s] over the ground, 0 while the position is held."""
    speed: Numbers = read_rates(trajectory.columns.__getitem__).way
    return speed


QUANTITY_FUNCTIONS: Final[Mapping[str, Callable[[Trajectory], Numbers]]] = {
    COURSE_QUANTITY: lambda trajectory: trajectory.columns["psi"],  # not wrapped
    "heavy": heaviness,
    "eye": eye_heights,
    "showing": shown_height,
    "clearance": keel_clearance,
    "speed_over_ground": over_ground,
}


def has_quantity(boat: Boat, quantity: str) -> bool:
    """Return whether a boat has the part that a quantity belongs to."""
    if quantity == "eye":
        return boat.file.scope is not None
    if quantity == "clearance":
        return ground_under(boat) is not None
    return quantity in DERIVED_QUANTITIES or scale_of(boat, quantity) != 0.0


def missing_quantities(boat: Boat, rule: ScoreRule) -> list[str]:
    """Return which quantities of a rule a boat does not have."""
    names = [rule.measured.name] if rule.measured else []
    names += [condition.quantity for condition in rule.conditions]
    return [name for name in names if not has_quantity(boat, name)]


class FlownRows:
    """Rows of fields of the state, tick by tick, which end as columns.

    A field that stands still takes no memory: two thirds of a usual run's, whose day would else
    take 126 MB. So columns are read only.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = names
        self._rows: list[Numbers] = []  # of the block that grows
        self._count = 0
        self._blocks: list[list[Numbers]] = []  # the columns of each

    def append(self, rows: Numbers) -> None:
        """Take rows, a number for each name and perhaps more behind them."""
        self._rows.append(rows[:, : len(self.names)])
        self._count += len(rows)
        if self._count >= BLOCK_ROWS:
            self._close_block()

    @property
    def last(self) -> Numbers:
        """Return the latest row, of one at least."""
        return (
            self._rows[-1][-1] if self._rows else np.array([each[-1] for each in self._blocks[-1]])
        )

    def columns(self) -> dict[str, Numbers]:
        """Return the columns so far, by name."""
        self._close_block()
        parts = zip(*self._blocks, strict=True)
        return {name: _join(part) for name, part in zip(self.names, parts, strict=True)}

    def _close_block(self) -> None:
        if self._rows:
            rows = np.concatenate(self._rows)
            still = (rows.view(np.int64) == rows[:1].view(np.int64)).all(axis=0).tolist()
            columns = zip(rows.T, still, strict=True)
            self._blocks.append(
                [_standing(each) if same else each.copy() for each, same in columns]
            )
        self._rows, self._count = [], 0


def _standing(column: Numbers) -> Numbers:
    """Return a column of one value, as one number."""
    return np.broadcast_to(column[:1].copy(), column.shape)


def _join(parts: Sequence[Numbers]) -> Numbers:
    """Return the column that blocks have parts of."""
    if len(parts) == 1:
        return parts[0]
    firsts = {part[:1].tobytes() for part in parts}
    if len(firsts) == 1 and not any(map(any, (part.strides for part in parts))):
        return np.broadcast_to(parts[0][:1], (sum(map(len, parts)),))
    return np.concatenate(parts)


def read_passage(
    recording: Recording, branch: int, layout: Sequence[str], boat: Boat, limits: ExerciseLimits
) -> Trajectory:
    """Return the passage to the end of a branch, its states read by ``layout``.

    ConfigError if that lacks a field that is needed.
    """
    lacking = [name for name in NEEDED_COLUMNS if name not in layout]
    if lacking:
        raise ConfigError(
            f"the recording is of another version of the trainer: no {lacking[0]} in its states; "
            "debrief it with that version"
        )
    present = [name for name in PASSAGE_COLUMNS if name in layout]
    indices = [layout.index(name) for name in present]
    rows, times = FlownRows(present), [np.empty((0, 3))]
    rows.append(np.empty((0, len(present))))
    flown = recording.flown(branch)
    while batch := list(islice(flown, BATCH_TICKS)):
        rows.append(np.array([numbers_of(each.state, layout)[indices] for each in batch]))
        times.append(np.array([_times(each) for each in batch]))
    timings = np.concatenate(times).T
    none = dict.fromkeys(NEWER_COLUMNS, np.zeros(timings.shape[1]))
    return Trajectory(
        boat=boat,
        limits=limits,
        orders=tuple(recording.orders(branch)),
        ticks=timings[0].astype(np.int64),
        columns={**none, **rows.columns()},
        lateness=timings[1],
        work=timings[2],
    )


def _times(flown: RecordedTick) -> tuple[float, float, float]:
    """Return tick, lateness and work [ns] of a tick."""
    if flown.lateness is None or flown.work is None:
        return flown.tick, np.nan, np.nan
    return flown.tick, flown.lateness, flown.work
