"""The marks of an exercise at each tick, as of a record ending there.

Whoever learns or plans asks at every step, so that what a flight earns is its mark to rounding. An
instructor who asks what could still be earned asks ``evaluator``. ``judge_run`` takes a whole
record into account by the same rows (``tallies``); here a boat goes on, and what is told of ships,
the ground and the crew is found as it comes.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.world.bottom import ground_under
from trainer.boat.world.contacts import contacts_in
from trainer.config.exercise.reference_crew import MARK_ORDER, REPORT_ORDER
from trainer.core.kernel import Numbers
from trainer.debrief.marks import tallies
from trainer.debrief.marks.judgement import plain_marks, widen_rules
from trainer.debrief.marks.measures import (
    MADE_COLUMNS,
    Measurement,
    measure_detection,
    measure_groundings,
    measure_report,
)
from trainer.debrief.marks.rehearsal import fly_rehearsal, last_tick
from trainer.debrief.marks.tallies import TALLY, take_ticks
from trainer.debrief.marks.tally_sheet import (
    LOOK_OUT_MEASURES,
    begin_tallies,
    conditions_hold,
    lay_out,
    passage_of,
    refuse_plan,
)
from trainer.debrief.passage.episodes import Episode, answer_to
from trainer.debrief.ticks.ground import GroundWatch, ground_reads
from trainer.debrief.ticks.ships import SEA_NAMES, ShipWatch
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import RecordedEvent, RecordedOrder
from trainer.session.past.plan import Plan

Mask = NDArray[np.bool_]
IDLE_FIRST: Final = ("time-to-detect", "alert-response")  # no ship came so far; no watch calls
SHOWN_MEASURES: Final = ("closest-approach", "exposed", "exposed-raise")


class TickJudge:
    """The judge of some boats in one exercise, each at a tick of its own.

    ``reads`` are the numbers of the state that it looks at. A boat ``begin``s, then ``look`` takes
    its next ticks and gives the total [%] of a record that ends there, 0 where marks are void.
    ``hear`` takes an order that the crew gave: an answer, a periscope's, or a mark of a ship.

    ConfigError naming why numbers tick by tick cannot judge the plan.
    """

    def __init__(self, plan: Plan, count: int = 1, width: str = "qualified") -> None:
        refuse_plan(plan)
        self.plan, self.width = plan, width
        self._boat = plan.launch_boat()
        boat, bottom = self._boat, ground_under(self._boat)
        contacts = contacts_in(boat)
        near = bool(contacts and contacts.any) or asks_for_ships(plan)
        also = (*ground_reads(boat), *(SEA_NAMES if near else ()))
        self.sheet = sheet = lay_out(widen_rules(plan.scores, width), boat, plan.limits, plan, also)
        sheet.rows["ends"] = np.isin(sheet.rows["measure"], (tallies.COLLAPSED, tallies.STRUCK))
        self.reads = sheet.reads
        self._tallies = np.zeros((count, sheet.rows.size), TALLY)
        self._rings = np.zeros((count, sheet.rings, sheet.window))
        first = len(sheet.reads) + len(sheet.derived)
        made = {name: first + i for i, name in enumerate(sheet.of_ships)}
        self._columns = first + len(made)
        self._ground = None if bottom is None else GroundWatch(boat, bottom, count, self.reads)
        self._ships = ShipWatch(boat, count, self.reads, made) if near else None
        self._last = np.zeros((count, self._columns))  # the tick that was taken last
        self._rows = np.zeros((count, 1, self._columns))
        self._orders: list[list[RecordedOrder]] = [[] for _ in range(count)]
        # at which ticks the conditions held of a rule whose value is written
        self._held: dict[int, Mask] = {
            r: np.zeros((count, last_tick(plan) + 2), bool)
            for r, row in enumerate(sheet.rows[: len(sheet.rules)])
            if row["measure"] >= tallies.AGROUND and row["conditions"]
        }
        answers = np.flatnonzero(sheet.rows["measure"] == tallies.RESPONSE)
        self._answers = [(r, sheet.rules[r]) for r in answers.tolist()]
        self._totals = np.zeros((count, 2))

    def begin(self, index: int, start: Numbers, nobody: Mapping[str, float]) -> float:
        """Begin with a boat whose ``reads`` are those at the start; return its total.

        ``nobody`` are the marks with nobody aboard at its seed, by the rules' names.
        """
        own = self._tallies[index]
        begin_tallies(own, self._rings[index])
        for r, rule in enumerate(self.sheet.rules):
            own[r]["free"] = nobody.get(rule.score.name, 0.0)
            own[r]["idle"] = rule.score.measure in IDLE_FIRST
            if rule.score.measure == "aground":
                own[r]["answered"] = 0.0
        for held in self._held.values():
            held[index] = False
        self._orders[index].clear()
        self._last[index, : len(start)] = start
        if self._ground:
            self._ground.begin(index, start)
        if self._ships:
            self._ships.begin(index)
        which = np.zeros(len(self._tallies), bool)
        which[index] = True
        rows = np.zeros((len(self._tallies), 1, len(self.reads)))
        rows[index, 0] = start
        return float(self.look(rows, which)[index])

    def look(self, rows: Numbers, which: Mask | None = None) -> Numbers:
        """Take the next ticks of all boats, or of a mask; return their totals.

        ``rows`` [boats, ticks, reads] are those after each tick. Other boats' totals are NaN.
        """
        totals = self._totals[:, tallies.TOTAL]
        totals[:] = 0.0
        if which is not None:
            totals[~which] = np.nan
        self._take(rows, slice(None) if which is None else which)
        return totals.copy()

    def hear(self, index: int, order: RecordedOrder) -> None:
        """Take an order or a mark that the crew of a boat gave."""
        self._orders[index].append(order)
        if self._ships is None or order.accepted is False:
            return
        said = parse(order.text)
        if isinstance(said, Order) and said.name == "scope":
            self._ships.raise_or_lower(index, said, order.tick)
        elif isinstance(said, Order) and said.name == REPORT_ORDER:
            self._ships.report(index, order)
        elif isinstance(said, Order) and said.name == MARK_ORDER:
            giver = order.giver
            mark = (1, order.tick, MARK_ORDER, giver.words, said.subject, "", giver.role)
            self._ships.mark(index, RecordedEvent(*mark))

    @property
    def ended(self) -> Mask:
        """Return which boats turned over, collapsed or lost their exercise."""
        ended: Mask = self._totals[:, tallies.ENDED] != 0.0
        return ended

    def _take(self, rows: Numbers, going: slice | Mask) -> None:
        ticks, count = rows.shape[1], len(self.reads)
        if self._rows.shape[1] != 1 + ticks:
            self._rows = np.zeros((len(self._tallies), 1 + ticks, self._columns))
        ours = self._rows
        ours[:, 0] = self._last
        ours[:, 1:, :count] = rows
        if self.sheet.derived:
            self._derive(ours[:, 1:])
        which = np.arange(len(ours))[going].tolist()
        seen = self._ships.watch(ours, which) if self._ships else []
        self._take_ticks(ours)
        self._last[going] = ours[going, -1]
        if any([*self._write_values(ours, which, seen)]):
            self._take_ticks(np.ascontiguousarray(ours[:, -1:]))  # none is taken, only added up

    def _take_ticks(self, rows: Numbers) -> None:
        """Take rows [boats, 1 + ticks, columns] into account."""
        flat = (rows.reshape(-1, self._columns), self._tallies.reshape(-1))
        rings = self._rings.reshape(-1, self.sheet.window)
        take_ticks(self.sheet.rows, self.sheet.conditions, *flat, rings, self._totals)

    def _derive(self, rows: Numbers) -> None:
        """Write the quantities that are made from several columns."""
        flat = rows.reshape(-1, self._columns)
        columns = dict(zip(self.reads, flat.T, strict=False))
        passage = passage_of(self._boat, columns, len(flat))
        for i, name in enumerate(self.sheet.derived, start=len(self.reads)):
            rows[..., i] = MADE_COLUMNS[name](passage).reshape(rows.shape[:2])

    def _write_values(self, rows: Numbers, which: list[int], seen: list[int]) -> Iterator[bool]:
        """Write what is told of the boats ``which``; yield whether that may be news."""
        for r, held in self._held.items():
            ticks = np.minimum(rows[which, 1:, 0], held.shape[1] - 1).astype(np.int64)
            now = conditions_hold(self.sheet, r, rows[which, 1:])
            held[np.array(which)[:, None], ticks] = now
        if self._ships:
            for index in seen:
                self._judge_look_out(index, self._ships)
                yield True
        if self._ground:
            for index in self._ground.watch(rows[:, 1:], which):
                self._judge_groundings(index, self._ground)
                yield True
        if self._answers:
            yield self._hear_answers()

    def _judge_look_out(self, index: int, watch: ShipWatch) -> None:
        """Write what a look-out is worth so far."""
        step = self.plan.method.step
        for r in self._rows_of("time-to-detect"):
            looked_at = partial(self._is_looked_at, index, r)
            found = measure_detection(watch.look_out(index), looked_at, self.sheet.rules[r], step)
            self._write_value(index, r, found)
        for r in self._rows_of("time-to-report"):
            shown = watch.first_shown(index, partial(self._is_looked_at, index, r))
            self._write_value(index, r, measure_report(shown, watch.reports(index), step))

    def _write_value(self, index: int, r: int, found: Measurement) -> None:
        value = np.nan if found.value is None else found.value
        self._write(index, r, {"answered": value, "idle": not found.counts})

    def _judge_groundings(self, index: int, ground: GroundWatch) -> None:
        """Write what groundings cost and end so far."""
        faults = ground.faults(index)
        for r in self._rows_of("aground"):
            looked_at, ticks = partial(self._is_looked_at, index, r), [each.tick for each in faults]
            self._write_value(index, r, measure_groundings(ticks, looked_at))
        hard = any(each.hard for each in ground.groundings[index])
        over = any(ground.is_over(index, each) for each in faults)
        for r, measure in enumerate(self.sheet.rows["measure"].tolist()):
            if measure >= tallies.HARD:
                capped = hard if measure == tallies.HARD else bool(faults)
                self._write(index, r, {"extreme": capped, "held": over})

    def _is_looked_at(self, index: int, r: int, tick: int) -> bool:
        """Return whether a rule looks at a tick of a boat that was taken."""
        row, onset, held = self.sheet.rows[r], self._tallies[index, r]["onset"], self._held.get(r)
        if row["since"] and not onset:
            return False
        since = onset - 1.0 if row["since"] else 0.0
        inside = since + row["begin"] - 1e-6 <= tick <= since + row["end"] + 1e-6
        return bool(inside and (held is None or held[index, tick]))

    def _rows_of(self, measure: str) -> list[int]:
        """Return the rules with a measure."""
        rules = enumerate(self.sheet.rules)
        return [r for r, rule in rules if rule.score.measure == measure]

    def _write(self, index: int, r: int, values: Mapping[str, float]) -> None:
        """Write numbers into the tally of a rule."""
        for name, value in values.items():
            self._tallies[index, r][name] = value

    def _hear_answers(self) -> bool:
        """Write when each casualty was answered; return whether that is news."""
        changed, step = False, self.plan.method.step
        for index, orders in enumerate(self._orders):
            for r, rule in self._answers:
                tally = self._tallies[index, r]
                if not (orders and tally["onset"] and rule.casualty):
                    continue
                begun, was = int(tally["onset"]) - 1, float(tally["answered"])
                heard = replace(passage_of(self._boat, {}, 1), orders=tuple(orders))
                answer = answer_to(
                    heard, Episode(rule.casualty.kind, begun, None, 0.0), rule.score.orders
                )
                now = np.nan if answer is None else (answer.tick - begun) * step
                tally["answered"] = now
                changed = changed or not (now == was or (np.isnan(now) and np.isnan(was)))
        return changed


def asks_for_ships(plan: Plan) -> bool:
    """Return whether a rule is about ships or the periscope, also where there are none."""
    measures = {rule.score.measure for rule in plan.scores}
    eyes = [condition.quantity for rule in plan.scores for condition in rule.conditions]
    eyes += [condition.quantity for loss in plan.lost for condition in loss.conditions]
    eyes += [rule.measured.name for rule in plan.scores if rule.measured]
    asked = bool(measures & {*SHOWN_MEASURES, *LOOK_OUT_MEASURES}) or "eye" in eyes
    return asked or plan.limits.cpa_m_min is not None


def nobody_aboard(plan: Plan, width: str = "qualified") -> dict[str, float]:
    """Return the marks of a plan's rules with nobody aboard at its seed."""
    return plain_marks(fly_rehearsal(plan.alone()).trajectory, plan, width)
