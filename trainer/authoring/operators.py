"""Model operators: persons with traits, who fly an exercise by its reference crew's hands.

``people`` asks with them how well marks tell better persons from worse, before people have flown.
An operator does what a person does less well than the reference crew: it reacts late, looks seldom,
sees what was a moment ago and not quite, takes angles off too late, and gives too much or too
little. It forgets an order, or gives it the wrong way, and mends that later.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.authoring.trainees import FORGOTTEN_ORDER, Skill, Trainee, order_later, scale_habits
from trainer.boat.boat import Boat
from trainer.boat.casualties import InstrumentReadings
from trainer.boat.crew_hands import TIME_ROUNDING_S, GaugeHistory
from trainer.boat.reference_crew import CrewReaction, GivenOrder, RuleProgress
from trainer.config.exercise.reference_crew import CREW_HANDS, SAID_ORDERS, Crew
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.passage.controls import control_of
from trainer.io.orders.grammar import Order
from trainer.session.past.plan import Plan

# Estimates, all of them: docs/validation.md says what of this is known of people, which is nothing.
REACTION_SPREAD: Final = 0.35  # [-] of one person's reactions, lognormal
LOOK_SPREAD: Final = 0.25  # [-] of the time from look to look, lognormal
MIN_LOOK_S: Final = 1.0  # [s]
STEP_SHARE: Final = 0.3  # [-] of a reaction that the next step of a chain takes
WRONG_WAY_S: Final = 8.0  # [s] for which a control goes the wrong way, beyond a reaction
FORGOTTEN_S: Final = 45.0  # [s] after which a forgotten order comes back to mind
RATE_NOISE: Final = 0.05  # [1/s] of the noise of a depth, in its rate
HEADING_NOISE: Final = math.radians(0.5)  # [rad] for a metre of noise of a depth
HAND_AXES: Final = {"planesman": "depth", "helmsman": "course"}  # of what a hand is ordered
HAND_CONTROLS: Final = {"planesman": ("stern", "bow"), "helmsman": ("rudder",)}


@dataclass(frozen=True)
class Person:
    """One operator, with the traits that it keeps from run to run."""

    number: int
    skill: float  # [-] 0: a beginner, 1: as good as the reference crew but for its reaction
    react_s: float  # [s] median, beyond the rules
    look_s: float  # [s] median, from look to look
    delay_s: float  # [s] from what a gauge shows to what is perceived
    lead: float  # [-] of the angle that the reference crew takes off in time
    gain: float  # [-] of the angle that it gives for an error
    noise_m: float  # [m] standard deviation of a depth that is read
    wrong_share: float  # [-] of orders given the wrong way at first
    omitted_share: float  # [-] of orders forgotten at first


def person_of(number: int, skill: float) -> Person:
    """Return the person of a number, whose traits scatter about its skill; estimates."""
    draws, lack = np.random.default_rng([number, 1]), 1.0 - skill
    react, lead, gain = draws.normal(0.0, (0.25, 0.3, 0.35 * lack))
    return Person(
        number=number,
        skill=skill,
        react_s=(2.0 + 16.0 * lack) * math.exp(react),
        look_s=3.0 + 6.0 * lack,
        delay_s=0.5 + 2.5 * lack,
        lead=max(0.0, 1.0 - lack * math.exp(lead)),
        gain=math.exp(gain),
        noise_m=0.15 + lack,
        wrong_share=0.2 * lack,
        omitted_share=0.2 * lack,
    )


@dataclass
class DrawnReaction(CrewReaction):
    """The reaction of a person: ``late`` is its median [s]."""

    def delay(self) -> float:
        """Return how much later the next reaction comes [s], lognormal about the median."""
        return self.late * math.exp(self._draws.normal(0.0, REACTION_SPREAD))


class PerceivedGauges(GaugeHistory):
    """The gauges as a person perceives them: a moment ago, and not quite right."""

    exact = False

    def __init__(self, boat: Boat, person: Person, draws: np.random.Generator) -> None:
        super().__init__(boat)
        self.person, self.draws = person, draws

    def _perceived(self) -> GaugeHistory:
        """Return the gauges up to a delay ago."""
        seen_by = self.seen[-1][0] - self.person.delay_s + TIME_ROUNDING_S
        return GaugeHistory(self.boat, self.seen[: max(self._index(seen_by), 1)])

    def _noise(self, scale: float) -> float:
        return float(self.draws.normal(0.0, scale * self.person.noise_m))

    def mean(self, name: str, seconds: float) -> float:
        """Return the mean of a gauge over the last seconds, as perceived."""
        return self._perceived().mean(name, seconds) + self._noise(1.0)

    def rate(self, name: str, seconds: float) -> float:
        """Return how fast a gauge moves [1/s], as perceived."""
        return self._perceived().rate(name, seconds) + self._noise(RATE_NOISE)

    def now(self) -> InstrumentReadings:
        """Return the readings as perceived, the heading not quite right."""
        readings = self._perceived().now()
        return readings._replace(heading=readings.heading + self._noise(HEADING_NOISE))


class Operator(Trainee):
    """A person at the reference crew's work. The seed of the reaction draws all that it does."""

    def __init__(
        self, person: Person, boat: Boat, crew: Crew, reaction: CrewReaction | None = None
    ) -> None:
        super().__init__(Skill(f"person {person.number}"), boat, crew, reaction)
        self.person = person
        self.draws = np.random.default_rng([self.reaction.seed, 2])
        self.gauges = PerceivedGauges(boat, person, self.draws)
        self.heard: dict[str, float] = {}  # the order that each hand has heard last, by its tick

    def look(self) -> list[GivenOrder]:
        """Follow the rules and the hands, each by its own next look."""
        for name, hand in self.hands.items():
            stamp = self._stamp(HAND_AXES[name])
            if stamp != self.heard.get(name, 0.0):
                self.heard[name] = stamp
                self._may_go_wrong(HAND_CONTROLS[name], hand.habits.answer_s + hand.late)
        given = super().look()
        for hand in self.hands.values():
            if hand.looked == self.boat.time:
                hand.habits = replace(hand.habits, look_s=self._next_look_s())
        return given

    def _next_look_s(self) -> float:
        spread = math.exp(self.draws.normal(0.0, LOOK_SPREAD))
        return max(self.person.look_s * spread, MIN_LOOK_S)

    def _may_go_wrong(self, controls: Iterable[str], begins_s: float = 0.0) -> None:
        """Draw whether controls, worked from a time [s] on, go the wrong way until that is seen."""
        if self.draws.random() < self.person.wrong_share:
            until = self.boat.time + begins_s + self.reaction.delay() + WRONG_WAY_S
            self.wrong_until |= dict.fromkeys(controls, until)

    def _notice(self, each: RuleProgress, before: RuleProgress | None) -> None:
        median = self.reaction.late
        self.reaction.late = median * (STEP_SHARE if each.rule.row.then else 1.0)
        super()._notice(each, before)
        self.reaction.late = median

    def _switch(self, order: Order) -> None:
        super()._switch(order)
        if (hand := self.hands.get(order.name)) is not None:
            person = self.person
            hand.habits = scale_habits(hand.habits, person.gain, person.lead, self._next_look_s())

    def _carry_out(self, progress: RuleProgress) -> GivenOrder:
        order = progress.rule.order
        if order.name not in (*CREW_HANDS, *SAID_ORDERS) and progress.rule in self.crew.rules:
            if self.draws.random() < self.person.omitted_share:
                self.count(progress)
                later = order_later(order.text, self.boat.time + FORGOTTEN_S)
                self._outdate(order.text)
                self.corrections[f"forgotten {control_of(order.text)}"] = later
                return FORGOTTEN_ORDER
            self._may_go_wrong(order.text.split()[:1])
        return super()._carry_out(progress)

    def _say(self, text: str) -> GivenOrder:
        self._outdate(text)
        return super()._say(text)

    def _outdate(self, text: str) -> None:
        """Never give what was forgotten of a control that is ordered anew."""
        if (forgotten := self.corrections.pop(f"forgotten {control_of(text)}", None)) is not None:
            forgotten.over = True


def fly_person(plan: Plan, person: Person, seed: int) -> Rehearsal:
    """Return an exercise flown by a person; ``seed`` draws the chances of this run."""
    reaction = DrawnReaction(person.react_s, seed=seed)
    return fly_rehearsal(plan, plan.crew, reaction, lambda *aboard: Operator(person, *aboard))
