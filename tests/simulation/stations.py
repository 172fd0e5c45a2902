"""The programs at the far ends of the lines.

They say what the script has, and read what they are sent.
"""

import itertools
import math
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from socket import AF_INET, AF_UNIX
from typing import Final

from simulation.admission import STRANGERS_WORDS, is_admitted, secrets_of
from simulation.laws import Docket, Law
from simulation.machine import SECOND_NS, Machine, Task
from simulation.model import INSTRUCTORS_FACTS
from simulation.network import Network, Socket
from simulation.script import Act, Farewell, Player, Visit, Way
from simulation.wires import Cable
from trainer.io.connection import carried_for
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.help import help_text
from trainer.io.orders.sentences import Sentence, order_sentence, parse_sentence
from trainer.session.stations.roles import ROLES, hears_kind

NOISE_TAG: Final = 900_000  # and above: of sentences that are noise
REDIAL_S: Final = 0.5  # [s] until a program calls again where nobody listens
SIP_PERIOD_S: Final = 1.0
BROWSER: Final = "192.0.2.7"  # another machine, at which the pages are looked at
HEAR_OUT_S: Final = 1.0  # [s] for which a program that hangs up waits for answers
SHOWN_WITHIN_S: Final = 2.0  # beyond its own period, that a channel may show what was before
FASTEST_HZ: Final = {"predictor": 1.0, "safe": 1.0}  # whatever is asked for
GIVE_UP_S: Final = 0.2  # [s] after which a program that cannot send hangs up

ASIDE_WORDS: Final = ("hint", "what if")  # answered when that is found, orders later perhaps


