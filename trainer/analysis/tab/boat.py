"""The numbers of one boat for a page that flies her: records, orders, channels, casualties, seas."""

from typing import Any, Final

from trainer.boat import casualties
from trainer.boat.boat import Boat
from trainer.boat.casualties import GAUGE_UNITS, SHARES, SIDES
from trainer.boat.crew_orders import AXES
from trainer.boat.export.wasm import numbers_of
from trainer.boat.sea_orders import fully_developed, standing_sea
from trainer.config.casualties import Casualty
from trainer.config.sea import peak_frequency, significant_height, step_problem
from trainer.core.ballast.tanks import BANKS, COMPARTMENTS, TANKS
from trainer.core.casualties import KINDS
from trainer.core.sea.sea import HEIGHT, OMEGA
from trainer.core.state import CASUALTIES, SCRATCH, VALVES
from trainer.core.surfaces import SURFACES
from trainer.io.orders.quantities import NUMBERS, Number
from trainer.io.orders.table import FORMS, NAMES, SETS, SIGNS
from trainer.session.stations.briefing import ranges
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.roles import ROLES
from trainer.session.stations.view import Fittings
from trainer.units import KNOT

SEA_STATES: Final = range(9)


def boat_for_page(boat: Boat, role: str) -> dict[str, Any]:
    """Return all that a page knows of a boat as it stands, for a station of that role."""
    return {
        **numbers_of(boat),
        "title": boat.file.name,
        "gauges_at": int((SCRATCH.fields or {})["reading"][1]),
        "channels": channels(),
        "ranges": list(ranges(boat, ROLES[role])),
        "casualties": offers(boat),
        "calms": developed_seas(boat),
        "ramp_s": boat.sea.sea.ramp_s,
        "grammar": grammar(),
        **fittings(boat),
    }


def channels() -> dict[str, list[tuple[str, str, int]]]:
    """Return name, unit and decimals of every field of the channels."""
    return {
        name: [(field.name, field.unit, field.decimals) for field in channel.fields]
        for name, channel in CHANNELS.items()
    }


def fittings(boat: Boat) -> dict[str, Any]:
    """Return the scales by which the state is read."""
    scales = Fittings.of(boat)
    bells = boat.file.propulsion.bells_kn
    return {
        **scales._asdict(),
        "toward": boat.toward,
        "rps": boat.file.propulsion.rps_per_mps,
        "bells": [("stop", 0.0), *((name, speed * KNOT) for name, speed in bells.items())],
        "tanks": TANKS,
        "compartments": COMPARTMENTS,
        "banks": BANKS,
        "valves": VALVES,
        "compressor": bool(boat.vessel.compressor_rate),
        "kinds": KINDS,
        "slots": CASUALTIES,
        "axes": AXES,
        "sides": SIDES,
        "gauge_units": GAUGE_UNITS,
        "shares": SHARES,
        "knot": KNOT,
    }


def offers(boat: Boat) -> list[dict[str, Any]]:
    """Return the casualties that the boat can suffer, with their numbers."""
    return [
        offer(boat, boat.casualties[name], degree)
        for name, degree, _ in casualties.available(boat)
    ]


def offer(boat: Boat, casualty: Casualty, degree: str) -> dict[str, Any]:
    """Return the numbers of a casualty; ``limit`` is that of a surface that goes hard over."""
    limits = [
        boat.toward[surface] * float(boat.vessel.limit[place])
        for place, surface in enumerate(SURFACES)
        if casualty.kind == f"{surface}-hard-over"
    ]
    measure = casualty.measure
    amount = casualty.severity * casualty.full * (limits or [1.0])[0]
    return {
        "name": casualty.name,
        "kind": casualty.kind,
        "code": casualty.code,
        "severity": casualty.severity,
        "ramp": casualty.ramp_s,
        "clear": casualty.clear_ramp_s,
        "says": casualty.description,
        "full": casualty.full,
        "limit": limits[0] if limits else None,
        "low": measure.limits.low,
        "high": min(measure.limits.high, 1e300),
        "sudden": measure.sudden,
        "degree": degree,
        "told": "" if measure.sudden else casualties.describe(boat, casualty.kind, amount),
    }


def developed_seas(boat: Boat) -> dict[str, tuple[float, float]]:
    """Return height [m] and peak [rad/s] of each sea state that the boat's step allows."""
    g = float(boat.vessel.g)
    found = {}
    for state in SEA_STATES:
        sea = fully_developed(boat.sea.sea, "state", float(state))
        height, peak = significant_height(sea, g), peak_frequency(sea, g)
        wanted = standing_sea(boat)
        wanted[HEIGHT], wanted[OMEGA] = height, peak
        if not step_problem(wanted, boat.method.step):
            found[str(state)] = (float(height), float(peak))
    return found


def grammar() -> dict[str, Any]:
    """Return the table of orders, by which a page reads a line."""
    return {
        "forms": [
            {"pattern": f.pattern, "name": f.name, "value": f.value, "refusal": f.refusal}
            for f in FORMS
        ],
        "sets": SETS,
        "numbers": {name: measure(number) for name, number in NUMBERS.items()},
        "names": {name: place.says for name, place in NAMES.items()},
        "signs": SIGNS,
    }


def measure(number: Number) -> dict[str, Any]:
    """Return a kind of number as a page reads it."""
    units = [{"text": u.text, "names": u.names, "factor": u.factor} for u in number.units]
    limits = {"low": number.low, "high": number.high, "decimals": number.decimals}
    return {"says": number.says, "units": units, "prefix": number.prefix, **limits}
