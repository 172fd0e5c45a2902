"""A boat made ready by its plan, and its crew, for runs and calls."""

import sys
from pathlib import Path

from trainer.boat.boat import Boat
from trainer.config.files import ConfigError
from trainer.io.paths import MAKING_READY
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.manning import HandWork, in_hand
from trainer.session.doors.warm_up import refuse_unstable, warm_boat
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan


def refuse_automatic(plan: Plan, path: Path | None) -> None:
    """Raise ConfigError if orders from a file give the autopilot an axis of the crew."""
    own_ids = {*map(id, plan.own_schedule)}
    added = [each for each in plan.schedule if id(each) not in own_ids]
    problems = [
        f"{path and path.name}:{entry.line_number}: {entry.order.text}: {taken.why}"
        for entry in added
        if entry.seconds >= plan.hand_from
        and (taken := in_hand(entry.order, plan.hand, plan.allowed))
    ]
    if problems:
        raise ConfigError(*problems)


def ready_boat(plan: Plan, options: RunOptions) -> Boat:
    """Return the boat as the plan starts it; ConfigError if it cannot be."""
    refuse_automatic(plan, options.orders_file)
    boat = Boat(plan.file, plan.method)
    if options.serve:
        print(f"{MAKING_READY} {plan.title or plan.file.name}", file=sys.stderr)
    warm_boat(boat)
    if not options.unsafe_step:
        refuse_unstable(boat)
    plan.start(boat)
    if plan.note:
        print(f"trainer: {plan.note}", file=sys.stderr)
    return boat


def crew_talk(plan: Plan, boat: Boat) -> CrewTalk:
    """Return the crew's talk before any word, with the axes that are worked by hand."""
    hand, allowed = frozenset(plan.hand), frozenset(plan.allowed)
    return CrewTalk(boat, HandWork(boat, hand, plan.hand_from, allowed, plan.guard))
