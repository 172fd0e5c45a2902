"""The constants of the boat beyond the range of its coefficients, from its file.

``assemble`` writes them into the core's vessel record. Within the range the file's coefficients
hold; beyond it these forces take over, because a polynomial there may even feed the boat. All of
docs/envelope.md's section on constants: added masses made symmetric, the viscous part of the linear
coefficients, strips, planes, stability of the step, engine.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trainer.config.boat.vessel import VesselFile
from trainer.core.ballast.buoyancy import segment
from trainer.core.ballast.tanks import NEGATIVE_TANK
from trainer.core.kernel import Numbers
from trainer.units import KNOT

# The core's vessel records, a number a member. As an array, mypy tries each of numpy's overloads
# for each sum of fields, which took a fifth of its time.
VesselRecords: TypeAlias = Any

# What holds where a vessel file says nothing; docs/envelope.md has where it comes from.
TESTED_FLOW_DEG: Final = 12.0  # [deg]
HANDOVER_DEG: Final = (35.0, 55.0)  # [deg] of flow: estimates beyond any turn of BB2
HULL_SHARE: Final = 0.5  # [-] of the lift: estimate
ASTERN_EFFECT: Final = 0.6  # [-] of the lift ahead: estimate after Molland and Turnock
STALL_ASTERN: Final = (18.0, 18.0, 18.0)  # [deg] likewise
NO_STALL_DEG: Final = (90.0, 90.0, 90.0)  # [deg]
EVEN_SHARES: Final = (1.0, 1.0, 1.0, 1.0, 1.0)  # of the strips, for a hull whose file has no widths
SURFACE_DAMPING: Final = 0.03  # [-]
CROSS_ARM: Final = 0.3  # [-] of the length
WAVE_DRAG: Final = 1.8e-3  # [-] at this Froude number: estimate
WAVE_DRAG_FROUDE: Final = 0.25  # [-] of the boat at the surface, by its length
TANKLESS_LIGHTNESS: Final = 0.05  # [-] of the weight, by which a boat without tanks is lighter
HALVING_COUNT: Final = 60  # more than a double has bits
KEY_ROUNDING: Final = 1e-9  # [-] of a key, below which two figures are one
LEAST_INDUCED: Final = 0.25  # [-] a plane's drag over its lift slope, so that it cannot feed a boat
# Torque of B4-70, P/D 1, in n^2, n u/D, (u/D)^2, for a K_Q(0) of 0.0638 (docs/envelope.md)
KQ_OF_ROWS: Final = 0.0638
TORQUE_STOPPING: Final = (0.0532, -0.0024, 0.0526)
TORQUE_ASTERN: Final = (0.0591, -0.0143, -0.0502)


def write_envelope(file: VesselFile, vessels: VesselRecords) -> None:
    """Write the constants of the envelope to vessel records [member] that are else complete."""
    said, length = file.envelope, file.hull.length
    low, high = said.handover_deg or HANDOVER_DEG
    vessels["tested"] = _tan_squared(_or(said.tested_deg, TESTED_FLOW_DEG))
    vessels["handover_from"], vessels["handover_to"] = _tan_squared(low), _tan_squared(high)
    vessels["cross_arm"] = (CROSS_ARM * length) ** 2
    for name, value in added_masses(vessels).items():
        vessels[name] = value
    for way, shares in enumerate(((0.0, 0.0), hull_shares(file))):
        lateral, vertical = viscous_part(vessels, shares)
        vessels["lateral"][:, way] = dissipative_forces(lateral, (1.0, length, length))[0]
        vessels["vertical"][:, way] = dissipative_forces(vertical, (1.0, length))[0]
    _write_strips(file, vessels)
    # write how rudder, stern and bow planes stall, work astern, and what they cost
    said = file.envelope
    vessels["stall_ahead"] = np.radians(said.stall_deg or NO_STALL_DEG)
    vessels["stall_slope"] = said.stall_slope or (0.0, 0.0, 0.0)
    vessels["stall_astern"] = np.radians(said.stall_astern_deg or STALL_ASTERN)
    vessels["astern_effect"] = _or(said.plane_effect_astern, ASTERN_EFFECT)
    lifts = np.stack([vessels["Y_dr"], vessels["Z_ds"], vessels["Z_db"]], axis=1)
    arms = np.stack([vessels["N_dr"], -vessels["M_ds"], -vessels["M_db"]], axis=1)
    drags = np.stack([vessels["X_drdr"], vessels["X_dsds"], vessels["X_dbdb"]], axis=1)
    vessels["stall_arm"] = np.divide(arms, lifts, out=np.zeros_like(arms), where=lifts != 0.0)
    vessels["plane_drag"] = np.minimum(drags, -LEAST_INDUCED * abs(lifts))
    vessels["stiffness"], vessels["still_mode"] = _stiffness(vessels), _still_mode(vessels)
    area = 0.5 * file.fluid.rho * length**2
    for i, row in enumerate(file.thrust.astern):
        vessels["thrust_astern"][:, i] = area * np.array([row.a, row.b, row.c])
    _write_surface(file, vessels)
    _write_engine(file, vessels)


def _or(value: float | None, otherwise: float) -> float:
    """Return a value of the file, or another number where the file has none."""
    return otherwise if value is None else value


def _tan_squared(angle: float) -> float:
    """Return the square of the tangent [-] of an angle [deg]."""
    return math.tan(math.radians(angle)) ** 2


def hull_shares(file: VesselFile) -> tuple[float, float]:
    """Return the hull's shares [-] of the lift in the horizontal and in the vertical."""
    said = file.envelope
    return (_or(said.hull_share_horizontal, HULL_SHARE), _or(said.hull_share_vertical, HULL_SHARE))


