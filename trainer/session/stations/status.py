"""Everything about the boat in words, for the instructor's order ``status``.

Each function returns some of its lines, at most 79 columns wide. Other roles see only the panels of
their own station (``shown``).
"""

import math
import textwrap

import numpy as np

from trainer.boat import casualties
from trainer.boat.boat import Boat
from trainer.boat.sea_orders import describe_held, sea_text
from trainer.core.ballast.tanks import COMPARTMENTS, TANKS
from trainer.io.sides import ANGLE_SIDES, sided
from trainer.io.status_line import course
from trainer.session.stations.display import view
from trainer.session.stations.view import Frame, Pace, Picture, StateReader
from trainer.session.time.ledger import Summary
from trainer.units import KNOT

MAX_LINE_LETTERS = 79  # [characters]


def status_lines(boat: Boat, ledger: Summary) -> list[str]:
    """Return everything about the boat."""
    s = boat.state
    state = boat.records.state.tobytes()
    frame = StateReader(boat, lambda: ledger).frame(Picture(int(s.tick), state, Pace()))
    seen = view(frame, frame.truth)
    method, held = boat.method, describe_held(boat)

    def mode(by_hand: float) -> str:
        return "by hand" if by_hand else "automatic"

    def angle(name: str, degrees: float) -> str:
        return sided(degrees, ANGLE_SIDES[name], decimals=2)

    turns = f"{seen.rpm:.1f} rpm, turns for {float(s.u_c) / KNOT:.1f} kn"
    return [
        boat.file.name,
        (
            f"{method.equations} set, {method.rates} rates, {method.integrator}, "
            f"step {method.step:g} s, tick {int(s.tick)}"
        ),
        (
            f"depth   {seen.depth_m:8.2f} m   ordered {s.ordered_depth:.1f}   "
            f"rate {frame.read('depth_rate'):+.2f} m/s down"
        ),
        (
            f"heading {course(seen.course_deg, 2):>8}     "
            f"ordered {course(math.degrees(s.ordered_psi), 1)}   "
            f"rate {math.degrees(frame.read('turn_rate') or 0.0):+.2f} deg/s"
        ),
        (
            f"speed   {seen.speed_kn:8.2f} kn  ordered {s.ordered_speed / KNOT:.1f}   {turns}, "
            f"{mode(s.speed_by_hand)}"
        ),
        f"pitch {angle('pitch', seen.pitch_deg)}   heel {angle('heel', seen.heel_deg)} degrees",
        (
            f"stern planes {angle('stern', seen.stern_deg)} {mode(s.stern_by_hand)}, "
            f"bow planes {angle('bow', seen.bow_deg)} {mode(s.bow_by_hand)}"
        ),
        f"rudder {angle('rudder', seen.rudder_deg)} {mode(s.rudder_by_hand)}",
        f"position {s.x:.0f} m north, {s.y:.0f} m east of the start",
        *current_lines(frame, boat),
        *sea_lines(boat),
        *(ballast_lines(boat) if boat.vessel.fitted else ()),
        *casualty_lines(boat),
        *(
            textwrap.wrap(f"frozen: {held}", MAX_LINE_LETTERS, subsequent_indent="  ")
            if held
            else ()
        ),
        (
            f"ticks {ledger.ticks}, duty cycle {100 * ledger.duty_cycle:.3f} %, "
            f"overruns {ledger.overruns}, gaps {ledger.gaps}"
        ),
    ]


def casualty_lines(boat: Boat) -> list[str]:
    """Return what the crew's instruments show, and the casualties."""
    shown = casualties.instrument_readings(boat)
    instruments = (
        f"instruments: depth {shown.depth:.1f} m, "
        f"heading {course(math.degrees(shown.heading), 1)}, log {shown.speed / KNOT:.1f} kn"
    )
    kinds = ", ".join(
        f"{one.kind} {casualties.describe_amount(boat, one.kind, one.amount)}".rstrip()
        for one in casualties.active_casualties(boat)
    )
    if not kinds:
        return [instruments]
    return [
        instruments,
        *textwrap.wrap(f"casualties: {kinds}", MAX_LINE_LETTERS, subsequent_indent="  "),
    ]


def sea_lines(boat: Boat) -> list[str]:
    """Return the sea in force, and the one ordered if it is another."""
    s = boat.state
    coming = [f"sea ordered {sea_text(s.sea_target)}, in {s.sea_ramp:.0f} s"]
    return [f"sea {sea_text(s.sea)}", *(coming if s.sea_ramp > 0.0 else [])]


def current_lines(frame: Frame, boat: Boat) -> list[str]:
    """Return the current and the way over the ground, nothing where there is neither."""
    around = boat.world.parts.get("current")
    if around is None or not around.acts:
        return []
    track, way, towards, drift = (frame.read(name) for name in ("track", "way", "set", "drift"))
    goes = f"towards {course(math.degrees(towards), 0)}" if towards is not None else ""
    water = f"{goes} at {(drift or 0.0) / KNOT:.2f} kn" if goes else "no current"
    ground = f"{course(math.degrees(track or 0.0), 1)} at {(way or 0.0) / KNOT:.2f} kn"
    return [f"current {water}; over ground {ground}"]


def ballast_lines(boat: Boat) -> list[str]:
    """Return the water and air that are aboard."""
    s, c = boat.state, boat.vessel
    tonnes = dict(zip(TANKS, s.water / 1000.0, strict=True))
    with np.errstate(all="ignore"):  # a bank or a tank that the boat lacks
        filled = np.nan_to_num(100.0 * s.water / c.capacity)
        pressure = np.nan_to_num(s.bank * c.gas / c.bank_volume) / 1e6
    weight = float(s.weight - c.buoyancy) / float(c.g) / 1000.0
    working = [name for name in ("hover", "compressor") if s[name]]
    lines = [
        (
            f"main ballast forward {filled[0]:.0f}, mid {filled[1]:.0f}, "
            f"aft {filled[2]:.0f}, negative {filled[3]:.0f} %; weight {weight:+.1f} t"
        ),
        (
            f"trim{' by hand' * bool(s.trim_by_hand)} forward {tonnes['trim_forward']:.1f}, "
            f"aft {tonnes['trim_aft']:.1f}, auxiliary {tonnes['auxiliary']:.1f}, "
            f"depth control {tonnes['depth_control']:.1f} t"
        ),
        (
            f"air banks main {pressure[0]:.1f}, emergency {pressure[1]:.1f} MPa"
            f"{'; on: ' + ', '.join(working) if working else ''}"
        ),
    ]
    flooded = [
        f"{name.removeprefix('compartment_')} {tonnes[name]:.1f} t"
        for name in COMPARTMENTS
        if tonnes[name] > 0.0
    ]
    return [*lines, f"flooded {', '.join(flooded)}"] if flooded else lines
