"""Crews of graded skill, made from an exercise's reference crew, and crews that are silly.

``validation`` flies exercises with them, to see whether the marks order skill and give none away.
A trainee follows the rules of the reference crew with its hands, but late and with faults. A silly
crew gives orders that know nothing of the exercise. Its marks must be next to none.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.casualties import InstrumentReadings
from trainer.boat.crew_hands import TIME_ROUNDING_S, GaugeHistory
from trainer.boat.reference_crew import (
    CrewReaction,
    GivenOrder,
    ReferenceCrew,
    RuleProgress,
    order_of_hand,
)
from trainer.config.exercise.reference_crew import (
    CREW_HANDS,
    SAID_ORDERS,
    Crew,
    CrewRow,
    CrewRule,
)
from trainer.debrief.passage.controls import opposite_order
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import CREW_TALK
from trainer.session.crew.manning import in_hand
from trainer.session.past.plan import Plan

HARSH_GAIN: Final = 1.5  # [-] of the angle that a harsh hand gives for an error; an estimate
GAIN_KEYS: Final = ("bubble_deg_per_m", "rudder_per_error")  # of a hand's habits
LEAD_KEYS: Final = ("bubble_s", "stern_s", "rudder_s")  # by which it takes the angle off in time
GLANCE_S: Final = 5.0  # [s] for which a gauge is misread alike
GLANCE_COUNT: Final = 997  # misreadings that are drawn; after the last comes the first again
LATE_SPREAD: Final = 0.2  # [-] of a delay, either way
MISREAD_TURN_RAD: Final = np.pi / 2.0  # of which a share is misread of the heading
HAND_ORDER: Final = re.compile(r"(stern planes|bow planes|rudder) (rise|dive|left|right) (\d+)")
ZERO_WORDS: Final = {"rudder": "amidships", "stern planes": "zero", "bow planes": "zero"}
EVENT_ORDERS: Final = CREW_TALK | {"casualty"}  # of a plan: what a crew has to answer
FORGOTTEN_ORDER: Final = GivenOrder("", "")


@dataclass(frozen=True)
class Skill:
    """What a crew does less well than the reference crew."""

    name: str
    late_s: float = 0.0  # [s] beyond the rules
    prompt_steps: bool = False  # only late to begin: what follows upon a step comes in time
    step_deg: int = 1  # in which hands set planes and rudder
    misread_share: float = 0.0  # [-] of what a gauge shows to the hands, at most
    forgets: int = 0  # one order in so many is never given
    wrong_s: float = 0.0  # [s] for which each control goes the wrong way at first
    look_s: float = 0.0  # [s] between looks of hands that are harsh; 0: they work by the exercise

    def reaction(self, seed: int) -> CrewReaction:
        """Return how slow this crew is, its delays spread by LATE_SPREAD."""
        spread = LATE_SPREAD * self.late_s
        return CrewReaction(self.late_s - spread, 2.0 * spread, seed)


# fmt: off
# Each grade has more of all faults than the one before it. The figures are an estimate.
GRADED_CREWS: Final = (
    Skill("reference crew"),
    Skill("good", late_s=5.0),
    Skill("fair", late_s=15.0, step_deg=2, misread_share=0.02),
    Skill("weak", late_s=30.0, step_deg=3, misread_share=0.035),
    Skill("beginner", late_s=60.0, step_deg=5, misread_share=0.05, forgets=5, wrong_s=10.0),
)
LATE_CREWS: Final = (
    Skill("late 5 s alone", late_s=5.0),
    Skill("late 15 s alone", late_s=15.0),
    Skill("late 30 s alone", late_s=30.0),
    Skill("late 60 s alone", late_s=60.0),
)
FAULTY_CREWS: Final = (
    Skill("hands in steps of 5 deg alone", step_deg=5),
    Skill("gauges misread by 5 % alone", misread_share=0.05),
    Skill("harsh hands that look each 10 s alone", look_s=10.0),
    Skill("one order in three forgotten alone", forgets=3),
    Skill("wrong way for 20 s first alone", wrong_s=20.0),
)
# fmt: on
ALL_CREWS: Final = (*GRADED_CREWS, *LATE_CREWS, *FAULTY_CREWS)


def make_harsh(habits: Any, look_s: float) -> Any:
    """Return the habits of a hand that looks rarely and gives too much.

    It looks each ``look_s`` [s], and takes no angle off in time.
    """
    return scale_habits(habits, HARSH_GAIN, 0.0, look_s)


def scale_habits(habits: Any, gain: float, lead: float, look_s: float) -> Any:
    """Return the habits of a hand that looks each ``look_s`` [s].

    ``gain`` [-] of the angle is given for an error, and ``lead`` [-] of it taken off in time.
    """
    factors = dict.fromkeys(GAIN_KEYS, gain) | dict.fromkeys(LEAD_KEYS, lead)
    scaled = {key: by * getattr(habits, key) for key, by in factors.items() if hasattr(habits, key)}
    return replace(habits, look_s=look_s, **scaled)


class MisreadGauges(GaugeHistory):
    """Gauges that are read wrong at each glance, by a share drawn anew."""

    exact = False

    def __init__(self, boat: Boat, share: float, seed: int) -> None:
        super().__init__(boat)
        self.draws = share * np.random.default_rng(seed).uniform(-1.0, 1.0, GLANCE_COUNT)

    def _wrong(self) -> float:
        return float(self.draws[int(self.boat.time / GLANCE_S) % GLANCE_COUNT])

    def mean(self, name: str, seconds: float) -> float:
        """Return the mean of a gauge over the last seconds, misread."""
        return super().mean(name, seconds) * (1.0 + self._wrong())

    def now(self) -> InstrumentReadings:
        """Return the last readings, the heading misread."""
        readings = super().now()
        return readings._replace(heading=readings.heading + self._wrong() * MISREAD_TURN_RAD)


class Trainee(ReferenceCrew):
    """The reference crew of an exercise, with the faults of a skill."""

    def __init__(
        self, skill: Skill, boat: Boat, crew: Crew, reaction: CrewReaction | None = None
    ) -> None:
        """Come aboard. The seed of the reaction draws which glances and orders go wrong, too."""
        super().__init__(boat, crew, reaction)
        seed = self.reaction.seed
        self.skill, self.said = skill, seed
        self.wrong_until: dict[str, float] = {}  # [s] by control
        self.corrections: dict[str, RuleProgress] = {}  # of what went the wrong way, by control
        if skill.misread_share:
            self.gauges = MisreadGauges(boat, skill.misread_share, seed)

    def look(self) -> list[GivenOrder]:
        """Follow the rules and the hands, and put right what was ordered the wrong way.

        The right order waits in ``corrections`` as one more rule, which is due ``wrong_s`` later.
        """
        given = [each for each in super().look() if each is not FORGOTTEN_ORDER]
        new = [each for each in self.corrections.values() if each not in self.followed]
        self.follow_rules([*self.followed, *new])
        return given

    def _notice(self, each: RuleProgress, before: RuleProgress | None) -> None:
        late = self.reaction
        if self.skill.prompt_steps and each.rule.row.then:
            self.reaction = CrewReaction()
        super()._notice(each, before)
        self.reaction = late

    def _switch(self, order: Order) -> None:
        super()._switch(order)
        hand = self.hands.get(order.name)
        if self.skill.look_s and hand is not None:
            hand.habits = make_harsh(hand.habits, self.skill.look_s)

    def _shown(self, quantity: str, mean: float) -> float:
        # rules read right: of many wrong glances one passes a threshold early, which is no fault
        if quantity in ("depth", "speed"):
            return GaugeHistory.mean(self.gauges, quantity, mean)
        if quantity == "course":
            return GaugeHistory.now(self.gauges).heading % math.tau
        return super()._shown(quantity, mean)

    def _carry_out(self, progress: RuleProgress) -> GivenOrder:
        order = progress.rule.order
        if order.name in (*CREW_HANDS, *SAID_ORDERS):
            return super()._carry_out(progress)
        self.count(progress)
        return self._say(order.text)

    def _give(self, text: str) -> GivenOrder:
        return self._say(coarse_order(text, self.skill.step_deg))

    def _say(self, text: str) -> GivenOrder:
        """Give an order, or forget it, or for ``wrong_s`` its opposite."""
        self.said += 1
        if self.skill.forgets and self.said % self.skill.forgets == 0:
            return FORGOTTEN_ORDER
        control = text.partition(" ")[0]
        until = self.wrong_until.setdefault(control, self.boat.time + self.skill.wrong_s)
        if self.boat.time >= until - TIME_ROUNDING_S:
            return super()._give(text)
        correction = self.corrections.get(control)
        if correction is None or correction.over:
            self.corrections[control] = order_later(text, until)
        else:  # what is put right is what was ordered last
            correction.rule = order_later(text, until).rule
        return super()._give(opposite_order(text))


def order_later(text: str, due: float) -> RuleProgress:
    """Return an order as a rule that waits for a time [s] alone."""
    rule = CrewRule(row=CrewRow(order=text), conditions=(), order=order_of_hand(text))
    return RuleProgress(rule, due)


def coarse_order(text: str, step: int) -> str:
    """Return a hand's order in whole steps [deg]."""
    match = HAND_ORDER.fullmatch(text)
    if match is None or step == 1:
        return text
    angle = step * round(int(match[3]) / step)
    return f"{match[1]} {match[2]} {angle}" if angle else f"{match[1]} {ZERO_WORDS[match[1]]}"


