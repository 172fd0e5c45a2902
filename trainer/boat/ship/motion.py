"""A ship that is not linear under way: its rudder, its propeller, Runge and Kutta.

``world/steered_ship`` moves ships near the boat by it, and ``identify`` fits ships by the same
kernels, so that a ship sails as it was fitted. Steps are by Runge and Kutta of fourth order.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.ship.forces import (
    AXIS_COUNT,
    NONLINEAR_COUNT,
    PART_COUNT,
    ROLL_INDEX,
    ROLL_RATE_INDEX,
    RUDDER,
    DrivenStates,
    R,
    System,
    U,
    V,
    add_heel,
    add_terms,
    rows_of,
    set_terms,
    states_of,
)
from trainer.boat.ship.forward_numbers import VALUE
from trainer.boat.ship.models import check_names, model_for
from trainer.config.files import ConfigError
from trainer.config.ship.ship import ShipFile
from trainer.core.kernel import Numbers, kernel
from trainer.units import KNOT

# A state beyond these is no ship's: numbers run away, or the equations, which divide by speed, end.
MIN_SHIP_SPEED: Final = 0.01  # [m/s]
MAX_SHIP_SPEED: Final = 1000.0  # [m/s] beyond it the numbers are lost
MAX_TURN_RATE: Final = 10.0  # [rad/s]
MAX_ROLL: Final = 1.5  # [rad] of roll
STAGE_TIMES: Final = (0.0, 0.5, 0.5, 1.0)  # [steps] of the four stages of Runge and Kutta
STAGE_WEIGHTS: Final = (1.0, 2.0, 2.0, 1.0)  # of their rates, over six
STEP_SHARE: Final = 0.025  # [L/U] of a step
ROLL_PHASE_STEP: Final = 0.5  # [rad] of roll's own period in a step
MAX_NEWTON_STEPS: Final = 60  # to the sway, rudder and revolutions of straight motion
NEWTON_TOLERANCE: Final = 1e-10  # [SI] accelerations left where a start counts as steady
NONE_FREE: Final = np.empty((0, 1), np.int64)


class MotionRoom(NamedTuple):
    """Scratch of a step."""

    table: Numbers  # of the terms
    rates: Numbers  # accelerations
    stage: Numbers  # the state within the step
    rate: Numbers  # dx/dt there
    total: Numbers  # weighted sum of those rates


def new_room(system: System) -> MotionRoom:
    """Return scratch for a ship's steps."""
    driven = system.driven
    parts = PART_COUNT if len(driven) == AXIS_COUNT else len(driven)
    states = (np.empty(states_of(driven)) for _ in range(3))
    return MotionRoom(np.empty((rows_of(system.terms), 1)), np.empty((parts, 1)), *states)


@kernel
def is_ship(x: Numbers) -> bool:
    """Return whether a state is that of a ship under way."""
    upright = x.size <= ROLL_INDEX or (
        abs(x[ROLL_RATE_INDEX]) <= MAX_TURN_RATE and abs(x[ROLL_INDEX]) <= MAX_ROLL
    )
    size = (
        abs(x[U]) <= MAX_SHIP_SPEED and abs(x[V]) <= MAX_SHIP_SPEED and abs(x[R]) <= MAX_TURN_RATE
    )
    return x[U] >= MIN_SHIP_SPEED and size and upright


@kernel
def set_rates(system: System, x: Numbers, c: Numbers, table: Numbers, rates: Numbers) -> None:
    """Write the accelerations (parts, columns) at a state and inputs; ``table`` is scratch."""
    count = system.terms.shape[0]
    set_terms(table, system.ship, x, c, system.values[count : count + NONLINEAR_COUNT])
    add_terms(table, system.terms, system.values, system.ship, rates)
    if len(system.driven) == AXIS_COUNT:
        add_heel(x, rates)


@kernel
def set_derivative(driven: DrivenStates, x: Numbers, rates: Numbers, out: Numbers) -> None:
    """Write dx/dt from the accelerations."""
    for e in range(len(driven)):
        out[driven[e]] = rates[e, VALUE]
    # heading and roll (3 and 5) have their rates one index before
    for i in range(3, states_of(driven), 2):
        out[i] = x[i - 1]


@kernel
def advance_state(
    system: System, x: Numbers, c: Numbers, rudder: float, h: float, room: MotionRoom
) -> bool:
    """Advance a state by ``h`` [s]; return whether it is still a ship.

    The step is one of Runge and Kutta, the rudder on its way to ``rudder`` [rad]. ``c`` are the
    inputs at the beginning, and those at the end afterwards; the last two are the wind.
    """
    stage, rate, total = room.stage, room.rate, room.total
    before, states = c[RUDDER], states_of(system.driven)
    for i in range(states):
        total[i] = 0.0
        rate[i] = 0.0
    for n in range(4):
        for i in range(states):
            stage[i] = x[i] + STAGE_TIMES[n] * h * rate[i]
        c[RUDDER] = before + STAGE_TIMES[n] * (rudder - before)
        set_rates(system, stage, c, room.table, room.rates)
        set_derivative(system.driven, stage, room.rates, rate)
        for i in range(states):
            total[i] += STAGE_WEIGHTS[n] * rate[i]
    for i in range(states):
        x[i] += h / 6.0 * total[i]
    return is_ship(x)


