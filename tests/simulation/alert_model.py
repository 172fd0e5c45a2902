"""Who may acknowledge and silence alerts, and what has become of each by that.

The model asks docs/station-tables.md who answers for an alert, not the product's table. It notes
each acknowledgement and silence that was answered, with its branch and tick. So it knows, wherever
time stands, and in the process after a kill, which alerts somebody has seen.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Final, NamedTuple

from helpers import places

from trainer.io.orders.grammar import Order, Refused
from trainer.io.recording.recording import RecordingError
from trainer.session.session import Session
from trainer.session.stations.alerts import Alert

SILENT_S: Final = 30.0  # that a silence lasts, as docs/orders.md has it
ROUNDED_S: Final = 0.5  # [s] about its end
INSTRUCTORS_KIND: Final = "watch"  # of the events that instructors alone hear
OWED_RANKS: Final = ("alarm", "warning")
MANY_PAST: Final = 150  # alerts that are over, of which the oldest may be gone
NOBODY: Final = ""  # has seen it


Said = tuple[str, str, str]  # "seen" or "silenced", the role of a silence, the alert's number


class Deed(NamedTuple):
    """An alert that somebody has seen, or silenced."""

    what: str  # "seen" or "silenced", as recordings have it
    number: int
    role: str
    branch: int
    tick: int


class Book(NamedTuple):
    """The alerts of a session, and the roles that are manned."""

    alerts: Mapping[int, Alert]
    open: frozenset[int]
    manned: frozenset[str]
    silent: frozenset[tuple[str, int]]  # at which role which is silent

    @classmethod
    def of(cls, session: Session, now: float) -> "Book":
        """Return how they are at a time [s]."""
        log = session.event_log
        alerts = {alert.number: alert for alert in log.alerts.all}
        manned = frozenset(station.role.name for station in log.stations)
        silent = frozenset(
            (role, int(name))
            for role, kept in log.own_alerts.by_role.items()
            for name, said in kept.items()
            if said.word == "silent" and said.due > now and name.isdigit()
        )
        return cls(alerts, frozenset(log.alerts.open), manned, silent)


@cache
def owners() -> Mapping[str, frozenset[str]]:
    """Return the roles that acknowledge each alert, by its name in docs/station-tables.md."""
    text = (places.ROOT / "docs" / "station-tables.md").read_text(encoding="utf-8")
    table = text.partition("\n## Alerts\n")[2].partition("\n## ")[0]
    cells = [line.strip("| ").split(" | ") for line in table.splitlines() if line.count(" | ") == 7]
    roles = {row[1].strip("`"): row[7].strip(" |").split(", ") for row in cells[1:]}
    return {name: frozenset(answer) for name, answer in roles.items()}


def hears(role: str, alert: Alert) -> bool:
    """Return whether a role hears of an alert."""
    return role == "instructor" or (alert.kind != INSTRUCTORS_KIND and role != "class")


def is_owed(alert: Alert) -> bool:
    """Return whether somebody still has to acknowledge an alert."""
    return alert.rank.value in OWED_RANKS and alert.seen is None


def may_see(role: str, alert: Alert, manned: Iterable[str]) -> bool:
    """Return whether it is for a role to acknowledge an alert."""
    there = owners()[alert.key.partition(":")[0]] & frozenset(manned)
    return role == "trainee" or not there or role in there


def meant_by(order: Order, role: str, book: Book) -> frozenset[int]:
    """Return the alerts that an order ``ack`` acknowledges or silences, none if it is refused."""
    heard = {n: a for n, a in book.alerts.items() if n in book.open and hears(role, a)}
    number = int(order.value)
    if order.word == "silent":
        alert = heard.get(number)
        sounds = (
            alert and alert.over is None and (is_owed(alert) or alert.rank.value == "emergency")
        )
        return frozenset([number] if sounds else [])
    seen = frozenset(n for n, a in heard.items() if is_owed(a) and may_see(role, a, book.manned))
    if order.word != "all":
        return seen & {number}
    return seen if role == "instructor" else frozenset()


@dataclass
class AlertModel:
    """What has become of the alerts of a session, through all its processes."""

    tell: Callable[[str], object]  # told what is another
    clock: Callable[[], float]  # [s]
    said: set[Said]  # what was ever to be done
    deeds: list[Deed] = field(default_factory=list)
    doubtful: set[int] = field(default_factory=set)  # alerts of a time that was not recorded
    silent: dict[tuple[str, int], tuple[float, int]] = field(default_factory=dict)  # until, tick

    def begin(self, session: Session, kept: Callable[[Deed], bool]) -> None:
        """Begin with a process; what it was left of an alert is in its file."""
        self.silent.clear()
        self.deeds = [deed for deed in self.deeds if kept(deed)]
        self.check(session, "at the beginning")

    def expect(self, order: Order, role: str, book: Book) -> None:
        """Note what an order is to do: lines hear of it before its answer."""
        if order.name == "ack" and not order.subject:
            silent = order.word == "silent"
            self.said |= {
                ("silenced" if silent else "seen", role if silent else "", str(number))
                for number in meant_by(order, role, book)
            }

    def hear(
        self, session: Session, order: Order, role: str, reply: object, before: Book, *, moved: bool
    ) -> None:
        """Take an order and its answer; ``moved``: the session may be at another moment now."""
        after, text = Book.of(session, self.clock()), repr(order.text)
        if order.name == "ack" and not order.subject and reply is not None:
            self._hear_ack(session, order, role, reply, before)
        elif not moved:
            self._compare(before, after, text, {})
        if moved:
            self.check(session, f"after {text}")
        self._check_silence(session, after, f"after {text}")

    def _hear_ack(
        self, session: Session, order: Order, role: str, reply: object, before: Book
    ) -> None:
        meant, history = meant_by(order, role, before), session.history
        what, text = "silenced" if order.word == "silent" else "seen", f"{order.text!r} of {role}"
        refused = isinstance(reply, Refused)
        if refused is bool(meant):
            answer = "refused" if refused else "obeyed"
            self.tell(f"{text} is {answer}, where it is to do {sorted(meant) or 'nothing'}")
        done = {} if refused else dict.fromkeys(meant, (what, role))
        self._compare(before, Book.of(session, self.clock()), text, done)
        for number in done:
            if what == "silenced":
                self.silent[role, number] = self.clock() + SILENT_S, history.tick
            if not history.flown.replaying:
                self.deeds.append(Deed(what, number, role, history.recording.branch, history.tick))
            if history.recording.trouble:
                self.doubtful.add(number)

    def tick(self, session: Session, before: Book, *, moved: bool) -> None:
        """Take a tick, in which nobody acknowledges anything."""
        after, text = Book.of(session, self.clock()), f"after tick {session.history.tick}"
        if moved:
            self.check(session, text)
        else:
            self._compare(before, after, text, {})
        self._check_silence(session, after, text)

    def _compare(
        self, before: Book, after: Book, text: str, done: Mapping[int, tuple[str, str]]
    ) -> None:
        """Look whether alerts were seen and silenced by nobody but those who did."""
        for number, was in before.alerts.items():
            now = after.alerts.get(number)
            if now is None:
                continue
            what, role = done.get(number, ("", NOBODY))
            seen = role if what == "seen" else was.seen_by
            silent = (*roles_of(was), role) if what == "silenced" else roles_of(was)
            if (now.seen_by, roles_of(now)) != (seen, silent):
                self.tell(
                    f"{text}: alert {number} is seen by {now.seen_by or 'nobody'} and silent at "
                    f"{roles_of(now)}, not by {seen or 'nobody'} and at {silent}"
                )

    def _check_silence(self, session: Session, book: Book, when: str) -> None:
        """Look whether each alert is silent where somebody has silenced it, and nowhere else."""
        now, tick = self.clock(), session.history.tick
        # what was silenced later than a moment sounds there
        self.silent = {key: each for key, each in self.silent.items() if each[1] <= tick}
        due = {key for key, (until, _) in self.silent.items() if until - now > ROUNDED_S}
        over = {key for key, (until, _) in self.silent.items() if abs(now - until) <= ROUNDED_S}
        if wrong := sorted(book.silent - due - over):
            self.tell(f"{when}: {wrong} are silent, and nobody has silenced them")
        if wrong := sorted(due - over - book.silent):
            self.tell(f"{when}: {wrong} sound, which were silenced")

    def check(self, session: Session, when: str) -> None:
        """Look whether all is seen and silenced that was so by this moment."""
        history = session.history
        recording = history.recording
        book = Book.of(session, self.clock())
        try:
            ends = dict(way_to(session))
        except (RecordingError, KeyError):
            ends = {}
        if recording.trouble or not ends:  # a jump cannot read then which alerts are of its way
            self.doubtful |= book.alerts.keys()
        if recording.trouble or recording.missing or history.flown.replaying:
            return
        stands = [each for each in self.deeds if each.tick <= ends.get(each.branch, -1)]
        seen = {each.number: each.role for each in stands if each.what == "seen"}
        for number, alert in book.alerts.items():
            if number in self.doubtful:
                continue
            if alert.seen_by != seen.get(number, NOBODY):
                wanted = seen.get(number, "nobody")
                self.tell(f"{when}: alert {number} is seen by {alert.seen_by!r}, not by {wanted}")
            silent = tuple(s.role for s in stands if (s.what, s.number) == ("silenced", number))
            if roles_of(alert) != silent:
                self.tell(f"{when}: alert {number} is silent at {roles_of(alert)}, not at {silent}")
        gone = {each.number for each in stands} - book.alerts.keys() - self.doubtful
        if gone and len(book.alerts) - len(book.open) < MANY_PAST:
            self.tell(f"{when}: the alerts {sorted(gone)} are gone, which somebody has seen")


def roles_of(alert: Alert) -> tuple[str, ...]:
    """Return at which roles an alert was silenced."""
    return tuple(role for role, _ in alert.silenced)


def way_to(session: Session) -> Iterator[tuple[int, int]]:
    """Yield the branches that lead to the present moment, with the last tick of each."""
    recording, tick = session.history.recording, session.history.tick
    branches = {each.id: each for each in recording.branches()}
    number: int | None = recording.branch
    while number is not None:
        yield number, tick
        tick = min(tick, branches[number].tick)
        number = branches[number].parent
