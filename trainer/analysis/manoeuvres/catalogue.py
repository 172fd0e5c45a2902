"""The manoeuvres by name, as an engineer asks for them."""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from trainer.analysis.manoeuvres.flight import Manoeuvre
from trainer.analysis.manoeuvres.speeds import Acceleration, CrashStop, UtmostAcceleration
from trainer.analysis.manoeuvres.spiral import PullOut, ReverseSpiral, Spiral
from trainer.analysis.manoeuvres.turns import ClimbingTurn, Turn
from trainer.analysis.manoeuvres.vehicle import Vehicle, limit
from trainer.analysis.manoeuvres.vertical import (
    Impulse,
    Meander,
    Overshoot,
    RollDecay,
    RudderImpulse,
    TrimChange,
)
from trainer.analysis.manoeuvres.zigzag import VerticalZigZag, ZigZag
from trainer.config.files import ConfigError, nearest

MANOEUVRES: Final[Mapping[str, Manoeuvre]] = MappingProxyType(
    {
        # of 1969, the program CONTR
        "meander": Meander(),
        "overshoot": Overshoot(),
        "turn": Turn(),
        "climbing-turn": ClimbingTurn(),
        "acceleration": Acceleration(),
        "utmost-acceleration": UtmostAcceleration(),
        "trim": TrimChange(),
        "impulse": Impulse(),
        "rudder-impulse": RudderImpulse(),
        # of today
        "turning-circle": Turn(angle_deg=35.0, duration_s=400.0),
        "zigzag-10": ZigZag(angle_deg=10.0, execute_deg=10.0),
        "zigzag-20": ZigZag(),
        "pull-out": PullOut(),
        "spiral": Spiral(),
        "reverse-spiral": ReverseSpiral(),
        "vertical-zigzag": VerticalZigZag(),
        "crash-stop": CrashStop(),
        "roll-decay": RollDecay(),
    }
)


def find_manoeuvre(name: str) -> Manoeuvre:
    """Return the manoeuvre of that name; ConfigError if there is none."""
    if name not in MANOEUVRES:
        known = ", ".join(MANOEUVRES)
        raise ConfigError(f"no manoeuvre {name!r}{nearest(name, MANOEUVRES)}; there are {known}")
    return MANOEUVRES[name]


PARAMETERS: Final = {"angle": "angle_deg", "execute": "execute_deg", "duration": "duration_s"}


def parameters(manoeuvre: Manoeuvre) -> dict[str, float]:
    """Return the numbers of a manoeuvre by the names an engineer gives them, [deg] and [s]."""
    return {
        name: getattr(manoeuvre, field)
        for name, field in PARAMETERS.items()
        if hasattr(manoeuvre, field)
    }


def within_limits(manoeuvre: Manoeuvre, vehicle: Vehicle) -> Manoeuvre:
    """Return the manoeuvre with an angle that the vehicle's control can go to."""
    given = parameters(manoeuvre)
    if "angle" not in given or not manoeuvre.needs or manoeuvre.needs[0] not in vehicle.controls:
        return manoeuvre
    most = round(math.degrees(limit(vehicle, manoeuvre.needs[0])), 9)
    if given["angle"] <= most:
        return manoeuvre
    return replace(manoeuvre, angle_deg=most)  # type: ignore[call-arg]


def adjust(name: str, vehicle: Vehicle, given: Mapping[str, float]) -> Manoeuvre:
    """Return the manoeuvre of that name for a vehicle, with the parameters ``given``.

    ConfigError if it has no such parameter, or the vehicle's control does not go so far.
    """
    manoeuvre = within_limits(find_manoeuvre(name), vehicle)
    known = parameters(manoeuvre)
    for parameter, value in given.items():
        if parameter not in known:
            has = ", ".join(known) or "none"
            raise ConfigError(f"--{parameter}: {name} has no such parameter; it has {has}")
        manoeuvre = replace(manoeuvre, **{PARAMETERS[parameter]: value})
    if within_limits(manoeuvre, vehicle) != manoeuvre:
        most = math.degrees(limit(vehicle, manoeuvre.needs[0]))
        raise ConfigError(
            f"--angle {given['angle']:g}: the {manoeuvre.needs[0]} of {vehicle.name} "
            f"goes to {most:g} degrees"
        )
    return manoeuvre
