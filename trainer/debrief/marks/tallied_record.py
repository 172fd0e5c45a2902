"""A whole record by the rules' rows, and what each rule made of it.

A passage is what was flown to the end of a branch of a recording (``trajectory``). ``tallies``
counts its ticks; ``scoring``, ``gates`` and ``judgement`` ask here for values and moments.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trainer.config.exercise.score_rules import ScoreRule
from trainer.core.kernel import Numbers
from trainer.debrief.marks import tallies
from trainer.debrief.marks.mark_numbers import HELD_TIME_S
from trainer.debrief.marks.measures import (
    MADE_COLUMNS,
    Measurement,
    lacking,
    measure_alerts,
    measure_detection,
    measure_groundings,
    measure_report,
)
from trainer.debrief.marks.tallies import TALLY, take_ticks
from trainer.debrief.marks.tally_sheet import TallySheet, begin_tallies, lay_out
from trainer.debrief.passage.episodes import answer_to, first_spell
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.ships_met import (
    look_out,
    meet_ships,
    reports_near_ships,
    shown_rows,
)
from trainer.debrief.passage.trajectory import RowMask, Trajectory
from trainer.session.past.plan import Plan

NOT_THERE: Final = Measurement(None, None, "it did not happen", counts=False)
TOLD_MEASURES: Final = ("response", *tallies.MEASURE_NAMES[tallies.AGROUND :])
IDLE_WORDS: Final = {
    "activity": "a single moment",
    "hand-travel": "a single moment",
    "closest-approach": "there was no ship",
}


@dataclass(frozen=True)
class TalliedRecord:
    """A passage, and the tallies of all its ticks by the rows of a sheet."""

    trajectory: Trajectory
    sheet: TallySheet
    tallies: Any  # [rows] of TALLY
    rings: Numbers  # [rings, ticks] how far off a quantity was in the last of them

    def caps(self, kind: int) -> list[tuple[Any, Any, Any]]:
        """Return what of a kind caps the marks: key, row and tally."""
        first = len(self.sheet.rules)
        rows = zip(self.sheet.caps, self.sheet.rows[first:], self.tallies[first:], strict=True)
        return [each for each in rows if each[1]["measure"] == kind and each[2]["extreme"]]

    def measurement(self, rule: ScoreRule) -> Measurement:
        """Return the value of a rule, and where it was, or why there is none."""
        if why := lacking(self.trajectory.boat, rule):
            return Measurement(None, None, why, counts=False)
        place = next(r for r, each in enumerate(self.sheet.rules) if each is rule)
        tally, measure = self.tallies[place], rule.score.measure
        if not tally["rows"] and (none := self._unseen(rule)):
            return none
        if measure in TOLD_MEASURES:
            return measure_told(self.trajectory, rule)
        idle = np.isinf(tally["extreme"]) if measure == "closest-approach" else not tally["travel"]
        if idle and measure in IDLE_WORDS:
            return Measurement(None, None, IDLE_WORDS[measure], counts=False)
        value, tick = float(tally["value"]), int(tally["at"])
        if np.isnan(value):
            return Measurement(None, None, self._why_none(rule, tally))
        if measure == "distance":
            tick = int(tally["last_tick"])
        if measure == "settled":
            ring = self.rings[int(self.sheet.rows[place]["ring"])]
            ticks = int(tally["last_tick"]) - np.arange(ring.size)[::-1]
            tick = int(ticks[np.nanargmax(ring[ticks % ring.size])])
        if measure == "beyond-test-depth" and not value:
            tick = -1
        return Measurement(value, tick if tick >= 0 else None)

    def _unseen(self, rule: ScoreRule) -> Measurement | None:
        """Return that a rule has looked at no tick, and why."""
        rows, flown = looked_at(self.trajectory, rule), self.trajectory
        if rows is None:
            return NOT_THERE
        if not rows.any():
            why = f"the record ends at {flown.seconds[-1]:g} s"
            return Measurement(None, None, why, counts=False, beyond_record=True)
        return Measurement(None, None, f"never {rule.score.when}") if rule.conditions else None

    def _why_none(self, rule: ScoreRule, tally: Any) -> str:
        """Return why there is no value where ticks were looked at."""
        measure, unit = rule.score.measure, rule.measured.unit if rule.measured else ""
        band = rule.score.band or 0.0
        if measure == "overshoot":
            return "the target was never reached"
        if measure == "rms":
            return f"{rule.score.when} for less than {HELD_TIME_S:g} s"
        if measure != "time-to" and tally["began_inside"]:
            return f"already within {f'{band:g} {unit}'.rstrip()} of it when it was ordered"
        beyond = abs(float(tally["last_off"])) - band
        far = f"{float(f'{beyond:.2g}'):g} {unit}"  # two digits that count
        return f"not in the band at the end, {far} beyond it"


def tally_record(
    trajectory: Trajectory, rules: Sequence[ScoreRule], plan: Plan | None = None
) -> TalliedRecord:
    """Return a passage that is tallied by rules, and by what loses a plan's exercise."""
    sheet = lay_out(rules, trajectory.boat, trajectory.limits, plan)
    names = (*sheet.reads, *sheet.derived, *sheet.of_ships)
    rows = np.empty((1 + trajectory.ticks.size, len(names)))
    for i, name in enumerate(names):
        rows[1:, i] = _column(trajectory, name)
    rows[0] = rows[1]
    taken = np.zeros(sheet.rows.size, TALLY)
    rings = np.empty((sheet.rings, sheet.window))
    begin_tallies(taken, rings)
    take_ticks(sheet.rows, sheet.conditions, rows, taken, rings, np.zeros((1, 2)))
    return TalliedRecord(trajectory, sheet, taken, rings)


