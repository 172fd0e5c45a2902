"""The autopilot of any boat, designed from its linear model.

``trainer boat gains`` prints them, and ``trainer boat estimate`` writes them into its boats.
Discrete linear-quadratic regulators with integral states, at speeds over the boat's range. Both
pairs of planes together hold depth and pitch, because each pair reverses at its own critical speed:
the regulator then uses the bow planes below that of the stern planes, and spares them above their
own. A large error is measured in the boat's limits, its length and the time in which it passes its
length, so that one rule serves a submarine and a torpedo-sized vehicle.
"""

import math

import numpy as np

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.linear import LinearModel, Matrix, linearise_at_speed
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError, toml_value
from trainer.core.kernel import Record
from trainer.core.vessel import GAINS, PLANE_GAINS
from trainer.units import KNOT

GAIN_SPEED_COUNT = 10  # in the schedule, geometrically spaced

# Errors as bad as surfaces at their limits. Lengths and times of passing a length are the units.
DEPTH_ERROR_LENGTHS = 0.04  # [lengths]
PITCH_ERROR_RAD = math.radians(12.0)  # [rad]
COURSE_ERROR_RAD = math.radians(6.0)  # [rad]
# [lengths run] for which a DEPTH_ERROR_LENGTHS error may last before it counts twice
DEPTH_ERROR_RUN = 8.0
COURSE_ERROR_RUN = 10.0  # [lengths run] likewise of a COURSE_ERROR_RAD error

SURFACE_SWING_RUN = 0.25  # [lengths run] how long a surface may take to go that far

# Slewing of the references
MAX_GLIDE_RAD = math.radians(6.0)  # steepest path of a depth change
PLANE_SHARE = 0.4  # of the limits, for a steady depth rate
SLEW_TURN_RATE = 0.2  # [1/lengths] yaw rate per speed: a circle of ten lengths
RUDDER_SHARE = 0.3  # of the limit, for a steady turn
DEPTH_RUN = 4.0  # [lengths run] while a depth rate is taken up
COURSE_RUN = 2.5  # [lengths run] while a yaw rate is taken up

RELIEF_RATE = 0.3  # [1/lengths] of a lasting bow plane angle, where the stern planes do it all
STRAIGHT_TURN_RATE = 0.02  # [1/lengths] yaw rate per speed up to which speed trim is learnt
EFFECT_MARGINS = (0.5, 1.0, 2.0)  # the loop must be stable with surfaces so many times as effective

GAIN_UNITS = {  # key and factor in the vessel file, of gains whose unit is another there
    "depth_rate": ("depth_rate_m_s", 1.0),
    "depth_acceleration": ("depth_acceleration_m_s2", 1.0),
    "course_rate": ("course_rate_deg_s", math.degrees(1.0)),
    "course_acceleration": ("course_acceleration_deg_s2", math.degrees(1.0)),
}

VERTICAL_STATES = ("w", "q", "theta", "z")
LATERAL_STATES = ("v", "r", "psi")
CONTROLLED_STATES = (*LATERAL_STATES, *VERTICAL_STATES)  # roll is left to itself
SURFACE_COLUMNS = ("delta_r", "delta_s", "delta_b")


def discretise(a: Matrix, b: Matrix, h: float) -> tuple[Matrix, Matrix]:
    """Return the matrices of one step ``h`` [s] with the input held.

    They are exponential series.
    """
    n, m = b.shape
    block = np.zeros((n + m, n + m))
    block[:n, :n], block[:n, n:] = a * h, b * h
    total = term = np.eye(n + m)
    for i in range(1, 40):
        term = term @ block / i
        total = total + term
    return total[:n, :n], total[:n, n:]


def regulator(a: Matrix, b: Matrix, error_cost: Matrix, most: Matrix) -> Matrix:
    """Return K of the optimal inputs -K x; an input of ``most`` costs 1.

    The discrete Riccati equation by structure-preserving doubling (Chu, Fan, Lin, Wang 2004). An
    input whose ``most`` is zero is not used.
    """
    ease = np.diag(most * most)
    drift, spread, cost = a, b @ ease @ b.T, error_cost
    for _ in range(60):
        inverse = np.linalg.inv(np.eye(len(a)) + spread @ cost)
        change = drift.T @ cost @ inverse @ drift
        spread = spread + drift @ inverse @ spread @ drift.T
        drift = drift @ inverse @ drift
        cost = cost + change
        if np.abs(change).max() <= 1e-13 * np.abs(cost).max():
            break
    pull = ease @ b.T @ cost
    return np.asarray(np.linalg.solve(np.eye(b.shape[1]) + pull @ b, pull @ a))


