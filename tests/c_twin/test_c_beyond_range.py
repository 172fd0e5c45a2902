"""The tick in plain C and the core's end in the same bits beyond the range, and with casualties."""

import math
import shutil
from dataclasses import dataclass
from typing import Final

import numpy as np
import pytest
from bench.standard_hour import TickRunner
from helpers.lanes import sample_cases
from helpers.loops import in_a_loop

from c_twin.compiler import SAME_BITS, build
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.casualties import clear_casualty, insert_casualty
from trainer.config.boat.vessel import load_vessel
from trainer.config.world.sea import load_sea, sea_settings
from trainer.core.ballast.tanks import NEGATIVE_TANK
from trainer.core.casualties import CASUALTY_TABLE, GAUGES
from trainer.core.envelope import EXTRAPOLATED_RANGE, INSIDE_RANGE, OUTSIDE_RANGE, substeps
from trainer.core.kernel import Record
from trainer.core.sea.sea import COSINES, GAMMA, OLD, PEAKED, SUCTION
from trainer.core.stall import is_stalled
from trainer.core.state import STATE_FIELDS
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(
        not shutil.which("gcc") and not shutil.which("cc"), reason="there is no C compiler"
    ),
]

# equations, rates, trigonometry, integrator: all that the C has, each at least once
WAYS: Final = (
    ("modified", "lagged", "exact", "adams2"),
    ("modified", "exact", "report", "adams3"),
    ("basic", "lagged", "report", "best2"),
    ("basic", "exact", "exact", "euler"),
)
STEP: Final = {  # [s] long enough to be divided
    "bb2": 0.5,
    "sdv-mk9": 0.1,
    "remus100": 0.1,
}
PUSHED: Final = 40  # [ticks] after the boat was put into any motion at all
SUFFERED: Final = 20  # [ticks] with a casualty, and after it is cleared
# Only stations see a broken gauge, so that a tick has nothing of it. The C has no fire, which is
# proved by the numbers of a program of its own in core/test_plant.
FELT_KINDS: Final = [
    kind.name
    for kind in CASUALTY_TABLE
    if kind.equipment not in GAUGES and not kind.name.startswith("fire")
]
FEELING: Final = (
    *("surface", "u_c", "command_u_c", "water", "tank_air", "bank"),
    *("plant_fault", "oil_spent", "bus_dead", "battery_spent"),
)


@pytest.fixture(
    scope="module", params=sample_cases(SAME_BITS, SAME_BITS[0]), ids=lambda way: way.name
)
def in_c(request: pytest.FixtureRequest) -> TickRunner:
    """Return the tick in C."""
    return build(request.param)


@dataclass
class Seen:
    """What happened to a boat on her way."""

    valid: set[int]
    divided: int  # [-] most parts of a tick
    polar: int  # [ticks] near the vertical
    cut: int  # [ticks] begun with the water's surface across the hull
    stalled: int  # [ticks]
    slowest: float  # [m/s]


def difference(one: Record, other: Record) -> str:
    """Return which places of two states have not the same bits."""
    a, b = one[0], other[0]
    apart = [n for n in STATE_FIELDS if np.asarray(a[n]).tobytes() != np.asarray(b[n]).tobytes()]
    return f"tick {a.tick:g}: {apart}"


def fly_both(boat: Boat, ticks: int, in_c: TickRunner) -> Seen:
    """Fly a boat and her like in C tick by tick, the same bits after each; return what was seen.

    The other begins with an empty work space.
    """
    other = Boat(boat.file, boat.method)
    for name in ("vessel", "compact", "scheme", "state"):
        getattr(other.records, name)[:] = getattr(boat.records, name)
    s, c = boat.state, boat.records.vessel
    seen = Seen(set(), 1, 0, 0, 0, float(s.u))
    for _ in range(ticks):
        status = in_a_loop(boat.records, 1)
        assert in_c(other.records, 1) == status
        assert boat.records.state.tobytes() == other.records.state.tobytes(), difference(
            boat.records.state, other.records.state
        )
        cut = int(boat.records.scratch[0].cut)
        seen.valid.add(int(s.validity))
        seen.divided = max(seen.divided, substeps(c, boat.method.step, cut, boat.records.state))
        seen.polar += int(s.polar)
        seen.cut += cut
        seen.stalled += int(is_stalled(c, boat.records.state))
        seen.slowest = min(seen.slowest, float(s.u))
        if status:
            break
    return seen


