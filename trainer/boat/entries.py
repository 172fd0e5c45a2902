"""The kernels that are called from outside the core, by what they take and answer.

``machine_code`` calls the shipped object by this table, ``export/lowering`` makes it, and the
modules for a browser and for C have some of its rows. Arguments go by address, or as numbers of
double precision, also where the kernel takes whole ones. A kernel is called with records of the
kinds written here, because numba would compile it anew for others, while a user waits.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.platforms import ROOMS
from trainer.core import full
from trainer.core.actuators import move_surfaces
from trainer.core.autopilot.autopilot import stand_by_all
from trainer.core.ballast.ballast import balance, start_ballast
from trainer.core.ballast.buoyancy import segment
from trainer.core.ballast.hover import is_hovering, wanted_pump
from trainer.core.casualties import begin, end, instruments
from trainer.core.current import north_and_east
from trainer.core.digest import digest_sources, imported_sources
from trainer.core.entry import LOOKOUT, RULE_COLUMNS, fly, sail, steer, tick
from trainer.core.envelope import substeps
from trainer.core.integrators import advance
from trainer.core.noise import gaussian_pair
from trainer.core.propulsion import answer_telegraph
from trainer.core.rates import rates
from trainer.core.readings import READINGS, write_readings
from trainer.core.scheme import SCHEME
from trainer.core.sea.cosine_sum import prepare_sum
from trainer.core.sea.filter_1969 import corner
from trainer.core.sea.forces import suction, wave_forces
from trainer.core.sea.free_surface import (
    deck_height,
    height_above_water,
    sail_height,
)
from trainer.core.sea.sea import TAPER, order_sea, write_elevations
from trainer.core.soundings import sound
from trainer.core.start import level_flight, set_out
from trainer.core.state import SCRATCH, STATE
from trainer.core.trim import trim
from trainer.core.update import lost, outside, update
from trainer.core.vessel import COMPACT, VESSEL

Kind = Any  # as ``Entry`` says
GIVEN_SIZE: Final = 0  # a size that each call gives, after all other arguments
GIVEN_ROW: Final = (GIVEN_SIZE,)
GIVEN_ROWS: Final = (GIVEN_SIZE, GIVEN_SIZE)
SIX_NUMBERS: Final = (6,)
BOAT_RECORDS: Final = (VESSEL, COMPACT, SCHEME, STATE, SCRATCH)
NUMBER_PAIR: Final = tuple[float, float]


@dataclass(frozen=True)
class RecordRow:
    """The kind of many records at an address; each call gives how many."""

    dtype: np.dtype


class Entry(NamedTuple):
    """A kernel, and the kinds of its arguments and of its answer.

    A kind is the record at an address, a row of records, ``float``, ``int``, or the shape of
    numbers at an address.
    """

    kernel: Any
    kinds: tuple[Kind, ...]
    answer: Any = None  # int, bool, float, NUMBER_PAIR, or None
    bundle: int = 0  # so many first arguments are one tuple to the kernel
    many_ticks: bool = False  # in one call, which lets other threads go on
    bound: bool = False  # has a second function, with all arguments in one block of words

    @property
    def name(self) -> str:
        """Return the name of the function in an object."""
        return f"trainer_{self.kernel.__name__}"

    @property
    def bound_name(self) -> str:
        """Return the name of the function that takes all arguments in one block of words."""
        return f"{self.name}_of"

    @property
    def sizes(self) -> Iterator[tuple[int, int]]:
        """Yield where each size that a call gives belongs: argument, and index in its shape."""
        for index, kind in enumerate(self.kinds):
            if isinstance(kind, RecordRow):
                yield index, 0
            elif isinstance(kind, tuple):
                yield from ((index, i) for i, size in enumerate(kind) if size == GIVEN_SIZE)

    @property
    def answers(self) -> int:
        """Return how many numbers are answered by address, after all arguments."""
        return {float: 1, NUMBER_PAIR: 2}.get(self.answer, 0)


KERNEL_ENTRIES: Final = (
    Entry(tick, (*BOAT_RECORDS, GIVEN_ROW), int, bundle=5, bound=True),
    Entry(fly, (*BOAT_RECORDS, GIVEN_ROW, GIVEN_ROW, GIVEN_ROWS), int, bundle=5, many_ticks=True),
    Entry(
        steer,
        (
            *(VESSEL, COMPACT, SCHEME, RecordRow(STATE), RecordRow(SCRATCH), GIVEN_ROW),
            *((GIVEN_SIZE, RULE_COLUMNS), GIVEN_ROWS, GIVEN_ROW, int, GIVEN_ROWS),
        ),
        int,
        bundle=6,
        many_ticks=True,
        bound=True,
    ),
    Entry(sail, (*BOAT_RECORDS, LOOKOUT, GIVEN_ROWS), int, bundle=5, many_ticks=True),
    Entry(update, BOAT_RECORDS, int),
    Entry(rates, BOAT_RECORDS),
    Entry(advance, BOAT_RECORDS),
    Entry(set_out, BOAT_RECORDS),
    Entry(level_flight, (*BOAT_RECORDS, float), int),
    Entry(trim, (*BOAT_RECORDS, int), int),
    Entry(stand_by_all, (VESSEL, float, STATE, SCRATCH)),
    Entry(outside, (VESSEL, SCHEME, STATE, SCRATCH)),
    Entry(lost, (STATE,), int),
    Entry(move_surfaces, (VESSEL, float, STATE)),
    Entry(answer_telegraph, (VESSEL, float, STATE)),
    Entry(substeps, (VESSEL, float, int, STATE), int),
    Entry(full.inertia, (VESSEL, STATE, (6, 6))),
    Entry(instruments, (STATE, SCRATCH)),
    Entry(write_readings, (VESSEL, STATE, SCRATCH, READINGS)),
    Entry(begin, (int, float, float, STATE), int),
    Entry(end, (int, float, STATE), int),
    Entry(start_ballast, (VESSEL, STATE)),
    Entry(balance, (VESSEL, STATE)),
    Entry(is_hovering, (STATE,), bool),
    Entry(wanted_pump, (VESSEL, float, STATE), float),
    Entry(segment, (float,), float),
    Entry(sound, (VESSEL, GIVEN_ROW, STATE)),
    Entry(north_and_east, (float,), NUMBER_PAIR),
    Entry(gaussian_pair, (int, int, int), NUMBER_PAIR),
    Entry(order_sea, (VESSEL, float, float, (TAPER + 1,), SCRATCH, STATE)),
    Entry(write_elevations, (VESSEL, float, SCRATCH, STATE, GIVEN_ROW)),
    Entry(corner, (float, float, int), float),
    Entry(prepare_sum, (float, float, SCRATCH)),
    Entry(suction, (float, float, float, float), NUMBER_PAIR),
    Entry(wave_forces, (VESSEL, SCRATCH, STATE, SIX_NUMBERS)),
    Entry(sail_height, (VESSEL, STATE), float),
    Entry(deck_height, (VESSEL, STATE), float),
    Entry(height_above_water, (STATE, float, float), float),
)


def entries_of(room: str) -> tuple[Entry, ...]:
    """Return the rows of a room's kernels, those of the core for ""."""
    if not room:
        return KERNEL_ENTRIES
    entries: tuple[Entry, ...] = import_module(ROOMS[room]).ENTRIES
    return entries


def room_of(module: str) -> str:
    """Return the room whose object has a module's kernels, "" for the core's."""
    package = module.rpartition(".")[0]
    rooms = (room for room, path in ROOMS.items() if path.rpartition(".")[0] == package)
    return next(rooms, "")


def digest_room(room: str) -> str:
    """Return a short hash of the sources of a room's kernels, with what they import."""
    paths = (Path(each.kernel.py_func.__code__.co_filename) for each in entries_of(room))
    return digest_sources(imported_sources(*paths))


def entry_of(kernel: Callable[..., Any]) -> Entry:
    """Return the row of a kernel."""
    return next(entry for entry in KERNEL_ENTRIES if entry.kernel is kernel)
