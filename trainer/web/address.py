"""The address of the pages: as text, as a QR code, in a browser.

``launch`` prints it when the server starts, so that crews reach the pages by telephone or tablet.
"""

import contextlib
import io
import os
import socket
import webbrowser
from dataclasses import dataclass
from typing import Final

from trainer.io.machine import is_here
from trainer.web.front import Front
from trainer.web.gate import WILDCARD_HOSTS

# An address for documents (RFC 5737). A UDP socket connected to it sends nothing; the system only
# chooses the own address from which it would.
UNSENT_ADDRESS: Final = ("192.0.2.1", 9)


@dataclass(frozen=True)
class Address:
    """Where the pages are served."""

    host: str
    port: int
    secure: bool = False
    front: Front | None = None

    @property
    def here(self) -> bool:
        """Return whether only this machine's browsers reach it."""
        return self.front is None and is_here(self.host)

    @property
    def url(self) -> str:
        """Return the address for a browser; it holds no token."""
        if self.front:
            return self.front.url
        host = reachable_address() if self.host in WILDCARD_HOSTS else self.host
        bracketed = f"[{host}]" if ":" in host else host
        return f"{'https' if self.secure else 'http'}://{bracketed}:{self.port}/"


def reachable_address() -> str:
    """Return the address by which other machines most likely reach this one."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end, contextlib.suppress(OSError):
        end.connect(UNSENT_ADDRESS)
        return str(end.getsockname()[0])
    return socket.gethostname()


def announce_address(address: Address) -> str:
    """Return the text for the terminal, with a QR code if other machines may come."""
    text = f"pages at {address.url}"
    if address.here:
        return text
    import segno  # noqa: PLC0415  a tenth of the start, and most servers draw nothing

    drawn = io.StringIO()
    segno.make_qr(address.url, error="l").terminal(drawn, compact=True, border=2)
    return f"{text}\n{drawn.getvalue().rstrip()}"


def open_page(address: Address) -> str:
    """Open the pages in this machine's browser; return what to do where there is none."""
    opened = False
    with contextlib.suppress(webbrowser.Error, OSError):
        browser = webbrowser.get()
        opened = not in_terminal(browser) and browser.open(address.url)
    return "" if opened else f"no browser was found: open {address.url} in one"


def in_terminal(browser: webbrowser.BaseBrowser) -> bool:
    """Return whether a browser would run in the terminal, where the console is.

    One that the user has named in BROWSER is taken as wanted.
    """
    if os.environ.get("BROWSER"):
        return False
    waits = isinstance(browser, webbrowser.GenericBrowser)
    return waits and not isinstance(browser, webbrowser.BackgroundBrowser)
