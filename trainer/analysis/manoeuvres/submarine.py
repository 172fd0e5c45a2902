"""A boat as a vehicle for manoeuvres, by its own controls or those of 1969.

``flight`` knows only vehicles; here orders go into a boat's state and its columns come out. What a
manoeuvre does not use is held: depth by the planes, course by the rudder, speed by the propeller.
The report of 1969 moved its controls at once, without lag or dead time.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.manoeuvres.vehicle import Control, LostError, Watch
from trainer.analysis.programs.neutral import trim_at
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.depths import collapse_of, feeling_surface, hull_depth, lowest_depth
from trainer.boat.limits import height_showing
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.core import entry
from trainer.core.actuators import move_surfaces
from trainer.core.autopilot.steering import OWN_LAW, REPORT_LAW, REPORT_LITERAL
from trainer.core.integrators import advance
from trainer.core.kernel import Numbers
from trainer.core.propulsion import answer_telegraph
from trainer.core.sea.sea import COSINES, DIRECTION, GAMMA, HEIGHT, OMEGA, TAPER
from trainer.core.update import lost, outside

# fmt: off
BOAT_COLUMNS: Final = (
    "t", "u", "v", "w", "p", "q", "r", "x", "y", "z", "phi", "theta", "psi", "delta_r", "delta_s",
    "delta_b", "u_c",
)
# fmt: on
CONTROL_SURFACES: Final = {"rudder": ("rudder", "r"), "planes": ("stern", "s")}
DEPTH_LAWS: Final = {"trainer": OWN_LAW, "report": REPORT_LAW, "literal": REPORT_LITERAL}
DEEP_WATER_M: Final = 1000.0  # [m] room for any manoeuvre, and away from the surface
CALM_SEA: Final = "calm"
MAX_PITCH_RAD: Final = math.radians(80.0)
SPEED_GAIN: Final = 4.0  # [-] command speed per speed, and
SPEED_RATE: Final = 0.2  # [1/s] per its integral
INSTANT_RATE_RAD_S: Final = 1e9  # [rad/s]
CYCLE_ROUNDING: Final = 1e-12  # [cycles]
WATCHED_QUANTITIES: Final = {
    "theta": entry.PITCH,
    "size of theta": entry.PITCH_SIZE,
    "psi": entry.HEADING,
    "u": entry.SPEED,
    "depth rate": entry.DEPTH_RATE,
}


@dataclass(frozen=True)
class Rig:
    """How a boat is handled in manoeuvres."""

    controls: str = "own"  # "own" rates, lags and dead time, or at "once", as CONTR has them
    trim: str = "own"  # neutral angles: the "own" equations' or those of the "full" set
    law: str = "trainer"  # of depth keeping, a name of DEPTH_LAWS; without gains the report's
    depth: float | None = (
        None  # [m] to begin at; None: DEEP_WATER_M, where the hull holds and no sea is
    )
    sea: str = CALM_SEA  # name or path, in force from the start
    seed: int = 1  # of the sea
    engine: str = "held"  # revolutions "held" whatever they take, or "limited" as the engine's are


def _no_sea_felt(what: str) -> str:
    """Return in words why a sea does nothing where manoeuvres begin."""
    return (
        f"{what}: no sea is felt {DEEP_WATER_M:g} m down, where manoeuvres begin unless told "
        "otherwise; give a --depth"
    )


class _Boat(Boat):
    """A boat that also starts at rest, in another boat's trim, or in that near the surface."""

    model: Boat | None = None  # whose trim it takes
    depth: float | None = None  # [m] at which it is in trim; None: in deep water

    def trimmed(self, speed: float) -> bool:
        """Bring the state into straight level flight at ``speed`` [m/s]."""
        if speed == 0.0:
            self.state.u = self.state.u_c = 0.0
            return True
        if self.model is None:
            with feeling_surface(self, speed, self.depth):
                return super().trimmed(speed)
        settled = trim_at(self.model, speed, self.depth) is not None
        for name in ("u", "v", "w", "phi", "theta", "delta_r", "delta_s", "delta_b", "u_c"):
            self.state[name] = self.model.state[name]
        return settled


