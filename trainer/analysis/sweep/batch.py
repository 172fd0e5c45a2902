"""Some members of a study, their results, and the functions that find these."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.sweep.draws import Draws
from trainer.analysis.sweep.outputs import Output
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers


@dataclass(frozen=True)
class Batch:
    """Members in their order."""

    members: NDArray[np.int64]
    seeds: NDArray[np.int64]
    drawn: dict[str, NDArray[Any]]  # by variable: numbers or words
    outputs: Numbers  # [member, output]; NaN: never came to that
    troubles: tuple[str | None, ...]  # why there is nothing of a member

    def told(self, place: int, names: Sequence[str]) -> dict[str, Any]:
        """Return all about one member by the result's columns. None for what it never came to."""
        numbers = [None if np.isnan(x) else float(x) for x in self.outputs[place]]
        return {
            "member": int(self.members[place]),
            "seed": int(self.seeds[place]),
            **member(self.drawn, place),
            **dict(zip(names, numbers, strict=True)),
            "trouble": self.troubles[place],
        }


class Subject(Protocol):
    """The common part of every member of a study."""

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Return what is kept of each member."""
        ...

    @property
    def chunk(self) -> int:
        """Return how many members are flown, and kept, at once."""
        ...

    def batch(self, first: int, count: int) -> Batch:
        """Return what becomes of ``count`` members from ``first`` on."""
        ...


def member(drawn: Mapping[str, NDArray[Any]], place: int) -> dict[str, Any]:
    """Return numbers and words of one member as Python's own."""
    return {
        name: values[place] if isinstance(values[place], str) else float(values[place])
        for name, values in drawn.items()
    }


def fly_each(
    draws: Draws,
    first: int,
    count: int,
    width: int,
    fly: Callable[[dict[str, Any], int], Sequence[float]],
) -> Batch:
    """Return members flown one by one.

    ``fly`` takes a member's numbers and seed, and returns ``width`` numbers; its ConfigError says
    why there are none.
    """
    drawn, seeds = draws.drawn(first, count), draws.seeds(first, count)
    outputs = np.full((count, width), np.nan)
    troubles: list[str | None] = [None] * count
    for i in range(count):
        try:
            outputs[i] = fly(member(drawn, i), int(seeds[i]))
        except ConfigError as wrong:
            troubles[i] = wrong.problems[0]
    return Batch(np.arange(first, first + count), seeds, drawn, outputs, tuple(troubles))
