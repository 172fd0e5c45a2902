"""The session: boat, clock, recording and stations, joined in the thread that ticks."""

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.boat import TICK, Boat
from trainer.boat.casualties import available, listing
from trainer.boat.depths import DepthGuard, DepthMonitor
from trainer.boat.helm import obey
from trainer.boat.limits import LimitMonitor
from trainer.boat.pilot import PilotMonitor
from trainer.config.exercise import Armed
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.schedule import Scheduled
from trainer.io.orders.table import BOAT_ORDERS, CREW_TALK
from trainer.io.recording.recording import Moment, RecordingError
from trainer.io.tables import Columns
from trainer.session.agenda import HEAD as PLANNED
from trainer.session.agenda import PLANNING, Agenda
from trainer.session.conduct import Conduct
from trainer.session.control import Alarm, Control
from trainer.session.crew import SCHEDULE, CrewTalk, Telling, role_of
from trainer.session.event_log import CREW, MOMENTS, TIME, EventLog
from trainer.session.history import History
from trainer.session.manning import unheard
from trainer.session.standing import Standing
from trainer.session.stations.briefing import Briefing, hint, in_words, ranges
from trainer.session.stations.display import panel
from trainer.session.stations.roles import INSTRUCTOR, STRANGER, Role
from trainer.session.stations.station import Asked, Fact, Reception, Station
from trainer.session.stations.subscriptions import Sending
from trainer.session.stations.view import Pace, Picture, StateReader
from trainer.session.status import status_lines
from trainer.session.time.ledger import SECOND
from trainer.session.time.pacer import WOKEN, Event
from trainer.session.time.timekeeping import Timekeeping

AT_A_TIME: Final = SECOND // 5  # [ns] of single steps before the stations are heard again
LINES_AT_A_TIME: Final = 32  # of one station before the clock is looked at again
PATIENCE: Final = 0.5  # [s] for a line to get out what it was sent before it is closed
QUESTIONS: Final = frozenset({"status", "who", "briefing", "casualties", "log", "plans"})
OF_THE_BOAT: Final = BOAT_ORDERS | CREW_TALK | PLANNING  # journalled, and none in a replay


