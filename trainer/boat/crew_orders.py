"""Orders to the crew stand on its panels until the next. They move nothing by themselves.

``helm`` obeys them here, and screens, debriefs and reference crews read them in the state. A course
is kept as a heading [rad] that is not wrapped at 360 degrees, so that the side of the turn is
known, however often the boat goes round.
"""

import math
from typing import Final, NamedTuple

from trainer.boat.boat import Boat
from trainer.boat.casualties import instrument_readings
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.facts import NO_CREW_FACT, CrewFact, CrewNews
from trainer.units import KNOT

CREW_AXES: Final = ("course", "depth", "speed", "pitch")  # in the order of the state's crew_order
SIDE_SIGNS: Final = {"left": -1.0, "right": 1.0}


class CrewOrder(NamedTuple):
    """An order that stands: its axis, what is ordered [rad, m, m/s], and its tick."""

    axis: str
    value: float
    tick: int
    side: float = 0.0  # of a course: -1 left, 1 right, 0 the shorter way
    unit: float = 1.0  # [m] the unit of the depth, as it was ordered

    def __str__(self) -> str:
        """Return the order in words, as the crew reads it."""
        if self.axis == "course":
            side = {-1.0: "left to ", 1.0: "right to "}.get(self.side, "")
            return f"course {side}{round(math.degrees(self.value)) % 360:03d}"
        if self.axis == "depth":
            unit = "m" if self.unit == 1.0 else "ft"
            return f"depth {round(self.value / self.unit, 1):g} {unit}"
        if self.axis == "speed":
            return f"speed {round(self.value / KNOT, 1):g} kn"
        angle = round(math.degrees(self.value), 1)
        return f"pitch {abs(angle):g} {'up' if angle > 0.0 else 'down'}" if angle else "pitch zero"


def standing_orders(boat: Boat) -> tuple[CrewOrder, ...]:
    """Return the orders to the crew that stand, in the order of CREW_AXES."""
    s = boat.state
    return tuple(
        CrewOrder(
            axis,
            float(s.crew_order[i]),
            int(s.crew_order_tick[i]) - 1,
            float(s.crew_course_side) if axis == "course" else 0.0,
            float(s.crew_depth_unit) if axis == "depth" else 1.0,
        )
        for i, axis in enumerate(CREW_AXES)
        if s.crew_order_tick[i]
    )


def order_crew(boat: Boat, order: Order) -> Reply:
    """Set the order that the crew has, or clear it."""
    what, _, more = order.word.partition("_")
    if what == "clear":
        return _clear(boat, more)
    if what == "course":
        return _order_course(boat, order.value, more)
    if what == "periscope":
        depth = boat.file.run.periscope_depth_m
        if depth is None:
            return Refused(f"{boat.file.path.name} gives no [run] periscope_depth_m: order a depth")
        return _set_standing(boat, "depth", depth)
    return limit_refusal(boat, what, order.value) or _order_amount(boat, what, order)


def _order_amount(boat: Boat, what: str, order: Order) -> str:
    """Let a depth, a speed or an angle stand; "down" is in the word of an angle."""
    if what == "depth":
        return _set_standing(boat, what, order.value, order.unit.factor if order.unit else 1.0)
    return _set_standing(boat, what, -order.value if order.word.endswith("down") else order.value)


def _order_course(boat: Boat, course: float, way: str) -> str:
    """Let a course stand; ``way`` is left, right, "" the shorter, or steady: the heading shown."""
    heading = instrument_readings(boat).heading
    side = SIDE_SIGNS.get(way, 0.0)
    change = 0.0 if way == "steady" else math.remainder(course - heading, math.tau)
    if change * side < 0.0:
        change += side * math.tau
    boat.state.crew_course_side = side
    if way == "steady":
        change = math.radians(round(math.degrees(heading))) - heading
    return _set_standing(boat, "course", heading + change)


def limit_refusal(boat: Boat, what: str, value: float) -> Refused | None:
    """Return why a depth or a speed cannot be ordered, None where it can."""
    deepest = boat.file.hull.max_depth_m
    if what == "depth" and deepest is not None and value > deepest:
        return Refused(f"this boat's greatest depth is {deepest:g} m, not {value:g} m")
    fastest = float(boat.vessel.u_c_ahead)
    if what == "speed" and value > fastest + 1e-9:
        return Refused(f"this boat's greatest speed is {fastest / KNOT:g} kn, not {value / KNOT:g}")
    return None


def _set_standing(boat: Boat, axis: str, value: float, unit: float = 1.0) -> str:
    """Write a standing order to the state; return it in words."""
    index = CREW_AXES.index(axis)
    boat.state.crew_order[index] = value
    boat.state.crew_order_tick[index] = boat.ticks + 1.0
    if axis == "depth":
        boat.state.crew_depth_unit = unit
    return f"ordered: {standing_order(boat, axis)}"


def ordered_fact(boat: Boat, order: Order) -> CrewFact:
    """Return what an order that has just been obeyed orders the crew."""
    if order.name == "tell":
        return CrewFact(CrewNews.ORDERED, order.subject)
    axis = order.word.partition("_")[0].replace("periscope", "depth")
    standing = standing_order(boat, axis) if order.name == "order" and axis in CREW_AXES else None
    return CrewFact(CrewNews.ORDERED, str(standing)) if standing else NO_CREW_FACT


def standing_order(boat: Boat, axis: str) -> CrewOrder | None:
    """Return the order that stands on one axis, None without."""
    return next((each for each in standing_orders(boat) if each.axis == axis), None)


def _clear(boat: Boat, axis: str) -> Reply:
    """Clear one order, or all of them; their numbers in the state become 0."""
    had = [each for each in standing_orders(boat) if axis in (each.axis, "all")]
    for order in had:
        boat.state.crew_order_tick[CREW_AXES.index(order.axis)] = 0.0
        boat.state.crew_order[CREW_AXES.index(order.axis)] = 0.0
    if not had:
        return Refused(f"the crew has no order{'' if axis == 'all' else f' on {axis}'}")
    return f"no longer ordered: {', '.join(map(str, had))}"
