"""The manoeuvres by name, with their parameters, as ``trainer boat manoeuvre`` takes them.

Guides, studies and reductions look a manoeuvre up here. The classes are in the modules beside it.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Final

from trainer.analysis.manoeuvres.casualties import OutOfBalance, PlaneJam, RudderJam
from trainer.analysis.manoeuvres.flight import Manoeuvre
from trainer.analysis.manoeuvres.seakeeping import BeamSea
from trainer.analysis.manoeuvres.speeds import Acceleration, Backing, CrashStop, UtmostAcceleration
from trainer.analysis.manoeuvres.turns import ClimbingTurn, PullOut, ReverseSpiral, Spiral, Turn
from trainer.analysis.manoeuvres.vehicle import Vehicle, surface_limit
from trainer.analysis.manoeuvres.vertical import (
    Impulse,
    Meander,
    Overshoot,
    RollDecay,
    RudderImpulse,
    TrimChange,
)
from trainer.analysis.manoeuvres.zigzag import VerticalZigZag, ZigZag
from trainer.config.files import ConfigError, offer_known
from trainer.units import KNOT

SPEED_ROUNDING_KN: Final = 1e-9  # [kn]
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
        "backing": Backing(),
        "roll-decay": RollDecay(),
        "beam-sea": BeamSea(),
        # what goes wrong
        "out-of-balance": OutOfBalance(share=-0.002),
        "plane-jam": PlaneJam(),
        "rudder-jam": RudderJam(),
    }
)
PARAMETERS: Final = {  # as an engineer names them, and the fields of the manoeuvres
    "angle": "angle_deg",
    "execute": "execute_deg",
    "planes": "planes_deg",
    "duration": "duration_s",
    "step_speed": "step_kn",
    "step_time": "each_s",
    "ahead_speed": "ahead_kn",
    "ahead_time": "ahead_s",
    "side": "side",
    "direction": "direction",
}
ParameterValues = dict[str, float | str]


def find_manoeuvre(name: str) -> Manoeuvre:
    """Return the manoeuvre of that name; ConfigError if there is none."""
    if name not in MANOEUVRES:
        raise ConfigError(f"no manoeuvre {name!r}{offer_known(name, MANOEUVRES)}")
    return MANOEUVRES[name]


def manoeuvre_parameters(manoeuvre: Manoeuvre) -> ParameterValues:
    """Return a manoeuvre's parameters by the names of PARAMETERS, in [deg], [s] and [kn].

    A parameter that is left to the vehicle, such as full ahead, is not among them.
    """
    return {
        name: getattr(manoeuvre, field)
        for name, field in PARAMETERS.items()
        if getattr(manoeuvre, field, None) is not None
    }


def format_parameters(given: Mapping[str, float | str]) -> str:
    """Return parameters in words: ``angle 15, duration 300, port``."""
    return ", ".join(
        value if isinstance(value, str) else f"{name.replace('_', ' ')} {value:g}"
        for name, value in given.items()
    )


def within_limits(manoeuvre: Manoeuvre, vehicle: Vehicle) -> Manoeuvre:
    """Return the manoeuvre, its angle reduced to the limit of the vehicle's control."""
    angle = getattr(manoeuvre, "angle_deg", None)
    if angle is None or not manoeuvre.needs or manoeuvre.needs[0] not in vehicle.controls:
        return manoeuvre
    most = round(math.degrees(surface_limit(vehicle, manoeuvre.needs[0])), 9)
    return manoeuvre if angle <= most else replace(manoeuvre, angle_deg=most)  # type: ignore[call-arg]


def adjust_manoeuvre(name: str, vehicle: Vehicle, given: Mapping[str, float | str]) -> Manoeuvre:
    """Return the manoeuvre of that name for a vehicle, with the parameters ``given``.

    ConfigError if it has no such parameter, or the vehicle's control does not go so far.
    """
    manoeuvre = within_limits(find_manoeuvre(name), vehicle)
    for parameter, value in given.items():
        if not hasattr(manoeuvre, PARAMETERS[parameter]):
            raise ConfigError(_no_parameter(name, parameter, value))
        manoeuvre = replace(manoeuvre, **{PARAMETERS[parameter]: value})
    _check_reach(manoeuvre, vehicle, given)
    return manoeuvre


def parameter_option(parameter: str, value: object = "") -> str:
    """Return how a parameter is given on the command line. A direction has its own words."""
    return f"--{value}" if parameter == "direction" else f"--{parameter.replace('_', '-')}"


def _no_parameter(name: str, parameter: str, value: object) -> str:
    """Return the parameters that a manoeuvre has, and which manoeuvres have the one asked for."""
    manoeuvre = find_manoeuvre(name)
    words = {"direction": "rise or dive"}
    keys = (key for key, field in PARAMETERS.items() if hasattr(manoeuvre, field))
    has = [words.get(key, key.replace("_", "-")) for key in keys]
    field = PARAMETERS[parameter]
    others = ", ".join(other for other, one in MANOEUVRES.items() if hasattr(one, field))
    option_text = parameter_option(parameter, value)
    return (
        f"{option_text}: {name} has no such parameter; it has {', '.join(has) or 'none'}. "
        f"{option_text} is for {others}"
    )


def _check_reach(manoeuvre: Manoeuvre, vehicle: Vehicle, given: Mapping[str, float | str]) -> None:
    """Check that the vehicle can fly these parameters; ConfigError if it cannot."""
    first = manoeuvre.needs[:1]
    for parameter, controls in (("angle", first), ("planes", ("planes",))):
        for control in controls:
            if parameter in given and control in vehicle.controls:
                most = round(math.degrees(surface_limit(vehicle, control)), 9)
                if float(given[parameter]) > most:
                    raise ConfigError(
                        f"--{parameter} {given[parameter]:g}: the {control} of {vehicle.name} goes "
                        f"to {most:g} degrees"
                    )
    if "ahead_speed" in given and "engine" in vehicle.controls:
        most = vehicle.controls["engine"].high / KNOT
        if float(given["ahead_speed"]) > most + SPEED_ROUNDING_KN:
            raise ConfigError(
                f"--ahead-speed {given['ahead_speed']:g}: the engine of {vehicle.name} is ordered "
                f"up to {most:.4g} kn"
            )
    ahead, whole = given.get("ahead_time"), getattr(manoeuvre, "duration_s", math.inf)
    if ahead is not None and float(ahead) >= whole:
        raise ConfigError(
            f"--ahead-time {ahead:g}: must be less than the duration, {whole:g} s; give a longer "
            "--duration"
        )
