"""Orders about tanks and air: valves, pumps, and the boat's standing words surface and dive.

``helm.obey_order`` finds them in ``BALLAST_DUTIES``. An order writes levers and pump orders into
the state; water and air then move in the ticks (``core/ballast``). docs/ballast.md has the table of
what each sets. ``session/crew/crew`` reports by PumpMonitor what pumps have done, and a plan puts
the boat out of trim at its start, because the exercise asks for it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.boat import Boat
from trainer.boat.crew_orders import limit_refusal
from trainer.boat.effects import MAIN_TANKS, SPACE_NAMES, holds, write_effect
from trainer.boat.limits import is_surfacing
from trainer.core.autopilot.ascent import NO_ASCENT, SURFACED_DEPTH
from trainer.core.ballast.ballast import balance
from trainer.core.ballast.hover import MAX_WAY_SPEED, SURE_PUMP_SHARE, is_hovering, wanted_pump
from trainer.core.ballast.tanks import (
    DEPTH_CONTROL_PUMP,
    FIRST_DRY,
    MAIN_BANK,
    PUMPED_TANKS,
    TANKS,
)
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.units import KNOT

TRIM_TANKS: Final = ("trim_forward", "trim_aft")
TANKS_OF: Final = (TRIM_TANKS, ("auxiliary",), ("depth_control",))  # by pump
PUMPED_BY: Final = ("trim", "auxiliary", "depth control")
PUMP_OF: Final = {name: pump for pump, names in enumerate(TANKS_OF) for name in names}
PUMP_DIRECTIONS: Final = {0: ("forward", "aft")}
WAVELESS_DEPTH_M: Final = 300.0  # [m] below all waves
NEAR_M: Final = 5.0  # [m] an estimate
EMPTY_BANK_SHARE: Final = 0.1  # [-] of a full bank: not enough to empty main ballast


def lacking(boat: Boat, order: Order) -> Refused | None:
    """Return that the boat lacks a tank or compressor that it needs, None if not."""
    if not boat.vessel.fitted:
        return Refused(f"{boat.file.path.name} has no [ballast] table: this boat has no tanks")
    if order.name == "compressor" and not boat.vessel.compressor_rate:
        return Refused("this boat has no compressor")
    for name in _needs(order):
        if not holds(boat, name):
            kind = " tank" * (name in PUMPED_TANKS)
            return Refused(f"this boat has no {name.replace('_', ' ')}{kind}")
    return None


def _needs(order: Order) -> tuple[str, ...]:
    """Return the tanks that an order cannot do without."""
    if order.word.startswith("trim"):
        return PUMPED_TANKS[:2]
    if order.name == "drain":
        return () if order.word == "stop" else (f"compartment_{order.word}",)
    named = {"negative": "negative", "hover": "depth_control"}.get(order.name)
    first = named or order.word.removesuffix("_open").removesuffix("_shut")
    return (first,) if first in TANKS else ()


def _move(boat: Boat, order: Order) -> Reply:
    """Move water, within the boat or between it and the sea."""
    hovers = bool(boat.state.hover) and order.word == "depth_control"
    answer = write_effect(boat, order)
    if order.word.startswith("trim"):
        return answer
    waits = _waits_for(boat, order.word, pumps=order.name == "pump")
    return f"{order.text}: {waits or 'under way'}{', hovering off' * hovers}"


def _waits_for(boat: Boat, tank: str, *, pumps: bool) -> str:
    """Return what an order to a pump waits for, "" where it works at once."""
    index = int(boat.state.drained) - 1
    if tank == "auxiliary" and index >= 0:
        return f"waits, its pump drains the {SPACE_NAMES[index]} compartment; drain stop frees it"
    if pumps and boat.state.z >= boat.vessel.shutoff_depth:
        return f"waits, the pump delivers nothing below {boat.vessel.shutoff_depth:g} m"
    return ""


def _drain(boat: Boat, order: Order) -> Reply:
    answer = write_effect(boat, order)
    if order.word == "stop":
        return answer
    tonnes = float(boat.state.water[FIRST_DRY + SPACE_NAMES.index(order.word)]) / 1000.0
    return f"draining the {order.word} compartment, {tonnes:.1f} t in it"


def _compressor(boat: Boat, order: Order) -> Reply:
    answer, reach = write_effect(boat, order), float(boat.vessel.intake_depth)
    if order.word == "on" and float(boat.state.z) > reach:
        return f"compressor on; it has air at {reach:.3g} m or less"
    return answer


def _hover(boat: Boat, order: Order) -> Reply:
    s = boat.state
    if order.word == "off":
        s.hover = s.move_depth_control = 0.0
        return "hovering off"
    depth = float(s.z) if order.word else order.value
    too_deep = None if order.word else limit_refusal(boat, "depth", depth)
    if refusal := too_deep or too_light(boat, depth) or cannot_hover(boat, depth):
        return refusal
    s.hover, s.hover_lost, s.ascent = 1.0, 0.0, 0.0  # the order ends what had given depth up
    s.ordered_depth = depth
    at = "this depth" if order.word else f"{depth:g} m"
    if not is_hovering(boat.records.state):
        return (
            f"hovering below {MAX_WAY_SPEED / KNOT:.0f} knots; until then the planes keep the depth"
        )
    if s.sea_height > 0.0 and s.sea_suction == 0.0:
        return f"hovering at {at}; this sea has no suction, so it is easier than at sea"
    return f"hovering at {at}"


def cannot_hover(boat: Boat, depth: float) -> Refused | None:
    """Return why the depth-control pump cannot hold a depth [m] here, None if it can."""
    records = boat.records
    sure = SURE_PUMP_SHARE * float(boat.vessel.pump_rate[DEPTH_CONTROL_PUMP])
    wanted = wanted_pump(records.vessel, depth, records.state)
    if wanted <= sure:
        return None
    deepest = boat.file.hull.max_depth_m or WAVELESS_DEPTH_M
    for deeper in range(math.ceil(depth), math.floor(deepest) + 1):
        if wanted_pump(records.vessel, float(deeper), records.state) <= sure:
            held = f"go to {deeper} m, or make 3 knots"
            break
    else:
        held = "make 3 knots"
    return Refused(
        f"the pump cannot hold {depth:.0f} m here: waves ask it for {wanted:.0f} kg/s, and it is "
        f"sure of {sure:.0f}; {held}"
    )


def too_light(boat: Boat, depth: float) -> Refused | None:
    """Return why blown main ballast forbids a depth [m], or None.

    It is flown. Open vents fill the tanks again, and the depth-control tank takes what it has room
    for.
    """
    s = boat.state
    if depth <= SURFACED_DEPTH * float(boat.vessel.diameter) or not is_surfacing(boat):
        return None
    light = (float(boat.vessel.buoyancy) - float(s.weight)) / float(boat.vessel.g) / 1000.0
    control = TANKS.index("depth_control")
    blowing = bool(s.blow[: len(MAIN_TANKS)].any())
    if not blowing and 1000.0 * light <= boat.vessel.capacity[control] - s.water[control]:
        return None
    if comes_to(boat, depth):
        return None
    if blowing:
        return Refused(f"main ballast is being blown: {depth:g} m is not kept; dive first")
    return Refused(
        f"main ballast is blown: the boat is {light:.0f} t too light for {depth:g} m; dive first"
    )


def comes_to(boat: Boat, depth: float) -> bool:
    """Return whether the boat, flown, comes to a depth [m].

    Half the way is enough, or NEAR_M.
    """
    there, begun = boat.snapshot(), float(boat.state.z)
    write_effect(boat, Order("depth", depth, "", f"depth {depth:g}", words="depth"))
    reached = boat.foresee("z")
    boat.restore(there)
    return abs(reached - depth) <= max(0.5 * abs(begun - depth), NEAR_M)


def _surface(boat: Boat, order: Order) -> Reply:
    write_effect(boat, order)
    bank = float(boat.state.bank_main / boat.vessel.bank_full[MAIN_BANK])
    if bank < EMPTY_BANK_SHARE:
        return f"surfacing: the main bank has {bank:.0%} of its air; emergency blow has its own"
    level = ", planes level, no depth is kept" if boat.automatic else ""
    return f"surfacing: blowing all main ballast{level}; type blow stop when the boat is up"


def _dive(boat: Boat, _order: Order) -> Reply:
    """Open the vents; keep at least periscope depth, or the planes would hold the boat up."""
    s = boat.state
    for tank in MAIN_TANKS:
        s[f"blow_{tank}"], s[f"vent_{tank}"] = 0.0, 1.0
    s.ordered_depth = max(s.ordered_depth, boat.file.run.periscope_depth_m or 0.0)
    s.ascent = NO_ASCENT
    return f"diving: main vents open, keeping depth {s.ordered_depth:g} m"


BALLAST_DUTIES: Final[dict[str, Callable[[Boat, Order], Reply]]] = {
    "flood": _move,
    "pump": _move,
    "drain": _drain,
    "compressor": _compressor,
    "hover": _hover,
    "surface": _surface,
    "dive": _dive,
}


@dataclass
class PumpMonitor:
    """The orders to the pumps that are to be reported when they are done."""

    asked: dict[int, float] = field(default_factory=dict)  # [kg] by pump
    left: dict[int, float] = field(default_factory=dict)  # [kg] when last looked at
    by: dict[int, str] = field(default_factory=dict)  # who ordered it

    def note(self, boat: Boat, order: Order, by: str) -> None:
        """Take an order that somebody has just given, to report its end to them."""
        pump = PUMP_OF[order.word]
        self.by[pump] = by
        self.asked[pump] = self.left[pump] = float(boat.state.to_move[pump])

    def look(self, boat: Boat) -> list[tuple[str, str]]:
        """Return who gave each order that has ended, and how it ended.

        It is done, or a tank is full or empty.
        """
        news = []
        for pump, amount in list(self.asked.items()):
            now, before = float(boat.state.to_move[pump]), self.left[pump]
            self.left[pump] = now
            if now:
                continue
            del self.asked[pump]
            inward, outward = PUMP_DIRECTIONS.get(pump, ("in", "out"))
            way, whole = inward if amount > 0.0 else outward, abs(amount) / 1000.0
            stops = [name for name in TANKS_OF[pump] if _at_an_end(boat, name)]
            if abs(before) <= float(boat.vessel.pump_rate[pump]) * boat.method.step + 1e-6:
                news.append((self.by[pump], f"{PUMPED_BY[pump]}: {whole:.3g} t {way}"))
            elif stops:
                moved, end = abs(amount - before) / 1000.0, _at_an_end(boat, stops[0])
                says = f"{stops[0].replace('_', ' ')} is {end}"
                news.append((self.by[pump], f"{says}: {moved:.1f} of {whole:.3g} t {way}"))
        return news


def _at_an_end(boat: Boat, tank: str) -> str:
    """Return whether a tank is full or empty, "" for neither."""
    index = TANKS.index(tank)
    water = float(boat.state.water[index])
    if water >= boat.vessel.capacity[index]:
        return "full"
    return "empty" if water <= 0.0 else ""


def put_out_of_trim(boat: Boat, heavy: float, forward: float) -> str:
    """Put the boat out of trim: ``heavy`` [kg], and ``forward`` [kg] moved from aft.

    No tank shows it, because the water stays: what moves are the fillings at which the weight and
    balance of the file hold. Return why it cannot be, "" when it is done.
    """
    wanted = {"depth_control": heavy, "trim_forward": forward, "trim_aft": -forward}
    for name, more in wanted.items():
        index = TANKS.index(name)
        trimmed_water = float(boat.state.water[index]) - more
        if more and not 0.0 <= trimmed_water <= boat.vessel.capacity[index]:
            tank, held = name.replace("_", " "), boat.vessel.capacity[index] / 1000.0
            return f"in trim the {tank} tank would hold {trimmed_water / 1000.0:g} t of {held:g}"
        boat.vessel.start[index] = trimmed_water
    balance(boat.records.vessel, boat.records.state)
    return ""
