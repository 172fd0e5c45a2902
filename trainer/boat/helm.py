"""The orders to a boat, each carried out or refused with the reason.

An order that is refused changes nothing. ``obey_order`` is the one way into the boat for every
order, from a console, a schedule or a call. It writes what is ordered into the state; the boat
begins to move at the next tick.
"""

import math
from collections.abc import Callable
from dataclasses import replace

from trainer.boat import ballast_orders, casualties, crew_orders, sea_orders
from trainer.boat.boat import Boat
from trainer.boat.effects import SURFACE_NAMES, effect_of, write_effect
from trainer.boat.plant_effects import lacking_plant
from trainer.boat.sea_orders import order_sea
from trainer.boat.world.world import WORLD_PARTS
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import BOAT_ORDERS, ORDER_WORDS
from trainer.units import KNOT

MIN_SWING_RATE = math.radians(0.02)  # [rad/s] of yaw, below which there is nothing to meet
MIN_MEETING_RUDDER = math.radians(10.0)  # [rad] of rudder that meets a swing, unless more is on
SWING_MARGIN = math.radians(30.0)  # [rad] an estimate

LEVER_SHARES = {"stern": 0.6, "bow": 1.0}  # [-] of one lever's angle, for each pair of planes


def obey_order(boat: Boat, order: Order) -> Reply:
    """Carry ``order`` out; return what now holds, or why it was refused."""
    word = ORDER_WORDS[order.name]
    if word.needs_autopilot(order.word) and not boat.automatic:
        return _without_autopilot(boat)
    if word.needs == "ballast" and (refusal := ballast_orders.lacking(boat, order)):
        return refusal
    if word.needs == "plant" and not boat.has_plant:
        return lacking_plant(boat)
    return ORDER_DUTIES.get(order.name, _plain_effect)(boat, order)


def _plain_effect(boat: Boat, order: Order) -> Reply:
    """Write what an order asks for that has no function of its own; its words are the answer."""
    try:
        effect = effect_of(boat, order)
    except KeyError:
        return Refused(f"this boat has nothing that obeys `{order.words}`")
    if not effect.takes(order.value) and (number := effect.number):
        ends = sorted((number.low / number.size, number.high / number.size))
        return Refused(f"this boat takes {ends[0]:g} to {ends[1]:g}")
    return write_effect(boat, order)


def _without_autopilot(boat: Boat) -> Refused:
    return Refused(
        f"{boat.file.path.name} has no [autopilot] table: steer by hand, "
        "or add the one that trainer boat gains prints"
    )


def _surface(boat: Boat, order: Order) -> Reply:
    """Put a surface to an angle or in hand, or give it to the autopilot."""
    said = SURFACE_NAMES[order.name]
    if not boat.carries(order.name):
        return Refused(f"this boat has no {said}")
    if order.word in ("ease", "shift", "meet"):
        rudder = _by_the_rudder(boat, order)
        if isinstance(rudder, Refused):
            return rudder
        text = f"rudder {_to_a_side(rudder)}"
        order = replace(order, value=rudder, text=text, words=text.rpartition(" ")[0])
    if not effect_of(boat, order).takes(order.value):
        limit = math.degrees(boat.vessel[f"limit_{SURFACES[order.name]}"])
        asked = math.degrees(abs(order.value))
        return Refused(f"the limit of the {said} is {limit:g} degrees, not {asked:g}")
    return write_effect(boat, order)


def _by_the_rudder(boat: Boat, order: Order) -> float | Refused:
    """Return the rudder [rad] that ease, shift or meet asks for, right positive.

    The session's crew puts the rudder of ``meet`` amidships once the swing stops.
    """
    s = boat.state
    angle = boat.toward["rudder"] * float(s.ordered_r if s.rudder_by_hand else s.delta_r)
    if order.word == "meet":
        if abs(s.psidot) < MIN_SWING_RATE:
            return Refused("the boat does not swing: there is nothing to meet")
        most = float(boat.vessel.limit_r)
        return -math.copysign(min(max(abs(angle), MIN_MEETING_RUDDER), most), float(s.psidot))
    if abs(angle) < 1e-9:
        return Refused(f"the rudder is amidships: nothing to {order.word}")
    if order.word == "shift":
        return -angle
    if order.value > abs(angle) + 1e-9:
        return Refused(
            f"the rudder is {_to_a_side(angle)}: "
            f"ease it to less than that, not {math.degrees(order.value):g}"
        )
    return math.copysign(order.value, angle)


