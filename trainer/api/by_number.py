"""A boat ordered by numbers and read as numbers, by programs that learn.

One call obeys a row of numbers, advances, and reads a row of the state, in machine code
(``core.entry.steer``). What an order by number writes is what its words write, to the bit.
"""

import threading
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.depths import collapse_of, crush_depth
from trainer.boat.effects import NumberedOrder, numbered_orders
from trainer.boat.machine_code import EMPTY_CHART, bind
from trainer.boat.world.bottom import TICK_OFFSET
from trainer.boat.world.world import World
from trainer.config.files import ConfigError, nearest, quote
from trainer.core.entry import CONST, NUMBER, OVER, PLACE, RULE_COLUMNS, SHORT, SHORTER, steer
from trainer.core.kernel import Numbers
from trainer.session.past.layout import LAYOUT

WRITE_CODES: Final = {
    "const": CONST,
    "number": NUMBER,
    "over": OVER,
    "place": PLACE,
    "short": SHORT,
    "shorter": SHORTER,
}
Z_OFFSET: Final = STATE_OFFSETS["z"]
MAX_TICKS: Final = 1_000_000  # of a step
NO_RULES: Final = np.empty((0, RULE_COLUMNS))  # for a tick without orders


class BoatByNumber:
    """A boat whose orders and readings are rows of numbers, in SI and radians.

    ``Boat.by_number`` gives one. ``orders`` and ``reads`` are the names of its columns, and
    ``ticks`` says how far a step goes. ``low`` and ``high`` are the limits of the orders, those of
    their words; right, rise, ahead, in and forward are positive. It is the same boat: ``order``,
    ``state``, ``snapshot`` and ``restore`` go on, but ``columns`` has no rows of its steps. With
    as many ``rows`` as ticks a step reads after each of them, one row behind the other.
    """

    def __init__(
        self,
        boat: Boat,
        lock: threading.Lock,
        orders: Sequence[str],
        reads: Sequence[str],
        ticks: int,
        rows: int = 1,
    ) -> None:
        chosen, offsets = choose_orders(boat, orders), choose_reads(reads)
        refuse_ticks(ticks)
        self.orders, self.reads, self.ticks = tuple(orders), tuple(reads), ticks
        self.low = np.array([order.low for order in chosen])
        self.high = np.array([order.high for order in chosen])
        self._boat, self._crush_depth = boat, crush_depth(boat.file.hull)
        self._values = np.zeros((1, len(chosen)))
        self._out = np.zeros((1, 1 + rows * len(reads)))
        self._shape, self._row = self.low.shape, self._values[0]
        # a step takes little more than its tick: so what it calls is found once
        self._copy, self._acquire, self._release = self._out[0, 1:].copy, lock.acquire, lock.release
        chart = EMPTY_CHART if boat.chart is None else boat.chart
        boats, rules = (*boat.records, chart), rules_of(chosen)
        self._steer = bind(steer, boats, rules, self._values, offsets, ticks, self._out)
        self._one = np.zeros((1, 1 + len(reads)))
        first, further = (
            bind(steer, boats, each, self._values, offsets, 1, self._one)
            for each in (rules, NO_RULES)
        )
        self._in_world = WorldSteps([boat.plain], first, further, self._one, self._out)
        self.places = offsets.astype(np.int64)  # of what is read, in a state

    def step(self, values: ArrayLike) -> Numbers:
        """Obey a row of numbers, advance by ``ticks``, and return a row of ``reads``.

        TrainerError if a number is beyond its limits or none, with the boat as it was, and if the
        boat is lost on the way, which stays as it was then.
        """
        if not (isinstance(values, np.ndarray) and values.shape == self._shape):
            values = self._row_of(values)
        if not self._acquire(False):  # noqa: FBT003  by its name it takes twice as long
            raise ConfigError(
                "another thread is at this boat: one call at a time; give each thread its own boat"
            )
        try:
            if lost := self._collapse():
                raise ConfigError(f"this boat cannot go on: {lost}; go back to a snapshot")
            self._row[...] = values
            world = self._boat.world
            resting = (
                self._steer()
                if self._boat.tick is self._boat.advance
                else self._refused() or self._in_world.step(world, self.ticks, self._steer)
            )
            if resting:
                raise ConfigError(self._reason())
            if lost := self._collapse():
                raise ConfigError(f"lost at {self._boat.time:g} s: {lost}")
            return self._copy()
        finally:
            self._release()

    def _collapse(self) -> str:
        """Return that the hull has collapsed, "" while it holds."""
        return collapse_of(self._boat) if self._boat.plain[Z_OFFSET] >= self._crush_depth else ""

    def _row_of(self, values: ArrayLike) -> Numbers:
        """Return values as a row of the orders; ConfigError if they are none."""
        given = numbers_of(values, "step()")
        if given.shape != self._shape:
            shape = " by ".join(map(str, given.shape)) or "one"
            raise ConfigError(f"step(): give {len(self.orders)} numbers, not {shape}")
        return given

    def clip(self, values: ArrayLike) -> Numbers:
        """Return numbers brought within the limits of their orders; what is none stays none."""
        given: Numbers = np.clip(numbers_of(values, "clip()"), self.low, self.high)
        return given

    def _refused(self) -> int:
        """Return 1 where a value is refused, before the world is written for it."""
        wrong = np.flatnonzero(~((self.low <= self._row) & (self._row <= self.high)))
        if wrong.size:
            self._out[0, 0] = -1.0 - wrong[0]
        return int(wrong.size > 0)

    def _reason(self) -> str:
        """Return why the last step was not done; the next one may be."""
        status, self._out[0, 0] = int(self._out[0, 0]), 0.0
        if status > 0:
            return self._boat.failure(status)
        k = -status - 1
        limits = f"{self.low[k]:.6g} to {self.high[k]:.6g}"
        return f"step(): {self.orders[k]} must be {limits}, not {self._row[k]:.6g}"


