"""The boat of the Python face: a session without a clock, run by calls.

``trainer.Boat`` is it. A headless run and this boat share the code that plans, makes ready, orders
and ticks. So the bits are the same.
"""

import contextlib
import math
import threading
from array import array
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self

import numpy as np

from trainer.api.by_number import BoatByNumber
from trainer.boat.depths import collapse_of
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise.exercise import StartState
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError, quote, remembering
from trainer.config.keywords import RUN_KEYWORDS, reading_keywords
from trainer.config.schema import Kind, kinds_of
from trainer.core.kernel import Numbers
from trainer.io.orders.grammar import BadOrder, Refused, parse, to_the_crew
from trainer.io.orders.schedule import MAX_TIME_S
from trainer.io.orders.words import BOAT_ORDERS, CREW_TALK
from trainer.io.recording.absence import OrderMemory
from trainer.io.recording.facts import station
from trainer.io.recording.recording import Moment, RecordedOrder
from trainer.io.status_line import course
from trainer.io.tables import MOTION_COLUMNS, Cell
from trainer.session.crew.agenda import Agenda
from trainer.session.exercise.terms import Terms
from trainer.session.jump import jump_to
from trainer.session.parts import Monitors
from trainer.session.past.header import header_of, refusing_damage
from trainer.session.past.history import History
from trainer.session.past.layout import LAYOUT
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run, refuse_depth
from trainer.session.ready import crew_talk, ready_boat
from trainer.session.session import ColumnFile, Session
from trainer.session.stations.subscriptions import PromptSender, Roster
from trainer.session.stations.view import StateReader
from trainer.session.time.pacer import MonotonicClock, Policy
from trainer.session.time.timekeeping import Timekeeping
from trainer.units import KNOT

if TYPE_CHECKING:
    from trainer.io.recording.recording import Recording
    from trainer.session.stations.station import News

ORDER_GIVER: Final = station("instructor", "python")  # who gives the orders, in the journal
INITIAL_KEYS: Final = {"speed": "speed_kn", "depth": "depth_m", "course": "course_deg"}
BOAT_KEYWORDS: Final = {
    **RUN_KEYWORDS,
    **{name: kinds_of(StartState)[key] for name, key in INITIAL_KEYS.items()},
}
ROW_WIDTH: Final = len(MOTION_COLUMNS)


@dataclass(frozen=True)
class Snapshot:
    """A moment of a boat, to go back to by ``Boat.restore``. ``time`` is its time [s]."""

    time: float
    _moment: Moment = field(repr=False)
    _of: object = field(repr=False)
    _plan: Plan = field(repr=False)

    def is_of(self, boat: object) -> bool:
        """Return whether it is a moment of that very boat."""
        return self._of is boat

    def is_foreign(self, boat: object) -> bool:
        """Return whether it is a moment of another ``Boat``, with a journal of its own."""
        return isinstance(self._of, Boat) and not self.is_of(boat)

    def moment_for(self, plan: Plan) -> Moment:
        """Return the moment for a boat of that plan; TrainerError for another kind."""
        if (plan.file, plan.method) != (self._plan.file, self._plan.method):
            raise ConfigError("restore: this snapshot is of another vessel file, or another method")
        return self._moment


class Flown(NamedTuple):
    """What a boat has flown, as its copy takes it over."""

    moment: Moment  # its last
    orders: tuple[RecordedOrder, ...]
    rows: "array[float]"
    events: "tuple[News, ...]"


