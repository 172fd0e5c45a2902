"""The laws of a session, and who looks whether they hold.

``Docket`` takes the breaches. ``Witness`` stands beside each order and each tick; ``check_kept``
reads what a process has left behind; ``check_whole`` reads the recording at the end. What is seen
on the lines is in ``stations``.
"""

import contextlib
import hashlib
import json
import sqlite3
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import pytest

from simulation.alert_model import AlertModel, Book, Deed, Said
from simulation.damage import check_damage, check_schedule
from simulation.disk import Disk, log_of
from simulation.machine import LADEN_TURN_NS, SECOND_NS, Machine
from simulation.milestones import Log, Stand
from simulation.model import JUMP_WORDS, Before, Model
from trainer.debrief.page.page import read_dossier, render
from trainer.io.orders.grammar import Refused, Reply
from trainer.io.orders.words import ORDER_WORDS, STRANGER
from trainer.io.recording.checkpoint import MAX_AHEAD_BYTES
from trainer.io.recording.recording import MARK_KIND, Recording
from trainer.session.attendance import Attendance, Introduction
from trainer.session.crew.agenda import Plans
from trainer.session.dispatch import Dispatch
from trainer.session.exercise.terms import Terms
from trainer.session.past.header import plan_of
from trainer.session.past.journal import MAX_KEPT_MOMENTS
from trainer.session.replay import replay_anyway
from trainer.session.session import Session
from trainer.session.stations.alerts import MAX_OPEN_ALERTS
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import Request, Station

SAFE_AFTER_NS: Final = SECOND_NS  # that lost power may take of what was answered: docs/promises.md
FOREVER_NS: Final = 2**62
MAX_THREADS: Final = 24  # of a session: its own, a debrief's, and those that see lines out


class Law(Enum):
    """What must hold, whatever the script."""

    KEPT = "L1: an answered order or mark is in the file with its tick"
    REFUSED = "L2: a refusal changes no bit, no branch, no freeze"
    FLOWN_AGAIN = "L3: every branch is flown again to the same bits and answers"
    SAME_BYTES = "L4: the same script gives the same bytes"
    ANSWERS = "L5: each whole order has one answer, in order but for hint and what if"
    ENDED = "L6: an exercise's end is taken back by a jump away from it alone; no tick follows it"
    COMMAND = "L7: an instructor without command is refused"
    LIVES = "L8: no thread dies, and a session ends within a minute of a signal"
    RESTS = "L9: no thread spins"
    BOUNDED = "L10: threads, moments, alerts and files are bounded"
    SECRETS = "L11: a line has the channels and events of its role alone"
    RESTORED = "L12: a snapshot restored is the moment that it was"
    DEBRIEFED = "L13: a debrief made twice is the same bytes"
    SOLE = "L14: a recording has one session: a second is refused"
    INSTRUMENTS = "L15: each sentence to an instrument is whole, and none is silent for long"
    AIS = "L16: each ship within reach is heard by AIS as often as is promised, and no other"
    MODEL = "L18: a session is what its lines make of it: plans, command, pictures, instruments"
    PLANS = "L17: the orders ahead are after a kill what they were before it; each is given once"
    SHOWN = "L19: whatever is subscribed shows the present moment, also after a jump"
    ALERTS = (
        "L20: whose an alert is sees it, for good; who silences it does so there alone, for 30 s"
    )
    ADMITTED = "L21: without its word a line orders and sees nothing; with it, it always comes in"
    DAMAGE = "L22: what is broken is what orders have broken and mended, at each tick"


class Breach(NamedTuple):
    """A broken law."""

    law: Law
    text: str

    def __str__(self) -> str:
        return f"{self.law.value}\n    {self.text}"


class Promise(NamedTuple):
    """An order or a mark that was answered."""

    who: str
    what: str
    tick: int
    kind: str  # "order", "refused" for one that was journalled and refused, "mark", "snapshot",
    # "branch", or "ack" of an alert that is seen or silenced
    branch: int


class Ahead(NamedTuple):
    """The orders that are still to come."""

    plans: Plans
    entry: int  # the next of the schedule

    @classmethod
    def of(cls, session: Session) -> "Ahead":
        """Return what is ahead of a session."""
        return cls(session.agenda.plans, session.history.entry)


