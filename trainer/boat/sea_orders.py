"""The orders that change the sea over a ramp, or freeze part of the boat.

``helm`` calls them for the orders ``sea``, ``hold`` and ``release``. A sea changes over some time,
as a real one does. A frozen part stands still until it is released, while all else goes on.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.config.world.sea import Sea, peak_frequency, significant_height, step_problem
from trainer.core.kernel import Numbers
from trainer.core.sea.sea import DIRECTION, GAMMA, HEIGHT, OMEGA, PEAKED
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.units import KNOT

FREEZABLE_PARTS: Final = ("depth", "position", "tanks")


def order_sea(boat: Boat, order: Order) -> Reply:
    """Raise, turn or calm the sea."""
    wanted = standing_sea(boat)
    if order.word == "from":
        wanted[DIRECTION] = order.value + math.pi
    elif order.word == "calm":
        wanted[HEIGHT] = 0.0
    else:
        # write height, period and peakedness of ``sea``
        sea = fully_developed(boat.sea.sea, order.word, order.value)
        wanted[HEIGHT] = significant_height(sea, boat.vessel.g)
        wanted[OMEGA] = peak_frequency(sea, boat.vessel.g)
        wanted[GAMMA], wanted[PEAKED] = 1.0, 0.0
    if refused := step_problem(wanted, boat.method.step):
        return refused
    boat.order_sea(wanted, boat.sea.sea.ramp_s)
    return f"{order.text}: {sea_text(wanted)}, within {boat.sea.sea.ramp_s:g} s"


def standing_sea(boat: Boat) -> Numbers:
    """Return the sea [SI] that is ordered, as ``Boat.order_sea`` takes it."""
    s = boat.state
    return np.array([*s.sea_target, s.sea_taper])


def fully_developed(sea: Sea, measure: str, value: float) -> Sea:
    """Return ``sea`` as a wind raises it that blows long enough, by one measure [SI]."""
    measures = {
        "state": {"sea_state": value},
        "wind": {"wind_kn": value / KNOT},
        "height": {"height_m": value},
    }
    bare = replace(
        sea,
        sea_state=None,
        wind_kn=None,
        height_m=None,
        period_s=None,
        spectrum="pierson-moskowitz",
    )
    return replace(bare, **measures[measure])  # type: ignore[arg-type]  # all of them numbers


def sea_text(quantities: Numbers) -> str:
    """Return a sea in words."""
    if quantities[HEIGHT] == 0.0:
        return "calm"
    origin = round(math.degrees(quantities[DIRECTION]) + 180.0) % 360
    period = 2.0 * math.pi / quantities[OMEGA]
    return f"{quantities[HEIGHT]:.3g} m, peak at {period:.1f} s, from {origin:03d}"


def hold_part(boat: Boat, order: Order) -> Reply:
    """Freeze the part that is the order's word from the next tick on."""
    if order.word == "tanks" and not boat.vessel.fitted:
        return Refused(f"{boat.file.path.name} has no [ballast] table: this boat has no tanks")
    boat.state[f"held_{order.word}"] = 1.0
    return f"{order.word} frozen{_where(boat, order.word)}"


def release_part(boat: Boat, order: Order) -> Reply:
    """Release the part that is the order's word, or ``all`` that is frozen."""
    frozen = parts_held(boat)
    parts = frozen if order.word == "all" else [order.word]
    if order.word != "all" and order.word not in frozen:
        return Refused(f"{order.word} is not frozen; frozen: {', '.join(frozen) or 'nothing'}")
    for part in parts:
        boat.state[f"held_{part}"] = 0.0
    return f"{' and '.join(parts)} released" if parts else "nothing is frozen"


def parts_held(boat: Boat) -> list[str]:
    """Return the parts that stand still."""
    return [part for part in FREEZABLE_PARTS if boat.state[f"held_{part}"]]


def describe_held(boat: Boat) -> str:
    """Return what stands still and where, in words."""
    return ", ".join(f"{part}{_where(boat, part)}" for part in parts_held(boat))


def _where(boat: Boat, part: str) -> str:
    """Return where a part stands, '' for one that is nowhere."""
    s = boat.state
    words = {
        "depth": f" at {s.z:.1f} m",
        "position": f" at {s.x:.0f} m north, {s.y:.0f} m east of the start",
    }
    return words.get(part, "")
