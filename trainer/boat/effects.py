"""What orders write into the state: an effect for each wording that does nothing else.

``helm`` and ``ballast_orders`` obey by these effects, and a boat that is exported has them as rows
of text, so that no second place says what an order does. Orders with a procedure (ease, shift,
meet, hover, dive, a course to a side) have none.

An effect's writes are done in order; each puts a number at a place of the state by a rule, of which
x is the number of the order [SI], starboard and rise positive:

    const V      V
    number S     S x
    over S       x / S
    place P      what stands at place P
    short P      the angle x, as the turns nearest to the angle at place P
    shorter P    the angle at the written place itself, likewise
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final, NamedTuple

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.plant_effects import (
    ConstantRow,
    breaker_rows,
    bus_rows,
    fight_rows,
    hydraulic_rows,
    isolation_rows,
    load_rows,
    mode_rows,
    ventilation_rows,
)
from trainer.core.autopilot.steering import OWN_LAW, REPORT_LAW, REPORT_LITERAL
from trainer.core.ballast.tanks import BLOWN_TANKS, COMPARTMENTS, NEGATIVE_TANK, TANKS
from trainer.core.state import VALVES
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import SIDE_SIGNS
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.sides import SURFACE_SIDES

SPEED_SLACK: Final = 1e-9  # [m/s] that forgives the rounding of knots
ANGLE_SLACK: Final = 1e-12  # [rad] that forgives the rounding of degrees
SURFACE_NAMES: Final = {"rudder": "rudder", "stern": "stern planes", "bow": "bow planes"}
PLANES: Final = ("stern", "bow")
ZERO_WORDS: Final = {"rudder": "amidships", "stern": "zero", "bow": "zero"}
IN_HAND: Final = "{text}, by hand"  # the answer
DEPTH_LAWS: Final = {
    "trainer": (OWN_LAW, "this trainer's own law"),
    "report": (REPORT_LAW, "the report's law"),
    "literal": (REPORT_LITERAL, "the report's law as it is printed"),
}
MAIN_TANKS: Final = BLOWN_TANKS[:NEGATIVE_TANK]
SPACE_NAMES: Final = tuple(name.removeprefix("compartment_") for name in COMPARTMENTS)


class Write(NamedTuple):
    """One number that is put at a place of the state by a rule."""

    place: int
    rule: str
    argument: float


class NumberRange(NamedTuple):
    """The number of an order: its limits and the size of its unit [SI].

    The size is negative where right and rise are positive and the words say the other. ``turn`` is
    the number typed that counts as 0.
    """

    low: float
    high: float
    size: float
    turn: str = ""


@dataclass(frozen=True)
class Effect:
    """What an order of these words writes, and the answer.

    In the answer {text} is the whole order. ``number`` is None if the order has none.
    """

    words: str
    writes: tuple[Write, ...]
    answer: str
    number: NumberRange | None = None

    def takes(self, x: float) -> bool:
        """Return whether the boat takes a number [SI]; any, if the order has none."""
        return self.number is None or self.number.low <= x <= self.number.high

    def write(self, boat: Boat, x: float) -> None:
        """Write into the boat's state what the order asks for."""
        s = boat.plain
        for place, rule, argument in self.writes:
            if rule == "const":
                s[place] = argument
            elif rule == "number":
                s[place] = argument * x
            elif rule == "over":
                s[place] = x / argument
            elif rule == "place":
                s[place] = s[int(argument)]
            else:
                near, angle = s[int(argument)], x if rule == "short" else s[place]
                s[place] = near + math.remainder(angle - near, math.tau)


def effect_of(boat: Boat, order: Order) -> Effect:
    """Return the effect of an order; KeyError if the boat has none for it."""
    for effect in effects_of_word(boat, order.name):
        if effect.words == order.words:
            return effect
    raise KeyError(order.words)


def write_effect(boat: Boat, order: Order) -> str:
    """Write into the state what an order asks for; return the answer."""
    effect = effect_of(boat, order)
    effect.write(boat, order.value)
    return effect.answer.format(text=order.text)


def effects_of_boat(boat: Boat) -> list[Effect]:
    """Return the effects of all orders that this boat takes."""
    return [effect for name in WORD_EFFECTS for effect in effects_of_word(boat, name)]


