"""Orders about the sea. They keep what they do not say, and take the sea's ramp to come about."""

import math
from dataclasses import replace

import numpy as np

from trainer.boat import Boat
from trainer.core.kernel import Numbers
from trainer.core.seaway import DIRECTION, GAMMA, HEIGHT, OMEGA
from trainer.files.sea_file import Sea, peak_frequency, significant_height
from trainer.io.orders import Order
from trainer.reply import Reply
from trainer.units import KNOT


def order_sea(boat: Boat, order: Order) -> Reply:
    """Raise, turn or calm the sea."""
    wanted = standing_sea(boat)
    if order.word == "from":
        wanted[DIRECTION] = order.value + math.pi
    elif order.word == "calm":
        wanted[HEIGHT] = 0.0
    else:
        _raise(wanted, fully_developed(boat.sea.sea, order.word, order.value), boat.vessel.g)
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


def _raise(wanted: Numbers, sea: Sea, g: float) -> None:
    """Write height, period and peakedness of ``sea``."""
    wanted[HEIGHT] = significant_height(sea, g)
    wanted[OMEGA] = peak_frequency(sea, g)
    wanted[GAMMA] = 1.0


def sea_text(quantities: Numbers) -> str:
    """Return a sea in words."""
    if quantities[HEIGHT] == 0.0:
        return "calm"
    origin = round(math.degrees(quantities[DIRECTION]) + 180.0) % 360
    period = 2.0 * math.pi / quantities[OMEGA]
    return f"{quantities[HEIGHT]:.3g} m, peak at {period:.1f} s, from {origin:03d}"
