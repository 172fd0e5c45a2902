"""The effects of depth: the calm surface above the boat, test depth and collapse.

The programs ``neutral`` and ``characteristic`` take the surface's coefficients from the vessel
file's tables. Aboard, the session calls out depths near test depth and beyond it, and ends
the run at collapse depth, as rehearsals of the debrief do. At periscope depth the periscope watch
calls what it sees, and so goes by the true depth. A guard levels the boat before a depth that an
exercise names, because a visitor with planes in hand might lose it.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple, TypeVar

import numpy as np

from trainer.boat.assemble import ballast_record
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.flown_ticks import FlownTicks, Mask, count_before
from trainer.boat.limits import is_surfacing, may_surface
from trainer.config.boat.vessel import VesselFile
from trainer.config.boat.vessel_records import Hull
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.io.orders.grammar import Order, parse
from trainer.units import KNOT

SLOPE_STEP_M: Final = 0.01  # [m] of depth either way, for the slopes of the surface's tables
HULL_REACH: Final = 0.4  # [-] of the length: ends of the pressure hull before and abaft the origin
FIRST_CALL_M: Final = 30.0  # [m] above test depth, where the first call is
CALL_SPACING_M: Final = 25.0  # [m] from each call beyond test depth to the next
AT_TEST_DEPTH: Final = 1  # index of test depth among the depths to be called, from 0
RECALL_RISE_M: Final = 5.0  # [m] to come up before the same depth is called again
MAST_RAISED_M: Final = 1.5  # [m] about periscope depth, where the mast is raised
MAST_LOWERED_M: Final = 5.0  # [m] below it, where the mast is lowered
RECALL_SINK_M: Final = 1.0  # [m] to go down before the same is seen again
WATCH_CALLS: Final = (  # [m] above periscope depth, and what the periscope watch calls then
    (2.0, "Periscope watch: 2 m more of the mast is out than should be"),
    (4.0, "Periscope watch: the sail is close below the surface"),
)
# of the alerts: all depths beyond test depth are one
DEPTH_KEYS: Final = ("near test depth", "test depth", "beyond test depth")
WATCH_KEYS: Final = ("mast out", "sail near the surface")
GUARD_AHEAD_S: Final = 30.0  # [s] that a guard looks ahead
GUARD_MARGIN_M: Final = 20.0  # [m] above the guarded depth, where the boat is kept meanwhile
RELEASE_MARGIN_M: Final = 5.0  # [m] above the guarded depth, from where the planes are given back
LEVEL_PITCH: Final = math.radians(3.0)  # [rad] of pitch that is level enough for it
Z, THETA, HELD_OFFSET = STATE_OFFSETS["z"], STATE_OFFSETS["theta"], STATE_OFFSETS["held_depth"]

SURFACE_COEFFICIENTS: Final = ("Z_star", "M_star", "Z_w", "M_w")  # that a calm surface changes

Depths = TypeVar("Depths", float, Numbers)  # of a moment, or of each tick


@dataclass(frozen=True)
class SurfaceForces:
    """The forces of the calm surface at one speed and depth, by the vessel file."""

    speed_kn: float
    Z_star: float  # [-] less that in deep water
    M_star: float
    Z_star_slope: float  # [1/m] with depth; at a depth of the tables the mean of both sides
    M_star_slope: float
    Z_N: float  # negative: suction
    M_N_m: float


def require_covered(file: VesselFile, depth: float | None) -> None:
    """Check that the vessel file covers a ``depth`` [m]; None is deep water.

    ConfigError if the vessel file says nothing of the surface, or the hull is not covered there.
    """
    if depth is None:
        return
    if file.free_surface is None:
        raise ConfigError(
            f"{file.path.name}: has no table [free_surface], which --depth {depth:g} asks for"
        )
    hull = ballast_record(file)[0]
    least = 0.5 * float(hull.hull_diameter) - float(hull.hull_axis)
    if depth < least:
        raise ConfigError(
            f"--depth {depth:g} m: the hull is covered from {least:.2f} m down, and the programs "
            "know no other boat"
        )


def _differences(file: VesselFile, speed: float, depth: float) -> dict[str, float]:
    """Return what coefficients are more than in deep water [-], as core.sea.free_surface has them.

    The speed is in m/s, the depth in m.
    """
    tables = file.free_surface
    if tables is None:
        return dict.fromkeys(SURFACE_COEFFICIENTS, 0.0)
    speeds = [row.speed_kn * KNOT for row in tables.rows]

    def at_depth(column: tuple[float, ...] | None) -> float:
        return 0.0 if column is None else float(np.interp(depth, tables.depth_m, column))

    return {
        "Z_star": float(np.interp(speed, speeds, [at_depth(row.Z_star) for row in tables.rows])),
        "M_star": float(np.interp(speed, speeds, [at_depth(row.M_star) for row in tables.rows])),
        "Z_w": at_depth(tables.Z_w),
        "M_w": at_depth(tables.M_w),
    }


def surface_at(file: VesselFile, speed: float, depth: float) -> SurfaceForces:
    """Return what the calm surface adds at ``speed`` [m/s] and ``depth`` [m] of the origin."""
    here, below, above = (
        _differences(file, speed, depth + step) for step in (0.0, SLOPE_STEP_M, -SLOPE_STEP_M)
    )
    Z, M = here["Z_star"], here["M_star"]
    area = 0.5 * file.fluid.rho * file.hull.length**2 * speed**2
    return SurfaceForces(
        speed_kn=speed / KNOT,
        Z_star=Z,
        M_star=M,
        Z_star_slope=(below["Z_star"] - above["Z_star"]) / (2.0 * SLOPE_STEP_M),
        M_star_slope=(below["M_star"] - above["M_star"]) / (2.0 * SLOPE_STEP_M),
        Z_N=area * Z,
        M_N_m=area * file.hull.length * M,
    )


def near_surface(file: VesselFile, speed: float, depth: float | None) -> VesselFile:
    """Return the vessel with the coefficients of ``speed`` [m/s] at ``depth`` [m]; None: deep.

    ``neutral`` asks for it, because so its equations of deep water serve near the surface too.
    """
    if depth is None:
        return file
    added = _differences(file, speed, depth)
    c = file.coefficients
    return replace(file, coefficients={**c, **{name: c[name] + added[name] for name in added}})


@contextmanager
def feeling_surface(boat: Boat, speed: float, depth: float | None) -> Iterator[None]:
    """Let trims feel a calm surface at ``depth`` [m] inside the block; None: deep water.

    It is in the coefficients there, because trims are of the equations in deep water.
    """
    file, records = boat.file, boat.records[:2]
    deep = [[float(record[name][0]) for name in SURFACE_COEFFICIENTS] for record in records]
    area = 0.5 * file.fluid.rho * file.hull.length**2
    arm = file.hull.length
    try:
        if depth is not None:
            for record, lever in zip(records, (arm, arm * float(records[1]["T5"][0])), strict=True):
                for name, value in _differences(file, speed, depth).items():
                    record[name] += area * value * (lever if name[0] == "M" else 1.0)
        yield
    finally:
        for record, values in zip(records, deep, strict=True):
            for name, value in zip(SURFACE_COEFFICIENTS, values, strict=True):
                record[name] = value


def surface_remarks(file: VesselFile, depth: float | None) -> tuple[str, ...]:
    """Return where a ``depth`` [m] lies outside the tables of the vessel."""
    if depth is None or file.free_surface is None:
        return ()
    first, last = file.free_surface.depth_m[0], file.free_surface.depth_m[-1]
    if depth < first:
        return (f"the tables of the surface begin at {first:g} m; taken as there",)
    return (f"the surface is not felt from {last:g} m down",) if depth >= last else ()


class PassedDepth(NamedTuple):
    """A depth that has been passed, and the call for it.

    It is passed on the way down, or at the periscope on the way up.
    """

    depth: float  # [m]
    call: MonitorCall


def lowest_depth(depth: Depths, pitch: Depths, length: float) -> Depths:
    """Return the depth [m] of the pressure hull's lowest point.

    ``depth`` [m] is the origin's, ``pitch`` in rad, ``length`` in m. An estimate: the ends are
    points of the boat's axis, so that heel does not move them.
    """
    lowest: Any = depth + HULL_REACH * length * np.abs(np.sin(pitch))
    return lowest  # type: ignore[no-any-return]


def hull_depth(boat: Boat) -> float:
    """Return the depth [m] of the lowest point of the boat's pressure hull."""
    return float(lowest_depth(boat.plain[Z], boat.plain[THETA], boat.file.hull.length))