def _to_a_side(angle: float) -> str:
    """Return a rudder angle [rad] in words."""
    return f"{'right' if angle > 0.0 else 'left'} {math.degrees(abs(angle)):.3g}"


def _lever(boat: Boat, order: Order) -> Reply:
    """Both pairs of planes by hand, by one lever; each stops at its own limit."""
    carried = [surface for surface in LEVER_SHARES if boat.carries(surface)]
    if not carried:
        return Refused("this boat has no planes")
    for surface in carried:
        limit = float(boat.vessel[f"limit_{SURFACES[surface]}"])
        angle = min(max(LEVER_SHARES[surface] * order.value, -limit), limit)
        boat.state[f"ordered_{SURFACES[surface]}"] = boat.toward[surface] * angle
        boat.state[f"{surface}_by_hand"] = 1.0
    return f"{order.text}, by hand"


def _depth(boat: Boat, order: Order) -> Reply:
    """Keep a depth, with both pairs of planes automatic."""
    if order.word != "auto" and (refusal := crew_orders.limit_refusal(boat, "depth", order.value)):
        return refusal
    if not boat.automatic:
        return _without_autopilot(boat)
    depth = float(boat.state.ordered_depth) if order.word == "auto" else order.value
    if refusal := ballast_orders.too_light(boat, depth):
        return refusal
    astern = boat.state.u < 0.0 and not boat.state.hover
    if astern and not ballast_orders.comes_to(boat, depth):
        return Refused(f"going astern the planes do not bring her to {depth:g} m: go ahead first")
    # hovering, the pump has to hold the new depth, where waves may ask more than it gives
    if order.word != "auto" and boat.state.hover:
        refusal = ballast_orders.cannot_hover(boat, order.value)
        if refusal:
            return refusal
    write_effect(boat, order)
    return f"keeping depth {boat.state.ordered_depth:g} m"


def _periscope(boat: Boat, order: Order) -> Reply:
    """Keep the boat's own periscope depth."""
    depth = boat.file.run.periscope_depth_m
    if depth is None:
        return Refused(f"{boat.file.path.name} gives no [run] periscope_depth_m: order a depth")
    return _depth(boat, replace(order, value=depth))


def _steer(boat: Boat, order: Order) -> Reply:
    """Keep a course, or refuse it to a boat that swings astern as no rudder stops her.

    It is flown: such a boat is then further from the course than she began.
    """
    s = boat.state
    if boat.astern_pace == 0.0:
        return COURSE_DUTIES[order.name](boat, order)
    there, begun = boat.snapshot(), float(s.psi)
    answer, kept = COURSE_DUTIES[order.name](boat, order), float(s.ordered_psi)
    if abs(boat.foresee("psi") - kept) <= abs(begun - kept) + SWING_MARGIN:
        return answer
    boat.restore(there)
    return Refused("going astern the rudder does not stop her swing: go ahead first")


def _course(boat: Boat, order: Order) -> str:
    """Keep a course, turning the short way, with the rudder automatic."""
    if order.word != "steady":
        write_effect(boat, order)
    else:  # the course that the helmsman reads; a broken gyro deceives him
        _steer_by_autopilot(boat)
        boat.state.ordered_psi = casualties.instrument_readings(boat).heading
    return f"keeping course {_degrees(boat.state.ordered_psi)}"


def _steer_by_autopilot(boat: Boat) -> None:
    """Give the rudder to the autopilot, which keeps the course that is ordered."""
    write_effect(boat, Order("course", 0.0, "auto", "course auto", words="course auto"))