class NumberedOrder(NamedTuple):
    """An order by a number [SI]: right, rise, ahead, in and forward are positive."""

    low: float
    high: float
    writes: tuple[Write, ...]


def numbered_orders(boat: Boat) -> dict[str, NumberedOrder]:
    """Return the orders by a number that this boat takes, by name.

    Two orders that write the same places, to one side and to the other, are one. It has the name of
    its surface, or the words of the side that is positive.
    """
    surfaces = {said: name for name, said in SURFACE_NAMES.items()}
    found: dict[tuple[tuple[int, str], ...], str] = {}
    orders: dict[str, NumberedOrder] = {}
    for effect in effects_of_boat(boat):
        if effect.number is None:
            continue
        places = tuple((write.place, write.rule) for write in effect.writes)
        said = effect.words.rpartition(" ")[0]
        name = found.setdefault(places, surfaces.get(said, effect.words))
        low, high, *_ = effect.number
        known = orders.get(name, NumberedOrder(low, high, effect.writes))
        if _sign(known.writes) != _sign(effect.writes):
            low, high = -high, -low
        ends = known.low, known.high, low, high
        orders[name] = NumberedOrder(min(ends) + 0.0, max(ends), known.writes)
    return orders


def _sign(writes: Iterable[Write]) -> float:
    """Return the sign with which the number of an order is written."""
    return next(
        (math.copysign(1.0, each.argument) for each in writes if each.rule == "number"), 1.0
    )


def effects_of_word(boat: Boat, name: str) -> Iterable[Effect]:
    """Return the effects of an order word, none where the boat lacks what it needs."""
    needs = ORDER_WORDS[name].needs
    fitted = {
        "": True,
        "autopilot": boat.automatic,
        "ballast": bool(boat.vessel.fitted),
        "plant": boat.has_plant,
    }
    return WORD_EFFECTS[name](boat) if fitted[needs] else ()


def _effect(
    words: str,
    writes: Mapping[str, tuple[str, float]],
    answer: str = "{text}",
    number: NumberRange | None = None,
) -> Effect:
    """Return an effect of rules by the names of the state's fields."""
    found = (Write(STATE_OFFSETS[name], *rule) for name, rule in writes.items())
    return Effect(words, tuple(found), answer, number)


def _const(value: float) -> tuple[str, float]:
    return "const", float(value)


def _place(name: str) -> tuple[str, float]:
    return "place", STATE_OFFSETS[name]


def _give_to_autopilot(boat: Boat, *names: str) -> dict[str, tuple[str, float]]:
    """Return what gives those surfaces to the autopilot; what the boat lacks is passed over."""
    carried = [name for name in names if boat.carries(name)]
    writes = {f"{name}_by_hand": _const(0.0) for name in carried}
    if "rudder" in carried:
        # the ordered course is steered the short way, however often the boat has turned
        writes["ordered_psi"] = "shorter", STATE_OFFSETS["psi"]
    return writes


def _take_in_hand(*names: str) -> dict[str, tuple[str, float]]:
    """Return what puts those surfaces in hand as they stand."""
    writes: dict[str, tuple[str, float]] = {}
    for name in names:
        letter = SURFACES[name]
        writes |= {f"ordered_{letter}": _place(f"delta_{letter}"), f"{name}_by_hand": _const(1.0)}
    return writes


def _surface(boat: Boat, name: str) -> Iterator[Effect]:
    """Yield the orders to a surface that the boat carries."""
    if not boat.carries(name):
        return
    letter, said, toward = SURFACES[name], SURFACE_NAMES[name], boat.toward[name]
    limit = float(boat.vessel[f"limit_{letter}"])
    unit = NUMBER_KINDS["ANGLE"].units[0].factor
    most = min(limit + ANGLE_SLACK, NUMBER_KINDS["ANGLE"].high * unit)
    held = {f"{name}_by_hand": _const(1.0)}
    for way in SURFACE_SIDES[name]:
        sign = SIDE_SIGNS[way]
        angle = NumberRange(min(sign * most, 0.0), max(sign * most, 0.0), sign * unit)
        put = {f"ordered_{letter}": ("number", toward), **held}
        yield _effect(f"{said} {way}", put, IN_HAND, angle)
        full = _const(toward * sign * limit)
        yield _effect(f"{said} {way} full", {f"ordered_{letter}": full, **held}, IN_HAND)
    zero = {f"ordered_{letter}": _const(toward * 0.0), **held}
    yield _effect(f"{said} {ZERO_WORDS[name]}", zero, IN_HAND)
    yield _effect(f"{said} manual", _take_in_hand(name), f"{said} by hand")
    if boat.automatic:
        yield _effect(f"{said} auto", _give_to_autopilot(boat, name), f"{said} automatic")


