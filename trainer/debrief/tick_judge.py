"""The marks of an exercise at each tick, as of a record ending there.

Whoever learns or plans asks at every step, so that what a flight earns is its mark to rounding. An
instructor who asks what could still be earned asks ``evaluator``. ``judge_run`` gives the same
marks of a whole record; here each tick is taken into account once, in machine code (``tallies``).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.debrief import tallies
from trainer.debrief.episodes import Episode, answer_to
from trainer.debrief.judgement import plain_marks
from trainer.debrief.rehearsal import fly_rehearsal
from trainer.debrief.tallies import TALLY, take_ticks
from trainer.debrief.tally_sheet import lay_out, passage_of
from trainer.debrief.trajectory import QUANTITY_FUNCTIONS
from trainer.io.recording.recording import RecordedOrder
from trainer.session.past.plan import Plan

Mask = NDArray[np.bool_]


class TickJudge:
    """The judge of some boats in one exercise, each at a tick of its own.

    ``reads`` are the numbers of the state that it looks at. A boat ``begin``s, then ``look`` takes
    its next ticks and gives the total [%] of a record that ends there, 0 where marks are void.
    ``hear`` takes an order that the crew gave, where a rule asks for answers.

    ConfigError naming the rule that numbers of one boat cannot judge.
    """

    def __init__(self, plan: Plan, count: int = 1, width: str = "qualified") -> None:
        self.plan, self.width = plan, width
        self._boat = plan.launch_boat()
        self.sheet = sheet = lay_out(plan, self._boat, width)
        self.reads = sheet.reads
        self._tallies = np.zeros((count, sheet.rows.size), TALLY)
        self._rings = np.zeros((count, sheet.rings, sheet.window))
        self._columns = len(sheet.reads) + len(sheet.derived)
        self._last = np.zeros((count, self._columns))  # the tick that was taken last
        self._rows = np.zeros((count, 1, self._columns))
        self._orders: list[list[RecordedOrder]] = [[] for _ in range(count)]
        answers = np.flatnonzero(sheet.rows["measure"] == tallies.RESPONSE)
        self._answers = [(r, sheet.rules[r]) for r in answers.tolist()]
        self._totals = np.zeros((count, 2))

    def begin(self, index: int, start: Numbers, nobody: Mapping[str, float]) -> float:
        """Begin with a boat whose ``reads`` are those at the start; return its total.

        ``nobody`` are the marks with nobody aboard at its seed, by the rules' names.
        """
        own = self._tallies[index]
        own[:] = np.zeros((), TALLY)
        for r, rule in enumerate(self.sheet.rules):
            own[r]["free"] = nobody.get(rule.score.name, 0.0)
            own[r]["answered"] = np.nan
        self._rings[index] = 0.0
        self._orders[index].clear()
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
        """Take an order that the crew of a boat gave at its tick."""
        self._orders[index].append(order)

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
        sheet, later = self.sheet, (self._tallies, self._rings, self._totals)
        take_ticks(sheet.rows, sheet.conditions, ours, *later)
        self._last[going] = ours[going, -1]
        if self._answers and self._hear_answers():
            none = np.ascontiguousarray(ours[:, -1:])  # no tick is taken, only added up
            take_ticks(sheet.rows, sheet.conditions, none, *later)

    def _derive(self, rows: Numbers) -> None:
        """Write the quantities that are made from several columns."""
        flat = rows.reshape(-1, self._columns)
        columns = dict(zip(self.reads, flat.T, strict=False))
        passage = passage_of(self._boat, columns, len(flat))
        for i, name in enumerate(self.sheet.derived, start=len(self.reads)):
            rows[..., i] = QUANTITY_FUNCTIONS[name](passage).reshape(rows.shape[:2])

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


def nobody_aboard(plan: Plan, width: str = "qualified") -> dict[str, float]:
    """Return the marks of a plan's rules with nobody aboard at its seed."""
    return plain_marks(fly_rehearsal(plan.alone()).trajectory, plan, width)
