"""The order ``trainer resume``: a recorded run goes on where its recording ends.

The boat gets the last recorded state, and the orders that were given after it once more.
ConfigError if the vessel file, the exercise or the program has changed since, unless the user
insists, because the run would go on differently from how it began.
"""

import contextlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import click
import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.crew_orders import ordered_fact
from trainer.boat.helm import obey_order
from trainer.boat.world.scope import periscope_of
from trainer.config.extras import require_library
from trainer.config.files import ConfigError
from trainer.core.kernel import Record
from trainer.core.state import STATE
from trainer.io.orders.grammar import Refused
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.paths import further_paths
from trainer.io.recording.facts import NO_CREW_FACT, BranchCause
from trainer.io.recording.recording import RecordedOrder, Recording, TakenError
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
from trainer.session.past.layout import LAYOUT, numbers_of, read_state
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan
from trainer.session.run import (
    MAX_NAME_TRIES,
    LastingParts,
    PreparedRun,
    course_of,
    discard_recording,
    fly_session,
    run_following,
    why_single,
)


def resume_boat(
    path: Path, options: RunOptions, debriefing: DebriefSource | None = None, *, anyway: bool
) -> int:
    """Go on with the recording at ``path``, and what follows it; return the exit code.

    One of another layout stays as it is, and a copy in today's layout goes on beside it.
    """
    if options.rrd is not None:
        require_library("rerun", "--rrd")
    course = course_of(options)
    made: Path | None = None  # such a copy
    with refusing_damage():
        with contextlib.closing(Recording.look(path)) as looked:  # what is refused stays as it is
            header = looked.header()
            refuse_other(path, differences(header), anyway=anyway)
            plan, layout = plan_of(header), layout_of(header)
            for state in looked.checked_states():
                numbers_of(state, layout)
            boat = Boat(plan.file, plan.method)
            refuse_end(options.duration, looked, boat.method.step)
        if layout == LAYOUT:
            recording = Recording.reopen(path)
        else:
            plan.start(boat)
            made, recording = carry_over(path, layout, boat.records.state)
            why = "its states are of another version"
            click.echo(f"{path}: {why}: it stays as it is, and {made} goes on", err=True)
    kept, seconds = made or path, options.duration
    flown_from: int | None = None  # [ticks]
    begun = LastingParts(debriefing=debriefing, course=course)
    try:
        with contextlib.closing(recording):
            warm_boat(boat)
            set_garbage_aside()
            with refusing_damage():
                history = bring_up(recording, plan, boat)
                history.noted()  # a damaged past raises an error here, before anything begins
            flown_from = boat.ticks
            how = "time is frozen: say run" if options.frozen else "going on"
            if seconds is None and plan.duration is not None and plan.duration <= boat.time:
                how = "at its end; --duration goes on beyond it"
            click.echo(f"{kept}: branch {recording.branch}, {boat.time:g} s; {how}", err=True)
            plan = plan if seconds is None else replace(plan, duration=seconds)
            options = options_as_begun(options, path, header, boat)
            prepared = PreparedRun(plan, boat, history, str(kept), begun, why_single(options))
            ended = fly_session(prepared, options)
    except ConfigError:
        if boat.ticks == flown_from or flown_from is None:
            discard_recording(made)  # it was begun for a run that is refused
        raise
    return run_following(ended, options, begun)


def refuse_end(seconds: float | None, recording: Recording, step: float) -> None:
    """Raise ConfigError if a run is to end where it is already, or before."""
    here, ticks = recording.branches()[-1], recording.latest().tick
    if here.cause is BranchCause.SHOWN:
        ticks = here.tick  # where the crew goes on
    elif orders := recording.orders(here.id):
        ticks = max(ticks, orders[-1].tick)
    if seconds is not None and seconds <= ticks * step:
        raise ConfigError(f"--duration {seconds:g} s: this run is at {ticks * step:g} s already")


def carry_over(path: Path, layout: tuple[str, ...], standing: Record) -> tuple[Path, Recording]:
    """Return a new recording beside one of another layout: all it has, in today's layout.

    Numbers that a state lacks come from ``standing``. RecordingError if it cannot be made.
    """
    header = {"layout": json.dumps(LAYOUT)}
    for kept in islice(further_paths(path), MAX_NAME_TRIES):
        with contextlib.suppress(TakenError):
            return kept, Recording.create_converted(
                kept, path, header, lambda state: read_state(state, layout, standing).tobytes()
            )
    raise ConfigError(f"{path}: {MAX_NAME_TRIES} names like it are taken")


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


def count_exposure(recording: Recording, boat: Boat) -> None:
    """Count again how long the periscope has shown, from the recorded states."""
    scope = periscope_of(boat)
    if scope is None or not scope.acts:
        return
    latest, present = boat.ticks, boat.records.state.copy()
    for flown in recording.flown(recording.branch):
        if flown.tick < latest and scope.at(flown.tick).out > 0.0:
            boat.restore(np.frombuffer(flown.state, STATE))
            scope.write(boat.plain)
    boat.restore(present)


def bring_up(recording: Recording, plan: Plan, boat: Boat) -> History:
    """Return the history of a boat brought to where its recording ends.

    It restores the last recorded state. Then it gives every order journalled since at its tick, so
    that no order is lost.
    """
    plan.start(boat)  # also what no state holds: the triggers armed
    recording.leave_shown()
    latest = recording.latest()
    boat.restore(np.frombuffer(latest.state, STATE))
    if boat.ticks != latest.tick:
        raise ConfigError(f"recording: its state of tick {latest.tick} is of another: damaged")
    restore_world(boat, recording, recording.branch, latest.after)
    count_exposure(recording, boat)
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
