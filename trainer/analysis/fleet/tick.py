"""A tick of boats side by side: one boat's kernels, for every lane.

Only a boat that ``supports_boat`` passes moves here. One that comes up from the deep, or loses its
numbers, strays: its lane goes on with numbers that mean nothing. The kernel that flies the block
then flies that member again by ``update``, whose bits are otherwise those of a lane.
"""

from trainer.analysis.fleet.block import (
    ADAMS_TERMS,
    BRACKET_BELOW,
    BRACKET_TOP,
    GAIN_RISES,
    LOW_GAINS,
    LOW_SPEED,
    SPEED_RISE,
    bracket_gains,
    compact_in,
    state_in,
    vessel_in,
    work_in,
)
from trainer.analysis.fleet.lanes import (
    as_float,
    every_lane,
    nearest,
    relay_kernel,
    times_power_of_two,
)
from trainer.core.actuators import move_surfaces
from trainer.core.autopilot.course import keep_course
from trainer.core.autopilot.depth import keep_depth
from trainer.core.autopilot.reference import slew_course, slew_depth
from trainer.core.autopilot.speed import keep_speed
from trainer.core.autopilot.steering import GAIN_COUNT, fade
from trainer.core.compact import (
    add_external,
    forces,
    further_forces,
    lagged_rates,
    slip_forces,
)
from trainer.core.elementary import cosine_and_sine_of_any
from trainer.core.envelope import AHEAD, BY_FLOW_FLOW, BY_N_FLOW, BY_N_N, cross_speed_squared
from trainer.core.integrators import adams_of
from trainer.core.kernel import Numbers, Record, inlined, kernel
from trainer.core.kinematics import attitude_of, kinematics
from trainer.core.propulsion import answer_telegraph
from trainer.core.stall import incidence
from trainer.core.update import lost


@inlined
def _no_slot(_kind: int, _state: Record) -> int:
    """Return -1: no casualty of this kind."""
    return -1


@inlined
def _no_fault(_surface: int, _state: Record) -> int:
    """Return -1: no casualty of this surface."""
    return -1


@inlined
def _no_waves(_h: float, _work: Record, _state: Record, _surface: int, _law: float) -> None:
    """Do nothing: there are no waves."""


@inlined
def _in_a_calm(_state: Record, _surface: int, law: float) -> float:
    """Return a law [rad] unchanged, because there are no waves."""
    return law


@inlined
def _learning_in_a_calm(_work: Record, _state: Record) -> float:
    """Return 1: there are no waves."""
    return 1.0


@inlined
def _not_softened(_vessel: Record, _h: float, _work: Record, _state: Record) -> None:
    """Do nothing likewise."""


@inlined
def _no_engine_limit(_vessel: Record, wanted: float, _state: Record) -> float:
    """Return the command speed [m/s] as it is wanted: a boat at its limit strays."""
    return wanted


@inlined
def _history_is_true(_state: Record) -> None:
    """Do nothing: the past is complete."""


@inlined
def _interpolate(u: float, gains: Numbers) -> None:
    """Write the gains for speed ``u`` [m/s] between those of its bracket."""
    share = (u - gains[LOW_SPEED]) / gains[SPEED_RISE]
    share = min(max(share, 0.0), 1.0)
    for i in range(GAIN_COUNT):
        gains[i] = gains[LOW_GAINS + i] + share * gains[GAIN_RISES + i]


LANE_KERNELS = {
    "_nearest": nearest,
    "_as_float": as_float,
    "_times_power_of_two": times_power_of_two,
}
_both = relay_kernel(cosine_and_sine_of_any, LANE_KERNELS)


@inlined
def _sine(x: float) -> float:
    """Return sin x [-] by both series: a lane cannot choose one, and may need the other too."""
    return _both(x)[1]


@inlined
def _cosine(x: float) -> float:
    """Return cos x [-] by both series, for the same reason."""
    return _both(x)[0]