def with_integral(a: Matrix, b: Matrix) -> tuple[Matrix, Matrix]:
    """Return the matrices with the integral of the last state as one more."""
    n = len(a)
    longer = np.zeros((n + 1, n + 1))
    longer[:n, :n] = a
    longer[n, n - 1] = 1.0
    return longer, np.vstack([b, np.zeros((1, b.shape[1]))])


def surface_reach(vessel: Record, speed: float) -> Matrix:
    """Return the angles [rad] of rudder, stern planes and bow planes that cost 1.

    An angle is the surface's limit, or what it reaches while the boat runs SURFACE_SWING_RUN of its
    length. The smaller one counts because a slow surface cannot follow a larger order: after a
    large disturbance the boat would swing from stop to stop.
    """
    swing = SURFACE_SWING_RUN * vessel["surface_rate"][0] * vessel["ell"][0] / speed
    return np.asarray(np.minimum(vessel["limit"][0], swing))


def plane_gains(model: LinearModel, speed: float, vessel: Record, h: float) -> Matrix:
    """Return depth, depth rate, pitch, pitch rate and integral gains [SI], stern row, bow row."""
    planes = SURFACE_COLUMNS[1:]
    a, b = with_integral(model.part(*VERTICAL_STATES), model.inputs(VERTICAL_STATES, planes))
    depth = DEPTH_ERROR_LENGTHS * vessel["ell"][0]
    lasting = depth * DEPTH_ERROR_RUN * vessel["ell"][0] / speed
    cost = np.diag([0.0, 0.0, PITCH_ERROR_RAD**-2, depth**-2, lasting**-2])
    most = surface_reach(vessel, speed)[1:]
    w, q, theta, z, integral = regulator(*discretise(a, b, h), cost, most).T
    # heave as the depth rate shows it: zdot = a w + b theta
    depth_rate = w / a[3, 0]
    return np.column_stack([z, depth_rate, a[3, 2] * depth_rate - theta, -q, integral])


def depth_rates(model: LinearModel) -> Matrix:
    """Return the steady depth rate [m/s] per angle [rad] of both pairs of planes.

    Below the critical speed of a pair its sign is turned.
    """
    motion = VERTICAL_STATES[:3]
    steady = -np.linalg.solve(model.part(*motion), model.inputs(motion, SURFACE_COLUMNS[1:]))
    return np.asarray(model.part(*VERTICAL_STATES)[3, :3] @ steady)


def slew_limits(model: LinearModel, speed: float, vessel: Record) -> list[float]:
    """Return the rates and accelerations [SI] that depth and course references may have."""
    time = vessel["ell"][0] / speed
    possible = PLANE_SHARE * float(np.abs(depth_rates(model)) @ vessel["limit"][0, 1:])
    climb = min(speed * math.sin(MAX_GLIDE_RAD), possible)
    turn = SLEW_TURN_RATE / time
    hull, force = model.part("v", "r"), model.inputs(("v", "r"), SURFACE_COLUMNS[:1])
    if np.linalg.eigvals(hull).real.max() < 0.0:
        most = RUDDER_SHARE * vessel["limit_r"][0]
        turn = min(turn, most * abs(np.linalg.solve(hull, force)[1, 0]))
    return [climb, climb / (DEPTH_RUN * time), turn, turn / (COURSE_RUN * time)]


def relief_rate(model: LinearModel, speed: float, vessel: Record) -> tuple[float, float]:
    """Return the rate [1/s] at which the stern planes take the bow planes' angle.

    Both move in the ratio that keeps the depth rate. The rate is higher where the stern planes have
    more effect on depth.
    """
    stern, bow = depth_rates(model)
    weaker = abs(bow) * vessel["limit_b"][0]
    stronger = stern * vessel["limit_s"][0]
    if weaker == 0.0 or stronger <= weaker:
        return 0.0, 0.0
    rate = RELIEF_RATE * speed / vessel["ell"][0] * (1.0 - weaker / stronger)
    return rate * bow / stern, -rate


def gains_at(model: LinearModel, speed: float, vessel: Record, h: float) -> list[float]:
    """Return the gains [SI] at one speed in the order of GAINS."""
    stern, bow = plane_gains(model, speed, vessel, h)
    taken, bow_relief = relief_rate(model, speed, vessel)
    force = model.inputs(LATERAL_STATES, SURFACE_COLUMNS[:1])
    a, b = with_integral(model.part(*LATERAL_STATES), force)
    lasting = COURSE_ERROR_RAD * COURSE_ERROR_RUN * vessel["ell"][0] / speed
    cost = np.diag([0.0, 0.0, COURSE_ERROR_RAD**-2, lasting**-2])
    v, r, psi, integral = regulator(*discretise(a, b, h), cost, surface_reach(vessel, speed)[:1])[0]
    course = (psi, r, -v, integral)
    return [*stern, taken, *bow, bow_relief, *course, *slew_limits(model, speed, vessel)]


