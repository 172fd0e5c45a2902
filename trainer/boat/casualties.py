"""Casualties of a boat: inserted, cleared, listed, armed; and instruments that they falsify.

The orders ``casualty`` and ``clear`` come here (``helm``). A casualty takes a slot of the state,
with its kind, its amount and how fast that grows; the core then makes it felt at each tick
(``core/casualties``). An armed one begins by itself, when a condition of the exercise is met.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.plant_effects import lacking_plant
from trainer.config.boat.casualties import (
    GAUGE_UNITS,
    PARTS_RULE,
    SEVERITY_MEASURES,
    Casualty,
    Count,
    parts_lines,
    parts_text,
    severity_rule,
)
from trainer.config.exercise.condition import PLANT_QUANTITIES, STATE_QUANTITIES
from trainer.config.exercise.derived import Condition
from trainer.config.files import ConfigError, nearest
from trainer.core import casualties as casualties_module
from trainer.core.ballast.tanks import BANKS, TANKS
from trainer.core.casualties import (
    CASUALTY_TABLE,
    CODES,
    KINDS,
    SOUNDER,
    CasualtyKind,
    instruments,
)
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.sides import SURFACE_SIDES

TRIGGER_RULES: Final = ("once", "again")
MAX_RAMP_S: Final = 3600.0  # [s] ramp
AMOUNT_UNITS: Final = {  # unit, its size [SI], and the words before
    Count.HOLE: ("cm2", 1e-4, "hole "),
    Count.FLOW: ("L/s", 1e-3, ""),
    Count.TIME: ("s", 1.0, ""),
}
OFFSETS: Final = ("too little", "too much")  # what a gauge shows


@dataclass(frozen=True)
class ActiveCasualty:
    """One casualty that the boat suffers."""

    kind: str
    amount: float  # [SI] at present
    target: float  # [SI]
    seconds: float  # until it is there, or gone
    clearing: bool


class Size(NamedTuple):
    """An amount of a casualty as people count it: `reads 3 m too much`."""

    amount: str
    unit: str
    before: str = ""  # the words before the amount
    side: str = ""
    sides: tuple[str, ...] = ()  # that of less, then that of more, where there are two


class Degree(NamedTuple):
    """The usual degree of a casualty, as an instructor's page offers it."""

    name: str
    severity: float
    ramp_s: float
    size: Size

    @property
    def fields(self) -> str:
        """Return the degree in fields for programs."""
        size = self.size
        amounts = f"{self.severity:g}", f"{self.ramp_s:g}", size.amount
        return ",".join((self.name, *amounts, size.unit, size.side, *size.sides))


class InstrumentReadings(NamedTuple):
    """The readings of a station's instruments."""

    depth: float  # [m]
    heading: float  # [rad] not wrapped
    speed: float  # [m/s]
    sounding: float  # [m] from the origin's depth down to the ground, 0 without an echo


def find_casualty(boat: Boat, name: str) -> Casualty | Refused:
    """Return the casualty of that name; spaces and underscores count as dashes."""
    key = name.strip().casefold().replace(" ", "-").replace("_", "-")
    if key in boat.casualties:
        return boat.casualties[key]
    return Refused(f"no casualty {name!r}{nearest(key, boat.casualties)}")


def insert_casualty(
    boat: Boat, name: str, severity: float | None = None, ramp_s: float | None = None
) -> Reply:
    """Begin a casualty at the next tick. A value that is not given is as in its table."""
    chosen = _chosen(boat, name, severity, ramp_s)
    if isinstance(chosen, Refused):
        return chosen
    casualty, wanted, ramp = chosen
    if casualty.parts:
        return _insert_parts(boat, casualty)
    amount = _amount(boat, casualty, wanted)
    ticks = float(boat.ticks_in(ramp))  # whole, so that a replay has the same
    if not casualties_module.begin(casualty.code, amount, ticks, boat.records.state):
        suffered = active_casualties(boat)
        return Refused(f"{len(suffered)} casualties at most: clear one of {_names(suffered)}")
    degree = "" if casualty.measure.sudden else f", {describe_amount(boat, casualty.kind, amount)}"
    return f"casualty {casualty.name}{degree}{_within(ramp)}"


