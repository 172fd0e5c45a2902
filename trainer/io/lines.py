"""Bytes from a keyboard, a serial panel, a pipe or a telnet client become lines.

``line`` and ``connection`` read by it. A line ends at CR, LF or CRLF. Backspace and DEL take back a
character, Ctrl-U the line so far. Telnet's own commands are dropped. Memory has a limit: a line
that is too long is dropped once, up to the next line end.
"""

import os
import re
import sys
import textwrap
from collections.abc import Callable
from dataclasses import dataclass

from trainer.io.orders.grammar import MAX_LINE_LETTERS

BACKSPACE, LINE_FEED, CARRIAGE_RETURN, KILL_LINE, DELETE = b"\b", b"\n", b"\r", b"\x15", b"\x7f"
RUN_PATTERN = re.compile(rb"[^\b\n\r\x15\x7f]+|.", re.DOTALL)

# Telnet, RFC 854: commands begin with 255; 251-254 carry an option; 250 opens a list that 240 ends.
TELNET_COMMAND, LIST_BEGIN, LIST_END = 255, 250, 240
OPTION_COMMANDS = frozenset({251, 252, 253, 254})
LINE_ENDS = b"\r\n"

Step = Callable[["TelnetFilter", int], bool]  # takes a byte, returns whether it is text


@dataclass(frozen=True)
class OverlongLine:
    """A line that exceeded the limit [characters] and was dropped."""

    limit: int


def plain(text: str) -> str:
    r"""Return text with every character that a terminal would obey made visible.

    An escape becomes \x1b, so that a text from another machine moves no cursor and hides no words.
    """
    if text.isprintable():
        return text
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode("ascii")
        for character in text
    )


def fit_terminal(text: str) -> str:
    """Return a line broken between words where standard errors are a terminal.

    A program that reads them from a pipe or a file gets its one line.
    """
    try:
        columns = os.get_terminal_size(sys.stderr.fileno()).columns
    except (OSError, ValueError):
        return text
    wraps = textwrap.TextWrapper(
        max(columns, 1), subsequent_indent="  ", break_long_words=False, break_on_hyphens=False
    )
    return wraps.fill(text)


def line_bytes(line: str) -> bytes:
    """Return a line as plain ASCII bytes, without its end."""
    return plain(line).encode("ascii", errors="replace")


class LineDecoder:
    """Cut a stream of bytes into lines; never raises, never holds more than one line."""

    def __init__(self, limit: int = MAX_LINE_LETTERS) -> None:
        self.limit = limit
        self._pending = bytearray()
        self._giving_up = False  # the rest of an overlong line is being skipped
        self._after_return = False  # a line feed or NUL now belongs to the line end before it
        self._telnet = TelnetFilter()

    def feed(self, data: bytes) -> list[str | OverlongLine]:
        """Return the lines that `data` completes, without their ends."""
        done: list[str | OverlongLine] = []
        for match in RUN_PATTERN.finditer(self._telnet.feed(data)):
            run = match[0]
            if self._after_return:
                run = run.removeprefix(b"\0")
            if run in (CARRIAGE_RETURN, LINE_FEED):
                if not (run == LINE_FEED and self._after_return):
                    done += self._end_line()
            elif run in (BACKSPACE, DELETE):
                self._take_back()
            elif run == KILL_LINE:
                self._pending.clear()
            else:
                done += self._extend(run)
            self._after_return = run == CARRIAGE_RETURN
        return done

    @property
    def held(self) -> int:
        """Return the size [bytes] of the unfinished line."""
        return len(self._pending)

    def _end_line(self) -> list[str | OverlongLine]:
        line = self._pending.decode("utf-8", errors="replace")
        given_up = self._giving_up
        self._pending.clear()
        self._giving_up = False
        return [] if given_up else [plain(line)]

    def _take_back(self) -> None:
        while self._pending and self._pending[-1] & 0xC0 == 0x80:  # inside a UTF-8 character
            self._pending.pop()
        del self._pending[-1:]

    def _extend(self, run: bytes) -> list[str | OverlongLine]:
        if self._giving_up:
            return []
        if len(self._pending) + len(run) <= self.limit:
            self._pending += run
            return []
        self._pending.clear()
        self._giving_up = True
        return [OverlongLine(self.limit)]


class TelnetFilter:
    """Drop telnet commands from a stream.

    A line end always ends a command, so that noise on a line cannot swallow all that follows.
    """

    def __init__(self) -> None:
        # A function of the class. A bound method would refer to this object, and the cycle would
        # keep it in memory until the garbage collector runs.
        self._state: Step = TelnetFilter._text

    def feed(self, data: bytes) -> bytes:
        """Return `data` without telnet's commands."""
        if TELNET_COMMAND not in data and self._state is TelnetFilter._text:
            return data
        passed = bytearray()
        for byte in data:
            if byte in LINE_ENDS:
                self._state = TelnetFilter._text
                passed.append(byte)
            elif self._state(self, byte):
                passed.append(byte)
        return bytes(passed)

    def _text(self, byte: int) -> bool:
        if byte == TELNET_COMMAND:
            self._state = TelnetFilter._command
        return byte != TELNET_COMMAND

    def _command(self, byte: int) -> bool:
        following: dict[int, Step] = {LIST_BEGIN: TelnetFilter._list}
        following |= dict.fromkeys(OPTION_COMMANDS, TelnetFilter._option)
        self._state = following.get(byte, TelnetFilter._text)
        return byte == TELNET_COMMAND  # twice 255 stands for itself

    def _option(self, _byte: int) -> bool:
        self._state = TelnetFilter._text
        return False

    def _list(self, byte: int) -> bool:
        if byte == LIST_END:
            self._state = TelnetFilter._text
        return False
