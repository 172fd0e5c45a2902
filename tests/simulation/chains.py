"""Faults of three events in a row, by which plain seeds and exploring are compared.

A chain is three milestones, which one process has to reach in this order. Each was chosen because
a session has to keep all three in mind: what was left, what is ahead, what was taken over. At the
third the boat is changed, which no law allows.
"""

# ruff: noqa: SLF001  a fault lies in private parts

import contextlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import pytest

from simulation.drawing import draw_script
from simulation.exploring import NUMBERS, Explorer, Row, processor_s
from simulation.milestones import Log
from simulation.play import Change, play
from simulation.script import Script
from trainer.session.session import Session

Chain = tuple[str, str, str]
Timed = tuple[float, Iterable[Row]]  # [s] of the processor when it was played, and its processes
CHAINS: Final[tuple[Chain, ...]] = (
    (
        "L3: a take-over in a freeze",
        "L17: a plan is due in the tick of a jump",
        "L17: a kill with plans ahead",
    ),
    (
        "L12: a restore with a casualty ramping",
        "L1: a mark on a branch that is left",
        "L3: a take-over in a freeze",
    ),
    (
        "L3: a jump while the disk is full",
        "L3: a take-over while time runs",
        "L12: a restore brings a casualty back",
    ),
    (
        "L12: a snapshot in a replay",
        "L12: a restore with a casualty ramping",
        "L17: a jump brings plans back",
    ),
    (
        "L3: a replay within a replay",
        "L3: a take-over in a freeze",
        "L17: a plan comes",
    ),
    (
        "L6: the end taken back by a restore",
        "L17: a plan comes",
        "L6: an exercise ends by its time",
    ),
    (
        "L7: command changes hands",
        "L3: a take-over while time runs",
        "L17: a plan is due in the tick of a jump",
    ),
    (
        "L14: a second session is refused",
        "L3: a jump while another program writes",
        "L3: a take-over in a freeze",
    ),
    (
        "L8: the machine sleeps",
        "L3: a replay ends by itself",
        "L12: a restore brings a casualty back",
    ),
    (
        "L2: a take-over is refused where nothing can be read",
        "L3: a take-over in a freeze",
        "L3: a jump forward in time",
    ),
    (
        "L6: a jump while marks are made",
        "L12: a snapshot in a replay",
        "L6: again after the end",
    ),
    (
        "L8: the time of day is set",
        "L3: a take-over in a freeze",
        "L12: a restore with a casualty ramping",
    ),
    (
        "L11: a page comes in a replay",
        "L3: a take-over while time runs",
        "L17: a jump brings plans back",
    ),
    (
        "L1: a mark in a replay",
        "L3: a jump while the disk is full",
        "L3: a kill in a replay",
    ),
    (
        "L12: a restore of what an earlier process kept",
        "L17: a plan is due in the tick of a jump",
        "L3: a jump out of a replay",
    ),
)
PLAIN_S: Final = 5.0  # that a process of a plain script lives
FAR_SEEDS: Final = 100_000  # from where exploring draws, so that it has no plain script's luck


class Find(NamedTuple):
    """When a chain was first come through."""

    seconds: float  # of the processor
    scripts: int


def comes_through(row: Sequence[str], chain: Chain) -> bool:
    """Return whether a process that reached these milestones came through a chain."""
    left = iter(row)
    return all(event in left for event in chain)


@dataclass
class Track:
    """The milestones of each process of a script, in order."""

    rows: dict[int, list[str]] = field(default_factory=dict)

    def see(self, life: int, name: str) -> None:
        """Note a milestone of a process."""
        if name in NUMBERS:
            self.rows.setdefault(life, []).append(name)


def plant(chain: Chain) -> Change:
    """Return the fault that moves the boat where a process has come through a chain."""

    @contextlib.contextmanager
    def change() -> Iterator[None]:
        sessions: list[Session] = []
        track, start, see = Track(), Log.see_start, Log._see

        def start_noted(log: Log, session: Session) -> None:
            sessions[:] = [session]
            start(log, session)

        def see_noted(log: Log, name: str) -> None:
            see(log, name)
            track.see(log.life, name)
            if name == chain[-1] and sessions and comes_through(track.rows[log.life], chain):
                sessions[0].boat.state.z += 0.01

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Log, "see_start", start_noted)
            patch.setattr(Log, "_see", see_noted)
            yield

    return change


def plain_rows(seed: int) -> Iterator[Timed]:
    """Play plain scripts without end; yield the milestones of the processes of each."""
    while True:
        rows = rows_of(draw_script(seed, PLAIN_S))
        yield processor_s(), rows
        seed += 1


def explored_rows(seed: int) -> Iterator[Timed]:
    """Play scripts that go on from one another; yield the milestones of each."""
    return ((leaf.at, leaf.rows) for leaf in Explorer(seed + FAR_SEEDS, PLAIN_S).explore())


def rows_of(script: Script) -> list[Row]:
    """Play a script; return the milestones of its processes."""
    track = Track()

    @contextlib.contextmanager
    def change() -> Iterator[None]:
        see = Log._see

        def see_noted(log: Log, name: str) -> None:
            see(log, name)
            track.see(log.life, name)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Log, "_see", see_noted)
            yield

    play(script, change)
    return [tuple(row) for row in track.rows.values()]


def hunt(scripts: Iterator[Timed], seconds: float) -> tuple[dict[Chain, Find], int]:
    """Play scripts for so long [s of the processor].

    Return when the first came through each chain, and how many scripts were played.
    """
    found: dict[Chain, Find] = {}
    begun, played = processor_s(), 0
    while processor_s() - begun < seconds and len(found) < len(CHAINS):
        at, rows = next(scripts)
        played += 1
        now = Find(at - begun, played)
        for chain in CHAINS:
            if chain not in found and any(comes_through(row, chain) for row in rows):
                found[chain] = now
    return found, played


def compare(seconds: float, seed: int) -> Iterator[str]:
    """Yield a line for each chain: when each way came through it. Each has so long [s]."""
    rows_of(draw_script(seed, PLAIN_S))  # what is compiled once is no part of either
    plain, plain_scripts = hunt(plain_rows(seed), seconds)
    explored, explored_scripts = hunt(explored_rows(seed), seconds)
    for chain in CHAINS:
        finds = (found.get(chain) for found in (plain, explored))
        told = ["never" if find is None else f"{find.seconds:.1f} s" for find in finds]
        yield f"plain {told[0]:>9}, exploring {told[1]:>9}: {', then '.join(chain)}"
    yield (
        f"of {len(CHAINS)}, {len(plain)} in {plain_scripts} plain scripts, {len(explored)} in "
        f"{explored_scripts} explored ones, {seconds:g} s each"
    )
