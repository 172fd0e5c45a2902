"""The boat of a class that is shown to all, until it is taken back.

A trainee sees his own boat alone. Here the instructor opens the wall of one more to all, and only
to look: a line from such a page orders nothing, and ends when the boat is taken back. The session
asks for the observer's word, as of any wall. ``/wall`` is the address that a projector keeps open:
it leads to the wall of the boat that is shown now.
"""

import asyncio
from collections.abc import Mapping
from typing import Final

from starlette.requests import HTTPConnection, Request
from starlette.responses import RedirectResponse, Response
from starlette.types import Message
from starlette.websockets import WebSocket

from trainer.classroom.fleet import AnyBoat
from trainer.io.orders import sentences
from trainer.io.orders.grammar import Order
from trainer.io.orders.words import ORDER_WORDS
from trainer.web.bridge import OLDER_PAGE_CODE, Bridge, RefusedError, close_page
from trainer.web.gate import Refusals
from trainer.web.server import Answer, carry_line, words_of

NO_BOAT: Final = 0  # the number where none is shown
LOOKING_ROLE: Final = "observer"  # the role of a wall
TAKEN_BACK_TEXT: Final = "this boat is shown no more"


class ShownBoat:
    """Which boat is shown to all now, and the lines of who looks."""

    def __init__(self, boats: Mapping[int, AnyBoat], refusals: Refusals) -> None:
        self.boats = boats
        self.number = NO_BOAT
        # apart from the boat's own pages, so that who looks takes no room of its crew
        self._bridges = {number: Bridge(boat.reach, refusals) for number, boat in boats.items()}
        self._changed = asyncio.Event()

    def show(self, number: int) -> None:
        """Show a boat in place of the one that is shown; NO_BOAT takes it back."""
        if number == self.number:
            return
        self.number = number
        self._changed.set()
        self._changed = asyncio.Event()

    def lead_to_wall(self, nothing: Answer, wall: Answer) -> tuple[Answer, Answer]:
        """Return the answers at the projector's address, and at the wall of a boat."""

        async def lead(request: Request) -> Response:
            if self.number == NO_BOAT:
                return await nothing(request)
            return redirect(request, f"/shown/{self.number}/wall")

        async def show_wall(request: Request) -> Response:
            if self._shows(request):
                return await wall(request)
            return redirect(request, "/wall")

        return lead, show_wall

    async def carry(self, page: WebSocket) -> None:
        """Carry the line of a page that looks, until its boat is shown no more."""
        if not self._shows(page):
            await page.accept()
            await close_page(page, OLDER_PAGE_CODE, TAKEN_BACK_TEXT)
            return
        bridge = self._bridges[self.number]
        looking = LookingPage(page.scope, page.receive, page.send)
        carried = asyncio.create_task(carry_line(looking, bridge, looking_words(page.cookies)))
        changed = asyncio.create_task(self._changed.wait())
        await asyncio.wait((carried, changed), return_when=asyncio.FIRST_COMPLETED)
        taken_back = not carried.done()
        for task in (carried, changed):
            task.cancel()
        await asyncio.gather(carried, changed, return_exceptions=True)
        if taken_back:
            await close_page(looking, OLDER_PAGE_CODE, TAKEN_BACK_TEXT)

    def _shows(self, asked: HTTPConnection) -> bool:
        """Return whether the boat of a request's path is the one that is shown."""
        boat: int = asked.path_params["boat"]
        return boat == self.number


class LookingPage(WebSocket):
    """The line of a page that looks: it brings nothing else than a wall says."""

    async def receive(self) -> Message:
        """Return what comes; RefusedError for an order that does more than look."""
        message = await super().receive()
        text = message.get("text")
        if isinstance(text, str) and not is_look(text):
            raise RefusedError("an order where a boat is only shown")
        return message


def is_look(line: str) -> bool:
    """Return whether a line is one that a wall sends."""
    heard = sentences.parse_line(line)
    if heard is None:
        return True
    order = heard.order
    if not isinstance(order, Order):
        return False
    return ORDER_WORDS[order.name].looks or (order.name, order.word) == ("role", LOOKING_ROLE)


def looking_words(cookies: dict[str, str]) -> dict[str, str]:
    """Return the words of a browser that looks: a trainee's own will do."""
    words = {role: word for role, word in words_of(cookies).items() if role != "instructor"}
    return {LOOKING_ROLE: words.get(LOOKING_ROLE) or next(iter(words.values()), "")}


def redirect(request: Request, path: str) -> Response:
    """Return the way to another page of the class."""
    return RedirectResponse(f"{request.scope['root_path']}{path}", 303)
