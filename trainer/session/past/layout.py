"""The names of a recorded state's numbers, so that other versions can read them.

A state is recorded as bytes. The recording's header holds its layout, the name of each number in
order. A later version, whose state has other numbers or another order, reads the numbers by name.
``changes`` lists, line by line, how a file differs from its recorded text.
"""

import re
from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher
from itertools import zip_longest
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Record
from trainer.core.state import STATE

MAX_TOLD_LINES: Final = 10  # changed lines of one file that are listed
MAX_SHOWN_LETTERS: Final = 60  # [characters] of a line or value shown
SETTING_PATTERN: Final = re.compile(r"\s*([\w.\"-]+)\s*=\s*(.*)")


class StateDifference(NamedTuple):
    """The difference of two states: the first number, its two values, and the count."""

    name: str
    recorded: float
    flown: float
    numbers: int


def _layout() -> tuple[str, ...]:
    """Return the name of each number: its own, or its block's and index, as ``motion[0]``.

    ``whole`` is the state as one block over the same memory, and names nothing.
    """
    names = [""] * (STATE.itemsize // 8)
    single: dict[str, int] = {}
    for name, field in (STATE.fields or {}).items():
        shape, first = field[0].shape, field[1] // 8
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
    """Return the numbers of a recorded state; ConfigError if ``layout`` does not fit it."""
    if len(state) != 8 * len(layout):
        raise ConfigError(f"a state of {len(state)} bytes, not of {8 * len(layout)}: damaged")
    return np.frombuffer(state, dtype=np.float64)


def read_state(state: bytes, layout: Sequence[str], standing: Record) -> Record:
    """Return the state that ``layout`` describes as a record of this version.

    Numbers that it lacks come from ``standing``. ConfigError if ``layout`` does not fit it.
    """
    numbers = numbers_of(state, layout)
    offsets = {name: i for i, name in enumerate(LAYOUT)}
    record = standing.copy()
    for name, number in zip(layout, numbers, strict=True):
        if name in offsets:
            record["whole"][0, offsets[name]] = number
    if "through_north" not in layout:  # there were no currents then
        record["through_north"], record["through_east"] = record["xdot"], record["ydot"]
    return record


def state_difference(recorded: bytes, flown: bytes) -> StateDifference | None:
    """Return the first number whose bits differ in two states of this version. None: all equal."""
    bits = [np.frombuffer(state, dtype=np.uint64) for state in (recorded, flown)]
    indices = np.flatnonzero(bits[0] != bits[1])
    if not indices.size:
        return None
    first = int(indices[0])
    values = [float(np.frombuffer(state, dtype=np.float64)[first]) for state in (recorded, flown)]
    return StateDifference(LAYOUT[first], values[0], values[1], int(indices.size))


def changes(file: str, now: str, was: str) -> list[str]:
    """Return a text for each changed line, with its number and the file's name."""
    lines = [f"{file} {text}" for text in _changes(now.split("\n"), was.split("\n"))]
    more = len(lines) - MAX_TOLD_LINES
    return [*lines[:MAX_TOLD_LINES], f"{file}: and {more} more lines"] if more > 0 else lines


def _changes(now: list[str], was: list[str]) -> Iterator[str]:
    """Yield each change in words, beginning with the number of its line."""
    for what, i, i_end, k, k_end in SequenceMatcher(None, was, now).get_opcodes():
        if what == "equal":
            continue
        numbered = enumerate(now[k:k_end], start=k + 1)
        gone = enumerate(was[i:i_end], start=i + 1)
        for new, old in zip_longest(numbered, gone):
            if new is None:
                yield f"line {old[0]} as recorded is gone: {_short(old[1])}"
            elif old is None:
                yield f"line {new[0]} is new: {_short(new[1])}"
            else:
                yield f"line {new[0]}: {_describe_change(new[1], old[1])}"


def _describe_change(new: str, old: str) -> str:
    """Return in words how one line differs from the recorded one."""
    if new.split() == old.split():
        return "differs in blanks only"
    ends = new.rpartition("#"), old.rpartition("#")
    if ends[0][1:] == ends[1][1:] and ends[0][1]:  # the same comment
        new, old = ends[0][0], ends[1][0]
    settings = SETTING_PATTERN.fullmatch(new), SETTING_PATTERN.fullmatch(old)
    if settings[0] and settings[1] and settings[0][1] == settings[1][1]:
        return f"{settings[0][1]} = {_short(settings[0][2])} was {_short(settings[1][2])}"
    return f"{_short(new)} was {_short(old)}"


def _short(text: str) -> str:
    """Return a line in printable ASCII, cut to a readable length."""
    plain = text.strip().encode("unicode_escape").decode("ascii") or "an empty line"
    return plain if len(plain) <= MAX_SHOWN_LETTERS else plain[: MAX_SHOWN_LETTERS - 3] + "..."
