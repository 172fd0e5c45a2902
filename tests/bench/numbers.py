"""The cost of a step by numbers, beside words, and of marks at each tick.

``python -m tests.bench --numbers`` measures it, in one run, in a calm and in a sea.
"""

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from typing import Final

import numpy as np
from helpers.loops import in_a_loop

import trainer
from bench.batches import BatchCost, Voyage, time_batches
from trainer.analysis.bench.ticks import STANDARD_METHOD, ready_boat, trouble_of
from trainer.boat.helm import obey_order
from trainer.config.boat.vessel import VesselFile
from trainer.config.world.sea import load_sea
from trainer.debrief.ticks.judge import TickJudge
from trainer.io.orders.grammar import Order, parse

ORDER_WORDS: Final = ("stern planes rise 1", "rudder right 1", "depth 60")
READ_NAMES: Final = ("z", "theta", "w", "q", "u", "psi")
SEA_NAMES: Final = ("calm", "sea-state-5")
EXERCISE_NAME: Final = "emergency-deep"  # in sea state 3
FLEET_BOATS: Final = 256
FLEET_TICKS: Final = (1, 10)  # of a step by threads
EVERY_S: Final = 5.0  # [s]


@dataclass(frozen=True)
class StepCost:
    """The cost of a step in a sea: three orders, a tick, and numbers read."""

    sea: str
    tick: BatchCost  # in a compiled loop
    step: BatchCost
    words: BatchCost  # the same by ``order``, ``run`` and ``state``
    over_the_tick_ns: float
    words_over_step: float


@dataclass(frozen=True)
class LearningCost:
    """The cost of what a program learns by, in a shipped exercise."""

    exercise: str
    judge: BatchCost  # of a tick of one boat of a fleet
    fleet: BatchCost  # of a boat's step of EVERY_S, judged and seen
    env: BatchCost | None  # of Gymnasium's step of one tick, None where it is not installed


@dataclass(frozen=True)
class FleetCost:
    """The cost of a boat's step in a fleet, by one thread and by two."""

    sea: str
    ticks: int  # of a step
    one: BatchCost
    two: BatchCost

    @property
    def gain(self) -> float:
        """Return how many times as fast two threads are."""
        return self.one.least_ns / self.two.least_ns


@dataclass(frozen=True)
class NumbersCost:
    """The costs of a step in each sea, in an exercise and by threads."""

    seas: Sequence[StepCost]
    learning: LearningCost
    fleets: Sequence[FleetCost]


def time_numbers(file: VesselFile) -> NumbersCost:
    """Return what steps by numbers and by words cost."""
    fleets = [_time_threads(file, ticks) for ticks in FLEET_TICKS]
    return NumbersCost([_time_in(file, sea) for sea in SEA_NAMES], _time_learning(), fleets)


def _time_threads(file: VesselFile, ticks: int) -> FleetCost:
    """Return what a step of so many ticks costs in a fleet, by one thread and by two."""
    sea = SEA_NAMES[-1]
    fleets = [
        trainer.Fleet(
            file.path, FLEET_BOATS, orders=["stern"], reads=READ_NAMES, sea=sea, depth=100.0,
            ticks=ticks, threads=threads, battery="endless",
        )
        for threads in (1, 2)
    ]  # fmt: skip
    level = np.zeros((FLEET_BOATS, 1))

    def step(fleet: trainer.Fleet, count: int) -> None:
        for _ in range(count):
            fleet.step(level)

    def trouble(fleet: trainer.Fleet, count: int) -> str:
        frozen = "frozen" if fleet.column("tick").min() < count * ticks else ""
        return fleet.why_lost(int(fleet.column("z").argmax())) or frozen

    name, runs = file.path.name, [(each, partial(step, each)) for each in fleets]
    costs = time_batches(
        [Voyage(name, run, each.reset, partial(trouble, each)) for each, run in runs]
    )
    return FleetCost(sea, ticks, *(_each(cost, FLEET_BOATS) for cost in costs))


def _time_learning() -> LearningCost:
    """Return what steps in an exercise cost, with its marks."""
    fleet = trainer.ExerciseFleet(EXERCISE_NAME, FLEET_BOATS, step_s=EVERY_S)
    judge, drill = TickJudge(fleet.drill.plan, FLEET_BOATS), fleet.drill
    rows = np.zeros((FLEET_BOATS, drill.ticks, len(judge.reads)))
    actions = np.zeros((FLEET_BOATS, len(fleet.controls)))

    def look(count: int) -> None:
        for _ in range(count):
            rows[:, :, 0] += drill.ticks
            judge.look(rows)

    def fly(count: int) -> None:
        for _ in range(count):
            fleet.step(actions)
            if fleet.over.any():  # one that is lost rests, and costs nothing
                fleet.reset()

    works: list[Callable[[int], object]] = [look, fly]
    if find_spec("gymnasium") is not None:
        works.append(_gymnasium_s_steps(drill.plan.method.step))
    looked, flown, *stepped = time_batches(works)
    one_tick, one_boat = FLEET_BOATS * drill.ticks, FLEET_BOATS
    return LearningCost(
        EXERCISE_NAME,
        _each(looked, one_tick),
        _each(flown, one_boat),
        stepped[0] if stepped else None,
    )