class Boat:
    """A boat that is ordered and run by calls, as fast as it goes.

    ``vessel`` is the name of a shipped boat or the path of a vessel file. Without it the boat is
    that of the exercise, or ``bb2``. The keywords are the options of ``trainer run``, but for the
    start and the names:

    - ``exercise``: name or path of an exercise. Its orders, casualties and sea come as in a
      headless run.
    - ``speed`` [kn], ``depth`` [m], ``course`` [degrees]: where the boat begins, in trim. Without
      them it begins as the exercise or the vessel file says, else to the north.
    - ``sea``: name or path of a sea. ``seed``: of everything random.
    - ``equations``, ``rates``, ``trig``, ``integrator``, ``step`` [s], ``unsafe_step``: how the
      boat is computed.
    - ``battery``: ``endless`` is never drained.
    - ``orders``: path of a schedule, which has a line ``SECONDS ORDER`` for each order.
    - ``record``: path of a recording to write. ``close`` ends it, and so does the end of a ``with``
      statement.

    ``copy.copy`` and ``copy.deepcopy`` give another boat at the same moment, to the bit, with what
    was flown. So does pickle, where the vessel file and the exercise are the same. No copy is
    recorded, and snapshots are of their own boat.

    TrainerError naming what is wrong, the keyword and its limits, and for a call that comes
    while another thread's is under way: give each thread a boat of its own.
    """

    def __init__(self, vessel: str | Path | None = None, **options: Any) -> None:
        self._asked = {"vessel": vessel, **options}
        with remembering() as texts:
            chosen, self._plan = plan_boat(self._asked)
        if chosen.record and any(self._asked.get(name) is not None for name in INITIAL_KEYS):
            raise ConfigError(
                "record=: a recorded run begins as its exercise or vessel file says, so that it "
                "can be replayed; leave out speed, depth and course, or write an exercise"
            )
        self._given = self._asked | {"record": None}  # to a copy
        self._boat = ready_boat(self._plan, chosen)
        state = self._boat.records.state.tobytes()
        keeper: Recording | OrderMemory = OrderMemory()
        if chosen.record:
            from trainer.session.run import create_recording

            header = header_of(chosen, texts, self._boat)
            _, keeper = create_recording((chosen.record,), header, state)
        self._keeper = keeper
        self._lock = threading.Lock()
        self._rows = _TickRows()
        self._events: list[News] = []
        self._closing: list[RecordedOrder] | None = None  # the orders, once the boat is closed
        self._session = self._begin(chosen)

    def _begin(self, chosen: RunOptions) -> Session:
        """Return a session without consoles, stations and pages, which calls run."""
        boat, plan = self._boat, self._plan
        time = Timekeeping.at(MonotonicClock(), boat.method.step, math.inf, Policy(chosen.overrun))
        session = Session(
            boat,
            time,
            History(boat, self._keeper),
            PromptSender(Roster(StateReader(boat, time.ledger.summary))),
            Agenda(boat, plan.schedule),
            crew_talk(plan, boat),
            Monitors.over(boat, LimitMonitor.over(boat, plan.limits)),
            terms=Terms(plan),
            rows=ColumnFile(self._rows, MOTION_COLUMNS),
        )
        session.event_log.hearers.append(self._events.append)
        self._rows.row(boat.numbers(MOTION_COLUMNS))
        return session

    def order(self, words: str) -> str:
        """Give an order in the console's words, such as ``depth 80``; return its answer.

        It acts at once, on the next tick. TrainerError with the console's words where it is no
        order, or is refused. Orders about time and moments are the calls ``run``, ``snapshot``
        and ``restore``.
        """
        if not isinstance(words, str):
            type_name = type(words).__name__
            raise ConfigError(f"order(): an order is text, such as 'depth 80', not {type_name}")
        said = parse(words)
        if said is None:
            raise ConfigError("no order: say one, such as depth 80")
        if isinstance(said, BadOrder):
            raise ConfigError(said.reason)
        order = to_the_crew(said)
        if order.name not in BOAT_ORDERS | CREW_TALK:
            raise ConfigError(
                f"{order.text}: is an order of a session; here time and moments are the calls "
                "run(), snapshot() and restore()"
            )
        with self._alone(), np.errstate(all="ignore"):
            self._refuse_closed()
            answer = self._session.dispatch.give(order, ORDER_GIVER)
        if isinstance(answer, Refused):
            raise ConfigError(answer.reason)
        return answer

    def run(self, seconds: float | None = None) -> None:
        """Run the boat for so many seconds [s], to the nearest tick, one at least.

        Without a number it runs to the end of the exercise. TrainerError if the boat is lost on
        the way: it stays as it was then, and can go back to a snapshot. TrainerError also if a
        collision or the ground stops it where the exercise says ``freeze``: ``run`` goes on.
        """
        with self._alone(), np.errstate(all="ignore"):
            self._refuse_closed()
            if self.lost:
                raise ConfigError(f"this boat cannot go on: {self.lost}; go back to a snapshot")
            hull, hull.halted = self._session.conduct.damage_watch, ""
            self._session.last_tick = self._last_tick(seconds)
            self._session.run()
        if self.lost:
            raise ConfigError(f"frozen at {self.time:g} s: {self.lost}")
        if hull.halted:
            raise ConfigError(f"frozen at {self.time:g} s by {hull.halted}; run() goes on")

    def _last_tick(self, seconds: float | None) -> int:
        """Return the tick to run to; ConfigError if that is none."""
        step, end = self._boat.method.step, self._plan.duration
        if seconds is None and end is None:
            raise ConfigError("run how long? say run(seconds); only an exercise has an end")
        if seconds is None:
            return round((end or 0.0) / step)
        if not isinstance(seconds, Real):
            type_name = type(seconds).__name__
            raise ConfigError(f"run(): give a number of seconds, such as run(900), not {type_name}")
        if not 0.0 < seconds <= MAX_TIME_S:
            longest = f"a run lasts longer than 0 s, and ends, within {MAX_TIME_S:g} s"
            raise ConfigError(f"run({quote(seconds)}): {longest}")
        return self._boat.ticks + max(round(seconds / step), 1)

    def by_number(
        self, orders: Sequence[str], reads: Sequence[str], ticks: int = 1
    ) -> BoatByNumber:
        """Return what orders this boat by numbers, and reads numbers, at each step.

        ``orders`` are such as ``rudder``, ``stern``, ``bow``, ``depth`` or ``turns``; ``reads``
        are names of ``state``; a step goes on by so many ``ticks``. TrainerError for a boat that
        is recorded, in an exercise or with a schedule: what happens there comes by ``run``.
        """
        with self._alone():
            self._refuse_closed()
            for name in ("record", "exercise", "orders"):
                if self._asked.get(name) is not None:
                    raise ConfigError(f"by_number: not with {name}=, which is for run()")
            return BoatByNumber(self._boat, self._lock, orders, reads, ticks)

    @property
    def time(self) -> float:
        """Return the simulated time [s] since the start."""
        return self._boat.time

    @property
    def state(self) -> dict[str, float]:
        """Return a copy of the state by the core's names, in SI and radians.

        ``u`` [m/s] is the speed ahead, ``z`` [m] the depth, ``psi`` [rad] the heading, ``theta``
        [rad] the pitch; the names are those of a recording's columns. Rates such as ``psidot`` are
        those with which the last tick began.
        """
        return dict(zip(LAYOUT, self._boat.plain.tolist(), strict=True))

    @property
    def columns(self) -> dict[str, Numbers]:
        """Return what was flown, an array for each column of ``trainer run --csv``.

        SI units and radians, a number for each tick from the start on; ``t`` is the time [s].
        """
        with self._alone():
            return self._rows.columns()

    def frame(self) -> Any:
        """Return ``columns`` as a pandas frame, with the time ``t`` [s] as its index.

        TrainerError where pandas is not installed; the extra ``pandas`` brings it.
        """
        from trainer.debrief.passage.recording_export import frame_of

        return frame_of(self.columns)

    @property
    def orders(self) -> list[dict[str, Cell]]:
        """Return the orders so far: ``t`` [s], ``who``, ``text``, ``accepted`` and ``answer``."""
        step = self._boat.method.step
        with self._alone():
            journal = self._journal()
        text_keys = ("who", "text", "accepted", "answer")
        return [
            {"t": entry.tick * step, **{name: getattr(entry, name) for name in text_keys}}
            for entry in journal
        ]

    def _journal(self) -> list[RecordedOrder]:
        """Return the orders of the present branch. A closed boat has those of its end."""
        if self._closing is not None:
            return self._closing
        with refusing_damage():
            return self._keeper.orders(self._keeper.branch)

    @property
    def events(self) -> list[dict[str, Cell]]:
        """Return what has happened so far: ``t`` [s], ``kind`` and ``text``."""
        return [{"t": each.seconds, "kind": each.kind, "text": each.text} for each in self._events]

    @property
    def lost(self) -> str:
        """Return why the boat cannot go on, "" while it can."""
        ending = self._session.conduct.ending
        why = ending.why if ending.outcome is Outcome.LOST else ""
        return self._session.control.failure or why or collapse_of(self._boat)

    def snapshot(self) -> Snapshot:
        """Return this moment, whole: state, sea, tanks, casualties, and what is still scheduled."""
        with self._alone():
            return Snapshot(self.time, self._session.history.now(), self, self._plan)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a moment of this boat, to the bit. What came after it is forgotten.

        A recording keeps it, on the branch that is left. A moment from a ``Fleet`` of the same
        vessel file does, too. TrainerError for another boat's.
        """
        if not isinstance(snapshot, Snapshot) or snapshot.is_foreign(self):
            raise ConfigError("restore: this is no snapshot, or one of another boat")
        with self._alone(), np.errstate(all="ignore"):
            self._refuse_closed()
            moment = snapshot.moment_for(self._plan)
            if not snapshot.is_of(self):
                now = self._session.history.now()
                moment = replace(now, tick=moment.tick, state=moment.state)
            jump_to(self._session, moment, f"restore, by {ORDER_GIVER}")
            self._rows.cut(self._boat.ticks)
            self._events[:] = [each for each in self._events if each.tick <= self._boat.ticks]

    def close(self) -> None:
        """End the run and its recording, if there is one. What was flown can still be read.

        TrainerError if the recording could not be written whole.
        """
        with self._alone():
            if self._closing is not None:
                return
            self._closing = self._journal()
            self._keeper.close()
        if self._keeper.missing or self._keeper.trouble:
            raise ConfigError(f"NOT RECORDED: {self._keeper.missing}; {self._keeper.trouble}")

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        """Hold the boat for one call; ConfigError while another thread holds it."""
        if not self._lock.acquire(blocking=False):
            raise ConfigError(
                "another thread is at this boat: one call at a time; give each thread its own boat"
            )
        try:
            yield
        finally:
            self._lock.release()

    def __reduce__(self) -> tuple[Any, ...]:
        with self._alone():
            self._refuse_closed()
            moment = replace(self._session.history.now(), branch=1)
            flown = Flown(moment, (*self._journal(),), self._rows.numbers[:], (*self._events,))
        return _another_boat, (self._given, flown)

    def _take_over(self, flown: Flown) -> None:
        """Be where another boat of this plan is."""
        self._keeper = self._session.history.recording = OrderMemory(flown.orders)
        self._session.in_force.read(flown.orders)
        with np.errstate(all="ignore"):
            jump_to(self._session, flown.moment, "copied")
        self._rows.numbers[:] = flown.rows
        self._events[:] = flown.events

    def _refuse_closed(self) -> None:
        """Raise ConfigError if the boat is closed."""
        if self._closing is not None:
            raise ConfigError("this boat is closed: what was flown can be read, and no more flown")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        s = self._boat.state
        where = f"{s.u / KNOT:.4g} kn, {s.z:.5g} m, course {course(math.degrees(s.psi), 1)}"
        return f"{self._boat.file.name}: {self.time:g} s, {where}"


def _another_boat(given: Mapping[str, Any], flown: Flown) -> Boat:
    """Return a boat that was begun as another, and is where that is."""
    boat = Boat(**given)
    boat._take_over(flown)  # noqa: SLF001  its own kind
    return boat


class _TickRows:
    """The columns of each tick that was run, in memory."""

    trouble = ""

    def __init__(self) -> None:
        self.numbers = array("d")

    def row(self, values: Sequence[float]) -> None:
        """Take the columns of one tick, unless they are here."""
        if not self.numbers or values[0] > self.numbers[-ROW_WIDTH]:
            self.numbers.extend(values)

    def cut(self, tick: int) -> None:
        """Drop the rows after a tick."""
        del self.numbers[bisect_right(self.numbers[::ROW_WIDTH], tick) * ROW_WIDTH :]

    def columns(self) -> dict[str, Numbers]:
        """Return copies of the columns, by name."""
        table = np.array(self.numbers).reshape(-1, ROW_WIDTH)
        return {name: table[:, i].copy() for i, name in enumerate(MOTION_COLUMNS)}


def plan_boat(
    keywords: Mapping[str, Any], kinds: Mapping[str, Kind] = BOAT_KEYWORDS, call: str = "Boat"
) -> tuple[RunOptions, Plan]:
    """Return options and plan of a boat by a call's keywords; ConfigError."""
    with reading_keywords(call, kinds, keywords) as asked:
        start = {key: asked.pop(name) for name, key in INITIAL_KEYS.items() if name in asked}
    if "orders" in asked:
        asked["orders_file"] = asked.pop("orders")
    given = frozenset(asked)
    chosen = RunOptions(**asked, headless=True, speed=math.inf, given=given)
    plan = plan_run(chosen)
    refuse_depth(start.get("depth_m"), plan.file, f"{call}: depth")
    return chosen, replace(plan, initial=replace(plan.initial, **start))