# Silly crews


class Moment(Enum):
    """The moments at which a silly crew orders something."""

    BEGIN = "begin"  # once, BEGIN_S after the start
    EVENT = "event"  # ANSWER_S after each order to the crew, and each casualty
    PANIC = "panic"  # as at EVENT, and all taken back TAKEN_BACK_S later
    EVER = "ever"  # one of its orders each TWITCH_S, in turn


BEGIN_S, ANSWER_S, TAKEN_BACK_S, TWITCH_S = 61.0, 6.0, 20.0, 4.0  # [s]
FIRST_TWITCH_S: Final = 60.0  # [s]


class SillyPolicy(NamedTuple):
    """Orders that know nothing of the exercise.

    In a text ``;`` parts orders of one moment; Moment.EVER and PANIC take the texts in turn.
    """

    name: str
    moment: Moment
    orders: tuple[str, ...]


AUTOMATIC_ORDERS: Final = (
    "planes auto; rudder auto; autopilot on; trim auto; hover on; depth 60; course 0; speed 8"
)
PANIC_ORDERS: Final = (
    "bell astern full; rudder left 30; stern planes rise 20; bow planes rise 20; emergency blow; "
    "drain aft; pump depth-control 5"
)
PANIC_ENDS: Final = (
    "bell ahead two-thirds; rudder amidships; stern planes zero; bow planes zero; blow stop; "
    "vent all open; drain stop; flood depth-control 5"
)
# fmt: off
SILLY_POLICIES: Final = (
    SillyPolicy("nobody", Moment.BEGIN, ()),
    SillyPolicy("run away", Moment.BEGIN, ("bell ahead flank; rudder right 20",)),
    SillyPolicy("circle right", Moment.BEGIN, ("rudder right 30",)),
    SillyPolicy("circle left", Moment.BEGIN, ("rudder left 30",)),
    SillyPolicy("surface", Moment.BEGIN, ("surface",)),
    SillyPolicy("surface at each event", Moment.EVENT, ("surface",)),
    SillyPolicy("emergency blow", Moment.BEGIN, ("emergency blow",)),
    SillyPolicy("emergency blow at each event", Moment.EVENT, ("emergency blow",)),
    SillyPolicy("all stop", Moment.BEGIN, ("bell stop",)),
    SillyPolicy("all stop at each event", Moment.EVENT, ("bell stop",)),
    SillyPolicy("full astern", Moment.BEGIN, ("bell astern full",)),
    SillyPolicy("full astern at each event", Moment.EVENT, ("bell astern full",)),
    SillyPolicy("full ahead", Moment.BEGIN, ("bell ahead full",)),
    SillyPolicy("full ahead at each event", Moment.EVENT, ("bell ahead full",)),
    SillyPolicy("hover by propeller", Moment.BEGIN, ("bell ahead one-third",)),
    SillyPolicy("dive", Moment.BEGIN, ("stern planes dive 10; bow planes dive 20",)),
    SillyPolicy("rise", Moment.BEGIN, ("stern planes rise 10; bow planes rise 20",)),
    SillyPolicy("flood 5 t", Moment.BEGIN, ("flood depth-control 5",)),
    SillyPolicy("pump 5 t", Moment.BEGIN, ("pump depth-control 5",)),
    SillyPolicy("order and take back", Moment.EVENT, ("depth 60; planes manual",)),
    SillyPolicy("all automatic", Moment.EVENT, (AUTOMATIC_ORDERS,)),
    SillyPolicy("words only", Moment.EVENT, ("order depth 60; order course 0",)),
    SillyPolicy("useless answer", Moment.EVENT, ("bow planes rise 1",)),
    SillyPolicy("panic, taken back", Moment.PANIC, (PANIC_ORDERS, PANIC_ENDS)),
    SillyPolicy("hunting", Moment.EVER, (
        "stern planes dive 4; rudder left 4", "stern planes rise 4; rudder right 4")),
    SillyPolicy("hunting, hard", Moment.EVER, (
        "stern planes dive 15; rudder left 15", "stern planes rise 15; rudder right 15")),
)
# fmt: on


def silly_orders(policy: SillyPolicy, plan: Plan) -> Iterator[tuple[float, Order]]:
    """Yield times [s] and orders of a silly crew, without what a station would refuse."""
    for i, seconds in enumerate(_moments(policy.moment, plan)):
        for text in policy.orders[i % len(policy.orders)].split("; ") if policy.orders else ():
            order = parse(text)
            if not isinstance(order, Order):
                continue
            if seconds < plan.hand_from or in_hand(order, plan.hand, plan.allowed) is None:
                yield seconds, order


def _moments(moment: Moment, plan: Plan) -> tuple[float, ...]:
    """Return the times [s] of a moment in a plan that has an end."""
    end: Any = plan.duration
    if moment is Moment.BEGIN:
        return (BEGIN_S,)
    if moment is Moment.EVER:
        return tuple(np.arange(FIRST_TWITCH_S, end, TWITCH_S))
    events = {e.seconds + ANSWER_S for e in plan.schedule if e.order.name in EVENT_ORDERS}
    delays = (0.0, TAKEN_BACK_S) if moment is Moment.PANIC else (0.0,)
    return tuple(each + delay for each in sorted(events) for delay in delays)