@dataclass
class Program:
    """One program, through its visits."""

    player: Player
    number: int
    machine: Machine
    network: Network
    docket: Docket
    hear: Callable[[bytes], object]  # told all that comes
    cable: Cable | None = None  # by which it comes, None for a socket
    place: tuple[int, int] = (0, 0)  # visits that are done, lines of the next that were said
    _idle_since: int = 0  # [ns] when the last visit was done
    _end: Socket = field(init=False, repr=False)
    _asked: deque[str] = field(default_factory=deque)  # tags of whole orders on this line
    _aside: deque[str] = field(default_factory=deque)  # of those whose answer is found aside
    _tag: int = 0
    _first: int = 0  # tag of this visit
    _sip: int = 0  # [bytes] that it takes at once, 0 for all
    _torn: bool = False  # what comes first may be the end of a line
    _rest: bytes = b""
    _entered: bool = False  # its role was granted
    tokens: tuple[str, ...] = ()  # that the session asks for
    _roles: set[str] = field(default_factory=set)  # that it has said
    _free: set[str] = field(default_factory=set)  # tags of what a line may say without a word
    # by channel, when [ns] it was last shown and of which tick, and its period [s]
    _shown: dict[str, tuple[int, int]] = field(default_factory=dict)
    _periods: dict[str, float] = field(default_factory=dict)

    def run(self) -> None:
        """Make all visits, then wait for more."""
        for number in itertools.count():
            if number < len(self.player.visits):
                self.place = number, 0
                self.machine.sleep(self.player.visits[number].after)
            else:
                self._idle_since = self.machine.now
                self.machine.wait(lambda: False)
            while (end := self._call(self._visit.room)) is None:
                self.machine.sleep(REDIAL_S)
            self._end, self._asked, self._rest, self._entered = end, deque(), b"", False
            self._aside.clear()
            self._free.clear()
            self._shown.clear()
            self._periods.clear()
            self._first, self._sip = self._tag + 1, self._visit.sip
            if self.player.way is Way.PAGE:
                self._send(f"{carried_for(BROWSER)}\n".encode())
            role = f"role {self.player.role} {self.player.token}".rstrip()
            if self._say(Act(0.0, role)) and self._act():
                self._leave(self.player.visits[number].farewell)
            self.place = number + 1, -1
            if self.cable is None:
                end.close()

    def go_on(self, player: Player, task: Task) -> None:
        """Go on as another player, who has done the same so far."""
        done, _ = self.place
        if done == len(self.player.visits) < len(player.visits) and task.is_idle:
            self.place = done, 0
            task.wake_at(self._idle_since, player.visits[done].after)
        self.player = player

    @property
    def _owes(self) -> bool:
        """Return whether it does not know the word that its role asks for."""
        word = self.player.token
        asked = self.tokens and self.cable is None
        return bool(asked) and not is_admitted(self.tokens, self.player.role, word)

    @property
    def _visit(self) -> Visit:
        return self.player.visits[self.place[0]]

    def _call(self, room: int) -> Socket | None:
        """Return an end that leads to the session, None where nobody listens."""
        if self.cable is None:
            family = AF_UNIX if self.player.way is Way.PAGE else AF_INET
            return self.network.call(room, family)
        end = self.cable.far
        if end:
            whole = not end.came or end.came.endswith(b"\r\n")
            self._torn = not whole
            end.came.clear()  # nobody read it
        return end

    def _act(self) -> bool:
        """Say all that is to be said; return whether the line is still there."""
        done, said = self.place
        while said < len(self._visit.acts):
            after = self._visit.acts[said].after
            if not self._visit.reads:
                self.machine.sleep(after)
            elif not self._listen(after):
                return False
            said += 1
            self.place = done, said
            if not self._say(self._visit.acts[said - 1]):
                return False
        visit = self._visit
        self.place = done + 1, -1
        hears_out = visit.reads and visit.farewell is Farewell.HANGS_UP
        return not hears_out or self._listen(HEAR_OUT_S)

    def _listen(self, seconds: float) -> bool:
        """Read what comes for a time; return whether the line is still there."""
        machine = self.machine
        until = machine.now + int(seconds * 1e9)
        if self._sip:
            while machine.now < until:
                machine.sleep(SIP_PERIOD_S)
                if self._is_heard() and not self._read():
                    return False
            return True
        while machine.wait(self._is_heard, max(until - machine.now, 0) / 1e9):
            if not self._read():
                return False
        self._look_shown(slept=machine.now > until + SECOND_NS)
        return True

    def _look_shown(self, *, slept: bool) -> None:
        """L19: look whether each channel has shown the moment that came after its last."""
        now, pictures = self.machine.now, self.docket.pictures
        for channel, period in self._periods.items():
            at, tick = self._shown.get(channel, (now, -1))
            if slept:  # the whole machine did
                self._shown[channel] = now, tick
                continue
            later = bisect_right(pictures, at)
            within = int((SHOWN_WITHIN_S + period) * SECOND_NS)
            if later < len(pictures) and now - pictures[later] > within:
                text = f"{channel} shows nothing for {(now - pictures[later]) / SECOND_NS:.1f} s"
            elif now - max(at, pictures[-1]) > within and tick != self.docket.picture[0]:
                text = f"{channel} shows tick {tick}, and it is {self.docket.picture[0]}"
            else:
                continue
            self.docket.enter(Law.SHOWN, f"{self._name}: {text}")

    def _is_heard(self) -> bool:
        return self._end.readable

    def _say(self, act: Act) -> bool:
        """Send a line; return whether the line is still there."""
        if act.noise:
            return self._send(act.words.encode("latin-1"))
        self._tag += 1
        self._note_channels(act.words)
        data = f"{order_sentence(act.words, str(self._tag))}{act.end}".encode()
        half = len(data) // 2 if act.pause else 0
        if half:
            if not self._send(data[:half]):
                return False
            self.machine.sleep(act.pause)
        if act.words.startswith("role "):
            self._roles.add(act.words.split()[1])
        guess = self._owes and act.words.startswith("role ")  # its answer may be kept back
        aside = guess or act.words.startswith(ASIDE_WORDS)
        if act.words.startswith(STRANGERS_WORDS):
            self._free.add(str(self._tag))
        # it may be answered before the last turn comes back
        (self._aside if aside else self._asked).append(str(self._tag))
        return self._send(data[half:])

    def _note_channels(self, words: str) -> None:
        """Note what is to be shown from now on, and how often."""
        order = parse(words)
        if not isinstance(order, Order):
            return
        if order.name == "subscribe":
            fastest = FASTEST_HZ.get(order.subject, math.inf)
            rate = min(order.value or math.inf, fastest)
            self._periods[order.subject] = 1.0 / rate
            self._shown.pop(order.subject, None)  # of a history before
        elif order.name == "history":  # its lines are as those that show the present
            self._periods.pop(order.subject, None)
        elif order.name in ("unsubscribe", "role", "detach"):
            self._periods.clear()

    def _send(self, data: bytes) -> bool:
        try:
            while data:
                data = data[self._end.send(data) :]
        except BlockingIOError:
            self.machine.sleep(GIVE_UP_S)
            return False
        except OSError:
            return False
        return True

    def _leave(self, farewell: Farewell) -> None:
        if farewell is Farewell.HALF:
            self._send(order_sentence("depth 90", str(NOISE_TAG)).encode()[:-7])
        if self.cable is None:
            self._end.peer.reset = farewell is Farewell.RESET
        elif farewell is Farewell.RESET:
            self.cable.pull()

    def _read(self) -> bool:
        """Take what has come; return whether the line is still there."""
        try:
            data = self._end.recv(self._sip or 100_000)
        except OSError:
            return False
        self.hear(data)
        for word in secrets_of(self.tokens):
            if word in self._rest + data:
                self.docket.enter(Law.ADMITTED, f"{self._name} is told {word.decode()}")
        *lines, self._rest = (self._rest + data).split(b"\r\n")
        if self._torn and lines:
            self._torn = False
            del lines[0]
        for line in lines:
            if line.startswith(b"$"):
                self._hear_sentence(line.decode("ascii"))
            elif self._owes and line[:2] != b"? " and line.decode() not in help_text(""):
                # noise is answered by "? ", or by help
                self.docket.enter(Law.ADMITTED, f"{self._name} has no word, and is told {line!r}")
        return bool(data)

    def _hear_sentence(self, line: str) -> None:
        sentence = parse_sentence(line)
        if sentence is None:
            self.docket.enter(Law.ANSWERS, f"{self._name}: a damaged line: {line!r}")
        elif sentence.kind == "TRA":
            self._hear_answer(sentence, line)
        elif self._entered:
            self._hear_shown(sentence, line)
        elif self._owes and sentence.fields[2] != "left":
            self.docket.enter(Law.ADMITTED, f"{self._name} has no word, and sees {line!r}")

    def _hear_answer(self, sentence: Sentence, line: str) -> None:
        """L5: the next answer on a line is that of the oldest order that has none."""
        if sentence.fields[0] == "say" or not sentence.tag or int(sentence.tag) >= NOISE_TAG:
            return
        if int(sentence.tag) < self._first:
            return  # a cable has it from a visit before
        if self.tokens and self.cable is None:
            self._hear_admission(sentence, line)
        if sentence.tag in self._aside:
            self._aside.remove(sentence.tag)
            self.docket.answers += 1
            return
        while sentence.tag in self._asked and self._may_lose(self._asked[0], sentence.tag):
            self._asked.popleft()
        if not self._asked or self._asked[0] != sentence.tag:
            waiting = ", ".join(list(self._asked)[:4]) or "none"
            self.docket.enter(Law.ANSWERS, f"{self._name}: {line!r}, where {waiting} wait")
        while self._asked and self._asked.popleft() != sentence.tag:
            pass
        self._entered = self._entered or sentence.fields[0] == "ok"
        self.docket.answers += 1

    def _hear_admission(self, sentence: Sentence, line: str) -> None:
        """L21: look at an answer where the session asks for words."""
        granted, asks = sentence.fields[0] == "ok", sentence.tag == str(self._first)
        self.docket.log.see_word(granted=granted, owes=self._owes, asks=asks)
        if self._owes and granted and sentence.tag not in self._free:
            self.docket.enter(Law.ADMITTED, f"{self._name} has no word: {line!r}")
        elif asks and not granted and not self._owes:
            self.docket.enter(Law.ADMITTED, f"{self._name} says its word: {line!r}")

    def _may_lose(self, waiting: str, tag: str) -> bool:
        """Return whether an answer may be missing before another.

        A slow reader loses lines, which the session counts. The first order of a visit by cable
        may hang on half a line of the visit before.
        """
        first = self.cable is not None and waiting == str(self._first)
        return waiting != tag and (first or bool(self._sip))

    def _hear_shown(self, sentence: Sentence, line: str) -> None:
        """L11: a line has the channels and the events of its role alone."""
        role, shown = ROLES[self.player.role], sentence.fields
        if sentence.kind in ("TRN", "TRS"):
            allowed = shown[0] in role.channels
            if sentence.kind == "TRS":
                self._shown[shown[0]] = self.machine.now, int(shown[1])
        else:
            allowed = sentence.kind != "TRE" or hears_kind(role, shown[2])
        if sentence.kind == "TRF" and shown[2] in INSTRUCTORS_FACTS:
            allowed = allowed and self.player.role == "instructor"
        if sentence.kind == "TRF" and shown[2] == "alert-state":
            self._hear_state(*shown[3].split(",")[:2])
        self.docket.log.see_shown(sentence.kind, sentence.fields)
        if not allowed:
            self.docket.enter(Law.SECRETS, f"{self._name} may not see {line!r}")

    def _hear_state(self, number: str, state: str) -> None:
        """L20: an alert is told silent where somebody has silenced it, and seen once it was."""
        deeds = self.docket.alert_deeds
        silent = any(("silenced", role, number) in deeds for role in self._roles)
        if (state == "silenced" and not silent) or (
            state == "acknowledged" and ("seen", "", number) not in deeds
        ):
            self.docket.enter(Law.ALERTS, f"{self._name} is told that alert {number} is {state}")

    @property
    def _name(self) -> str:
        return f"{self.player.role} {self.number}"
