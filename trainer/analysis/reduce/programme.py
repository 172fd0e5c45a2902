"""The programme of a reduction: legs to fit, prove and judge a set by.

A leg is one manoeuvre at one speed. A set is fitted to some legs, and proven by those of the guide
while terms are dropped. It is judged by the guide, by more steady turns than were fitted, and by
legs that neither has seen, because a set that only fits what it was fitted to is worth nothing.
``reduction`` takes those to fit to, ``search`` those to prove and ``verdict`` those to judge by.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np

from trainer.analysis.check import round_speeds
from trainer.analysis.guide.programme import (
    OWN_RIG,
    Leg,
    both_ways,
    guide_legs,
    own_method,
    turn_rigs,
)
from trainer.analysis.manoeuvres.casualties import (
    UPRIGHT_COLUMNS,
    OutOfBalance,
    PlaneJam,
    RudderJam,
)
from trainer.analysis.manoeuvres.catalogue import within_limits
from trainer.analysis.manoeuvres.flight import LEAD_TIME_S, Conn, Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.speeds import Backing, CrashStop
from trainer.analysis.manoeuvres.submarine import Submarine
from trainer.analysis.manoeuvres.turns import ClimbingTurn, Turn
from trainer.analysis.manoeuvres.vehicle import (
    DIVE,
    PORT,
    RISE,
    STARBOARD,
    Direction,
    Measure,
    Side,
    part_measure,
)
from trainer.analysis.manoeuvres.vertical import (
    Impulse,
    Meander,
    Overshoot,
    RollDecay,
    RudderImpulse,
    TrimChange,
)
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.units import KNOT

WEAVE_LENGTHS: Final = (3.0, 6.0, 6.0)  # [lengths run] to one side, the other, and the first again
READING_SHARES: Final = (1 / 3, 2 / 3, 1.0)  # of a leg
LEVEL_COLUMNS: Final = {"r": "rad/s", "v": "m/s", "psi": "rad", "u": "m/s", "phi": "rad"}
TURN_LENGTHS: Final = 120.0  # [lengths run] of a turn, until it is steady
USUAL_LENGTHS: Final = 40.0  # of all else
MIN_FLIGHT_S: Final = 20.0  # [s] besides
JUDGED_ANGLES: Final = 6  # of the rudder, up to the largest
MAX_RUDDER_DEG: Final = 30.0  # [deg] the largest, or as far as it goes
LOAD_SHARE: Final = 0.002  # [-] of the weight, out of balance
MAX_ANGLE_HALVINGS: Final = 5  # of a control's angle until the full set is not lost
BOTH_SIDES: Final[tuple[Side, Side]] = STARBOARD, PORT
# what is halved, the first
HALVED_FIELDS: Final = ("jammed_lengths", "share", "planes_deg", "angle_deg")
# slow to fly; turns have their numbers
SLOW_MANOEUVRES: Final = ("pull-out", "spiral", "reverse-spiral")


@dataclass(frozen=True)
class _Weave(Manoeuvre):
    """One control from side to side by the clock, whatever the boat does.

    The full and the compact set so have the same control at the same time, which makes their
    readings then comparable.
    """

    keep: ClassVar[tuple[str, ...]] = ()
    watched: ClassVar[Mapping[str, str]]  # columns and their units
    swinging: ClassVar[str]

    angle_deg: float = 15.0  # control

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the legs."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        yield from conn.hold(LEAD_TIME_S)
        length, speed, sign = conn.vehicle.length, conn.value("u"), self.sign
        for run in WEAVE_LENGTHS:
            conn.order(self.needs[0], sign * math.radians(self.angle_deg))
            conn.mark("leg")
            yield from conn.hold(run * length / speed)
            sign = -sign

    def measures(self, flight: Flight) -> list[Measure]:
        """Return readings along the legs and extremes of what swings, counted to the side."""
        flight = flight.counted_to(getattr(self, "side", STARBOARD))
        begins = [mark.t for mark in flight.marks]
        ends = [*begins[1:], float(flight.t[-1])]
        times = {
            f"{reading:.2g} of leg {i}": begin + reading * (end - begin)
            for i, (begin, end) in enumerate(zip(begins, ends, strict=True), start=1)
            for reading in READING_SHARES
        }
        measures = []
        for name, unit in self.watched.items():
            most = float(abs(flight.change(name)).max())
            measures += [
                part_measure(f"{name} after {moment}", unit, flight.at(time, name), most)
                for moment, time in times.items()
            ]
        swing = flight.change(self.swinging)
        most = float(abs(swing).max())
        for word, value in (("largest", swing.max()), ("smallest", swing.min())):
            measures.append(part_measure(f"{word} {self.swinging}", "rad", float(value), most))
        return measures


@dataclass(frozen=True)
class Weave(_Weave):
    """Rudder from side to side; depth kept."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    keep: ClassVar[tuple[str, ...]] = ("depth",)
    watched: ClassVar[Mapping[str, str]] = LEVEL_COLUMNS
    swinging: ClassVar[str] = "psi"

    side: Side = STARBOARD


