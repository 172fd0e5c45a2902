"""The marks that a careful crew could still earn, while the session goes on.

A session starts it as a process of its own (``session/exercise/evaluation``): python -m
trainer.debrief.live.evaluator FILE. For each moment a line of JSON comes in, and one goes out. The
orders up to it are read from the recording, and flown again with the reference crew mute. What can
be had from there is searched (``attainable``), and what to order (``advice``).
"""

import base64
import json
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import CrewReaction
from trainer.config.files import ConfigError
from trainer.core.state import STATE
from trainer.debrief.attainable.continuations import Choices
from trainer.debrief.attainable.search import (
    ContinuationSearch,
    NoCurve,
    OpenMoment,
    order_at,
    refuse_plan,
)
from trainer.debrief.live.advice import Advisor
from trainer.debrief.marks.judgement import FREEING_ORDERS, WIDTH_FACTORS, judge_run
from trainer.debrief.marks.reference import join_runs
from trainer.debrief.marks.rehearsal import ByReference, Departure, Flight, due_tick, fly
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.page.data import events_of, find_branch, nobody_aboard
from trainer.debrief.passage.episodes import crew_orders, ordered_beyond
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.orders.grammar import Refused
from trainer.io.recording.facts import SCHEDULE_GIVER
from trainer.io.recording.recording import RecordedEvent, RecordedOrder, Recording
from trainer.session.past.header import open_recording, plan_of
from trainer.session.past.plan import Plan

JOURNAL_TIMEOUT_S: Final = 5.0  # [s] until an order that was given is in the file
JOURNAL_PERIOD_S: Final = 0.05  # [s] between looks
OTHER_PROGRAM: Final = "the run cannot be flown again to the bit"


@dataclass(frozen=True)
class FollowedStretch:
    """A stretch of the run that was flown again, and the moment at its end."""

    orders: tuple[int, ...]  # numbers of those that led to it
    trajectory: Trajectory
    end: Departure


@dataclass
class RunFollower:
    """A run under way, followed by the mute reference crew from moment to moment."""

    plan: Plan
    nobody: Mapping[str, float]  # marks with nobody aboard, as ``judge_run`` takes them
    width: str = "qualified"
    stretches: list[FollowedStretch] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.choices = Choices(self.plan)
        boat = self.plan.launch_boat()
        crew = MuteCrew(boat, self.plan.crew, CrewReaction())
        start = Departure(0, boat.snapshot(), (), crew.aboard(boat))
        first = Flight(self.plan, boat, ByReference()).rehearsal().trajectory
        self.stretches.append(FollowedStretch((), first, start))

    def follow(self, orders: Sequence[RecordedOrder], tick: int, state: bytes) -> Departure:
        """Fly the run on to a tick by its recorded orders.

        NoCurve if it does not come to the recorded state. What was followed before is kept as far
        as the same orders led to it.
        """
        while not self._leads_to(self.stretches[-1], orders, tick):
            del self.stretches[-1]
        since = self.stretches[-1].end
        by_tick: dict[int, list[RecordedOrder]] = defaultdict(list)
        for order in orders:
            by_tick[order.tick].append(order)
        run, end = fly(self.plan, since, by_tick, until=tick)
        told = np.frombuffer(state, STATE)[0]["motion"]
        if end.tick != tick or not np.array_equal(end.state["motion"][0], told):
            raise NoCurve(OTHER_PROGRAM)
        led = tuple(order.id for order in orders if order.tick < tick)
        if tick > since.tick:
            self.stretches.append(FollowedStretch(led, run.trajectory, end))
        return end

    def _leads_to(self, known: FollowedStretch, orders: Sequence[RecordedOrder], tick: int) -> bool:
        """Return whether a stretch is of the run that these orders made, up to a tick."""
        earlier = tuple(order.id for order in orders if order.tick < known.end.tick)
        return known.end.tick <= tick and earlier == known.orders

    def past(
        self, orders: Sequence[RecordedOrder], marks: Sequence[RecordedEvent], tick: int
    ) -> Trajectory:
        """Return the run that was followed up to a tick, with its orders."""
        flown = reduce(join_runs, (each.trajectory for each in self.stretches))
        return replace(
            flown,
            orders=tuple(each for each in orders if each.tick < tick),
            marks=tuple(each for each in marks if each.tick < tick),
        )

    def judge(self, trajectory: Trajectory) -> Scorecard:
        """Return the marks of a whole run."""
        return judge_run(trajectory, self.plan, self.nobody, self.width)

    def advisor(self, past: Trajectory, end: Departure, orders: Sequence[RecordedOrder]) -> Advisor:
        """Return who advises at a moment, the orders of its tick given."""
        later: dict[int, list[RecordedOrder]] = defaultdict(list)
        later[end.tick] += [each for each in orders if each.tick == end.tick]
        given = {each.entry for each in orders}
        for index, entry in enumerate(self.plan.schedule):
            if index not in given:
                tick, words = max(due_tick(self.plan, index), end.tick), entry.order.text
                later[tick].append(order_at(tick, SCHEDULE_GIVER, words, index))
        own = crew_orders(replace(past, orders=tuple(orders)))
        search = ContinuationSearch(self.plan, self.judge, self.choices, later)
        return Advisor(search, OpenMoment(end, past, own))


