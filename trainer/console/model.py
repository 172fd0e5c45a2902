"""All that a screen knows of its session: what it shows, what was said, what was asked."""

import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, NamedTuple, Protocol

from trainer.console.client import Barred, Greeting, Item, Joined, Lost
from trainer.console.journal import Journal, Sample, Trace
from trainer.console.readings import Picture
from trainer.io.orders.sentences import Sentence

NUMBER: Final = r"[0-9]+(?:\.[0-9]+)?(?:e\+[0-9]{1,3})?"  # as Python's "g" writes it
KEPT_MOMENT: Final = re.compile(rf"([a-z][a-z0-9-]*) \(({NUMBER}) s\)")
BACK: Final = re.compile(rf"back from {NUMBER} s to ({NUMBER}) s")
GOING_BACK: Final = ("backtrack", "restore", "reset")
OVER: Final = "the session is over"  # its last words
WIDELY_KNOWN: Final = ("snapshots", "casualties")  # asked for on joining, by the instructor


class Quantity(NamedTuple):
    """What a chart shows: a name, a unit, and where the actual and the ordered value come from."""

    name: str
    unit: str
    actual: tuple[str, str]  # channel, field
    ordered: tuple[str, str] | None
    least: float  # shown range at least
    signs: tuple[str, str] = ("", "")  # before a positive and a negative value


class Broken(NamedTuple):
    """A casualty that can be had: how it is ordered unless said otherwise, and what it is."""

    name: str
    degree: str
    says: str


class Kept(NamedTuple):
    """Something on the time line."""

    seconds: float
    sign: str
    text: str


class Talk(Protocol):
    """Who carries words to the session, and brings what it says."""

    def order(self, words: str) -> str:
        """Send an order; return its tag, "" when there is no line."""
        ...

    def take(self) -> list[Item]:
        """Return what has come since the last call."""
        ...


@dataclass
class Asked:
    """An order on its way; ``quiet`` ones are the screen's own."""

    words: str
    quiet: bool
    lines: list[str] = field(default_factory=list)


