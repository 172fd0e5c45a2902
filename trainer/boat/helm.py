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
from trainer.boat.sea_orders import order_sea
from trainer.boat.world.world import WORLD_PARTS
from trainer.core.autopilot.steering import OWN_LAW, REPORT_LAW, REPORT_LITERAL
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.units import KNOT

DEPTH_LAWS = {
    "trainer": (OWN_LAW, "this trainer's own law"),
    "report": (REPORT_LAW, "the report's law"),
    "literal": (REPORT_LITERAL, "the report's law as it is printed"),
}
MIN_SWING_RATE = math.radians(0.02)  # [rad/s] of yaw, below which there is nothing to meet
MIN_MEETING_RUDDER = math.radians(10.0)  # [rad] of rudder that meets a swing, unless more is on
SURFACE_NAMES = {"rudder": "rudder", "stern": "stern planes", "bow": "bow planes"}

# What the autopilot alone can do. "depth" is not here, because a depth too deep for the boat is
# refused before the lack of an autopilot.
AUTOPILOT_WORDS = frozenset({"course", "course-to", "course-by", "speed", "autopilot", "trim"})
LEVER_SHARES = {"stern": 0.6, "bow": 1.0}  # [-] of one lever's angle, for each pair of planes


def obey_order(boat: Boat, order: Order) -> Reply:
    """Carry ``order`` out; return what now holds, or why it was refused."""
    if order.name in AUTOPILOT_WORDS and not boat.automatic:
        return _without_autopilot(boat)
    return _DUTIES[order.name](boat, order)


def _without_autopilot(boat: Boat) -> Refused:
    return Refused(
        f"{boat.file.path.name} has no [autopilot] table: steer by hand, "
        "or add the one that trainer boat gains prints"
    )


def _by_hand(boat: Boat, surface: str, angle: float) -> None:
    boat.state[f"ordered_{SURFACES[surface]}"] = angle
    boat.state[f"{surface}_by_hand"] = 1.0


def _surface(boat: Boat, order: Order) -> Reply:
    """Put a surface to an angle or in hand, or give it to the autopilot."""
    sign = boat.toward[order.name]
    limit = float(boat.vessel[f"limit_{SURFACES[order.name]}"])
    if not boat.carries(order.name):
        return Refused(f"this boat has no {SURFACE_NAMES[order.name]}")
    if order.word == "auto":
        return _automatic(boat, order.name)
    if order.word == "manual":
        _by_hand(boat, order.name, float(boat.state[f"delta_{SURFACES[order.name]}"]))
        return f"{SURFACE_NAMES[order.name]} by hand"
    text, angle = order.text, order.value
    if order.word in ("ease", "shift", "meet"):
        rudder = _by_the_rudder(boat, order)
        if isinstance(rudder, Refused):
            return rudder
        text, angle = f"rudder {_to_a_side(rudder)}", rudder
    if order.word == "full":
        angle = math.copysign(limit, angle)
    if abs(angle) > limit + 1e-12:  # forgives the rounding of degrees
        return Refused(
            f"the limit of the {SURFACE_NAMES[order.name]} is {math.degrees(limit):g} degrees, "
            f"not {math.degrees(abs(angle)):g}"
        )
    _by_hand(boat, order.name, sign * angle)
    return f"{text}, by hand"


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


def _automatic(boat: Boat, *surfaces: str) -> Reply:
    """Give surfaces to the autopilot; one the boat lacks is passed over."""
    if not boat.automatic:
        return _without_autopilot(boat)
    s = boat.state
    carried = [surface for surface in surfaces if boat.carries(surface)]
    for surface in carried:
        s[f"{surface}_by_hand"] = 0.0
    if "rudder" in carried:
        # the ordered course is steered the short way, however often the boat has turned
        s.ordered_psi = s.psi + math.remainder(s.ordered_psi - s.psi, math.tau)
    return " and ".join(SURFACE_NAMES[surface] for surface in carried) + " automatic"


