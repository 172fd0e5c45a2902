"""The ships of an exercise (``[[contact]]``), their types, and the rules for encounters.

``world`` reads them with the other tables of an exercise, and ``boat/world/contacts`` moves the
ships. A type has the sizes of one usual ship of its kind, so that an author need not look them up.
The table ``[contacts]`` has the rules: when an encounter is called, what a collision does.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Final

from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    path_named,
    raise_problems,
    relative_name,
)
from trainer.config.schema import (
    Choice,
    Flag,
    KeyForm,
    Quantity,
    Rows,
    Text,
    WholeNumber,
    list_schema,
    optional,
    read_record,
    required,
    with_default,
    within,
)
from trainer.config.ship.nomoto import NomotoFile, is_nomoto, load_nomoto
from trainer.io.orders.schedule import MAX_TIME_S
from trainer.units import KNOT

if TYPE_CHECKING:
    from trainer.config.ship.ship import ShipFile

MAX_CONTACTS: Final = 200  # contacts of an exercise
MAX_CONTACT_RANGE_M: Final = 200_000.0  # [m] from the origin
CONTACT_NAME: Final = re.compile(r"[a-z][a-z0-9-]{0,15}")  # as an order names it
MMSI_RANGE: Final = 100_000_000, 999_999_999  # of nine digits
RESERVED_NAMES: Final = ("add",)  # "contact add" is an order, so no contact may have the name
SHIP_ACCELERATION_M_S2: Final = 0.02  # [m/s^2] of every ship: an estimate
MIN_TIME_CONSTANT_S: Final = 0.1  # [s] of a ship: a faster one changes too much in a tick
# [lengths] radius of a turn: half of IMO's largest tactical diameter
TURN_RADIUS_LENGTHS: Final = 2.5
CONTACT_STATUSES: Final = ("under way", "at anchor", "fishing", "trawling", "sailing", "adrift")
GROUND_SPEED: Final = Quantity("kn", within(0, 60), "over the ground, or one for each leg; else 0")


@dataclass(frozen=True)
class ShipType:
    """One kind of ship: sizes [m], block coefficient, fastest [kn], and its number in AIS."""

    length: float
    beam: float
    draught: float
    block: float
    height: float  # of hull and house over the water
    mast: float  # of the masthead over the water
    fastest_kn: float
    ais: int
    small: bool = False  # it carries a transponder of class B
    status: str = "under way"  # as such a ship usually is

    @cached_property
    def half_diagonal(self) -> float:
        """Return the distance [m] of its corners from its middle, seen from above."""
        return 0.5 * math.hypot(self.length, self.beam)

    @property
    def turn(self) -> float:
        """Return the radius [m] of its turns."""
        return TURN_RADIUS_LENGTHS * self.length

    @property
    def fastest(self) -> float:
        """Return its greatest speed [m/s]."""
        return self.fastest_kn * KNOT


SHIP_TYPES: Final[Mapping[str, ShipType]] = {
    "tanker": ShipType(200, 32, 11, 0.8, 30, 40, 16, ais=80),
    "cargo": ShipType(140, 21, 8, 0.7, 26, 34, 20, ais=70),
    "ferry": ShipType(120, 20, 5.5, 0.58, 24, 32, 24, ais=60),
    "fishing": ShipType(24, 7, 3, 0.55, 7, 12, 12, ais=30, status="fishing"),
    "yacht": ShipType(14, 4.2, 2.2, 0.4, 1.5, 18, 9, ais=36, small=True, status="sailing"),
    "tug": ShipType(32, 11, 5, 0.6, 12, 18, 14, ais=52),
    "submarine": ShipType(70, 10, 8, 0.6, 8, 8, 20, ais=35),  # surfaced; its mast is the sail
}


@dataclass(frozen=True)
class WayPoints:
    """A list of locations, each north and east of the origin."""

    meaning: str
    most: int = 100

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        pair = list_schema(within(-MAX_CONTACT_RANGE_M, MAX_CONTACT_RANGE_M).schema, 2, 2)
        message = f"1 to {self.most} pairs, {-MAX_CONTACT_RANGE_M:.0f} to {MAX_CONTACT_RANGE_M:.0f}"
        return KeyForm("m", message, self.meaning, list_schema(pair, 1, self.most))

    def read(self, key: str, value: object, position: Position) -> tuple[tuple[float, float], ...]:
        """Return the locations; ConfigError naming the first that is wrong."""
        if not isinstance(value, list) or not 1 <= len(value) <= self.most:
            message = f"must be a list of 1 to {self.most} pairs [north, east]"
            raise ConfigError(position.wrong(key, value, message))
        return tuple(self._pair(f"{key}[{i}]", each, position) for i, each in enumerate(value))

    def _pair(self, key: str, value: object, position: Position) -> tuple[float, float]:
        if not isinstance(value, list) or len(value) != 2:
            raise ConfigError(position.wrong(key, value, "must be a pair [north, east]"))
        number = Quantity("m", within(-MAX_CONTACT_RANGE_M, MAX_CONTACT_RANGE_M), "")
        north, east = (number.read(f"{key}[{i}]", each, position) for i, each in enumerate(value))
        return north, east


@dataclass(frozen=True)
class LegSpeeds:
    """One number for all legs, or a list with one for each."""

    each: Quantity
    most: int = 99

    @property
    def form(self) -> KeyForm:
        """Return unit, range and meaning, and the JSON Schema of its values."""
        unit, limits, meaning, schema = self.each.form
        schemas = {"anyOf": [schema, list_schema(schema, 1, self.most)]}
        return KeyForm(unit, f"{limits}, or a list", meaning, schemas)

    def read(self, key: str, value: object, position: Position) -> float | tuple[float, ...]:
        """Return the number or the numbers; ConfigError naming the first that is wrong."""
        if not isinstance(value, list):
            return self.each.read(key, value, position)
        return tuple(self.each.read(f"{key}[{i}]", item, position) for i, item in enumerate(value))


@dataclass(frozen=True, kw_only=True)
class ContactRow:
    """One ship as it stands in the file."""

    name: str = required(Text(16, "as orders name it: small letters, digits and hyphens"))
    type: str = required(
        Choice(tuple(SHIP_TYPES), "kind of ship: sizes, lights, what AIS calls it")
    )
    mmsi: int | None = optional(
        WholeNumber(*MMSI_RANGE, "its number in AIS; else it has no transponder")
    )
    points: tuple[tuple[float, float], ...] = required(
        WayPoints(
            "way points, north and east of the start's origin; one: it lies, or keeps a course"
        )
    )
    speed_kn: float | tuple[float, ...] | None = optional(LegSpeeds(GROUND_SPEED))
    course_deg: float | None = optional(
        "deg", within(0, 360), "with one point: how it lies or goes; else north"
    )
    starts_s: float | None = optional(
        "s", within(0, MAX_TIME_S), "lies until then; else it has its speed from the start"
    )
    status: str | None = optional(
        Choice(
            CONTACT_STATUSES,
            "for lights and AIS; else its type's; where it lies, at anchor, or adrift",
        )
    )
    drifts: bool | None = optional(
        Flag("the current of 5 m carries it; its way is through the water; else over the ground")
    )
    nomoto: str | None = optional(
        Text(200, "file of an identified Nomoto ship that steers it; with one point and a course")
    )
    ship: str | None = optional(
        Text(200, "the same, of a ship that is not linear; it has way on from the start")
    )


@dataclass(frozen=True, kw_only=True)
class Contact:
    """One ship, checked by itself. ``position`` is where the file has it, for messages."""

    row: ContactRow
    position: Position
    nomoto: NomotoFile | None = None  # the ship that answers its rudder,
    ship: "ShipFile | None" = None  # or one that is not linear

    @property
    def type(self) -> ShipType:
        """Return its kind."""
        return SHIP_TYPES[self.row.type]

    @property
    def legs(self) -> int:
        """Return how many speeds it has: one for each leg."""
        return max(len(self.row.points) - 1, 1)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Return the speed [m/s] on each leg; one for a ship with one point."""
        stated = self.row.speed_kn or 0.0
        leg_speeds = stated if isinstance(stated, tuple) else (stated,) * self.legs
        return tuple(speed * KNOT for speed in leg_speeds)

    @property
    def course(self) -> float:
        """Return the course [rad] of a ship with one point."""
        return math.radians(self.row.course_deg or 0.0)

    @property
    def status(self) -> str:
        """Return the status of the ship at the start, such as "at anchor"."""
        if self.row.status:
            return self.row.status
        if len(self.row.points) > 1 or any(self.speeds):
            return self.type.status
        return "adrift" if self.row.drifts else "at anchor"


