"""The cost of a step by numbers, beside the bare tick and words.

``trainer dev bench --numbers`` measures it, in one run, in a calm and in a sea.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

import trainer
from trainer.analysis.bench.tick import (
    STANDARD_METHOD,
    BatchCost,
    in_a_loop,
    ready_boat,
    time_batches,
)
from trainer.boat.helm import obey_order
from trainer.config.sea import load_sea
from trainer.config.vessel import VesselFile
from trainer.io.orders.grammar import Order, parse

ORDER_WORDS: Final = ("stern planes rise 1", "rudder right 1", "depth 60")
READ_NAMES: Final = ("z", "theta", "w", "q", "u", "psi")
SEA_NAMES: Final = ("calm", "sea-state-5")


@dataclass(frozen=True)
class StepCost:
    """The cost of a step in a sea: three orders, a tick, and numbers read."""

    sea: str
    tick: BatchCost  # in a compiled loop
    step: BatchCost
    words: BatchCost  # the same by ``order``, ``run`` and ``state``
    over_the_tick_ns: float
    words_over_step: float


@dataclass(frozen=True)
class NumbersCost:
    """The costs of a step in each sea."""

    seas: Sequence[StepCost]


def time_numbers(file: VesselFile) -> NumbersCost:
    """Return what steps by numbers and by words cost."""
    return NumbersCost([_time_in(file, sea) for sea in SEA_NAMES])


def _time_in(file: VesselFile, sea: str) -> StepCost:
    """Return the costs in a sea; the works take turns, so that they meet the same machine."""
    told, steered = (trainer.Boat(file.path, sea=sea) for _ in range(2))
    bare = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    bare.put_to_sea(load_sea(sea))
    orders = [order for order in map(parse, ORDER_WORDS) if isinstance(order, Order)]
    for order in orders:
        obey_order(bare, order)  # so that its tick does the same work
    by_number = steered.by_number([order.name for order in orders], READ_NAMES)
    values = np.array([*np.radians((1.0, 1.0)), 60.0])

    def step(count: int) -> None:
        for _ in range(count):
            by_number.step(values)

    def tell(count: int) -> None:
        for _ in range(count):
            for words in ORDER_WORDS:
                told.order(words)
            told.run(file.run.step_s)
            _ = told.state["z"]

    tick, stepped, said = time_batches([partial(in_a_loop, bare.records), step, tell])
    over = stepped.least_ns - tick.least_ns
    return StepCost(sea, tick, stepped, said, over, said.least_ns / stepped.least_ns)


def lines(cost: NumbersCost) -> list[str]:
    """Return the costs as lines of a page."""
    head = "A step by numbers: three orders, a tick, six numbers read [us, least of batches]"
    columns = f"  {'':12}{'bare tick':>10}{'step':>8}{'over it':>9}{'in words':>10}{'times':>7}"
    rows = [
        f"  {each.sea:12}{each.tick.least_ns / 1e3:10.3f}{each.step.least_ns / 1e3:8.3f}"
        f"{each.over_the_tick_ns / 1e3:9.3f}{each.words.least_ns / 1e3:10.0f}"
        f"{each.words_over_step:7.0f}"
        for each in cost.seas
    ]
    return [head, columns, *rows]
