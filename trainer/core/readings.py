"""What is read off a boat at a tick, for whatever is shown of it.

``write_readings`` computes them from the vessel and the state. What a boat lacks, and what nothing
is ordered of, reads NaN; so does a sounder without an echo. All are SI and radians; right, rising,
bow up, forward and inward are positive. Whoever shows them has units and decimals of its own. A
number that stands in the state as it is shown, such as the pitch, is read there.
"""

import math
from typing import Final

import numpy as np

from trainer.core.ballast.tanks import BANKS, FIRST_DRY, TANKS
from trainer.core.bottom import SOUNDING_STATIONS, keel_below
from trainer.core.casualties import GAUGES, SOUNDER, instruments
from trainer.core.elementary import arctangent, cosine_and_sine
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel, record_dtype
from trainer.core.kinematics import guard_cosine
from trainer.core.plant.oil import oil_pressure
from trainer.core.plant.power import bus_load
from trainer.core.sea.free_surface import sail_height
from trainer.core.sea.sea import DIRECTION, HEIGHT, OMEGA
from trainer.core.state import GROUND_DEPTH, SOUNDING_COUNT

TANK_NAMES: Final = [name.replace("compartment_", "flood_") for name in TANKS]
SURFACE_COUNT, CREW_AXIS_COUNT = 3, 4
COURSE, DEPTH, SPEED, PITCH = 0, 1, 2, 3  # of the orders to the crew
NOTHING: Final = math.nan
MIN_SHOWN_SPEED: Final = 0.005 * 1852.0 / 3600.0  # [m/s] below it a way has no direction
LONG_TURN: Final = math.radians(350.0)  # [rad] nearly round, the other way than was ordered

# fmt: off
READINGS: Final = record_dtype(
    # by the gauges, as wrong as these are
    ("gauge", ["depth", "heading", "speed", "sounding"]),  # [m] [rad] not wrapped [m/s] [m]
    ("angle", ["rudder", "stern", "bow"]),  # [rad]
    ("angle_ordered", ["ordered_rudder", "ordered_stern", "ordered_bow"]),  # [rad]
    # what is kept, by the autopilot or hovering
    "ordered_course",  # [rad] not wrapped
    "ordered_depth",  # [m]
    "ordered_speed",  # [m/s]
    "ordered_turns",  # [m/s] command speed that is asked for, by hand or by the autopilot
    # of the motion as it stands: those in the state are of when the last tick began
    "heel_rate", "pitch_rate", "turn_rate",  # [rad/s]
    "north_rate", "east_rate", "depth_rate",  # [m/s] over the ground, 0 of what is held
    "way",  # [m/s] over the ground
    "track",  # [rad] its direction; the heading without way
    "drift",  # [m/s] of the water at the boat
    "set",  # [rad] its direction
    ("tank_water", TANK_NAMES),  # [kg]
    ("tank_share", [f"{name}_full" for name in TANKS[:FIRST_DRY]]),  # [-]
    ("bank_pressure", list(BANKS)),  # [Pa]
    ("bank_share", [f"{name}_full" for name in BANKS]),  # [-]
    # orders to the crew, what is to go by the gauges, and how long they have stood
    ("crew_ordered", ["crew_course", "crew_depth", "crew_speed", "crew_pitch"]),
    ("crew_to_go", ["course_error", "depth_error", "speed_error", "pitch_error"]),
    ("crew_since", ["course_since", "depth_since", "speed_since", "pitch_since"]),  # [ticks]
    "heavy",  # [kg] heavier than its displacement
    "clearance",  # [m] of the keel over the ground
    "over_sail",  # [m] of water over the sail's top
    # the sea in force, and that ordered: height, period of its peak, where it comes from
    "height", "period", "origin",  # [m] [s] [rad] not wrapped
    "ordered_height", "ordered_period", "ordered_origin",
    # the plant: oil by system, tanks filled, buses, and what the battery has left
    ("oil_pressure", ["main_pressure", "vital_pressure"]),  # [Pa]
    ("oil_level", ["main_level", "vital_level"]),  # [m3] in the tanks
    ("bus_load", ["port_load", "starboard_load", "dc_load"]),  # [W]
    "charge",  # [-]
    "overload_left",  # [s] until a breaker opens
)
# fmt: on


def new_readings() -> Record:
    """Return a record of readings of zeros."""
    return np.zeros(1, READINGS)