class WorldSteps:
    """Steps of boats in a world that acts: it is written before each tick.

    ``plains`` are their states as plain numbers. ``first`` obeys and does one tick of all boats,
    ``further`` one tick; both write status and reads to ``one``, whence they come to ``out``.
    """

    def __init__(
        self,
        plains: Sequence[Any],
        first: Callable[[], object],
        further: Callable[[], object],
        one: Numbers,
        out: Numbers,
    ) -> None:
        self._plains, self._first, self._further = plains, first, further
        self._one, self._out = one, out

    def step(self, world: World, ticks: int, whole: Callable[[], object]) -> int:
        """Do a step of so many ticks; return how many boats rest.

        ``whole`` does all of it in one call, where the world stands still for so long.
        """
        one, out = self._one, self._out
        one[:, 0] = out[:, 0]
        going = [plain for plain, rests in zip(self._plains, one[:, 0], strict=True) if not rests]
        if going and world.stands(int(min(plain[TICK_OFFSET] for plain in going))):
            for plain in going:
                world.write(plain)
            whole()
            return int(np.count_nonzero(out[:, 0]))
        count = one.shape[1] - 1
        for k in range(ticks):
            for plain, rests in zip(self._plains, one[:, 0].tolist(), strict=True):
                if not rests:
                    world.write(plain)
            (self._further if k else self._first)()
            at = 1 + k * count if out.shape[1] > 1 + count else 1
            out[:, at : at + count] = one[:, 1:]
        out[:, 0] = one[:, 0]
        return int(np.count_nonzero(out[:, 0]))


def rules_of(orders: Sequence[NumberedOrder]) -> Numbers:
    """Return the rules of ``core.entry.steer`` [n, RULE_COLUMNS] by which orders are obeyed."""
    rows = [
        (index, write.place, WRITE_CODES[write.rule], write.argument, order.low, order.high)
        for index, order in enumerate(orders)
        for write in order.writes
    ]
    return np.array(rows, float).reshape(-1, RULE_COLUMNS)


def choose_orders(boat: Boat, names: Sequence[str]) -> list[NumberedOrder]:
    """Return orders by a number; ConfigError if the boat takes none of such a name."""
    known = numbered_orders(boat)
    if not isinstance(names, Sequence) or isinstance(names, str) or not names:
        raise ConfigError('orders: give a list of names, such as ["stern", "bow"]')
    for name in names:
        if name not in known:
            raise ConfigError(
                f"orders: no order {name!r} takes a number{nearest(str(name), known)}; there are "
                f"{', '.join(known)}"
            )
    return [known[name] for name in names]


def choose_reads(names: Sequence[str]) -> Numbers:
    """Return where numbers stand in the state; ConfigError if there are none of such names."""
    if not isinstance(names, Sequence) or isinstance(names, str):
        raise ConfigError('reads: give a list of names, such as ["z", "theta"]')
    for name in names:
        if name not in LAYOUT:
            raise ConfigError(f"reads: the state has no {name!r}{nearest(str(name), LAYOUT)}")
    return np.array([LAYOUT.index(name) for name in names], float)


def numbers_of(values: ArrayLike, call: str) -> Numbers:
    """Return values as an array of numbers; ConfigError naming the call if some are none."""
    try:
        return np.asarray(values, float)
    except (TypeError, ValueError, OverflowError):
        raise ConfigError(f"{call}: give numbers, not {quote(values)}") from None


def refuse_ticks(ticks: int) -> None:
    """Raise ConfigError if a step cannot have so many ticks."""
    if not (isinstance(ticks, int) and 0 < ticks <= MAX_TICKS):
        raise ConfigError(f"ticks must be 1 to {MAX_TICKS}, not {quote(ticks)}")