@dataclass(frozen=True)
class VerticalWeave(_Weave):
    """Planes from side to side."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    watched: ClassVar[Mapping[str, str]] = UPRIGHT_COLUMNS
    swinging: ClassVar[str] = "theta"

    angle_deg: float = 5.0  # control
    direction: Direction = RISE


def leg_speeds(file: VesselFile) -> tuple[float, ...]:
    """Return four speeds [kn] up to the boat's fastest, for BB2 5, 10, 15, 20."""
    low, top = file.run.speed_range_kn
    return tuple(float(u) for u in np.linspace(max(low, top / 4.0), top, 4))


def turn_legs(file: VesselFile) -> tuple[Leg, ...]:
    """Return steady turns to both sides, at four speeds and by six angles.

    Where the engine is limited they are turned by held revolutions too.
    """
    return _turns_at(file, leg_speeds(file))


def _turns_at(
    file: VesselFile, speeds: Sequence[float], angles: int = JUDGED_ANGLES
) -> tuple[Leg, ...]:
    """Return steady turns to both sides at ``speeds`` [kn] by so many angles."""
    most = min(MAX_RUDDER_DEG, file.surfaces.rudder_limit_deg)
    return tuple(
        replace(leg, rig=rig)
        for rig in turn_rigs(file)
        for speed in speeds
        for angle in (most * i / angles for i in range(1, angles + 1))
        for leg in _ways("turn", f"rudder {angle:.3g} deg", speed, Turn(angle_deg=angle), file)
    )


