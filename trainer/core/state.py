"""The one flat state record, and the work space of one boat's kernels.

The state has everything that evolves, standing orders included, so that a snapshot, a replay, a
backtrack and an ensemble are copies of it. All fields are float64.

A tick reads nothing that an earlier tick left in the work space, except what follows from the sea
in force, the waves met, the step and the boat. That part is a pure function of them. It is computed
whenever it does not fit them, so that a snapshot need not hold it.
"""

from typing import Final

import numpy as np

from trainer.core.kernel import Field, Record, record_dtype

# [m/s] [m/s] [m/s] [rad/s] [rad/s] [rad/s] [rad] [rad] [rad] [m] [m] [m]
MOTION: Final = ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "x", "y", "z"]
# time derivatives of the above; those of the last cycle until this one has computed its own
RATES: Final = [f"{name}dot" for name in MOTION]
PHI, THETA, PSI = 6, 7, 8  # indices in them
P, Q, R = 0, 1, 2  # indices in a turn about the body's axes
AXIAL, LATERAL, NORMAL = 0, 1, 2  # indices in forces and accelerations: X, Y, Z
ROLLING, PITCHING, YAWING = 3, 4, 5  # K, M, N

PAST_CYCLES: Final = 3  # past cycles an integrator may look back on, beside the last

# the quantities of a sea, each ramped when another is ordered
SEA_QUANTITIES: Final = [
    "sea_height",  # [m] significant height, 4 standard deviations of the elevation
    "sea_omega",  # [rad/s] frequency of the spectrum's peak
    "sea_gamma",  # [-] how much its peak is raised; 1: Pierson-Moskowitz and Bretschneider
    "sea_direction",  # [rad] direction in which the waves travel, clockwise from north
    "sea_cosines",  # [-] share of the variance from the cosine sum, the rest from filters
    "sea_suction",  # [-] factor on the second-order upward force
    "sea_1969",  # [-] share of the filters' variance from that of 1969
    "sea_peaked",  # [-] share of the rest of it from the bank of the peaked spectrum
]
SEA_COMPONENTS: Final = 50
SOUNDING_COUNT: Final = 5  # stations along the hull where the ground below it is looked at
GROUND_DEPTH, GROUND_NORTH, GROUND_EAST = 0, 1, 2  # rows of soundings: depth, its slopes
STRIP_COUNT: Final = 7  # of the hull, on which waves push
STRIP_ROWS: Final = 96  # wave numbers beside 0 at which their sums are tabulated
MAX_CASUALTIES: Final = 8  # at a time
VALVES: Final = ("forward", "mid", "aft", "negative")  # blow valves and vents have these