def _insert_parts(boat: Boat, casualty: Casualty) -> Reply:
    """Begin all parts of a casualty at the next tick, or none."""
    suffered = active_casualties(boat)
    new = {each.kind for each in casualty.parts} - {each.kind for each in suffered}
    most = boat.state.casualty.size
    if len(suffered) + len(new) > most:
        return Refused(
            f"{casualty.name}: {len(new)} more, and {most} casualties at most: clear some of "
            f"{_names(suffered)}"
        )
    for part in casualty.parts:
        amount, ticks = _amount(boat, part, part.severity), float(boat.ticks_in(part.ramp_s))
        casualties_module.begin(part.code, amount, ticks, boat.records.state)
    return f"casualty {casualty.name}: {parts_text(casualty)}"


def ordered_casualty(order: Order) -> tuple[str, float | None, float | None]:
    """Return name, severity and ramp of an order ``casualty``; None for what it leaves out."""
    numbers = list(order.numbers)
    ramp = numbers.pop() if order.word == "ramp" else None
    return order.subject, numbers[0] if numbers else None, ramp


def casualty_refusal(boat: Boat, order: Order) -> Refused | None:
    """Return why an order ``casualty`` would be refused at any time, None if not."""
    chosen = _chosen(boat, *ordered_casualty(order))
    return chosen if isinstance(chosen, Refused) else None


def _chosen(
    boat: Boat, name: str, severity: float | None, ramp_s: float | None
) -> tuple[Casualty, float, float] | Refused:
    """Return a casualty with its severity and ramp, or why it cannot happen to the boat."""
    casualty = find_casualty(boat, name)
    if isinstance(casualty, Refused):
        return casualty
    wanted = casualty.severity if severity is None else severity
    ramp = casualty.ramp_s if ramp_s is None else ramp_s
    return _wrong(boat, casualty, wanted, ramp) or (casualty, wanted, ramp)


def clear_casualty(boat: Boat, name: str) -> Reply:
    """Clear a casualty, or ``all`` of them. Each takes the time of its table."""
    if name.strip().casefold() in ("all", "casualties"):
        suffered = active_casualties(boat)
        for slot in suffered:
            _end(boat, boat.casualties[slot.kind])
        return f"clearing {_names(suffered)}" if suffered else "there is nothing to clear"
    casualty = find_casualty(boat, name)
    if isinstance(casualty, Refused):
        return casualty
    ended = [_end(boat, each) for each in casualty.broken]
    if not any(ended):
        absent = casualty.name if casualty.parts else casualty.kind
        return Refused(f"there is no {absent}; active: {_names(active_casualties(boat))}")
    return f"clearing {casualty.name}{_within(casualty.clear_ramp_s)}"


def active_casualties(boat: Boat) -> list[ActiveCasualty]:
    """Return what the boat suffers, in the order of the slots."""
    s, step = boat.state, boat.method.step
    return [
        ActiveCasualty(
            kind=KINDS[int(s.casualty[i]) - 1],
            amount=float(s.casualty_amount[i]),
            target=float(s.casualty_target[i]) if s.casualty_ticks[i] >= 0.0 else 0.0,
            seconds=float(abs(s.casualty_ticks[i])) * step,
            clearing=bool(s.casualty_ticks[i] < 0.0),
        )
        for i in range(s.casualty.size)
        if s.casualty[i]
    ]


def broken_gauges(boat: Boat) -> set[str]:
    """Return the names of the gauges that a casualty has spoilt."""
    rows = (kind_row(each.kind) for each in active_casualties(boat))
    return {row.equipment for row in rows if row.gauge >= 0}


def describe_amount(boat: Boat, kind: str, amount: float) -> str:
    """Return an amount [SI] of a casualty with its unit and side: 6 deg dive."""
    size = size_of(boat, kind, amount)
    return f"{size.before}{size.amount} {size.unit} {size.side}".rstrip() if size else ""


def size_of(boat: Boat, kind: str, amount: float) -> Size | None:
    """Return an amount [SI] of a casualty as people count it.

    None where they do not count it.
    """
    row, measure = kind_row(kind), SEVERITY_MEASURES[kind]
    if measure.count is Count.ANGLE:
        # an angle [rad] of a surface with its side, right and rise positive
        angle = amount * boat.toward[row.equipment]
        size = round(math.degrees(angle), 1) + 0.0
        more, less = SURFACE_SIDES[row.equipment]
        sides = (less, more) if size else ()
        return Size(f"{abs(size):g}", "deg", side=less if size < 0.0 else more, sides=sides)
    if measure.count in AMOUNT_UNITS:
        unit, size, before = AMOUNT_UNITS[measure.count]
        return Size(f"{amount / size:.3g}", unit, before=before)
    if measure.count is Count.SHARE:
        return Size(f"{100.0 * amount:.3g}", f"% {measure.share}")
    if measure.count is Count.NOTHING:
        return None
    return _gauge_size(row.equipment, measure.count, amount)