def crush_depth(hull: Hull) -> float:
    """Return the depth [m] of the origin above which nothing of a hull is crushed."""
    return (hull.collapse_depth_m or math.inf) - hull.length


def collapse_of(boat: Boat) -> str:
    """Return that the hull has collapsed, and where, "" while it holds.

    It holds where the file gives no collapse depth, and as long as the depth is frozen.
    """
    limit = boat.file.hull.collapse_depth_m
    if limit is None or boat.plain[HELD_OFFSET]:
        return ""
    depth = hull_depth(boat)
    return f"collapse at {depth:.0f} m{boat.flat_words}" if depth >= limit else ""


def has_collapsed(boat: Boat, flown: FlownTicks) -> Mask:
    """Return at which ticks the hull has collapsed, as ``collapse_of`` says of one."""
    z, held = flown["z"], flown["held_depth"]
    return is_crushed(boat.file.hull, z, flown["theta"], held)


def is_crushed(hull: Hull, z: Numbers, theta: Numbers, held: Numbers) -> Mask:
    """Return where depth [m] and pitch [rad] crush a hull whose depth is not held."""
    if hull.collapse_depth_m is None:
        return np.zeros(z.size, np.bool_)
    crushed: Mask = (lowest_depth(z, theta, hull.length) >= hull.collapse_depth_m) & (held == 0.0)
    return crushed