@dataclass
class Docket:
    """The breaches of one script, and what was done in it."""

    machine: Machine
    breaches: list[Breach] = field(default_factory=list)
    trace: "hashlib._Hash" = field(default_factory=hashlib.sha256)
    promises: list[tuple[Promise, int]] = field(default_factory=list)  # and when [ns]
    snapshots: dict[str, set[bytes]] = field(default_factory=lambda: defaultdict(set))
    alert_deeds: set[Said] = field(default_factory=set)
    life: int = 1
    orders: int = 0
    answers: int = 0
    ticks: int = 0
    pictures: list[int] = field(default_factory=list)  # [ns] when another moment came to be shown
    picture: tuple[int, int] = (-1, 0)  # the tick and branch of that
    kills: int = 0
    power_cuts: int = 0
    log: Log = field(default_factory=Log)  # of the milestones

    def enter(self, law: Law, text: str) -> None:
        """Enter a breach of a law, now."""
        now = self.machine.now / SECOND_NS
        self.breaches.append(Breach(law, f"process {self.life}, {now:.3f} s: {text}"))

    def see_picture(self, tick: int, branch: int) -> None:
        """Note the moment that is handed over to be shown."""
        if self.picture != (tick, branch):
            self.picture = tick, branch
            self.pictures.append(self.machine.now)

    def forget_pictures(self) -> None:
        """Begin with a process, which has shown nothing."""
        self.picture, self.pictures = (-1, 0), []


