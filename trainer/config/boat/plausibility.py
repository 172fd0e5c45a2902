"""Checks whether the numbers of a vessel file fit together.

``vessel`` refuses a file by them, and ``trainer boat check`` tells the rest. Each function returns
its problems as texts. The limits are wide, because they are to catch feet, pounds and misplaced
points, not poor boats.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Final

from trainer.config.boat.propulsion import row_problems
from trainer.config.boat.vessel_records import (
    Autopilot,
    Envelope,
    Fluid,
    FreeSurface,
    Hull,
    Propulsion,
    RunDefaults,
    ThrustSet,
    WaveStrips,
)
from trainer.units import KNOT

FEET_PER_METRE = 3.2808
POUNDS_PER_KILOGRAM = 2.2046
POUNDS_FORCE_PER_NEWTON = 0.22481
# m' = mass/(rho/2 L^3) [-]; known submarines and AUVs: 0.013 to 0.08
MASS_PRIME_RANGE = (0.003, 0.3)
ROLL_GYRADIUS_RANGE = (0.01, 0.5)  # sqrt(Ix/mass)/L [-]; known boats: 0.04 to 0.12
# of pitch and yaw [-]; known boats: 0.24 to 0.30; 0.5: all mass at the ends
PITCH_GYRADIUS_RANGE = (0.1, 0.5)
WEIGHT_SLACK = 0.05  # [-] relative
INERTIA_SLACK = 0.05  # [-] relative
STATED_SLACK = 0.01  # of a number given twice, once for the reader
STRIP_SLACK = 0.01  # of the strips' mass
STRIP_CENTRE = 0.005  # [-] of the length, of their centre
STRIP_ADDED = 0.02  # of their added masses, and their centres
STRIP_END = 0.6  # [-] of the length
# a hard turn of BB2, in which its propeller's torque is told on both sides of the handover
HANDOVER_ETA, HANDOVER_SPEED_KN = 2.0, 10.0  # [-], [kn] command speed
# gains that take the boat back where the coefficient beside them has the sign given
RESTORING_GAINS: Final = {
    "stern_pitch": ("M_ds", -1.0),
    "bow_depth": ("Z_db", 1.0),
    "rudder_course": ("N_dr", 1.0),
    "rudder_yaw_rate": ("N_dr", 1.0),
}


def hull_problems(hull: Hull, fluid: Fluid) -> list[str]:
    """Return what is implausible about size, mass and centres in this water."""
    # Each depth is compared with the one before it in the order of ``_depths``.
    problems = []
    for (key, least), (other, depth) in pairwise(_depths(hull).items()):
        collapse = other == "collapse_depth_m"
        if depth < least or (collapse and depth == least):
            rule = "deeper than" if collapse else "at least"
            problems.append(f"{other} = {depth:g} m: must be {rule} {key} = {least:g} m")
    return [
        *_mass_problems(hull, fluid),
        *_inertia_problems(hull),
        *(
            f"{name} = {list(point)}: lies further than L = {hull.length:g} m from the origin"
            for name, point in (("cg", hull.cg), ("cb", hull.cb))
            if math.hypot(*point) > hull.length
        ),
        *problems,
    ]


def _depths(hull: Hull) -> dict[str, float]:
    """Return the depths [m] that the file gives by their keys, in the order they must have."""
    keys = ("max_depth_m", "test_depth_m", "collapse_depth_m")
    return {key: getattr(hull, key) for key in keys if getattr(hull, key) is not None}


def _mass_problems(hull: Hull, fluid: Fluid) -> list[str]:
    """Return what is implausible about mass, weight and buoyancy."""
    problems = []
    mass_prime = hull.mass / (0.5 * fluid.rho * hull.length**3)
    low, high = MASS_PRIME_RANGE
    if not low <= mass_prime <= high:
        in_metres = mass_prime * FEET_PER_METRE**3
        hint = "; are these feet?" if low <= in_metres <= high else ""
        problems.append(
            f"length = {hull.length:g} m, mass = {hull.mass:g} kg: mass/(rho/2 L^3) is "
            f"{mass_prime:.3g}, must be {low:g} to {high:g}{hint}"
        )
    ratio = hull.weight / (hull.mass * fluid.g)
    if abs(ratio - 1) > WEIGHT_SLACK:
        problems.append(
            f"weight = {hull.weight:g} N: must be mass times g = {hull.mass * fluid.g:g} N within "
            f"{WEIGHT_SLACK:.0%}{_weight_hint(ratio, fluid.g)}"
        )
    if not 0.5 <= hull.buoyancy / hull.weight <= 2:
        problems.append(
            f"buoyancy = {hull.buoyancy:g} N: must be weight = {hull.weight:g} N within a factor 2"
        )
    return problems


def _weight_hint(ratio: float, g: float) -> str:
    """Return a question if weight/(mass g) is that of a usual slip of units."""
    slips = {
        "is the mass in pounds?": 1 / POUNDS_PER_KILOGRAM,
        "is the weight in pounds?": POUNDS_FORCE_PER_NEWTON,
        "is the weight in kilograms?": 1 / g,
        "is the weight in kilonewtons?": 1e-3,
        "is the mass in tonnes?": 1e3,
    }
    for question, expected in slips.items():
        if abs(ratio / expected - 1) <= WEIGHT_SLACK:
            return f"; {question}"
    return ""


def _inertia_problems(hull: Hull) -> list[str]:
    """Return the inertias that no body of this mass and length can have."""
    problems = []
    inertias = {"Ix": hull.Ix, "Iy": hull.Iy, "Iz": hull.Iz}
    for name, inertia in inertias.items():
        low, high = ROLL_GYRADIUS_RANGE if name == "Ix" else PITCH_GYRADIUS_RANGE
        gyradius = math.sqrt(inertia / hull.mass) / hull.length
        if not low <= gyradius <= high:
            problems.append(
                f"{name} = {inertia:g} kg m2: sqrt({name}/mass)/L is {gyradius:.3g}, "
                f"must be {low:g} to {high:g}"
            )
        # The triangle inequality of moments of inertia: no body exceeds it.
        others = sum(inertias.values()) - inertia
        if inertia > others * (1 + INERTIA_SLACK):
            problems.append(
                f"{name} = {inertia:g} kg m2: must not exceed the sum of the other two, "
                f"{others:g} kg m2, by more than {INERTIA_SLACK:.0%}"
            )
    for pair in ("xy", "yz", "xz"):
        product: float = getattr(hull, f"I{pair}")
        limit = math.sqrt(inertias[f"I{pair[0]}"] * inertias[f"I{pair[1]}"])
        if abs(product) >= limit:
            problems.append(
                f"I{pair} = {product:g} kg m2: must be below {limit:.4g} kg m2 either way, "
                f"the root of I{pair[0]} I{pair[1]}"
            )
    return problems


def added_mass_problems(coefficients: Mapping[str, float], hull: Hull, fluid: Fluid) -> list[str]:
    """Return the accelerations whose virtual mass or inertia would not be positive."""
    mass = hull.mass / (0.5 * fluid.rho * hull.length**3)
    per_inertia = 1 / (0.5 * fluid.rho * hull.length**5)
    mass_limits = {
        "X_udot": mass,
        "Y_vdot": mass,
        "Z_wdot": mass,
        "K_pdot": hull.Ix * per_inertia,
        "M_qdot": hull.Iy * per_inertia,
        "N_rdot": hull.Iz * per_inertia,
    }
    return [
        f"{key} = {coefficients[key]!r}: must be below the boat's own {limit:.4g}; "
        "an added mass is negative here"
        for key, limit in mass_limits.items()
        if coefficients[key] >= limit
    ]


def propulsion_problems(propulsion: Propulsion) -> list[str]:
    """Return what does not fit among thrust rows, bells and the largest command speed."""
    problems = row_problems(propulsion.sets) or engine_problems(propulsion)
    bells = propulsion.bells_kn
    largest = propulsion.max_ordered_speed_kn
    problems += [
        f"bells_kn.{name} = {speed:g} kn: must be within max_ordered_speed_kn = {largest:g} kn"
        for name, speed in bells.items()
        if abs(speed) > largest
    ]
    for way, sign in (("ahead", 1), ("astern", -1)):
        rising = [("rest", 0.0)] + [(n, sign * s) for n, s in bells.items() if n.startswith(way)]
        problems += [
            f"bells_kn.{name} = {sign * speed:g} kn: must be further {way} than {slower}"
            for (slower, least), (name, speed) in pairwise(rising)
            if speed <= least
        ]
    return problems


def engine_problems(propulsion: Propulsion) -> list[str]:
    """Return the keys that an engine's limits lack."""
    torque, power = propulsion.torque_limit_n_m, propulsion.shaft_power_w
    name, value = ("torque_limit_n_m", torque) if power is None else ("shaft_power_w", power)
    if value is None:
        return []
    lacking = [key for key in ("KQ", "propeller_diameter") if getattr(propulsion, key) is None]
    problems = [f"{name} = {value:g}: needs {key} as well" for key in lacking]
    if propulsion.KQ and propulsion.KQ[0] <= 0.0:
        problems.append(f"KQ[0] = {propulsion.KQ[0]:g}: must be above 0 for a limit of torque")
    return problems


