"""Many boats in one exercise, ordered by numbers, each with its marks.

Whoever learns has the mark as its reward: what a flight earns from step to step is what the debrief
would give it. ``trainer.gym`` is Gymnasium's face of it, and ``trainer dev learn`` learns by it.
"""

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trainer.api.boat import plan_boat
from trainer.api.by_number import choose_orders, numbers_of
from trainer.api.fleet import Fleet, Mask
from trainer.boat.due_orders import obey_all, orders_due
from trainer.config.exercise.reference_crew import SAID_ORDERS
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers, kernel
from trainer.core.surfaces import SURFACES
from trainer.debrief.marks.rehearsal import LOOKOUT_GIVER, last_tick
from trainer.debrief.marks.tally_sheet import refuse_words
from trainer.debrief.passage.trajectory import CREW_ORDERS
from trainer.debrief.ticks.judge import TickJudge, nobody_aboard
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import station
from trainer.io.recording.recording import RecordedOrder
from trainer.session.past.plan import Plan

SEED_COUNT: Final = 64  # seas of an exercise, which take turns
STEP_CHOICES_S: Final = (5.0, 2.0, 1.0)  # [s] the first that the schedule allows is a step
MOST_WATER_KG: Final = 10_000.0  # [kg] that one order moves
MOST_SEEN: Final = 10.0  # [-] to which what is seen is held, either way
# [SI] usual sizes, by which what is seen is divided; estimates
USUAL_SIZES: Final = {
    "u": 4.0, "w": 0.3, "q": 0.003, "r": 0.01, "phi": 0.1, "theta": 0.08, "z": 60.0, "zdot": 0.3,
    "delta_r": 0.3, "delta_s": 0.3, "delta_b": 0.3, "u_c": 4.0,
}  # fmt: skip
OFF_SIZES: Final = {"course": 0.3, "depth": 10.0, "speed": 1.0, "pitch": 0.08}
OFF_FIELDS: Final = {"course": "psi", "depth": "z", "speed": "u", "pitch": "theta"}
TIME_SIZE_S: Final = 120.0
# what an axis that is in hand is ordered by
AXIS_CONTROLS: Final[Mapping[str, tuple[str, ...]]] = {
    "rudder": ("rudder",),
    "planes": ("stern", "bow"),
    "speed": ("turns",),
    "ballast": ("flood auxiliary", "pump trim forward"),
}
WATER_CONTROLS: Final = AXIS_CONTROLS["ballast"]
LOOK_OUT_WORDS: Final = ("scope", *SAID_ORDERS)
LOOK_OUT: Final = station(LOOKOUT_GIVER.role, "python")
Sights = NDArray[np.float32]
SIGHT_FIELDS: Final = (
    *USUAL_SIZES,
    *(OFF_FIELDS[axis] for axis in CREW_ORDERS),
    *(value for value, _ in CREW_ORDERS.values()),
    *(stamp for _, stamp in CREW_ORDERS.values()),
    "tick",
)
SIGHT_NAMES: Final = (
    *USUAL_SIZES,
    *(f"{axis} less ordered" for axis in CREW_ORDERS),
    "time since an order",
    "time left",
)


@dataclass(frozen=True)
class Drill:
    """An exercise by numbers: what is ordered, what is read, when it ends."""

    plan: Plan
    controls: tuple[str, ...]
    low: Numbers  # [SI] of the controls, as -1 asks for
    high: Numbers
    toward: Numbers  # [-] signs of what is seen, right and rise positive
    ticks: int  # of a step
    last: int  # [tick]
    due: Mapping[int, Sequence[Order]]  # by tick
    judge_reads: tuple[str, ...]
    times: Numbers  # [ticks] the last one, and of one [-]

    @property
    def reads(self) -> tuple[str, ...]:
        """Return what is read after each tick: for the judge, then what is seen."""
        return (*self.judge_reads, *SIGHT_FIELDS)

    @property
    def steps(self) -> int:
        """Return how many steps the exercise lasts."""
        return self.last // self.ticks

    def values(self, actions: ArrayLike) -> Numbers:
        """Return the orders [SI] of actions from -1 to 1; NaN stays NaN."""
        given = np.minimum(np.maximum(numbers_of(actions, "step()"), -1.0), 1.0)
        values: Numbers = np.maximum(given, 0.0) * self.high - np.minimum(given, 0.0) * self.low
        return values

    def sights(self, rows: Numbers) -> Sights:
        """Return what is seen in rows [n, SIGHT_FIELDS], by usual sizes."""
        seen = np.empty((len(rows), len(SIGHT_NAMES)), np.float32)
        write_sights(rows, self.toward, OFF_DIVISORS, self.times, seen)
        return seen


