"""How a crew worked together: closed loops, latency, who informed whom, faults, load by station.

All is from the journal. A loop is closed by the order, its right repeat, and a report with the
order's number once the boat has done it. The limits are estimates, because no standard gives them.
"""

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import groupby
from statistics import median
from typing import Final

from trainer.debrief.passage.episodes import INSTRUCTOR_ROLE, WORDS_AXIS, ReadBack
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import CREW_TALK, ORDER_WORDS
from trainer.io.recording.facts import GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.session.crew.manning import REPEATING_ROLES

REPEAT_LIMIT_S: Final = 10.0  # [s] as the session asks again
REPORT_LIMIT_S: Final = 60.0  # [s] for a report once an order is carried out; an estimate
BUSY_ORDERS: Final = 20  # that one station works within a minute, which leaves no eye; an estimate
WHOLE_CREW: Final = "crew"  # whose a fault is that cannot be attributed
ALL_INFORMED: Final = "all"  # whom a report informs that is no answer to an order
SPOKEN_WORDS: Final = CREW_TALK | {"ready", "role"}  # said, where no hand is at a control


@dataclass(frozen=True)
class CrewFault:
    """One thing that a station left out or did wrong."""

    tick: int
    role: str
    kind: str  # not repeated, repeated late, repeated wrong, not reported, taken in silence, busy
    what: str


@dataclass(frozen=True)
class StationLoad:
    """What one station did: orders that it worked, the most within a minute, repeats, reports."""

    role: str
    worked: int
    busiest: int
    repeats: int
    reports: int


@dataclass(frozen=True)
class CrewWork:
    """How a crew worked together; its stations are roles."""

    orders: int  # to the crew
    repeated: int
    closed: int
    latency_s: float | None  # median from order to repeat
    informed: tuple[tuple[str, str, int], ...]  # who, whom, how often
    load: tuple[StationLoad, ...]
    faults: tuple[CrewFault, ...]


def judge_crew(
    orders: Sequence[RecordedOrder], spoken: Sequence[ReadBack], step: float, end: int
) -> CrewWork | None:
    """Return how a crew worked until a tick, None where fewer than two stations did."""
    stations = (e for e in orders if e.giver.kind is GiverKind.STATION and e.accepted is not False)
    given = [each for each in stations if each.giver.role != INSTRUCTOR_ROLE]
    roles = {each.giver.role for each in given}
    if len(roles) < 2 or not spoken:
        return None
    reports = [each for each in given if each.name == "report"]
    closing = [_closing(each, reports) for each in spoken]
    told = [(b.repeated.giver.role, b.order.giver.role) for b in spoken if b.repeated]
    answers = {r.id: b.order.giver.role for b, r in zip(spoken, closing, strict=True) if r}
    told += [(each.giver.role, answers.get(each.id, ALL_INFORMED)) for each in reports]
    waits = [(b.repeated.tick - b.order.tick) * step for b in spoken if b.repeated]
    loops = zip(spoken, closing, strict=True)
    usual = {(b.axis, b.repeated.giver.role) for b in spoken if b.repeated}
    able = {
        axis: [r for r in repeating if (axis, r) in usual] or [r for r in repeating if r in roles]
        for axis, repeating in REPEATING_ROLES.items()
    }
    faults = [fault for b, r in loops for fault in _left_open(b, r, step, end, able[b.axis])]
    load = tuple(_load(role, given, step) for role in sorted(roles))
    faults += [*_taken(given), *(_busy(each, given) for each in load if each.busiest > BUSY_ORDERS)]
    return CrewWork(
        orders=len(spoken),
        repeated=len(waits),
        closed=sum(each is not None for each in closing),
        latency_s=median(waits) if waits else None,
        informed=tuple((*pair, count) for pair, count in sorted(Counter(told).items())),
        load=load,
        faults=tuple(sorted(faults, key=lambda each: each.tick)),
    )


