"""The plan of a run: all its settings, decided before it starts.

The command line overrules the exercise, and the exercise overrules the vessel file. ``run`` makes
the boat and the session by the plan; replays and marks make it again from a recording's header.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from trainer.boat import casualties as casualties_module
from trainer.boat.assemble import Method
from trainer.boat.ballast_orders import put_out_of_trim
from trainer.boat.boat import Boat
from trainer.boat.depths import DepthGuard
from trainer.boat.plant import without_drain
from trainer.boat.world.encounters import refuse_touching
from trainer.boat.world.world import world_of
from trainer.config.boat.casualties import Casualty, load_casualties
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.exercise.baseline import Baseline, kept_baseline
from trainer.config.exercise.derived import Loss
from trainer.config.exercise.exercise import (
    AIDS,
    ConditionalCasualty,
    Exercise,
    ExerciseLimits,
    StartState,
    load_exercise,
)
from trainer.config.exercise.reference_crew import Crew
from trainer.config.exercise.score_rules import ScoreRule, with_quiet_hands
from trainer.config.exercise.steps import Step
from trainer.config.files import ConfigError, read_text
from trainer.config.keywords import STEP_LIMITS
from trainer.config.words import ENDLESS_BATTERY
from trainer.config.world.sea import SeaFile, load_sea, sea_settings, step_problem
from trainer.config.world.world import WorldTables
from trainer.core.scheme import RUNGE_KUTTAS
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import BadSchedule, ScheduledOrder, parse_schedule
from trainer.io.orders.words import ORDER_WORDS
from trainer.session.past.options import RunOptions
from trainer.units import KNOT

# For each option that overrules an exercise: the key of the exercise's heading that it overrules.
OVERRULED_SETTINGS: Final = {
    "vessel": "vessel",
    "equations": "equations",
    "rates": "rates",
    "integrator": "integrator",
    "step": "step_s",
    "seed": "seed",
    "duration": "duration_s",
}
# the orders that put an axis in hand; surfaces and water stay as they are
INTO_HAND_ORDERS: Final = {
    "rudder": ("rudder manual",),
    "planes": ("planes manual",),
    "ballast": ("trim manual", "hover off"),
}


@dataclass(frozen=True, kw_only=True)
class Plan:
    """All settings of a run, decided before it starts."""

    file: VesselFile
    method: Method
    sea: SeaFile
    seed: int
    duration: float | None  # [s]
    schedule: list[ScheduledOrder]
    casualties: Mapping[str, Casualty]
    # Of the exercise. Without one these defaults hold.
    title: str = ""
    briefing: str = ""
    initial: StartState = field(default_factory=StartState)
    armed: tuple[ConditionalCasualty, ...] = ()
    limits: ExerciseLimits = field(default_factory=ExerciseLimits)
    scores: tuple[ScoreRule, ...] = ()
    own_schedule: tuple[ScheduledOrder, ...] = ()  # of the exercise alone, without --orders
    instructor: str = ""  # the briefing that only the instructor gets
    hand: tuple[str, ...] = ()  # axes that the crew works
    hand_from: float = 0.0  # [s]
    allowed: tuple[str, ...] = ()  # automatic orders, all the same
    guard: DepthGuard = field(default_factory=DepthGuard)
    visitors: bool = False  # may begin it again
    lost: tuple[Loss, ...] = ()
    crew: Crew = field(default_factory=Crew)  # the reference crew
    baseline: Baseline | None = None  # as it was flown and kept
    world: WorldTables = field(default_factory=dict)  # the exercise's own
    steps: tuple[Step, ...] = ()  # that lead a trainee
    aids: tuple[str, ...] = AIDS  # that are allowed
    hint_marks: float = 0.0  # [%] that each hint costs
    light: str = ""  # that the periscope sees by

    @property
    def judged_by_tasks(self) -> bool:
        """Return whether the marks are those of tasks, else a plain mean (docs/debrief.md).

        From a task's marks those are taken off that a boat with nobody aboard gets.
        """
        return bool(self.hand or self.lost or any(rule.score.part for rule in self.scores))

    @property
    def note(self) -> str:
        """Return the notice that the boat has no compact set, "" where it needs none."""
        if self.file.has_compact_set or self.method.equations != "full":
            return ""
        return (
            f"{self.file.path.name} has no compact set of its own: the full set is flown; "
            "trainer boat reduce makes one"
        )

    @property
    def around(self) -> WorldTables:
        """Return the tables of the world. The exercise's overrule those of the sea's file."""
        return {**self.sea.world, **self.world}

    def alone(self) -> "Plan":
        """Return the plan without the orders that the command line adds."""
        own = list(self.own_schedule)
        return self if own == self.schedule else replace(self, schedule=own)

    @property
    def hides(self) -> bool:
        """Return whether the plan has casualties, which the crew must not know before.

        The briefing of an older file is then for the instructor alone.
        """
        return bool(self.armed) or any(each.order.name == "casualty" for each in self.schedule)

    @cached_property
    def outfit(self) -> Boat:
        """Return the boat that each boat of this plan copies."""
        return Boat(self.file, self.method)

    def launch_boat(self) -> Boat:
        """Return another boat, started as planned; ConfigError if it cannot."""
        boat = self.outfit.another()
        self.start(boat)
        return boat

    def start(self, boat: Boat) -> None:
        """Start the boat as planned; ConfigError if it cannot."""
        run = self.file.run
        speed = run.start_speed_kn if self.initial.speed_kn is None else self.initial.speed_kn
        depth = run.start_depth_m if self.initial.depth_m is None else self.initial.depth_m
        course = math.radians(self.initial.course_deg or 0.0)
        boat.start(speed * KNOT, depth, course, self.seed)
        boat.put_to_sea(self.sea)
        boat.world = world_of(boat, self.around)
        refuse_touching(boat)
        heavy, forward = self.initial.heavy_t or 0.0, self.initial.forward_t or 0.0
        why = put_out_of_trim(boat, 1000.0 * heavy, 1000.0 * forward) if heavy or forward else ""
        if why:
            raise ConfigError(f"[initial] heavy_t = {heavy:g}, forward_t = {forward:g}: {why}")
        boat.casualties = self.casualties
        for entry in self.armed:
            casualties_module.arm_casualty(boat, entry.condition, entry.casualty, entry.rule)
        boat.meet_world()


def plan_run(options: RunOptions) -> Plan:
    """Return the plan of the command line's ``options``; ConfigError on what is wrong.

    ``options.given`` names those that the user gave; they overrule the exercise.
    """
    exercise = None if options.exercise is None else load_exercise(options.exercise)
    chosen = replace(options, **exercise_options(exercise, options.given)) if exercise else options
    file = load_vessel(chosen.vessel)
    if chosen.battery == ENDLESS_BATTERY:
        file = without_drain(file)
    if exercise:
        where = f"{exercise.path.name}: [initial] depth_m"
        refuse_depth(exercise.initial.depth_m, file, where)
    exercise_sea = exercise.sea if exercise and options.sea is None else None
    sea, method = exercise_sea or load_sea(options.sea or "calm"), choose_method(file, chosen)
    if refused := step_problem(sea_settings(sea, file.fluid.g), method.step):
        raise ConfigError(f"{sea.path.name}: {refused.reason}")
    own_schedule = []
    if exercise:
        own_schedule = [*into_hand(exercise, file), *exercise.schedule_of(int(chosen.seed))]
    schedule = [*own_schedule, *read_schedule(options.orders_file)]
    plan = Plan(
        file=file,
        method=method,
        sea=sea,
        seed=int(chosen.seed),
        duration=chosen.duration,
        schedule=sorted(schedule, key=lambda entry: entry.seconds),
        casualties=exercise.casualties if exercise else load_casualties(),
    )
    if exercise is None:
        return plan
    heading = exercise.heading
    return replace(
        plan,
        title=heading.name,
        briefing=heading.briefing,
        initial=exercise.initial,
        armed=exercise.armed,
        limits=exercise.limits,
        scores=with_quiet_hands(exercise.scores, heading.hand or ()),
        own_schedule=tuple(sorted(own_schedule, key=lambda entry: entry.seconds)),
        instructor=heading.instructor or "",
        hand=heading.hand or (),
        hand_from=heading.hand_from_s or 0.0,
        allowed=heading.allowed or (),
        guard=DepthGuard(heading.guard_depth_m or math.inf),
        visitors=bool(heading.visitors),
        lost=exercise.lost,
        crew=exercise.crew,
        hint_marks=heading.hint_marks,
        light=heading.light or "",
        baseline=kept_baseline(exercise.path),
        world=exercise.world,
        steps=exercise.steps,
        aids=exercise.aids,
    )


def into_hand(exercise: Exercise, file: VesselFile) -> list[ScheduledOrder]:
    """Return the orders that put the crew's controls in hand, none without an autopilot."""
    heading = exercise.heading
    if file.autopilot is None or not heading.hand:
        return []
    speed = exercise.initial.speed_kn
    speed = file.run.start_speed_kn if speed is None else speed
    words = {**INTO_HAND_ORDERS, "speed": (f"turns {speed:g}",)}  # turns for the speed of the start
    orders = [parse(text) for axis in heading.hand for text in words[axis]]
    at = heading.hand_from_s or 0.0
    return [ScheduledOrder(at, order, 0) for order in orders if isinstance(order, Order)]


