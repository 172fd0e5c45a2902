"""The ships near: where each is, what the instructor changes, what is seen.

``world`` has them round the boat. Where they are follows from the exercise, the orders with their
ticks, and the tick alone. So a replay has them where they were, and a tick of the past has them as
they were then. A ship that drifts goes its way through the water, and the current of FLOATING
carries its way along.
"""

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any, Final

import numpy as np

from trainer.boat.world.bottom import STATE_OFFSETS, TICK_OFFSET
from trainer.boat.world.consorts import BOAT_NAME, BOAT_TYPE, BOATS_MMSI, hull_at
from trainer.boat.world.contact_fleet import KNOWN_BLOCKS, ContactFleet, Ship, Ticks
from trainer.boat.world.current import CurrentAround
from trainer.boat.world.hulls import Pose, read_pose
from trainer.boat.world.lights import Light, lights_of
from trainer.boat.world.ship_force import ShipPull
from trainer.boat.world.steered import SteerableShip, SteeredContact, SteeredNomoto
from trainer.boat.world.tracks import (
    Piece,
    Situation,
    Stretch,
    Way,
    lay_way,
    path_along,
    rest_of,
    turn_stretch,
    unreached_stretch,
)
from trainer.config.files import ConfigError, collecting, nearest, raise_problems
from trainer.config.world.contacts import (
    CONTACT_NAME,
    MAX_CONTACTS,
    RESERVED_NAMES,
    SHIP_TYPES,
    Contact,
    Encounters,
)
from trainer.config.world.world import WorldTables
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.units import KNOT