def boat_of(vessel: str, way: tuple[str, str, str, str]) -> Boat:
    """Return a boat at her own step."""
    equations, rates, trig, integrator = way
    return Boat(load_vessel(vessel), Method(equations, rates, trig, integrator, STEP[vessel]))


def in_hand(boat: Boat, command: float) -> None:
    """Put all in hand as it stands, with a command speed [m/s]."""
    s = boat.state
    s.by_hand[:] = s.speed_by_hand = 1.0
    s.ordered[:] = s.surface
    s.ordered_u_c = command


@pytest.mark.parametrize("way", WAYS, ids="-".join)
def test_bb2_backs_full_from_ten_knots(way: tuple[str, str, str, str], in_c: TickRunner) -> None:
    boat = boat_of("bb2", way)
    boat.start(10.0 * KNOT, 300.0, 0.0)
    in_hand(boat, boat.vessel.u_c_astern)

    seen = fly_both(boat, 1200, in_c)

    assert seen.valid == {INSIDE_RANGE, EXTRAPOLATED_RANGE, OUTSIDE_RANGE}
    assert seen.slowest < -2.0


@pytest.mark.parametrize("way", WAYS, ids="-".join)
def test_sdv_rolled_and_dropped_on_the_water(
    way: tuple[str, str, str, str], in_c: TickRunner
) -> None:
    boat = boat_of("sdv-mk9", way)
    boat.start(3.0 * KNOT, 10.0, 0.0)
    in_hand(boat, 0.0)
    s = boat.state
    s.motion[:] = 0.0
    s.u_c, s.phi, s.theta, s.z = 0.0, 2.0, 0.2, -1.0

    seen = fly_both(boat, 1200, in_c)

    assert seen.cut > 5  # she has no weight to spare, and goes on down
    assert seen.divided > 1


@pytest.mark.parametrize("way", WAYS, ids="-".join)
@pytest.mark.parametrize("vessel", STEP)
def test_a_boat_goes_through_the_vertical(
    vessel: str, way: tuple[str, str, str, str], in_c: TickRunner
) -> None:
    boat = boat_of(vessel, way)
    boat.start(boat.file.run.start_speed_kn * KNOT, 300.0, 0.0)
    in_hand(boat, 0.0)
    s = boat.state
    s.theta, s.q = math.radians(80.0), 0.1 * 70.2 / boat.vessel.ell

    seen = fly_both(boat, 600, in_c)

    assert 0 < seen.polar < 600


@pytest.mark.parametrize("way", WAYS[:2], ids="-".join)
@pytest.mark.parametrize(
    "shares", [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.5, 0.5, 0.5), (1.0, 0.0, 0.0)]
)
def test_bb2_blown_and_afloat_in_a_sea(
    shares: tuple[float, float, float], way: tuple[str, str, str, str], in_c: TickRunner
) -> None:
    boat = boat_of("bb2", way)
    boat.start(10.0 * KNOT, 40.0, 0.3, seed=7)
    wanted = sea_settings(load_sea("sea-state-4"), boat.vessel.g)
    wanted[[COSINES, OLD, PEAKED]] = shares
    wanted[GAMMA], wanted[SUCTION] = 3.3, 1.0
    boat.order_sea(wanted, 0.0)
    in_hand(boat, 0.0)
    boat.state.blow[:] = 2.0
    c = boat.vessel
    c.compressibility, c.reference_depth, c.layers = 300.0, 40.0, 3
    c.layer_depth[:3], c.layer_density[:3] = (5.0, 20.0, 35.0), (-1.0, 0.5, 1.0)

    seen = fly_both(boat, 1200, in_c)

    assert seen.cut > 600
    assert seen.divided > 1
    assert boat.state.z < boat.vessel.hull_diameter


@pytest.mark.parametrize("way", WAYS, ids="-".join)
@pytest.mark.parametrize("vessel", STEP)
def test_boats_put_into_any_motion_at_any_attitude_and_depth(
    vessel: str, way: tuple[str, str, str, str], in_c: TickRunner
) -> None:
    rng, stalled, parts = np.random.default_rng(11), 0, set()
    boat = boat_of(vessel, way)
    boat.start(boat.file.run.start_speed_kn * KNOT, 30.0, 0.0)
    boat.put_to_sea(load_sea("sea-state-4"))
    start = boat.snapshot()
    for _ in range(25):
        boat.restore(start)
        put_anywhere(boat, rng)
        seen = fly_both(boat, PUSHED, in_c)
        stalled += seen.stalled
        parts.add(seen.divided)

    assert max(parts) > 1
    if vessel != "remus100":  # her planes hold ahead
        assert stalled > 0


