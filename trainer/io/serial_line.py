"""A serial line at any pyserial URL. It opens again by itself after it was unplugged.

Stations, consoles and NMEA outlets open ports by it. Only an Inbox calls `read` and only an Outbox
calls `write`, because both may wait. The reading thread also opens the line again; while it is
down, output is dropped and counted.
"""

import contextlib
import difflib
import errno
import re
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from trainer.io.lines import KILL_LINE, LINE_FEED

if TYPE_CHECKING:
    import serial

READ_TIMEOUT_S = 0.1  # [s]  a read's longest wait; bounds how long close() takes
# [s]  a write's longest wait; 0 would spin for ever inside pyserial on a full line
WRITE_TIMEOUT_S = 1.0
FIRST_PAUSE_S, MAX_PAUSE_S = 0.25, 4.0  # [s]  between attempts to reopen
CHUNK_BYTES = 4096  # [bytes]
MAX_BAUD_RATE = 4_000_000  # [baud]

URL_SCHEMES = ("socket", "rfc2217", "loop", "hwgrep", "spy", "alt", "cp2110")
NETWORK_SCHEMES = ("socket", "rfc2217")
# pyserial has raised each of these on open.
OPEN_ERRORS = (OSError, ValueError, TypeError, LookupError, re.error)
SYSTEM_TEXT_PATTERN = re.compile(r"(?:Errno -?\d+\] |\(\d+, ')([^:']+)")


class LinkError(Exception):
    """A serial line that cannot be opened; the text says what to do about it."""


class SerialLine:
    """An open line; raises LinkError from the constructor only."""

    def __init__(
        self, url: str, baud: int = 9600, tell: Callable[[str], object] = lambda _text: None
    ) -> None:
        """Open the line. The reading thread calls ``tell`` when it is lost, and when it is back."""
        self.url = url
        self._tell = tell
        self.losses = 0  # times the line went down
        self.unsent = 0  # lines that did not go out, or not whole
        self._baud = baud
        self._port: serial.Serial | None = open_port(url, baud)
        self._closing = threading.Event()
        self._pause = FIRST_PAUSE_S
        self._writing = threading.Lock()  # held to write, and to take the port away

    @property
    def up(self) -> bool:
        """Return whether the line is open now."""
        return self._port is not None

    def read(self) -> bytes | None:
        """Return what has come, b"" when nothing has for a while, None once closed."""
        if self._closing.is_set():
            self.release()
            return None
        port = self._port
        if port is None:
            self._reopen()
            return b""
        try:
            data = bytearray(port.read(1))
            # To ask for more than is there would wait for it. A socket of pyserial
            # never says more than 1, hence the loop.
            while len(data) < CHUNK_BYTES and (waiting := port.in_waiting):
                data += port.read(waiting)
        except OSError as error:  # what pyserial raises is one
            self.losses += 1
            self.release()
            self._tell(f"{self.url}: the line is lost ({reason(error)}); it is tried again")
            return KILL_LINE  # half an order must not be completed by what comes after the gap
        return bytes(data)

    def write(self, data: bytes) -> None:
        """Write all of `data`. A line that is down or stalled counts it as unsent."""
        with self._writing:
            with contextlib.suppress(OSError):  # stalled, or gone: the reader finds out which
                if self._port is not None:
                    self._port.write(data)
                    return
            self.unsent += data.count(LINE_FEED)

    def close(self) -> None:
        """Close the line: at once for the writer, at its next read for the reader."""
        self._closing.set()

    def release(self) -> None:
        """Give the port back. A line that was not closed opens it again at its next read."""
        with self._writing:
            port, self._port = self._port, None
            if port is not None:
                port.close()

    def _reopen(self) -> None:
        if self._closing.wait(self._pause):
            return
        try:
            self._port = open_port(self.url, self._baud)
        except LinkError:
            self._pause = min(2.0 * self._pause, MAX_PAUSE_S)
        else:
            self._pause = FIRST_PAUSE_S
            self._tell(f"{self.url}: the line is back")


def open_port(url: str, baud: int) -> "serial.Serial":
    """Return the opened port; raises LinkError with the reason and the nearest name."""
    import serial  # noqa: PLC0415  only runs with a serial line pay for it

    scheme, separator, _ = url.partition("://")
    if separator and scheme.lower() not in URL_SCHEMES:
        raise LinkError(f"{url}: no such kind of line{nearest(scheme, list(URL_SCHEMES))}")
    if not 0 < baud <= MAX_BAUD_RATE:
        raise LinkError(f"{url}: {baud} baud: a line runs at 1 to {MAX_BAUD_RATE} baud")
    if scheme.lower() in NETWORK_SCHEMES and not is_address(url):
        raise LinkError(f"{url}: say {scheme}://HOST:PORT, the port 1 to 65535")
    # a line by RFC 2217 has no limit on how long a write takes, and refuses to be given one
    patience = None if scheme.lower() == "rfc2217" else WRITE_TIMEOUT_S
    try:
        return serial.serial_for_url(url, baud, timeout=READ_TIMEOUT_S, write_timeout=patience)
    except OPEN_ERRORS as error:
        advice = "" if separator or not device_is_absent(error) else nearest(url, devices())
        if "option 'control'" in str(error):
            advice = "; a line without control lines: add ?ign_set_control to its address"
        raise LinkError(f"{url}: {reason(error)}{advice}") from error


def is_address(url: str) -> bool:
    """Return whether the URL names a host and a port."""
    try:
        parts = urlsplit(url)
        return bool(parts.hostname and parts.port)
    except ValueError:
        return False


def device_is_absent(error: Exception) -> bool:
    """Return whether the device is not there, as POSIX or as Windows reports it."""
    return getattr(error, "errno", None) == errno.ENOENT or "FileNotFound" in str(error)


def reason(error: Exception) -> str:
    """Return what the system said, which pyserial wraps in words of its own."""
    messages = SYSTEM_TEXT_PATTERN.findall(str(error))
    return messages[-1] if messages else str(error) or type(error).__name__


def devices() -> list[str]:
    """Return the serial devices of this machine."""
    from serial.tools.list_ports import comports  # noqa: PLC0415  see open_port

    return [port.device for port in comports()]


def nearest(given: str, names: list[str]) -> str:
    """Return advice: the nearest name of a device, or the names of all."""
    near = difflib.get_close_matches(given, names, n=1)
    if near:
        return f"; did you mean {near[0]}?"
    return f"; there are {', '.join(names)}" if names else "; this machine has no serial devices"