def envelope_problems(envelope: Envelope) -> list[str]:
    """Return what does not fit about the boat beyond its range."""
    problems = []
    if envelope.handover_deg and envelope.handover_deg[0] >= envelope.handover_deg[1]:
        problems.append(f"handover_deg = {list(envelope.handover_deg)}: must ascend")
    if envelope.tail_place is None and (envelope.tail_y or envelope.tail_z):
        problems.append("tail_y, tail_z: need tail_place as well")
    if envelope.sail_place is None and (envelope.sail_y or envelope.sail_added_mass):
        problems.append("sail_y, sail_added_mass: need sail_place as well")
    if envelope.sail_lift_place is None and envelope.sail_lift:
        problems.append("sail_lift: needs sail_lift_place as well")
    if envelope.strip_width and not sum(envelope.strip_width) > 0.0:
        problems.append(f"strip_width = {list(envelope.strip_width)}: one must be above 0")
    return problems


def run_problems(run: RunDefaults, hull: Hull) -> list[str]:
    """Return what does not fit about the start of a run."""
    slowest, fastest = run.speed_range_kn
    problems = []
    if slowest >= fastest:
        problems.append(f"speed_range_kn = {[slowest, fastest]}: must ascend")
    elif not slowest <= run.start_speed_kn <= fastest:
        problems.append(
            f"start_speed_kn = {run.start_speed_kn:g} kn: must be within speed_range_kn, "
            f"{slowest:g} to {fastest:g} kn"
        )
    for key, depth in list(_depths(hull).items())[:1]:
        if run.start_depth_m > depth:
            problems.append(
                f"start_depth_m = {run.start_depth_m:g} m: must be at most {key} = "
                f"{depth:g} m of [vessel]"
            )
    return problems


