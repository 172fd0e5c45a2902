"""The HTTP server of the pages (Starlette, run by uvicorn), as a process.

``launch`` starts it with a socket that listens already. It serves the pages, their files and the
debriefs, and passes each page's WebSocket to ``bridge``, which joins it to the session. A request
goes through ``WholeRequests`` (``admission``: it is there in time), then ``Gate`` (``gate``: it
comes from a page of this server), then Starlette's routes.
"""

import asyncio
import logging
import re
import socket
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

import click
import uvicorn
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect, HTTPConnection, Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from uvicorn.protocols.websockets.auto import AutoWebSocketsProtocol
from websockets.exceptions import InvalidState

from trainer import __version__
from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.orders.sentences import order_sentence
from trainer.web.address import Address
from trainer.web.admission import (
    Admission,
    ConnectionRoom,
    Visit,
    WholeRequests,
    allowed_descriptors,
)
from trainer.web.bridge import OLDER_PAGE_CODE, Allowance, Bridge, Reach
from trainer.web.front import Front
from trainer.web.gate import Gate, Refusals, page_policy, policy_of
from trainer.web.packing import Assets
from trainer.web.pages import MISSING_DEBRIEF, MISSING_PAGE, PAGES, Page, render

Answer = Callable[[Request], Awaitable[Response]]
# makes pages, for where they are served, what it refuses, and what stands before them
Pages = Callable[[str, Refusals, Front | None], WholeRequests]

# How the name of the cookie of a role's token begins.
TOKEN_COOKIE_PREFIX: Final = "word-"  # noqa: S105
# [characters]  An order with the longest role and tag must still fit a line.
MAX_TOKEN_LETTERS: Final = MAX_LINE_LETTERS - len(order_sentence("role instructor ", "999999"))
ROLE_TOKEN_FORM: Final = re.compile(
    rf"(?P<role>[a-z]+) (?P<word>[!#%-)+-~]{{0,{MAX_TOKEN_LETTERS}}})"
)
MAX_BODY_BYTES: Final = 200  # [bytes]
MAX_MISSING_FOLDERS: Final = 8  # of an address without a page, from which its links lead back
MAX_FRAME_BYTES: Final = 4096  # [bytes] a longer one is not even read
MAX_LINE_BYTES_PER_S: Final = 65536  # of a page's line; a lever sends a thousand
MAX_LINE_BYTES_AT_ONCE: Final = 4 * 1024 * 1024
PULSE_PERIOD_S: Final = 1.0
SHUTDOWN_PAUSE_S: Final = 0.05
MAX_SHUTDOWN_TRIES: Final = 20
# [s] a year: a file with a hash in its name never changes
KEPT_FOREVER: Final = "public, max-age=31536000, immutable"
TOKEN_AGE_S: Final = 7 * 24 * 3600  # [s]


@dataclass(frozen=True)
class Certificate:
    """The files of a certificate and its key."""

    cert: Path
    key: Path


class ComplaintHandler(logging.Handler):
    """A log handler for errors of the server's library, which nobody can flood."""

    def __init__(self, refusals: Refusals) -> None:
        super().__init__(logging.ERROR)
        self._refusals = refusals

    def emit(self, record: logging.LogRecord) -> None:
        """Log the first line of a message, and its exception."""
        what = record.exc_info[1] if record.exc_info else ""
        self._refusals.note(f"{record.getMessage().splitlines()[0]} {what!r}".rstrip(" '"))


def application(reach: Reach, host: str, refusals: Refusals, front: Front | None) -> WholeRequests:
    """Return the pages of a session; ``host`` is where they are served, ``front`` before them."""
    bridge = Bridge(reach, refusals)
    pages = session_pages(lambda _: bridge, Assets())
    return WholeRequests(Gate(pages, host, refusals, front))