def put_anywhere(boat: Boat, rng: np.random.Generator) -> None:
    """Put a boat into a motion in any direction, down to where nothing of her can show.

    One without tanks has her weight anywhere, so far off that rows of the solve change places.
    """
    s, c = boat.state, boat.vessel
    turning = 2.0 * c.u_c_ahead / c.ell
    s.motion[:3] = rng.uniform(-c.u_c_ahead, c.u_c_ahead, 3)
    s.motion[3:6] = rng.uniform(-turning, turning, 3)
    s.motion[6:9] = rng.uniform(-math.pi, math.pi, 3)
    s.theta *= 0.5
    s.z = rng.uniform(-0.5, 2.0) * c.surface_line
    s.x_g, s.y_g, s.z_g = rng.uniform(-3.0, 3.0, 3)
    s.surface[:] = rng.uniform(-1.0, 1.0, 3) * c.limit
    s.u_c = rng.uniform(c.u_c_astern, c.u_c_ahead)
    in_hand(boat, float(rng.uniform(c.u_c_astern, c.u_c_ahead)))


@pytest.mark.parametrize("kind", sample_cases(FELT_KINDS, *FELT_KINDS[::4]))
def test_bb2_at_work_suffers_every_casualty(kind: str, in_c: TickRunner) -> None:
    sound, boat = bb2_at_work(), bb2_at_work()
    in_a_loop(sound.records, SUFFERED)

    assert not isinstance(insert_casualty(boat, kind), Refused)
    fly_both(boat, SUFFERED, in_c)
    felt = any(np.any(boat.state[name] != sound.state[name]) for name in FEELING)
    clear_casualty(boat, kind)
    fly_both(boat, SUFFERED, in_c)

    assert felt, f"nothing in bb2_at_work feels {kind}: put at work what it acts on"


@pytest.mark.parametrize("automatic", [True, False])
def test_bb2_goes_flat_and_black_and_her_oil_is_spent(in_c: TickRunner, *, automatic: bool) -> None:
    boat = boat_of("bb2", WAYS[0])
    boat.start(10.0 * KNOT, 60.0, 0.0)
    s = boat.state
    s.battery_spent = float(boat.vessel.battery_full) - 3e7
    if not automatic:
        in_hand(boat, float(s.u_c))

    for stroke in range(40):  # from stop to stop, until the accumulators are empty
        s.ordered_depth = 60.0 + 40.0 * (stroke % 2)
        s.ordered[:] = 0.4 * (-1.0) ** stroke
        fly_both(boat, 30, in_c)

    assert s.bus_dead.all()
    assert s.gyro_unfed > 0.0
    assert s.u_c < 0.1
    assert automatic or s.oil_spent[0] > 0.9 * boat.vessel.oil_usable[0]


def bb2_at_work() -> Boat:
    """Return a BB2 whose rudder, planes, propeller, pumps, tanks and air are all at work."""
    boat = boat_of("bb2", WAYS[0])
    boat.start(8.0 * KNOT, 40.0, 0.0)
    s = boat.state
    s.ordered_speed = 14.0 * KNOT
    s.by_hand[:] = 1.0  # the autopilot works valves of its own in a blow
    s.ordered[:] = 0.2
    s.negative_flood = 1.0
    s.blow[:], s.vent[:] = 2.0, 0.01
    s.water[: NEGATIVE_TANK + 1] *= 0.8  # a full tank loses all its air at once
    s.to_move[:] = 5000.0
    return boat


@pytest.mark.parametrize("alone", [0, 1])
def test_the_scheme_without_the_envelope_has_the_equations_of_1969(
    alone: int, in_c: TickRunner
) -> None:
    boat = boat_of("bb2", WAYS[0])
    boat.start(10.0 * KNOT, 300.0, 0.0)
    boat.records.scheme["envelope"] = 1 - alone
    in_hand(boat, boat.vessel.u_c_astern)

    seen = fly_both(boat, 400, in_c)

    assert OUTSIDE_RANGE in seen.valid


@pytest.mark.parametrize("name", ["u", "r", "theta", "z"])
def test_a_tick_that_loses_its_numbers_is_the_same_failure(name: str, in_c: TickRunner) -> None:
    boat = boat_of("bb2", WAYS[0])
    boat.start(10.0 * KNOT, 300.0, 0.0)
    boat.state.theta = 1.5  # where the attitude is turned
    boat.state[name] = math.nan

    fly_both(boat, 1, in_c)

    assert boat.ticks == 0