def _planes(boat: Boat) -> Iterator[Effect]:
    """Yield the orders to both pairs of planes."""
    level = {"ordered_s": _const(0.0), "ordered_b": _const(0.0)}
    in_hand = {"stern_by_hand": _const(1.0), "bow_by_hand": _const(1.0)}
    yield _effect("planes zero", {**level, **in_hand}, IN_HAND)
    yield _effect("planes manual", _take_in_hand(*PLANES), "planes by hand")
    if boat.automatic:
        carried = " and ".join(SURFACE_NAMES[name] for name in PLANES if boat.carries(name))
        yield _effect("planes auto", _give_to_autopilot(boat, *PLANES), f"{carried} automatic")


def _turns_range(boat: Boat) -> NumberRange:
    """Return the command speeds [m/s] of the propeller."""
    least, most = (float(boat.vessel[name]) for name in ("u_c_astern", "u_c_ahead"))
    return NumberRange(
        least - SPEED_SLACK, most + SPEED_SLACK, NUMBER_KINDS["TURNS"].units[0].factor
    )


def _revolutions(words: str, rule: tuple[str, float], number: NumberRange | None = None) -> Effect:
    """Return an order that holds revolutions."""
    held = {"ordered_u_c": rule, "speed_by_hand": _const(1.0)}
    return _effect(words, held, number=number)


def _turns(boat: Boat) -> Iterator[Effect]:
    yield _revolutions("turns", ("number", 1.0), _turns_range(boat))


def _rpm(boat: Boat) -> Iterator[Effect]:
    rate, turns = boat.file.propulsion.rps_per_mps, _turns_range(boat)
    said, minute = NUMBER_KINDS["RPM"], NUMBER_KINDS["RPM"].units[0].factor
    slowest, fastest = max(turns.low * rate, said.low * minute), said.high * minute
    number = NumberRange(slowest, min(turns.high * rate, fastest), minute)
    yield _revolutions("rpm", ("over", rate), number)


def _bell(boat: Boat) -> Iterator[Effect]:
    """Yield the orders of the boat's telegraph."""
    yield _revolutions("bell stop", _const(0.0))
    for bell, speed in boat.file.propulsion.bells_kn.items():
        way, _, how = bell.partition("_")
        ordered = _const(speed * NUMBER_KINDS["TURNS"].units[0].factor)
        yield _revolutions(f"bell {way} {how.replace('_', '-')}", ordered)


def _keep_depth(boat: Boat) -> dict[str, tuple[str, float]]:
    """Return what lets the planes keep a depth; afloat after a blow, it is the order to leave."""
    return {"ascent": _const(0.0), **_give_to_autopilot(boat, *PLANES)}


def _depth(boat: Boat) -> Iterator[Effect]:
    """Yield the orders to keep a depth, with both pairs of planes automatic."""
    if not boat.automatic:
        return
    depth, deepest = NUMBER_KINDS["DEPTH"], boat.file.hull.max_depth_m
    keel = NumberRange(0.0, depth.high if deepest is None else min(deepest, depth.high), 1.0)
    yield _effect("depth", {"ordered_depth": ("number", 1.0), **_keep_depth(boat)}, number=keel)
    yield _effect("depth auto", _give_to_autopilot(boat, *PLANES))


def _periscope(boat: Boat) -> Iterator[Effect]:
    depth = boat.file.run.periscope_depth_m
    if boat.automatic and depth is not None:
        yield _effect("periscope depth", {"ordered_depth": _const(depth), **_keep_depth(boat)})