# fmt: off
STATE: Final = record_dtype(
    "tick",  # [-] ticks done since the start of the run
    ("motion", MOTION),
    ("rates", RATES),
    ("past_rates", (PAST_CYCLES, 12)),  # rates of one, two and three cycles ago
    ("past_motion", (PAST_CYCLES, 12)),
    "history",  # [-] how many past cycles are true; 0 after a start or a jump
    "substep",  # [s] present step of the variable-step Runge-Kutta, 0 before its first
    ("largest", (12,)),  # largest |motion| so far, to which its tolerance is relative
    # weight and balance
    "weight",  # [N]
    "x_g",  # [m] centre of gravity
    "y_g",
    "z_g",
    # control surfaces and propeller as they are
    ("surface", ["delta_r", "delta_s", "delta_b"]),  # [rad] rudder, stern planes, bow planes
    "u_c",  # [m/s] command speed: propeller revolutions times a constant
    # the same as commanded in this tick, by hand or by the autopilot
    ("command", ["command_r", "command_s", "command_b"]),
    "command_u_c",
    # standing orders
    (
        "ordered_place",
        [
            "ordered_depth",  # [m]
            "ordered_psi",  # [rad] unwrapped heading to steer
        ],
    ),
    "ordered_speed",  # [m/s] speed to keep
    "ordered_u_c",  # [m/s] command speed by bell or revolutions
    ("ordered", ["ordered_r", "ordered_s", "ordered_b"]),  # [rad] surfaces by hand
    # [-] 1 by hand, 0 by the autopilot
    ("by_hand", ["rudder_by_hand", "stern_by_hand", "bow_by_hand"]),
    "speed_by_hand",  # [-] 1 constant revolutions, 0 speed kept by the autopilot
    "depth_law",  # [-] see autopilot: 0 this trainer's, 1 and 2 [ASSES]'s
    # autopilot memory
    (
        "reference",
        [
            "depth_reference",  # [m] ordered depth as slewed
            "psi_reference",  # [rad]
        ],
    ),
    (
        "reference_rate",
        [
            "depth_reference_rate",  # [m/s]
            "psi_reference_rate",  # [rad/s]
        ],
    ),
    ("integral", ["rudder_integral", "stern_integral", "bow_integral"]),  # [rad]
    # [rad] rest of a surface's angle by hand, after the autopilot took it over
    ("handover", ["rudder_handover", "stern_handover", "bow_handover"]),
    "speed_trim",  # [m/s]
    # engine telegraph
    "telegraph_order",  # [m/s] last order that was heard
    "telegraph_answer",  # [m/s] order that is acted upon
    "telegraph_ticks",  # [-] ticks until the order heard is acted upon
    "eta_wave",  # [m] surface elevation above the boat
    # the sea in force, the one ordered, and the time until they are the same
    ("sea", SEA_QUANTITIES),
    ("sea_target", (len(SEA_QUANTITIES),)),
    "sea_ramp",  # [s]
    "sea_taper",  # [-] 1: no waves below five hull diameters
    "seed",  # [-] of every random number, a whole number below 2^53
    ("sea_memory", (8,)),  # [-] of the four sections of the wave filter of 1969
    "sea_drift",  # [rad] phase of the peak wave that the boat has run through
    "sea_elevation",  # [-] its elevation above the boat, of variance 1
    "sea_quadrature",  # [-] the same a quarter of a period ago
    "sea_turned",  # [rad] the phases of the cosine sum follow from it, see cosine_sum
    "sea_along",
    "sea_across",
    # ballast aboard, in the order of tanks.TANKS and tanks.BANKS
    (
        "water",  # [kg]
        [
            "water_forward", "water_mid", "water_aft", "water_negative",
            "water_trim_forward", "water_trim_aft", "water_auxiliary", "water_depth_control",
            "flood_forward", "flood_centre", "flood_aft",
        ],
    ),
    ("tank_air", ["air_forward", "air_mid", "air_aft", "air_negative"]),  # [kg]
    ("bank", ["bank_main", "bank_emergency"]),  # [kg]
    "water_taken",  # [kg] from the sea since the start, less what went back
    "air_taken",  # [kg] from outside banks and tanks, less what was lost
    # ballast orders; valves [-] 0 shut, 1 open, blow 2 the emergency valve as well
    ("vent", ["vent_forward", "vent_mid", "vent_aft", "vent_negative"]),
    ("blow", ["blow_forward", "blow_mid", "blow_aft", "blow_negative"]),
    "negative_flood",  # flood valve of the negative tank; without it that tank is sealed
    # [kg] still to be moved: trim forward, the others in from the sea; negative the other way
    ("to_move", ["move_trim", "move_auxiliary", "move_depth_control"]),
    "drained",  # [-] compartment being pumped out: 1, 2, 3 from forward; 0 none
    "compressor",  # [-] 1 on
    "hover",  # [-] 1 on, at ordered_depth
    "hover_integral",  # [kg]
    # ballast faults, 0 sound
    (
        "breach",  # [m2] holes
        [
            "leak_trim_forward", "leak_trim_aft", "leak_auxiliary", "leak_depth_control",
            "breach_forward", "breach_centre", "breach_aft",
        ],
    ),
    # [-] share of the rate lost
    ("pump_fault", ["pump_fault_trim", "pump_fault_drain", "pump_fault_depth_control"]),
    ("bank_fault", ["bank_fault_main", "bank_fault_emergency"]),
    # [-] share of the opening lost; a vent's is negative when it is stuck open so far
    ("blow_fault", [f"blow_fault_{name}" for name in VALVES]),
    ("vent_fault", [f"vent_fault_{name}" for name in VALVES]),
    # casualties, by slot: see casualties
    ("casualty", (MAX_CASUALTIES,)),  # [-] kind, 0 none
    ("casualty_amount", (MAX_CASUALTIES,)),  # [SI] by kind, at present
    ("casualty_target", (MAX_CASUALTIES,)),  # [SI]
    ("casualty_ticks", (MAX_CASUALTIES,)),  # [-] left; negative while it is cleared
    "triggers_spent",  # [-] one bit for each trigger that has fired
    # partial freezes: see update
    ("held", ["held_depth", "held_position", "held_tanks"]),  # [-] 1 held
    ("sailed", ["sailed_x", "sailed_y"]),  # [m] x and y as they would be without the hold
    # beyond the range of the coefficients: see envelope and integrators
    ("last_turn", ["last_p", "last_q", "last_r"]),  # [rad/s] of the last step or substep
    "last_step",  # [s] its length
    "polar",  # [-] 1: that step was flown near the vertical
    "validity",  # [-] of the equations: 0 inside their range, 1 extrapolated, 2 outside
    # the wave filter: see wave_filter
    ("sea_modes", (2, 8)),  # [-] by bank, real parts first
    ("sea_spare", (2,)),  # [-] by bank: the second of a pair of deviates, for the next step
    ("sea_past", (4, 4)),  # [-] outputs of its last four internal steps, each by its number
    "sea_clock",  # [-] share of an internal step since the last step but two
    "sea_steps",  # [-] internal steps done
    # [-] above the boat: elevation, the same a quarter of a period ago, and both of the force
    ("sea_waves", ["wave_cos", "wave_sin", "push_cos", "push_sin"]),
    "push_number",  # [1/m] wave number of the force
    # memory of depth, course, speed and trim keeping: see autopilot
    "speed_followed",  # [m/s] speed without the part that waves make
    "turn_followed",  # [rad/s] yaw rate without the part that waves make
    "speed_order",  # [m/s] ordered speed of the last tick
    "speed_since",  # [s] since another speed was ordered
    "speed_rate_1",  # [m/s2] of the trim, past one low-pass and past two
    "speed_rate_2",
    "speed_short",  # [s] for which the engine has given all, and it was not enough
    "wave_slow",  # [m/s] slow part of the depth rate
    "wave_band",  # [m/s] rest of the depth rate
    "wave_power",  # [m2/s2] mean square of that rest
    "wave_since",  # [s] since that rest last rose through zero
    "wave_period",  # [s] mean time between such crossings
    "wave_count",  # [-] number of such crossings, as far as it matters
    "wave_share",  # [-] of the law for waves, 0 in a calm
    ("notch", (12,)),  # [rad] of two notches, stern planes and bow planes: see waves
    "ascent",  # [-] in a blow: 1 on the way up, 2 afloat, 0 none
    "ascent_pitch",  # [rad] pitch to be held, as it is taken up
    "ascent_quiet",  # [s] for which the boat has come to rest
    ("hover_filter", (9,)),  # [m] of two notches and a low-pass: see sections
    "hover_notched",  # [-] 1: the notches are in use
    "hover_error",  # [m] past the filter
    "hover_error_rate",  # [m/s]
    "hover_room",  # [m] error beyond which hovering is given up
    "hover_order",  # [m] ordered depth of the last tick
    "hover_time",  # [s] since hovering began
    "hover_full",  # [s] for which the pump has been at its most
    "hover_lost",  # [-] 1: given up
    "trim_by_hand",  # [-] 1 by hand, 0 automatic
    "trim_lift",  # [N] carried by the planes, and its moment
    "trim_moment",  # [N m]
    "trim_pitch",  # [rad] mean pitch
    "trim_flood",  # [kg] to be let into the auxiliary tank in this tick
    "trim_forward",  # [kg] to be moved forward in this tick
    # the plant, 0 where it is well: see plant. Until it is touched, a tick passes it by
    "plant_touched",  # [-] 1
    ("oil_spent", ["oil_spent_main", "oil_spent_vital"]),  # [m3] out of the accumulators
    ("tank_gain", ["tank_gain_main", "tank_gain_vital"]),  # [m3] in the oil's tanks since the start
    # [-] 0 standing by, 1 running, 2 stopped
    ("hydraulic_pump", ["hydraulic_pump_1", "hydraulic_pump_2", "hydraulic_pump_vital"]),
    (
        "isolated",  # [-] 1: legs of the surfaces, then systems
        [
            "rudder_isolated", "stern_isolated", "bow_isolated",
            "main_isolated", "vital_isolated",
        ],
    ),
    ("mode", ["rudder_mode", "stern_mode", "bow_mode"]),  # [-] 0 normal, 1 emergency, 2 hand
    ("mode_ordered", ["rudder_mode_ordered", "stern_mode_ordered", "bow_mode_ordered"]),
    # [-] until shifted; negative: just ordered
    ("mode_ticks", ["rudder_mode_ticks", "stern_mode_ticks", "bow_mode_ticks"]),
    ("bus_dead", ["port_dead", "starboard_dead", "dc_dead"]),  # [-] 1
    ("breaker_open", ["port_open", "starboard_open"]),  # [-] 1
    "bus_tie",  # [-] 1 shut
    "overload",  # [s] for which a breaker has given too much
    "loads_shed",  # [-] 1
    "unpowered",  # [-] a bit for each consumer
    "battery_spent",  # [J]
    "cells_gone",  # [-] share of the charge that went with lost cells
    "dip_time",  # [s] for which the power has dipped
    "gyro_unfed",  # [s]
    ("gauge_held", ["gyro_held", "log_held", "sounder_held"]),  # what they read without power
    (
        "plant_fault",  # [-] shares, [m3/s] leaks, [s] the dip
        [
            "main_pump_fault", "vital_pump_fault",
            "header_leak", "rudder_leg_leak", "stern_leg_leak", "bow_leg_leak",
            "port_fault", "starboard_fault", "dc_fault", "cells_fault", "power_dip",
            "fire_fault_forward", "fire_fault_control", "fire_fault_aft",
        ],
    ),
    # by compartment [-]: size of the fire, how much of its fault has kindled it, and smoke
    ("fire", ["fire_forward", "fire_control", "fire_aft"]),
    ("kindled", (3,)),
    ("burnt", (3,)),  # [s] of a whole fire
    ("smoke", ["smoke_forward", "smoke_control", "smoke_aft"]),
    "ventilation",  # [-] 0 runs, 1 secured, 2 exhausts
    "fighting",  # [-] compartment whose fire is fought: 1, 2, 3 from forward; 0 none
    "fight_ticks",  # [-] until the party fights it; negative: just ordered
    # orders to the crew, which no kernel reads: course, depth, speed and pitch
    (
        "crew_order",
        [
            "crew_course",  # [rad]
            "crew_depth",  # [m]
            "crew_speed",  # [m/s]
            "crew_pitch",  # [rad] bow up
        ],
    ),
    ("crew_order_tick", (4,)),  # [-] tick after which it was given, plus 1; 0 none
    "crew_course_side",  # [-] way to turn: -1 left, 1 right, 0 the shorter
    "crew_depth_unit",  # [m] unit in which the depth was said: 1, or a foot
    # the world around the boat, written from outside before each tick; zero where there is none
    (
        "current",  # of the water over ground: north = water_north + shear_north z
        [
            "water_north", "water_east",  # [m/s]
            "shear_north", "shear_east",  # [1/s]
        ],
    ),
    ("through", ["through_north", "through_east"]),  # [m/s] rates of location through the water
    ("bottom", (3, SOUNDING_COUNT)),  # [m] depth along the hull, its slopes north and east; 0: none
    "bottom_load",  # [N] that the ground carries
    "aground",  # [-] ticks for which it has
    ("ship_force", (6,)),  # [N] and [N m] of ships near
)
# fmt: on

