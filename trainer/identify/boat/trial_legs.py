"""The legs of a planned trial, and the boat of a prior that sails them.

The boat is the filter's own. Its helmsman and planesman are plain laws of angle and rate: what they
order by hand is what the trial orders, at the same times. Courses and depths are kept between.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import turning_signs
from trainer.config.boat.vessel_records import Surfaces
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, RecordNumbers, sail_controls
from trainer.identify.boat.motion import STATE, STATE_COUNT
from trainer.identify.boat.trial import (
    INTERVAL_RANGE_S,
    MIN_DEPTH_DIAMETERS,
    THINNED_LENGTHS,
    Trial,
    steps_between,
)
from trainer.identify.boat.vessel import FittedVessel
from trainer.units import DEGREE

READ_STATES: Final = {  # what a trial is taken to read
    "speed": STATE.U,
    "heading": STATE.PSI,
    "pitch": STATE.THETA,
    "roll": STATE.PHI,
    "depth": STATE.Z,
}
START_COURSE_RAD: Final = math.pi  # [rad]
# all times in L/U of the boat
WAIT_LENGTHS: Final = (2.0, 12.0)  # before a leg: at least, and at most until the boat is steady
RECOVERY_LENGTHS: Final = 5.0  # at its end, course and depth kept again
STEADY_RAD: Final = math.radians(3.0)  # [rad] off course and pitched, of a boat that is steady
STEADY_DEPTH_LENGTHS: Final = 0.05  # [L] off its depth
# laws of the helmsman and the planesman: rudder per error and per rate [L/U], and so on
HELM_GAINS, MAX_HELM_RAD = (0.5, 0.44), math.radians(15.0)
PLANES_GAINS, MAX_PLANES_RAD = (1.5, 0.29), math.radians(15.0)
PITCH_PER_LENGTH, MAX_KEPT_PITCH_RAD = 1.4, 0.1  # [rad per L] of a depth that is off
THROTTLE_S: Final = 25.0  # [s] from nothing to full revolutions, of BB2; in proportion to L/U
BOW_ORDER: Final = "bow planes zero"  # of a boat that has some
OPEN_DEPTH_LENGTHS: Final = 1.0  # [L] below the shallowest depth, where none is said


class TrialLeg(NamedTuple):
    """A part of a trial: which control is worked, and how."""

    name: str
    control: str  # rudder, stern or turns
    angle: float  # [deg], or the share of the trial's speed
    execute: float = math.inf  # [deg] of heading or pitch, at which the surface goes over

    @property
    def words(self) -> str:
        """Return what its crew does, as a sentence."""
        if self.control == "turns":
            return f"slow down to {self.angle:.0%} of the speed; halfway, up to it again"
        first, other, motion = {
            "rudder": ("rudder right", "left", "off the course"),
            "stern": ("stern planes dive", "rise", "down by the bow"),
        }[self.control]
        begun = f"{first} {self.angle:g}"
        if math.isinf(self.execute):
            return f"{begun}, and hold it"
        return f"{begun}; at {self.execute:g} deg {motion}, {other} as much; and so to and fro"


TRIAL_LEGS: Final = (
    TrialLeg("turn at 15 deg", "rudder", 15.0),
    TrialLeg("turn at 25 deg", "rudder", 25.0),
    TrialLeg("zig-zag 10/10", "rudder", 10.0, 10.0),
    TrialLeg("zig-zag 20/20", "rudder", 20.0, 20.0),
    TrialLeg("vertical zig-zag 5/3", "stern", 5.0, 3.0),
    TrialLeg("vertical zig-zag 8/5", "stern", 8.0, 5.0),
    TrialLeg("acceleration", "turns", 0.6),
)
PLAIN_LEG: Final = next(leg for leg in TRIAL_LEGS if leg.name == "zig-zag 20/20")


class Waters(NamedTuple):
    """Where a trial is sailed."""

    room: float  # [m] of its track, north and south, east and west; infinite: any
    shallowest: float  # [m] of the origin
    deepest: float
    depth: float  # [m] at which it begins


class Ordered(NamedTuple):
    """What stands ordered; None: course or depth is kept."""

    rudder: float | None  # [deg] positive to port
    stern: float | None  # [deg] positive bow down
    speed: float  # [m/s] that the revolutions give
    course: float  # [rad]


class SailedTrial(NamedTuple):
    """A trial as the boat of a prior sails it."""

    legs: tuple[TrialLeg, ...]
    seconds: float  # of each leg
    trial: Trial  # its readings are exact
    states: Numbers  # (n, STATE_COUNT)
    orders: tuple[tuple[float, str], ...]  # [s], as they are typed


def waters_of(vessel: FittedVessel, room: str | None, depth: str | None) -> Waters:
    """Return what words such as ``2000m`` and ``40:120`` say; ConfigError."""
    hull = vessel.file.hull
    least = MIN_DEPTH_DIAMETERS * (hull.diameter or hull.beam or 0.0)
    wide = math.inf if room is None else _metres("--room", room, room)
    if depth is None:
        start = max(vessel.file.run.start_depth_m, least + OPEN_DEPTH_LENGTHS * vessel.length)
        return Waters(wide, least, 2.0 * start - least, start)
    first, colon, last = depth.partition(":")
    if not colon:
        raise ConfigError(f"--depth {depth}: say the least and the greatest, such as 40:120")
    shallow, deep = (_metres("--depth", depth, text) for text in (first, last))
    if not shallow < deep:
        raise ConfigError(f"--depth {depth}: the first must be less than the second")
    if shallow < least:
        raise ConfigError(
            f"--depth {depth}: from {shallow:g} m, and a fit takes no record above {least:.3g} m, "
            f"{MIN_DEPTH_DIAMETERS:g} breadths of the hull: say {math.ceil(least)}:{deep:g}"
        )
    return Waters(wide, shallow, deep, 0.5 * (shallow + deep))


def _metres(option: str, whole: str, text: str) -> float:
    """Return a length [m] as typed, with or without its unit."""
    try:
        length = float(text.strip().removesuffix("m"))
    except ValueError:
        raise ConfigError(f"{option} {whole}: {text!r} is no length in metres") from None
    if not 0.0 < length < 1e6:
        raise ConfigError(f"{option} {whole}: must be above 0 and below 1e6 m")
    return length


def able_legs(surfaces: Surfaces) -> tuple[TrialLeg, ...]:
    """Return the legs that the surfaces of a boat allow."""
    most = {"rudder": surfaces.rudder_limit_deg, "stern": surfaces.stern_plane_limit_deg}
    return tuple(leg for leg in TRIAL_LEGS if leg.angle <= most.get(leg.control, math.inf))


class _Watch:
    """The helmsman and the planesman of a trial: what they order, leg by leg."""

    def __init__(
        self, vessel: FittedVessel, legs: Sequence[TrialLeg], seconds: float, waters: Waters
    ) -> None:
        self.vessel, self.legs, self.seconds, self.waters = vessel, legs, seconds, waters
        self.span = vessel.length / vessel.speed
        self.course, self.number = START_COURSE_RAD, -1
        self.side, self.begun, self.over = 1.0, math.inf, False

    def order(self, t: float, x: Numbers) -> Ordered:
        """Return what stands ordered at a time [s] of a state."""
        number = min(int(t / self.seconds + 1e-9), len(self.legs) - 1)
        since, leg = t - number * self.seconds, self.legs[number]
        if number != self.number:
            self.number, self.side, self.begun, self.over = number, 1.0, math.inf, False
        least, most = (self.span * lengths for lengths in WAIT_LENGTHS)
        if math.isinf(self.begun) and since >= least and (self.is_steady(x) or since >= most):
            self.begun = since
        end = self.seconds - RECOVERY_LENGTHS * self.span
        if since >= end and not self.over:
            self.over = True
            self.turn_back(leg, x)
        if not self.begun <= since < end:
            return Ordered(None, None, self.vessel.speed, self.course)
        if leg.control == "turns":
            slow = since < 0.5 * (self.begun + end)
            share = leg.angle if slow else 1.0
            return Ordered(None, None, share * self.vessel.speed, self.course)
        motion = x[STATE.THETA] if leg.control == "stern" else x[STATE.PSI] - self.course
        # a right rudder is negative and raises the heading; dive is positive and lowers the pitch
        way = 1.0 if leg.control == "stern" else -1.0
        if -way * self.side * motion >= leg.execute * DEGREE:
            self.side = -self.side
        angle = way * self.side * leg.angle
        rudder, stern = (angle, None) if leg.control == "rudder" else (None, angle)
        return Ordered(rudder, stern, self.vessel.speed, self.course)

    def is_steady(self, x: Numbers) -> bool:
        """Return whether a boat is on its course and depth."""
        level = max(abs(x[STATE.PSI] - self.course), abs(x[STATE.THETA])) < STEADY_RAD
        off = abs(x[STATE.Z] - self.waters.depth) / self.vessel.length
        return level and off < STEADY_DEPTH_LENGTHS

    def turn_back(self, leg: TrialLeg, x: Numbers) -> None:
        """Set the course after a leg: as a turn ends, else back in small room."""
        if leg.control == "rudder" and math.isinf(leg.execute):
            self.course += round((x[STATE.PSI] - self.course) / DEGREE) * DEGREE
        elif math.isfinite(self.waters.room):
            self.course += math.pi

    def angles(self, ordered: Ordered, x: Numbers) -> Numbers:
        """Return the inputs (4,) that should stand."""
        off = x[STATE.PSI] - ordered.course
        rudder = HELM_GAINS[0] * off + HELM_GAINS[1] * self.span * x[STATE.R]
        deep = (x[STATE.Z] - self.waters.depth) / self.vessel.length
        pitch = np.clip(PITCH_PER_LENGTH * deep, -MAX_KEPT_PITCH_RAD, MAX_KEPT_PITCH_RAD)
        stern = PLANES_GAINS[0] * (x[STATE.THETA] - pitch)
        stern += PLANES_GAINS[1] * self.span * x[STATE.Q]
        kept = np.clip([rudder, stern], -MAX_HELM_RAD, MAX_PLANES_RAD)
        hands = [ordered.rudder, ordered.stern]
        both = [k if h is None else h * DEGREE for k, h in zip(kept, hands, strict=True)]
        return np.array([*both, 0.0, ordered.speed])


def sail_legs(
    vessel: FittedVessel, values: Numbers, legs: Sequence[TrialLeg], seconds: float, waters: Waters
) -> SailedTrial:
    """Return a trial of legs of ``seconds`` [s] each, as a boat sails it.

    States are NaN from where the boat is lost.
    """
    boat, watch = vessel.numbers(values), _Watch(vessel, legs, seconds, waters)
    least, most = INTERVAL_RANGE_S
    interval = float(np.clip(round(THINNED_LENGTHS * watch.span, 2), least, 0.5 * most))
    rate = vessel.file.surfaces.rate_deg_s * DEGREE * interval
    throttle = vessel.speed * interval / (THROTTLE_S * vessel.pace**-1)
    able, steps = np.array([rate, rate, rate, throttle]), steps_between(interval, vessel)
    x = np.zeros(STATE_COUNT)
    x[STATE.U], x[STATE.PSI], x[STATE.Z] = vessel.speed, START_COURSE_RAD, waters.depth
    inputs, states = [np.array([0.0, 0.0, 0.0, vessel.speed])], [x]
    before = Ordered(None, None, vessel.speed, START_COURSE_RAD)
    has_bows = turning_signs(vessel.file.coefficients)["bow"] != 0.0
    orders = [(0.0, _turns(vessel.speed))]
    empty = np.zeros((0, len(CHANNEL_NAMES)))
    for k in range(round(len(legs) * seconds / interval)):
        ordered = watch.order(k * interval, x)
        words = [one for one in _typed(before, ordered) if one != BOW_ORDER or has_bows]
        orders += [(round(k * interval, 2), one) for one in words]
        before = ordered
        change = np.clip(watch.angles(ordered, x) - inputs[-1], -able, able)
        inputs.append(inputs[-1] + change)
        pair = RecordNumbers(empty, np.array(inputs[-2:]), interval, steps)
        x = sail_controls(boat, pair, x)[1]
        states.append(x)
        if not np.isfinite(x).all():
            break
    whole = np.array(states)
    readings = np.full((len(whole), len(CHANNEL_NAMES)), np.nan)
    for name, at in READ_STATES.items():
        readings[:, CHANNEL_NAMES.index(name)] = whole[:, at]
    name = ", ".join(leg.name for leg in legs)
    trial = Trial(name, "", interval, steps, readings, np.array(inputs), (), ())
    return SailedTrial(tuple(legs), seconds, trial, whole, tuple(orders))


def _turns(speed: float) -> str:
    """Return the order for revolutions that give a speed [m/s]."""
    return f"turns {speed:.2f} m/s"


def _typed(before: Ordered, now: Ordered) -> Iterator[str]:
    """Yield the orders that lead from what stood ordered to what does."""
    if now.speed != before.speed:
        yield _turns(now.speed)
    if now.rudder is None and (before.rudder is not None or now.course != before.course):
        yield "rudder auto"
        yield f"course {round(math.degrees(now.course)) % 360:03d}"
    elif now.rudder is not None and now.rudder != before.rudder:
        yield f"rudder {'left' if now.rudder > 0.0 else 'right'} {abs(now.rudder):g}"
    if now.stern is None and before.stern is not None:
        yield "planes auto"
    elif now.stern is not None and now.stern != before.stern:
        if before.stern is None:
            yield BOW_ORDER
        yield f"stern planes {'dive' if now.stern > 0.0 else 'rise'} {abs(now.stern):g}"


def limits_broken(sailed: SailedTrial, waters: Waters) -> str:
    """Return which limit of the waters a trial breaks, and how; "" for none."""
    if not np.isfinite(sailed.states).all():
        return "the boat of the prior does not sail it"
    depth = sailed.states[:, STATE.Z]
    if depth.min() < waters.shallowest or depth.max() > waters.deepest:
        return f"goes from {depth.min():.0f} to {depth.max():.0f} m deep"
    wide = room_of(sailed)
    return f"needs {wide:.0f} m of room" if wide > waters.room else ""


def room_of(sailed: SailedTrial) -> float:
    """Return the room [m] of a track, north to south or east to west."""
    sine, cosine = np.sin(sailed.states[:, STATE.PSI]), np.cos(sailed.states[:, STATE.PSI])
    u = sailed.states[:, STATE.U] * np.cos(sailed.states[:, STATE.THETA])
    v = sailed.states[:, STATE.V]
    ways = (u * sine + v * cosine, u * cosine - v * sine)
    return float(max(np.ptp(sailed.trial.interval * np.cumsum(way)) for way in ways))