def _course(boat: Boat) -> Iterator[Effect]:
    """Yield the orders to keep a course, turning the short way, with the rudder automatic."""
    rudder, course = _give_to_autopilot(boat, "rudder"), NUMBER_KINDS["COURSE"]
    turn = NumberRange(0.0, math.tau, course.units[0].factor, f"{course.high:g}")
    yield _effect("course", {**rudder, "ordered_psi": ("short", STATE_OFFSETS["psi"])}, number=turn)
    yield _effect("course auto", rudder)


def _speed(boat: Boat) -> Iterator[Effect]:
    """Yield the orders to keep a speed; the propeller answers like an engine order."""
    said, automatic = NUMBER_KINDS["SPEED"], {"speed_by_hand": _const(0.0)}
    knot = said.units[0].factor
    fastest = min(float(boat.vessel.u_c_ahead) + SPEED_SLACK, said.high * knot)
    ordered = {"ordered_speed": ("number", 1.0), **automatic}
    yield _effect("speed", ordered, number=NumberRange(0.0, fastest, knot))
    yield _effect("speed auto", automatic)


def _autopilot(boat: Boat) -> Iterator[Effect]:
    """Yield what makes all automatic, puts it in hand, or chooses the law of depth."""
    surfaces = _give_to_autopilot(boat, *SURFACES)
    yield _effect("autopilot on", {**_by_hand(0.0), **surfaces}, "everything automatic")
    engine = {"ordered_u_c": _place("u_c"), **_by_hand(1.0)}
    in_hand = {**_take_in_hand(*SURFACES), **engine}
    yield _effect("autopilot off", in_hand, "everything by hand, as it stands")
    for word, (law, says) in DEPTH_LAWS.items():
        yield _effect(f"autopilot {word}", {"depth_law": _const(law)}, f"depth is kept by {says}")


def _by_hand(value: float) -> dict[str, tuple[str, float]]:
    """Return what puts speed and trim in hand (1), or not (0)."""
    return {"speed_by_hand": _const(value), "trim_by_hand": _const(value)}


def _trim(_boat: Boat) -> Iterator[Effect]:
    yield _effect("trim manual", {"trim_by_hand": _const(1.0)}, "trim by hand")
    automatic = "trim automatic, in steady level flight"
    yield _effect("trim auto", {"trim_by_hand": _const(0.0)}, automatic)


# Tanks and air

TANK_GROUPS: Final = {**{group: (group,) for group in MAIN_TANKS}, "all": MAIN_TANKS}


def _main_ballast(groups: tuple[str, ...], blow: float) -> dict[str, tuple[str, float]]:
    """Return what sets blow valves of groups of main ballast [-], and shuts their vents.

    Both at once, because a vent that stays open lets the air of a blow out.
    """
    blown = {f"blow_{group}": _const(blow) for group in groups}
    return blown | {f"vent_{group}": _const(0.0) for group in groups}


def _blow(_boat: Boat) -> Iterator[Effect]:
    for said, groups in TANK_GROUPS.items():
        answer = f"blowing {' and '.join(groups)} main ballast, vents shut"
        yield _effect(f"blow {said}", _main_ballast(groups, 1.0), answer)
    shut = {f"blow_{valve}": _const(0.0) for valve in VALVES}
    stopped = {**shut, "negative_flood": _const(0.0)}
    yield _effect("blow stop", stopped, "all blow valves shut")


def _emergency(_boat: Boat) -> Iterator[Effect]:
    answer = "emergency blow: all main ballast, both banks"
    yield _effect("emergency blow", _main_ballast(MAIN_TANKS, 2.0), answer)


def _vent(_boat: Boat) -> Iterator[Effect]:
    for said, groups in TANK_GROUPS.items():
        for position, vent in (("open", 1.0), ("shut", 0.0)):
            vents = {f"vent_{group}": _const(vent) for group in groups}
            yield _effect(f"vent {said} {position}", vents, f"{said} main vents {position}")


def _to_the_surface(_boat: Boat) -> Iterator[Effect]:
    up = {"ordered_depth": _const(0.0), "hover": _const(0.0)}
    yield _effect("surface", {**_main_ballast(MAIN_TANKS, 1.0), **up})