def _planes(boat: Boat, order: Order) -> Reply:
    """Both pairs of planes by hand, or automatic."""
    if order.word == "auto":
        return _automatic(boat, "stern", "bow")
    zero = order.word == "zero"
    for surface in ("stern", "bow"):
        angle = 0.0 if zero else float(boat.state[f"delta_{SURFACES[surface]}"])
        _by_hand(boat, surface, angle)
    return "planes zero, by hand" if zero else "planes by hand"


def _lever(boat: Boat, order: Order) -> Reply:
    """Both pairs of planes by hand, by one lever; each stops at its own limit."""
    carried = [surface for surface in LEVER_SHARES if boat.carries(surface)]
    if not carried:
        return Refused("this boat has no planes")
    for surface in carried:
        limit = float(boat.vessel[f"limit_{SURFACES[surface]}"])
        angle = min(max(LEVER_SHARES[surface] * order.value, -limit), limit)
        _by_hand(boat, surface, boat.toward[surface] * angle)
    return f"{order.text}, by hand"


def _depth(boat: Boat, order: Order) -> Reply:
    """Keep a depth, with both pairs of planes automatic."""
    if order.word != "auto" and (refusal := crew_orders.limit_refusal(boat, "depth", order.value)):
        return refusal
    if not boat.automatic:
        return _without_autopilot(boat)
    # hovering, the pump has to hold the new depth, where waves may ask more than it gives
    if order.word != "auto" and boat.state.hover:
        refusal = ballast_orders.cannot_hover(boat, order.value)
        if refusal:
            return refusal
    if order.word != "auto":
        boat.state.ordered_depth = order.value
        boat.state.ascent = 0.0  # afloat after a blow, this is the order to leave it
    _automatic(boat, "stern", "bow")
    return f"keeping depth {boat.state.ordered_depth:g} m"


def _periscope(boat: Boat, order: Order) -> Reply:
    """Keep the boat's own periscope depth."""
    depth = boat.file.run.periscope_depth_m
    if depth is None:
        return Refused(f"{boat.file.path.name} gives no [run] periscope_depth_m: order a depth")
    return _depth(boat, replace(order, value=depth))


def _course(boat: Boat, order: Order) -> Reply:
    """Keep a course, turning the short way, with the rudder automatic."""
    s = boat.state
    _automatic(boat, "rudder")
    if order.word == "steady":  # the course that the helmsman reads; a broken gyro deceives him
        s.ordered_psi = casualties.instrument_readings(boat).heading
    elif order.word != "auto":
        s.ordered_psi = s.psi + math.remainder(order.value - s.psi, math.tau)
    return f"keeping course {_degrees(s.ordered_psi)}"


def _course_to(boat: Boat, order: Order) -> Reply:
    """Keep a course, turning the way ordered, with the rudder automatic."""
    side, start = order.side, boat.state.psi
    _automatic(boat, "rudder")
    # a whole turn more where the short way is to the other side than the one ordered
    change = math.remainder(abs(order.value) - start, math.tau)
    boat.state.ordered_psi = start + change + (side * math.tau if change * side < 0.0 else 0.0)
    return f"{order.text}: keeping course {_degrees(boat.state.ordered_psi)}"


def _course_by(boat: Boat, order: Order) -> Reply:
    """Change the course kept, or the heading if the rudder is by hand, the way ordered."""
    s = boat.state
    # by hand it is the compass that the change starts from
    start = casualties.instrument_readings(boat).heading if s.rudder_by_hand else s.ordered_psi
    _automatic(boat, "rudder")
    s.ordered_psi = start + order.value
    return f"{order.text}: keeping course {_degrees(s.ordered_psi)}"


def _degrees(angle: float) -> str:
    """Return an angle [rad] as a course, 000 to 359."""
    return f"{round(math.degrees(angle)) % 360:03d}"


