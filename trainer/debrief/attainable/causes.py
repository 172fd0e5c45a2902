"""What made marks fall: each fault is proved by a flight.

An edit changes the crew's orders at one place: one is left out, moved in time, or another given in
its stead. What could be had at the end of a fall after the edit, less what could be had there, is
its gain. A fault is told where its edit gains more than WORTH_MARKS, and no other gains more.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

from trainer.boat.mute_crew import WATER_ORDERS, is_same_order
from trainer.config.exercise.reference_crew import CREW_HANDS, SAID_ORDERS
from trainer.debrief.attainable.changes import FaultKind, MarkChange
from trainer.debrief.attainable.continuations import ANGLE_ORDERS, Continuation, ContinuationKind
from trainer.debrief.attainable.explorer import MAX_TICKS, RunExplorer
from trainer.debrief.attainable.search import (
    WORTH_MARKS,
    crew_of,
    order_at,
    orders_without,
    point_of,
)
from trainer.debrief.marks.reference import join_runs
from trainer.debrief.marks.rehearsal import OrdersByTick, fly
from trainer.debrief.passage.controls import HAND_CONTROLS
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.io.recording.recording import RecordedOrder

STEADY_MARKS: Final = 0.5  # [%] less from point to point is no fall
JOINED_S: Final = 60.0  # [s] between falls that are one
LATE_S: Final = 2.0  # [s] from which an order is late
EARLY_S: Final = 10.0  # [s] before its due, from which an order counts as the rule's
INSTEAD_S: Final = 90.0  # [s] before a rule is due, from which another order may come for it
PLACE_S: Final = 120.0  # [s] around it, within which an order at another place may
MOST_LEFT_OUT: Final = 20  # orders, the last before a fall, of which each is left out
MOST_FAULTS: Final = 3  # told of one fall
MAIN_SHARE: Final = 0.5  # [-] of a fall that its first fault has to account for


@dataclass(frozen=True)
class Edit:
    """Other orders of the crew at one place, and the fault that these would prove."""

    told: MarkChange  # without its marks
    since: int  # [tick] from which the run is another
    left_out: frozenset[int] = frozenset()  # orders, by number
    put_in: tuple[tuple[int, str], ...] = ()  # orders, each with its tick
    rule: int | None = None  # whose order was wanted
    by_hands: bool = False  # of the reference crew from then on, at planes and rudder

    @property
    def subject(self) -> str:
        """Return the order that was missed, by which two edits are of one fault."""
        return self.told.right or self.told.order

    def beside(self, other: "Edit") -> "Edit":
        """Return both edits as one."""
        return replace(
            self,
            since=min(self.since, other.since),
            left_out=self.left_out | other.left_out,
            put_in=self.put_in + other.put_in,
            by_hands=self.by_hands or other.by_hands,
        )


@dataclass(frozen=True)
class ProvedEdit:
    """An edit, and the marks that it gains [%]."""

    gain: float
    edit: Edit


@dataclass
class FaultFinder:
    """The search for what made the falls of one run."""

    run: RunExplorer
    orders: tuple[tuple[RecordedOrder, Order], ...] = field(init=False)

    def __post_init__(self) -> None:
        given = ((each, parse(each.text)) for each in self.run.crew)
        self.orders = tuple(
            (e, o) for e, o in given if isinstance(o, Order) and o.name not in SAID_ORDERS
        )
        self.controls = self.run.search.choices.controls
        self.rules = [rule.order for rule in self.run.plan.crew.rules]
        self.giver = self.run.crew[0].giver if self.run.crew else REFERENCE_GIVER

    def falls(self) -> list[tuple[int, int]]:
        """Return the stretches over which marks fall by more than WORTH_MARKS, by their ticks."""
        run = self.run
        points = [run.points[tick] for tick in sorted(run.points)]
        found: list[tuple[int, int]] = []
        for before, after in pairwise(points[:-1] if run.cut_short else points):
            if before.marks - after.marks <= STEADY_MARKS and before.won == after.won:
                continue
            near = found and (before.tick - found[-1][1]) * run.step <= JOINED_S
            begin = found.pop()[0] if near else before.tick
            found.append((begin, after.tick))
        marks = {each.tick: each.marks for each in points}
        return [each for each in found if marks[each[0]] - marks[each[1]] > WORTH_MARKS]

    def explain(self, begin: int, end: int) -> Iterator[MarkChange]:
        """Yield a fall, in parts where several faults made it; they add up to it."""
        run = self.run
        had, left = run.points[begin].marks, run.points[end].marks
        loss = had - left
        searched = run.search.flown <= MAX_TICKS
        told = self._proved(begin, end) if searched else []
        last = self._last_kept(begin, end)
        whole, parts = sum(each.gain for each in told), []
        if loss - whole > WORTH_MARKS:
            fault = FaultKind.UNPROVED if searched else FaultKind.UNSEARCHED
            parts = [MarkChange(begin, end, whole - loss, fault, until=last)]
            whole = loss
        scale = loss / whole if whole and not parts else 1.0
        for proved in told:
            told_of = proved.edit.told
            until = last if last and last > told_of.told_at else None
            remedy = proved.edit.put_in
            marks = -proved.gain * scale
            yield replace(told_of, marks=marks, until=until, remedy=remedy)
        yield from parts

    def _last_before(self, begin: int, end: int) -> int:
        """Return the last tick of a fall at which next to nothing was lost yet."""
        points = self.run.points
        least = points[begin].marks - WORTH_MARKS
        return max(tick for tick in points if tick <= end and points[tick].marks >= least)

    def _last_kept(self, begin: int, end: int) -> int | None:
        """Return the last tick at which all could still be put right; None if it is not known.

        Points lie further apart where marks go slowly: between two of them it is looked for.
        """
        run, least = self.run, self.run.points[begin].marks - WORTH_MARKS
        last = self._last_before(begin, end)
        after = min((tick for tick in run.points if tick > last), default=last)
        while after - last > run.finest:
            if run.search.flown > MAX_TICKS:
                return None
            middle = last + run.finest * max((after - last) // run.finest // 2, 1)
            if run.point(middle, run.points[begin].marks, won=False).marks >= least:
                last = middle
            else:
                after = middle
        return last

    def _proved(self, begin: int, end: int) -> list[ProvedEdit]:
        """Return the faults that made a fall, the one that its flight proves best first."""
        run = self.run
        loss = run.points[begin].marks - run.points[end].marks

        def capped(each: ProvedEdit) -> float:
            return min(each.gain, loss)

        found = [ProvedEdit(self.gain(each, begin, end), each) for each in self.edits(begin, end)]
        top = max(map(capped, found), default=0.0)
        if not found:
            return []
        least = max(top - WORTH_MARKS, MAIN_SHARE * loss)
        near = [each for each in found if capped(each) >= least]
        first = min(near, key=lambda e: _rank(e.edit)) if near else max(found, key=capped)
        if capped(first) <= WORTH_MARKS:
            return self._all_late(found, begin, end)
        told, edit, have = [replace(first, gain=capped(first))], first.edit, capped(first)
        while have < loss - WORTH_MARKS and len(told) < MOST_FAULTS:
            names = {each.edit.subject for each in told}
            others = [e.edit for e in found if e.edit.subject not in names and not e.edit.by_hands]
            if len(told) > 1:
                others = [each for each in others if each.told.fault is not FaultKind.NEEDLESS]
            more = [
                ProvedEdit(min(self.gain(edit.beside(each), begin, end), loss) - have, each)
                for each in others
            ]
            best = max(more, key=lambda e: (e.gain // WORTH_MARKS, -_rank(e.edit)), default=None)
            if best is None or best.gain <= WORTH_MARKS:
                break
            told.append(best)
            edit, have = edit.beside(best.edit), have + best.gain
        if have < loss - WORTH_MARKS:  # what the crew ordered later was for the boat that it had
            repaired = [
                ProvedEdit(min(self._repaired(e.edit, begin), loss), e.edit)
                for e in found
                if e.edit.rule is not None
            ]
            best = max(
                repaired, key=lambda e: (e.gain // WORTH_MARKS, -_rank(e.edit)), default=None
            )
            if best is not None and best.gain > have + WORTH_MARKS:
                return [best]
            late = self._all_late(found, begin, end)
            if late and late[0].gain > have + WORTH_MARKS:
                return late
        return told

    def _all_late(self, found: Iterable[ProvedEdit], begin: int, end: int) -> list[ProvedEdit]:
        """Return the fault that all late orders are together, where these explain a fall."""
        late = [each.edit for each in found if each.edit.told.fault is FaultKind.LATE]
        if len(late) < 2:
            return []
        whole = late[0]
        for each in late[1:]:
            whole = whole.beside(each)
        gain = self.gain(whole, begin, end)
        whole = replace(whole, told=replace(whole.told, late_orders=len(late)))
        loss = self.run.points[begin].marks - self.run.points[end].marks
        return [ProvedEdit(min(gain, loss), whole)] if gain > WORTH_MARKS else []

    # what a flight says

    def gain(self, edit: Edit, begin: int, end: int) -> float:
        """Return the marks that an edit keeps at the end of a fall [%]."""
        run = self.run
        had, left = run.points[begin].marks, run.points[end].marks
        steered = crew_of(run.at(self._last_before(begin, end)).here).crew.hands
        if edit.by_hands:
            return self._after(edit, begin, end, hands=edit.since) - left
        gain = self._after(edit, begin, end) - left
        if gain < MAIN_SHARE * (had - left) and steered:
            # hands would have answered the boat that they then had
            by_hands = self._after(edit, begin, end, hands=edit.since) - left
            if by_hands > MAIN_SHARE * (had - left):
                nothing = Edit(edit.told, edit.since)
                alone = self._after(nothing, begin, end, hands=edit.since) - left
                gain = max(gain, by_hands - max(alone, 0.0))
        return gain

    def _after(self, edit: Edit, begin: int, end: int, hands: int | None = None) -> float:
        """Return what could be had at a tick after an edit, by hands from a tick on."""
        run = self.run
        orders = self._edited(edit)
        since = max(min(edit.since, begin), 0)
        moment = run.with_orders(orders, since, min(end, run.last), hands)
        if moment.here.tick < end or end >= run.last:
            return point_of(end, run.judge(moment.past)).marks
        marks = run.points[begin].marks
        best = run.search.best(moment, marks, won=False).marks
        rest = {tick: given for tick, given in orders.items() if tick >= end}
        flown, there = fly(run.plan, moment.here, rest)
        run.search.flown += there.tick - end
        own = point_of(end, run.judge(join_runs(moment.past, flown.trajectory))).marks
        return max(best, own)

    def _edited(self, edit: Edit) -> OrdersByTick:
        orders = dict(orders_without(self.run.recorded, edit.left_out))
        for tick, text in edit.put_in:
            orders[tick] = [*orders.get(tick, ()), order_at(tick, self.giver, text)]
        return orders

    def _repaired(self, edit: Edit, begin: int) -> float:
        """Return what a rule's order, given when a fall begins, has over the run without it."""
        run, index = self.run, edit.rule
        assert index is not None  # noqa: S101 (asked of edits of a rule)
        moment, kind = run.at(begin), ContinuationKind.ONE_ORDER
        given = run.search.point(moment, Continuation(kind, (self.rules[index].text,)))
        if given.marks < run.points[begin].marks - WORTH_MARKS:
            return 0.0
        return given.marks - run.search.point(moment, Continuation(kind, (), (index,))).marks

    # the edits

    def edits(self, begin: int, end: int) -> Iterator[Edit]:
        """Yield the edits that may have kept the marks of a fall."""
        blank = MarkChange(begin, end, 0.0, FaultKind.STEERING)
        last = self._last_before(begin, end)
        if hands := crew_of(self.run.at(last).here).crew.hands:
            yield Edit(self._steered(replace(blank, begin=last), hands), last, by_hands=True)
        for index, rule in enumerate(self.rules):
            due = self.run.due_tick(index)
            if rule.name not in (*CREW_HANDS, *SAID_ORDERS) and due is not None and due < end:
                yield from self._edits_of_rule(blank, index, due)
        before = [(e, o) for e, o in self.orders if e.tick < end and not self._by_own_hand(o)]
        before = before[-MOST_LEFT_OUT:]
        for entry, order in before:
            if not self._is_first(entry, order):
                told = replace(blank, fault=FaultKind.NEEDLESS, order=entry.text, tick=entry.tick)
                told = replace(told, who=entry.who)
                yield Edit(told, entry.tick, frozenset({entry.id}))
        ruled = [(e, o) for e, o in before if self._of_rules(o)]
        for (one, first), (two, second) in pairwise(ruled):
            if self._index(first) > self._index(second):
                told = replace(blank, fault=FaultKind.TURNED, order=one.text, tick=one.tick)
                told = replace(told, right=two.text, who=one.who)
                swapped = ((one.tick, two.text), (two.tick, one.text))
                yield Edit(told, one.tick, frozenset({one.id, two.id}), swapped)

    def _steered(self, blank: MarkChange, hands: Iterable[str]) -> MarkChange:
        """Return how surfaces were worked that are in the crew's hands when a fall begins.

        It has the order that stood there from then, or when the first one came after all.
        """
        worked = frozenset().union(*(HAND_CONTROLS[hand][1] for hand in hands)) & ANGLE_ORDERS
        given = [entry for entry, _ in self.orders if entry.name in worked]
        since = blank.begin - round(JOINED_S / self.run.step)
        before = [each for each in given if since <= each.tick <= blank.begin]
        if before:
            last = before[-1]
            return replace(blank, order=last.text, tick=last.tick, who=last.who)
        return replace(blank, came=next((e.tick for e in given if e.tick > blank.begin), None))

    def _edits_of_rule(self, blank: MarkChange, index: int, due: int) -> Iterator[Edit]:
        """Yield the edits about a rule: its order in time, or instead of another."""
        run, rule, end = self.run, self.rules[index], blank.end
        early, late = round(EARLY_S / run.step), round(LATE_S / run.step)
        same = [e for e, o in self.orders if is_same_order(o, rule)]
        done = next((e for e in same if e.tick < end), None)
        came = next((e for e in same if due - early <= e.tick < end), None)
        after = next((e for e in same if e.tick >= end), None)
        told = replace(blank, order=rule.text, tick=due)
        if done is None and after is None:
            yield Edit(
                replace(told, fault=FaultKind.MISSING), due, put_in=((due, rule.text),), rule=index
            )
        elif (moved := came if done else after) is not None and moved.tick > due + late:
            told = replace(told, fault=FaultKind.LATE, came=moved.tick, who=moved.who)
            yield Edit(told, due, frozenset({moved.id}), ((due, moved.text),))
        since, place = due - round(INSTEAD_S / run.step), round(PLACE_S / run.step)
        in_time = came.tick if came is not None and came.tick <= due + late else since
        for entry, order in self.orders:
            meets = bool(self.controls.of(order) & self.controls.of(rule))
            if not since <= entry.tick < end or not (meets or order.name == rule.name):
                continue
            told = replace(blank, order=entry.text, tick=entry.tick, right=rule.text, who=entry.who)
            again = [e.id for e, _ in self.orders if e.tick > entry.tick and e.text == rule.text]
            instead = frozenset({entry.id, *again})
            if self._is_another_s(entry, order, rule, due):
                continue
            if meets and done is not None and done.tick < entry.tick:
                if not self._has_skipped(entry, order, index):
                    told = replace(told, fault=FaultKind.UNDONE)
                    yield Edit(told, entry.tick, frozenset({entry.id}), (), index)
            elif entry.tick >= in_time and (meets or abs(entry.tick - due) <= place):
                told = replace(told, fault=self._fault_of(order, rule))
                yield Edit(told, entry.tick, instead, ((entry.tick, rule.text),), index)

    def _has_skipped(self, entry: RecordedOrder, order: Order, index: int) -> bool:
        """Return whether an order is a later rule's, and one between it and a rule is overdue."""
        if not self._is_first(entry, order):
            return False
        ahead = next(i for i, rule in enumerate(self.rules) if is_same_order(order, rule))
        given = [o for e, o in self.orders if e.tick <= entry.tick]
        return any(
            (due := self.run.due_tick(each)) is not None
            and due <= entry.tick
            and self.rules[each].name not in CREW_HANDS
            and not any(is_same_order(o, self.rules[each]) for o in given)
            for each in range(index + 1, ahead)
        )

    def _is_another_s(self, entry: RecordedOrder, order: Order, rule: Order, due: int) -> bool:
        """Return whether an order near a rule's due has nothing to do with it.

        It is the rule's own, or that of another rule that is due, or of a hand that steers then.
        """
        early = due - round(EARLY_S / self.run.step)
        by_hand = self._by_own_hand(order) or order.name in self.run.search.choices.by_hand
        if is_same_order(order, rule) or (by_hand and entry.tick < early):
            return True
        dues = (self.run.due_tick(i) for i, r in enumerate(self.rules) if is_same_order(order, r))
        own = any(each is not None and each <= entry.tick + 2 for each in dues)
        return (own and self._is_first(entry, order)) or self._after_hand(entry, order, due)

    def _fault_of(self, order: Order, rule: Order) -> FaultKind:
        """Return what is wrong with an order on the controls of a rule's."""
        given, wanted = self.controls.setting(order), self.controls.setting(rule)
        if self.controls.of(order) != self.controls.of(rule):
            return FaultKind.WRONG_PLACE
        if order.name in WATER_ORDERS or not self.controls.is_switch(rule):
            turned = any(given.get(place, 0.0) * value < 0.0 for place, value in wanted.items())
            return FaultKind.WRONG_WAY if turned else FaultKind.WRONG_AMOUNT
        return FaultKind.WRONG_WAY

    def _of_rules(self, order: Order) -> bool:
        return any(is_same_order(order, rule) for rule in self.rules)

    def _index(self, order: Order) -> int:
        return next(i for i, rule in enumerate(self.rules) if is_same_order(order, rule))

    def _is_first(self, entry: RecordedOrder, order: Order) -> bool:
        """Return whether an order is a rule's that has not come so often before."""
        rules = sum(is_same_order(order, rule) for rule in self.rules)
        return rules > sum(is_same_order(o, order) and e.id < entry.id for e, o in self.orders)

    def _by_own_hand(self, order: Order) -> bool:
        """Return whether an order is an angle at a surface that is in the crew's hands."""
        axis = "rudder" if order.name == "rudder" else "planes"
        by_hand = order.name in ANGLE_ORDERS and order.word != "auto"
        return by_hand and axis in self.run.plan.hand and not self._of_rules(order)

    def _after_hand(self, entry: RecordedOrder, order: Order, due: int) -> bool:
        """Return whether a hand of the reference crew would work that surface by then."""
        early = round(EARLY_S / self.run.step)
        begun = [
            tick
            for index, rule in enumerate(self.rules)
            if rule.name in CREW_HANDS
            and rule.word == "on"
            and order.name in HAND_CONTROLS[rule.name][1] & ANGLE_ORDERS
            and (tick := self.run.due_tick(index)) is not None
        ]
        return any(
            begin <= entry.tick and (due < begin or entry.tick > due + early) for begin in begun
        )


def _rank(edit: Edit) -> int:
    """Return the place of an edit's fault among the kinds."""
    return list(FaultKind).index(edit.told.fault)