def _closing(spoken: ReadBack, reports: Sequence[RecordedOrder]) -> RecordedOrder | None:
    """Return the first report of who repeated an order that has its number, if there is one."""
    repeated = spoken.repeated
    if repeated is None:
        return None
    own = (e for e in reports if e.giver.role == repeated.giver.role and e.tick >= repeated.tick)
    wanted = _numbers(spoken.told)
    return next((each for each in own if wanted <= _numbers(each.text)), None)


def _numbers(words: str) -> set[float]:
    return {float(each) for each in re.findall(r"\d+(?:\.\d+)?", words)}


def _left_open(
    spoken: ReadBack, report: RecordedOrder | None, step: float, end: int, able: Collection[str]
) -> list[CrewFault]:
    """Return what was left out or wrong with one order.

    ``able`` are the roles that repeat orders of its axis in this run, else those that may. Where
    these are several, and none did, it is the crew's fault.
    """
    order, repeated, done = spoken.order, spoken.repeated, spoken.carried_out
    late = order.tick + REPEAT_LIMIT_S / step
    faults = [
        CrewFault(each.tick, each.giver.role, "repeated wrong", f"{said}; {spoken.told}")
        for each, said in zip(spoken.wrong_by, spoken.wrong, strict=True)
    ]
    if repeated is None:
        others = [role for role in able if role != order.giver.role]
        if not others or late >= end:
            return faults
        blamed = others[0] if len(others) == 1 else WHOLE_CREW
        return [*faults, CrewFault(order.tick, blamed, "not repeated", spoken.told)]
    role = repeated.giver.role
    if repeated.tick > late:
        faults.append(CrewFault(repeated.tick, role, "repeated late", spoken.told))
    due = None if done is None else max(done, repeated.tick) + REPORT_LIMIT_S / step
    unheard = report is None or (due is not None and report.tick > due)
    if due is not None and due < end and unheard and spoken.axis != WORDS_AXIS:
        faults.append(CrewFault(int(due), role, "not reported", spoken.told))
    return faults


def _taken(given: Sequence[RecordedOrder]) -> list[CrewFault]:
    """Return who worked an axis that another role has, without saying so.

    Each is told once until somebody says that he has it: the other then works what is still his.
    """
    hands: dict[str, str] = {}  # the role that has an axis
    told: set[tuple[str, str]] = set()
    faults = []
    for entry in given:
        order, role = parse(entry.text), entry.giver.role
        axes = ORDER_WORDS[order.name].takes(order.word) if isinstance(order, Order) else ()
        for axis in axes:
            if entry.name == "have":
                hands[axis] = role
                told = {each for each in told if each[0] != axis}
            elif hands.setdefault(axis, role) != role and (axis, role) not in told:
                told.add((axis, role))
                what = f"the {axis}, which {hands[axis]} had"
                faults.append(CrewFault(entry.tick, role, "taken in silence", what))
    return faults


def _worked(role: str, given: Sequence[RecordedOrder]) -> list[int]:
    """Return the ticks of what a role worked; presses within one tick count once."""
    own = (e.tick for e in given if e.giver.role == role and e.name not in SPOKEN_WORDS)
    return [tick for tick, _ in groupby(own)]


def _load(role: str, given: Sequence[RecordedOrder], step: float) -> StationLoad:
    ticks, minute = _worked(role, given), 60.0 / step
    busiest = max(
        (sum(t <= u < t + minute for u in ticks[i:]) for i, t in enumerate(ticks)), default=0
    )
    said = Counter(each.name for each in given if each.giver.role == role)
    return StationLoad(role, len(ticks), busiest, said["aye"], said["report"])


def _busy(load: StationLoad, given: Sequence[RecordedOrder]) -> CrewFault:
    what = f"{load.busiest} orders within a minute"
    return CrewFault(_worked(load.role, given)[0], load.role, "busy", what)