def added_masses(c: VesselRecords) -> dict[str, Numbers]:
    """Return the added masses [kg, kg m, kg m2] of each member, positive and symmetric."""
    return {
        "m11": -c["X_udot"],
        "m22": -c["Y_vdot"],
        "m33": -c["Z_wdot"],
        "m44": -c["K_pdot"],
        "m55": -c["M_qdot"],
        "m66": -c["N_rdot"],
        "m24": -0.5 * (c["Y_pdot"] + c["K_vdot"]),
        "m26": -0.5 * (c["Y_rdot"] + c["N_vdot"]),
        "m35": -0.5 * (c["Z_qdot"] + c["M_wdot"]),
        "m46": -0.5 * (c["K_rdot"] + c["N_pdot"]),
    }


def _matrices(rows: Sequence[Sequence[Any]]) -> Numbers:
    """Return a matrix for each member [member, row, column] of entries by member."""
    return np.moveaxis(np.array(rows, float), -1, 0)


def viscous_part(c: VesselRecords, shares: tuple[float, float]) -> tuple[Numbers, Numbers]:
    """Return the viscous part of the linear coefficients. Y K N are by v p r, Z M by w q.

    A coefficient of u and a velocity holds an ideal part, which is taken off. ``shares`` [-] of
    the lift are the hull's, whose centre moves to the other end astern; 0 ahead.
    """
    side, down = (1.0 - 2.0 * share for share in shares)
    lateral = [
        [c["Y_v"], c["Y_p"], (c["Y_r"] - c["X_udot"]) * side],
        [c["K_v"], c["K_p"], c["K_r"]],
        [
            (c["N_v"] - c["Y_vdot"] + c["X_udot"]) * side,
            c["N_p"] - c["Y_pdot"],
            c["N_r"] - c["Y_rdot"],
        ],
    ]
    vertical = [
        [c["Z_w"], (c["Z_q"] + c["X_udot"]) * down],
        [(c["M_w"] - c["X_udot"] + c["Z_wdot"]) * down, c["M_q"] + c["Z_qdot"]],
    ]
    return _matrices(lateral), _matrices(vertical)


def dissipative_forces(
    forces: Numbers, lengths: tuple[float, ...]
) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return forces by velocities [member, row, column] that never feed a boat, and where changed.

    The symmetric part, scaled by ``lengths`` [m], loses its positive eigenvalues, because only
    these feed energy to a motion.
    """
    scale = np.outer(lengths, lengths)
    scaled = forces / scale
    turned = np.swapaxes(scaled, 1, 2)
    even, odd = 0.5 * (scaled + turned), 0.5 * (scaled - turned)
    values, vectors = np.linalg.eigh(even)
    feeds = values[:, -1] > 1e-12 * abs(values).max(axis=1)
    damping = (vectors * np.minimum(values, 0.0)[:, None]) @ np.swapaxes(vectors, 1, 2)
    return np.where(feeds[:, None, None], (damping + odd) * scale, forces), feeds


def is_clipped(file: VesselFile, vessel: VesselRecords) -> bool:
    """Return whether the file's own viscous coefficients would feed the boat."""
    length = file.hull.length
    pairs = (viscous_part(vessel, (0.0, 0.0)), viscous_part(vessel, hull_shares(file)))
    sizes = ((1.0, length, length), (1.0, length))
    return any(
        dissipative_forces(m, sizes[i])[1].any() for pair in pairs for i, m in enumerate(pair)
    )


