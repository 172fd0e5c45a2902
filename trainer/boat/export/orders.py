"""The orders of a boat in a page that only write numbers: a row each.

A row means what ``trainer.boat.helm`` and ``ballast_orders`` make of the same words, with the
limits, bells and signs of one boat. It is WORDS;LOW;HIGH;FACTOR;TURN;WRITES. LOW to HIGH [SI] bound
x, the number typed after the words times FACTOR; nothing stands there if none is. FACTOR is
negative where right and rise are positive and the words say the other. TURN is the number typed
that counts as 0. WRITES are PLACE=RULE:ARGUMENT, done in order:

    const V      V
    number S     S x
    over S       x / S
    place P      what stands at place P
    short P      the angle x, as the turns nearest to the angle at place P
    shorter P    the angle at PLACE itself, likewise
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from trainer.boat.ballast_orders import MAIN_TANKS, SPACE_NAMES
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import SURFACE_SIDES
from trainer.boat.helm import SURFACE_NAMES
from trainer.core.ballast.tanks import NEGATIVE_TANK, TANKS
from trainer.core.state import VALVES
from trainer.core.surfaces import SURFACES
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import SIDE_SIGNS

SPEED_SLACK: Final = 1e-9  # [m/s] as helm forgives
ZERO_WORDS: Final = {"rudder": "amidships", "stern": "zero", "bow": "zero"}


@dataclass(frozen=True)
class NumberRange:
    """A number of an order.

    It has its limits, the size of its unit [SI], and the number that is 0.
    """

    low: float
    high: float
    factor: float
    turn: str = ""


def order_rows(boat: Boat) -> list[str]:
    """Return the rows of the orders that this boat takes."""
    return [
        *_surfaces(boat),
        *_propeller(boat),
        *(_autopilot_orders(boat) if boat.automatic else ()),
        *(_ballast(boat) if boat.vessel.fitted else ()),
    ]


def _row(words: str, writes: dict[str, str], number: NumberRange | None = None) -> str:
    """Return a row: the words, the rule of each field written, the number typed if there is one."""
    limits = ";;;"
    if number:
        limits = f"{number.low!r};{number.high!r};{number.factor!r};{number.turn}"
    rules = ",".join(f"{STATE_OFFSETS[field]}={rule}" for field, rule in writes.items())
    return f"{words};{limits};{rules}"


def _const(value: float) -> str:
    return f"const:{float(value)!r}"


def _place(name: str) -> str:
    return f"place:{STATE_OFFSETS[name]}"


def _give_to_autopilot(boat: Boat, *names: str) -> dict[str, str]:
    """Return what gives those surfaces to the autopilot; what the boat lacks is passed over."""
    carried = [name for name in names if boat.carries(name)]
    writes = {f"{name}_by_hand": _const(0.0) for name in carried}
    if "rudder" in carried:
        writes["ordered_psi"] = f"shorter:{STATE_OFFSETS['psi']}"
    return writes


def _take_in_hand(*names: str) -> dict[str, str]:
    """Return what puts those surfaces in hand as they stand."""
    writes: dict[str, str] = {}
    for name in names:
        letter = SURFACES[name]
        writes |= {f"ordered_{letter}": _place(f"delta_{letter}"), f"{name}_by_hand": _const(1.0)}
    return writes


def _surfaces(boat: Boat) -> Iterator[str]:
    """Yield the orders to rudder and planes."""
    for name in filter(boat.carries, SURFACES):
        letter, said, toward = SURFACES[name], SURFACE_NAMES[name], boat.toward[name]
        limit = float(boat.vessel[f"limit_{letter}"])
        unit = NUMBER_KINDS["ANGLE"].units[0].factor
        most = min(limit + 1e-12, NUMBER_KINDS["ANGLE"].high * unit)
        held = {f"{name}_by_hand": _const(1.0)}
        for way in SURFACE_SIDES[name]:
            sign = SIDE_SIGNS[way]
            angle = NumberRange(min(sign * most, 0.0), max(sign * most, 0.0), sign * unit)
            yield _row(f"{said} {way}", {f"ordered_{letter}": f"number:{toward!r}", **held}, angle)
            if name == "rudder":
                full = _const(toward * sign * limit)
                yield _row(f"rudder {way} full", {"ordered_r": full, **held})
        yield _row(
            f"{said} {ZERO_WORDS[name]}", {f"ordered_{letter}": _const(toward * 0.0), **held}
        )
        yield _row(f"{said} manual", _take_in_hand(name))
        if boat.automatic:
            yield _row(f"{said} auto", _give_to_autopilot(boat, name))
    yield _row("planes manual", _take_in_hand("stern", "bow"))


def _propeller(boat: Boat) -> Iterator[str]:
    """Yield the orders to the engine room."""
    knot = NUMBER_KINDS["TURNS"].units[0].factor
    c = boat.vessel
    held = {"speed_by_hand": _const(1.0)}
    turns = NumberRange(float(c.u_c_astern) - SPEED_SLACK, float(c.u_c_ahead) + SPEED_SLACK, knot)
    yield _row("turns", {"ordered_u_c": "number:1.0", **held}, turns)
    rate = boat.file.propulsion.rps_per_mps
    said, minute = NUMBER_KINDS["RPM"], NUMBER_KINDS["RPM"].units[0].factor
    slowest, fastest = max(turns.low * rate, said.low * minute), said.high * minute
    revolutions = NumberRange(slowest, min(turns.high * rate, fastest), minute)
    yield _row("rpm", {"ordered_u_c": f"over:{rate!r}", **held}, revolutions)
    yield _row("bell stop", {"ordered_u_c": _const(0.0), **held})
    for bell, speed in boat.file.propulsion.bells_kn.items():
        way, _, how = bell.partition("_")
        bell_order = f"bell {way} {how.replace('_', '-')}"
        yield _row(bell_order, {"ordered_u_c": _const(speed * knot), **held})


def _autopilot_orders(boat: Boat) -> Iterator[str]:
    """Yield the orders that the autopilot carries out."""
    planes = _give_to_autopilot(boat, "stern", "bow")
    everything = {
        "speed_by_hand": _const(0.0),
        "trim_by_hand": _const(0.0),
        **_give_to_autopilot(boat, "rudder", "stern", "bow"),
    }
    depth, course, speed = (NUMBER_KINDS[kind] for kind in ("DEPTH", "COURSE", "SPEED"))
    deepest = boat.file.hull.max_depth_m
    keel = NumberRange(0.0, depth.high if deepest is None else min(deepest, depth.high), 1.0)
    below = {"ascent": _const(0.0), **planes}
    yield _row("depth", {"ordered_depth": "number:1.0", **below}, keel)
    yield _row("depth auto", planes)
    yield _row("planes auto", planes)
    if boat.file.run.periscope_depth_m is not None:
        periscope = _const(boat.file.run.periscope_depth_m)
        yield _row("periscope depth", {"ordered_depth": periscope, **below})
    rudder = _give_to_autopilot(boat, "rudder")
    turn = NumberRange(0.0, math.tau, course.units[0].factor, f"{course.high:g}")
    yield _row("course", {**rudder, "ordered_psi": f"short:{STATE_OFFSETS['psi']}"}, turn)
    yield _row("course auto", rudder)
    knot = speed.units[0].factor
    fastest = min(float(boat.vessel.u_c_ahead) + SPEED_SLACK, speed.high * knot)
    keeping = {"ordered_speed": "number:1.0", "speed_by_hand": _const(0.0)}
    yield _row("speed", keeping, NumberRange(0.0, fastest, knot))
    yield _row("speed auto", {"speed_by_hand": _const(0.0)})
    yield _row("autopilot on", everything)
    hands = _take_in_hand("rudder", "stern", "bow")
    revolutions = {"ordered_u_c": _place("u_c"), "speed_by_hand": _const(1.0)}
    yield _row("autopilot off", {**hands, **revolutions, "trim_by_hand": _const(1.0)})
    yield _row("trim manual", {"trim_by_hand": _const(1.0)})
    yield _row("trim auto", {"trim_by_hand": _const(0.0)})


def _ballast(boat: Boat) -> Iterator[str]:
    """Yield the orders to valves, pumps and compressor that this boat has."""
    # yield the orders to the valves of main ballast
    named = {**{group: (group,) for group in MAIN_TANKS}, "all": MAIN_TANKS}
    for said, groups in named.items():
        yield _row(f"blow {said}", _main(groups, 1.0))
        for position, vent in (("open", 1.0), ("shut", 0.0)):
            vents = {f"vent_{group}": _const(vent) for group in groups}
            yield _row(f"vent {said} {position}", vents)
    shut = {f"blow_{valve}": _const(0.0) for valve in VALVES}
    yield _row("blow stop", {**shut, "negative_flood": _const(0.0)})
    yield _row("emergency blow", _main(MAIN_TANKS, 2.0))
    up = {"ordered_depth": _const(0.0), "hover": _const(0.0)}
    yield _row("surface", {**_main(MAIN_TANKS, 1.0), **up})
    if boat.vessel.capacity[NEGATIVE_TANK]:
        opened = {"negative_flood": _const(1.0)}
        for word, vent, blow in (("flood", 1.0, 0.0), ("blow", 0.0, 1.0)):
            valves = {"vent_negative": _const(vent), "blow_negative": _const(blow)}
            yield _row(f"negative {word}", {**opened, **valves})
    yield from _pumps(boat)
    held = dict(zip(TANKS, boat.vessel.capacity, strict=True))
    for index, space in enumerate(SPACE_NAMES):
        if held[f"compartment_{space}"]:
            yield _row(f"drain {space}", {"drained": _const(1.0 + index)})
    yield _row("drain stop", {"drained": _const(0.0)})
    if boat.vessel.compressor_rate:
        yield _row("compressor on", {"compressor": _const(1.0)})
        yield _row("compressor off", {"compressor": _const(0.0)})


def _main(groups: tuple[str, ...], blow: float) -> dict[str, str]:
    """Return what sets blow valves of groups, and shuts the vents of main ballast."""
    blown = {f"blow_{group}": _const(blow) for group in groups}
    return blown | {f"vent_{group}": _const(0.0) for group in groups}


def _pumps(boat: Boat) -> Iterator[str]:
    """Yield the orders that move water."""
    amount = NUMBER_KINDS["AMOUNT"]
    tonne = amount.units[0].factor
    tonnes = NumberRange(0.0, amount.high * tonne, tonne)
    held = dict(zip(TANKS, boat.vessel.capacity, strict=True))
    if held["trim_forward"]:
        yield _row("pump trim forward", {"move_trim": "number:1.0"}, tonnes)
        yield _row("pump trim aft", {"move_trim": "number:-1.0"}, tonnes)
    for tank in ("auxiliary", "depth_control"):
        if not held[tank]:
            continue
        stands = {"hover": _const(0.0)} if tank == "depth_control" else {}
        for word, sign in (("flood", 1.0), ("pump", -1.0)):
            moved = {f"move_{tank}": f"number:{sign!r}", **stands}
            yield _row(f"{word} {tank.replace('_', '-')}", moved, tonnes)
