"""What is broken, and what a schedule has given, by the journal of a recording.

The laws of casualties fly nothing again: a recording that is flown again by the product has the
product's own faults. What an order breaks, how far by then and when it is mended stands in
docs/casualties.md and in the tables of ``configs/casualties``.
"""

import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np
from helpers import places

from trainer.core.casualties import KINDS
from trainer.core.state import STATE
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import BranchCause
from trainer.io.recording.recording import RecordedOrder, Recording
from trainer.session.past.plan import Plan
from trainer.units import KNOT

PARAMETERS: Final = {  # of severity 1, in SI
    "hole_m2": 1.0,
    "leak_l_s": 1e-3,
    "dip_s": 1.0,
    **{
        f"{what}_{unit}": size
        for what in ("noise", "bias")
        for unit, size in (("m", 1.0), ("deg", math.radians(1.0)), ("kn", KNOT))
    },
}
# Kinds whose amount is an angle or a reading that the boat has at the time.
FOUND_KINDS: Final = ("-stuck", "-hard-over")
TOLERANCE: Final = 1e-9  # [-] of an amount


class Row(NamedTuple):
    """One thing that an entry of the tables breaks."""

    kind: str
    severity: float
    full: float | None  # [SI] of severity 1, None where the boat has it
    ramp: float  # [s]
    clear: float  # [s]


@dataclass(frozen=True)
class Damage:
    """One casualty, since the last order about it."""

    since: int  # tick
    ticks: int  # that it takes to come, or to go
    first: float | None  # [SI] None where nobody knows it
    last: float | None
    clearing: bool = False

    def at(self, tick: int) -> float | None:
        """Return its amount at a tick."""
        if self.first is None or self.last is None:
            return None
        share = min((tick - self.since) / self.ticks, 1.0) if self.ticks else 1.0
        return self.first + (self.last - self.first) * share

    def is_gone(self, tick: int) -> bool:
        """Return whether it is mended by a tick."""
        return self.clearing and tick - self.since >= self.ticks


@cache
def rows() -> Mapping[str, tuple[Row, ...]]:
    """Return what each entry of the shipped tables breaks, by its name."""
    tables: dict[str, dict[str, Any]] = {}
    for name in ("standard", "compound"):
        text = (places.ROOT / "configs" / "casualties" / f"{name}.toml").read_text(encoding="utf-8")
        tables |= tomllib.loads(text)["casualty"]
    usual = {entry["kind"]: entry for entry in tables.values() if "kind" in entry}
    return {
        name: tuple(_row(usual[part["kind"]] | part) for part in entry.get("parts", [entry]))
        for name, entry in tables.items()
    }


def _row(entry: Mapping[str, Any]) -> Row:
    kind = entry["kind"]
    sizes = [size * entry[key] for key, size in PARAMETERS.items() if key in entry]
    full = None if kind.endswith(FOUND_KINDS) else sizes[0] if sizes else 1.0
    return Row(kind, entry["severity"], full, entry["ramp_s"], entry["clear_ramp_s"])


def obey(broken: dict[str, Damage], order: Order, tick: int, step: float) -> None:
    """Break or mend what an order says that was accepted at a tick."""

    def ticks_of(seconds: float) -> int:
        return math.ceil(seconds / step - 1e-9)

    for kind in [kind for kind, damage in broken.items() if damage.is_gone(tick)]:
        del broken[kind]
    name = order.subject.strip().casefold().replace(" ", "-").replace("_", "-")
    if order.name == "clear":
        every = name in ("all", "casualties")
        for row in [rows()[kind][0] for kind in broken] if every else rows()[name]:
            if was := broken.get(row.kind):
                held = row.kind.endswith("-stuck") and "servo" not in row.kind
                ticks = 1 if held else max(ticks_of(row.clear), 1)
                broken[row.kind] = Damage(tick, ticks, was.at(tick), 0.0, clearing=True)
        return
    numbers = list(order.numbers)
    ramp = numbers.pop() if order.word == "ramp" else None
    for row in rows()[name]:
        severity = numbers[0] if numbers else row.severity
        ticks = ticks_of(row.ramp if ramp is None else ramp)
        was = broken.get(row.kind)
        last = None if row.full is None else severity * row.full
        first = None if row.full is None else was.at(tick) if was else 0.0
        broken[row.kind] = Damage(tick, ticks, first, last)