def _wrong_signs(autopilot: Autopilot, coefficients: Mapping[str, float]) -> list[str]:
    """Return the gains that would drive the boat away from what is ordered."""
    problems = []
    for name, (coefficient, sign) in RESTORING_GAINS.items():
        effect = coefficients[coefficient]
        for gain in getattr(autopilot, name):
            if sign * gain * effect < 0.0:
                wanted = "above" if sign * effect > 0.0 else "below"
                problems.append(
                    f"{name} = {gain:g}: has the wrong sign; with {coefficient} = {effect:g} it "
                    f"must be {wanted} 0, or trainer boat gains makes the table"
                )
                break
    return problems


def autopilot_problems(autopilot: Autopilot, coefficients: Mapping[str, float]) -> list[str]:
    """Return the gain lists that do not fit the speeds or the boat's surfaces."""
    speeds = autopilot.speed_kn
    problems = [
        f"{name} = {list(values)}: has {len(values)} entries, speed_kn has {len(speeds)}"
        for name, values in vars(autopilot).items()
        if isinstance(values, tuple) and len(values) != len(speeds)
    ]
    if any(slower >= faster for slower, faster in pairwise(speeds)):
        problems.append(f"speed_kn = {list(speeds)}: must ascend, none twice")
    return problems + _wrong_signs(autopilot, coefficients)