class Submarine:
    """A boat under the orders of a manoeuvre."""

    columns = BOAT_COLUMNS

    def __init__(self, file: VesselFile, method: Method, rig: Rig = Rig()) -> None:
        """Fit the boat out; ConfigError for a sea where none is felt."""
        self.name = file.name
        self.length = file.hull.length
        self.step = method.step
        self.boat = _Boat(file, method)
        if rig.sea != CALM_SEA:
            self.boat.sea = load_sea(rig.sea)
            if rig.depth is None:
                raise ConfigError(_no_sea_felt(f"--sea {rig.sea}"))
        self.boat.depth = rig.depth
        self.sea = rig.sea  # in words, for a page
        self._depth, self._seed = rig.depth, rig.seed
        self._collapsed = ""  # in the last sail
        if rig.trim == "full":
            self.boat.model = Boat(file, Method("full", "exact", "exact", "adams2", method.step))
        self._at_once = rig.controls == "once"
        self._law = (
            DEPTH_LAWS[rig.law] if self.boat.automatic else max(DEPTH_LAWS[rig.law], REPORT_LAW)
        )
        self._neutral = {"rudder": 0.0, "planes": 0.0}
        self._kept_speed: float | None = None
        self._lookout = np.zeros(1, entry.LOOKOUT)
        self._lookout["steepest"] = MAX_PITCH_RAD
        vessel = self.boat.records.vessel
        if rig.engine == "held":
            vessel["torque_limit"] = 0.0  # what holds revolutions holds them, whatever the engine
        if self._at_once:
            vessel["surface_rate"], vessel["surface_lag"] = INSTANT_RATE_RAD_S, 0.0
            vessel["telegraph_dead_time"], vessel["propulsion_lag"] = 0.0, 0.0

    @property
    def controls(self) -> Mapping[str, Control]:
        """Return the limits of its controls by name."""
        c, toward = self.boat.vessel, self.boat.toward
        controls = {}
        for control, (surface, letter) in CONTROL_SURFACES.items():
            most = float(c[f"limit_{letter}"])
            if toward[surface] and most > 0.0:
                controls[control] = Control(-most, most)
        return controls | {"engine": Control(float(c.u_c_astern), float(c.u_c_ahead))}

    def start(self, speed: float) -> None:
        """Begin anew in trim at ``speed`` [m/s], everything in hand; ConfigError if it cannot."""
        self._begin(speed)
        self._kept_speed = None
        s = self.boat.state
        s.by_hand[:] = 1.0
        s.speed_by_hand = s.trim_by_hand = 1.0
        s.ordered_u_c = s.telegraph_order = s.u_c
        s.depth_law = self._law
        self._neutral = {"rudder": float(s.delta_r), "planes": float(s.delta_s)}

    def _begin(self, speed: float) -> None:
        """Start the boat at its depth; ConfigError if it may not be there, or shows in the air."""
        file, depth = self.boat.file, self._depth
        if depth is None:
            self.boat.start(speed, DEEP_WATER_M, 0.0, self._seed)
            return
        deepest = file.hull.max_depth_m
        if deepest is not None and depth > deepest:
            raise ConfigError(
                f"{file.path.name}: a depth of {depth:g} m is below max_depth_m = {deepest:g} m, "
                "the deepest that may be ordered"
            )
        self.boat.start(speed, depth, 0.0, self._seed)
        height = height_showing(self.boat)
        if height > 0.0:
            least = math.ceil(10.0 * (depth + height)) / 10.0
            raise ConfigError(
                f"{file.path.name}: at a depth of {depth:g} m the boat shows {height:.1f} m above "
                f"the sea; begin at {least:g} m or deeper"
            )

    def notices(self, columns: Mapping[str, Numbers]) -> tuple[str, ...]:
        """Return in words when a flight passed test depth and broke surface. It has columns (n,).

        Waves do not count as breaking surface. A boat without a depth of its own has no notices.
        """
        if self._depth is None:
            return ()
        t, notices = columns["t"], []
        lowest = lowest_depth(columns["z"], columns["theta"], self.length)
        test_depth = self.boat.file.hull.test_depth_m
        if test_depth is not None and (deep := np.flatnonzero(lowest > test_depth)).size:
            notices.append(f"test depth, {test_depth:g} m, is passed after {t[deep[0]]:g} s")
        heights = self._heights(columns)
        if (out := np.flatnonzero(heights > 0.0)).size:
            most = f"{heights.max():.1f} m above still water"
            notices.append(f"BROACHED after {t[out[0]]:g} s; the boat shows at most {most}")
        return tuple(notices)

    def _heights(self, columns: Mapping[str, Numbers]) -> Numbers:
        """Return the height [m] (n,) of the boat's highest part above still water."""
        s, as_it_was = self.boat.state, self.boat.snapshot()
        heights = np.full(columns["t"].size, -np.inf)
        s.eta_wave = 0.0
        for i in np.flatnonzero(columns["z"] < self.boat.reach):
            s.z, s.phi, s.theta = (columns[name][i] for name in ("z", "phi", "theta"))
            heights[i] = height_showing(self.boat)
        self.boat.restore(as_it_was)
        return heights

    def incline(self, heel: float) -> None:
        """Heel the boat by ``heel`` [rad], without a rate."""
        self.boat.state.phi = heel

    def load(self, share: float) -> None:
        """Take on a ``share`` [-] of the boat's weight at its CG, or lose it.

        Tanks and air are held from then on, else they would make up for the weight.
        """
        self.boat.state.weight *= 1.0 + share
        self.boat.state.held_tanks = 1.0

    def meet_sea(self, height: float, period: float) -> None:
        """Let long-crested waves run to starboard, without suction, unless a sea was asked for.

        ``height`` [m] is their significant height, ``period`` [s] that of their peak. ConfigError
        where no sea is felt.
        """
        if self._depth is None:
            raise ConfigError(_no_sea_felt("these waves"))
        if self.boat.state.sea_height > 0.0:
            return
        waves = np.zeros(TAPER + 1)
        waves[[HEIGHT, OMEGA, GAMMA, COSINES]] = height, 2.0 * math.pi / period, 1.0, 1.0
        waves[DIRECTION] = self.boat.state.psi + 0.5 * math.pi
        self.boat.order_sea(waves, 0.0)
        self.sea = f"{height:.3g} m, {period:.3g} s, from port"

    def order(self, control: str, value: float) -> None:
        """Order a surface [rad] from neutral, or the command speed [m/s]."""
        s = self.boat.state
        if control == "engine":
            s.speed_by_hand, s.ordered_u_c = 1.0, value
            return
        surface, letter = CONTROL_SURFACES[control]
        s[f"{surface}_by_hand"] = 1.0
        s[f"ordered_{letter}"] = self._neutral[control] + self.boat.toward[surface] * value

    def keep(self, quantity: str) -> None:
        """Leave "depth" to both pairs of planes, "course" to the rudder, "speed" to the propeller.

        Each is kept as it is now; "depth by stern planes" leaves the bow planes where they are.
        """
        s = self.boat.state
        if quantity == "course":
            s.ordered_psi, s.rudder_by_hand = s.psi, 0.0
            return
        if quantity == "speed":
            if self.boat.automatic:
                self._kept_speed = float(s.u)
                s.ordered_speed, s.speed_trim, s.speed_by_hand = s.u, s.u_c - s.u, 0.0
            return
        s.ordered_depth = s.z
        pairs = (("stern", "s"), ("bow", "b"))
        for surface, letter in pairs[:1] if quantity == "depth by stern planes" else pairs:
            if self.boat.toward[surface] and self.boat.vessel[f"limit_{letter}"] > 0.0:
                s[f"{surface}_by_hand"] = 0.0

    def observe(self) -> tuple[float, ...]:
        """Return the columns as they stand, SI and radians."""
        return tuple(self.boat.numbers(BOAT_COLUMNS))

    def advance(self) -> None:
        """Advance by one cycle; LostError if the numbers go astray."""
        if self._kept_speed is not None:
            self._make_speed(self._kept_speed)
        self._check(self._moved() if self._at_once else self.boat.tick())

    def _check(self, status: int) -> None:
        """Check the tick just made; LostError if the numbers went astray."""
        if status:
            raise LostError(self.boat.failure(status))
        if collapse := self._collapse_words():
            raise LostError(collapse)
        s = self.boat.state
        if abs(s.theta) > MAX_PITCH_RAD:
            raise LostError(
                f"pitch is {math.degrees(s.theta):.0f} degrees after {self.boat.time:g} s, "
                "beyond what the equations are good for"
            )

    @property
    def swift(self) -> bool:
        """Return whether the tick alone moves the boat. Then many can run at once."""
        return self._kept_speed is None and not self._at_once

    def sail(self, end: float, watch: Watch | None) -> Numbers:
        """Advance to ``end`` [s], or until what is watched passes. Return a row for each cycle."""
        last = math.ceil(end / self.step - CYCLE_ROUNDING)
        eye = self._lookout
        eye["last"], eye["watched"], eye["status"] = last, entry.NO_QUANTITY, 0.0
        if watch:
            eye["watched"], eye["mark"] = WATCHED_QUANTITIES[watch.quantity], watch.mark
            eye["side"] = watch.side
        begun, start = self.boat.ticks, self.boat.snapshot()
        rows = np.empty((max(last - begun, 0), len(BOAT_COLUMNS)))
        rows = rows[: entry.sail(self.boat.records, eye, rows)]
        collapse = self._collapse_in(rows)
        self._collapsed = ""
        if collapse is None:
            return rows
        rows = rows[: collapse + 1]
        self.boat.restore(start)
        eye["last"], eye["watched"] = begun + len(rows), entry.NO_QUANTITY
        entry.sail(self.boat.records, eye, rows)  # to there again
        self._collapsed = self._collapse_words()
        return rows

    def _collapse_words(self) -> str:
        """Return that the hull has collapsed, "" while it holds."""
        if self._depth is None or not collapse_of(self.boat):
            return ""
        after = f"after {self.boat.time:g} s{self.boat.flat_words}"
        return f"collapse at {hull_depth(self.boat):.0f} m {after}"

    def _collapse_in(self, rows: Numbers) -> int | None:
        """Return the first of the rows in which the hull is beyond collapse depth; None: in none.

        Without a depth of its own the boat has room for any manoeuvre.
        """
        limit = self.boat.file.hull.collapse_depth_m
        if self._depth is None or limit is None:
            return None
        beyond = np.flatnonzero(self._lowest(rows.T) >= limit)
        return int(beyond[0]) if beyond.size else None

    def _lowest(self, columns: Numbers) -> Numbers:
        """Return the depth [m] (n,) of the hull's lowest point, by BOAT_COLUMNS (17, n)."""
        z, theta = (columns[BOAT_COLUMNS.index(name)] for name in ("z", "theta"))
        return lowest_depth(z, theta, self.length)

    def sound(self) -> None:
        """Check how the last ``sail`` ended; LostError if the numbers went astray in it."""
        if self._collapsed:
            raise LostError(self._collapsed)
        self._check(int(self._lookout["status"][0]))

    def _make_speed(self, wanted: float) -> None:
        """Let the autopilot's trim of speed bring the boat to a speed [m/s] in turns too.

        Otherwise the autopilot learns it in straight flight alone, and a turn slows the boat.
        """
        s, (low, high) = self.boat.state, self.controls["engine"]
        more = SPEED_RATE * (wanted - float(s.u)) - SPEED_GAIN * float(s.udot)
        command = float(s.ordered_speed + s.speed_trim) + self.step * more
        s.speed_trim = min(max(command, low), high) - s.ordered_speed

    def _moved(self) -> int:
        """Advance with controls that act in the very cycle they are ordered in."""
        vessel, _, scheme, state, scratch = records = self.boat.records
        h = self.step
        self.boat.stand_by()
        move_surfaces(vessel, h, state)
        answer_telegraph(vessel, h, state)
        outside(vessel, scheme, state, scratch)
        advance(*records)
        state["tick"] += 1.0
        return int(lost(state))