def _gauge_size(gauge: str, count: Count, amount: float) -> Size:
    """Return what is wrong with a gauge, in its unit."""
    unit, size = GAUGE_UNITS[gauge]
    shown = amount / size
    if count is Count.NOISE:
        return Size(f"{shown:.3g}", f"{unit} of noise")
    if count is Count.VALUE:
        value = shown % 360.0 if unit == "deg" else shown
        return Size(f"{value:.1f}", unit, before="at ")
    side = OFFSETS[shown >= 0.0]
    return Size(f"{abs(shown):.3g}", unit, before="reads ", side=side, sides=OFFSETS)


def kind_row(kind: str) -> CasualtyKind:
    """Return the row of a kind of casualty."""
    return CASUALTY_TABLE[CODES[kind] - 1]


def casualty_listing(boat: Boat) -> list[str]:
    """Return what the boat can suffer.

    Each has the word of the order ``casualty``, then its meaning.
    """
    lines = []
    for name, degree, says in available_casualties(boat):
        casualty = boat.casualties[name]
        whole = _amount(boat, casualty, casualty.severity)
        effect = "" if casualty.sudden else f"    ({describe_amount(boat, casualty.kind, whole)})"
        lines += [f"{name} {degree}".rstrip() + effect, f"    {says}", *parts_lines(casualty)]
    return lines


def available_casualties(boat: Boat) -> list[tuple[str, str, str]]:
    """Return the casualties of the boat.

    Each has its name, its degree as ordered and its meaning.
    """
    return [
        (
            casualty.name,
            "" if casualty.sudden else f"{casualty.severity:g} ramp {casualty.ramp_s:g}",
            casualty.description,
        )
        for casualty in boat.casualties.values()
        if all(_carries(boat, each.kind) for each in casualty.broken)
    ]


def degrees(boat: Boat) -> list[Degree]:
    """Return the usual degrees of the casualties that can have another one."""
    found = (degree_of(boat, boat.casualties[name]) for name, _, _ in available_casualties(boat))
    return [degree for degree in found if degree]


def degree_of(boat: Boat, casualty: Casualty) -> Degree | None:
    """Return the usual degree of a casualty, None where it can have no other."""
    if casualty.sudden:
        return None
    size = size_of(boat, casualty.kind, _amount(boat, casualty, casualty.severity))
    return Degree(casualty.name, casualty.severity, casualty.ramp_s, size) if size else None


def instrument_readings(boat: Boat) -> InstrumentReadings:
    """Return what the instruments of a station show at this tick."""
    instruments(boat.records.state, boat.records.scratch)
    return InstrumentReadings(*boat.records.scratch["reading"][0].tolist())


def arm_casualty(boat: Boat, condition: Condition, casualty: Casualty, rule: str = "once") -> None:
    """Begin ``casualty`` when the state meets ``condition``.

    It begins once, or ``again`` each time.

    Armed triggers are constants of the run and belong to no snapshot. ConfigError if the boat lacks
    what either is about, or has no trigger left.
    """
    where = condition.position
    if rule not in TRIGGER_RULES:
        raise ConfigError(where.wrong("rule", rule, f"must be {' or '.join(TRIGGER_RULES)}"))
    wrong = _wrong(boat, casualty, casualty.severity, casualty.ramp_s)
    if wrong:
        raise ConfigError(where.problem(f"casualty {casualty.name}: {wrong}"))
    m = boat.records.scheme[0]
    unarmed = [i for i in range(m.trigger_kind.size) if m.trigger_kind[i] == 0.0]
    if len(unarmed) < len(casualty.broken):
        raise ConfigError(where.problem(f"more than {m.trigger_kind.size} triggers"))
    # what turns the threshold [SI] into that of the field of the state
    factor = scale_of(boat, condition.quantity)
    if factor == 0.0:
        problem = f"condition {condition.text!r}: {boat.file.path.name} has no {condition.quantity}"
        raise ConfigError(condition.position.problem(problem))
    for i, part in zip(unarmed, casualty.broken, strict=False):
        m.trigger_place[i] = STATE_OFFSETS[STATE_QUANTITIES[condition.quantity].field]
        m.trigger_sense[i] = condition.sense * math.copysign(1.0, factor)
        m.trigger_threshold[i] = _whole(condition.threshold * factor)
        m.trigger_strict[i] = condition.strict
        m.trigger_amount[i] = _amount(boat, part, part.severity)
        m.trigger_ticks[i] = boat.ticks_in(part.ramp_s)
        m.trigger_again[i] = rule == "again"
        m.trigger_kind[i] = part.code


