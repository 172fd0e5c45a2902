"""The quantities of conditions, as they truly are on a boat at this moment."""

import math

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import scale_of
from trainer.boat.grounding import clearance
from trainer.boat.limits import height_showing, is_deep
from trainer.boat.readings import read_rates
from trainer.boat.world.scope import eye_height
from trainer.config.exercise.condition import STATE_QUANTITIES
from trainer.config.exercise.derived import Condition


def is_met(condition: Condition, boat: Boat) -> bool:
    """Return whether a condition holds now; False if the boat lacks its quantity."""
    value = quantity_of(boat, condition.quantity)
    beyond = condition.sense * (value - condition.threshold)
    return beyond > 0.0 if condition.strict else beyond >= 0.0


def quantity_of(boat: Boat, name: str) -> float:
    """Return the true value of a condition's quantity [SI]. NaN if the boat lacks it."""
    if name == "showing":
        return -math.inf if is_deep(boat) else height_showing(boat)
    if measure := {"eye": eye_height, "clearance": clearance}.get(name):
        return measure(boat)
    if name == "course":
        return boat.plain[STATE_OFFSETS["psi"]] % math.tau
    if name == "heavy":
        vessel = boat.vessel
        return (boat.plain[STATE_OFFSETS["weight"]] - float(vessel.buoyancy)) / float(vessel.g)
    if name == "speed_over_ground":
        return float(read_rates(lambda name: boat.plain[STATE_OFFSETS[name]]).way)
    factor = scale_of(boat, name)
    return boat.plain[STATE_OFFSETS[STATE_QUANTITIES[name].field]] / factor if factor else math.nan