def close_loop(model: LinearModel, row: list[float], vessel: Record, h: float) -> Matrix:
    """Return the matrix of one tick of boat, surfaces and integrals under the gains ``row``.

    A command acts a tick later and through the surfaces' lag, because it does so in the trainer.
    """
    inputs = model.inputs(CONTROLLED_STATES, SURFACE_COLUMNS)
    drift, force = discretise(model.part(*CONTROLLED_STATES), inputs, h)
    n = len(CONTROLLED_STATES)
    law, learn = np.zeros((3, n)), np.zeros((3, n + 6))
    depth_rate = model.part(*CONTROLLED_STATES)[n - 1]
    for surface in (1, 2):
        first = len(PLANE_GAINS) * (surface - 1)
        depth, rate, pitch, pitch_rate, integral, relieved = row[first : first + len(PLANE_GAINS)]
        law[surface, 4:7] = pitch_rate, pitch, -depth
        law[surface] -= rate * depth_rate
        learn[surface, [n - 1, n + 2]] = -integral, relieved
    course, yaw_rate, sway, integral = row[12:16]
    law[0, :3] = sway, -yaw_rate, -course
    learn[0, 2] = -integral
    lag = float(vessel["surface_lag"][0])
    share = -math.expm1(-h / lag) if lag > 0.0 else 1.0

    integrals = np.hstack([np.zeros((3, n + 3)), np.eye(3)]) + h * learn
    command = np.hstack([law, np.zeros((3, 6))]) + integrals
    surfaces = share * command
    surfaces[:, n : n + 3] += (1.0 - share) * np.eye(3)
    return np.vstack([np.hstack([drift, force, np.zeros((n, 3))]), surfaces, integrals])


def holds_boat(model: LinearModel, row: list[float], vessel: Record, h: float) -> bool:
    """Return whether the closed loop is stable with surfaces at each of EFFECT_MARGINS."""
    others = (LinearModel(model.A, margin * model.B) for margin in EFFECT_MARGINS)
    loops = (np.linalg.eigvals(close_loop(other, row, vessel, h)) for other in others)
    return not any(np.abs(roots).max() >= 1.0 + 1e-9 for roots in loops)


def round_digits(value: float) -> float:
    """Return ``value`` to four significant digits."""
    return float(f"{value:.4g}") + 0.0


def design_gains(file: VesselFile) -> dict[str, list[float] | float]:
    """Return the [autopilot] table, keys and units of the file; ConfigError if nothing holds it.

    Speeds at which the boat cannot fly straight and level are left out.
    """
    boat = Boat(file, Method("full", "exact", "exact", "adams2", file.run.step_s))
    vessel = boat.records.vessel
    speeds: list[float] = []
    rows: list[list[float]] = []
    surge = 0.0
    for knots in np.geomspace(*file.run.speed_range_kn, GAIN_SPEED_COUNT):
        model = linearise_at_speed(boat, knots * KNOT)
        if model is None:
            continue
        row = gains_at(model, knots * KNOT, vessel, boat.method.step)
        if not holds_boat(model, row, vessel, boat.method.step):
            raise ConfigError(
                f"{file.path.name}: no gains hold this boat at {knots:.3g} kn with a step of "
                f"{boat.method.step:g} s; give [run] a smaller step_s or another speed_range_kn"
            )
        surge = surge or -float(model.A[0, 0])
        speeds.append(round_digits(knots))
        rows.append(row)
    if len(speeds) < 2:
        raise ConfigError(
            f"{file.path.name}: no straight level flight within [run] speed_range_kn: no autopilot"
        )
    turning = STRAIGHT_TURN_RATE * speeds[0] * KNOT / file.hull.length
    columns: dict[str, list[float] | float] = {"speed_kn": speeds}
    for i, name in enumerate(GAINS):
        key, factor = GAIN_UNITS.get(name, (name, 1.0))
        columns[key] = [round_digits(factor * row[i]) for row in rows]
    return columns | {
        "speed_integral": round_digits(surge),
        "turning_rate_deg_s": round_digits(math.degrees(turning)),
    }


def design_text(file: VesselFile) -> str:
    """Return the [autopilot] table as text for the vessel file."""
    lines = [f"{key} = {toml_value(value)}" for key, value in design_gains(file).items()]
    return "\n".join(["[autopilot]", *lines])
