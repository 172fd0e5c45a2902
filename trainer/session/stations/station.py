"""A station: one line to the session, with its role, its subscriptions and its counts.

A person at a terminal, a screen, a page and a panel are all stations: each sends lines and gets
lines. ``attendance`` calls ``take`` for the orders that have come. What concerns the line alone is
answered here: its role, its subscriptions, help, lines that are no order, orders that its role may
not give. The rest goes to ``dispatch`` as a ``Request``, and its answer comes back by ``answer``.

A line that has ever sent a program's sentence (``$TRO``) also gets facts. What came last, a
sentence or plain words, decides in which form it is answered.
"""

import math
import textwrap
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, Protocol

from trainer.io.line import Line
from trainer.io.lines import OverlongLine
from trainer.io.noise_log import NoiseLog
from trainer.io.orders import sentences
from trainer.io.orders.grammar import BadOrder, Order, Refused, Reply, to_the_crew
from trainer.io.orders.help import help_text
from trainer.io.orders.sentences import Message, parse_line
from trainer.io.recording.facts import Giver
from trainer.io.recording.facts import station as giver_at
from trainer.session.stations.channels import EVENTS_CHANNEL, TELETYPE_CHANNEL
from trainer.session.stations.display import MAX_LINE_LETTERS
from trainer.session.stations.roles import (
    COMMON_ORDERS,
    INSTRUCTOR_ROLE,
    MAX_TOKEN_GUESSES,
    ROLES,
    STRANGER_ROLE,
    TRAINEE_ROLE,
    Access,
    Role,
    hears_kind,
    refusal,
)
from trainer.session.stations.subscriptions import (
    Sender,
    Subscriptions,
    rate_of,
    unknown_channel,
    why_barred,
)

# orders that a line which came by itself may give, so that none fills the recording or delays
# others (docs/threat-model.md); more wait at their sender
ORDERS_A_SECOND: Final = 20
ORDERS_AT_ONCE: Final = 100  # orders after a silence, before the rate holds
ORDER_RATE: Final = (("second", str(ORDERS_A_SECOND)), ("once", str(ORDERS_AT_ONCE)))  # as told
WRONG_TOKEN_TEXT: Final = "wrong token: type role NAME TOKEN with the right one"  # noqa: S105
Log = Callable[[str, str], None]  # takes a kind of roles.EVENT_KINDS and a text


class Fact(NamedTuple):
    """A fact for programs: its name, one of sentences.FACTS, and its subject in fields."""

    what: str
    subject: str = ""


class Saying(NamedTuple):
    """What somebody said, and who: a role or ``schedule``. A program shows them apart."""

    speaker: str
    words: str


class News(NamedTuple):
    """An event. Its kind, one of roles.EVENT_KINDS, decides whose role hears of it."""

    tick: int
    seconds: float
    kind: str
    text: str  # for people
    fact: Fact | None = None  # for programs
    saying: Saying | None = None  # for programs, which show the speaker beside the words
    branch: int = 0  # of the recording, on which it has happened


@dataclass(frozen=True)
class Request:
    """An order that a line may give, to be obeyed and then answered there."""

    order: Order
    heard: Message
    station: "Station"


class LongAnswer(NamedTuple):
    """A long answer, and its result."""

    lines: Sequence[str]
    result: str = ""


Duty = Callable[[Request], Reply | LongAnswer | None]  # None: the answer comes later


class LateAnswer(NamedTuple):
    """The answer to a wrong token, which is kept back for a while."""

    due: float  # [s]
    heard: Message
    reply: Refused
    leaving: str  # why the line is closed after it, "" while it stays


@dataclass
class WordCounts:
    """The words that a line has sent."""

    orders: int = 0  # handed on
    refused: int = 0  # not its to give
    bad: int = 0  # no orders


