"""Many of one boat, each ordered by numbers of its own.

A plain loop of the shipped tick (``core.entry.steer``), so that every boat has the bits that it has
alone, whatever it does.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trainer.api.boat import BOAT_KEYWORDS, Snapshot, plan_boat
from trainer.api.by_number import (
    NO_RULES,
    WorldSteps,
    choose_orders,
    choose_reads,
    numbers_of,
    refuse_ticks,
    rules_of,
)
from trainer.boat.boat import Boat as CoreBoat
from trainer.boat.depths import collapse_of
from trainer.boat.due_orders import obey_all
from trainer.boat.machine_code import EMPTY_CHART, bind
from trainer.config.files import ConfigError, quote
from trainer.core.entry import steer
from trainer.core.kernel import Numbers
from trainer.core.state import SCRATCH, STATE
from trainer.io.orders.grammar import Order
from trainer.io.recording.recording import Moment
from trainer.session.past.plan import Plan
from trainer.session.ready import ready_boat

MAX_BOATS: Final = 1_000_000
STATE_SIZE: Final = STATE.itemsize // 8
Mask = NDArray[np.bool_]


RUN_NAMES: Final = frozenset({"ticks", "each_tick", "seeds", "threads"})  # how many are run
FLEET_KEYWORDS: Final = {  # those that say how each boat begins
    name: BOAT_KEYWORDS[name]
    for name in ("vessel", "speed", "depth", "course", "sea", "step", "battery")
}


class Fleet:
    """Many of one boat in one call, each with its own orders, sea and end.

    ``orders``, ``reads`` and ``ticks`` are as for ``Boat.by_number``; with ``each_tick`` a step
    reads after every tick. ``seeds`` are those of everything random, one for each boat; without
    them boat i has the seed 1 + i. The other keywords are those of ``Boat``. So many ``threads``
    share the boats.

    TrainerError naming what is wrong. In a sea with a current or ships that pull, each
    tick takes longer, because they are written before it.
    """

    def __init__(
        self,
        vessel: str | Path,
        count: int,
        *,
        orders: Sequence[str],
        reads: Sequence[str],
        **options: Any,
    ) -> None:
        start = {name: options.pop(name) for name in {*options} - RUN_NAMES}
        chosen, plan = plan_boat({"vessel": vessel, **start}, FLEET_KEYWORDS, "Fleet")
        self._begin(plan, ready_boat(plan, chosen), count, (orders, reads), **options)

    @classmethod
    def of_plan(
        cls,
        plan: Plan,
        count: int,
        *,
        orders: Sequence[str],
        reads: Sequence[str],
        **options: Any,
    ) -> Self:
        """Return many boats of a plan; its scheduled orders are the caller's."""
        fleet = cls.__new__(cls)
        begun = plan, plan.launch_boat(), count, (orders, reads)
        fleet._begin(*begun, **options)  # noqa: SLF001  its own kind
        return fleet

    def _begin(  # noqa: PLR0913  those of RUN_NAMES have defaults here
        self,
        plan: Plan,
        boat: CoreBoat,
        count: int,
        names: tuple[Sequence[str], Sequence[str]],
        *,
        ticks: int = 1,
        each_tick: bool = False,
        seeds: Sequence[int] | None = None,
        threads: int = 1,
    ) -> None:
        for name, given, most in (("count", count, MAX_BOATS), ("threads", threads, 1024)):
            if not (isinstance(given, int) and 0 < given <= most):
                raise ConfigError(f"Fleet: {name} must be 1 to {most}, not {quote(given)}")
        refuse_ticks(ticks)
        rows = ticks if each_tick else 1
        self.plan, self._boat = plan, boat
        chosen, (orders, reads) = choose_orders(boat, names[0]), names
        self.orders, self.reads, self.ticks, self.count = tuple(orders), tuple(reads), ticks, count
        self.low = np.array([order.low for order in chosen])
        self.high = np.array([order.high for order in chosen])
        self._states = np.zeros(count, STATE)
        self._starts = np.zeros((count, STATE_SIZE))
        self._values = np.zeros((count, len(chosen)))
        self._out = np.zeros((count, 1 + rows * len(reads)))
        self._offsets = choose_reads(reads)
        self._whole = self._states.view(float).reshape(count, STATE_SIZE)
        rules, self._one = rules_of(chosen), np.zeros((count, 1 + len(reads)))
        self._calls = self._bound(rules, threads, ticks, self._out)
        tick_calls = (self._bound(each, threads, 1, self._one) for each in (rules, NO_RULES))
        first, further = (partial(self._run, calls) for calls in tick_calls)
        plains = [row.data for row in self._whole] if boat.world.acts else []
        self._in_world = WorldSteps(plains, first, further, self._one, self._out)
        self._crew = ThreadPoolExecutor(threads) if threads > 1 else None
        self.reset(seeds=seeds or range(1, count + 1))

    def _run(self, calls: Sequence[Callable[[], int]]) -> None:
        """Have each thread do its call."""
        if self._crew:
            list(self._crew.map(lambda call: call(), calls))
        else:
            calls[0]()

    def _bound(
        self, rules: Numbers, threads: int, ticks: int, out: Numbers
    ) -> Sequence[Callable[[], int]]:
        """Return the call of each thread, for boats in a row."""
        records, calls = self._boat.records, []
        chart = EMPTY_CHART if self._boat.chart is None else self._boat.chart
        own = self.plan.sea.sea.generator == "cosines"  # which keeps in it what a seed has drawn
        ends = np.linspace(0, self.count, min(threads, self.count) + 1).astype(int).tolist()
        for begin, end in pairwise(ends):
            scratch = np.zeros(end - begin if own else 1, SCRATCH)
            scratch[:] = records.scratch
            shared = records.vessel, records.compact, records.scheme
            boats = (*shared, self._states[begin:end], scratch)
            rows = self._values[begin:end], self._offsets, ticks, out[begin:end]
            calls.append(bind(steer, (*boats, chart), rules, *rows))
        return calls

    @property
    def status(self) -> NDArray[np.int64]:
        """Return 0 for each boat that goes on. A lost one rests until it is reset."""
        return self._out[:, 0].astype(np.int64)

    @property
    def places(self) -> NDArray[np.int64]:
        """Return where in a state stands what is read."""
        return self._offsets.astype(np.int64)

    def column(self, name: str) -> Numbers:
        """Return a copy of one number of the state of all boats."""
        return self._whole[:, int(choose_reads([name])[0])].copy()

    def step(self, values: ArrayLike) -> Numbers:
        """Obey a row of numbers for each boat, advance, and return what is read.

        They are [count, reads], or [count, ticks, reads] with ``each_tick``. TrainerError, with
        nothing moved, if a number of a boat that goes on is beyond its limits or none.
        """
        given = numbers_of(values, "step()")
        if given.shape != self._values.shape:
            raise ConfigError(f"step(): give {self._values.shape} numbers, not {given.shape}")
        wrong = ~((self.low <= given) & (given <= self.high))
        wrong[self._out[:, 0] != 0.0] = False
        if wrong.any():
            boat, order = np.argwhere(wrong)[0].tolist()
            limits = f"{self.low[order]:.6g} to {self.high[order]:.6g}"
            raise ConfigError(
                f"step(): boat {boat}: {self.orders[order]} must be {limits}, not "
                f"{given[boat, order]:.6g}"
            )
        self._values[:] = given
        if self._boat.world.acts:
            self._in_world.step(self._boat.world, self.ticks, partial(self._run, self._calls))
        else:
            self._run(self._calls)
        return self._seen()

    def clip(self, values: ArrayLike) -> Numbers:
        """Return numbers brought within the limits of their orders; what is none stays none."""
        given: Numbers = np.clip(numbers_of(values, "clip()"), self.low, self.high)
        return given

    def reset(self, which: Mask | None = None, seeds: Sequence[int] | None = None) -> Numbers:
        """Bring boats to their start, all or those of a mask; return what is read.

        With ``seeds``, one for each of them, they begin with these; else with those they had.
        """
        chosen = np.arange(self.count) if which is None else np.flatnonzero(self._mask(which))
        if seeds is not None:
            if len(seeds) != chosen.size:
                raise ConfigError(f"reset(): give {chosen.size} seeds, not {len(seeds)}")
            for index, seed in zip(chosen.tolist(), seeds, strict=True):
                replace(self.plan, seed=int(seed)).start(self._boat)
                self._starts[index] = self._boat.plain
        self._whole[chosen] = self._starts[chosen]
        self._out[chosen, 0] = 0.0
        rows = self._whole[:, self.places]
        return rows.copy()

    def why_lost(self, index: int) -> str:
        """Return what one boat lost, its numbers or its hull, "" for neither."""
        np.asarray(self._boat.plain)[:] = self._whole[index]
        status = int(self._out[index, 0])
        return self._boat.failure(status) if status > 0 else collapse_of(self._boat)

    def snapshot(self, index: int) -> Snapshot:
        """Return the moment of one boat, also for a ``Boat`` of the same file."""
        state = self._whole[index].tobytes()
        tick = int(self._states["tick"][index])
        moment = Moment(1, tick, state, 0, 0)
        return Snapshot(tick * self.plan.method.step, moment, self, self.plan)

    def restore(self, index: int, snapshot: Snapshot) -> None:
        """Bring one boat to a moment of any boat of the same file."""
        self.put(index, np.frombuffer(snapshot.moment_for(self.plan).state, float))

    def put(self, index: int, whole: Numbers) -> None:
        """Bring one boat to the whole numbers of a state; it goes on from there."""
        self._whole[index] = whole
        self._out[index, 0] = 0.0

    def obey(self, index: int, orders: Sequence[Order]) -> None:
        """Have one boat obey orders in words, with its state as it is now."""
        plain = np.asarray(self._boat.plain)
        plain[:] = self._whole[index]
        obey_all(self._boat, orders)
        self._whole[index] = plain

    def _mask(self, which: Any) -> Mask:
        mask = np.asarray(which)
        if mask.shape != (self.count,) or mask.dtype != bool:
            raise ConfigError(f"reset(): give a mask of {self.count} booleans")
        return mask

    def _seen(self) -> Numbers:
        """Return copies of what was read."""
        rows = self._out[:, 1:].copy()
        ticks = rows.shape[1] // max(len(self.reads), 1)
        return rows if ticks == 1 else rows.reshape(self.count, -1, len(self.reads))

    def __len__(self) -> int:
        return self.count