def _names(casualties: list[ActiveCasualty]) -> str:
    """Return what there is, in words."""
    return ", ".join(each.kind for each in casualties) or "none"


def _within(seconds: float) -> str:
    """Return a ramp in words, '' for none."""
    return f" within {seconds:g} s" if seconds else ""


def _whole(value: float) -> float:
    """Return ``value``, or the whole number where only rounding is between them."""
    nearest_whole = float(round(value))
    return nearest_whole if abs(value - nearest_whole) < 1e-9 * max(abs(value), 1.0) else value


def scale_of(boat: Boat, quantity: str) -> float:
    """Return the factor from a quantity [SI] to its field of the state. 0: the boat lacks it.

    A condition names quantities as people do; the state may hold another sign or unit.
    """
    name = quantity
    if name == "time":
        return 1.0 / boat.method.step
    if name == "turns":
        return 1.0 / boat.file.propulsion.rps_per_mps
    if name in SURFACES:
        return boat.toward[name]
    if name.startswith("bank_"):
        volume = boat.vessel.bank_volume[BANKS.index(name.removeprefix("bank_"))]
        return float(volume / boat.vessel.gas) if boat.vessel.gas else 0.0
    if name.startswith(("water_", "flood_")):
        tank = name.removeprefix("water_").replace("flood_", "compartment_")
        return float(boat.vessel.capacity[TANKS.index(tank)] > 0.0)
    return float(name not in PLANT_QUANTITIES or boat.file.plant is not None)


def _amount(boat: Boat, casualty: Casualty, severity: float) -> float:
    """Return the core's amount [SI] of a casualty."""
    return severity * casualty.full * full_angle(boat, casualty.kind)


def full_angle(boat: Boat, kind: str) -> float:
    """Return the angle [rad] hard over if a kind drives a surface, else 1."""
    row = kind_row(kind)
    if not row.turned or row.holds:
        return 1.0
    return boat.toward[row.equipment] * float(boat.vessel.limit[row.surface])


def _end(boat: Boat, casualty: Casualty) -> int:
    """Clear a casualty; return whether it was there."""
    ticks = float(boat.ticks_in(casualty.clear_ramp_s))
    return int(casualties_module.end(casualty.code, ticks, boat.records.state))


def _wrong(boat: Boat, casualty: Casualty, severity: float, ramp: float) -> Refused | None:
    """Return why this cannot happen to the boat, None if it can."""
    if casualty.parts:
        return _wrong_parts(boat, casualty, severity, ramp)
    if not _carries(boat, casualty.kind):
        if kind_row(casualty.kind).plant and not boat.has_plant:
            return lacking_plant(boat)
        return Refused(f"{boat.file.path.name} has nothing for {casualty.kind} to act on")
    if severity not in casualty.measure.limits:
        return Refused(f"severity {severity:g}: {severity_rule(casualty.kind)}")
    if not 0.0 <= ramp <= MAX_RAMP_S:
        return Refused(f"ramp {ramp:g} s: must be 0 to {MAX_RAMP_S:g} s")
    ramped = casualty.sudden and ramp
    return Refused(f"{casualty.kind} comes at once: it has no ramp") if ramped else None


def _wrong_parts(boat: Boat, casualty: Casualty, severity: float, ramp: float) -> Refused | None:
    """Return why a casualty of several cannot happen to the boat, None if it can."""
    if severity != 1.0 or ramp:
        return Refused(f"{casualty.name}: {PARTS_RULE}")
    found = (_wrong(boat, each, each.severity, each.ramp_s) for each in casualty.parts)
    return next((Refused(f"{casualty.name}: {each.reason}") for each in found if each), None)


def _carries(boat: Boat, kind: str) -> bool:
    """Return whether the boat has what the kind acts on; everyone has a propeller and gauges."""
    row = kind_row(kind)
    if row.surface >= 0 and not boat.carries(row.equipment):
        return False
    if row.surface >= 0 and not row.size:
        return True
    if row.gauge == SOUNDER:
        return bool(boat.state.bottom[0, 0])
    if row.size:
        return bool(boat.vessel[row.size][row.part])
    return row.equipment != "autopilot" or boat.automatic
