"""Faults of three events in a row, by which plain seeds and exploring are compared.

A chain is three milestones, which one process has to reach in this order. It is drawn by a seed
among those that no plain seed has come through, though some came through its first two events and
some through its last two. At the third the boat is changed, which no law allows.
"""

# ruff: noqa: SLF001  a fault lies in private parts

import contextlib
import itertools
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from random import Random
from typing import Final

import pytest

from simulation.drawing import draw_script
from simulation.exploring import Explorer
from simulation.laws import Docket
from simulation.milestones import MILESTONES, Log
from simulation.play import Change, play
from simulation.script import Script
from trainer.session.session import Session

EVENTS: Final = 3
CHAINS: Final = 10  # that are compared
LONGEST_S: Final = 5.0  # that a process of a plain script lives
MIN_ROWS: Final = 20  # processes, of whose milestones chains are drawn
FAR_SEEDS: Final = 100_000  # from where exploring draws, so that it has no plain script's luck
Chain = tuple[str, ...]


@dataclass
class Track:
    """How far one process has come in each chain, and which chains it came through."""

    chains: Sequence[Chain]
    passed: set[Chain] = field(default_factory=set)
    _begun: int = -1  # the process
    _events: dict[Chain, int] = field(default_factory=dict)

    def see(self, life: int, name: str) -> list[Chain]:
        """Note a milestone; return the chains that end with it."""
        if life != self._begun:  # a script has processes one after the other
            self._begun, self._events = life, dict.fromkeys(self.chains, 0)
        ends = []
        for chain, events in self._events.items():
            if events < len(chain) and chain[events] == name:
                self._events[chain] = events + 1
                if events + 1 == len(chain):
                    ends.append(chain)
        self.passed.update(ends)
        return ends


def draw_chains(rows: Sequence[Sequence[str]], count: int, seed: int) -> list[Chain]:
    """Draw chains of the milestones that processes reached for the first time, in order."""
    pairs = Counter(pair for row in rows for pair in set(itertools.combinations(row, 2)))
    whole = {triple for row in rows for triple in itertools.combinations(row, EVENTS)}
    after: dict[str, list[str]] = {}
    for first, second in pairs:
        after.setdefault(first, []).append(second)
    chains = [
        (first, second, third)
        for first, second in sorted(pairs)
        for third in sorted(after.get(second, ()))
        if third != first and (first, second, third) not in whole
    ]
    return Random(seed).sample(chains, count)  # noqa: S311  no secrets


def rows_of(docket: Docket) -> list[list[str]]:
    """Return the milestones that each process of a script reached, in order."""
    rows: dict[int, list[str]] = {}
    for name, point in docket.log.reached.items():
        if point and name in MILESTONES:
            rows.setdefault(point.life, []).append(name)
    return list(rows.values())


def tracked(track: Track, strike: Callable[[Session], object] = lambda _: None) -> Change:
    """Return the change that tells a track of milestones. A session is struck at the third."""

    @contextlib.contextmanager
    def change() -> Iterator[None]:
        sessions: list[Session] = []
        start, see = Log.see_start, Log._see

        def start_noted(log: Log, session: Session) -> None:
            sessions[:] = [session]
            start(log, session)

        def see_noted(log: Log, name: str) -> None:
            see(log, name)
            if track.see(log.life, name) and sessions:
                strike(sessions[0])

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Log, "see_start", start_noted)
            patch.setattr(Log, "_see", see_noted)
            yield

    return change


def plant(chain: Chain) -> Change:
    """Return the fault that moves the boat where a process has come through a chain."""

    def move(session: Session) -> None:
        session.boat.state.z += 0.01

    return tracked(Track([chain]), move)


def hunt(
    chains: Sequence[Chain],
    draw: Callable[[], Script],
    learn: Callable[[Script, Docket], object],
    budget: float,
) -> tuple[dict[Chain, float], int]:
    """Play scripts for so long [s of the processor].

    Return when the first came through each chain, and how many scripts were played.
    """
    found: dict[Chain, float] = {}
    begun, scripts = time.process_time(), 0
    while time.process_time() - begun < budget and len(found) < len(chains):
        script, track = draw(), Track([chain for chain in chains if chain not in found])
        learn(script, play(script, tracked(track)))
        scripts += 1
        found.update(dict.fromkeys(track.passed, time.process_time() - begun))
    return found, scripts


def compare(seconds: float, seed: int) -> Iterator[str]:
    """Yield a line for each chain: when each way came through it.

    Each way has so long [s of the processor]; half of that is spent on drawing the chains.
    """
    scripts = map(partial(draw_script, longest=LONGEST_S), itertools.count(seed))
    rows: list[list[str]] = []
    begun = time.process_time()
    while time.process_time() - begun < seconds / 2.0 or len(rows) < MIN_ROWS:
        rows += rows_of(play(next(scripts)))
    chains = draw_chains(rows, CHAINS, seed)
    plain, plain_scripts = hunt(chains, partial(next, scripts), lambda *_: None, seconds)
    explorer = Explorer(seed + FAR_SEEDS, LONGEST_S)

    def learn(script: Script, docket: Docket) -> None:
        explorer.learn(script, {n: point for n, point in docket.log.reached.items() if point})

    explored, explored_scripts = hunt(chains, explorer.draw, learn, seconds)
    for chain in chains:
        times = (found.get(chain) for found in (plain, explored))
        plain_s, explored_s = ("never" if each is None else f"{each:.1f} s" for each in times)
        yield f"plain {plain_s:>8}, exploring {explored_s:>8}: {', then '.join(chain)}"
    yield (
        f"{len(plain)} of {CHAINS} in {plain_scripts} plain scripts, {len(explored)} in "
        f"{explored_scripts} explored ones"
    )