def _gymnasium_s_steps(step_s: float) -> Callable[[int], None]:
    """Return what takes steps of a tick in Gymnasium's environment, as ``make`` gives it."""
    import gymnasium  # noqa: PLC0415  it may be lacking

    env = gymnasium.make(f"trainer.gym:trainer/{EXERCISE_NAME}-v0", step_s=step_s)
    action = env.action_space.sample() * 0.0
    env.reset(seed=1)

    def step(count: int) -> None:
        for _ in range(count):
            *_, lost, over, _ = env.step(action)
            if lost or over:
                env.reset()

    return step


def _each(cost: BatchCost, count: int) -> BatchCost:
    """Return the cost of one of so many that a repetition has."""
    return replace(cost, median_ns=cost.median_ns / count, least_ns=cost.least_ns / count)


def _time_in(file: VesselFile, sea: str) -> StepCost:
    """Return the costs in a sea; the works take turns, so that they meet the same machine."""
    told, steered = (trainer.Boat(file.path, sea=sea, battery="endless") for _ in range(2))
    moments = [each.snapshot() for each in (told, steered)]
    bare = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    bare.put_to_sea(load_sea(sea))
    orders = [order for order in map(parse, ORDER_WORDS) if isinstance(order, Order)]
    for order in orders:
        obey_order(bare, order)  # so that its tick does the same work
    by_number = steered.by_number([order.name for order in orders], READ_NAMES)
    values = np.array([*np.radians((1.0, 1.0)), 60.0])

    def step(count: int) -> None:
        for _ in range(count):
            by_number.step(values)

    def tell(count: int) -> None:
        for _ in range(count):
            for words in ORDER_WORDS:
                told.order(words)
            told.run(file.run.step_s)
            _ = told.state["z"]

    def trouble(face: trainer.Boat, count: int) -> str:
        seen = bare.another()
        seen.plain[:] = array("d", face.state.values())
        return face.lost or trouble_of(seen, 0, count)

    faces = zip((steered, told), (step, tell), reversed(moments), strict=True)
    works = [
        Voyage(file.path.name, work, partial(face.restore, moment), partial(trouble, face))
        for face, work, moment in faces
    ]
    tick, stepped, said = time_batches([Voyage.of(bare, partial(in_a_loop, bare.records)), *works])
    over = stepped.least_ns - tick.least_ns
    return StepCost(sea, tick, stepped, said, over, said.least_ns / stepped.least_ns)


def lines(cost: NumbersCost) -> list[str]:
    """Return the costs as lines of a page."""
    head = "A step by numbers: three orders, a tick, six numbers read [us, least of batches]"
    columns = f"  {'':12}{'bare tick':>10}{'step':>8}{'over it':>9}{'in words':>10}{'times':>7}"
    rows = [
        f"  {each.sea:12}{each.tick.least_ns / 1e3:10.3f}{each.step.least_ns / 1e3:8.3f}"
        f"{each.over_the_tick_ns / 1e3:9.3f}{each.words.least_ns / 1e3:10.0f}"
        f"{each.words_over_step:7.0f}"
        for each in cost.seas
    ]
    learning = cost.learning
    costs = [
        ("marks of a tick", learning.judge),
        (f"step of {EVERY_S:g} s", learning.fleet),
        ("Env.step, a tick", learning.env),
    ]
    told = [
        f"  {what:18}{each.least_ns / 1e3:8.3f}  {1e9 / each.least_ns:12,.0f} a second"
        for what, each in costs
        if each is not None
    ]
    said = f"In {learning.exercise}, {FLEET_BOATS} boats and one [us each, least of batches]"
    by_threads = f"Fleet of {FLEET_BOATS} boats in {SEA_NAMES[-1]} [us a boat's step]"
    shared = [
        f"  {f'{each.ticks} ticks' if each.ticks > 1 else 'a tick':18}"
        f"{each.one.least_ns / 1e3:8.3f} by one thread{each.two.least_ns / 1e3:8.3f} by two"
        f"{each.gain:7.2f} times"
        for each in cost.fleets
    ]
    return [head, columns, *rows, "", said, *told, "", by_threads, *shared]
