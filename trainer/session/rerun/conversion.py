"""A recording made into a file for Rerun's viewer."""

import sys
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.world.world import world_of
from trainer.io.atomic_write import replacing
from trainer.io.recording.recording import Flown, Noted, Recording
from trainer.session.header import layout_of, plan_of
from trainer.session.rerun.batch import Batch, Block, Subject, Times, Told, Worked, states
from trainer.session.rerun.sinks import RrdFile
from trainer.session.world_orders import settle_world

ROWS: Final = 4096  # [ticks] written at a time


def write_record(recording: Recording, path: Path, branch: int) -> None:
    """Write a branch and the past that led to it, with what happened then. A file is replaced.

    ConfigError or RecordingError if it cannot be read, OSError if the file cannot be written.
    """
    header = recording.header()
    plan = plan_of(header)
    boat = Boat(plan.file, plan.method)
    boat.world = world_of(boat, plan.around)
    settle_world(boat, recording, branch, sys.maxsize)
    subject = Subject.of(plan, boat)
    parts = batches(recording, branch, layout_of(header), subject.step)
    first = next(parts)  # nothing is replaced where there is nothing to write
    with replacing(path) as made:
        file = RrdFile(made, subject)
        file.open()
        try:
            for batch in chain((first,), parts):
                file.write(batch)
        finally:
            file.close()


def batches(
    recording: Recording, branch: int, layout: tuple[str, ...], step: float
) -> Iterator[Batch]:
    """Yield the ticks that led to the end of a branch. The last of them has the events."""
    flown = recording.flown(branch)
    ends: dict[int, int] = {}
    while part := list(islice(flown, ROWS)):
        ends |= {each.branch: each.tick for each in part}
        yield Batch(block_of(part, layout, step), worked_of(part, step), told_of([], step))
    told = [each for each in recording.first_events() if each.tick <= ends.get(each.branch, -2) + 1]
    yield Batch(block_of([], layout, step), worked_of([], step), told_of(told, step))


def block_of(part: list[Flown], layout: tuple[str, ...], step: float) -> Block:
    """Return the states of some ticks."""
    return Block(
        times_of(part, step),
        states([each.state for each in part], layout),
        np.array([each.branch for each in part], np.int64),
        np.zeros(len(part), np.bool_),
    )


def worked_of(part: list[Flown], step: float) -> Worked:
    """Return the timings of those ticks that have any."""
    timed = [each for each in part if each.work is not None]
    return Worked(
        times_of(timed, step),
        np.array([each.lateness for each in timed], np.float64),
        np.array([each.work for each in timed], np.float64),
    )


def told_of(events: list[Noted], step: float) -> Told:
    """Return what was told."""
    return Told(
        times_of(events, step),
        tuple(each.kind for each in events),
        tuple(each.text for each in events),
    )


def times_of(rows: Sequence[Flown | Noted], step: float) -> Times:
    """Return when ticks or events were."""
    ticks = [each.tick for each in rows]
    return Times.of(ticks, [tick * step for tick in ticks])