def largest_sail_lift(c: VesselRecords) -> Numbers:
    """Return the sail's lift slope [N s2/m2] that the boat can lose, at most.

    Without it the viscous forces by v p r still take energy from any motion, ahead and astern. The
    limit is det A/(p adj(A) p), where A is what they take and p the sail's lever: 0 where nothing
    damps the boat.
    """
    length = c["ell"]
    lever = np.stack([np.ones_like(length), -c["lift_z"] / length, c["lift_x"] / length], axis=1)
    scale = np.stack([np.ones_like(length), length, length], axis=1)
    limits = []
    for way in range(2):
        forces = c["lateral"][:, way] / (scale[:, :, None] * scale[:, None, :])
        rows = np.moveaxis(-0.5 * (forces + np.swapaxes(forces, 1, 2)), 1, 0)
        adjugate = np.stack([np.cross(rows[i - 2], rows[i - 1]) for i in range(3)])
        whole = (rows[0] * adjugate[0]).sum(axis=1)
        share = (lever.T * (adjugate * lever).sum(axis=2)).sum(axis=0)
        limits.append(np.divide(whole, share, out=np.zeros_like(whole), where=share > 0.0))
    return np.asarray(np.maximum(np.minimum(*limits), 0.0))


def bounded_keys(file: VesselFile, vessel: VesselRecords) -> Iterator[tuple[str, float, float]]:
    """Yield each key cut at a bound: its name, what is given, what is flown.

    Bounds see to it that a force takes energy from any motion. A key that is not given has none.
    """
    area = 0.5 * file.fluid.rho * file.hull.length**2
    drags = ("X_drdr", "X_dsds", "X_dbdb")
    given = {f"[coefficients] {name}": file.coefficients[name] for name in (*drags, "K_p")}
    given["[envelope] sail_lift"] = file.envelope.sail_lift or 0.0
    flown = (
        *(vessel["plane_drag"][0] / area),
        vessel["roll_damping"][0] / (area * file.hull.length**2),
        vessel["sail_lift"][0] / area,
    )
    for (key, value), used in zip(given.items(), flown, strict=True):
        if value and abs(used - value) > KEY_ROUNDING * abs(value):
            yield key, value, float(used)


def _write_strips(file: VesselFile, c: VesselRecords) -> None:
    """Write the cross-flow drag [N s2/m2] of hull, tail and sail, and the damping of roll."""
    said = file.envelope
    area = 0.5 * file.fluid.rho * file.hull.length**2
    width = np.array(said.strip_width or EVEN_SHARES)
    width /= width.sum()
    tail_y, tail_z = area * (said.tail_y or 0.0), area * (said.tail_z or 0.0)
    sail = area * (said.sail_y or 0.0)
    side = np.maximum(abs(c["Y_vav"]) - tail_y - sail, 0.0)
    down = np.maximum(abs(c["Z_waw"]) - tail_z, 0.0)
    if said.crossflow_y is not None:
        side[:] = area * said.crossflow_y
    if said.crossflow_z is not None:
        down[:] = area * said.crossflow_z
    c["crossflow_Y"], c["crossflow_Z"] = side[:, None] * width, down[:, None] * width
    c["tail_x"] = (said.tail_place or 0.0) * file.hull.length
    c["tail_Y"], c["tail_Z"], c["strip_Y"] = tail_y, tail_z, sail
    c["strip_x"], c["strip_z"] = said.sail_place or (0.0, 0.0)
    c["lift_x"], c["lift_z"] = said.sail_lift_place or (0.0, 0.0)
    c["sail_lift"] = np.minimum(area * (said.sail_lift or 0.0), largest_sail_lift(c))
    c["sail_mass"] = said.sail_added_mass or 0.0
    c["sail_height"] = np.maximum(c["z_deck"] - c["z_sail"], 0.0)
    c["roll_damping"] = np.minimum(c["K_p"], 0.0)
    c["roll_drag"] = np.minimum(c["K_pap"] + sail * abs(c["strip_z"]) ** 3, 0.0)


def _stiffness(c: VesselRecords) -> Numbers:
    """Return the fastest mode [1/m] in a flow of 1 m/s: roll across it, or the viscous forces.

    The core divides a tick by it where the flow makes this mode too fast for the step.
    """
    roll = np.sqrt(abs(c["m33"] - c["m22"]) / (c["I_x"] + c["m44"]))
    lateral = _matrices(
        [
            [c["mass"] + c["m22"], c["m24"], c["m26"]],
            [c["m24"], c["I_x"] + c["m44"], c["m46"]],
            [c["m26"], c["m46"], c["I_z"] + c["m66"]],
        ]
    )
    vertical = _matrices([[c["mass"] + c["m33"], c["m35"]], [c["m35"], c["I_y"] + c["m55"]]])
    modes = [
        abs(np.linalg.eigvals(np.linalg.solve(mass, c[name][:, way]))).max(axis=1)
        for mass, name in ((lateral, "lateral"), (vertical, "vertical"))
        for way in range(2)
    ]
    return np.asarray(np.maximum.reduce([roll, *(0.5 * mode for mode in modes)]))