STATE_FIELDS: Final = [name for name in STATE.names or () if STATE.fields and name != "whole"]


def offset_of(name: str) -> int:
    """Return the offset in the state [-] of a field."""
    return int((STATE.fields or {})[name][1]) // 8  # type: ignore[index]


def new_state() -> Record:
    """Return a state record of zeros."""
    return np.zeros(1, STATE)


SECTION_NUMBERS: Final = 5  # of a filter's section, see autopilot/sections
FILTER_DEGREE: Final = 9  # of the filter's denominator with the pole of the bilinear transform

SEA_FIELDS: Final[tuple[Field, ...]] = (
    # wave filter of 1969, and the frequency and step for which it is made
    "omega",  # [rad/s]
    "h",  # [s]
    ("low", ["low_a1", "low_a2"]),  # [-] section y = w ..., w = x - a1 w' - a2 w''
    ("high", ["high_a1", "high_a2"]),
    "elevation_gain",  # [-] from the low-pass section to an output of variance 1
    "quadrature_gain",
    # sine and cosine of the sea's direction, and the direction that they are of
    "direction",  # [rad]
    ("toward", ["toward_north", "toward_east"]),  # [-]
    ("force_rows", (2, 8, 2)),  # [-] of the wave filter, by bank, for the depth of the tick
    # cosine sum, and the peakedness and seed for which it is made
    "gamma",  # [-]
    "seed",
    ("relative", (SEA_COMPONENTS,)),  # [-] frequency over that of the peak
    ("phase_start", (SEA_COMPONENTS,)),  # [rad]
    ("amplitude", (SEA_COMPONENTS,)),  # [-] for variance 1
    # its components' phases above the boat, then what each pulls with
    ("phase_cos", (SEA_COMPONENTS,)),  # [-]
    ("phase_sin", (SEA_COMPONENTS,)),
    ("pull_cos", (SEA_COMPONENTS,)),  # [m/s2]
    ("pull_sin", (SEA_COMPONENTS,)),
    # work space of the wave forces
    "g",  # [m/s2]
    "depth",  # [m]
    "ell",  # [m]
    "along",  # [-] cosine and sine of a wave's way off the boat's heading
    "across",
    "kappa",  # [-] its number along the boat times the boat's length
    ("station", (5,)),  # [m] along the boat, where the water's level is wanted
    "levels",  # [-] 1: that level is wanted
    ("level", (5,)),  # [m]
    ("rise", (5,)),  # [m/s]
    ("pull", (12,)),  # sums over the waves: see forces
    # sums over the hull's strips by wave number, and those strips: see forces
    ("strip_sums", (STRIP_ROWS + 1, 3, 4)),  # [-]
    ("strips_of", (4, STRIP_COUNT)),
    # work space of the variance of a filter's output
    ("a", (FILTER_DEGREE + 1,)),
    ("b", (FILTER_DEGREE + 1,)),
    ("d", (FILTER_DEGREE + 1,)),
    "elevation_power",
    "quadrature_power",
)