def session_pages(bridge_of: Callable[[HTTPConnection], Bridge], assets: Assets) -> Starlette:
    """Return the pages of sessions; ``bridge_of`` finds that of a request or a page's line."""

    async def line(page: WebSocket) -> None:
        await carry_line(page, bridge_of(page), words_of(page.cookies))

    show_missing = answer_page(MISSING_PAGE, assets, 404)
    show_missing_debrief = answer_page(MISSING_DEBRIEF, assets, 404)

    async def show_missing_page(request: Request, _error: Exception) -> Response:
        if "/assets/" in request.url.path:  # no person types those
            return PlainTextResponse("not found\n", 404)
        return await show_missing(request)

    async def debrief(request: Request) -> Response:
        key, name = request.path_params["key"], request.path_params["name"]
        try:
            html = await asyncio.to_thread(bridge_of(request).shelf.find, key, name)
        except (KeyError, OSError, UnicodeDecodeError):
            return await show_missing_debrief(request)
        return HTMLResponse(html, headers={"Content-Security-Policy": policy_of(html)})

    return Starlette(
        routes=[
            Route("/debrief/{key}/{name}", debrief),
            *(Route(f"/{page.name}", answer_page(page, assets)) for page in PAGES),
            Route("/word", keep_word, methods=["POST"]),
            WebSocketRoute("/line", line),
            Route("/assets/{name}", answer_asset(assets)),
        ],
        middleware=[Middleware(GZipMiddleware, minimum_size=500)],
        exception_handlers={404: show_missing_page},
    )


async def carry_line(page: WebSocket, bridge: Bridge, words: Mapping[str, str]) -> None:
    """Carry the line of a page of this version, with the words of its browser by role."""
    await page.accept()
    if page.query_params.get("version") != __version__:
        await page.close(OLDER_PAGE_CODE, f"this page is not of the trainer {__version__}")
        return
    await bridge.carry(page, words)


def answer_page(page: Page, assets: Assets, status: int = 200) -> Answer:
    """Return a function that answers with a page. The page is made once.

    Its links are relative, so at an address within folders they lead up first.
    """
    html, script_map = assets.link(render(page))

    async def show(request: Request) -> Response:
        path, root = request.scope["path"], request.scope["root_path"]
        up = "../" * min(path.count("/") - root.count("/") - 1, MAX_MISSING_FOLDERS) or "./"
        policy = page_policy(script_map.replace('"./', f'"{up}'))
        headers = {"Content-Security-Policy": policy}
        return HTMLResponse(html.replace('"./', f'"{up}'), status, headers)

    return show


def answer_asset(assets: Assets) -> Answer:
    """Return a function that answers with a script or a style."""

    async def show(request: Request) -> Response:
        asset = assets.files.get(request.path_params["name"])
        if asset is None:
            raise HTTPException(404)
        headers = {"Cache-Control": KEPT_FOREVER, "Vary": "Accept-Encoding"}
        if "gzip" not in request.headers.get("Accept-Encoding", ""):
            return Response(asset.body, headers=headers, media_type=asset.media_type)
        headers["Content-Encoding"] = "gzip"
        return Response(asset.packed, headers=headers, media_type=asset.media_type)

    return show


async def keep_word(request: Request) -> Response:
    """Keep a role's token in the browser, where no script of a page can read it."""
    match = ROLE_TOKEN_FORM.fullmatch(await body_of(request))
    if not match or match["role"] not in {page.role for page in PAGES if page.role}:
        return PlainTextResponse("say ROLE WORD\n", 400)
    answer = PlainTextResponse("kept\n")
    answer.set_cookie(
        TOKEN_COOKIE_PREFIX + match["role"],
        match["word"],
        max_age=TOKEN_AGE_S if match["word"] else 0,
        path=f"{request.scope['root_path']}/line",  # nothing else needs it
        secure=request.url.scheme == "https",
        httponly=True,
        samesite="strict",
    )
    return answer


async def body_of(request: Request, longest: int = MAX_BODY_BYTES) -> str:
    """Return the body of a request, "" if it is longer than ``longest`` [bytes]."""
    body = b""
    try:
        async for part in request.stream():
            body += part
            if len(body) > longest:
                return ""
    except ClientDisconnect:
        return ""
    return body.decode("utf-8", "replace")


def words_of(cookies: dict[str, str]) -> dict[str, str]:
    """Return the tokens that a browser keeps, by role."""
    tokens = {name: word for name, word in cookies.items() if name.startswith(TOKEN_COOKIE_PREFIX)}
    return {name.removeprefix(TOKEN_COOKIE_PREFIX): word for name, word in tokens.items()}