class FreeRun(NoCurve):
    """A branch has no marks; another one may have them."""


def refuse_free(card: Scorecard | None) -> None:
    """Raise FreeRun for the marks of a free run."""
    if card is not None and card.verdict is not None and card.verdict.free:
        since, _, _giver = card.verdict.reason.partition(", by ")
        raise FreeRun(f"free run since {since}: backtrack for marks")


@dataclass
class Evaluator:
    """The answers about one recording that is being written."""

    recording: Recording
    source: Path
    follower: RunFollower

    @classmethod
    def of(cls, recording: Recording, source: Path) -> "Evaluator":
        """Return the evaluator of a recording; NoCurve if its exercise has no curve."""
        header = recording.header()
        begun = header.get("width", "")
        width = begun if begun in WIDTH_FACTORS else "qualified"
        plan = plan_of(header).alone()
        refuse_plan(plan)
        nobody = nobody_aboard(plan, header, width)
        return cls(recording, source, RunFollower(plan, nobody, width))

    def answer(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        """Return what could still be earned from a moment, and with an order."""
        tick, branch = int(asked["tick"]), int(asked["branch"])
        orders = self._orders(branch, int(asked["after"]))
        end = self.follower.follow(orders, tick, base64.b64decode(asked["state"]))
        recording, branches = self.recording, self.recording.branches()
        events = events_of(recording, branches, find_branch(recording, self.source, branch))
        marks = [each for each in events if each.kind == "mark"]
        if (wants := asked.get("wants", "marks")) != "marks":
            return self._advise(wants, orders, marks, end)
        past = self.follower.past(orders, marks, tick)
        so_far = self.follower.judge(past) if tick else None
        advisor = self.follower.advisor(past, end, orders)
        refuse_free(advisor.best.card)
        point = advisor.marks()
        beyond = ordered_beyond(orders)
        answer: dict[str, Any] = {
            "so_far": so_far.total if so_far else 0.0,
            "marks": point.marks,
            "won": point.won,
            "lost": point.lost,
            "beyond": beyond[-1].text if beyond else "",
        }
        if text := asked.get("order", ""):
            reply = advisor.answer(text)
            answer["refused"] = reply.reason if isinstance(reply, Refused) else ""
            answer["with"] = advisor.marks_after(text)
        return answer

    def _advise(
        self,
        wants: str,
        orders: Sequence[RecordedOrder],
        marks: Sequence[RecordedEvent],
        end: Departure,
    ) -> dict[str, Any]:
        """Return a hint or the way on, even in a free run: what freed it counts as planned."""
        planned = [
            replace(each, giver=SCHEDULE_GIVER) if each.name in FREEING_ORDERS else each
            for each in orders
        ]
        past = self.follower.past(planned, marks, end.tick)
        advisor = self.follower.advisor(past, end, planned)
        if wants == "hint":
            return {"hint": advisor.hint(), "marks": advisor.best.marks}
        return {"way": advisor.way()}

    def _orders(self, branch: int, after: int) -> list[RecordedOrder]:
        """Return the accepted orders that a moment includes, once they are all in the file."""
        until = time.monotonic() + JOURNAL_TIMEOUT_S
        while True:
            orders = self.recording.orders(branch)
            if not after or any(each.id >= after for each in orders):
                kept = (each for each in orders if each.id <= after)
                return [each for each in kept if each.accepted is not False]
            if time.monotonic() > until:
                raise NoCurve("the recording does not have the last orders")
            time.sleep(JOURNAL_PERIOD_S)


def answers(source: Path, lines: Iterator[str]) -> Iterator[dict[str, Any]]:
    """Yield an answer for each line; without a curve each says why."""
    evaluator: Evaluator | None = None
    with open_recording(source) as recording, np.errstate(all="ignore"):
        for line in lines:
            try:
                evaluator = evaluator or Evaluator.of(recording, source)
                yield evaluator.answer(json.loads(line))
            except FreeRun as free:
                yield {"free": free.why}
            except (NoCurve, ConfigError) as none:
                yield {"why": getattr(none, "why", str(none))}


def main() -> None:
    """Answer the lines of the standard input until it ends."""
    for answer in answers(Path(sys.argv[1]), iter(sys.stdin.readline, "")):
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