SEA: Final = record_dtype(*SEA_FIELDS)


def new_sea() -> Record:
    """Return a record that fits no sea and is filled on first use."""
    return np.zeros(1, SEA)


SCRATCH: Final = record_dtype(
    ("external", (6,)),  # forces [N] and moments [N m] of this tick from sea and surface
    ("near", (6,)),  # the same with those of the water's surface at this moment
    ("felt", (6,)),  # the same less the lift of surfaces that stall
    ("wide", (6,)),  # accelerations of the wide set
    "cut",  # [-] 1: the water's surface cuts the hull
    ("turn", (3,)),  # [rad/s] weighted body rates of a Runge-Kutta step, and those of a stage
    ("spin", (3,)),
    ("force", (6,)),  # right sides of the six equations, less the accelerations
    ("inertia", (6, 6)),  # their coefficients on the left
    ("system", (6, 7)),  # work space of the linear solve
    ("jacobian", (7, 8)),  # of the trim, and its Newton step
    ("change", (7,)),
    ("start", (12,)),  # motion at the start of a Runge-Kutta step, and its weighted slopes
    ("slope", (12,)),
    ("origin", (12,)),  # motion and rates at the start of a variable step, to try it again from
    ("origin_rates", (12,)),
    ("coarse", (12,)),  # the variable step taken whole
    ("gains", (20,)),  # autopilot gains at the present speed
    # depth keeping in waves: factors, then two notches and the period and step they are made for
    "law_factor",  # [-]
    "pitch_rate_factor",  # [-]
    "learning",  # [-]
    "notch_period",  # [s]
    "notch_h",  # [s]
    ("lower_notch", (SECTION_NUMBERS,)),  # [-]
    ("upper_notch", (SECTION_NUMBERS,)),
    # the share of its way that the propeller goes in a tick, and the step [s] and lag [s] of it
    "lag_h",
    "lag",
    "lag_share",  # [-]
    ("reading", (4,)),  # of depth gauge [m], gyro [rad], log [m/s], sounder [m]
    *SEA_FIELDS,
    ("before", (STATE.itemsize // 8,)),  # the state before the tick
)


def new_scratch() -> Record:
    """Return a work space of zeros."""
    return np.zeros(1, SCRATCH)