class MeasuredLine(asyncio.Protocol):
    """The line of a page, with a limit of bytes a second.

    Empty frames and pings count as well, because the server works for them too.
    """

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to count."""
        self._far_end = cast("asyncio.Transport", transport)
        self._allowance = Allowance(MAX_LINE_BYTES_PER_S, MAX_LINE_BYTES_AT_ONCE)
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Take what comes, or cut the line off."""
        if self._allowance.covers(len(data)):
            super().data_received(data)
            return
        machine = self._far_end.get_extra_info("peername")[0]
        rate = f"{MAX_LINE_BYTES_PER_S} bytes a second"
        logging.getLogger("uvicorn.error").error("%s: more than %s: cut off", machine, rate)
        self._far_end.abort()


def configuration(app: WholeRequests, certificate: Certificate | None) -> uvicorn.Config:
    """Return the settings of the server's library."""
    return uvicorn.Config(
        app,
        log_config=None,
        access_log=False,
        lifespan="off",
        proxy_headers=False,  # it would believe the scheme too; ``Front`` reads the client alone
        ws=type("Line", (MeasuredLine, cast("type", AutoWebSocketsProtocol)), {}),
        ws_max_size=MAX_FRAME_BYTES,
        ws_ping_interval=10.0,  # a page that is asleep or gone does not answer, and is closed
        ws_ping_timeout=20.0,
        ws_per_message_deflate=False,  # lines are short; and what is never inflated is no bomb
        server_header=False,
        timeout_graceful_shutdown=1,
        ssl_certfile=certificate.cert if certificate else None,
        ssl_keyfile=certificate.key if certificate else None,
    )


class PageServer(uvicorn.Server):
    """The server, which takes connections by the rules of their admission."""

    def __init__(
        self,
        config: uvicorn.Config,
        listener: socket.socket,
        admission: Admission,
        pulse: Callable[[], None],
    ) -> None:
        super().__init__(config)
        self._listener = listener
        self._admission = admission
        self._pulse = pulse
        self._duties: list[asyncio.Task[None]] = []

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to take connections, and to send the pulse."""
        await super().startup(sockets=sockets or [])
        accept = self._admission.accept(self._listener, self._protocol, self.config.ssl)
        self._duties = [asyncio.create_task(accept), asyncio.create_task(self._beat())]
        for duty in self._duties:
            duty.add_done_callback(self._end)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Take no more connections, and end those that there are.

        uvicorn fails of a page that closes its line at this instant, and would leave the others.
        """
        for duty in self._duties:
            duty.cancel()
        for _ in range(MAX_SHUTDOWN_TRIES - 1):
            try:
                return await super().shutdown(sockets)
            except InvalidState:
                await asyncio.sleep(SHUTDOWN_PAUSE_S)
        return await super().shutdown(sockets)

    def _protocol(self, visit: Visit) -> asyncio.Protocol:
        """Return the HTTP protocol of one connection."""
        speaker: Callable[..., asyncio.Protocol] = self.config.http_protocol_class
        state = {"visit": visit}  # of each request by this connection
        return speaker(config=self.config, server_state=self.server_state, app_state=state)

    async def _beat(self) -> None:
        """Send the pulse for ever, as a sign that this loop still runs."""
        while True:
            self._pulse()
            await asyncio.sleep(PULSE_PERIOD_S)

    def _end(self, duty: asyncio.Task[None]) -> None:
        """End the server after a fault; a session that owns it starts it again."""
        if not duty.cancelled() and (error := duty.exception()):
            logging.getLogger("uvicorn.error").error("the server ends", exc_info=error)
            self.should_exit = True


def serve_at_socket(
    pages: Pages,
    listener: socket.socket,
    address: Address,
    certificate: Certificate | None,
    pulse: Callable[[], None],
) -> None:
    """Serve pages at a socket that listens, until a signal.

    ``pulse`` is called each second, as long as the server attends to its connections.
    """
    refusals = Refusals(lambda text: click.echo(f"pages: {text}", err=True))
    logger = logging.getLogger("uvicorn.error")
    logger.propagate = False
    logger.addHandler(ComplaintHandler(refusals))
    app = pages(address.host, refusals, address.front)
    admission = Admission(ConnectionRoom.of(allowed_descriptors()), refusals, address.front)
    try:
        PageServer(configuration(app, certificate), listener, admission, pulse).run()
    finally:
        refusals.close()