def _course_to(boat: Boat, order: Order) -> str:
    """Keep a course, turning the way ordered, with the rudder automatic."""
    side, start = order.side, boat.state.psi
    _steer_by_autopilot(boat)
    # a whole turn more where the short way is to the other side than the one ordered
    change = math.remainder(abs(order.value) - start, math.tau)
    boat.state.ordered_psi = start + change + (side * math.tau if change * side < 0.0 else 0.0)
    return f"{order.text}: keeping course {_degrees(boat.state.ordered_psi)}"


def _course_by(boat: Boat, order: Order) -> str:
    """Change the course kept, or the heading if the rudder is by hand, the way ordered."""
    s = boat.state
    # by hand it is the compass that the change starts from
    start = casualties.instrument_readings(boat).heading if s.rudder_by_hand else s.ordered_psi
    _steer_by_autopilot(boat)
    s.ordered_psi = start + order.value
    return f"{order.text}: keeping course {_degrees(s.ordered_psi)}"


def _degrees(angle: float) -> str:
    """Return an angle [rad] as a course, 000 to 359."""
    return f"{round(math.degrees(angle)) % 360:03d}"


def _speed(boat: Boat, order: Order) -> Reply:
    """Keep a speed; the propeller answers like an engine order."""
    refusal = order.word != "auto" and crew_orders.limit_refusal(boat, "speed", order.value)
    if refusal:
        return refusal
    write_effect(boat, order)
    return f"keeping speed {boat.state.ordered_speed / KNOT:g} kn"


def _revolutions(boat: Boat, order: Order) -> Reply:
    """Hold the revolutions of a command speed, of revolutions a minute or of a bell."""
    c, bells, per_mps = boat.vessel, boat.file.propulsion.bells_kn, boat.file.propulsion.rps_per_mps
    if order.name == "bell" and order.word not in ("stop", *bells):
        known = ", ".join(name.replace("_", " ") for name in bells)
        return Refused(f"this boat's telegraph has {known} and stop")
    effect = effect_of(boat, order)
    if not effect.takes(order.value):
        per_knot = per_mps * KNOT * 60.0
        return Refused(
            f"turns must be {c.u_c_astern / KNOT:g} to {c.u_c_ahead / KNOT:g} kn, "
            f"{c.u_c_astern / KNOT * per_knot:.0f} to {c.u_c_ahead / KNOT * per_knot:.0f} rpm"
        )
    effect.write(boat, order.value)
    said = "" if order.name == "turns" else f"{order.text}: "
    answer = f"{said}turns for {boat.state.ordered_u_c / KNOT:.3g} kn"
    if boat.state.ordered_u_c < 0.0 and _loses_depth(boat):
        return f"{answer}; astern no depth is kept"
    return answer


def _loses_depth(boat: Boat) -> bool:
    """Return whether the planes, which are to keep a depth, do not as the boat is ordered."""
    s = boat.state
    keeps = boat.automatic and not (s.hover or s.ascent or (s.stern_by_hand and s.bow_by_hand))
    return bool(keeps and not ballast_orders.comes_to(boat, float(s.ordered_depth)))


COURSE_DUTIES = {"course": _course, "course-to": _course_to, "course-by": _course_by}
# What obeys an order that does more than write its effect, or answers in other words.
ORDER_DUTIES: dict[str, Callable[[Boat, Order], Reply]] = {
    **dict.fromkeys(
        WORLD_PARTS.keys() & BOAT_ORDERS, lambda boat, order: boat.world.obey(order, boat.ticks)
    ),
    "depth": _depth,
    **dict.fromkeys(COURSE_DUTIES, _steer),
    "speed": _speed,
    "turns": _revolutions,
    "rpm": _revolutions,
    "bell": _revolutions,
    "rudder": _surface,
    "stern": _surface,
    "bow": _surface,
    "lever": _lever,
    "periscope": _periscope,
    "order": crew_orders.order_crew,
    "sea": order_sea,
    "casualty": lambda boat, order: casualties.insert_casualty(
        boat, *casualties.ordered_casualty(order)
    ),
    "clear": lambda boat, order: casualties.clear_casualty(boat, order.subject),
    "hold": sea_orders.hold_part,
    "release": sea_orders.release_part,
    **ballast_orders.BALLAST_DUTIES,
}