class OrderAllowance:
    """The number of orders that a line may still give now (a token bucket)."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._since = clock()
        self.left = float(ORDERS_AT_ONCE)
        self.held_up = 0.0  # [s] until more is taken, 0 where nothing waits

    def share(self, most: int) -> int:
        """Return how many of ``most`` lines may be taken now; without one the sender waits."""
        now = self._clock()
        self.left = min(self.left + (now - self._since) * ORDERS_A_SECOND, ORDERS_AT_ONCE)
        self._since = now
        allowed = min(most, int(self.left))
        self.held_up = 0.0 if allowed else (1.0 - self.left) / ORDERS_A_SECOND
        return allowed


class TokenGuesses:
    """The wrong tokens of one line, and the answer that is kept back."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self.count = 0
        self.late: LateAnswer | None = None
        self._clock = clock

    @property
    def wait(self) -> float:
        """Return the time [s] to the answer that is kept back, infinity without one."""
        return max(self.late.due - self._clock(), 0.0) if self.late else math.inf

    def add(self, heard: Message, wait: float) -> None:
        """Count a wrong token, and keep its answer back for ``wait`` [s]."""
        self.count += 1
        last = self.count >= MAX_TOKEN_GUESSES
        closed = f", the {MAX_TOKEN_GUESSES}rd: this line is closed" if last else ""
        waited = f"; answered after {wait:g} s, because there were many" if wait else ""
        leaving = f"{MAX_TOKEN_GUESSES} wrong tokens" if last else ""
        why = Refused(f"wrong token{closed}{waited}")
        self.late = LateAnswer(self._clock() + wait, heard, why, leaving)

    def take_due(self) -> LateAnswer | None:
        """Return the answer that was kept back, once, when it is due."""
        if self.wait:
            return None
        due, self.late = self.late, None
        return due


