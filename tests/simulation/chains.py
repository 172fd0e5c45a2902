"""Faults that need three events in a row, by which plain seeds and exploring are compared.

A chain is three milestones, which one process has to reach in this order. It is drawn by a seed
among those that no plain seed has come through, though some came through its first two events and
some through its last two. At the third the boat is changed, which no law allows.
"""

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Final

EVENTS: Final = 3
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
        if life != self._begun:
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