def _column(trajectory: Trajectory, name: str) -> Numbers | RowMask:
    """Return a column of a sheet, made of the whole passage where it is not of the state."""
    if name == "tick":
        return trajectory.ticks.astype(np.float64)
    if name == "nearest":
        return meet_ships(trajectory).nearest
    if name == "struck":
        return np.isin(trajectory.ticks, [tick for tick, _ in meet_ships(trajectory).collisions])
    if name in ("head_out", "raise"):
        return shown_rows(trajectory)[name == "raise"]
    return MADE_COLUMNS[name](trajectory) if name in MADE_COLUMNS else trajectory.columns[name]


def looked_at(trajectory: Trajectory, rule: ScoreRule) -> RowMask | None:
    """Return the ticks that a rule looks at, whatever its conditions.

    None: the casualty from which they count did not come.
    """
    begin, end = rule.score.from_s, rule.score.to_s
    if rule.since is not None:
        episode = first_spell(trajectory, rule.since)
        if episode is None:
            return None
        onset = episode.begun * trajectory.boat.method.step
        begin, end = onset + (begin or 0.0), None if end is None else onset + end
    return trajectory.between(begin, end)


def measure_told(trajectory: Trajectory, rule: ScoreRule) -> Measurement:
    """Return a value that others tell: of ships, the ground, alerts or answers."""
    step, ticks, measure = trajectory.boat.method.step, trajectory.ticks, rule.score.measure
    if measure == "response":
        return _measure_response(trajectory, rule)
    rows = looked_at(trajectory, rule)
    rows = np.zeros(ticks.size, bool) if rows is None else rows
    for condition in rule.conditions:
        rows &= trajectory.holds(condition)
    is_looked_at = set(ticks[rows].tolist()).__contains__
    if measure == "time-to-detect":
        return measure_detection(look_out(trajectory), is_looked_at, rule, step)
    if measure == "time-to-report":
        shown = filter(is_looked_at, ticks[shown_rows(trajectory)[0]].tolist())
        return measure_report(next(shown, None), reports_near_ships(trajectory), step)
    if measure == "alert-response":
        return measure_alerts(trajectory.alerts, is_looked_at, rule, step, int(ticks[-1]))
    faults = (int(ticks[each.row]) for each in groundings(trajectory) if each.at_fault)
    return measure_groundings(faults, is_looked_at)


def _measure_response(trajectory: Trajectory, rule: ScoreRule) -> Measurement:
    """Return the time [s] from the casualty's first onset to the crew's answer."""
    episode = first_spell(trajectory, rule.casualty)
    if episode is None:
        return NOT_THERE
    answer = answer_to(trajectory, episode, rule.score.orders)
    if answer is None:
        return Measurement(None, None, "it was not answered")
    return Measurement((answer.tick - episode.begun) * trajectory.boat.method.step, answer.tick)
