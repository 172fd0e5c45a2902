"""The address of the pages: as it is typed, told, drawn for a camera, opened."""

import contextlib
import io
import ipaddress
import os
import socket
import webbrowser
from dataclasses import dataclass
from typing import Final

import segno

from trainer.web.gate import LOOPBACK_HOSTS, WILDCARD_HOSTS

UNSENT_ADDRESS: Final = (
    "192.0.2.1",
    9,
)  # an address for documents (RFC 5737): nothing is sent there


@dataclass(frozen=True)
class Address:
    """The place where the pages are served."""

    host: str
    port: int
    secure: bool = False

    @property
    def here(self) -> bool:
        """Return whether only this machine's browsers reach it."""
        if self.host in LOOPBACK_HOSTS:
            return True
        with contextlib.suppress(ValueError):
            return ipaddress.ip_address(self.host).is_loopback
        return False

    @property
    def url(self) -> str:
        """Return the address for a browser; it holds no token."""
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
    """Return an address as the terminal shows it; beyond this machine, for a camera too."""
    text = f"pages at {address.url}"
    if address.here:
        return text
    drawn = io.StringIO()
    segno.make(address.url, error="l").terminal(drawn, compact=True, border=2)
    return f"{text}\n{drawn.getvalue().rstrip()}"


def open_page(address: Address) -> str:
    """Open the pages in this machine's browser; return what to do where there is none."""
    opened = False
    with contextlib.suppress(webbrowser.Error, OSError):
        browser = webbrowser.get()
        opened = not in_terminal(browser) and browser.open(address.url)
    return "" if opened else f"no browser was found: open {address.url} in one"


def in_terminal(browser: webbrowser.BaseBrowser) -> bool:
    """Return whether a browser would take the terminal, though nobody has chosen it."""
    if os.environ.get("BROWSER"):
        return False
    waits = isinstance(browser, webbrowser.GenericBrowser)
    return waits and not isinstance(browser, webbrowser.BackgroundBrowser)