LANE_REPLACEMENTS = {
    **LANE_KERNELS,
    "cosine_and_sine": _both,
    "sine": _sine,
    "cosine": _cosine,
    "slot_of": _no_slot,
    "fault_of": _no_fault,
    "remember": _history_is_true,
    "within_engine": _no_engine_limit,
    "pass_notches": _no_waves,
    "law_in_waves": _in_a_calm,
    "soften": _not_softened,
    "learning_in_waves": _learning_in_a_calm,
}
_slew_depth = relay_kernel(slew_depth, LANE_REPLACEMENTS)
_slew_course = relay_kernel(slew_course, LANE_REPLACEMENTS)
_keep_depth = relay_kernel(keep_depth, LANE_REPLACEMENTS)
_keep_course = relay_kernel(keep_course, LANE_REPLACEMENTS)
_fade = relay_kernel(fade, LANE_REPLACEMENTS)
_keep_speed = relay_kernel(keep_speed, LANE_REPLACEMENTS)
_forces = relay_kernel(forces, LANE_REPLACEMENTS)
_every_force = relay_kernel(further_forces, LANE_REPLACEMENTS)
_every_slip = relay_kernel(slip_forces, LANE_REPLACEMENTS)
_add_external = relay_kernel(add_external, LANE_REPLACEMENTS)
_lagged = relay_kernel(lagged_rates, LANE_REPLACEMENTS)
_attitude = relay_kernel(attitude_of, LANE_REPLACEMENTS)
_kinematics = relay_kernel(kinematics, LANE_REPLACEMENTS)
_adams = relay_kernel(adams_of, LANE_REPLACEMENTS)
_move_surfaces = relay_kernel(move_surfaces, LANE_REPLACEMENTS)
_answer_telegraph = relay_kernel(answer_telegraph, LANE_REPLACEMENTS)
_lost = relay_kernel(lost, LANE_REPLACEMENTS)
_cross = relay_kernel(cross_speed_squared, LANE_REPLACEMENTS)
_incidence = relay_kernel(incidence, LANE_REPLACEMENTS)
ENGINE_LIMIT_SHARE = 1.0 - 1e-9  # [-] of the engine's limits; beyond it a boat flies alone
STEEP_PITCH_RAD = 1.3  # [rad] pitch, somewhat below that at which the angles are turned


@inlined
def _further_forces(compact: Record, state: Record, force: Numbers) -> None:
    """Add the further terms of a lane that has some.

    The forces of another lane stay, signs of zeros too.
    """
    f0, f1, f2, f3, f4, f5 = force[0], force[1], force[2], force[3], force[4], force[5]
    _every_force(compact, state, force)
    if compact[0].extended == 0.0:
        force[0], force[1], force[2], force[3], force[4], force[5] = f0, f1, f2, f3, f4, f5


@inlined
def _slip_forces(compact: Record, state: Record, force: Numbers) -> None:
    """Add the terms of slip of a lane that has some, likewise."""
    f0, f1, f2, f3, f4, f5 = force[0], force[1], force[2], force[3], force[4], force[5]
    _every_slip(compact, state, force)
    if compact[0].slipping == 0.0:
        force[0], force[1], force[2], force[3], force[4], force[5] = f0, f1, f2, f3, f4, f5


@kernel
def keep_gains(out: Numbers) -> None:
    """Find new gains where a lane has left its bracket of speeds."""
    outside_count = 0
    for lane in every_lane():
        gains = work_in(out, lane)[0].gains
        u = state_in(out, lane)[0].u
        outside_count += 1 if u <= gains[BRACKET_BELOW] or u > gains[BRACKET_TOP] else 0
    if outside_count > 0:
        for lane in every_lane():
            bracket_gains(lane, out)


@kernel
def aim_autopilot(h: float, out: Numbers) -> None:
    """Write the gains, and the references of the autopilot."""
    for lane in every_lane():
        gains = work_in(out, lane)[0].gains
        _interpolate(state_in(out, lane)[0].u, gains)
        _slew_depth(h, gains, state_in(out, lane))
        _slew_course(h, gains, state_in(out, lane))


@kernel
def command_controls(h: float, out: Numbers) -> None:
    """Write the commands of surfaces and revolutions. As one loop it would not be vector code."""
    for lane in every_lane():
        _keep_depth(vessel_in(out, lane), h, work_in(out, lane), state_in(out, lane))
    for lane in every_lane():
        _keep_course(vessel_in(out, lane), h, work_in(out, lane)[0].gains, state_in(out, lane))
    for lane in every_lane():
        _fade(vessel_in(out, lane), h, state_in(out, lane))
    for lane in every_lane():
        _keep_speed(vessel_in(out, lane), h, state_in(out, lane))


@kernel
def compute_forces(trig: int, out: Numbers) -> None:
    """Write the forces."""
    extended = slipping = 0
    for lane in every_lane():
        state = state_in(out, lane)
        _forces(compact_in(out, lane), _attitude(trig, state), state, work_in(out, lane)[0].force)
        extended += 1 if compact_in(out, lane)[0].extended != 0.0 else 0
        slipping += 1 if compact_in(out, lane)[0].slipping != 0.0 else 0
    if extended > 0:
        for lane in every_lane():
            _further_forces(compact_in(out, lane), state_in(out, lane), work_in(out, lane)[0].force)
    if slipping > 0:
        for lane in every_lane():
            _slip_forces(compact_in(out, lane), state_in(out, lane), work_in(out, lane)[0].force)
    for lane in every_lane():
        work = work_in(out, lane)[0]
        _add_external(compact_in(out, lane), work.external, work.force)


