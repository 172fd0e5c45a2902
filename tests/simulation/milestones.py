"""What sessions sometimes reach: the other side of the laws, which always hold.

A law that held over ten thousand seeds says nothing of what no seed reached. So each law has
moments here that tempt it. A night prints how many seeds reached each; one that none reached is
red, because then the generator never makes the case. ``Log`` is asked after each order and each
tick, and as processes begin and end.

Every order word is to be said and accepted sometimes, too (``word NAME``), every gate on an order's
road to be shut (``gate NAME``, and for each permission ``gate of roles: NAME``), and each kind of
event and each channel to come to a line (``heard NAME``, ``shown NAME``), and each alert of the
plant to be called (``called NAME``).
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import pytest

from simulation.disk import Disk, Trouble
from trainer.boat.calls import MonitorCall
from trainer.boat.plant_alerts import PLANT_RANKS
from trainer.config.exercise.outcome import Outcome
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.words import ORDER_WORDS, Obeyer
from trainer.session import dispatch
from trainer.session.dispatch import ORDER_GATES, Gate
from trainer.session.parts import Parts
from trainer.session.session import Session
from trainer.session.stations import station as stations
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import EVENT_KINDS, INSTRUCTOR_ROLE, Role
from trainer.session.stations.roles import refusal as role_refusal
from trainer.session.stations.station import Fact, Station

if TYPE_CHECKING:
    from simulation.script import (  # whose words are drawn among ships, and those know laws
        Life,
        Point,
    )


class Stand(NamedTuple):
    """How a session stood before an order or a tick."""

    branch: int
    tick: int
    frozen: bool
    over: bool
    replaying: bool
    plans: int
    casualties: int
    ramping: bool
    busy: bool  # marks or a debrief are being made
    holder: object  # of command
    owed: int  # alerts that nobody has acknowledged
    seen: int  # alerts that somebody has
    silenced: int  # at how many roles

    @classmethod
    def of(cls, session: Session) -> "Stand":
        """Return how a session stands."""
        state, conduct = session.boat.state, session.conduct
        book = session.event_log.alerts
        alerts = [*book.past, *book.open.values()]
        return cls(
            session.history.recording.branch,
            session.history.tick,
            session.time.frozen,
            bool(conduct.ending.over),
            session.history.flown.replaying,
            len(session.agenda.planned),
            int((state.casualty != 0.0).sum()),
            bool((state.casualty_ticks != 0.0).any()),
            any(thread.is_alive() for thread in conduct.work.threads),
            conduct.command.holder,
            sum(alert.owed for alert in alerts),
            sum(bool(alert.seen_by) for alert in alerts),
            sum(len(alert.silenced) for alert in alerts),
        )


class Glance(NamedTuple):
    """One order that was carried out or refused, and what was before and after it."""

    word: str
    accepted: bool
    role: str
    before: Stand
    after: Stand
    session: Session
    troubles: frozenset[Trouble]  # that befall the disk now
    life: int
    first_branch: int  # of this process
    marked_branches: frozenset[int]  # where somebody has marked something

    @property
    def jumped(self) -> bool:
        """Return whether time jumped to another moment."""
        return self.accepted and self.after.branch != self.before.branch

    @property
    def is_due(self) -> bool:
        """Return whether a plan is due in the next tick."""
        boat, plans = self.session.boat, self.session.agenda.planned.values()
        return any(boat.ticks_in(p.seconds) <= boat.ticks for p in plans if p.condition is None)


# What an order may reach, by the law that it tempts.
ORDER_MILESTONES: Final[Mapping[str, Callable[[Glance], bool]]] = {
    "L1: an order is taken while the disk is full": lambda g: (
        g.accepted and Trouble.FULL in g.troubles
    ),
    "L1: an order is taken while another program writes": lambda g: (
        g.accepted and Trouble.LOCKED in g.troubles
    ),
    "L1: a mark in a replay": lambda g: g.accepted and g.word == "mark" and g.before.replaying,
    "L1: a mark after the end": lambda g: g.accepted and g.word == "mark" and g.before.over,
    "L2: a jump is refused": lambda g: not g.accepted and ORDER_WORDS[g.word].jumps,
    "L2: an order is refused while marks are made": lambda g: not g.accepted and g.before.busy,
    "L2: an order is refused in a replay": lambda g: not g.accepted and g.before.replaying,
    "L3: a jump while the disk is full": lambda g: g.jumped and Trouble.FULL in g.troubles,
    "L3: a jump while another program writes": lambda g: g.jumped and Trouble.LOCKED in g.troubles,
    "L2: a jump is refused where nothing can be read": lambda g: (
        not g.accepted and ORDER_WORDS[g.word].jumps and Trouble.UNREADABLE in g.troubles
    ),
    "L2: a take-over is refused where nothing can be read": lambda g: (
        not g.accepted and g.word == "take" and Trouble.UNREADABLE in g.troubles
    ),
    "L3: a jump in a freeze": lambda g: g.jumped and g.before.frozen,
    "L3: a jump while time runs": lambda g: g.jumped and not g.before.frozen,
    "L3: a jump out of a replay": lambda g: g.jumped and g.before.replaying and g.word != "take",
    "L3: a jump to a left branch's end": lambda g: g.jumped and g.word == "branch",
    "L3: a jump forward in time": lambda g: g.jumped and g.after.tick > g.before.tick,
    "L3: a replay within a replay": lambda g: (
        g.accepted and g.word == "replay" and g.before.replaying
    ),
    "L3: a take-over in a freeze": lambda g: g.accepted and g.word == "take" and g.before.frozen,
    "L3: a take-over while time runs": lambda g: (
        g.accepted and g.word == "take" and not g.before.frozen
    ),
    "L6: again after the end": lambda g: g.jumped and g.before.over and g.word == "again",
    "L6: the end taken back by a restore": lambda g: (
        g.jumped and g.before.over and not g.after.over and g.word == "restore"
    ),
    "L6: a jump while marks are made": lambda g: g.jumped and g.before.busy,
    "L6: a second debrief is asked for while one is made": lambda g: (
        g.word == "debrief" and g.before.busy
    ),
    "L7: a second instructor is refused": lambda g: (
        not g.accepted and g.role == "instructor" and g.before.holder is not None
    ),
    "L7: command changes hands": lambda g: (
        g.before.holder is not None and g.after.holder not in (None, g.before.holder)
    ),
    "L12: a restore with a casualty ramping": lambda g: (
        g.jumped and g.word == "restore" and (g.before.ramping or g.after.ramping)
    ),
    "L12: a restore brings a casualty back": lambda g: (
        g.jumped and g.before.casualties < g.after.casualties
    ),
    "L12: a restore of what an earlier process kept": lambda g: (
        g.jumped and g.word == "restore" and g.life > 1 and g.before.branch == g.first_branch
    ),
    "L12: a snapshot in a replay": lambda g: (
        g.accepted and g.word == "snapshot" and g.before.replaying
    ),
    "L17: a jump takes plans away": lambda g: g.jumped and g.after.plans < g.before.plans,
    "L17: a jump brings plans back": lambda g: g.jumped and g.after.plans > g.before.plans,
    "L1: a mark on a branch that is left": lambda g: (
        g.jumped and g.before.branch in g.marked_branches
    ),
    "L17: a plan is due in the tick of a jump": lambda g: g.jumped and g.is_due,
    "L17: a plan is cancelled": lambda g: g.accepted and g.word == "cancel",
    "L17: a plan is made in a freeze": lambda g: (
        g.accepted and g.word == "plan" and g.before.frozen
    ),
    "L20: an alert is acknowledged": lambda g: g.after.seen > g.before.seen and not g.jumped,
    "L20: an alert is silenced": lambda g: g.after.silenced > g.before.silenced and not g.jumped,
    "L20: an alert that is owed is refused to one": lambda g: (
        not g.accepted and g.word == "ack" and g.before.owed > 0
    ),
    "L20: a jump takes an acknowledgement back": lambda g: (
        g.jumped and g.after.seen < g.before.seen
    ),
    "L20: a jump brings an acknowledgement back": lambda g: (
        g.jumped and g.after.seen > g.before.seen
    ),
    "L22: one of several is mended": lambda g: (
        g.accepted and g.word == "clear" and g.before.casualties > 1
    ),
    "L22: several break at once": lambda g: g.after.casualties > 1 + g.before.casualties,
    "L22: a jump takes back what is broken": lambda g: (
        g.jumped and g.after.casualties < g.before.casualties
    ),
}
# What a tick may reach, and what processes begin and end with.
TICK_MILESTONES: Final[Mapping[str, Callable[[Stand, Stand, Session], bool]]] = {
    "L3: a replay ends by itself": lambda before, after, _: (
        before.replaying and not after.replaying
    ),
    "L6: an exercise ends by its time": lambda before, after, session: (
        after.over and not before.over and session.conduct.ending.outcome is not Outcome.LOST
    ),
    "L6: an exercise is lost": lambda before, after, session: (
        after.over and not before.over and session.conduct.ending.outcome is Outcome.LOST
    ),
    "L17: a plan comes": lambda before, after, _: (
        after.plans < before.plans and before.branch == after.branch
    ),
    "L22: something breaks by a plan or the schedule": lambda before, after, _: (
        before.branch == after.branch
        and after.casualties > before.casualties
        and not before.replaying
    ),
    "L16: a tick late among ships": lambda _before, _after, session: (
        session.boat.world.acts and bool(session.time.ledger.summary().overruns)
    ),
}
OTHER_MILESTONES: Final = (
    "L1: a kill right after an answer",
    "L1: a kill between journal and answer",
    "L1: power lost between journal and answer",
    "L1: power lost on a slow disk",
    "L1: a kill while the disk is full",
    "L3: a kill in a replay",
    "L3: a gap in the recording",
    "L3: format 1 goes on",
    "L3: power is lost after a kill in which nobody spoke",
    "L3: four processes on one recording",
    "L5: two instructors within one tick",
    "L6: a kill after the end",
    "L6: a kill while marks are made",
    "L8: a signal while a debrief is written",
    "L8: the time of day is set",
    "L8: the machine sleeps",
    "L11: a page comes in a replay",
    "L11: somebody comes after a kill",
    "L14: a second session is refused",
    "L17: a kill with plans ahead",
    "L20: a kill after an acknowledgement",
    "L21: a line without its word is refused an order",
    "L21: a wrong word",
    "L21: a word after a kill",
    "L22: a kill with something broken",
)
# A line answers its own orders, which no other part of the session hears; all say their role.
WORD_MILESTONES: Final = tuple(
    f"word {name}"
    for name, word in ORDER_WORDS.items()
    if word.obeyer not in (Obeyer.LINE, Obeyer.CHAIR)
)
GATE_MILESTONES: Final = tuple(f"gate {gate.__name__}" for gate in ORDER_GATES)
ROLE_GATE_MILESTONES: Final = tuple(
    dict.fromkeys(
        f"gate of roles: {word.control.says}" for word in ORDER_WORDS.values() if word.control.says
    )
)
HEARD_MILESTONES: Final = (
    *(f"heard {kind}" for kind in EVENT_KINDS if kind != "lesson"),  # none is played
    *(f"shown {channel}" for channel in INSTRUCTOR_ROLE.channels if channel != "teletype"),
    *(f"called {alert}" for alert in PLANT_RANKS),
)
SAID_MILESTONES: Final = (
    *(*WORD_MILESTONES, *GATE_MILESTONES, *ROLE_GATE_MILESTONES, *HEARD_MILESTONES),
)
MILESTONES: Final = (*ORDER_MILESTONES, *TICK_MILESTONES, *OTHER_MILESTONES)


@dataclass
class Log:
    """The milestones that one script has reached."""

    reached: dict[str, "Point | None"] = field(default_factory=dict)  # and where first
    where: Callable[[], "Point | None"] = lambda: None
    orders: list[tuple[int, str, "Point"]] = field(default_factory=list)  # tick, words, where
    note: Callable[[str], object] = lambda _: None  # told each time
    disk: Disk | None = None
    life: int = 1
    first_branch: int = 1
    _marked: set[int] = field(default_factory=set)  # the branches that have a mark
    _ordered: tuple[int, object] = (-1, None)  # the last tick of an instructor's order, and who

    def begin(self, life: "Life", number: int, disk: Disk, before: "Life | None") -> None:
        """Note what a process begins with."""
        self.life, self.disk = number, disk
        self._note("L3: format 1 goes on", life.aged and number > 1)
        self._note("L3: four processes on one recording", number > 3)
        silent = before is not None and is_killed(before) and not life.players
        self._note(
            "L3: power is lost after a kill in which nobody spoke",
            silent and is_powerless(life),
        )

    def see_start(self, session: Session) -> None:
        """Note how a session begins, when it has read what was before."""
        self.first_branch = session.history.recording.branch
        self._note("L1: a kill between journal and answer", bool(session.history.unanswered))

    def see_arrival(self, session: Session, words: str) -> None:
        """Note where an order comes."""
        if point := self.where():
            self.orders.append((session.history.tick, words, point))

    def see_order(
        self, session: Session, word: str, role: str, who: object, before: Stand, reply: object
    ) -> None:
        """Note what an order has reached."""
        accepted = not isinstance(reply, Refused)  # None is answered later
        after = Stand.of(session)
        troubles = frozenset(self.disk.troubles if self.disk else ())
        glance = Glance(
            *(word, accepted, role, before, after, session, troubles, self.life),
            *(self.first_branch, frozenset(self._marked)),
        )
        for name, is_so in ORDER_MILESTONES.items():
            self._note(name, is_so(glance))
        self._note(f"word {word}", accepted)
        if word == "mark" and accepted:
            self._marked.add(before.branch)
        if role == "instructor":
            tick, other = self._ordered
            self._note(
                "L5: two instructors within one tick", tick == before.tick and other is not who
            )
            self._ordered = before.tick, who

    def see_tick(self, session: Session, before: Stand) -> None:
        """Note what a tick has reached."""
        after = Stand.of(session)
        for name, is_so in TICK_MILESTONES.items():
            self._note(name, bool(is_so(before, after, session)))

    def see_guest(self, session: Session) -> None:
        """Note when somebody comes to a session."""
        self._note("L11: a page comes in a replay", session.history.flown.replaying)
        self._note("L11: somebody comes after a kill", self.life > 1)

    def see_end(self, session: Session | None, life: "Life", *, unanswered: bool) -> None:
        """Note with what a process is ended that does not end by itself."""
        if session is None:
            return
        stand, killed, power = Stand.of(session), is_killed(life), is_powerless(life)
        recording = session.history.recording
        self._note("L1: a kill right after an answer", killed and life.at_answer)
        self._note("L1: power lost between journal and answer", power and unanswered)
        self._note("L1: power lost on a slow disk", power and life.slow_disk)
        full = self.disk is not None and Trouble.FULL in self.disk.troubles
        self._note("L1: a kill while the disk is full", killed and full)
        self._note("L3: a kill in a replay", killed and stand.replaying)
        self._note("L6: a kill after the end", killed and stand.over)
        self._note("L6: a kill while marks are made", killed and stand.busy)
        self._note("L17: a kill with plans ahead", killed and bool(stand.plans))
        self._note("L20: a kill after an acknowledgement", killed and bool(stand.seen))
        self._note("L22: a kill with something broken", killed and bool(stand.casualties))
        self._note("L3: a gap in the recording", bool(recording.missing))

    def see_signal(self, session: Session) -> None:
        """Note how a session stands that a signal asks to end."""
        self._note("L8: a signal while a debrief is written", Stand.of(session).busy)

    def see_mishap(self, trouble: Trouble) -> None:
        """Note what befalls the machine."""
        self._note("L8: the time of day is set", trouble is Trouble.SET)
        self._note("L8: the machine sleeps", trouble is Trouble.ASLEEP)

    def see_word(self, *, granted: bool, owes: bool, asks: bool) -> None:
        """Note an answer in a session that asks for words; ``asks``: to a role."""
        self._note(
            "L21: a line without its word is refused an order", owes and not (granted or asks)
        )
        self._note("L21: a wrong word", asks and owes)
        self._note("L21: a word after a kill", granted and asks and self.life > 1)

    def see_rival(self) -> None:
        """Note that another session was refused the recording."""
        self._see("L14: a second session is refused")

    def see_shown(self, kind: str, fields: Sequence[str]) -> None:
        """Note what a line is shown: a channel's values, or an event of a kind."""
        if kind == "TRE":
            self._see(f"heard {fields[2]}")
        elif kind == "TRS":
            self._see(f"shown {fields[0]}")

    def watch(self, patch: pytest.MonkeyPatch) -> None:
        """Note which gates are shut, and what the plant calls. Nothing of it is changed."""
        alert = EventLog.alert

        def noted(gate: Gate) -> Gate:
            def look(order: Order, station: Station | None, session: Parts) -> Refused | None:
                shut = gate(order, station, session)
                self._note(f"gate {gate.__name__}", shut is not None)
                return shut

            return look

        def refuse(role: Role, order: Order) -> Refused | None:
            shut = role_refusal(role, order)
            says = ORDER_WORDS[order.name].control.says
            self._note(f"gate of roles: {says}", shut is not None)
            return shut

        def alert_noted(
            log: EventLog, kind: str, call: MonitorCall, fact: Fact | None = None
        ) -> None:
            self._note(f"called {call.key.partition(':')[0]}", kind == "plant")
            alert(log, kind, call, fact)

        patch.setattr(dispatch, "ORDER_GATES", tuple(map(noted, dispatch.ORDER_GATES)))
        patch.setattr(dispatch, "role_refusal", refuse)
        patch.setattr(stations, "refusal", refuse)
        patch.setattr(EventLog, "alert", alert_noted)

    def _note(self, name: str, is_so: object) -> None:
        if is_so:
            self._see(name)

    def _see(self, name: str) -> None:
        """Note that a milestone is reached."""
        self.note(name)
        if name not in self.reached:
            self.reached[name] = self.where()


def is_killed(life: "Life") -> bool:
    """Return whether a process is killed, if it does not end by itself."""
    return life.ending.name == "KILLED"


def is_powerless(life: "Life") -> bool:
    """Return whether a process ends as the power goes."""
    return life.ending.name == "POWER"


def reach_table(reached: Counter[str], seeds: int) -> list[str]:
    """Return a line for each milestone, with how many seeds reached it; the rarest first."""
    names = (*MILESTONES, *SAID_MILESTONES)
    return [
        f"{reached[name]:>7} of {seeds}  {name}"
        for name in sorted(names, key=lambda name: reached[name])
    ]


def never_reached(reached: Counter[str]) -> list[str]:
    """Return the milestones that no seed reached."""
    return [name for name in (*MILESTONES, *SAID_MILESTONES) if not reached[name]]