def _fitted_turns(file: VesselFile) -> tuple[Leg, ...]:
    """Return every second angle of the steady turns, by a limited engine at the faster speeds.

    At the slower ones no turn comes to the engine's limit. At the guide's low speed every angle is
    fitted: there the planes' work in a turn goes up and down between two of them.
    """
    fast = leg_speeds(file)[2:]
    turns = _turns_at(file, leg_speeds(file), JUDGED_ANGLES // 2)
    own = (leg for leg in turns if leg.rig == OWN_RIG or leg.speed_kn in fast)
    slow = (leg for leg in _turns_at(file, (_low_speed(file),)) if leg.rig == OWN_RIG)
    return tuple(dict.fromkeys((*own, *slow)))


def _low_speed(file: VesselFile) -> float:
    """Return the guide's low speed [kn]: the second of its round ones."""
    speeds = round_speeds(*file.run.speed_range_kn)
    return speeds[min(1, len(speeds) - 1)]


def fit_legs(file: VesselFile) -> tuple[Leg, ...]:
    """Return the legs that the factors are fitted to."""
    return flyable_legs(file, (*_fitted_turns(file), *_weaves(file), *_upright(file)))


def _weaves(file: VesselFile) -> Iterator[Leg]:
    """Yield weaves and diving turns, angles not yet within the boat's limits."""
    own_speed, third, top = file.run.start_speed_kn, leg_speeds(file)[2], leg_speeds(file)[3]
    for speed, angle in ((own_speed, 10.0), (own_speed, 20.0), (top, 15.0)):
        weave = Weave(angle_deg=angle)
        yield from _ways("weave", f"rudder {angle:g} deg", speed, weave, file)
    for speed, angle in ((own_speed, 5.0), (own_speed, 10.0), (top, 3.0)):
        vertical = VerticalWeave(angle_deg=angle)
        yield from _ways("vertical weave", f"planes {angle:g} deg", speed, vertical, file)
    dives = (own_speed, 10.0, 5.0), (own_speed, 20.0, 10.0), (third, 20.0, 5.0)
    for speed, angle, planes in dives:
        for side in BOTH_SIDES:
            dive = ClimbingTurn(angle, planes, side=side, direction=DIVE)
            yield _leg("diving turn", f"rudder {angle:g} deg, {side}", speed, dive, file)


def _upright(file: VesselFile) -> Iterator[Leg]:
    """Yield the legs besides turns and weaves, angles not yet within the boat's limits."""
    own_speed, third, top = file.run.start_speed_kn, leg_speeds(file)[2], leg_speeds(file)[3]
    rounds, slow = round_speeds(*file.run.speed_range_kn), _low_speed(file)
    for speed in sorted({slow, own_speed, third, top}):
        yield from _ways("meander", "", speed, Meander(), file)
    for speed in (slow, top):
        yield from _ways("trim", "", speed, TrimChange(), file)
    for speed in (slow, top):
        for execute in (5.0, 20.0):
            overshoot = Overshoot(execute_deg=execute)
            yield from _ways("overshoot", f"execute {execute:g} deg", speed, overshoot, file)
    yield from _ways("impulse", "", own_speed, Impulse(), file)
    yield from _ways("rudder-impulse", "", own_speed, RudderImpulse(), file)
    for speed in (rounds[0], slow, own_speed):
        for share, keep in ((-LOAD_SHARE, ("depth",)), (LOAD_SHARE, ())):
            depth_words = "depth kept" if keep else "planes still"
            loaded = OutOfBalance(share=share, keep=keep)
            yield _leg("out of balance", f"{share:+.1%}, {depth_words}", speed, loaded, file)
    yield _leg("crash-stop", "", own_speed, CrashStop(), file)
    yield _leg("backing", "", 0.0, Backing(), file)
    yield from _ways("rudder-jam", "", own_speed, RudderJam(), file)
    yield from _ways("roll-decay", "", 0.0, RollDecay(), file)


def fastest_legs(file: VesselFile) -> tuple[Leg, ...]:
    """Return legs at the boat's top speed. The fit has their kinds below it."""
    top = leg_speeds(file)[3]
    dives = [ClimbingTurn(10.0, 10.0, side=side, direction=DIVE) for side in BOTH_SIDES]
    loads = OutOfBalance(share=-LOAD_SHARE), OutOfBalance(share=LOAD_SHARE, keep=())
    legs = (
        *(_leg("diving turn", f"planes 10 deg, {one.side}", top, one, file) for one in dives),
        *_ways("impulse", "", top, Impulse(), file),
        *_ways("rudder-impulse", "", top, RudderImpulse(), file),
        _leg("out of balance", f"{-LOAD_SHARE:+.1%}, depth kept", top, loads[0], file),
        _leg("out of balance", f"{LOAD_SHARE:+.1%}, planes still", top, loads[1], file),
    )
    return flyable_legs(file, legs)


def legs_of_guide(file: VesselFile) -> tuple[Leg, ...]:
    """Return the legs of the guide, which a set must pass unseen by the fit."""
    return tuple(leg for leg in guide_legs(file) if leg.name not in SLOW_MANOEUVRES)


def holdout_legs(file: VesselFile) -> tuple[Leg, ...]:
    """Return the legs that neither fit nor choice see: zig-zags, climbing turns, casualties."""
    own_speed, third, second = file.run.start_speed_kn, leg_speeds(file)[2], leg_speeds(file)[1]
    rounds, slow = round_speeds(*file.run.speed_range_kn), _low_speed(file)
    between = 0.5 * (rounds[0] + slow), 0.5 * (slow + own_speed)
    jams = 0.5 * (own_speed + third), third
    heavy = OutOfBalance(share=1.5 * LOAD_SHARE)
    light = OutOfBalance(share=-1.5 * LOAD_SHARE, keep=())
    zigzag = ZigZag(angle_deg=15.0, execute_deg=15.0)
    climbs = [ClimbingTurn(10.0, 10.0, side=side) for side in BOTH_SIDES]
    legs = [
        *(leg for u in (second, third) for leg in _ways("zigzag-15", "", u, zigzag, file)),
        *(_leg("climbing turn", one.side, u, one, file) for u in (second, third) for one in climbs),
        *(leg for u in jams for leg in _ways("stern-plane jam", "", u, PlaneJam(), file)),
        *(_leg("out of balance", "heavy, depth kept", speed, heavy, file) for speed in between),
        *(_leg("out of balance", "light, planes still", speed, light, file) for speed in between),
    ]
    return flyable_legs(file, legs)


def _ways(
    name: str, variant: str, speed: float, manoeuvre: Manoeuvre, file: VesselFile
) -> Iterator[Leg]:
    """Yield a manoeuvre's legs to both sides, or up and down, as `ways` has them."""
    leg = _leg(name, variant, speed, manoeuvre, file)
    yield from both_ways(name, leg.speed_kn, leg.manoeuvre, variant)


def _leg(name: str, variant: str, speed: float, manoeuvre: Manoeuvre, file: VesselFile) -> Leg:
    """Return a leg, its duration limited by lengths that this boat runs."""
    if speed and hasattr(manoeuvre, "duration_s"):
        lengths = TURN_LENGTHS if name == "turn" else USUAL_LENGTHS
        enough = lengths * file.hull.length / (speed * KNOT) + MIN_FLIGHT_S
        manoeuvre = replace(manoeuvre, duration_s=min(manoeuvre.duration_s, enough))  # type: ignore[call-arg]
    return Leg(name, variant, round(speed, 3), manoeuvre)


def flyable_legs(file: VesselFile, legs: tuple[Leg, ...] | list[Leg]) -> tuple[Leg, ...]:
    """Return the legs that the full set can fly. Angles of the planes are smaller where need be."""
    boats = {rig: Submarine(file, own_method(file, "full"), rig) for rig in turn_rigs(file)}
    gentled = (_flyable(boats[leg.rig], leg) for leg in legs)
    return tuple(dict.fromkeys(leg for leg in gentled if leg))


def _flyable(boat: Submarine, leg: Leg) -> Leg | None:
    """Return the leg by the largest angle at which the full set is not lost; None: by none."""
    if not all(control in boat.controls for control in leg.manoeuvre.needs):
        return None
    leg = replace(leg, manoeuvre=within_limits(leg.manoeuvre, boat))
    for _ in range(MAX_ANGLE_HALVINGS):
        try:
            flight = fly_manoeuvre(boat, leg.manoeuvre, leg.speed_kn * KNOT)
        except ConfigError:
            return None
        recovers = not isinstance(leg.manoeuvre, PlaneJam) or flight.time_of("level") is not None
        if not flight.lost and recovers:
            return leg
        field = next((field for field in HALVED_FIELDS if hasattr(leg.manoeuvre, field)), None)
        if field is None:
            return None
        half = {field: 0.5 * getattr(leg.manoeuvre, field)}
        leg = replace(leg, manoeuvre=replace(leg.manoeuvre, **half))
    return None
