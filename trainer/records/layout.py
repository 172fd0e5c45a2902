"""Which number of a state record is what: here, and in a recording made by another version."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.config import ConfigError
from trainer.core.kernel import Record
from trainer.core.state import STATE


class Unlike(NamedTuple):
    """How two states differ: the first number that does, its two values, and how many do."""

    name: str
    recorded: float
    flown: float
    numbers: int


def _layout() -> tuple[str, ...]:
    """Return the name of each number of the state: its own, or its block's with the place in it."""
    names = [""] * (STATE.itemsize // 8)
    single: dict[str, int] = {}
    for name, place in (STATE.fields or {}).items():
        shape, first = place[0].shape, place[1] // 8
        if not shape:
            single[name] = first
        elif name != "whole":
            for i, index in enumerate(np.ndindex(*shape)):
                names[first + i] = f"{name}[{','.join(map(str, index))}]"
    for name, first in single.items():
        names[first] = name
    return tuple(names)


LAYOUT: Final = _layout()


def numbers_of(state: bytes, layout: Sequence[str]) -> NDArray[np.float64]:
    """Return the numbers of a recorded state; ConfigError if it is not of that layout."""
    if len(state) != 8 * len(layout):
        raise ConfigError(f"a state of {len(state)} bytes, not of {8 * len(layout)}: damaged")
    return np.frombuffer(state, dtype=np.float64)


def read_state(state: bytes, layout: Sequence[str], standing: Record) -> Record:
    """Return the state that ``layout`` describes as a record of this version.

    Numbers that it lacks are as in ``standing``. ConfigError if it is not of that layout.
    """
    numbers = numbers_of(state, layout)
    places = {name: i for i, name in enumerate(LAYOUT)}
    record = standing.copy()
    for name, number in zip(layout, numbers, strict=True):
        if name in places:
            record["whole"][0, places[name]] = number
    return record


def unlike(recorded: bytes, flown: bytes) -> Unlike | None:
    """Return how two states of this version differ, bit by bit; None if they do not."""
    bits = [np.frombuffer(state, dtype=np.uint64) for state in (recorded, flown)]
    places = np.flatnonzero(bits[0] != bits[1])
    if not places.size:
        return None
    first = int(places[0])
    values = [float(np.frombuffer(state, dtype=np.float64)[first]) for state in (recorded, flown)]
    return Unlike(LAYOUT[first], values[0], values[1], int(places.size))