@inline_kernel
def toward(vessel: Record, surface: int) -> float:
    """Return the sign [-] of a deflection that turns right or makes the boat rise.

    It is 0 if none does. The coefficients carry it: rudder by yawing moment, stern planes by
    pitching moment, bow planes by lift.
    """
    c = vessel[0]
    effect = c.N_dr
    if surface == 1:
        effect = c.M_ds
    elif surface > 1:
        effect = -c.Z_db
    if effect == 0.0:
        return 0.0
    return 1.0 if effect > 0.0 else -1.0


@inline_kernel
def wrapped(angle: float) -> float:
    """Return an angle [rad] as the one within half a turn."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def read_surfaces(vessel: Record, state: Record, readings: Record) -> None:
    """Write the angles of the surfaces [rad] and what is ordered of them."""
    s = state[0]
    out = readings[0]
    for i in range(SURFACE_COUNT):
        sign = toward(vessel, i)
        ordered = s.ordered[i] if s.by_hand[i] != 0.0 else s.command[i]
        out.angle[i] = s.surface[i] * sign if sign != 0.0 else NOTHING
        out.angle_ordered[i] = ordered * sign if sign != 0.0 else NOTHING


@kernel
def read_kept(state: Record, readings: Record) -> None:
    """Write what is kept: course, depth and speed; and the turns that are asked for."""
    s = state[0]
    out = readings[0]
    # one pair of planes keeps the depth, or the depth-control tank
    kept = s.stern_by_hand == 0.0 or s.bow_by_hand == 0.0 or s.hover != 0.0
    out.ordered_course = s.ordered_psi if s.rudder_by_hand == 0.0 else NOTHING
    out.ordered_depth = s.ordered_depth if kept else NOTHING
    out.ordered_speed = s.ordered_speed if s.speed_by_hand == 0.0 else NOTHING
    out.ordered_turns = s.ordered_u_c if s.speed_by_hand != 0.0 else s.command_u_c


@kernel
def read_rates(state: Record, readings: Record) -> None:
    """Write the rates of attitude and location of the motion as it stands, [ASSES] (7)."""
    s = state[0]
    out = readings[0]
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_psi, sin_psi = cosine_and_sine(s.psi)
    across, down = s.v * cos_phi - s.w * sin_phi, s.v * sin_phi + s.w * cos_phi
    along = s.u * cos_th + down * sin_th
    water_north = s.water_north + s.shear_north * s.z
    water_east = s.water_east + s.shear_east * s.z
    out.turn_rate = (s.q * sin_phi + s.r * cos_phi) / guard_cosine(cos_th)
    out.heel_rate = s.p + out.turn_rate * sin_th
    out.pitch_rate = s.q * cos_phi - s.r * sin_phi
    # a held boat sails on unseen, which nobody is to be told
    out.north_rate = out.east_rate = out.depth_rate = 0.0
    if s.held_position == 0.0:
        out.north_rate = along * cos_psi - across * sin_psi + water_north
        out.east_rate = along * sin_psi + across * cos_psi + water_east
    if s.held_depth == 0.0:
        out.depth_rate = down * cos_th - s.u * sin_th
    out.way = math.sqrt(out.north_rate * out.north_rate + out.east_rate * out.east_rate)
    makes_way = out.way >= MIN_SHOWN_SPEED
    out.track = arctangent(out.east_rate, out.north_rate) if makes_way else s.psi
    out.drift = math.sqrt(water_north * water_north + water_east * water_east)
    out.set = arctangent(water_east, water_north) if out.drift >= MIN_SHOWN_SPEED else NOTHING


@kernel
def read_ballast(vessel: Record, state: Record, readings: Record) -> None:
    """Write water [kg] and air [Pa], and how full tanks and banks are [-]."""
    c = vessel[0]
    s = state[0]
    out = readings[0]
    for i in range(c.capacity.size):
        whole = c.capacity[i]
        out.tank_water[i] = s.water[i] if whole != 0.0 else NOTHING
        if i < out.tank_share.size:
            out.tank_share[i] = s.water[i] / whole if whole != 0.0 else NOTHING
    for i in range(c.bank_volume.size):
        volume, full = c.bank_volume[i], c.bank_full[i]
        out.bank_pressure[i] = s.bank[i] * c.gas / volume if volume != 0.0 else NOTHING
        out.bank_share[i] = s.bank[i] / full if full != 0.0 else NOTHING
    out.heavy = (s.weight - c.buoyancy) / c.g


@kernel
def read_crew_orders(state: Record, readings: Record) -> None:
    """Write the orders to the crew, what is to go, and their age [ticks]."""
    s = state[0]
    out = readings[0]
    for i in range(CREW_AXIS_COUNT):
        stands = s.crew_order_tick[i] != 0.0
        out.crew_ordered[i] = s.crew_order[i] if stands else NOTHING
        out.crew_since[i] = s.tick - s.crew_order_tick[i] + 1.0 if stands else NOTHING
    to_go = out.crew_ordered[COURSE] - out.heading
    shorter = s.crew_course_side == 0.0 or abs(to_go) > LONG_TURN
    if shorter and s.crew_order_tick[COURSE] != 0.0:
        to_go = wrapped(to_go)
    out.crew_to_go[COURSE] = to_go
    out.crew_to_go[DEPTH] = out.crew_ordered[DEPTH] - out.depth
    out.crew_to_go[SPEED] = out.crew_ordered[SPEED] - out.speed
    out.crew_to_go[PITCH] = out.crew_ordered[PITCH] - s.theta


@kernel
def read_surroundings(vessel: Record, state: Record, readings: Record) -> None:
    """Write the water over the sail, the keel over the ground, and the sea."""
    s = state[0]
    out = readings[0]
    cos_phi, _ = cosine_and_sine(s.phi)
    cos_th, sin_th = cosine_and_sine(s.theta)
    out.over_sail = -sail_height(vessel, state)
    out.clearance = NOTHING
    if s.bottom[GROUND_DEPTH, 0] != 0.0:
        least, lean = math.inf, vessel[0].ell * sin_th
        for i in range(SOUNDING_COUNT):
            least = min(least, s.bottom[GROUND_DEPTH, i] + SOUNDING_STATIONS[i] * lean)
        out.clearance = least - s.z - keel_below(vessel) * cos_th * cos_phi
    out.height, out.ordered_height = s.sea[HEIGHT], s.sea_target[HEIGHT]
    out.period, out.ordered_period = peak_period(s.sea), peak_period(s.sea_target)
    out.origin, out.ordered_origin = origin(s.sea), origin(s.sea_target)


@inline_kernel
def peak_period(sea: Numbers) -> float:
    """Return the period [s] of a sea's peak, nothing in a calm."""
    return 2.0 * math.pi / sea[OMEGA] if sea[HEIGHT] != 0.0 else NOTHING