@dataclass
class Session:
    """One run from its first tick to its end."""

    boat: Boat
    time: Timekeeping
    history: History
    recorder: Columns
    columns: tuple[str, ...]
    sending: Sending
    reception: Reception | None = None
    schedule: Sequence[Scheduled] = ()
    armed: Sequence[Armed] = ()  # casualties of the exercise that wait for a condition
    monitor: LimitMonitor = field(default_factory=LimitMonitor)
    last_tick: float = math.inf
    progress: Callable[[int], None] | None = None
    wake: threading.Event = field(default_factory=threading.Event)
    briefing: tuple[str, ...] = ()  # what the instructor is told
    crew_briefing: tuple[str, ...] = ()  # what everybody else is
    exercise: Briefing = field(default_factory=Briefing)  # as programs are told it
    hand: frozenset[str] = frozenset()  # axes that the exercise has worked by hand
    hand_from: float = 0.0  # [s]
    allowed: frozenset[str] = frozenset()  # automatic orders allowed nevertheless
    guard: DepthGuard = field(default_factory=DepthGuard)
    until_left: bool = False  # it ends when the last of those who came by themselves has gone
    deserted: str = ""  # why it ended before its time
    refused: list[str] = field(default_factory=list)  # of the schedule, as it was told
    event_log: EventLog = field(init=False)
    control: Control = field(init=False)
    conduct: Conduct = field(init=False)
    depths: DepthMonitor = field(init=False)
    pilot: PilotMonitor = field(init=False)
    crew: CrewTalk = field(init=False)
    agenda: Agenda = field(init=False)
    standing: Standing = field(init=False)

    def __post_init__(self) -> None:
        self.event_log = log = EventLog(self.history)
        self.control = Control(self.boat, self.time, self.history, self.schedule)
        self.conduct = Conduct(self.control, log, self._show, self.wake.set, hand=self.hand)
        self.depths = DepthMonitor.over(self.boat)
        self.pilot = PilotMonitor.over(self.boat)
        self.crew = CrewTalk(self.boat, self.hand, self.hand_from, self.allowed, self.guard)
        self.agenda = Agenda(self.boat, self.schedule, self.armed)
        self.standing = Standing(self.crew, self.agenda, self.history)
        self.standing.go_back()  # a recorded run goes on
        self._alarm = Alarm(self.wake.set)
        self._lookout = StateReader(self.boat, self.time.ledger.summary)
        self._pace = Pace()  # as it was last shown: whatever changes it has it shown

    def run(self, *, frozen: bool = False) -> None:
        """Run to the last tick, an order to quit, or until nobody can say run."""
        if self.columns:
            self._row()
        self.conduct.judge_hull()  # a recorded run may have ended in a collapse
        self.conduct.look()  # or at its exercise's end
        self._obey_schedule()  # the crew's controls are in hand before time runs
        if not (frozen or self.control.failure or self.conduct.ending.over):
            self.time.pacer.run()
        self._show()
        while not self._over:
            if self.time.pacer.frozen and self._deserted():
                self.deserted = self.conduct.desert()
                return
            if self.time.pacer.wait(self.wake) is WOKEN:
                self.wake.clear()
                self.listen()
            else:
                self._tick()
            if self.control.steps:
                self._take_steps()  # those of the schedule, and those still to be taken

    def stop(self) -> None:
        """End the run after the present tick; may be called from another thread."""
        self.control.ended = True
        self.wake.set()

    def greet(self, station: Station) -> None:
        """Tell whoever comes what this is."""
        for line in (*self._briefed(station), hint(station.role, self.hand)):
            station.line.send(line)

    def _introduce(self, station: Station) -> None:
        """Tell a program the exercise, the vessel's ranges, and what the crew is ordered."""
        told = [("exercise", pair) for pair in self._exercise_facts(station)]
        told += [("range", pair) for pair in ranges(self.boat, station.role)]
        told += [("rate", pair) for pair in station.rate]
        self.event_log.note(station, [Fact(what, f"{key}={value}") for what, (key, value) in told])
        self.event_log.note(station, [each.fact for each in self.crew.standing(station.role.name)])
        self.event_log.note(station, self.conduct.outcome_for(station.role))
        self._tell_plans(station)
        self.event_log.note_alerts(station)

    def _exercise_facts(self, station: Station) -> list[tuple[str, str]]:
        """Return what there is to tell of the exercise by now, as keys and values."""
        role = station.role
        return [*self.exercise.facts(role, self.boat.time), *self.crew.conditions(role.name)]

    def _briefed(self, station: Station) -> tuple[str, ...]:
        """Return what a station is told of the exercise."""
        return self.briefing if station.role is INSTRUCTOR else self.crew_briefing

    def listen(self) -> None:
        """Admit newcomers, take what the stations say, and see out who has left."""
        self.event_log.strangers.settle()
        self.conduct.tend()
        self._admit_newcomers()
        for station in list(self.event_log.stations):
            self.event_log.heard = station
            before = (station.role, station.settled)
            for asked in station.take(LINES_AT_A_TIME):
                before = self._entered(station, before)
                if not self.conduct.hear(asked):
                    self._hear(asked)
                self._take_steps()
            self._entered(station, before)
            self._alarm.set(station.late)
            if station.held_up:
                self._alarm.set(station.held_up)  # what was not taken waits with no word of its own
            elif station.waiting:
                self.wake.set()  # others, and the clock, have their turn before the rest
            elif station.leaving or station.line.ended:
                self._see_out(station)
        self.event_log.heard = None
        self._alarm.set(self.event_log.strangers.wait)

    def _admit_newcomers(self) -> None:
        """Let those be stations who have come since the last call."""
        for station in self.reception.newcomers() if self.reception else ():
            if station.role is not STRANGER:  # who has to say who it is, is told nothing before
                self.greet(station)
            self.event_log.stations.append(station)
            self.event_log.strangers.log("station", f"{station.line.name} has come")

    def _entered(self, station: Station, before: tuple[Role, bool]) -> tuple[Role, bool]:
        """Greet or introduce a newcomer; return its role, and whether it has said so."""
        if before[0] is STRANGER and station.role is not STRANGER:
            self.greet(station)
        if station.settled and not before[1]:  # an observer's role is the same as before
            self._introduce(station)
        return station.role, station.settled

    @property
    def _over(self) -> bool:
        """Return whether the run has been ended or has reached its last tick."""
        return self.control.ended or self.boat.plain[TICK] >= self.last_tick

    def _see_out(self, station: Station) -> None:
        """Let a line go: it is closed by a thread of its own, since that may wait."""
        if not station.visits:
            return  # a line that the run was begun with is there to its end
        station.leave()
        self.event_log.stations.remove(station)
        tell = self.event_log.tell if station.settled else self.event_log.strangers.log
        tell("station", f"{station.account()}: {station.leaving or 'gone'}")
        threading.Thread(target=station.close, args=(PATIENCE,), daemon=True).start()
        if self.until_left and not any(each.visits for each in self.event_log.stations):
            self.event_log.tell("time", f"ended at {self.boat.time:g} s: the last station has left")
            self.control.ended = True

    def _take_steps(self) -> None:
        """Take the steps that were ordered while time is frozen, and listen between long ones."""
        until = self.time.clock.now() + AT_A_TIME
        while self.control.steps and self.time.frozen and not self._over:
            if self.time.clock.now() > until:
                self.wake.set()
                return
            self.control.steps -= 1
            self._tick()

    def _deserted(self) -> bool:
        """Return whether nobody can let time, which stands still, go on."""
        if self.reception and self.reception.awaited:
            return False
        silent = all(station.line.ended for station in self.event_log.stations)
        self.listen()  # what came before the silence
        return silent and self.time.frozen and not self._over and not self.control.steps

    # Orders

    def _hear(self, asked: Asked) -> None:
        """Answer a question, or carry out an order, from a station."""
        order, station = asked.order, asked.station
        if order.name in QUESTIONS:
            self._tell_about(asked)
        elif order.name == "ack":
            station.answer(asked, self.event_log.acknowledge(order, station))
        elif order.name == "mark":
            self._mark(asked)
        else:
            self._give(asked)

    def _tell_about(self, asked: Asked) -> None:
        """Answer a question, programs with facts before it."""
        name, station = asked.order.name, asked.station
        if name == "briefing":
            self._introduce(station)
        if name == "plans":
            self._tell_plans(station)
        if name == "casualties":
            self.event_log.note(
                station, [Fact("casualty", ",".join(each)) for each in available(self.boat)]
            )
        answers: dict[str, Callable[[], Sequence[str]]] = {
            "status": lambda: self._status(station),
            "who": lambda: [each.account() for each in self.event_log.stations],
            "briefing": lambda: (
                *self._briefed(station),
                *(() if asked.heard.machine else in_words(self._exercise_facts(station))),
            ),
            "casualties": lambda: listing(self.boat),
            "plans": lambda: self.agenda.listing(self.history.place),
            "log": lambda: self.event_log.lately(station.role, int(asked.order.value)),
        }
        station.answer(asked, "", *answers[name]())

    def _mark(self, asked: Asked) -> None:
        """Mark this moment; it is in the file before it is answered."""
        remark = asked.order.subject
        self.event_log.tell("mark", remark or "marked", asked.station, Fact("mark", remark))
        self.history.recording.flush()
        asked.station.answer(asked, self.event_log.as_kept(f"marked at {self.boat.time:g} s"))
        self.event_log.tell_trouble()

    def _give(self, asked: Asked) -> None:
        """Carry out an order, answer it, and tell the others."""
        order, station = self.crew.meant(asked.order), asked.station
        answer = self.give(order, station.who)
        manned = self.event_log.attended_by_others(station)
        alone = unheard(order, self.crew.worked, self.crew.allowed, manned)
        heard = [] if isinstance(answer, Refused) or not alone else [alone]
        station.answer(asked, self.event_log.as_kept(answer), *heard)
        if self.event_log.pass_on(order, answer, station) == "back":
            self.event_log.recall(self.crew.unrepeated)
        self._tell_plans()
        self.event_log.tell_trouble()

    def give(self, order: Order, who: str) -> Reply:
        """Carry out an order of somebody's; return what now holds, or why it was refused."""
        if why := self.conduct.past_its_end(order, who) or self.crew.in_hand(order):
            return Refused(why)
        try:
            if order.name in BOAT_ORDERS:
                self._obey_schedule()  # what was due before comes before
            return self._carry_out(self.crew.meant(order), who)
        except RecordingError as error:  # its past cannot be read at present
            return Refused(str(error))

    def return_to(self, moment: Moment, why: str) -> None:
        """Go back to a moment of this run: a new branch begins there, frozen."""
        self.control.go_to(moment, why)
        self._settle()
        self._show()

    def _status(self, station: Station) -> list[str]:
        """Return all about the boat that a station may know."""
        if station.role is INSTRUCTOR:
            return status_lines(self.boat, self.time.ledger.summary())
        picture = Picture(self.history.tick, self.history.now().state, self._pace)
        return panel(station.role.channels, self._lookout.frame(picture))

    def _carry_out(self, order: Order, who: str, place: int | None = None) -> Reply:
        """Carry out an order, to the boat once it is journalled; return the answer."""
        moves = order.name in OF_THE_BOAT
        if moves and self.history.rerun:
            return Refused("a replay is running: take over first")
        kept = moves or place is not None or who.startswith(PLANNED)
        number = self.history.order(who, order, place) if kept else None
        answer = self._obey(order, who) if moves else self.control.obey(order, who)
        if number is not None:
            self.history.answered(number, answer)
            self.standing.keep()
        if not moves:
            self._after_time(order)
        return answer

    def _obey(self, order: Order, who: str) -> Reply:
        """Have the boat obey an order, or the crew told; tell what the crew is to know of it."""
        if order.name in PLANNING:
            return self.agenda.obey(order)
        talk = order.name in CREW_TALK
        tellings = [] if talk else self.crew.wrong_way(order, role_of(who))
        answer = self.crew.obey(order, role_of(who)) if talk else obey(self.boat, order)
        if not isinstance(answer, Refused):
            tellings += self.crew.note(order, who, self.history.tick, answer)
            self._say(tellings, who)
        self._pace = self._pace._replace(told=self.crew.told)
        if self.time.frozen and not isinstance(answer, Refused):  # no tick comes to show it
            self._show()
        return answer

    def _say(self, tellings: Sequence[Telling], who: str = "") -> None:
        """Tell what was said; who has said it to the crew has an answer in place of the text."""
        heard = None if self.history.rerun else self.event_log.heard
        speaker = heard if heard and heard.who == who else None
        for each in tellings:
            self.event_log.tell(
                each.kind, each.text, speaker if each.kind == CREW else None, each.fact
            )

    def _after_time(self, order: Order) -> None:
        """Show what an order about time has changed."""
        if order.name in MOMENTS:
            self._settle()
        if order.name in MOMENTS or order.name in TIME:
            self._show()

    def _settle(self) -> None:
        """Take the moment as it is after a jump in time: nothing of it is news."""
        counting = self.monitor, self.depths, self.pilot
        for each in counting:
            each.settle(self.boat)
        self.conduct.settle()
        self.standing.go_back()
        self.event_log.settle(counting)
        self.conduct.judge_hull()

    def _obey_due(self) -> bool:
        """Carry out the orders that are due; return whether they stop time before a tick."""
        was_frozen = self.time.frozen
        self._obey_schedule()
        if self.history.rerun is None:
            for each in self.agenda.due():
                who = f"{PLANNED}{each.number}"
                self._tell_due(each.ahead.moment, each.order, self.give(each.order, who))
                self._tell_plans()
        elif self._obey_replay():
            return True
        return self.control.ended or (self.time.frozen and not was_frozen)

    def _obey_schedule(self) -> None:
        """Carry out what is due by now: an order acts on the first tick not before its time."""
        while self.history.rerun is None and self.history.place < len(self.schedule):
            entry = self.schedule[self.history.place]
            if math.ceil(entry.seconds / self.boat.method.step - 1e-9) > self.boat.ticks:
                return
            answer = self._carry_out(entry.order, SCHEDULE, self.history.place)
            told = self._tell_due(f"{entry.seconds:g} s", entry.order, answer)
            if isinstance(answer, Refused):
                self.refused.append(told)

    def _tell_due(self, when: str, order: Order, answer: Reply) -> str:
        """Tell how an order that was due was answered; what was said to the crew, has been told."""
        wrong = f"{order.text}: refused: {answer.reason}" if isinstance(answer, Refused) else ""
        text = f"{when}: {wrong or answer}"
        if wrong or order.name not in CREW_TALK:
            fact = None if wrong else Fact("order", order.text)
            self.event_log.tell("exercise", text, fact=fact)
        return text

    def _tell_plans(self, station: Station | None = None) -> None:
        """Tell an instructor what is ahead; without one all of them, where it has changed."""
        place = self.history.place
        if station is None and not self.agenda.has_changed(place):
            return
        for each in [station] if station else self.event_log.stations:
            if each.role is INSTRUCTOR:
                self.event_log.note(each, self.agenda.facts(place))

    def _obey_replay(self) -> bool:
        """Give again what was given at this tick; return whether a replay ends here, told so."""
        for order, who in self.history.due(self.schedule):
            if order.name in BOAT_ORDERS | CREW_TALK:
                self._obey(order, who)
            self.agenda.note(order, who, self.boat.time)
        if not self.history.caught_up:
            return False
        self.event_log.tell("moment", self.history.arrive())
        self.standing.arrive()
        self.conduct.judge_hull()
        self.conduct.look()
        self.time.pacer.freeze()
        self.control.steps = 0
        self._show()
        return True

    # Ticks

    def _tick(self) -> None:
        """Carry out the orders that are due, and unless they stop time take a tick."""
        history = self.history
        ahead = history.rerun or self.agenda.planned or history.place < len(self.schedule)
        if ahead and self._obey_due():
            return
        pacer = self.time.pacer
        was_frozen = pacer.frozen
        pacer.begin()
        status = self.boat.tick()
        tick = int(self.boat.plain[TICK])
        if status:
            self.control.failure = self.boat.failure(status)
            self.event_log.tell("trouble", f"FROZEN: {self.control.failure}")
        else:
            self._after_tick(tick)
        events = pacer.end()
        if history.rerun is None:
            history.recording.timing(tick, pacer.ledger.lateness, pacer.ledger.work)
        if self.control.failure:
            pacer.freeze()
            self.control.steps = 0
        if pacer.frozen and not was_frozen:
            self._show()
        if events:
            self._tell_late(events)
        if self.progress:
            self.progress(tick)

    def _tell_late(self, events: tuple[Event, ...]) -> None:
        """Tell of a tick that was late, and show the speed if it had to fall."""
        speed = self.time.speed
        for kind, text in self.time.judge(events):
            self.event_log.tell(kind, text)
        if self.time.speed != speed:
            self._show()

    def _after_tick(self, tick: int) -> None:
        """Keep the state, show it, and call out what it means."""
        state = self.history.ticked(tick)
        self.event_log.tell_trouble()
        if self.columns and self.history.rerun is None:
            self._row()
        self.sending.offer(tick, state, self._pace)
        for kind, monitor in (("watch", self.monitor), ("pilot", self.pilot)):
            for text in monitor.look(self.boat):
                self.event_log.alert(kind, text)
        self.conduct.collide(self.monitor.encounters)
        if passed := self.depths.look(self.boat):  # on the way down
            self.conduct.tell_depth(passed.words, Fact("depth", f"{passed.depth:g}"))
        self.conduct.judge_hull()
        self._tell_plans()
        if self.history.rerun is None:
            self.conduct.look()
        if tick >= self.crew.due:
            self._say(self.crew.missing(tick, self.event_log.attended))
        if not self.history.rerun and (due := self.crew.due_by_hand()):
            self.event_log.tell("order", f"{due.why}: {self._carry_out(due.order, due.who)}")
        while self.sending.troubles:
            self.event_log.tell("trouble", self.sending.troubles.popleft())

    def _row(self) -> None:
        """Hand the state to the columns' file; tell at once when it is in trouble."""
        before = self.recorder.trouble
        self.recorder.row(self.boat.numbers(self.columns))
        if self.recorder.trouble != before:
            self.event_log.tell("trouble", f"NOT RECORDED: {self.recorder.trouble}")

    def _show(self) -> None:
        """Let the present moment be seen, and how time runs from here on."""
        now, time = self.history.now(), self.time
        replaying = self.history.rerun is not None
        self._pace = Pace(time.frozen, time.speed, now.branch, replaying, self.crew.told, now.after)
        self.sending.offer(now.tick, now.state, self._pace)