@kernel
def write_sights(
    rows: Numbers, sizes: Numbers, off_sizes: Numbers, times: Numbers, seen: Sights
) -> None:
    """Write what is seen in rows of SIGHT_FIELDS. ``times`` has the last tick, and a tick."""
    plain, axes = sizes.size, off_sizes.size
    for i in range(rows.shape[0]):
        row, newest, tick = rows[i], 0.0, rows[i, plain + 3 * axes]
        for k in range(plain):
            seen[i, k] = row[k] * sizes[k]
        for k in range(axes):
            aim, stamp = row[plain + axes + k], row[plain + 2 * axes + k]
            off = row[plain + k] - aim if stamp > 0.0 else 0.0
            if k == 0:  # a course, the short way round
                off = (off + math.pi) % math.tau - math.pi
            seen[i, plain + k] = off / off_sizes[k]
            newest = max(newest, stamp)
        seen[i, plain + axes] = (tick - newest) * times[1]
        seen[i, plain + axes + 1] = (times[0] - tick) * times[1]
        for k in range(seen.shape[1]):
            seen[i, k] = min(max(seen[i, k], -MOST_SEEN), MOST_SEEN)


OFF_DIVISORS: Final = np.array([OFF_SIZES[axis] for axis in CREW_ORDERS])


@functools.cache
def planned(exercise: str | Path, seed: int | None = None) -> Plan:
    """Return the plan of an exercise at a seed, None for its own."""
    return plan_boat({"exercise": exercise, "seed": seed}, call="ExerciseFleet")[1]


@functools.cache
def drill_of(exercise: str | Path, step_s: float | None = None) -> Drill:
    """Return an exercise by numbers; ConfigError naming why it cannot be so."""
    plan = planned(exercise)
    judge, boat = TickJudge(plan), plan.launch_boat()
    refuse_words(plan)
    controls = tuple(name for axis in plan.hand for name in AXIS_CONTROLS[axis])
    surfaces = (name for name in controls if name in SURFACES)
    lacking = {name for name in surfaces if not boat.carries(name)}
    controls = tuple(name for name in controls if name not in lacking)
    if not controls:
        raise ConfigError(f"{plan.title}: no control that is in hand takes a number")
    chosen = choose_orders(boat, controls)
    water = np.array([name in WATER_CONTROLS for name in controls])
    low, high = (np.array([getattr(each, end) for each in chosen]) for end in ("low", "high"))
    signs = {f"delta_{letter}": boat.toward[name] for name, letter in SURFACES.items()}
    last, due = last_tick(plan), orders_due(boat, plan.schedule)
    return Drill(
        plan,
        controls,
        np.where(water, -MOST_WATER_KG, low),
        np.where(water, MOST_WATER_KG, high),
        np.array([signs.get(name, 1.0) / size for name, size in USUAL_SIZES.items()]),
        step_ticks(plan, step_s, {*due, last}),
        last,
        due,
        judge.reads,
        np.array([last, plan.method.step / TIME_SIZE_S]),
    )


def step_ticks(plan: Plan, step_s: float | None, moments: set[int]) -> int:
    """Return the ticks of a step, at whose ends all moments [ticks] fall."""
    for seconds in STEP_CHOICES_S if step_s is None else (step_s,):
        ticks = round(seconds / plan.method.step)
        whole = ticks > 0 and abs(ticks * plan.method.step - seconds) < 1e-9
        within = [tick for tick in moments if whole and tick % ticks]
        if whole and not within:
            return ticks
    why = "is no whole number of ticks"
    if whole:
        why = f"has an order, or the end, within it at {min(within) * plan.method.step:g} s"
    raise ConfigError(f"{plan.title}: a step of {seconds:g} s {why}")


def look_out_order(text: str, tick: int) -> RecordedOrder:
    """Return an order to the look-out as it is given; ConfigError for another one."""
    order = parse(text)
    if not isinstance(order, Order) or order.name not in LOOK_OUT_WORDS:
        raise ConfigError(
            f"order(): {text!r}: a look-out takes scope raise, scope lower, mark contact 064 and "
            "report no close contacts"
        )
    return RecordedOrder(0, 1, tick, LOOK_OUT, text, None, None, "")


@dataclass(frozen=True)
class DrillStart:
    """The start of an exercise at a seed, and the marks of nobody aboard there."""

    whole: Numbers  # of the state, the first orders obeyed
    nobody: Mapping[str, float]


def plan_drawn(exercise: str | Path, draw: int) -> Plan:
    """Return an exercise's plan in one of SEED_COUNT seas; a calm is one."""
    plan = planned(exercise)
    return planned(exercise, plan.seed + draw % SEED_COUNT) if plan.sea.sea.sea_state else plan


