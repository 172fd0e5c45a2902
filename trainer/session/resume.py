"""The order ``trainer resume``: a recorded run goes on where its recording ends.

The boat gets the last recorded state, and the orders that were given after it once more.
ConfigError if the vessel file, the exercise or the program has changed since, unless the user
insists, because the run would go on differently from how it began.
"""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.crew_orders import ordered_fact
from trainer.boat.helm import obey_order
from trainer.boat.world.scope import periscope_of
from trainer.config.files import ConfigError
from trainer.io.orders.grammar import Refused
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.recording.facts import NO_CREW_FACT
from trainer.io.recording.recording import RecordedOrder, Recording
from trainer.session.doors.warm_up import set_garbage_aside, warm_boat
from trainer.session.exercise.marks import DebriefSource
from trainer.session.past.header import (
    differences,
    exercise_of,
    layout_of,
    plan_of,
    refusing_damage,
    trainees_of,
)
from trainer.session.past.history import History
from trainer.session.past.journal import order_of, restore_world
from trainer.session.past.layout import read_state
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan
from trainer.session.run import (
    LastingParts,
    PreparedRun,
    course_of,
    fly_session,
    run_following,
    why_single,
)


def resume_boat(
    path: Path, options: RunOptions, debriefing: DebriefSource | None = None, *, anyway: bool
) -> int:
    """Go on with the recording at ``path``, and what follows it; return the exit code."""
    course = course_of(options)
    with refusing_damage():
        with contextlib.closing(Recording.look(path)) as looked:  # what is refused stays as it is
            refuse_other(path, differences(looked.header()), anyway=anyway)
        recording = Recording.reopen(path)
    try:
        with refusing_damage():
            header = recording.header()
            plan = plan_of(header)
            boat = Boat(plan.file, plan.method)
            warm_boat(boat)
            set_garbage_aside()
            history = bring_up(recording, plan, boat, layout_of(header))
            history.noted()  # a damaged past raises an error here, before anything begins
    except BaseException:
        recording.close()
        raise
    seconds = options.duration
    if seconds is not None and seconds <= boat.time:
        recording.close()
        raise ConfigError(f"--duration {seconds:g} s: this run is at {boat.time:g} s already")
    how = "time is frozen: say run" if options.frozen else "going on"
    if seconds is None and plan.duration is not None and plan.duration <= boat.time:
        how = "at its end; --duration goes on beyond it"
    click.echo(f"{path}: branch {recording.branch}, {boat.time:g} s; {how}", err=True)
    plan = plan if seconds is None else replace(plan, duration=seconds)
    begun = LastingParts(debriefing=debriefing, course=course)
    options = options_as_begun(options, path, header, boat)
    prepared = PreparedRun(plan, boat, history, str(path), begun, why_single(options))
    return run_following(fly_session(prepared, options), options, begun)


def options_as_begun(
    options: RunOptions, path: Path, header: Mapping[str, str], boat: Boat
) -> RunOptions:
    """Return the options with what the run was begun with.

    They are for the run and for what follows it, which is recorded beside it, in a course with the
    boat's own seed.
    """
    return replace(
        options,
        exercise=exercise_of(header) or None,
        trainee=options.trainee or trainees_of(header),
        width=header.get("width", options.width),
        seed=int(boat.state.seed),
        record=path.parent,
        given=options.given | {"seed"},
    )


def refuse_other(path: Path, found: list[str], *, anyway: bool) -> None:
    """Raise ConfigError naming what differs from the recording, unless the user insists."""
    if found and not anyway:
        raise ConfigError(
            f"{path.name}: would not be the same run; --anyway goes on all the same",
            *(f"{path.name}: {each}" for each in found),  # of which the last may not be told
        )


def count_exposure(recording: Recording, boat: Boat, layout: tuple[str, ...]) -> None:
    """Count again how long the periscope has shown, from the recorded states."""
    scope = periscope_of(boat)
    if scope is None or not scope.acts:
        return
    latest, present = boat.ticks, boat.records.state.copy()
    for flown in recording.flown(recording.branch):
        if flown.tick < latest and scope.at(flown.tick).out > 0.0:
            boat.restore(read_state(flown.state, layout, present))
            scope.write(boat.plain)
    boat.restore(present)


def bring_up(recording: Recording, plan: Plan, boat: Boat, layout: tuple[str, ...]) -> History:
    """Return the history of a boat brought to where its recording ends.

    It restores the last recorded state. Then it gives every order journalled since at its tick, so
    that no order is lost.
    """
    plan.start(boat)  # also what no state holds: the triggers armed
    recording.leave_shown()
    latest = recording.latest()
    boat.restore(read_state(latest.state, layout, boat.records.state))
    if boat.ticks != latest.tick:
        raise ConfigError(f"recording: its state of tick {latest.tick} is of another: damaged")
    restore_world(boat, recording, recording.branch, latest.after)
    count_exposure(recording, boat, layout)
    history = History(boat, recording, latest.after, latest.entry)
    with np.errstate(all="ignore"):
        for entry in recording.orders(recording.branch, latest.after):
            while history.tick < entry.tick:
                if status := boat.tick():
                    raise ConfigError(f"cannot be brought up: {boat.failure(status)}")
                history.ticked(history.tick)
            obey_anew(history, entry, plan.schedule)
    history.read_world_orders(recording.branch)
    return history


def obey_anew(history: History, entry: RecordedOrder, schedule: Sequence[ScheduledOrder]) -> None:
    """Have the boat obey an order of the journal that its state does not include.

    Where the program ended before it was answered, it is answered now: by the boat if it moves it,
    and else by the session that begins.
    """
    order = order_of(entry, schedule)
    if order is not None and order.name in BOAT_ORDERS and entry.accepted is not False:
        answer = obey_order(history.boat, order)
        if entry.accepted is None:
            refused = isinstance(answer, Refused)
            fact = NO_CREW_FACT if refused else ordered_fact(history.boat, order)
            history.answered(entry.id, answer, fact)
    elif entry.accepted is None:
        history.unanswered.append(entry)
    history.include(entry)
