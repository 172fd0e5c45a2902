"""The bridge from a page's WebSocket to the session's TCP.

``server`` calls ``Bridge.carry`` for each page that opens its WebSocket. The bridge dials the
session once for that page, and copies lines: a text frame of the page is a line to the session. The
lines of the session that are there at once are one text frame to the page, because with thirty
pages a frame for each line is most of the work after a tick, and an order waits behind it. The
session takes the page for one more station, so it checks roles, tokens and the rate of orders. The
bridge itself refuses only frames that no station could send: bytes, more than one line, too long,
too many a second.

It adds two things that the session cannot: the tokens that this browser has in its cookies, and the
address of a debrief's page, because the session knows the file's path alone.
"""

import asyncio
import contextlib
import re
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from dataclasses import dataclass, field
from glob import escape
from pathlib import Path
from secrets import token_urlsafe
from socket import socket
from typing import Final
from urllib.parse import quote

from starlette.requests import HTTPConnection
from starlette.websockets import WebSocket, WebSocketDisconnect

from trainer.io.connection import carried_for
from trainer.io.machine import THIS_MACHINE, is_here, machine_of
from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS, Order
from trainer.io.orders.sentences import MAX_ANSWER_LETTERS
from trainer.io.serial_line import LinkError
from trainer.web.gate import Refusals

MAX_CHUNK_BYTES: Final = 2 * MAX_ANSWER_LETTERS  # of what the session says at once
# Only lines with one of these are parsed, which spares the others.
DEBRIEF_FACT: Final = ",debrief,"
FULL_FACT: Final = ",no-room,"
# Why a page's line is closed; a page says what to do about each.
NO_SESSION_CODE: Final = 4001
OLDER_PAGE_CODE: Final = 4002
REFUSED_CODE: Final = 4003
NO_ROOM_CODE: Final = 4004

FRAMES_A_SECOND: Final = 100  # ten times what a lever sends
FRAMES_AT_ONCE: Final = 300
ASCII_LINE: Final = re.compile(r"[ -~]*")  # plain ASCII, and one line
MAX_DEBRIEFS: Final = 100  # debriefs at most; the oldest gives way
CLOSE_TIMEOUT_S: Final = 1.0  # [s] for a session to take what is on its way
MAX_PAGES_OF_MACHINE: Final = 8  # lines at once, of another machine
MAX_REMOTE_PAGES: Final = 30  # of all of them; a session has room for 40, the last for this machine

Reach = Callable[[], socket]  # raises LinkError


@dataclass
class DebriefShelf:
    """The debriefs that an instructor's page may show, by random keys.

    A key stands for a token, because whoever has the address reads the page.
    """

    files: dict[str, Path] = field(default_factory=dict)

    def keep(self, name: str) -> str:
        """Keep the file of a debrief; return its address, "" without a file.

        A ``?`` in its path matches any character, because sentences hold no others than ASCII.
        """
        root = Path(name).anchor
        pattern = escape(name.removeprefix(root)).replace("[?]", "?")
        matches = [*Path(root).glob(pattern)] if root and pattern else []
        if len(matches) != 1 or matches[0].resolve().suffix != ".html":
            return ""
        path = matches[0]
        key = next((key for key, kept in self.files.items() if kept == path), token_urlsafe(16))
        self.files[key] = path
        if len(self.files) > MAX_DEBRIEFS:
            del self.files[next(iter(self.files))]
        return f"./debrief/{key}/{quote(path.name)}"

    def find(self, key: str, name: str) -> str:
        """Return the page under a key; KeyError or OSError if there is none."""
        path = self.files[key]
        if path.name != name:
            raise KeyError(name)
        return path.read_text(encoding="utf-8")


class RefusedError(Exception):
    """A frame or a page that is not let through; the text says why."""


class Allowance:
    """The number of frames, or bytes, that a page may still send now."""

    def __init__(self, rate: float, most: float) -> None:
        """Allow ``rate`` a second, and ``most`` at once."""
        self._rate, self._most = rate, most
        self._left = most
        self._since = time.monotonic()

    def covers(self, amount: float) -> bool:
        """Take an amount off; return whether there was enough."""
        now = time.monotonic()
        self._left = min(self._left + (now - self._since) * self._rate, self._most) - amount
        self._since = now
        return self._left >= 0


