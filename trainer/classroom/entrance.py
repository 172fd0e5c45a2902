"""The entrance of a class: one address, behind which each boat has its own pages.

Whoever comes says his name and takes a seat (``seats``); a boat's pages are those of any session,
under ``/boat/3/``, and its lines go to that boat alone. The instructor's page has a line to every
boat. All requests go through the same gates as a session's (``web.server``).
"""

import re
from collections.abc import Mapping
from typing import Final

from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket

from trainer.classroom.door import ask_role
from trainer.classroom.fleet import AnyBoat
from trainer.classroom.seats import EVERY_BOAT, SEAT_COOKIE, Seats
from trainer.classroom.shown import LOOKING_ROLE, NO_BOAT, ShownBoat
from trainer.web.admission import WholeRequests
from trainer.web.bridge import REFUSED_CODE, Bridge, RefusedError, machine_at
from trainer.web.front import Front
from trainer.web.gate import Gate, Refusals
from trainer.web.packing import Assets
from trainer.web.pages import (
    CLASS_PAGE,
    ENTRANCE_PAGE,
    MISSING_PAGE,
    NOTHING_SHOWN_PAGE,
    PAGES,
)
from trainer.web.server import (
    MAX_TOKEN_LETTERS,
    TOKEN_AGE_S,
    TOKEN_COOKIE_PREFIX,
    Answer,
    answer_asset,
    answer_page,
    body_of,
    session_pages,
)

MAX_SEAT_BYTES: Final = 1000
# boat (0: the next free one), role, word, name: a line each
SEAT_FORM: Final = re.compile(
    rf"(?P<boat>\d{{1,2}})\n(?P<role>[a-z]+)\n(?P<word>[!#%-)+-~]{{0,{MAX_TOKEN_LETTERS}}})\n"
    r"(?P<name>[^\n]{0,80})"
)
WORD_FORM: Final = re.compile(
    rf"(?P<role>instructor|{LOOKING_ROLE}) (?P<word>[!#%-)+-~]{{0,{MAX_TOKEN_LETTERS}}})"
)
SHOWN_FORM: Final = re.compile(r"\d{1,2}")  # a boat, or NO_BOAT
CREW_PAGES: Final = {page.role for page in PAGES if page.role} - {"instructor"}
NO_SEAT_TEXT: Final = "you have no seat on boat {}: choose it on the first page"


class Entrance:
    """What the pages of a class ask for: seats, words, how boats are."""

    def __init__(self, boats: Mapping[int, AnyBoat], refusals: Refusals, *, guarded: bool) -> None:
        """``guarded`` says that the boats ask for words."""
        self.boats = boats
        self.seats = Seats()
        self.shown = ShownBoat(boats, refusals)
        self.bridges = {number: Bridge(boat.reach, refusals) for number, boat in boats.items()}
        self._guarded = guarded

    def bridge_of(self, asked: HTTPConnection) -> Bridge:
        """Return the bridge to the boat of a request's path."""
        return self.bridges[asked.path_params["boat"]]

    async def tell_boats(self, request: Request) -> Response:
        """Answer how the boats are; only an instructor is told what has happened to them."""
        seat, instructs = self.seats.seat_of(request.cookies), self._instructs(request)
        rows = [self._boat_row(boat, instructs=instructs) for boat in self.boats.values()]
        told = {"seat": seat.boat if seat else None, "guarded": self._guarded}
        return JSONResponse({"boats": rows, **told, "shown": self.shown.number})

    async def show_boat(self, request: Request) -> Response:
        """Show a boat to all, or none, as an instructor says."""
        if not self._instructs(request):
            return PlainTextResponse("the instructor shows a boat to all\n", 403)
        said = await body_of(request)
        number = int(said) if SHOWN_FORM.fullmatch(said) else -1
        if number not in (NO_BOAT, *self.boats):
            return PlainTextResponse(f"say a boat, 1 to {len(self.boats)}, or 0 for none\n", 400)
        self.shown.show(number)
        return PlainTextResponse(f"{number}\n")

    def _instructs(self, request: Request) -> bool:
        """Return whether a browser has the instructor's seat."""
        seat = self.seats.seat_of(request.cookies)
        return seat is not None and seat.boat == EVERY_BOAT

    def _boat_row(self, boat: AnyBoat, *, instructs: bool) -> dict[str, object]:
        number = boat.row.number
        crew = self.seats.crew_of(number)
        row = {"number": number, "name": boat.row.name or "", "crew": len(crew)}
        if not instructs:
            return row
        names = [seat.name for seat in crew if seat.name]
        return row | {"names": names, "state": boat.state.value, "resumed": boat.resumed}

    async def take_seat(self, request: Request) -> Response:
        """Give a browser a seat on a boat, if the boat admits it to the role that it wants."""
        asked = SEAT_FORM.fullmatch(await body_of(request, MAX_SEAT_BYTES))
        if not asked or asked["role"] not in CREW_PAGES:
            return PlainTextResponse("say BOAT, ROLE, WORD, NAME, a line each\n", 400)
        boat = int(asked["boat"]) or self.seats.next_free(self.boats)
        if boat is None:
            return PlainTextResponse("no boat is free: choose one and join its crew\n", 409)
        if boat not in self.boats:
            return PlainTextResponse(f"there is no boat {boat}\n", 404)
        return await self._admit(request, boat, asked["role"], asked["word"], asked["name"])

    async def take_word(self, request: Request) -> Response:
        """Give a browser the instructor's seat, if a boat takes the word."""
        asked = WORD_FORM.fullmatch(await body_of(request, MAX_SEAT_BYTES))
        if not asked or asked["role"] != "instructor":
            return PlainTextResponse("say instructor WORD\n", 400)
        return await self._admit(request, EVERY_BOAT, "instructor", asked["word"], "")

    async def keep_looking_word(self, request: Request) -> Response:
        """Keep the word of a browser that looks at the boat that is shown; its line tries it."""
        asked = WORD_FORM.fullmatch(await body_of(request))
        if not asked or asked["role"] != LOOKING_ROLE:
            return PlainTextResponse(f"say {LOOKING_ROLE} WORD\n", 400)
        answer = PlainTextResponse("kept\n")
        self._keep(request, answer, TOKEN_COOKIE_PREFIX + LOOKING_ROLE, asked["word"])
        return answer

    async def _admit(
        self, request: Request, boat: int, role: str, word: str, name: str
    ) -> Response:
        """Give a browser a seat and the word that it has said, if the boat takes it."""
        client_host = request.client.host if request.client else ""
        for number in [boat] if boat else [*self.boats]:  # any boat knows the instructor's word
            refused = await ask_role(self.bridges[number].reach, client_host, role, word)
            if refused is None or self.boats[number].state is self.boats[number].state.AT_SEA:
                break
        if refused is not None:
            return PlainTextResponse(f"{refused.reason}\n", 403)
        answer = PlainTextResponse(f"{boat}\n")
        try:
            key = self.seats.take(boat, name, request.cookies, machine_at(request))
        except RefusedError as refusal:
            return PlainTextResponse(f"{refusal}\n", 403)
        self._keep(request, answer, SEAT_COOKIE, key)
        self._keep(request, answer, TOKEN_COOKIE_PREFIX + role, word)
        return answer

    def _keep(self, request: Request, answer: Response, name: str, value: str) -> None:
        """Have a browser keep a value where no script of a page can read it."""
        answer.set_cookie(
            name,
            value,
            max_age=TOKEN_AGE_S if value else 0,
            path=f"{request.scope['root_path']}/",
            secure=request.url.scheme == "https",
            httponly=True,
            samesite="strict",
        )

    def show_class(self, show: Answer) -> Answer:
        """Return the answer with the class page, and its seat if no word is asked."""

        async def answer(request: Request) -> Response:
            shown = await show(request)
            if not self._guarded:
                try:
                    key = self.seats.take(EVERY_BOAT, "", request.cookies, machine_at(request))
                except RefusedError as refusal:
                    return PlainTextResponse(f"{refusal}\n", 403)
                self._keep(request, shown, SEAT_COOKIE, key)
            return shown

        return answer