@dataclass
class Witness:
    """What stands beside each order and each tick of the present session."""

    docket: Docket
    machine: Machine
    session: Session | None = None
    model: Model = field(init=False)
    alerts: AlertModel = field(init=False)
    amidst: bool = False  # an order is journalled, and not yet answered there
    _reply: object = None  # the last that a station was given
    _who: str = ""  # gives the order that is heard, before it may take another role
    _meant: str = ""  # by the order that is heard, before it acts: belay takes back the newest
    _before: int = 0  # the last order in the journal before the one that is heard
    ahead: Ahead | None = None  # when the last order was done with; None in the midst of one
    _left: Ahead | None = None  # by the process before, where it was killed

    def __post_init__(self) -> None:
        self.model = Model(
            lambda text: self.docket.enter(Law.MODEL, text),
            lambda: self.machine.now / SECOND_NS,
            self.docket.see_picture,
        )
        self.alerts = AlertModel(
            lambda text: self.docket.enter(Law.ALERTS, text),
            lambda: self.machine.now / SECOND_NS,
            self.docket.alert_deeds,
        )

    def watch(self, patch: pytest.MonkeyPatch) -> None:
        """Wrap what is looked at. Nothing of it is changed."""
        init, hear, answer = Session.__post_init__, Dispatch.hear, Station.answer
        tick, answer_left = Session.tick, Dispatch.answer_left_orders
        greet = Attendance.greet

        def begin(session: Session, terms: Terms, introduction: Introduction) -> None:
            init(session, terms, introduction)
            self.session = session
            self.docket.log.see_start(session)

        def answer_left_orders(dispatch: Dispatch) -> None:
            answer_left(dispatch)
            assert self.session is not None
            self.model.begin(self.session)
            kept = {promise for promise, _ in self.docket.promises}
            self.alerts.begin(self.session, lambda deed: ack_promise(deed) in kept)
            self._check_plans()
            self.ahead = Ahead.of(self.session)  # it may be killed before it hears of anything

        def hear_order(dispatch: Dispatch, asked: Request) -> None:
            with self._beside(asked):
                hear(dispatch, asked)

        def answer_order(station: Station, asked: Request, reply: Reply, *lines: str) -> None:
            self._promise(asked, reply)
            answer(station, asked, reply, *lines)

        def take_tick(session: Session) -> None:
            if session.conduct.ending.over and not session.history.flown.replaying:
                self.docket.enter(Law.ENDED, f"a tick follows tick {session.history.tick}, the end")
            self.docket.ticks += 1
            self.ahead, stand, before = None, Stand.of(session), Before.of(session)
            book = Book.of(session, self.alerts.clock())
            tick(session)
            if self.machine.turn == LADEN_TURN_NS:  # else it takes no time at all
                self.machine.now += LADEN_TURN_NS
            self.model.tick(session, before)
            self.alerts.tick(session, book, moved=has_moved(session, before))
            self.ahead = Ahead.of(session)
            self.docket.log.see_tick(session, stand)

        def greet_guest(attendance: Attendance, station: Station) -> None:
            greet(attendance, station)
            if self.session:
                self.docket.log.see_guest(self.session)

        self.docket.log.watch(patch)
        self._watch_journal(patch)
        self.model.watch(patch)
        patch.setattr(Session, "__post_init__", begin)
        patch.setattr(Session, "tick", take_tick)
        patch.setattr(Dispatch, "answer_left_orders", answer_left_orders)
        patch.setattr(Dispatch, "hear", hear_order)
        patch.setattr(Station, "answer", answer_order)
        patch.setattr(Attendance, "greet", greet_guest)

    def _watch_journal(self, patch: pytest.MonkeyPatch) -> None:
        """Know when an order is in the journal without its answer."""
        write_order, write_answer = Recording.order, Recording.answered

        def journal_order(recording: Recording, *given: Any) -> int:
            number = write_order(recording, *given)
            self.amidst = True
            return number

        def journal_answer(recording: Recording, *given: Any) -> None:
            self.amidst = False
            write_answer(recording, *given)

        patch.setattr(Recording, "order", journal_order)
        patch.setattr(Recording, "answered", journal_answer)

    @contextlib.contextmanager
    def _beside(self, asked: Request) -> Iterator[None]:
        """Look at a session before and after an order."""
        session = self.session
        assert session
        before, stand, said = Posture.of(session), Stand.of(session), Before.of(session)
        book, role = Book.of(session, self.alerts.clock()), asked.station.role.name
        self.alerts.expect(asked.order, role, book)
        elsewhere = is_elsewhere(session, asked.station)
        self._reply, self._before, self.ahead = None, session.history.after, None
        self.docket.orders += 1
        self.docket.log.see_arrival(session, f"{asked.station.who}: {asked.order.text}")
        self._who = asked.station.who
        self._meant = session.crew.meant(asked.order).text
        yield
        self.ahead = Ahead.of(session)
        after, name = Posture.of(session), asked.order.name
        station = asked.station
        self.docket.log.see_order(session, name, station.role.name, station, stand, self._reply)
        self.model.hear(session, asked.order, station, self._reply, said)
        moved, done = has_moved(session, said), len(self.alerts.deeds)
        self.alerts.hear(session, asked.order, role, self._reply, book, moved=moved)
        if not session.history.recording.trouble:  # lost power may take it: then it is owed again
            deeds = self.alerts.deeds[done:]
            self.docket.promises += [(ack_promise(deed), FOREVER_NS) for deed in deeds]
        text = f"{asked.order.text!r} at tick {before.tick}"
        if isinstance(self._reply, Refused):
            if changed := before.changed(after):
                reason = self._reply.reason
                self.docket.enter(Law.REFUSED, f"{text}: refused ({reason}), and {changed}")
        elif role == STRANGER:
            self.docket.enter(Law.ADMITTED, f"{text}: obeyed without a word")
        elif elsewhere and not ORDER_WORDS[name].watching:
            self.docket.enter(Law.COMMAND, f"{text}: obeyed without command")
        elif before.over:
            self._check_end(session, name, text)
        restored = name == "restore" and not isinstance(self._reply, Refused)
        if restored and after.state not in self.docket.snapshots[asked.order.subject]:
            self.docket.enter(Law.RESTORED, f"{text}: another moment than was kept")

    def _check_end(self, session: Session, name: str, text: str) -> None:
        """L6, after an order that was obeyed where the exercise was over."""
        ending, rule = session.conduct.ending, ORDER_WORDS[name]
        at_end = session.history.tick >= ending.last_tick
        if ending.over or session.history.flown.replaying:
            return
        if not (rule.jumps or name in ("replay", "take")):
            self.docket.enter(Law.ENDED, f"{text}: has taken the end back")
        elif rule.jumps and ending.watched and at_end:
            self.docket.enter(Law.ENDED, f"{text}: at the end, and yet it is not over")

    def _promise(self, asked: Request, reply: Reply) -> None:
        """Note what a station is told, before it is."""
        self._reply = reply
        session, name = self.session, asked.order.name
        assert session
        if name == "snapshot" and not isinstance(reply, Refused):
            self.docket.snapshots[asked.order.subject].add(session.boat.plain.tobytes())
        refused = isinstance(reply, Refused)
        journalled = ORDER_WORDS[name].journalled and session.history.after != self._before
        if (refused and not journalled) or session.history.recording.trouble:
            return  # "(not recorded)"
        tick, branch = session.history.tick, session.history.recording.branch
        if ORDER_WORDS[name].journalled:
            kind = "refused" if refused else "order"
            promise = Promise(self._who, self._meant, tick, kind, branch)
        elif name == "mark":
            text = asked.order.subject or "marked"
            promise = Promise(self._who, text, tick, "mark", branch)
        elif name == "snapshot":
            promise = snapshot_promise(asked.order.subject, tick, session.boat.plain.tobytes())
        elif name in JUMP_WORDS and not refused:
            promise = branch_promise(branch, tick)
        else:
            return
        self.docket.promises.append((promise, self.machine.now))

    def leave(self, *, killed: bool) -> None:
        """Note with which orders ahead a process ends; they are promised where it was killed."""
        self._left = self.ahead if killed and self.session else None
        history = self.session.history if self.session else None
        if history and (history.recording.trouble or history.flown.replaying):
            self._left = None  # who is killed in a replay goes on at its end

    def _check_plans(self) -> None:
        """L17, when a session has answered what the process before had left."""
        assert self.session
        left, ahead = self._left, Ahead.of(self.session)
        self._left = None
        if left is not None and left != ahead:
            self.docket.enter(Law.PLANS, f"before: {left}; now: {ahead}")

    def check_bounds(self, threads: int, disk: Disk) -> None:
        """L10: look at what the session holds."""
        session, ahead = self.session, log_of(disk.path)
        if not session:
            return
        held = {
            "threads": (threads, MAX_THREADS),
            "moments": (len(session.history.automatic), MAX_KEPT_MOMENTS),
            "alerts": (len(session.event_log.alerts.open), MAX_OPEN_ALERTS),
            "bytes ahead": (ahead.stat().st_size if ahead.exists() else 0, 2 * MAX_AHEAD_BYTES),
            "files": (len(list(disk.path.parent.iterdir())), 3),
        }
        for what, (number, most) in held.items():
            if number > most:
                self.docket.enter(Law.BOUNDED, f"{number} {what}, at most {most}")


