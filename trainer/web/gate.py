"""The check that each HTTP request comes from a page of this server.

``server`` puts ``Gate`` around its application. A page of another server can make a browser send
requests here (cross-site requests). The gate refuses those whose Origin header is not this server.
An attacker's host name can also be made to point to this machine (DNS rebinding). The gate refuses
those requests too, because their Host header is none of this server's names. The answers get
headers that forbid the browser to load anything from elsewhere (SECURITY_HEADERS).
"""

import asyncio
import base64
import hashlib
import re
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from html.parser import HTMLParser
from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trainer.io.lines import plain
from trainer.io.machine import address_of
from trainer.io.noise_log import ENTRY_PERIOD_S, NoiseLog
from trainer.io.orders.grammar import Refused
from trainer.web.front import Front

Tell = Callable[[str], None]

LOOPBACK_HOSTS: Final = ("127.0.0.1", "localhost", "::1")
WILDCARD_HOSTS: Final = ("0.0.0.0", "::", "")  # noqa: S104  compared, not listened at
PAGE_POLICY: Final = (
    "default-src 'self'; img-src 'self' data:; object-src 'none'; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
SECURITY_HEADERS: Final[Mapping[str, str]] = {
    "Content-Security-Policy": PAGE_POLICY,
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=()",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-cache",
}
HOST_AND_PORT: Final = re.compile(
    r"(?:\[(?P<six>[0-9A-Fa-f:.]+)\]|(?P<name>[^][:@/% ]*))(?::[0-9]{1,5})?"
)
SAFE_METHODS: Final = frozenset({"GET", "HEAD"})  # methods that change nothing


@dataclass(frozen=True)
class ServerNames:
    """The names that this server answers to."""

    names: frozenset[str]
    any_address: bool

    @classmethod
    def at(cls, host: str, front: Front | None = None) -> "ServerNames":
        """Return the names of a server at ``host``, and of what stands before it."""
        own_names = {socket.gethostname().casefold()}
        beyond = (
            {f"{name}.local" for name in own_names} | own_names
            if host not in LOOPBACK_HOSTS
            else set()
        )
        beyond |= {front.host} if front else set()
        return cls(frozenset({*LOOPBACK_HOSTS, host.casefold(), *beyond}), host in WILDCARD_HOSTS)

    def admits(self, given: str) -> bool:
        """Return whether a Host header names this server."""
        name = hostname(given)
        if name in self.names:
            return True
        return self.any_address and address_of(name) is not None  # which no DNS server can redirect


def hostname(given: str) -> str:
    """Return the name or address in ``HOST[:PORT]``, "" if it is not of that form."""
    match = HOST_AND_PORT.fullmatch(given)
    return (match["six"] or match["name"]).casefold() if match else ""


class Refusals:
    """The count of refused requests, and a log of them that nobody can flood."""

    def __init__(self, tell: Tell) -> None:
        self.count = 0
        self._log = NoiseLog(lambda _, text: tell(text), time.monotonic)
        self._due = False

    def add(self, client: tuple[str, int] | None, why: str) -> None:
        """Count a refusal, and log it."""
        self.count += 1
        self.note(f"{client[0] if client else 'somebody'}: {why}")

    def note(self, text: str) -> None:
        """Log a line, unless too many have come; see ``NoiseLog``."""
        self._log.log("refused", plain(text))
        if not self._due:
            self._due = True
            asyncio.get_running_loop().call_later(ENTRY_PERIOD_S, self._settle)

    def close(self) -> None:
        """Log how many lines were held back."""
        self._log.close()

    def _settle(self) -> None:
        self._due = False
        self._log.settle()


class Gate:
    """The gate: it refuses foreign requests, and adds headers to all answers."""

    def __init__(self, app: ASGIApp, host: str, refusals: Refusals, front: Front | None) -> None:
        self._app = app
        self._names = ServerNames.at(host, front)
        self._refusals = refusals
        self._front = front

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        host = Headers(scope=scope).get("host", "")
        if self._front:
            scope = self._front.restore_request(scope)
        refused = self._refusal(scope, host)
        if not refused:
            await self._app(scope, receive, guard_sender(send))
            return
        self._refusals.add(scope.get("client"), f"refused: {refused.reason}")
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": refused.reason})
        else:
            await PlainTextResponse(f"{refused.reason}\n", 403)(scope, receive, guard_sender(send))

    def _refusal(self, scope: Scope, host: str) -> Refused | None:
        """Return why a request is refused, None if it is not; ``host`` as it came here."""
        headers = Headers(scope=scope)
        origin = headers.get("origin", "")
        if scope["client"] is None:
            return Refused("the proxy names no client: let it set X-Forwarded-For")
        if not self._names.admits(host):
            name = host[:80] or "a server without a name"
            return Refused(f"this is not {name}: use the address that the server has told")
        if not origin and scope["type"] == "http" and scope["method"] in SAFE_METHODS:
            return None
        secure = scope["scheme"] in ("https", "wss")
        own = f"{'https' if secure else 'http'}://{headers.get('host', '')}"
        if origin != own:
            return Refused(f"a page of {origin[:80] or 'nobody'} has no business at {own[:80]}")
        return None


class StyleHashes(HTMLParser):
    """The hashes of a page's styles: its style elements and its style attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.hashes: set[str] = set()
        self._within = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take the style of an element, which may begin a style sheet."""
        self._within = tag == "style"
        for name, value in attrs:
            if name == "style" and value:
                self.hashes.add(hash_of(value))

    def handle_data(self, data: str) -> None:
        """Take a style sheet."""
        if self._within:
            self.hashes.add(hash_of(data))

    def handle_endtag(self, _tag: str) -> None:
        """End a style sheet."""
        self._within = False


def hash_of(text: str) -> str:
    """Return the hash of a text, in the form of a Content-Security-Policy."""
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
    return f"'sha256-{digest}'"


def page_policy(script_map: str) -> str:
    """Return the policy of a page, which allows its import map inline."""
    return f"{PAGE_POLICY}; script-src 'self' {hash_of(script_map)}"


def policy_of(html: str) -> str:
    """Return the policy of a debrief, which allows its own styles and no script.

    A script in the file, which anybody may have changed, must not act as a page of this server.
    """
    styles = StyleHashes()
    styles.feed(html)
    allowed = " ".join(["'unsafe-hashes'", *sorted(styles.hashes)])
    return (
        f"default-src 'none'; style-src {allowed}; img-src data:; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'; sandbox allow-popups"
    )


def guard_sender(send: Send) -> Send:
    """Return a sender that adds the headers to each answer."""

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return send_with_headers