@dataclass(frozen=True, kw_only=True)
class Encounters:
    """The rules for ships that come near."""

    cpa_m: float = with_default(
        500.0,
        "m",
        within(1, 20_000),
        "closest approach below which it is called; else 500",
    )
    warn_s: float = with_default(
        600.0, "s", within(1, 3600), "called when it is less far ahead; else 600"
    )
    collision: str = with_default(
        "freeze", Choice(("freeze", "end", "call"), "what a collision does; else freeze")
    )
    force: str = with_default(
        "off",
        Choice(("off", "on"), "pull of ships near: an estimate within a factor of two; else off"),
    )


CONTACT_ROWS: Final = Rows(ContactRow, ("note",), 0, MAX_CONTACTS, "ships near, below")


def read_contacts(value: object, position: Position, path: Path) -> tuple[Contact, ...]:
    """Return the ships of an exercise; ConfigError with all that is wrong in them."""
    problems: list[str] = []
    contacts = []
    rows = CONTACT_ROWS.read("contact", value, Position(position.file, ""))
    for i, row in enumerate(rows):
        inside = Position(position.file, f"contact[{i}]")
        with collecting(problems):
            nomoto = _nomoto(row, path) if row.nomoto else None
            ship = _ship(row, path) if row.ship else None
            contact = Contact(row=row, position=inside, nomoto=nomoto, ship=ship)
            problems += _faults(contact)
            contacts.append(contact)
    problems += _twice(contacts)
    raise_problems(problems)
    return tuple(contacts)