def _speed(boat: Boat, order: Order) -> Reply:
    """Keep a speed; the propeller answers like an engine order."""
    s = boat.state
    if order.word != "auto":
        if refusal := crew_orders.limit_refusal(boat, "speed", order.value):
            return refusal
        s.ordered_speed = order.value
    s.speed_by_hand = 0.0
    return f"keeping speed {s.ordered_speed / KNOT:g} kn"


def _revolutions(boat: Boat, u_c: float, said: str) -> Reply:
    """Hold the revolutions of command speed ``u_c`` [m/s]."""
    c, s = boat.vessel, boat.state
    if not c.u_c_astern - 1e-9 <= u_c <= c.u_c_ahead + 1e-9:
        per_knot = boat.file.propulsion.rps_per_mps * KNOT * 60.0
        return Refused(
            f"turns must be {c.u_c_astern / KNOT:g} to {c.u_c_ahead / KNOT:g} kn, "
            f"{c.u_c_astern / KNOT * per_knot:.0f} to {c.u_c_ahead / KNOT * per_knot:.0f} rpm"
        )
    s.ordered_u_c = u_c
    s.speed_by_hand = 1.0
    return f"{said}turns for {u_c / KNOT:.3g} kn"


def _bell(boat: Boat, order: Order) -> Reply:
    if order.word == "stop":
        return _revolutions(boat, 0.0, f"{order.text}: ")
    bells = boat.file.propulsion.bells_kn
    if order.word not in bells:
        known = ", ".join(name.replace("_", " ") for name in bells)
        return Refused(f"this boat's telegraph has {known} and stop")
    return _revolutions(boat, bells[order.word] * KNOT, f"{order.text}: ")


def _autopilot(boat: Boat, order: Order) -> Reply:
    """Everything automatic or by hand, or another law of depth keeping."""
    s = boat.state
    if order.word in DEPTH_LAWS:
        s.depth_law, law = DEPTH_LAWS[order.word]
        return f"depth is kept by {law}"
    if order.word == "on":
        s.speed_by_hand = s.trim_by_hand = 0.0
        _automatic(boat, "rudder", "stern", "bow")
        return "everything automatic"
    for surface, letter in SURFACES.items():
        _by_hand(boat, surface, float(s[f"delta_{letter}"]))
    s.ordered_u_c, s.speed_by_hand, s.trim_by_hand = s.u_c, 1.0, 1.0
    return "everything by hand, as it stands"


def _trim(boat: Boat, order: Order) -> Reply:
    """Leave trim to the pumps and what the planes show, or to hands."""
    boat.state.trim_by_hand = float(order.word == "manual")
    return "trim by hand" if order.word == "manual" else "trim automatic, in steady level flight"


_DUTIES: dict[str, Callable[[Boat, Order], Reply]] = {
    **dict.fromkeys(WORLD_PARTS, lambda boat, order: boat.world.obey(order, boat.ticks)),
    "depth": _depth,
    "course": _course,
    "course-by": _course_by,
    "course-to": _course_to,
    "speed": _speed,
    "turns": lambda boat, order: _revolutions(boat, order.value, ""),
    "rpm": lambda boat, order: _revolutions(
        boat, order.value / boat.file.propulsion.rps_per_mps, f"{order.text}: "
    ),
    "bell": _bell,
    "rudder": _surface,
    "stern": _surface,
    "bow": _surface,
    "planes": _planes,
    "lever": _lever,
    "autopilot": _autopilot,
    "periscope": _periscope,
    "trim": _trim,
    "order": crew_orders.order_crew,
    "sea": order_sea,
    "casualty": lambda boat, order: casualties.insert_casualty(
        boat, *casualties.ordered_casualty(order)
    ),
    "clear": lambda boat, order: casualties.clear_casualty(boat, order.subject),
    "hold": sea_orders.hold_part,
    "release": sea_orders.release_part,
    **dict.fromkeys(ballast_orders.ORDERS, ballast_orders.order_ballast),
}