@functools.cache
def start_of(exercise: str | Path, draw: int) -> DrillStart:
    """Return the start of an exercise in the sea that a draw chooses."""
    plan = plan_drawn(exercise, draw)
    if plan is planned(exercise) and draw:
        return start_of(exercise, 0)
    boat = plan.launch_boat()
    obey_all(boat, orders_due(boat, plan.schedule).get(0, ()))
    return DrillStart(np.array(boat.plain), nobody_aboard(plan))


class ExerciseFleet:
    """Many boats in one exercise, ordered by numbers, each with its marks at every step.

    An action sets the ``controls`` that the exercise puts in hand, from -1 to 1 of their limits;
    right, rise, ahead, in and forward are positive. A step lasts ``step_s``, 5, 2 or 1 s without
    it. What is seen are the ``sights``, by usual sizes, and held to 10 of them.

    TrainerError naming why an exercise cannot be flown so, as one that asks for an answer.
    """

    def __init__(
        self, exercise: str | Path, count: int, *, step_s: float | None = None, threads: int = 1
    ) -> None:
        self.drill = drill = drill_of(exercise, step_s)
        self.exercise, self.count = exercise, count
        self.controls, self.sights, self.steps = drill.controls, SIGHT_NAMES, drill.steps
        names = {"orders": drill.controls, "reads": drill.reads}
        how: dict[str, Any] = {"ticks": drill.ticks, "each_tick": True, "threads": threads}
        self._fleet = Fleet.of_plan(drill.plan, count, **names, **how)
        self._judge = TickJudge(drill.plan, count)
        self._at = np.zeros(count, np.int64)  # [tick]
        self._seen = np.zeros((count, len(SIGHT_NAMES)), np.float32)
        self.marks = np.zeros(count)  # [%] that a record which ends here has
        self.lost = np.zeros(count, bool)
        self.reset()

    def plan_of(self, draw: int) -> Plan:
        """Return the plan in the sea that a draw chooses."""
        return plan_drawn(self.exercise, draw)

    @property
    def begun(self) -> Mask:
        """Return which boats are beyond their start."""
        begun: Mask = self._at > 0
        return begun

    @property
    def over(self) -> Mask:
        """Return which boats are lost, or at the end; they rest until they are reset."""
        over: Mask = self.lost | (self._at >= self.drill.last)
        return over

    def reset(self, which: Mask | None = None, draws: Sequence[int] | None = None) -> Sights:
        """Begin anew with all boats, or those of a mask; return what all see.

        ``draws`` choose the sea of each of them, by their remainders of 64.
        """
        chosen = np.arange(self.count) if which is None else np.flatnonzero(which)
        count, rows = len(self.drill.judge_reads), np.zeros((chosen.size, len(self.drill.reads)))
        for k, index in enumerate(chosen.tolist()):
            draw = index if draws is None else int(draws[k])
            start = start_of(self.exercise, draw % SEED_COUNT)
            self._fleet.put(index, start.whole)
            rows[k] = start.whole[self._fleet.places]
            self.marks[index] = self._judge.begin(index, rows[k, :count], start.nobody)
        self._seen[chosen] = self.drill.sights(rows[:, count:])
        self._at[chosen], self.lost[chosen] = 0, False
        return self._seen.copy()

    def why_lost(self, index: int) -> str:
        """Return how one boat was lost, "" for one that is not."""
        why = "turned over, or by what loses the exercise" if self.lost[index] else ""
        return self._fleet.why_lost(index) or why

    def order(self, index: int, text: str) -> None:
        """Have the look-out of one boat carry out what no number says.

        ``text`` is ``scope raise``, ``scope lower``, ``mark contact 064`` or ``report no close
        contacts``. TrainerError for another order.
        """
        self._judge.hear(index, look_out_order(text, int(self._at[index])))

    def step(self, actions: ArrayLike) -> Sights:
        """Obey an action for each boat, advance, judge; return what is seen [count, sights]."""
        drill, fleet, going = self.drill, self._fleet, ~self.over
        values = drill.values(actions)
        for tick in {*self._at[going].tolist()} & drill.due.keys() - {0}:
            for index in np.flatnonzero(going & (self._at == tick)).tolist():
                fleet.obey(index, drill.due[tick])
        rows = fleet.step(values).reshape(self.count, drill.ticks, -1)
        failed = going & (fleet.status != 0)
        judged, count = going & ~failed, len(drill.judge_reads)
        totals = self._judge.look(rows[..., :count], judged)
        self.marks[judged] = totals[judged]
        self.lost |= failed | (judged & self._judge.ended)
        self._at[going] += drill.ticks
        self._seen[judged] = drill.sights(rows[:, -1, count:])[judged]
        return self._seen.copy()
