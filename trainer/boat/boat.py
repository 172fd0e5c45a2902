"""A boat under way: the records that the core computes with, and their tick.

``Boat`` joins what the core keeps apart: the vessel, the scheme, and the state that ``tick``
rewrites. Sessions, manoeuvres and sweeps all fly this one object.
"""

import functools
import math
from collections.abc import Callable, Mapping
from copy import copy
from operator import itemgetter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.assemble import Method, Records, fit_out
from trainer.boat.machine_code import EMPTY_CHART, bind
from trainer.boat.world.world import World
from trainer.config.boat.casualties import load_casualties
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.config.world.sea import SeaFile, load_sea, sea_settings, step_problem
from trainer.core.autopilot.autopilot import stand_by_all
from trainer.core.ballast.ballast import start_ballast
from trainer.core.casualties import instruments
from trainer.core.entry import fly, tick
from trainer.core.kernel import Numbers, Record
from trainer.core.scheme import equations_alone
from trainer.core.sea.free_surface import DECK_REACH
from trainer.core.sea.sea import order_sea
from trainer.core.start import level_flight, set_out
from trainer.core.state import STATE
from trainer.core.surfaces import SURFACES
from trainer.core.update import WATCHED_NAMES
from trainer.units import KNOT

STATE_OFFSETS = {name: field[1] // 8 for name, field in (STATE.fields or {}).items()}
TICK_OFFSET = STATE_OFFSETS["tick"]
# How long an order is flown to see whether it can be kept: estimates
FORESEEN_S: Final = 600.0  # [s]
ASTERN_LENGTHS, ASTERN_S = 120.0, 1800.0  # [-] of the boat, [s]
FLAT_WORDS: Final = ", after the battery went flat"  # of a loss


@functools.cache
def _getter(names: tuple[str, ...]) -> "itemgetter[Any]":
    """Return a getter of the named fields of plain numbers; ``t`` gets the tick.

    One getter takes all numbers of a row at once, which recordings ask for at each tick.
    """
    return itemgetter(*(TICK_OFFSET if name == "t" else STATE_OFFSETS[name] for name in names))


def turning_signs(coefficients: Mapping[str, float]) -> dict[str, float]:
    """Return by surface which sign turns right or lifts; 0 without effect.

    The coefficients carry it: rudder by yawing moment, stern planes by pitching moment, bow by
    lift.
    """
    effects = {
        "rudder": coefficients["N_dr"],
        "stern": coefficients["M_ds"],
        "bow": -coefficients["Z_db"],
    }
    return {name: math.copysign(1.0, effect) if effect else 0.0 for name, effect in effects.items()}


class Boat:
    """One boat. ``state`` is all that evolves: copy it to keep a moment, assign it to go back.

    ``plain`` is a view of the same numbers by their STATE_OFFSETS, as reading one there takes a
    twentieth of the time.
    """

    def __init__(self, file: VesselFile, method: Method) -> None:
        """Fit the boat out; it lies still at the surface until ``start``."""
        self.file = file
        self.method = method
        self.toward = turning_signs(file.coefficients)
        self.sea = load_sea("calm")
        self.casualties = load_casualties()
        self.take_records(fit_out(file, method))
        start_ballast(self.records.vessel, self.records.state)
        # how far [m] from the origin the sail's top and the ends of the deck are, at most
        deck = math.hypot(DECK_REACH * self.vessel["ell"], self.vessel["z_deck"])
        self.reach = max(deck, math.hypot(self.vessel["x_sail"], self.vessel["z_sail"]))
        self._fillings = self.vessel.start.copy()  # [kg] at which the vessel file's weight holds

    def take_records(self, records: Records) -> None:
        """Have these records, and nothing around."""
        self.records = records
        self.vessel = records.vessel[0]
        self.state = records.state[0]
        whole: Any = records.state.view(np.uint8)
        self.plain = memoryview(whole).cast("d")
        self.chart: Numbers | None = None  # of the ground, as core.soundings has it
        self.world = World()

    def another(self) -> "Boat":
        """Return a copy of this boat, which was never started.

        To fit one out anew takes fifty times as long.
        """
        boat = copy(self)
        boat.take_records(self.records.copy())
        return boat

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self.plain[TICK_OFFSET] * self.method.step

    @property
    def ticks(self) -> int:
        """Return the number of ticks done."""
        return int(self.plain[TICK_OFFSET])

    def ticks_in(self, seconds: float) -> int:
        """Return a time [s] as whole ticks, at least its length.

        A time on a tick, such as 30 s of 0.1 s, is that tick, whatever rounding makes of it.
        """
        return math.ceil(seconds / self.method.step - 1e-9)

    @property
    def automatic(self) -> bool:
        """Return whether the vessel file gives autopilot gains."""
        return bool(self.vessel.gain_count > 0.0)

    @property
    def has_plant(self) -> bool:
        """Return whether the vessel file says what feeds the boat."""
        return bool(self.vessel.battery_full > 0.0)

    @property
    def astern_pace(self) -> float:
        """Return how fast [m/s] the boat goes astern, or is ordered to; 0 ahead."""
        s = self.state
        return float(max(-s.u, -(s.ordered_u_c if s.speed_by_hand else s.ordered_speed), 0.0))

    @property
    def flat_words(self) -> str:
        """Return words for a loss where the battery is flat, else ""."""
        spent, full = float(self.state.battery_spent), float(self.vessel.battery_full)
        return FLAT_WORDS if 0.0 < full <= spent else ""

    def carries(self, surface: str) -> bool:
        """Return whether the boat has that surface, and it does something."""
        return bool(self.toward[surface] and self.vessel[f"limit_{SURFACES[surface]}"])

    def trimmed(self, speed: float) -> bool:
        """Bring the state into level flight at ``speed`` [m/s]; return whether it can be."""
        r = self.records
        scheme = equations_alone(r.scheme)
        scheme["exact"] = 1
        with np.errstate(all="ignore"):  # a boat without bow planes has a singular system
            return bool(level_flight(r.vessel, r.compact, scheme, r.state, r.scratch, speed))

    def start(self, speed: float, depth: float, course: float, seed: int = 1) -> None:
        """Start in trim at ``speed`` [m/s], ``depth`` [m] and ``course`` [rad], orders the same.

        The sea stays the one of the last ``put_to_sea``, at first a calm; ``seed`` is that of
        everything random. ConfigError if the boat cannot fly straight and level at that speed.
        """
        self._clear()
        if not self.trimmed(speed):
            raise ConfigError(
                f"{self.file.path.name}: no straight level flight at {speed / KNOT:g} kn "
                f"within the limits of the planes; start at another speed: start_speed_kn of "
                "its [run], speed_kn of an exercise's [initial], or --at"
            )
        s = self.state
        s.z, s.psi, s.seed = depth, course, seed
        set_out(*self.records)
        self.stand_by()
        if self.automatic:
            s.by_hand[:] = self.vessel.limit == 0.0  # nothing to give where there is no surface
            s.speed_by_hand = s.trim_by_hand = 0.0
        self.put_to_sea(self.sea)

    def start_from(self, numbers: Mapping[str, float], seed: int = 1) -> None:
        """Start from these numbers of the state [SI, rad], others 0, with everything in hand.

        The boat need not be in trim, nor able to fly straight and level at all.
        """
        self._clear()
        for name, value in numbers.items():
            self.state[name] = value
        self.state.seed = seed
        set_out(*self.records)
        self.stand_by()
        self.put_to_sea(self.sea)

    def _clear(self) -> None:
        """Bring the boat to rest at the origin, with its file's weight and no trigger armed."""
        self.state.whole[:] = 0.0
        self.vessel.start[:] = self._fillings
        self.records.scheme["trigger_kind"] = 0.0
        for name in ("weight", "x_g", "y_g", "z_g"):
            self.state[name] = self.vessel[name]

    def put_to_sea(self, sea: SeaFile) -> None:
        """Put the boat into a sea at its full height, as after a long time.

        ConfigError if the step is too long for it.
        """
        wanted = sea_settings(sea, self.vessel.g)
        if refused := step_problem(wanted, self.method.step):
            raise ConfigError(f"{sea.path.name}: {refused.reason}")
        self.sea = sea
        self.state.sea_height = 0.0
        self.order_sea(wanted, 0.0)

    def order_sea(self, wanted: Numbers, ramp: float) -> None:
        """Order a sea, by ``sea_settings`` [SI], to be in force after ``ramp`` [s]."""
        s = self.state
        if s.sea_height == 0.0:
            s.sea[1:] = wanted[1 : s.sea.size]  # a calm has all but height at once
        records = self.records
        order_sea(records.vessel, self.method.step, ramp, wanted, records.scratch, records.state)

    def stand_by(self) -> None:
        """Make the autopilot's integrals ready to take over without a jump, with hands on."""
        records = self.records
        stand_by_all(records.vessel, self.method.step, records.state, records.scratch)

    @property
    def world(self) -> World:
        """Return what is around the boat and acts on it."""
        return self._world

    @world.setter
    def world(self, world: World) -> None:
        self._world = world
        world.changed = self._look_around
        self._look_around()

    def _look_around(self) -> None:
        """Forget the cached tick, because the world may begin or cease to act.

        A boat alone then ticks without asking a world.
        """
        self.__dict__.pop("tick", None)

    @functools.cached_property
    def tick(self) -> Callable[[], int]:
        """Advance by one step. Return 0, or a status for ``failure`` with the state as it was."""
        return self._in_its_world if self.world.acts else self.advance

    def meet_world(self) -> None:
        """Write the world to the state before the first tick, for the first picture."""
        if not self.world.acts:
            return
        self.world.write(self.plain)
        s = self.state
        s.xdot = s.through_north + s.water_north + s.shear_north * s.z
        s.ydot = s.through_east + s.water_east + s.shear_east * s.z

    def _in_its_world(self) -> int:
        self.world.write(self.plain)
        return self.advance()

    def sound_by(self, chart: Numbers | None) -> None:
        """Sound this chart of the ground before each tick from now on; None: none."""
        self.chart = chart
        for name in ("advance", "tick"):
            self.__dict__.pop(name, None)

    @functools.cached_property
    def advance(self) -> Callable[[], int]:
        """Advance by one step, the world as the state has it."""
        return bind(tick, self.records, EMPTY_CHART if self.chart is None else self.chart)

    def fly(self, offsets: NDArray[np.int64], rows: Numbers) -> int:
        """Advance by a step for each of ``rows``.

        Return 0, or the status of the tick that failed, which writes no row. A row gets the numbers
        of the state at ``offsets``, then what the gauges read, if it is longer.
        """
        if self.world.stands(self.ticks):
            self.world.write(self.plain)  # once for all
            chart = EMPTY_CHART if self.chart is None else self.chart
            return int(fly(self.records, chart, offsets.astype(np.float64), rows))
        # A current, the pull of ships or a raised periscope is written by Python, before each tick.
        numbers = self.records.state.view(np.float64)
        readings = self.records.scratch["reading"][0]
        for row in rows:
            if status := self.tick():
                return status
            row[: offsets.size] = numbers[offsets]
            if row.size > offsets.size:
                instruments(self.records.state, self.records.scratch)
                row[offsets.size :] = readings
        return 0

    def foresee(self, name: str) -> float:
        """Return what a number of the state is FORESEEN_S later; the boat stays here.

        Astern it is the time for ASTERN_LENGTHS of the boat, if longer, ASTERN_S at most.
        """
        way = ASTERN_LENGTHS * self.file.hull.length
        seconds = min(max(FORESEEN_S, way / (self.astern_pace or math.inf)), ASTERN_S)
        there, rows = self.snapshot(), np.full((self.ticks_in(seconds), 1), self.state[name])
        self.fly(np.array([STATE_OFFSETS[name]]), rows)
        self.restore(there)
        return float(rows[-1, 0])

    def fly_and_keep(
        self, offsets: NDArray[np.int64], rows: Numbers, keep: Callable[[Numbers], int]
    ) -> tuple[int, Numbers]:
        """Fly as ``fly`` does, to the end of the rows that are kept.

        ``keep`` says how many of the rows flown these are. If it is fewer, the boat goes back and
        flies to there again, with the same bits. Return the status, and the rows kept.
        """
        # Nobody looks on the way, because that would leave the machine code at each tick. What
        # gauges show, a collapse or a collision is found in the rows.
        begun, start = self.ticks, memoryview(self.plain.tobytes()).cast("d")
        status = self.fly(offsets, rows)
        flown = rows[: self.ticks - begun]
        kept = flown[: keep(flown)]
        if len(kept) < len(flown):
            self.plain[:] = start  # as it was
            status = self.fly(offsets, kept)
        return status, kept

    def failure(self, status: int) -> str:
        """Return where and when a failing tick lost its numbers, in words."""
        s = self.state
        return (
            f"{WATCHED_NAMES[status - 1]} is out of all bounds after tick {int(s.tick)} "
            f"({self.time:g} s); last good state: u {s.u:.4g} m/s, pitch "
            f"{math.degrees(s.theta):.4g} deg, heel {math.degrees(s.phi):.4g} deg, "
            f"depth {s.z:.4g} m{self.flat_words}"
        )

    def numbers(self, names: tuple[str, ...]) -> list[float]:
        """Return the named fields of the state; ``t`` is the time [s]."""
        if not names:
            return []
        taken = _getter(names)(self.plain)
        values = list(taken) if len(names) > 1 else [taken]
        if "t" in names:
            values[names.index("t")] = self.time
        return values

    def snapshot(self) -> Record:
        """Return a copy of the whole state."""
        # as plain numbers: numpy copies a record name by name, in forty times the time
        return np.array(self.plain).view(STATE)

    def restore(self, snapshot: Record) -> None:
        """Go back to ``snapshot``, to the bit."""
        self.records.state.view(np.float64)[:] = snapshot.view(np.float64)