class Posture(NamedTuple):
    """What a refusal must leave as it is."""

    state: bytes
    branch: int
    frozen: bool
    entry: int  # of the schedule: what was due comes before an order, also before a refusal
    tick: int
    over: str
    reachable: bool  # the recording is, after a gap: whatever is journalled next begins a branch

    @classmethod
    def of(cls, session: Session) -> "Posture":
        """Return how a session stands."""
        history = session.history
        return cls(
            session.boat.plain.tobytes(),
            history.recording.branch,
            session.time.frozen,
            history.entry,
            history.tick,
            session.conduct.ending.over,
            history.recording.reachable,
        )

    def changed(self, after: "Posture") -> str:
        """Return what has changed that a refusal does not change, "" for nothing."""
        if self.branch != after.branch and not self.reachable:
            return "began a branch"
        if self.frozen != after.frozen:
            return "stopped time or let it go on"
        return (
            "changed the state" if self.state != after.state and self.entry == after.entry else ""
        )


def has_moved(session: Session, before: Before) -> bool:
    """Return whether a session has come to another moment otherwise than by a tick."""
    history = session.history
    replaying = before.replaying or history.flown.replaying
    return replaying or history.recording.branch != before.branch or history.tick < before.tick


def is_elsewhere(session: Session, station: Station) -> bool:
    """Return whether another instructor has command, who is here."""
    holder = session.conduct.command.holder
    return (
        station.role is INSTRUCTOR_ROLE
        and holder is not None
        and holder is not station
        and holder in session.event_log.stations
        and not holder.line.ended
        and not holder.leaving
    )


