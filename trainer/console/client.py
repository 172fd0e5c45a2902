"""The line to a session, which is dialled again when it is lost.

``model`` takes what has come. Role and subscriptions are then sent again. A thread of its own does
all this. It keeps what comes until the screen takes it, up to MAX_KEPT_ITEMS, so that a screen that
is held up loses the oldest and holds up nobody.
"""

import itertools
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from trainer.io.client import dial
from trainer.io.line import Line
from trainer.io.lines import OverlongLine
from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS, Refused
from trainer.io.orders.sentences import Sentence
from trainer.io.serial_line import LinkError

# [s] until a lost line is dialled again, twice as long each time after
FIRST_REDIAL_S: Final = 0.25
MAX_WAIT_S: Final = 4.0  # [s] between two dials
MAX_KEPT_ITEMS: Final = 2000  # items that have come and that the screen has not taken
BATCH_LINES: Final = 200  # [lines]
ROLE_TAG: Final = "1"  # tags of what the client says of itself
WISH_TAG: Final = "2"
# [characters]
MAX_ORDER_LETTERS: Final = MAX_LINE_LETTERS - len(sentences.order_sentence("", "999999"))
Reach = Callable[[str, threading.Event], Line]


@dataclass(frozen=True)
class RoleTaken:
    """The session has taken the role."""


@dataclass(frozen=True)
class LineLoss:
    """There is no line now; it is dialled again."""

    why: str


class RoleRefusal(Refused):
    """The session refuses the role for good."""


@dataclass(frozen=True)
class Greeting:
    """A line that the session sends to whoever comes."""

    text: str


class NeverBegunError(Exception):
    """There is no session and there will be none."""


Item = RoleTaken | LineLoss | RoleRefusal | Greeting | Sentence


class Client:
    """One station's line to its session."""

    def __init__(
        self, url: Callable[[], str], role: str, wishes: Mapping[str, str], *, reach: Reach = dial
    ) -> None:
        """Keep a line to ``url()`` for ``role``, with its token and its channels in ``wishes``.

        A wish is a channel and its rate, such as ``at 10 hz``. ``url`` may wait for the session,
        and raise NeverBegunError.
        """
        self._url = url
        self._role = role
        self._wishes = wishes
        self._reach = reach
        self._items: deque[Item] = deque(maxlen=MAX_KEPT_ITEMS)
        self._wake = threading.Event()
        self._closing = threading.Event()
        self._first: Line | None = None
        self._line: Line | None = None
        self._tags = itertools.cycle(range(10, 1_000_000))
        self._thread = threading.Thread(target=self._run, name="client", daemon=True)

    def dial(self) -> None:
        """Dial the first line. LinkError if nobody answers."""
        self._first = self._reach(self._url(), self._wake)

    def start(self) -> None:
        """Keep a line in a thread, beginning with that of ``dial`` if there is one."""
        self._thread.start()

    def take(self) -> list[Item]:
        """Return what has come since the last call."""
        taken = []
        while self._items:
            taken.append(self._items.popleft())
        return taken

    def order(self, words: str) -> str:
        """Send an order; return the tag of its answer, "" when there is no line."""
        open_line = self._line
        if open_line is None:
            return ""
        tag = str(next(self._tags))
        open_line.send(sentences.order_sentence(words, tag))
        return tag

    def take_chair(self, role: str, wishes: Mapping[str, str]) -> None:
        """Subscribe what another role is shown, which the session has given to this line."""
        self._role, self._wishes = role, wishes
        if self._line:
            self._subscribe(self._line)

    def close(self, patience: float) -> None:
        """Leave the session, waiting at most ``patience`` [s]."""
        self._closing.set()
        self._wake.set()
        self._thread.join(patience)

    def _run(self) -> None:
        wait = FIRST_REDIAL_S
        while not self._closing.is_set():
            try:
                open_line = self._first or self._reach(self._url(), self._wake)
                self._first = None
            except NeverBegunError as error:
                self._items.append(RoleRefusal(str(error)))
                return
            except LinkError as error:
                self._items.append(LineLoss(str(error)))
            else:
                taken = self._attend(open_line)
                wait = FIRST_REDIAL_S if taken else wait
            self._closing.wait(wait)
            wait = min(2.0 * wait, MAX_WAIT_S)

    def _attend(self, open_line: Line) -> bool:
        """Listen on a line to its end; return whether the session took the role."""
        open_line.send(sentences.order_sentence(f"role {self._role}", ROLE_TAG))
        taken = False
        while not (open_line.ended or self._closing.is_set()):
            self._wake.wait()
            self._wake.clear()
            while lines := open_line.take(BATCH_LINES):
                for said in lines:
                    taken = self._hear(open_line, said) or taken
        self._line = None
        if not self._closing.is_set():
            self._items.append(LineLoss(open_line.trouble or "the session has closed the line"))
        else:
            open_line.send(sentences.order_sentence("detach"))
        open_line.close(FIRST_REDIAL_S)
        return taken

    def _hear(self, open_line: Line, said: str | OverlongLine) -> bool:
        """Take one line; return whether it says that the role is taken."""
        if isinstance(said, OverlongLine):
            return False
        sentence = sentences.parse_sentence(said)
        if sentence is None:
            if not said.startswith("$"):
                self._items.append(Greeting(said))
            return False
        if sentence.tag != ROLE_TAG:
            self._items.append(sentence)
            return False
        # hear whether the role is taken; say what is wanted if it is
        kind, text = sentence.fields
        if kind == "no":
            self._closing.set()
            self._items.append(RoleRefusal(text))
        if kind != "ok":
            return False
        self._subscribe(open_line)
        self._line = open_line
        self._items.append(RoleTaken())
        return True

    def _subscribe(self, open_line: Line) -> None:
        for channel, often in self._wishes.items():
            wish = f"subscribe {channel} {often}".rstrip()
            open_line.send(sentences.order_sentence(wish, WISH_TAG))
