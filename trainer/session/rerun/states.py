"""Lanes: what is so from one moment to another, as words under a time line."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.sea_orders import PARTS
from trainer.core.casualties import KINDS
from trainer.core.state import CASUALTIES, VALVES
from trainer.core.surfaces import SURFACES
from trainer.session.rerun.batch import Block, Whole

SLOTS: Final = tuple(f"casualty[{i}]" for i in range(CASUALTIES))
LEFT: Final = tuple(f"casualty_ticks[{i}]" for i in range(CASUALTIES))
ACTING, CLEARED = "acting", "being cleared"
BLOWS: Final = ("", "", " (emergency)")  # by the position of a blow valve


AUTO, HAND, BROKEN, MENDING = 0x56B4E9FF, 0xE69F00FF, 0xD55E00FF, 0xCC79A7FF


@dataclass(frozen=True)
class Lane:
    """A code for each tick, and the word for each code. "" while there is nothing to show."""

    path: str
    codes: Callable[[Block], Whole]
    word: Callable[[int], str]
    colours: Mapping[str, int] = field(default_factory=dict)  # of words that have their own


def lanes_of(boat: Boat) -> tuple[Lane, ...]:
    """Return the lanes of the boat; those of casualties come with `casualty_lanes`."""
    steered = [name for name in SURFACES if boat.toward[name]]
    lanes = [Lane("lanes/run", _run, _describe_run)]
    lanes += [_by_hand(name) for name in (*steered, "speed")]
    lanes.append(_several("lanes/held", tuple(f"held_{part}" for part in PARTS), PARTS))
    if boat.vessel.fitted:
        lanes.append(
            Lane("lanes/hover", lambda block: _whole(block["hover"]), ("", "on").__getitem__)
        )
        lanes.append(Lane("lanes/blow", _blow, _describe_blow))
        lanes.append(_several("lanes/vents", tuple(f"vent_{name}" for name in VALVES), VALVES))
    return tuple(lanes)


def casualty_lanes(block: Block) -> list[Lane]:
    """Return a lane for each kind of casualty that is there in the block."""
    kinds = np.unique(block.several(*SLOTS)).astype(int)
    return [_casualty(kind) for kind in kinds.tolist() if kind]


def _casualty(kind: int) -> Lane:
    """Return the lane of a kind of casualty."""

    def codes(block: Block) -> Whole:
        here = block.several(*SLOTS) == kind
        clearing = here & (block.several(*LEFT) < 0.0)
        acting = np.any(here & ~clearing, axis=1)
        return np.where(acting, 2, np.where(np.any(clearing, axis=1), 1, 0))

    word = ("", CLEARED, ACTING).__getitem__
    return Lane(f"lanes/{KINDS[kind - 1]}", codes, word, {CLEARED: MENDING, ACTING: BROKEN})


def _whole(column: np.ndarray) -> Whole:
    return column.astype(np.int64)


def _run(block: Block) -> Whole:
    return 2 * block.branch + block.replaying


def _describe_run(code: int) -> str:
    return f"{'replay of ' if code % 2 else ''}branch {code // 2}"


def _by_hand(what: str) -> Lane:
    """Return whether something is steered by hand."""
    place = f"{what}_by_hand"
    word = ("auto", "hand").__getitem__
    colours = {"auto": AUTO, "hand": HAND}
    return Lane(f"lanes/{what}", lambda block: _whole(block[place]), word, colours)


def _several(path: str, places: tuple[str, ...], names: tuple[str, ...]) -> Lane:
    """Return which of several things are so, each a bit of the code."""
    bits = 2 ** np.arange(len(places))

    def word(code: int) -> str:
        return ", ".join(name for i, name in enumerate(names) if code & 1 << i)

    return Lane(path, lambda block: _whole((block.several(*places) > 0.0) @ bits), word)


def _blow(block: Block) -> Whole:
    positions = block.several(*(f"blow_{name}" for name in VALVES))
    return _whole(positions @ 3.0 ** np.arange(len(VALVES)))


def _describe_blow(code: int) -> str:
    """Return which blow valves are open; each is a digit of the code to the base of three."""
    positions = [(name, code // 3**i % 3) for i, name in enumerate(VALVES)]
    return ", ".join(name + BLOWS[position] for name, position in positions if position)