@kernel
def find_outside(h: float, out: Numbers) -> None:
    """Find the lanes outside the range of the equations, or with stalled planes."""
    for lane in every_lane():
        c, s = vessel_in(out, lane)[0], state_in(out, lane)[0]
        work = work_in(out, lane)[0]
        cross = _cross(vessel_in(out, lane), state_in(out, lane))
        inside = 1.0 if s.u > 0.0 and cross <= c.handover_from * s.u * s.u else 0.0
        level = 1.0 if abs(s.theta) < STEEP_PITCH_RAD and abs(s.phi) < STEEP_PITCH_RAD else 0.0
        even = 1.0 if s.last_step in (h, 0.0) else 0.0
        work.strayed += 1.0 - inside * level * even
        for i in range(3):
            lift = abs(_incidence(vessel_in(out, lane), i, state_in(out, lane)))
            work.strayed += 0.0 if lift <= s.u * c.stall_ahead[i] else 1.0


@kernel
def compute_rates(trig: int, out: Numbers) -> None:
    """Write the rates, and find the lanes that are not deep."""
    for lane in every_lane():
        s, work = state_in(out, lane)[0], work_in(out, lane)[0]
        shallow = 0.0 if s.z > work.hull_clear else 1.0
        work.strayed += shallow + (0.0 if s.z >= work.tables_clear else 1.0)
        _lagged(compact_in(out, lane), work.force, state_in(out, lane))
        _kinematics(_attitude(trig, state_in(out, lane)), state_in(out, lane))


@kernel
def advance_motion(scheme: Record, out: Numbers) -> None:
    """Advance the motion."""
    for lane in every_lane():
        s = state_in(out, lane)[0]
        s.last_p, s.last_q, s.last_r, s.last_step = s.p, s.q, s.r, scheme[0].h
        _adams(scheme, ADAMS_TERMS, state_in(out, lane))
        s.sailed_x, s.sailed_y = s.x, s.y


@kernel
def deflect_surfaces(h: float, out: Numbers) -> None:
    """Move the surfaces."""
    for lane in every_lane():
        _move_surfaces(vessel_in(out, lane), h, state_in(out, lane))


@kernel
def advance_command_speed(h: float, out: Numbers) -> None:
    """Advance the command speed by the engine room's answer to the telegraph.

    It is a step of its own: in one loop with another neither would become vector code.
    """
    for lane in every_lane():
        _answer_telegraph(vessel_in(out, lane), h, state_in(out, lane))
    for lane in every_lane():
        c, s = vessel_in(out, lane)[0], state_in(out, lane)[0]
        flow, turns = max(s.u, 0.0) / c.screw, s.telegraph_answer * c.turns
        torque = turns * (c.torque[AHEAD, BY_N_N] * turns + c.torque[AHEAD, BY_N_FLOW] * flow)
        torque += c.torque[AHEAD, BY_FLOW_FLOW] * flow * flow
        limited = 1.0 if c.torque_limit > 0.0 and s.telegraph_answer > s.u else 0.0
        at_limit = 1.0 if torque > c.torque_limit * ENGINE_LIMIT_SHARE else 0.0
        power = turns * torque
        most_power = c.power_limit if c.power_limit > 0.0 else power + 1.0
        at_limit = 1.0 if power > most_power * ENGINE_LIMIT_SHARE else at_limit
        astern = 1.0 if c.torque_limit > 0.0 and s.telegraph_answer < 0.0 else 0.0
        work_in(out, lane)[0].strayed += limited * at_limit + astern


@kernel
def watch_lanes(out: Numbers) -> None:
    """Count the tick, and find the lanes that have lost their numbers."""
    for lane in every_lane():
        c, s = vessel_in(out, lane)[0], state_in(out, lane)[0]
        s.tick += 1.0
        cross = _cross(vessel_in(out, lane), state_in(out, lane))
        s.validity = 1.0 if cross > c.tested * s.u * s.u else 0.0
        if s.u < 0.0 or cross > c.handover_from * s.u * s.u:
            s.validity = 2.0
        work = work_in(out, lane)[0]
        work.strayed += 0.0 if _lost(state_in(out, lane)) == 0 else 1.0


@kernel
def tick_abreast(scheme: Record, out: Numbers) -> None:
    """Advance every lane of a block by one tick.

    The order is that of ``update`` and ``autopilot``.
    """
    how = scheme[0]
    keep_gains(out)
    aim_autopilot(how.h, out)
    command_controls(how.h, out)
    compute_forces(how.trig, out)
    find_outside(how.h, out)
    compute_rates(how.trig, out)
    advance_motion(scheme, out)
    deflect_surfaces(how.h, out)
    advance_command_speed(how.h, out)
    watch_lanes(out)