def free_surface_problems(table: FreeSurface) -> list[str]:
    """Return the rows that do not fit the depths, or do not end with 0."""
    depths, speeds = list(table.depth_m), [row.speed_kn for row in table.rows]
    lists = [
        (f"rows[{i}]: {name}", list(getattr(row, name)))
        for i, row in enumerate(table.rows)
        for name in ("Z_star", "M_star")
    ]
    lists += [
        (name, list(values))
        for name, values in (("Z_w", table.Z_w), ("M_w", table.M_w))
        if values is not None
    ]
    problems = [
        f"{name} = {values}: has {len(values)} entries, depth_m has {len(depths)}"
        for name, values in lists
        if len(values) != len(depths)
    ]
    problems += [
        f"{name} = {values}: must end with 0, the effect ends at the last depth"
        for name, values in lists
        if values[-1] != 0.0
    ]
    for name, values in (("depth_m", depths), ("rows: speed_kn", speeds)):
        if any(lower >= higher for lower, higher in pairwise(values)):
            problems.append(f"{name} = {values}: must ascend, none twice")
    return problems


def _centre(distances: Sequence[float], masses: Sequence[float]) -> float:
    """Return the centre [m] of masses at distances [m]; 0 of none."""
    moments = (x * mass for x, mass in zip(distances, masses, strict=True))
    return sum(moments) / sum(masses) if sum(masses) else 0.0


def wave_strip_problems(table: WaveStrips, hull: Hull, fluid: Fluid) -> list[str]:
    """Return what is wrong with strips that are not those of this hull."""
    problems = []
    centres, masses = list(table.x_m), table.displaced_kg
    if any(ahead <= behind for ahead, behind in pairwise(centres)):
        problems.append(f"x_m = {centres}: must descend from the bow, none twice")
    if max(map(abs, centres)) > STRIP_END * hull.length:
        most = STRIP_END * hull.length
        problems.append(f"x_m = {centres}: must lie within {most:g} m of the origin")
    displaced = hull.buoyancy / fluid.g
    if abs(sum(masses) / displaced - 1.0) > STRIP_SLACK:
        problems.append(
            f"displaced_kg: the sum is {sum(masses):g} kg, must be buoyancy/g = {displaced:g} kg "
            f"within {STRIP_SLACK:.0%}"
        )
    centre, most = _centre(centres, masses), STRIP_CENTRE * hull.length
    if abs(centre - hull.cb[0]) > most:
        problems.append(
            f"displaced_kg: the centre is at x = {centre:.3g} m, must be that of cb, "
            f"{hull.cb[0]:g} m, within {most:.3g} m"
        )
    empty = [name for name in ("added_down_kg", "added_side_kg") if not any(getattr(table, name))]
    return [*problems, *(f"{name}: all are 0, must have a sum" for name in empty)]


