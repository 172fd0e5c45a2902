"""Scripts that go on from where others came for the first time.

A script reaches a milestone, or two of them in an order that none had reached. Up to there it is
played again, exactly, and goes on with other chance. What was seldom reached, and seldom gone on
from, is chosen more often (A. Ecoffet and others, *Nature* 590, 2021: first return, then explore).
"""

from collections import Counter
from dataclasses import dataclass, field
from random import Random
from typing import Final

from simulation.drawing import draw_script, redraw
from simulation.milestones import MILESTONES
from simulation.script import Point, Script

PLAIN_SHARE: Final = 0.2  # [-] of scripts begin from nothing (estimate)
NEAR_S: Final = 4.0  # that a process goes on at most from a place (estimate)
CHEAPER: Final = 0.7  # [-] of a way to a place, from which on another takes its place (estimate)

Key = tuple[str, ...]  # one milestone, or two in the order in which they were reached


@dataclass
class Place:
    """Where a script came to what was new then."""

    script: Script
    point: Point
    chosen: int = 0  # how often it was gone on from

    @property
    def seconds(self) -> float:
        """Return how long [s] it takes to come here."""
        before = self.script.lives[: self.point.life - 1]
        return sum(life.seconds for life in before) + self.point.seconds


@dataclass
class Explorer:
    """What was reached so far, and what is tried next."""

    seed: int
    longest: float  # that a process of a plain script lives [s]
    counts: Counter[Key] = field(default_factory=Counter)
    places: dict[Key, Place] = field(default_factory=dict)
    _tried: int = 0
    _dice: Random = field(init=False)

    def __post_init__(self) -> None:
        self._dice = Random(f"{self.seed}/explorer")  # noqa: S311  no secrets

    def draw(self) -> Script:
        """Return the next script: a new one, or one that goes on from a place."""
        self._tried += 1
        dice = self._dice
        if not self.places or dice.random() < PLAIN_SHARE:
            return draw_script(self.seed + self._tried, self.longest)
        keys = list(self.places)
        weights = [
            1.0 / (self.counts[key] * (1 + place.chosen) * (1.0 + place.seconds))
            for key, place in self.places.items()
        ]
        place = self.places[dice.choices(keys, weights)[0]]
        place.chosen += 1
        return redraw(place.script, place.point, self.seed + self._tried, NEAR_S)

    def learn(self, script: Script, reached: dict[str, Point]) -> list[Key]:
        """Note what a script reached, in order; return what no script had reached before."""
        first, passed = [], list[str]()
        for name, point in reached.items():
            if name not in MILESTONES:
                continue
            for key in ((name,), *((before, name) for before in passed)):
                self.counts[key] += 1
                here, known = Place(script, point), self.places.get(key)
                if known is None:
                    first.append(key)
                if known is None or here.seconds < CHEAPER * known.seconds:
                    here.chosen = known.chosen if known else 0
                    self.places[key] = here
            passed.append(name)
        return first