def check_kept(docket: Docket, path: Path, *, until: int, since: int = 0) -> None:
    """L1: look for what was promised until a time [ns] at ``path``.

    A process has left that.
    What was promised before ``since`` [ns] was for the process to see to from then on.
    """
    with contextlib.closing(Recording.look(path)) as recording:
        kept = promises_in(recording)
    with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as reader:
        for name, tick, state in reader.execute("SELECT name, tick, state FROM snapshots"):
            kept[snapshot_promise(name, tick, state)] += 1
    due = Counter(promise for promise, at in docket.promises if max(at, since) <= until)
    for promise, count in due.items():
        if kept[promise] < count:
            docket.enter(
                Law.KEPT,
                f"{promise.kind} {promise.what!r} of {promise.who}, branch {promise.branch}, tick "
                f"{promise.tick}: {count} answered, {kept[promise]} in the file",
            )
    remaining = []
    for promise, at in docket.promises:  # what lost power has taken was never promised
        if kept[promise] > 0:
            kept[promise] -= 1
            remaining.append((promise, at))
    docket.promises = remaining


def snapshot_promise(name: str, tick: int, state: bytes) -> Promise:
    """Return what is promised where a snapshot is answered."""
    digest = hashlib.sha256(state).hexdigest()[:12]
    return Promise(digest, name, tick, "snapshot", 0)


def branch_promise(branch: int, tick: int) -> Promise:
    """Return what is promised where a jump is answered: the branch that it begins."""
    return Promise("", "", tick, "branch", branch)


def ack_promise(deed: Deed) -> Promise:
    """Return what is promised where an alert is seen or silenced."""
    return Promise(deed.role, f"{deed.what} {deed.number}", deed.tick, "ack", deed.branch)


def promises_in(recording: Recording) -> Counter[Promise]:
    """Return the orders and marks in a recording, and how often each is there."""
    kept: Counter[Promise] = Counter()
    for branch in recording.branches():
        kept[branch_promise(branch.id, branch.tick)] += 1
        for order in recording.orders(branch.id):
            if order.branch == branch.id and order.accepted is not None:
                kind = "order" if order.accepted else "refused"
                kept[Promise(order.who, order.text, order.tick, kind, branch.id)] += 1
    for event in recording.events():
        if event.kind == MARK_KIND:
            kept[Promise(event.who, event.text, event.tick, "mark", event.branch)] += 1
    for note in recording.notes():
        what, number = json.loads(note.text)[:2]
        kept[ack_promise(Deed(what, number, note.role, note.branch, note.tick))] += 1
    return kept


def check_debriefs(docket: Docket, path: Path) -> None:
    """L13: debrief each branch of the recording twice, without what each minute cost."""
    with contextlib.closing(Recording.look(path)) as recording:
        flown = [each.id for each in recording.branches() if recording.last_tick(each.id)]
    for branch in flown:
        first, second = (render(read_dossier(path, branch)) for _ in range(2))
        if first != second:
            docket.enter(Law.DEBRIEFED, f"branch {branch}: two pages differ")
        docket.trace.update(first.encode())


def check_secrets(docket: Docket, path: Path, secrets: Sequence[bytes]) -> None:
    """L21: look for the words that a session asks for in what it leaves."""
    left = b"".join(each.read_bytes() for each in path.parent.iterdir())
    for word in secrets:
        if word in left:
            docket.enter(Law.ADMITTED, f"{word.decode()} is in the recording")


def check_whole(docket: Docket, path: Path) -> None:
    """L3, and what L4 compares: fly all branches of the recording again."""
    with contextlib.closing(Recording.look(path)) as recording, np.errstate(all="ignore"):
        for flight in replay_anyway(recording):
            if not flight.same:
                why = flight.parting or flight.answers[:2] or flight.trouble
                docket.enter(
                    Law.FLOWN_AGAIN,
                    f"branch {flight.branch.id}: {flight.unequal} of {flight.compared} states "
                    f"differ: {why}",
                )
        for branch in recording.branches():
            docket.trace.update(repr(branch).encode())
            for order in recording.orders(branch.id):
                docket.trace.update(repr(order).encode())
            for tick, state in recording.states(branch.id):
                docket.trace.update(b"%d:" % tick + state)
        plan = plan_of(recording.header())
        for text in check_damage(recording, plan.method.step):
            docket.enter(Law.DAMAGE, text)
        for text in check_schedule(recording, plan):
            docket.enter(Law.PLANS, text)
        for event in recording.events():
            docket.trace.update(repr(event).encode())