def _still_mode(c: VesselRecords) -> Numbers:
    """Return the faster of roll and pitch [rad/s] that the weight rights in a deep boat.

    They are what is left of the stiffness where nothing flows past the boat.
    """
    righting = np.maximum(c["z_g"] * c["weight"] - c["z_b"] * c["buoyancy"], 0.0)
    least = np.minimum(c["I_x"] + c["m44"], c["I_y"] + c["m55"])
    return np.asarray(np.sqrt(righting / least))


def _write_surface(file: VesselFile, c: VesselRecords) -> None:
    """Write the boat at the surface: where it begins, damping, fastest mode, wave resistance."""
    length = file.hull.length
    area = 0.5 * file.fluid.rho * length**2
    c["station_reach"] = abs(c["station_x"]).max(axis=1)
    c["hull_reach"] = 0.5 * c["hull_diameter"] + abs(c["hull_axis"]) + abs(c["y_b"])
    c["surface_line"] = c["station_reach"] + c["hull_diameter"]
    c["surface_damping"] = _or(file.envelope.surface_damping, SURFACE_DAMPING)
    c["wave_drag"] = area * WAVE_DRAG / (WAVE_DRAG_FROUDE**4 * (file.fluid.g * length) ** 2)
    c["surface_mode"] = np.maximum.reduce(list(surface_modes(c).values()))


def _write_engine(file: VesselFile, c: VesselRecords) -> None:
    """Write the engine's limits, and the propeller's torque in three quadrants."""
    engine = file.propulsion
    torque, power = engine.torque_limit_n_m, engine.shaft_power_w
    if torque is None and power is not None:
        # the torque that takes this power at the most revolutions ordered
        turns = engine.rps_per_mps * engine.max_ordered_speed_kn * KNOT
        torque, power = power / (2.0 * math.pi * turns), None
    if torque is None or engine.KQ is None or engine.propeller_diameter is None:
        return
    diameter = engine.propeller_diameter
    c["torque_limit"] = torque / (file.fluid.rho * diameter**5)
    c["power_limit"] = (power or 0.0) / (2.0 * math.pi * file.fluid.rho * diameter**5)
    c["screw"], c["turns"] = diameter, engine.rps_per_mps
    scale = engine.KQ[0] / KQ_OF_ROWS
    stopping, astern = scale * np.array(TORQUE_STOPPING), scale * np.array(TORQUE_ASTERN)
    c["torque"] = np.array([engine.KQ, stopping, astern])


def lightness(c: VesselRecords) -> Numbers:
    """Return the share of the buoyancy [-] above the water at the lightest. It is at most half."""
    blown = c["start"][:, :NEGATIVE_TANK].sum(axis=1) * c["g"] * (c["fitted"] != 0.0)
    light = (c["buoyancy"] - c["weight"] + blown) / c["buoyancy"]
    return np.where(light > 0.0, np.minimum(light, 0.5), TANKLESS_LIGHTNESS)


def float_height(share: float) -> float:
    """Return the height [diameters] of a part of a circle, by its share [-].

    It is found by halving, as the inverse of the core's ``segment``.
    """
    low, high = 0.0, 0.5
    for _ in range(HALVING_COUNT):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if segment(middle) < share else (low, middle)
    return 0.5 * (low + high)


def surface_modes(c: VesselRecords) -> dict[str, Numbers]:
    """Return the frequencies [rad/s] of heave, pitch and roll of boats afloat at their lightest.

    The lightest boat has the fastest; a tick on the surface is divided by it.
    """
    shares, which = np.unique(lightness(c), return_inverse=True)
    height = np.array([float_height(float(share)) for share in shares])[which]
    chord = 2.0 * np.sqrt(height * (1.0 - height))
    plane = 4.0 * c["buoyancy"] * chord / (math.pi * c["hull_diameter"])
    stiffness = plane[:, None] * c["station_share"]
    heave = stiffness.sum(axis=1) / (c["mass"] * (1.0 - shares[which]) + c["m33"])
    righting = c["z_g"] * c["weight"] - c["z_b"] * c["buoyancy"]
    trim = (stiffness * c["station_x"] ** 2).sum(axis=1)
    pitch = (trim + righting) / (c["I_y"] + c["m55"])
    roll = righting / (c["I_x"] + c["m44"])
    squares = {"heave": heave, "pitch": pitch, "roll": roll}
    return {name: np.sqrt(np.maximum(square, 0.0)) for name, square in squares.items()}