@inline_kernel
def origin(sea: Numbers) -> float:
    """Return where a sea comes from [rad], nothing in a calm."""
    return sea[DIRECTION] + math.pi if sea[HEIGHT] != 0.0 else NOTHING


@kernel
def read_plant(vessel: Record, state: Record, readings: Record) -> None:
    """Write pressures, levels, loads and charge of the plant, nothing where there is none."""
    c, s = vessel[0], state[0]
    out = readings[0]
    if c.battery_full == 0.0:
        for i in range(2):
            out.oil_pressure[i] = out.oil_level[i] = NOTHING
        for i in range(3):
            out.bus_load[i] = NOTHING
        out.charge = out.overload_left = NOTHING
        return
    for i in range(2):
        out.oil_pressure[i] = oil_pressure(vessel, i, state)
        out.oil_level[i] = c.oil_reserve[i] + s.tank_gain[i]
    for i in range(3):
        out.bus_load[i] = bus_load(vessel, i, state)
    out.charge = 1.0 - s.battery_spent / c.battery_full
    out.overload_left = c.overload_time - s.overload if s.overload > 0.0 else NOTHING


@kernel
def write_readings(vessel: Record, state: Record, scratch: Record, readings: Record) -> None:
    """Write all that is read off a boat at a tick."""
    out = readings[0]
    instruments(state, scratch)
    for gauge in range(len(GAUGES)):
        out.gauge[gauge] = scratch[0].reading[gauge]
    if out.gauge[SOUNDER] == 0.0:
        out.gauge[SOUNDER] = NOTHING
    read_surfaces(vessel, state, readings)
    read_kept(state, readings)
    read_rates(state, readings)
    read_ballast(vessel, state, readings)
    read_crew_orders(state, readings)
    read_surroundings(vessel, state, readings)
    read_plant(vessel, state, readings)
