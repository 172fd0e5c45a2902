"""The steady turn of the full and the compact set, and how they differ."""

import math
from dataclasses import asdict, dataclass

import numpy as np

from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile
from trainer.units import KNOT

RUDDER = 15.0  # [deg]
LENGTHS = 90.0  # boat lengths at the first speed: long enough to settle,
LAST = 20.0  # the last of which are averaged
MOST_TICKS = 20_000  # at whatever speed
SPREAD = 0.02  # [-] of the yaw rate over them: more is not steady


@dataclass(frozen=True)
class Turn:
    """A steady turn."""

    diameter_m: float
    speed_kn: float  # resultant in the boat's plane
    yaw_rate_deg_s: float
    heel_deg: float  # starboard side down


@dataclass(frozen=True)
class Comparison:
    """The same turn by both sets. Without either when it did not settle, ``problem`` saying why."""

    rudder_deg: float
    speed_kn: float
    depth: str  # how it was kept
    full: Turn | None
    modified: Turn | None
    percent: dict[str, float]  # modified less full, of full
    problem: str


def steady_turn(file: VesselFile, equations: str, rudder: float) -> Turn:
    """Return the turn with ``rudder`` [rad] at the vessel's start speed, command speed constant.

    ConfigError if it does not trim, diverges or does not become steady.
    """
    boat = Boat(file, Method(equations, "lagged", "exact", "adams2", file.run.step_s))
    speed = file.run.start_speed_kn * KNOT
    boat.start(speed, file.run.start_depth_m, 0.0)
    s = boat.state
    s.speed_by_hand = s.rudder_by_hand = 1.0
    s.ordered_r = rudder
    ticks = min(math.ceil(LENGTHS * file.hull.length / speed / boat.method.step), MOST_TICKS)
    seen = np.zeros((ticks, 4))
    for tick in range(ticks):
        status = boat.tick()
        if status:
            raise ConfigError(f"{equations}: {boat.failure(status)}")
        seen[tick] = s.u, s.v, s.psidot, s.phi
    last = seen[-math.ceil(ticks * LAST / LENGTHS) :]
    u, v, yaw, heel = (float(mean) for mean in last.mean(axis=0))
    if np.ptp(last[:, 2]) >= SPREAD * abs(yaw):
        raise ConfigError(f"{equations}: the turn is not steady after {boat.time:.0f} s")
    through = math.hypot(u, v)
    return Turn(2.0 * through / abs(yaw), through / KNOT, math.degrees(yaw), math.degrees(heel))


def compare_turns(file: VesselFile) -> Comparison:
    """Return the starboard turn by the full and modified sets.

    The rudder is at 15 deg, or its limit.
    """
    rudder = min(RUDDER, file.surfaces.rudder_limit_deg)
    to_starboard = -1.0 if file.coefficients["N_dr"] <= 0.0 else 1.0
    found: dict[str, Turn | None] = {"full": None, "modified": None}
    problem = ""
    for equations in found:
        try:
            found[equations] = steady_turn(file, equations, to_starboard * math.radians(rudder))
        except ConfigError as wrong:
            problem = problem or str(wrong)
    full, modified = found["full"], found["modified"]
    percent = {}
    if full and modified:
        by_compact = asdict(modified)
        percent = {
            name: 100.0 * (by_compact[name] - value) / value
            for name, value in asdict(full).items()
            if value != 0.0
        }
    depth = "by the autopilot" if file.autopilot else "not kept, planes as trimmed"
    speed = file.run.start_speed_kn
    return Comparison(rudder, speed, depth, full, modified, percent, problem)