def count_passed(test_depth: float, depth: float) -> int:
    """Return how many depths to call are at a depth [m] or above it."""
    if depth < test_depth:
        return int(depth >= test_depth - FIRST_CALL_M)
    return 2 + math.floor((depth - test_depth) / CALL_SPACING_M)


def called_depth(test_depth: float, index: int) -> PassedDepth:
    """Return a depth to call and its words, by its index from 0, the shallowest."""
    if index == 0:
        depth = test_depth - FIRST_CALL_M
        words = f"Passing {depth:g} m, {FIRST_CALL_M:g} m above test depth"
        return PassedDepth(depth, MonitorCall(words, key=DEPTH_KEYS[0]))
    beyond = CALL_SPACING_M * (index - 1)
    depth = test_depth + beyond
    if index == AT_TEST_DEPTH:
        return PassedDepth(
            depth, MonitorCall(f"Passing test depth, {depth:g} m", key=DEPTH_KEYS[1])
        )
    words = f"Passing {depth:g} m, {beyond:g} m beyond test depth"
    return PassedDepth(depth, MonitorCall(words, Rank.EMERGENCY, DEPTH_KEYS[2]))


@dataclass
class DepthMonitor:
    """The watch on depth: how many calls are made, and when test depth was passed.

    ``session/session`` looks after each tick. ``session/quiet`` asks for ``quiet_ticks`` because
    ticks that are flown in one block must end before anything is to be called.
    """

    passed: int = 0
    raised: bool = False  # the mast of the periscope
    seen: int = 0  # how much of WATCH_CALLS has been called
    times: dict[str, list[float]] = field(default_factory=dict)  # [s]

    @classmethod
    def over(cls, boat: Boat) -> "DepthMonitor":
        """Return the watch over a boat; what it has passed by now is no news."""
        monitor = cls()
        monitor.reset_to(boat)
        return monitor

    def reset_to(self, boat: Boat) -> None:
        """Take the boat as it is. Nothing of it is news."""
        test_depth = boat.file.hull.test_depth_m
        if test_depth is not None:
            self.passed = count_passed(test_depth, hull_depth(boat))
        self.raised = False
        self._look_out(boat)

    def look(self, boat: Boat) -> PassedDepth | None:
        """Return the deepest depth passed since the last look, or what the periscope shows.

        None if there is nothing to call.
        """
        return self._look_down(boat) or self._look_out(boat)

    @property
    def holding(self) -> set[str]:
        """Return the keys of the alerts called that hold still."""
        return {*DEPTH_KEYS[: self.passed], *WATCH_KEYS[: self.seen]}

    def quiet_ticks(self, boat: Boat, flown: FlownTicks) -> int:
        """Return after how many ticks there may be something to call, or all of them."""
        return count_before(self._may_pass(boat, flown) | self._may_rise(boat, flown))

    def _may_rise(self, boat: Boat, flown: FlownTicks) -> Mask:
        """Return at which ticks the mast is raised or lowered, or more of it shows."""
        depth, now = boat.file.run.periscope_depth_m, flown["z"]
        if depth is None:
            return np.zeros(len(flown), np.bool_)
        lowered = now > depth + MAST_LOWERED_M
        raised: Mask = ~lowered & (np.abs(now - depth) < MAST_RAISED_M)
        if not self.raised:
            return raised
        shown = [depth - above for above, _ in WATCH_CALLS]
        high = np.sum([now < each for each in shown], axis=0)
        again = np.sum([now < each + RECALL_SINK_M for each in shown], axis=0)
        seen = np.maximum(high, np.minimum(self.seen, again))
        changed: Mask = lowered | may_surface(boat, flown)
        changed |= seen != self.seen
        return changed

    def _may_pass(self, boat: Boat, flown: FlownTicks) -> Mask:
        """Return at which ticks a depth to call is passed, down or up."""
        test_depth = boat.file.hull.test_depth_m
        if test_depth is None:
            return np.zeros(len(flown), np.bool_)
        depth = lowest_depth(flown["z"], flown["theta"], boat.file.hull.length)
        outside: Mask = depth >= called_depth(test_depth, self.passed).depth
        if self.passed:  # and so far above the last one that it may be called again
            outside |= depth <= called_depth(test_depth, self.passed - 1).depth - RECALL_RISE_M
        outside &= flown["held_depth"] == 0.0
        return outside

    def _look_out(self, boat: Boat) -> PassedDepth | None:
        """Return how far the boat has risen above periscope depth, if that is news."""
        depth, now = boat.file.run.periscope_depth_m, boat.plain[Z]
        if depth is None or now > depth + MAST_LOWERED_M or is_surfacing(boat):
            self.raised, self.seen = False, 0
            return None
        self.raised = self.raised or abs(now - depth) < MAST_RAISED_M
        if not self.raised:
            return None
        high, before = sum(now < depth - above for above, _ in WATCH_CALLS), self.seen
        self.seen = max(
            high, min(before, sum(now < depth - above + RECALL_SINK_M for above, _ in WATCH_CALLS))
        )
        call = MonitorCall(WATCH_CALLS[high - 1][1], key=WATCH_KEYS[high - 1])
        return PassedDepth(now, call) if high > before else None

    def _look_down(self, boat: Boat) -> PassedDepth | None:
        """Return the deepest depth passed since the last look, None if none was."""
        test_depth = boat.file.hull.test_depth_m
        if test_depth is None or boat.plain[HELD_OFFSET]:
            return None
        depth, before = hull_depth(boat), self.passed
        now = count_passed(test_depth, depth)
        # the next one is called again only after the boat has come up from it
        near = depth > called_depth(test_depth, now).depth - RECALL_RISE_M
        self.passed = max(now, min(before, now + near))
        if now <= before:
            return None
        if before <= AT_TEST_DEPTH < now:
            self.times.setdefault("test depth passed", []).append(boat.time)
        return called_depth(test_depth, now - 1)


