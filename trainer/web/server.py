"""The server of the pages: one process, which carries every page's line to the session."""

import asyncio
import logging
import re
import socket
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import click
import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.gzip import GZipMiddleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket

from trainer import __version__
from trainer.io.orders.grammar import LONGEST
from trainer.io.orders.sentences import order_sentence
from trainer.web.address import Address
from trainer.web.bridge import OLDER_PAGE, Bridge, Reach
from trainer.web.gate import Door, Gate, Refusals, policy_of
from trainer.web.pages import ASSETS, PAGES, Page, render

KEPT_WORD: Final = "word-"  # how the cookie of a role's token begins
LONGEST_WORD: Final = LONGEST - len(order_sentence("role instructor ", "999999"))  # [characters]
SAID: Final = re.compile(rf"(?P<role>[a-z]+) (?P<word>[!#%-)+-~]{{0,{LONGEST_WORD}}})")
LONGEST_BODY: Final = 200  # [bytes]
LONGEST_FRAME: Final = 4096  # [bytes] a longer one is not even read
CONNECTIONS: Final = 500  # at once; what comes beyond is turned away
A_WEEK: Final = 7 * 24 * 3600  # [s]


@dataclass(frozen=True)
class Certificate:
    """The files of a certificate and its key."""

    cert: Path
    key: Path


class Complaints(logging.Handler):
    """Tells what the server's library complains of, as long as it is little."""

    def __init__(self, refusals: Refusals) -> None:
        super().__init__(logging.ERROR)
        self._refusals = refusals

    def emit(self, record: logging.LogRecord) -> None:
        """Tell the first line, and which exception it was."""
        what = record.exc_info[1] if record.exc_info else ""
        self._refusals.note(f"{record.getMessage().splitlines()[0]} {what!r}".rstrip(" '"))


def application(reach: Reach, host: str, refusals: Refusals) -> Gate:
    """Return the pages of a session; ``host`` is where they are served."""
    bridge = Bridge(reach, refusals)

    async def line(page: WebSocket) -> None:
        await page.accept()
        if page.query_params.get("version") != __version__:
            await page.close(OLDER_PAGE, f"this page is not of the trainer {__version__}")
            return
        await bridge.carry(page, words_of(page.cookies))

    async def debrief(request: Request) -> Response:
        key, name = request.path_params["key"], request.path_params["name"]
        try:
            html = await asyncio.to_thread(bridge.shelf.find, key, name)
        except (KeyError, OSError, UnicodeDecodeError):
            return PlainTextResponse(
                "no such debrief: the instructor's page has its address\n", 404
            )
        return HTMLResponse(html, headers={"Content-Security-Policy": policy_of(html)})

    pages = Starlette(
        routes=[
            Route("/debrief/{key}/{name}", debrief),
            *(Route(f"/{page.name}", shown(page)) for page in PAGES),
            Route("/word", keep_word, methods=["POST"]),
            WebSocketRoute("/line", line),
            Mount("/assets", StaticFiles(directory=ASSETS)),
        ],
        middleware=[Middleware(GZipMiddleware, minimum_size=500)],
    )
    return Gate(pages, Door.at(host), refusals)


def shown(page: Page) -> Callable[[Request], Awaitable[Response]]:
    """Return what answers with a page, which is made once."""
    made = render(page)

    async def show(_request: Request) -> Response:
        return HTMLResponse(made)

    return show


async def keep_word(request: Request) -> Response:
    """Keep a role's token in the browser, where no script of a page can read it."""
    found = SAID.fullmatch(await body_of(request))
    if not found or found["role"] not in {page.role for page in PAGES if page.role}:
        return PlainTextResponse("say ROLE WORD\n", 400)
    answer = PlainTextResponse("kept\n")
    answer.set_cookie(
        KEPT_WORD + found["role"],
        found["word"],
        max_age=A_WEEK if found["word"] else 0,
        path="/line",  # nothing else needs it
        secure=request.url.scheme == "https",
        httponly=True,
        samesite="strict",
    )
    return answer


async def body_of(request: Request) -> str:
    """Return what a request brings, "" if it is too long to be a word."""
    body = b""
    try:
        async for part in request.stream():
            body += part
            if len(body) > LONGEST_BODY:
                return ""
    except ClientDisconnect:
        return ""
    return body.decode("ascii", "replace")


def words_of(cookies: dict[str, str]) -> dict[str, str]:
    """Return the tokens that a browser keeps, by role."""
    kept = {name: word for name, word in cookies.items() if name.startswith(KEPT_WORD)}
    return {name.removeprefix(KEPT_WORD): word for name, word in kept.items()}


def configuration(app: Gate, certificate: Certificate | None) -> uvicorn.Config:
    """Return how the pages are served."""
    return uvicorn.Config(
        app,
        log_config=None,
        access_log=False,
        lifespan="off",
        limit_concurrency=CONNECTIONS,
        ws_max_size=LONGEST_FRAME,
        ws_ping_interval=10.0,  # a page that does not answer, asleep or gone, is let go
        ws_ping_timeout=20.0,
        ws_per_message_deflate=False,  # lines are short, and thirty pages are many
        server_header=False,
        timeout_graceful_shutdown=1,
        ssl_certfile=certificate.cert if certificate else None,
        ssl_keyfile=certificate.key if certificate else None,
    )


def serve(
    reach: Reach, listener: socket.socket, address: Address, certificate: Certificate | None
) -> None:
    """Serve the pages at a socket that listens, until a signal."""
    refusals = Refusals(lambda text: click.echo(f"pages: {text}", err=True))
    logger = logging.getLogger("uvicorn.error")
    logger.propagate = False
    logger.addHandler(Complaints(refusals))
    app = application(reach, address.host, refusals)
    try:
        uvicorn.Server(configuration(app, certificate)).run(sockets=[listener])
    finally:
        refusals.close()