class SeatedBoats:
    """The pages of the boats, each for who has a seat there."""

    def __init__(self, pages: ASGIApp, entrance: Entrance, refusals: Refusals) -> None:
        self._pages = pages
        self._entrance = entrance
        self._refusals = refusals

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or lead to the first page."""
        asked = HTTPConnection(scope)
        boat = asked.path_params["boat"]
        seat = self._entrance.seats.seat_of(asked.cookies)
        if boat in self._entrance.boats and seat is not None and seat.covers(boat):
            if scope["type"] != "websocket":
                await self._pages(scope, receive, send)
                return
            with self._entrance.seats.carrying_line(seat):
                await self._pages(scope, receive, send)
            return
        self._refusals.add(scope.get("client"), f"refused: {NO_SEAT_TEXT.format(boat)}")
        if scope["type"] == "websocket":
            page = WebSocket(scope, receive, send)
            await page.accept()
            await page.close(REFUSED_CODE, NO_SEAT_TEXT.format(boat))
            return
        first = f"{scope['root_path'].removesuffix(f'/boat/{boat}')}/?boat={boat}"
        await RedirectResponse(first, 303)(scope, receive, send)


def class_pages(
    boats: Mapping[int, AnyBoat],
    host: str,
    refusals: Refusals,
    front: Front | None,
    *,
    guarded: bool,
) -> WholeRequests:
    """Return the pages of a class; ``host`` is where they are served, ``front`` before them."""
    entrance, assets = Entrance(boats, refusals, guarded=guarded), Assets()
    show_missing = answer_page(MISSING_PAGE, assets, 404)

    async def show_missing_page(request: Request, _error: Exception) -> Response:
        return await show_missing(request)

    boat_pages = session_pages(entrance.bridge_of, assets)
    wall = next(page for page in PAGES if page.name == "wall")
    lead_to_wall, show_wall = entrance.shown.lead_to_wall(
        answer_page(NOTHING_SHOWN_PAGE, assets), answer_page(wall, assets)
    )
    app = Starlette(
        routes=[
            Route("/", answer_page(ENTRANCE_PAGE, assets)),
            Route("/class", entrance.show_class(answer_page(CLASS_PAGE, assets))),
            Route("/boats", entrance.tell_boats),
            Route("/seat", entrance.take_seat, methods=["POST"]),
            Route("/word", entrance.take_word, methods=["POST"]),
            Route("/assets/{name}", answer_asset(assets)),
            Route("/wall", lead_to_wall),
            Route("/shown", entrance.show_boat, methods=["POST"]),
            Route("/shown/{boat:int}/wall", show_wall),
            Route("/shown/{boat:int}/word", entrance.keep_looking_word, methods=["POST"]),
            WebSocketRoute("/shown/{boat:int}/line", entrance.shown.carry),
            Mount("/boat/{boat:int}", SeatedBoats(boat_pages, entrance, refusals)),
        ],
        exception_handlers={404: show_missing_page},
    )
    return WholeRequests(Gate(app, host, refusals, front))