def refuse_depth(depth: float | None, file: VesselFile, where: str) -> None:
    """Raise ConfigError if the hull is lost at a depth [m]. ``where`` says of what."""
    limit = file.hull.collapse_depth_m
    if depth is not None and limit is not None and depth >= limit:
        raise ConfigError(
            f"{where} = {depth:g} m: must be less than "
            f"collapse_depth_m = {limit:g} m of {file.path.name}"
        )


def exercise_options(exercise: Exercise, given: frozenset[str]) -> dict[str, Any]:
    """Return the options that the exercise sets and the user has not given."""
    said = {item.name: getattr(exercise.heading, item.name) for item in fields(exercise.heading)}
    return {
        option: said[key]
        for option, key in OVERRULED_SETTINGS.items()
        if said[key] is not None and option not in given
    }


def choose_method(file: VesselFile, options: RunOptions) -> Method:
    """Return equations, integrator and step of the boat; ConfigError on a bad step."""
    step = file.run.step_s if options.step is None else options.step
    low, high = STEP_LIMITS
    if not low <= step <= high:
        raise ConfigError(f"--step {step:g}: a step is {low:g} to {high:g} s")
    integrator = options.integrator
    rates = options.rates or ("exact" if integrator in RUNGE_KUTTAS else "lagged")
    equations = options.equations or file.own_equations
    return Method(equations, rates, options.trig, integrator, step)


def read_schedule(path: Path | None) -> list[ScheduledOrder]:
    """Return the scheduled orders in that file; ConfigError naming the line that is wrong."""
    if path is None:
        return []
    try:
        text = read_text(path)
    except ConfigError as wrong:
        raise ConfigError(f"--orders {wrong}") from None
    schedule = parse_schedule(text, path.name)
    if isinstance(schedule, BadSchedule):
        raise ConfigError(str(schedule))
    for entry in schedule:
        if not ORDER_WORDS[entry.order.name].scheduled:
            raise ConfigError(
                f"{path.name}:{entry.line_number}: {entry.order.text} has no place in a schedule"
            )
    return schedule