@dataclass
class Bridge:
    """The bridge between the pages of all browsers and the session."""

    reach: Reach
    refusals: Refusals
    machines: Counter[str] = field(default_factory=Counter)  # open lines by other machine
    shelf: DebriefShelf = field(default_factory=DebriefShelf)

    async def carry(self, page: WebSocket, words: Mapping[str, str]) -> None:
        """Carry lines both ways until either end goes.

        ``words`` are the tokens that this browser keeps, by role.
        """
        try:
            with self.count_page(machine_at(page)):
                end = await asyncio.to_thread(self.reach)
                shelf = self.shelf if leads_here(end) else None
                local = not isinstance(end.getpeername(), tuple)  # a session of this user
                reader, writer = await asyncio.open_connection(sock=end, limit=MAX_CHUNK_BYTES)
                if page.client and local:  # the session counts stations by their machine
                    writer.write(f"{carried_for(page.client.host)}\n".encode("ascii"))
                await self._attend(page, reader, writer, words, shelf)
        except RefusedError as error:
            self.refusals.add(page.client, f"{error}: its line is closed")
            await close_page(page, NO_ROOM_CODE, str(error))
        except (LinkError, OSError) as error:
            await close_page(page, NO_SESSION_CODE, str(error))

    @contextlib.contextmanager
    def count_page(self, machine: str) -> Iterator[None]:
        """Count a page inside the block; RefusedError without room."""
        if machine == THIS_MACHINE:
            yield
            return
        if self.machines[machine] >= MAX_PAGES_OF_MACHINE:
            raise RefusedError(
                f"{MAX_PAGES_OF_MACHINE} pages of this machine are open: close one of them"
            )
        if self.machines.total() >= MAX_REMOTE_PAGES:
            raise RefusedError(f"no room: {MAX_REMOTE_PAGES} pages of other machines are open")
        self.machines[machine] += 1
        try:
            yield
        finally:
            self.machines[machine] -= 1
            self.machines += Counter()  # forgets those that have none

    async def _attend(
        self,
        page: WebSocket,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        words: Mapping[str, str],
        shelf: DebriefShelf | None,
    ) -> None:
        """Carry both ways until one of them ends; then end the other."""
        ways = [
            asyncio.create_task(self._down(reader, page, shelf)),
            asyncio.create_task(self._up(page, writer, words)),
        ]
        try:
            await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
            writer.close()
            with contextlib.suppress(OSError, TimeoutError):
                await asyncio.wait_for(writer.wait_closed(), CLOSE_TIMEOUT_S)

    async def _down(
        self, reader: asyncio.StreamReader, page: WebSocket, shelf: DebriefShelf | None
    ) -> None:
        """Carry the session's lines to the page.

        Lines that a slow page does not take fill the session's socket. Then the session drops and
        counts them, and waits for nobody.
        """
        code, why = NO_SESSION_CODE, "the session has closed the line"
        try:
            async for lines in whole_lines(reader):
                told = lines
                if shelf and DEBRIEF_FACT in lines:
                    told = await asyncio.to_thread(with_debriefs, lines, shelf)
                await page.send_text(told)
                for fact in facts_in(lines, "no-room") if FULL_FACT in lines else ():
                    why = f"no room: {fact[2]} stations are here; close a page"
                    code = NO_ROOM_CODE
        except (OSError, ValueError, WebSocketDisconnect, RuntimeError):
            pass
        await close_page(page, code, why)

    async def _up(
        self, page: WebSocket, writer: asyncio.StreamWriter, words: Mapping[str, str]
    ) -> None:
        """Carry the page's lines to the session."""
        allowance = Allowance(FRAMES_A_SECOND, FRAMES_AT_ONCE)
        try:
            while True:
                line = check_frame(await page.receive(), allowance)
                writer.write((with_word(line, words) + "\n").encode("ascii"))
                await writer.drain()
        except RefusedError as error:
            self.refusals.add(page.client, f"{error}: its line is closed")
            await close_page(page, REFUSED_CODE, str(error))
        except (OSError, WebSocketDisconnect):
            pass


async def whole_lines(reader: asyncio.StreamReader) -> AsyncIterator[str]:
    """Yield all whole lines that are there, until the end; ValueError if one is too long."""
    begun = b""
    while chunk := await reader.read(MAX_CHUNK_BYTES):
        lines, ended, begun = (begun + chunk).rpartition(b"\n")
        if ended:
            yield lines.replace(b"\r", b"").decode("ascii", "replace")
        if len(begun) > MAX_CHUNK_BYTES:
            raise ValueError(f"a line of more than {MAX_CHUNK_BYTES} bytes")


def check_frame(message: Mapping[str, object], allowance: Allowance) -> str:
    """Return the line in a frame; RefusedError if it could not be one."""
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect
    if not allowance.covers(1):
        raise RefusedError(f"more than {FRAMES_A_SECOND} frames a second")
    text = message.get("text")
    if not isinstance(text, str):
        raise RefusedError("a frame that is no text")
    if len(text) > MAX_LINE_LETTERS:
        raise RefusedError(f"a frame of {len(text)} characters; the longest is {MAX_LINE_LETTERS}")
    if not ASCII_LINE.fullmatch(text):
        raise RefusedError("a frame that is not one line of plain ASCII")
    return text


def machine_at(page: HTTPConnection) -> str:
    """Return the name under which a page's machine is counted; see ``machine_of``."""
    return machine_of(page.client.host, page.scope["server"][0]) if page.client else ""


def leads_here(end: socket) -> bool:
    """Return whether the session at the far end of a socket is on this machine."""
    peer = end.getpeername()
    return not isinstance(peer, tuple) or is_here(peer[0])


def facts_in(lines: str, what: str) -> Iterator[tuple[str, str, str]]:
    """Yield tick, seconds and subject of each line that is such a fact."""
    for fact in map(sentences.parse_sentence, lines.split("\n")):
        if fact is not None and fact.kind == "TRF" and fact.fields[2] == what:
            yield fact.fields[0], fact.fields[1], fact.fields[3]


def with_debriefs(lines: str, shelf: DebriefShelf) -> str:
    """Return lines, behind each that tells of a debrief the fact with its page."""
    told = []
    for line in lines.split("\n"):
        told.append(line)
        for tick, seconds, name in facts_in(line, "debrief"):
            if address := shelf.keep(name):
                told.append(sentences.fact(int(tick), float(seconds), "debrief-page", address))
    return "\n".join(told)


def with_word(line: str, words: Mapping[str, str]) -> str:
    """Return a line; an order to take a role gets the browser's token."""
    heard = sentences.parse_line(line) if "role" in line else None
    if heard is None or not heard.machine:
        return line
    order = heard.order
    if not isinstance(order, Order) or order.name != "role" or order.subject:
        return line
    word = words.get(order.word, "")
    return sentences.order_sentence(f"role {order.word} {word}", heard.tag) if word else line


async def close_page(page: WebSocket, code: int, why: str) -> None:
    """Close a page's line, if it is still open."""
    with contextlib.suppress(RuntimeError, WebSocketDisconnect, OSError):
        await page.close(code, why[:120])  # RFC 6455 allows 123 bytes
