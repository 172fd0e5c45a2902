"""The quiet ticks of a session, without a call, flown many at once.

A run that keeps no time and that nobody watches need not look at each of its ticks. It flies some
in one call of machine code, and the monitors say how many of them go by without a call. The boat
goes back to the end of these, and there takes one tick as any session does (``session.tick``). So
states, orders and events are the same. The recording gets each state; of the work it gets the mean.

A session takes each tick by itself where somebody looks at each or may do something after it: a
station, a plan, a replay, a guard of the planes, somebody who meets a swing, an
exercise that can be lost, a lesson, or a recording in trouble.
"""

import math
from typing import Final

import numpy as np

from trainer.boat.depths import has_collapsed
from trainer.boat.flown_ticks import ALL_OFFSETS, FlownTicks, count_before
from trainer.core.kernel import Numbers
from trainer.session.parts import Parts
from trainer.session.stations.subscriptions import PromptSender
from trainer.session.time.pacer import FreePacer

MIN_STRIDE_TICKS: Final = 16  # ticks below which flying at once takes longer than one by one
MAX_STRIDE_TICKS: Final = 512  # whole states of so many are 2.5 MB
MAX_REST_TICKS: Final = 256  # taken one by one where nearly each has something to say


class QuietTicks:
    """The quiet ticks of a session."""

    def __init__(self, session: Parts) -> None:
        self._session = session
        self._stride = MIN_STRIDE_TICKS
        self._rest = self._resting = 0  # [ticks] to be taken one by one: at most, and still
        self._flown = FlownTicks(np.empty((0, ALL_OFFSETS.size)), session.boat.method.step)

    def rows_of(self, columns: tuple[str, ...]) -> list[list[float]]:
        """Return these columns of the ticks flown last, a row for each."""
        return self._flown.table(columns)

    def fly(self, last_tick: float) -> int:
        """Fly ticks in which nobody has anything to say; return how many, 0 for none."""
        if self._resting:
            self._resting -= 1
            return 0
        boat, pacer = self._session.boat, self._session.time.pacer
        if not isinstance(pacer, FreePacer) or self._is_watched():
            return 0
        count = min(self._end(last_tick) - boat.ticks, self._stride)
        if count < MIN_STRIDE_TICKS:
            return 0
        pacer.begin()
        rows = np.empty((int(count), ALL_OFFSETS.size))
        _, rows = boat.fly_and_keep(ALL_OFFSETS, rows, self._quiet_ticks)
        self._adapt(len(rows), int(count))
        if len(rows):
            self._pass_over(FlownTicks(rows, boat.method.step))
            pacer.end(len(rows))
            self._keep()
        return len(rows)

    def _is_watched(self) -> bool:
        """Return whether somebody looks at each tick, or may do something after it."""
        session, log = self._session, self._session.event_log
        sending, conduct, crew = session.sending, session.conduct, session.crew
        heard = log.stations or not isinstance(sending, PromptSender) or not sending.roster.empty
        shown = session.history.flown.shows_way
        guarded = crew.meeting or not math.isinf(crew.work.guard.deepest) or session.agenda.planned
        recording = session.history.recording
        troubled = conduct.ending.watched or recording.trouble or recording.behind
        return bool(heard or shown or guarded or troubled or conduct.guide.steps)

    def _end(self, last_tick: float) -> float:
        """Return the tick to which nobody orders anything."""
        session = self._session
        due = session.history.flown.next_due(session.agenda.schedule)
        return min(last_tick, due, session.crew.due - 1)

    def _quiet_ticks(self, rows: Numbers) -> int:
        """Return how many of the ticks flown go by before there may be a call."""
        session, boat = self._session, self._session.boat
        flown, monitors = FlownTicks(rows, boat.method.step), session.monitors
        counts = [count_before(has_collapsed(boat, flown))] if len(rows) else [0]
        ground = session.conduct.damage_watch.ground
        watches = monitors.depths, monitors.pilot, monitors.plant, ground, monitors.limits
        for monitor in watches:
            if counts[-1]:
                counts.append(monitor.quiet_ticks(boat, flown))
        return min(counts)

    def _adapt(self, kept: int, flown: int) -> None:
        """Fly more at once where all is quiet, and less where much is called.

        Ticks flown beyond the first call are flown in vain.
        """
        self._stride = min(2 * flown if kept == flown else max(kept, flown // 2), MAX_STRIDE_TICKS)
        self._stride = max(self._stride, MIN_STRIDE_TICKS)
        self._rest = 0 if kept else min(2 * self._rest + MIN_STRIDE_TICKS, MAX_REST_TICKS)
        self._resting = self._rest

    def _pass_over(self, flown: FlownTicks) -> None:
        """Have all monitors take the ticks as seen."""
        session, self._flown = self._session, flown
        session.monitors.pilot.pass_over(session.boat, flown)
        session.monitors.plant.pass_over(session.boat, flown)
        session.monitors.limits.pass_over(session.boat, flown)
        session.conduct.damage_watch.ground.pass_over(session.boat, flown)
        session.conduct.look()

    def _keep(self) -> None:
        """Record each state; keep the moments in memory, as after a tick of its own."""
        history, ledger = self._session.history, self._session.time.ledger
        flown = history.flown
        for tick, state in zip(self._flown.ticks.tolist(), self._flown.rows, strict=True):
            flown.keep(tick, state.tobytes())
            flown.keep_timing(tick, ledger.lateness, ledger.work)