@dataclass(frozen=True)
class DepthGuard:
    """A guard that levels a boat before it passes a depth, its planes in hand.

    An exercise names the depth (``guard_depth_m``), because a visitor might lose the boat. It takes
    the planes while the boat would be too deep soon, and gives them back when it is level.
    ``session/crew/crew`` asks it only where the planes must be worked by hand.
    """

    deepest: float = math.inf  # [m]

    def holds(self, boat: Boat) -> bool:
        """Return whether the planes are, or are to be, the guard's."""
        if math.isinf(self.deepest):
            return False
        s = boat.state
        coming = float(s.z) + GUARD_AHEAD_S * max(float(s.zdot), 0.0)
        if s.stern_by_hand or s.bow_by_hand:
            return coming > self.deepest
        return coming > self.deepest - RELEASE_MARGIN_M or abs(float(s.theta)) > LEVEL_PITCH

    def order(self, boat: Boat) -> Order | None:
        """Return the order by which it takes the planes or gives them back. None: neither."""
        if math.isinf(self.deepest):
            return None
        by_hand = bool(boat.state.stern_by_hand or boat.state.bow_by_hand)
        if by_hand is not self.holds(boat):
            return None
        reply = parse(f"depth {self.deepest - GUARD_MARGIN_M:g}" if by_hand else "lever zero")
        return reply if isinstance(reply, Order) else None