FORCE_OFFSET: Final = STATE_OFFSETS["ship_force"]
STRAIGHT_ON: Final = (Stretch(0.0, math.inf),)  # straight on for ever
EMPTY_PIECE: Final = Piece(0.0, math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class ContactState:
    """One ship at a tick, in SI and radians. Its location is from the start's origin."""

    name: str
    type: str
    status: str
    north: float
    east: float
    course: float  # over the ground, and so is the speed
    speed: float
    heading: float
    turning: float  # [rad/s] to starboard positive
    length: float
    beam: float
    draught: float
    height: float  # of hull and house over the water
    mast: float  # of the masthead over the water
    lights: tuple[Light, ...]
    mmsi: int | None


class Contacts:
    """The ships near, as a part of the world."""

    def __init__(self, boat: Any, ships: Sequence[Contact], encounters: Encounters) -> None:
        """Take the ships of an exercise; ConfigError on a way that no ship can go."""
        self.encounters = encounters
        self.step = float(boat.method.step)
        self.given = tuple(ships)
        self._boat = boat
        self._recent: deque[ContactFleet] = deque(maxlen=KNOWN_BLOCKS)
        self._first = self._fleet_of(ships_of(ships, self.step))
        self._fleets: tuple[tuple[int, ContactFleet], ...] = ((0, self._first),)
        self._pull = ShipPull(boat) if encounters.force == "on" else None

    @property
    def acts(self) -> bool:
        """Return whether ships pull at the boat."""
        return self._pull is not None and self.any

    @property
    def any(self) -> bool:
        """Return whether there are ships at any tick."""
        return any(fleet.order for _, fleet in self._fleets)

    def fleet(self, tick: int) -> ContactFleet:
        """Return the ships that there are at a tick."""
        begins, fleet = self._fleets[-1]
        if begins <= tick:  # nearly always
            return fleet
        index = bisect_right(self._fleets, tick, key=itemgetter(0)) - 1
        return self._fleets[max(index, 0)][1]

    def at(self, tick: int) -> Situation:
        """Return where the ships are at a tick, in the order of the fleet."""
        motions = self.fleet(tick).motions(tick)
        return Situation(*np.array(motions).reshape(-1, len(Situation._fields)).T)

    def stretches(self, ticks: Ticks) -> Iterator[tuple[Ticks, ContactFleet]]:
        """Yield each fleet of some ticks, with the indices of its ticks among them."""
        begins = np.array([begin for begin, _ in self._fleets])
        chosen = np.maximum(np.searchsorted(begins, ticks, side="right") - 1, 0)
        for i in np.unique(chosen).tolist():
            yield np.flatnonzero(chosen == i), self._fleets[i][1]

    def seen(self, tick: int) -> tuple[ContactState, ...]:
        """Return every ship at a tick, with what can be seen of it."""
        fleet, now = self.fleet(tick), self.at(tick)
        columns = *now[:2], *now.over_ground(), now.course, now.turning
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return tuple(_seen(ship, row) for ship, row in zip(fleet.order, rows, strict=True))

    def water(self, time: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the way of water [m] by a time [s], and its velocity."""
        current = self._boat.world.parts.get("current")
        if not isinstance(current, CurrentAround) or not current.acts:
            return (0.0, 0.0), (0.0, 0.0)
        return current.carried(time), current.floating(time)

    def obey(self, order: Order, tick: int) -> Reply:
        """Take an order from a tick on; return the answer."""
        doing = order.word.partition("_")[0]
        ships = dict(self.fleet(tick).ships)
        brings = {"add": self._add, "boat": self._meet, "boats": self._meet}.get(doing)
        if brings:
            return brings(order, tick, ships)
        ship = ships.get(order.subject)
        if ship is None:
            known = nearest(order.subject, ships) or f"; there are: {', '.join(ships) or 'none'}"
            return Refused(f"no contact {order.subject}{known}")
        if doing == "remove":
            del ships[ship.name]
            return self._change(tick, ships, f"contact {ship.name} is gone")
        if doing == "speed" and order.value > ship.type.fastest + 1e-9:
            return Refused(f"a {ship.kind} makes {ship.type.fastest_kn:g} kn")
        change = _steered if ship.steered else CHANGES[doing]
        time = tick * self.step
        if doing == "speed" and (refused := _unable(ship, order.value, time)):
            return Refused(f"{ship.name}: {refused.reason}")
        # an ordered location is over the ground; the way of a ship that drifts is through the water
        if doing == "move" and ship.drifts:
            gone = self.water(time)[0]
            numbers = tuple(at - by for at, by in zip(order.numbers, gone, strict=True))
            ships[ship.name] = change(ship, replace(order, numbers=numbers), time)
        else:
            ships[ship.name] = change(ship, order, time)
        return self._change(tick, ships, f"{order.text}")

    def forget(self) -> None:
        """Forget all orders: the ships are those of the exercise."""
        self._fleets = ((0, self._first),)

    def stands(self, _tick: int) -> bool:
        """Return whether no ship pulls at the boat."""
        return self._pull is None

    def write(self, numbers: Any) -> None:
        """Write the pull of the ships near for the tick that comes."""
        if self._pull is None:
            return
        tick = int(numbers[TICK_OFFSET])
        fleet = self.fleet(tick)
        rows = zip(fleet.order, fleet.motions(tick), strict=True)
        ships = [(ship.type, *motion[:4]) for ship, motion in rows if not ship.hull]
        pull = self._pull.on(Pose(*read_pose(numbers)), ships)
        for i, each in enumerate(pull, FORCE_OFFSET):
            numbers[i] = each

    def _change(self, tick: int, ships: dict[str, Ship], reply: str = "") -> str:
        self._fleets = (*self._fleets, (tick, self._fleet_of(ships)))
        return reply

    def _fleet_of(self, ships: Mapping[str, Ship]) -> ContactFleet:
        return ContactFleet(ships, self.water, self.step, self._recent)

    def _meet(self, order: Order, tick: int, ships: dict[str, Ship]) -> Reply:
        """Have another boat of the class where it is told to be, or have none any more."""
        if order.word == "boats_gone":
            return self._change(tick, {name: ships[name] for name in ships if not ships[name].hull})
        number, north, east, depth, course, speed = order.numbers
        start = EMPTY_PIECE._replace(north=north, east=east, course=course, speed=speed)
        hull, name = hull_at(self._boat, depth), BOAT_NAME.format(int(number))
        mmsi = BOATS_MMSI + int(number) if hull.mast > 0.0 else None
        way = lay_way(tick * self.step, start, STRAIGHT_ON)
        status = SHIP_TYPES[BOAT_TYPE].status
        ships[name] = Ship(name, BOAT_TYPE, status, mmsi, way, hull=hull)
        return self._change(tick, ships)

    def _add(self, order: Order, tick: int, ships: dict[str, Ship]) -> Reply:
        """Add a ship that keeps a course and speed."""
        name, kind = order.subject, order.word.split("_")[1]
        north, east, course, speed = order.numbers
        if refused := _unfit(name, kind, speed, ships):
            return refused
        start = EMPTY_PIECE._replace(north=north, east=east, course=course, speed=speed)
        status = "at anchor" if speed == 0.0 else SHIP_TYPES[kind].status
        way = lay_way(tick * self.step, start, STRAIGHT_ON)
        ships[name] = Ship(name, kind, status, None, way)
        return self._change(tick, ships, order.text)


def contacts_in(boat: Any) -> Contacts | None:
    """Return the ships near a boat; None for one without a world."""
    part = boat.world.parts.get("contact")
    return part if isinstance(part, Contacts) else None


def contacts_of(boat: Any, tables: WorldTables) -> Contacts:
    """Return the ships near a boat; ConfigError with all ways that none can go."""
    return Contacts(boat, tables.get("contact", ()), tables.get("contacts", Encounters()))


def _unable(ship: Ship, speed: float, time: float) -> Refused | None:
    """Return why a ship cannot go at a speed [m/s] from a time [s] on, None if it can."""
    return ship.steered.ship.unfit(ship.steered.at(time), speed) if ship.steered else None


def _seen(ship: Ship, row: Sequence[float]) -> ContactState:
    """Return a ship as it is looked at, by its numbers in the order of a situation."""
    kind = ship.type
    north, east, course, speed, heading, turning = row
    # fmt: off
    return ContactState(
        ship.name, ship.kind, ship.status,
        north, east, course % math.tau, speed, heading % math.tau, turning,
        kind.length, kind.beam, kind.draught, kind.height, kind.mast,
        lights=lights_of(kind, ship.status),
        mmsi=ship.mmsi,
    )
    # fmt: on


def _unfit(name: str, kind: str, speed: float, ships: Mapping[str, Ship]) -> Refused | None:
    """Return why no such ship can be added, None if it can."""
    if not CONTACT_NAME.fullmatch(name) or name in RESERVED_NAMES:
        return Refused(f"{name}: a name has at most 16 letters, digits and hyphens")
    if name in ships:
        return Refused(f"there is a contact {name} already")
    if len(ships) >= MAX_CONTACTS:
        return Refused(f"there are {MAX_CONTACTS} contacts already")
    fastest = SHIP_TYPES[kind]
    too_fast = speed > fastest.fastest + 1e-9
    return Refused(f"a {kind} makes {fastest.fastest_kn:g} kn") if too_fast else None


def ships_of(ships: Sequence[Contact], step: float) -> dict[str, Ship]:
    """Return the ships of an exercise; ConfigError with all ways that none can go."""
    problems: list[str] = []
    by_name = {}
    for contact in ships:
        with collecting(problems):
            by_name[contact.row.name] = _ship_of(contact, step)
    raise_problems(problems)
    return by_name


def _ship_of(contact: Contact, step: float) -> Ship:
    """Return a ship of the exercise; ConfigError if its way cannot be gone."""
    row = contact.row
    steered = steered_of(contact, step)
    drifts = bool(row.drifts)
    return Ship(row.name, row.type, contact.status, row.mmsi, way_of(contact), drifts, steered)


def steered_of(contact: Contact, step: float) -> SteeredContact | None:
    """Return a ship that answers its rudder; None for one that goes along a way. ConfigError."""
    ship = _helmed(contact)
    if ship is None:
        return None
    row, (speed,) = contact.row, contact.speeds
    late, (north, east) = row.starts_s or 0.0, row.points[0]
    start = ship.begin(north, east, contact.course, 0.0 if late else speed)
    return SteeredContact(ship, step, late, start, contact.course, speed)


def _helmed(contact: Contact) -> SteerableShip | None:
    """Return the ship of a contact's file; None without one. ConfigError if it cannot sail."""
    if contact.nomoto:
        return SteeredNomoto(contact.nomoto)
    from trainer.boat.world.steered_ship import SteeredShip  # noqa: PLC0415  few sail one

    return SteeredShip(contact.ship) if contact.ship else None


def way_of(contact: Contact) -> Way:
    """Return the way of a ship. ConfigError on a leg too short, for its turns or its speed."""
    row, position = contact.row, contact.position
    course, path = contact.course, [Stretch(0.0, math.inf, contact.speeds[0])]
    if len(row.points) > 1:
        try:
            course, path = path_along(row.points, contact.speeds, contact.type.turn)
        except ValueError as wrong:
            text = ", ".join(f"[{north:g}, {east:g}]" for north, east in row.points)
            raise ConfigError(position.problem(f"points = [{text}]: {wrong}")) from None
    (north, east), late = row.points[0], row.starts_s or 0.0
    speed = 0.0 if late else contact.speeds[0]
    start = EMPTY_PIECE._replace(north=north, east=east, course=course, speed=speed)
    way = lay_way(late, start, path)
    if len(row.points) > 1 and (leg := unreached_stretch(way)) is not None:
        ordered = (path[leg].speed or 0.0) / KNOT
        text = f"{ordered:g} kn is not reached on a leg of {path[leg].length:.0f} m between turns"
        raise ConfigError(position.problem(f"speed_kn = {ordered:g}: {text}"))
    return way


def _on(ship: Ship, start: Piece, path: Sequence[Stretch]) -> Ship:
    """Return the ship on another way, which begins where a piece of the old one does."""
    return replace(ship, way=lay_way(start.begins, start, path))


def _course(ship: Ship, order: Order, time: float) -> Ship:
    """Turn to a course the short way, and keep it. A ship that lies still is turned at once."""
    now, path = rest_of(ship.way, time)
    if ship.lies(now):
        return _on(ship, now._replace(course=order.value), STRAIGHT_ON)
    change = math.remainder(order.value - now.course, math.tau)
    first, *others = [*turn_stretch(change, ship.type.turn), Stretch(0.0, math.inf)]
    return _on(ship, now, [first._replace(speed=path[0].speed), *others])


def _speed(ship: Ship, order: Order, time: float) -> Ship:
    """Go at a speed from now on, the way unchanged."""
    now, path = rest_of(ship.way, time)
    path = [each._replace(speed=order.value) for each in path]
    at_anchor = ship.status == "at anchor" and order.value > 0.0
    status = ship.type.status if at_anchor else ship.status
    return _on(replace(ship, status=status), now, path)


def _move(ship: Ship, order: Order, time: float) -> Ship:
    """Be elsewhere at once, and go straight on from there."""
    now, path = rest_of(ship.way, time)
    north, east = order.numbers
    start = now._replace(north=north, east=east)
    return _on(ship, start, [Stretch(0.0, math.inf, path[0].speed)])


def _steered(ship: Ship, order: Order, time: float) -> Ship:
    """Order course or speed of a ship that answers its rudder, or put it elsewhere."""
    steered = ship.steered
    assert steered is not None  # noqa: S101  the caller has looked
    if order.word == "move":
        return replace(ship, steered=steered.moved(time, *order.numbers))
    course, speed = (order.value if order.word == key else None for key in ("course", "speed"))
    return replace(ship, steered=steered.then(time, course, speed))


CHANGES: Final = {"course": _course, "speed": _speed, "move": _move}