@dataclass
class Sight:
    """The session as one station sees it."""

    talk: Talk
    role: str
    charts: tuple[Quantity, ...]
    clock: Callable[[], float] = time.monotonic
    picture: Picture = field(default_factory=Picture)
    journal: Journal = field(default_factory=Journal)
    greeted: bool = False  # the session has taken the role once
    joined: bool = False
    trouble: str = ""  # with the line
    barred: str = ""
    over: bool = False
    ended: bool = False  # by an order of this screen
    briefing: list[str] = field(default_factory=list)
    casualties: list[Broken] = field(default_factory=list)
    snapshots: list[Kept] = field(default_factory=list)
    marks: list[Kept] = field(default_factory=list)
    furthest: float = 0.0  # [s] that time has reached on this branch
    refused: int = 0  # orders of this screen
    trace: Trace = field(init=False)

    def __post_init__(self) -> None:
        self.trace = Trace(len(self.charts))
        self._asked: dict[str, Asked] = {}

    @property
    def instructs(self) -> bool:
        """Return whether this is the instructor's screen, who sees the truth."""
        return self.role == "instructor"

    @property
    def waiting(self) -> int:
        """Return how many orders have not been answered yet."""
        return len(self._asked)

    @property
    def gauges(self) -> str:
        """Return the channel of depth, heading, speed and attitude."""
        return "motion" if self.instructs else "gauges"

    def order(self, words: str) -> bool:
        """Send an order and show it; return whether there was a line to send it on."""
        return self._send(words, quiet=False)

    def ask(self, words: str) -> bool:
        """Send an order of the screen's own, which is not shown."""
        return self._send(words, quiet=True)

    def hear(self) -> None:
        """Take what has come."""
        for item in self.talk.take():
            if isinstance(item, Sentence):
                self._read(item)
            elif isinstance(item, Greeting):
                self._greet(item.text)
            elif isinstance(item, Joined):
                self._join()
            elif isinstance(item, Lost):
                self._lose(item.why)
            else:
                self._bar(item)

    def _send(self, words: str, *, quiet: bool) -> bool:
        if not quiet:
            self.journal.add(self.picture.seconds, "sent", words)
        tag = self.talk.order(words)
        if tag:
            self._asked[tag] = Asked(words, quiet)
        elif not quiet:
            self.journal.add(None, "refused", f"not sent: {self.trouble or 'no line'}")
        return bool(tag)

    # the line

    def _join(self) -> None:
        if self.greeted:
            self.journal.add(None, "station", "the line is back")
        self.joined, self.trouble, self.over, self.greeted = True, "", False, True
        for words in WIDELY_KNOWN if self.instructs else ():
            self.ask(words)

    def _lose(self, why: str) -> None:
        if not self.over and (self.joined or why != self.trouble):
            self.journal.add(None, "lost", f"no line: {why}")
        self.joined, self.trouble = False, why
        self._asked.clear()
        self.picture.forget()

    def _bar(self, barred: Barred) -> None:
        self.joined, self.barred, self.trouble = False, barred.why, barred.why

    def _greet(self, text: str) -> None:
        """Keep what whoever comes is told, the first time."""
        if text not in self.briefing:
            self.briefing.append(text)
            self.journal.add(None, "briefing", text)

    # what the session says

    def _read(self, sentence: Sentence) -> None:
        if sentence.kind == "TRA":
            self._answered(sentence)
        elif sentence.kind == "TRE":
            self._happened(sentence)
        elif self.picture.take(sentence, self.clock()) == self.gauges:
            self._sample()

    def _sample(self) -> None:
        """Add the present to the charts."""
        reading = self.picture.reading(self.gauges)
        if self.trace.times[-1:] != [reading.seconds]:
            number = self.picture.number
            samples = [
                Sample(number(*each.actual), number(*each.ordered) if each.ordered else None)
                for each in self.charts
            ]
            self.trace.add(reading.seconds, samples)
        self.furthest = max(self.furthest, reading.seconds)

    def _happened(self, sentence: Sentence) -> None:
        _, seconds, kind, text = sentence.fields
        self.journal.add(float(seconds), kind, text)
        _, _, said = text.partition(": ")  # who has ordered, or remarked, it
        if kind == "mark":
            self._mark(float(seconds), said)
        else:
            words, _, answer = said.partition(": ")
            self._remember(float(seconds), kind, words, answer)
        if kind == "time" and text == OVER:
            self.over = True

    def _answered(self, sentence: Sentence) -> None:
        kind, text = sentence.fields
        asked = self._asked.get(sentence.tag)
        if asked is None:
            if kind == "no":
                self.journal.add(None, "refused", text)
            return
        if kind == "say":
            asked.lines.append(text)
            return
        del self._asked[sentence.tag]
        if not asked.quiet:
            self._show_answer(asked, kind, text)
        if kind == "ok":
            self.ended = self.ended or asked.words == "quit"
            self._learn(asked, text)
        else:
            self.refused += 1

    def _show_answer(self, asked: Asked, kind: str, text: str) -> None:
        for each in asked.lines:
            self.journal.add(None, "answer", each)
        if text:
            self.journal.add(None, "answer" if kind == "ok" else "refused", text)

    def _learn(self, asked: Asked, text: str) -> None:
        """Keep what an answer tells for good."""
        if asked.words == "snapshots":
            self.snapshots = [Kept(float(s), "S", n) for n, s in KEPT_MOMENT.findall(text)]
        elif asked.words == "casualties":
            self.casualties = suffered(asked.lines)
        elif asked.words.startswith("mark"):
            self._mark(self.picture.seconds, asked.words.removeprefix("mark").strip())
        elif not asked.quiet:
            kind = "moment" if asked.words.startswith(GOING_BACK) else "exercise"
            self._remember(self.picture.seconds, kind, asked.words, text)

    def _mark(self, seconds: float, remark: str) -> None:
        self.marks.append(Kept(seconds, "M", remark or "marked"))

    def _remember(self, seconds: float, kind: str, words: str, answer: str) -> None:
        """Keep on the time line what is worth going back to.

        Only what the session says of an order to go back takes anything from it.
        """
        back = BACK.match(answer) if kind == "moment" else None
        if back:
            self._go_back(float(back[1]))
        elif answer.startswith("refused: "):
            return
        elif words.startswith("snapshot ") and self.instructs:
            self.ask("snapshots")
        elif words.startswith("casualty "):
            self.marks.append(Kept(seconds, "C", words))

    def _go_back(self, seconds: float) -> None:
        """Forget what lies after a moment gone back to."""
        self.marks = [kept for kept in self.marks if kept.seconds <= seconds]
        self.furthest = seconds
        if self.instructs:
            self.ask("snapshots")


def suffered(lines: list[str]) -> list[Broken]:
    """Return the casualties that the session lists: a line as it is ordered, then one in words."""
    found: list[Broken] = []
    for text in lines:
        if text.startswith(" ") and found:
            found[-1] = found[-1]._replace(says=text.strip())
        else:
            name, _, degree = text.partition(" ")
            found.append(Broken(name, degree, ""))
    return found