def _negative(boat: Boat) -> Iterator[Effect]:
    if holds(boat, "negative"):
        for word, vent, says in (("flood", 1.0, "flooding"), ("blow", 0.0, "being blown")):
            valves = {"vent_negative": _const(vent), "blow_negative": _const(1.0 - vent)}
            opened = {"negative_flood": _const(1.0), **valves}
            yield _effect(f"negative {word}", opened, f"negative tank {says}")


def _tonnes() -> NumberRange:
    amount = NUMBER_KINDS["AMOUNT"]
    tonne = amount.units[0].factor
    return NumberRange(0.0, amount.high * tonne, tonne)


def _moved(boat: Boat, word: str, sign: float) -> Iterator[Effect]:
    """Yield the orders that let water in, or pump it out where ``sign`` is negative."""
    for tank in ("auxiliary", "depth_control"):
        if holds(boat, tank):
            # hovering orders the same pump at every tick
            stands = {"hover": _const(0.0)} if tank == "depth_control" else {}
            moved = {f"move_{tank}": ("number", sign), **stands}
            yield _effect(f"{word} {tank.replace('_', '-')}", moved, number=_tonnes())


def _pump(boat: Boat) -> Iterator[Effect]:
    if holds(boat, "trim_forward"):
        for way, sign in (("forward", 1.0), ("aft", -1.0)):
            moved = {"move_trim": ("number", sign)}
            yield _effect(f"pump trim {way}", moved, "{text}: pumping", _tonnes())
    yield from _moved(boat, "pump", -1.0)


def _drain(boat: Boat) -> Iterator[Effect]:
    for index, space in enumerate(SPACE_NAMES):
        if holds(boat, f"compartment_{space}"):
            yield _effect(f"drain {space}", {"drained": _const(1.0 + index)})
    yield _effect("drain stop", {"drained": _const(0.0)}, "draining stopped")


def _compressor(boat: Boat) -> Iterator[Effect]:
    if boat.vessel.compressor_rate:
        yield _effect("compressor on", {"compressor": _const(1.0)})
        yield _effect("compressor off", {"compressor": _const(0.0)})


def holds(boat: Boat, tank: str) -> bool:
    """Return whether the boat has that tank."""
    return bool(boat.vessel.capacity[TANKS.index(tank)])


def _to_the_plant(boat: Boat, rows: Callable[[Boat], Iterable[ConstantRow]]) -> Iterator[Effect]:
    """Yield the effects of orders to the plant, which is computed from then on."""
    for words, values, answer in rows(boat):
        touched = {name: _const(value) for name, value in {**values, "plant_touched": 1.0}.items()}
        yield _effect(words, touched, answer)


def _planes_mode(boat: Boat) -> Iterator[ConstantRow]:
    for name in PLANES:
        yield from mode_rows(boat, SURFACE_NAMES[name], (name,))
    yield from mode_rows(boat, "planes", PLANES)


PLANT_ROWS: Final[Mapping[str, Callable[[Boat], Iterable[ConstantRow]]]] = {
    "rudder-mode": partial(mode_rows, said="rudder", surfaces=("rudder",)),
    "planes-mode": _planes_mode,
    "isolate": partial(isolation_rows, "isolate", 1.0),
    "open": partial(isolation_rows, "open", 0.0),
    "hydraulic": hydraulic_rows,
    "bus": bus_rows,
    "breaker": breaker_rows,
    "loads": load_rows,
    "ventilation": ventilation_rows,
    "fight": fight_rows,
}
WORD_EFFECTS: Final[Mapping[str, Callable[[Boat], Iterable[Effect]]]] = {
    **{name: partial(_surface, name=name) for name in SURFACES},
    "planes": _planes,
    "turns": _turns,
    "rpm": _rpm,
    "bell": _bell,
    "depth": _depth,
    "periscope": _periscope,
    "course": _course,
    "speed": _speed,
    "autopilot": _autopilot,
    "trim": _trim,
    "blow": _blow,
    "emergency": _emergency,
    "surface": _to_the_surface,
    "vent": _vent,
    "negative": _negative,
    "flood": partial(_moved, word="flood", sign=1.0),
    "pump": _pump,
    "drain": _drain,
    "compressor": _compressor,
    **{word: partial(_to_the_plant, rows=rows) for word, rows in PLANT_ROWS.items()},
}