class ShipMoment(NamedTuple):
    """A ship at a time, SI; the rudder is positive to starboard."""

    north: float
    east: float
    state: tuple[float, ...]  # u, v, r, heading; with roll its rate and roll
    rudder: float
    turns: float  # [1/s] of the propeller


class ShipMotion:
    """The motion of a ship by the numbers of its file."""

    def __init__(self, ship: ShipFile) -> None:
        """Take the ship's numbers; ConfigError if no fit has given it any."""
        if ship.result is None:
            raise ConfigError(
                f"{ship.path.name}: lacks [result] and [coefficients]: fit it first, "
                "trainer identify RECORD --model mmg --ship FILE --write-ship FOUND"
            )
        self.file, self.result = ship, ship.result
        self.length = ship.dimensions.length_m
        self.limit = math.radians(ship.dimensions.rudder_limit_deg)
        self._fastest = math.radians(ship.dimensions.rudder_rate_deg_s)
        model = model_for(ship, self.result.model, wind="N_ww" in ship.coefficients)
        check_names(ship, model)
        values = np.concatenate(
            [model.whole(ship.coefficients), np.zeros(len(model.noises) + model.states)]
        )
        constants = np.array(ship.constants)
        self._system = System(constants, model.terms, values, NONE_FREE, model.driven)
        self._room = new_room(self._system)

    @property
    def states(self) -> int:
        """Return how many states there are."""
        return states_of(self._system.driven)

    @property
    def step(self) -> float:
        """Return the usual step [s]."""
        usual = STEP_SHARE * self.length / (self.result.speed_kn * KNOT)
        if self.file.roll is not None:
            usual = min(usual, ROLL_PHASE_STEP / math.sqrt(self.file.stiffness))
        return float(f"{usual:.1g}")

    def straight(self, speed: float) -> ShipMoment:
        """Return the ship straight ahead to the north; ConfigError if nothing holds it there."""
        sway, rudder, turns, *heel = self._steady(speed)
        rolls = (0.0, *heel) if heel else ()
        return ShipMoment(0.0, 0.0, (speed, sway, 0.0, 0.0, *rolls), rudder, turns)

    def after(self, now: ShipMoment, wanted: float, h: float) -> ShipMoment | None:
        """Return the ship ``h`` [s] later, its rudder on the way to ``wanted`` [rad].

        None if it is then no ship under way.
        """
        most = self._fastest * h
        rudder = now.rudder + min(
            max(min(max(wanted, -self.limit), self.limit) - now.rudder, -most), most
        )
        before, c = np.array(now.state), np.array([now.rudder, now.turns, 0.0, 0.0])
        x = before.copy()
        if not advance_state(self._system, x, c, rudder, h, self._room):
            return None
        # the mean of both ends is enough, because nothing depends on position
        u, v, _, psi, *_ = (0.5 * (before + x)).tolist()
        north = now.north + h * (u * math.cos(psi) - v * math.sin(psi))
        east = now.east + h * (u * math.sin(psi) + v * math.cos(psi))
        return ShipMoment(north, east, tuple(x.tolist()), rudder, now.turns)

    def _rates(self, state: Numbers, rudder: float, turns: float) -> Numbers:
        """Return du/dt, dv/dt, dr/dt, and with roll dp/dt, in no wind."""
        room = new_room(self._system)
        inputs = np.array([rudder, turns, 0.0, 0.0])
        set_rates(self._system, state, inputs, room.table, room.rates)
        return np.array(room.rates[: len(self._system.driven), VALUE])

    def _steady(self, speed: float) -> tuple[float, ...]:
        """Return sway [m/s], rudder [rad] and revolutions [1/s] of straight motion, by Newton.

        With roll, also the heel [rad].
        """
        axes = len(self._system.driven)
        scale = np.array([speed, 1.0, self.result.revolutions_per_s or 1.0, 1.0])[:axes]
        unknowns = np.zeros(axes)
        unknowns[2] = scale[2] * speed / (self.result.speed_kn * KNOT)
        still = [0.0] if axes == AXIS_COUNT else []
        levers = np.array([1.0, 1.0, self.length, self.length])[:axes]
        unit = levers * self.length / max(speed, 1e-9) ** 2

        def residual(z: Numbers) -> Numbers:
            state = np.array([speed, z[0], 0.0, 0.0, *still, *z[3:]])
            return unit * self._rates(state, z[1], z[2])

        for _ in range(MAX_NEWTON_STEPS):
            off = residual(unknowns)
            if np.max(np.abs(off)) < NEWTON_TOLERANCE:
                break
            aside = np.diag(1e-6 * scale)
            J = np.column_stack(
                [(residual(unknowns + e) - residual(unknowns - e)) / (2.0 * e.sum()) for e in aside]
            )
            try:
                move = np.linalg.solve(J, off)
            except np.linalg.LinAlgError:
                break
            unknowns = unknowns - move / max(1.0, float(np.max(np.abs(move) / (0.3 * scale))))
        good = (
            np.max(np.abs(residual(unknowns))) < 1e3 * NEWTON_TOLERANCE
            and abs(unknowns[1]) < self.limit
        )
        if not good or not np.isfinite(unknowns).all():
            raise ConfigError(
                f"{self.file.name}: nothing holds it straight at {speed / KNOT:.4g} kn; "
                f"it was identified at {self.result.speed_kn:.4g} kn"
            )
        return tuple(map(float, unknowns))