class Station:
    """One attached line, from its coming to its going."""

    def __init__(
        self,
        line: Line,
        access: Access,
        sending: Sender,
        log: Log,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.line = line
        self.role = access.first
        self.counts = WordCounts()
        self.wishes = Subscriptions(line, sending)
        self.called = ""  # what it calls itself, as a screen for everybody does
        self.leaving = ""  # why the line is to be closed, "" while it stays
        self.waiting = False  # there may be more to take
        self.allowance = OrderAllowance(clock)
        self.guesses = TokenGuesses(clock)
        self._door = access
        self.settled = access.role is not None  # it is known for good what the line is
        self._log = log
        self._flooding = False  # it was logged that orders wait
        # It does not refer to this station, which is therefore freed as soon as it is dropped.
        self._log_hidden: Log = lambda kind, text: log(kind, access.hide(text))
        self._noise = NoiseLog(self._log_hidden, clock)
        self._machine = False  # a program spoke last
        self._program = False  # one has spoken

    @property
    def visits(self) -> bool:
        """Return whether the line came by itself, and may go."""
        return self._door.role is None

    @property
    def who(self) -> str:
        """Return who gives an order here, for the record."""
        return self.giver.words

    @property
    def giver(self) -> Giver:
        """Return who gives an order here."""
        return giver_at(self.role.name, self.line.name)

    def account(self) -> str:
        """Return what there is to say of the line, for the order ``who``."""
        c = self.counts
        called = f", called {self.called}" if self.called else ""
        text = f"{self.who}{called}: {c.orders} orders, {c.refused} refused, {c.bad} bad lines"
        lost = f", {self.line.dropped} lines lost" if self.line.dropped else ""
        trouble = f"; {self.line.trouble}" if self.line.trouble else ""
        return f"{text}{lost}{trouble}"

    def take(self, most: int) -> Iterator[Request]:
        """Yield the orders among the next lines, one at a time, at most so many.

        What comes after an order is heard once that has been answered.
        """
        self._noise.settle()
        allowed = self.allowance.share(most)
        self._answer_late()
        lines = self.line.take(allowed) if allowed else []
        self.waiting = len(lines) == allowed
        if not (allowed or self._flooding):
            self._flooding = True
            self._log("refused", f"{self.who}: more than {ORDERS_A_SECOND} orders a second wait")
        for line in lines:
            if self.leaving:
                break
            yield from self._hear(line)

    def answer(self, asked: Request, reply: Reply, *lines: str) -> None:
        """Answer an order by a long answer's lines, then the result or the reason."""
        self._answer(asked.heard, reply, *lines)

    def tell(self, news: News) -> None:
        """Tell of something that happened, if it is for this role and wanted."""
        if not (self.wishes.events and hears_kind(self.role, news.kind)):
            return
        self.note(news)
        if not self._machine:
            self.line.send(news.text)
            return
        if news.saying:
            self.note(news._replace(fact=Fact("said", ",".join(news.saying))))
        self.line.send(sentences.event(*news[:4]))

    def note(self, news: News) -> None:
        """Tell a program the fact of the news, unless it owes a token."""
        if news.fact and self._program and self.role is not STRANGER_ROLE:
            self.line.send(sentences.fact(news.tick, news.seconds, *news.fact))

    def take_chair(self, role: Role) -> None:
        """Take another role, with those of its channels that the new one may see."""
        self.role = role
        self.wishes.keep_for(role)

    def type_out(self) -> None:
        """Send the teletype line at every tick, as a line for people begins."""
        self.wishes.begin(TELETYPE_CHANNEL, 0.0, self.role, machine=False)

    def leave(self) -> None:
        """Send nothing more. Log how many bad lines were not written one by one."""
        self._noise.close()
        self.guesses.late = None
        self.wishes.end(*self.wishes.channels)

    def close(self, patience: float) -> None:
        """Leave, and close the line. After ``leave`` any thread may do it, since it may wait."""
        self.leave()
        self.line.close(patience)

    def _hear(self, line: str | OverlongLine) -> list[Request]:
        """Return the order to be obeyed on a line, if there is one; answer the rest."""
        if isinstance(line, OverlongLine):
            reason = f"longer than {line.limit} characters; nothing done"
            self._bad(Message(BadOrder("", reason), self._machine), reason)
            return []
        heard = parse_line(line)
        if heard is None:
            return []
        self._machine = heard.machine
        self._program = self._program or heard.machine
        if self.guesses.late:
            self._answer(heard, Refused("not heard: wait for the answer to the wrong token"))
            return []
        if isinstance(heard.order, BadOrder):
            self._bad(heard, heard.order.reason)
            return []
        return self._obey(heard, heard.order)

    def _bad(self, heard: Message, reason: str) -> None:
        """Answer a line that is no order."""
        self.counts.bad += 1
        self._log_refusal(f"{heard.order.text or 'a line'}: {reason}")
        self._answer(heard, Refused(reason))

    def _obey(self, heard: Message, order: Order) -> list[Request]:
        """Answer what concerns the line alone or is not its to order; return the rest."""
        if "order" in self.role.commands:
            order = to_the_crew(order)
        if refused := refusal(self.role, order):
            guessed = self.role is STRANGER_ROLE and self.guesses.count
            hint = "" if self._door.settles(self.role) else f"; {other_chair(order)}"
            told = WRONG_TOKEN_TEXT if guessed else f"{refused.reason}{hint}"
            self._refuse(heard, order, Refused(told))
            return []
        duties: dict[str, Callable[[Message, Order], None]] = {
            "role": self._take_role,
            "help": lambda heard, order: self._answer(heard, "", *help_text(order.word)),
            "subscribe": self._subscribe,
            "unsubscribe": lambda heard, order: self._answer(
                heard, self.wishes.cancel(order.subject)
            ),
            "detach": self._detach,
            "name": self._be_called,
        }
        changes = order.name == "role" and self.settled and not self._door.settles(self.role)
        if order.name in duties and not changes:
            duties[order.name](heard, order)
            return []
        self.counts.orders += 1
        self.allowance.left -= self.visits
        return [Request(order, heard, self)]

    def _refuse(self, heard: Message, order: Order, refused: Refused) -> None:
        """Refuse an order that this line's role may not give."""
        self.counts.refused += 1
        self._log_refusal(f"{order.text}: {refused.reason}")
        self._answer(heard, refused)

    def _log_refusal(self, text: str) -> None:
        """Log a refusal. Those of lines without a role go to a log that sums them up."""
        log = self._noise.log if self.settled else self._log_hidden
        log("refused", f"{self.who}: {text}")

    def _answer(self, heard: Message, reply: Reply, *lines: str) -> None:
        """Send an answer, as a sentence if the order came as one, else a line."""
        hidden = Refused(self._door.hide(reply.reason)) if isinstance(reply, Refused) else reply
        send_answer(self.line, heard, hidden, lines)

    def _be_called(self, heard: Message, order: Order) -> None:
        """Give the line a name of its own in the list of stations."""
        self.called = order.subject
        self._log("station", f"{self.who} is called {self.called}")
        self._answer(heard, f"this line is called {self.called}")

    def _detach(self, heard: Message, _order: Order) -> None:
        self.leaving = "detached"
        if self._program:
            self.line.send(sentences.fact(0, 0.0, "left", ""))
        self._answer(heard, "bye")

    def _take_role(self, heard: Message, order: Order) -> None:
        """Give the line the role that it says, once, if it has the token."""
        if self.settled:
            self._refuse(heard, order, Refused(f"you {self.role.part}: a line keeps its role"))
            return
        if not self._door.admits(order.word, order.subject):
            self._refuse_token(heard, order)
            return
        self.role, self.settled = ROLES[order.word], True
        self._door.entered()
        self._log("station", f"{self.line.name} now {self.role.of_another}")
        seen = [each for each in self.role.channels if not self.wishes.lack(each)]
        self._answer(heard, f"you {self.role.part}", *role_powers(self.role, seen))
        self.wishes.keep_for(self.role)

    def _refuse_token(self, heard: Message, order: Order) -> None:
        """Refuse a wrong token, in the log at once. The answer may have to wait.

        The line is closed after the third.
        """
        if not order.subject:
            needed = "this session needs a token: --token WORD, or type role NAME TOKEN"
            self._refuse(heard, order, Refused(needed))
            return
        self.counts.refused += 1
        self._log_refusal(f"{order.text}: wrong token")
        self.guesses.add(heard, self._door.delay())
        self._answer_late()

    def _answer_late(self) -> None:
        """Send the answer to a wrong token, once it is due."""
        if late := self.guesses.take_due():
            self.leaving = late.leaving
            self._answer(late.heard, late.reply)

    def _subscribe(self, heard: Message, order: Order) -> None:
        """Subscribe a channel, after the answer has been sent."""
        channel = order.subject
        if unknown := unknown_channel(channel, self.role):
            self._answer(heard, unknown)
            return
        if refused := why_barred(channel, self.role) or self.wishes.lack(channel):
            self._refuse(heard, order, refused)
            return
        rate = rate_of(channel, order.value)
        often = f"at most {rate:g} a second" if rate else "every tick"
        self._answer(
            heard, f"{channel}: {'as they happen' if channel == EVENTS_CHANNEL else often}"
        )
        self.wishes.begin(channel, rate, self.role, machine=heard.machine)


def role_powers(role: Role, channels: Sequence[str]) -> list[str]:
    """Return what a role may order and see, in lines of at most 79 columns."""
    own_orders = (
        "everything"
        if role is INSTRUCTOR_ROLE
        else ", ".join(sorted(role.commands - COMMON_ORDERS))
    )
    seen = ", ".join((*channels, EVENTS_CHANNEL))
    text = f"you may order {own_orders or 'nothing'}; you may see {seen}"
    return textwrap.wrap(text, MAX_LINE_LETTERS)


class Reception(Protocol):
    """The source of stations that come by themselves."""

    @property
    def awaited(self) -> bool:
        """Return whether a run without stations goes on, because one may still come."""

    def newcomers(self) -> list[Station]:
        """Return the stations that have come since the last call."""


class NoReception:
    """A reception without newcomers."""

    awaited = False

    def newcomers(self) -> list[Station]:
        """Return nobody."""
        return []


def other_chair(order: Order) -> str:
    """Return in which chair a lone person may give an order."""
    chair = TRAINEE_ROLE if order.name in TRAINEE_ROLE.commands else INSTRUCTOR_ROLE
    return f"who is alone may, after `role {chair.name}`"


def send_answer(line: Line, heard: Message, reply: Reply, lines: Sequence[str]) -> None:
    """Send an answer, as a sentence if the order came as one, else a line."""
    accepted = not isinstance(reply, Refused)
    text = reply.reason if isinstance(reply, Refused) else reply
    if heard.machine:
        for answer_line in lines:
            line.send(sentences.say(heard.tag, answer_line))
        line.send(sentences.answer(heard.tag, accepted=accepted, text=text))
        return
    for answer_line in lines:
        line.send(answer_line)
    if text:
        line.send(text if accepted else f"? {text}")