def wave_strip_remarks(
    table: WaveStrips, coefficients: Mapping[str, float], hull: Hull, fluid: Fluid
) -> list[str]:
    """Return the added masses of strips that do not agree with the coefficients."""
    k3 = 0.5 * fluid.rho * hull.length**3
    remarks = []
    for name, mass, moment, sign in (
        ("added_down_kg", "Z_wdot", "Z_qdot", 1.0),
        ("added_side_kg", "Y_vdot", "Y_rdot", -1.0),
    ):
        strip_values, expected = getattr(table, name), -k3 * coefficients[mass]
        arm = sign * hull.length * coefficients[moment] / -coefficients[mass] if expected else 0.0
        if abs(sum(strip_values) - expected) > STRIP_ADDED * abs(expected):
            remarks.append(
                f"{name}: the sum is {sum(strip_values):g} kg, -{mass} is {expected:g} kg, which a "
                "run shares out"
            )
        if abs(_centre(table.x_m, strip_values) - arm) > STRIP_ADDED * hull.length:
            remarks.append(
                f"{name}: the centre is at x = {_centre(table.x_m, strip_values):.3g} m, "
                f"by {moment} it is at {arm:.3g} m"
            )
    return remarks


def stated_remarks(hull: Hull, fluid: Fluid) -> list[str]:
    """Return the numbers for the reader that differ from those a run uses."""
    k3, k5 = (0.5 * fluid.rho * hull.length**power for power in (3, 5))
    expected = {
        "displaced_volume": ("buoyancy/(rho g)", hull.buoyancy / (fluid.rho * fluid.g), " m3"),
        "m_prime": ("mass/(rho/2 L^3)", hull.mass / k3, ""),
        "Ix_prime": ("Ix/(rho/2 L^5)", hull.Ix / k5, ""),
        "Iy_prime": ("Iy/(rho/2 L^5)", hull.Iy / k5, ""),
        "Iz_prime": ("Iz/(rho/2 L^5)", hull.Iz / k5, ""),
    }
    return [
        f"{key} = {stated:g}{unit}: {formula} is {used:.5g}{unit}, which a run uses"
        for key, (formula, used, unit) in expected.items()
        if (stated := getattr(hull, key)) is not None and abs(stated / used - 1) > STATED_SLACK
    ]


def torque_remarks(coefficients: Mapping[str, float], hull: Hull, fluid: Fluid) -> list[str]:
    """Return the step of the propeller's torque beyond the coefficients' range.

    In their range it is K_star u^2 + K_star_eta u^2 (eta - 1), beyond it K_star u_c|u_c|. The two
    are the same at eta = 1 alone; told is HANDOVER_ETA, at HANDOVER_SPEED_KN of command speed.
    """
    u_c = HANDOVER_SPEED_KN * KNOT
    u = u_c / HANDOVER_ETA
    inside = coefficients["K_star"] * u * u + coefficients["K_star_eta"] * u * (u_c - u)
    beyond = coefficients["K_star"] * u_c * u_c
    stiffness = hull.cg[2] * hull.weight - hull.cb[2] * hull.buoyancy
    if inside == beyond or stiffness <= 0.0:
        return []
    scale = 0.5 * fluid.rho * hull.length**3
    step = scale * (beyond - inside)
    moments = (
        f"{scale * inside / 1e3:.4g} kN m by the coefficients, {scale * beyond / 1e3:.4g} kN m"
    )
    text = (
        f"[coefficients] K_star, K_star_eta: at eta = {HANDOVER_ETA:g} and turns for "
        f"{HANDOVER_SPEED_KN:g} kn the propeller's torque is {moments} beyond their range, "
        f"where it is K_star u_c|u_c|: "
        f"{math.degrees(step / stiffness):+.2g} deg of heel while one hands over to the other"
    )
    return [text]


def thrust_remarks(sets: tuple[ThrustSet, ...]) -> list[str]:
    """Return what is unusual, not wrong, about thrust rows sorted by falling eta_min."""
    at_self_propulsion = [row for row in sets if row.eta_min <= 1]
    remarks = []
    if at_self_propulsion:
        row = at_self_propulsion[0]
        total = row.a + row.b + row.c
        if abs(total) > 1e-6:
            remarks.append(
                f"sets: a + b + c = {total:.3g} in the row of eta = 1, not 0: "
                "command speed is not the speed reached"
            )
    if sets[-1].eta_min > 0:
        remarks.append(f"sets: no row for eta below {sets[-1].eta_min:g}")
    return remarks