def read_encounters(value: object, position: Position, path: Path) -> Encounters:
    """Return the rules for ships that come near; ConfigError with all that is wrong."""
    del path
    return read_record(Encounters, value, position, ("note",))


def _ship(row: ContactRow, path: Path) -> "ShipFile":
    """Return the ship of a contact that is not linear; ConfigError if its file is of none."""
    from trainer.config.ship.ship import load_ship  # noqa: PLC0415  few exercises have one

    ship_path = path_named(relative_name(path, str(row.ship)), "ships")
    if is_nomoto(ship_path):
        raise ConfigError(f"{ship_path.name}: is a Nomoto ship: {row.name} has it as nomoto")
    return load_ship(ship_path)


def _nomoto(row: ContactRow, path: Path) -> NomotoFile:
    """Return the identified ship of a contact; ConfigError if it cannot be steered."""
    from trainer.config.ship.ship import is_ship  # noqa: PLC0415  likewise

    nomoto_path = Path(relative_name(path, str(row.nomoto)))
    if is_ship(nomoto_path):
        raise ConfigError(
            f"{nomoto_path.name}: is a ship that is not linear: {row.name} has it as ship"
        )
    ship = load_nomoto(nomoto_path)
    bad = [
        Position(nomoto_path.name, "").wrong(
            key, getattr(ship, key), f"{row.name} cannot be steered: {why}"
        )
        for key, why, good in (
            ("K_per_s", "must be below 0", ship.K_per_s < 0.0),
            (
                "T1_s",
                f"must be {MIN_TIME_CONSTANT_S:g} s or more",
                ship.T1_s >= MIN_TIME_CONSTANT_S,
            ),
            ("T2_s", "must be 0, or as much", ship.T2_s == 0.0 or ship.T2_s >= MIN_TIME_CONSTANT_S),
        )
        if not good
    ]
    if bad:
        raise ConfigError(*bad)
    return ship


def _faults(contact: Contact) -> list[str]:
    """Return what is wrong with one ship by itself."""
    row, position = contact.row, contact.position
    faults = []
    if not CONTACT_NAME.fullmatch(row.name) or row.name in RESERVED_NAMES:
        message = "must be small letters, digits and hyphens, a letter first, and not add"
        faults.append(position.wrong("name", row.name, message))
    if isinstance(row.speed_kn, tuple) and len(row.speed_kn) != contact.legs:
        faults.append(
            position.wrong("speed_kn", [*row.speed_kn], f"must be one number, or {contact.legs}")
        )
    faults += [
        position.wrong("speed_kn", speed, f"a {row.type} makes {contact.type.fastest_kn:g} kn")
        for speed in dict.fromkeys(speed / KNOT for speed in contact.speeds)
        if speed > contact.type.fastest_kn + 1e-9
    ]
    return faults + _misplaced(contact)


def _misplaced(contact: Contact) -> list[str]:
    """Return problems of keys that do not go with the way points, or with each other."""
    row, position = contact.row, contact.position
    problems = []
    if row.course_deg is not None and len(row.points) > 1:
        problems.append(position.wrong("course_deg", row.course_deg, "goes with one point alone"))
    for key in ("nomoto", "ship"):
        file = getattr(row, key)
        if file is not None and len(row.points) > 1:
            problems.append(position.wrong(key, file, "goes with one point and course_deg"))
    if row.ship is not None:
        problems += _without_way(contact)
    if row.drifts and row.status == "at anchor":
        problems.append(
            position.wrong("drifts", row.drifts, 'does not go with status = "at anchor"')
        )
    return problems


def _without_way(contact: Contact) -> list[str]:
    """Return problems of keys that do not go with a ship that is not linear."""
    row, position = contact.row, contact.position
    problems = []
    if row.nomoto is not None:
        problems.append(position.wrong("ship", row.ship, "goes without nomoto: give one"))
    if not any(contact.speeds):
        problems.append(position.wrong("ship", row.ship, "goes with speed_kn: it has way on"))
    if row.starts_s:
        problems.append(
            position.wrong("starts_s", row.starts_s, "goes without ship: it has way on")
        )
    return problems


def _twice(found: list[Contact]) -> list[str]:
    """Return problems of names and numbers that two ships share."""
    problems = []
    for key in ("name", "mmsi"):
        values = [(getattr(each.row, key), each.position) for each in found]
        for i, (value, position) in enumerate(values):
            if value is not None and value in [before for before, _ in values[:i]]:
                problems.append(position.wrong(key, value, "another [[contact]] has it"))
    return problems