def found_in(state: bytes) -> dict[str, float]:
    """Return the casualties of a state, with their amounts [SI]."""
    s = np.frombuffer(state, STATE)[0]
    slots = zip(s["casualty"].tolist(), s["casualty_amount"].tolist(), strict=True)
    return {KINDS[int(code) - 1]: amount for code, amount in slots if code}


def standing_in(state: bytes, tick: int) -> dict[str, Damage]:
    """Return the casualties of a state, believed as they are there."""
    s = np.frombuffer(state, STATE)[0]
    slots = zip(
        *(s[name].tolist() for name in ("casualty", "casualty_amount", "casualty_target")),
        s["casualty_ticks"].tolist(),
        strict=True,
    )
    return {
        KINDS[int(code) - 1]: Damage(
            tick, int(abs(ticks)), amount, 0.0 if ticks < 0 else target, clearing=ticks < 0
        )
        for code, amount, target, ticks in slots
        if code
    }


def check_damage(recording: Recording, step: float) -> Iterator[str]:
    """Yield where something else is broken than orders have broken and mended."""
    causes = {branch.id: branch for branch in recording.branches()}
    for branch in recording.branches():
        orders = recording.orders(branch.id)
        before = [order for order in orders if order.branch != branch.id]
        own = [order for order in orders if order.branch == branch.id]
        doubtful = any(each.accepted is None for each in before)
        doubtful = doubtful or any(
            causes[number].cause is BranchCause.GAP for number in ancestry(causes, branch.id)
        )
        broken = standing_in(branch.state, branch.tick) if doubtful else damage_of(before, step)
        until = next((o.tick for o in own if o.accepted is None), math.inf)
        given = [(o.tick, order) for o in own if o.accepted and (order := damaging(o))]
        for tick, state in recording.states(branch.id):
            if tick > until:
                break
            while given and given[0][0] < tick:
                obey(broken, given[0][1], given[0][0], step)
                del given[0]
            if wrong := _difference(broken, found_in(state), tick):
                yield f"branch {branch.id}, tick {tick}: {wrong}"
                break


def check_schedule(recording: Recording, plan: Plan) -> Iterator[str]:
    """Yield where a branch was not given each order of its schedule once."""
    branches = {branch.id: branch for branch in recording.branches()}
    step = plan.method.step
    due = [math.ceil(entry.seconds / step - 1e-9) for entry in plan.schedule]
    for number in branches:
        causes = {branches[each].cause for each in ancestry(branches, number)}
        orders = recording.orders(number)
        given = [order.entry for order in orders if order.entry is not None]
        last = recording.last_tick(number)
        late = [i for i, tick in enumerate(due) if tick < last and i >= len(given)]
        lost = late and not causes & {BranchCause.GAP, BranchCause.SHOWN}
        if given != list(range(len(given))) or lost:
            yield f"branch {number}: of the schedule are given {given}, by tick {last} of {due}"


def damage_of(orders: Iterable[RecordedOrder], step: float) -> dict[str, Damage]:
    """Return what orders have broken."""
    broken: dict[str, Damage] = {}
    for given in orders:
        if given.accepted and (order := damaging(given)):
            obey(broken, order, given.tick, step)
    return broken


def damaging(given: RecordedOrder) -> Order | None:
    """Return an order that breaks or mends something, None for another."""
    if not given.text.startswith(("casualty", "clear")):
        return None
    order = parse(given.text)
    return order if isinstance(order, Order) and order.name in ("casualty", "clear") else None


def _difference(broken: Mapping[str, Damage], found: Mapping[str, float], tick: int) -> str:
    wanted = {kind: each.at(tick) for kind, each in broken.items() if not each.is_gone(tick)}
    if wanted.keys() != found.keys():
        return f"{sorted(found)} are broken, not {sorted(wanted)}"
    for kind, amount in wanted.items():
        if amount is not None and abs(found[kind] - amount) > TOLERANCE * max(abs(amount), 1.0):
            return f"{kind} is {found[kind]:g}, not {amount:g}"
    return ""


def ancestry(branches: Mapping[int, Any], number: int) -> Iterator[int]:
    """Yield a branch and all from which it has come."""
    at: int | None = number
    while at is not None:
        yield at
        at = branches[at].parent
