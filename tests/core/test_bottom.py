"""The ground: the forces on the keel, and the chart that is sounded under the hull."""

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import make_boat, start_boat

from trainer.boat.ballast_orders import put_out_of_trim
from trainer.boat.boat import Boat
from trainer.boat.casualties import clear_casualty, insert_casualty, instrument_readings
from trainer.boat.world.bottom import Ground, chart_of, keel_of
from trainer.config.files import Position
from trainer.config.world.bottom import Bottom, read_bottom
from trainer.config.world.soundings import Grid
from trainer.core.casualties import KINDS, SOUNDER_RANGE
from trainer.core.soundings import DISTANT_GROUND_M, FIRST_SAMPLE, SELDOM_MASK, sound
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

TONNE = 9.80665e3  # [N]


def ground(**table: object) -> Bottom:
    """Return the ground of a table [bottom]."""
    return read_bottom(table, Position("x.toml", "bottom"), Path("x.toml"))


def by_hand(boat: Boat) -> None:
    """Put all in hand, surfaces amidships."""
    s = boat.state
    s.by_hand[:] = s.speed_by_hand = s.trim_by_hand = 1.0
    s.ordered[:] = 0.0


def sinking(boat: Boat, rate: float, above: float, **more: object) -> float:
    """Start a heavy boat that sinks [m/s], ``above`` [m] flat ground; return the ground's depth."""
    boat.start(1.0, 60.0, 0.0)
    by_hand(boat)
    s = boat.state
    s.u = s.u_c = s.ordered_u_c = s.theta = s.delta_s = s.delta_b = 0.0
    s.w = rate
    assert put_out_of_trim(boat, 20_000.0, 0.0) == ""
    depth = 60.0 + keel_of(boat.vessel) + 10.0
    Ground(boat, ground(depth_m=depth, **more))
    s.z += 10.0 - above
    return depth


def lies(boat: Boat, depth: float, seconds: float = 400.0) -> tuple[float, float]:
    """Let a boat come to rest; return the largest load [N] and how deep she went into it [m]."""
    loads, deep = [], []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        loads.append(float(boat.state.bottom_load))
        deep.append(float(boat.state.z) + keel_of(boat.vessel) - depth)
    return max(loads), max(deep)


@pytest.fixture
def boat() -> Boat:
    return make_boat()


@pytest.mark.core
@pytest.mark.long
@pytest.mark.parametrize(
    ("step", "integrator", "most_t", "most_m"),
    [
        (0.25, "adams2", 240.0, 0.75),
        (0.5, "adams2", 280.0, 0.75),
        (1.0, "adams2", 340.0, 1.1),  # the first force comes up to a step's way late
        (0.5, "rk4", 280.0, 0.75),
    ],
)
def test_a_boat_20_t_heavy_sinks_onto_the_ground_and_lies_still(
    step: float, integrator: str, most_t: float, most_m: float
) -> None:
    boat = make_boat(integrator=integrator, step=step)
    most, deepest = lies(boat, sinking(boat, 0.5, 0.5))
    s = boat.state
    into = float(s.z) + keel_of(boat.vessel) - float(s.bottom[0, 2])

    assert most < most_t * TONNE
    assert deepest < most_m
    assert s.bottom_load == pytest.approx(20.0 * TONNE, rel=2e-3)
    assert into == pytest.approx(0.1, abs=0.01)
    assert abs(s.zdot) < 1e-9
    assert s.aground > 100.0 / step


@pytest.mark.core
@pytest.mark.long
def test_the_peak_load_is_the_same_by_runge_kutta_within_10_t() -> None:
    peaks = []
    for integrator, rates in (("adams2", "lagged"), ("rk4", "exact")):
        boat = make_boat(integrator=integrator, rates=rates, step=0.25)
        peaks.append(lies(boat, sinking(boat, 0.5, 0.5), 60.0)[0])
    assert abs(peaks[0] - peaks[1]) < 10.0 * TONNE


@pytest.mark.core
@pytest.mark.long
@pytest.mark.parametrize("step", [0.5, 1.0])
def test_ten_knots_into_a_slope_of_one_in_ten_slides_up_and_stops(step: float) -> None:
    boat = start_boat(10.0 * KNOT, step=step)
    by_hand(boat)
    depth = 60.0 + keel_of(boat.vessel) + 20.0
    Ground(boat, ground(depth_m=depth, slope_percent=10, deepens_deg=180))
    loads = []
    for _ in range(round(400.0 / step)):
        assert boat.tick() == 0
        loads.append(float(boat.state.bottom_load))
    s = boat.state

    assert 400.0 * TONNE < max(loads) < 520.0 * TONNE
    assert abs(s.u) < 0.1
    assert s.z < 20.0  # up the slope
    assert abs(s.phi) > math.radians(5.0)


@pytest.mark.core
@pytest.mark.parametrize(("course", "moment"), [(0.0, 1.0), (math.pi, -1.0)])
def test_ground_under_one_end_turns_the_boat_off_it(course: float, moment: float) -> None:
    """Ground that rises to the north lifts the end that is north."""
    boat = start_boat(1.0, 60.0, course)
    s = boat.state
    s.u = s.v = s.w = s.q = 0.0
    bow = 0.45 * float(boat.vessel.ell)
    depth = 60.0 + keel_of(boat.vessel) + 6.0  # it touches from 60 % of half a length on
    Ground(boat, ground(depth_m=depth, slope_percent=30, deepens_deg=180))
    assert boat.tick() == 0
    assert s.bottom_load > 0.0
    assert s.bottom[0, 4 if moment > 0 else 0] == pytest.approx(depth - 0.3 * bow, abs=0.1)
    assert s.qdot * moment > 0.0


@pytest.mark.core
def test_a_hull_in_a_current_is_rubbed_by_its_way_over_the_ground(boat: Boat) -> None:
    pushes = []
    for east in (0.0, 1.0):
        sinking(boat, 0.0, -0.1)
        boat.state.water_east = east
        assert boat.tick() == 0
        pushes.append(float(boat.state.vdot))
    assert pushes[1] < pushes[0] - 0.005  # the stream carries her east, the ground holds back


@pytest.mark.core
@pytest.mark.long
def test_mud_holds_a_boat_until_the_lift_breaks_it_out() -> None:
    risen = {}
    for breakout in (5.0, 100.0):  # [t]
        boat = make_boat()
        depth = sinking(boat, 0.1, 0.2, kind="mud", breakout_t=breakout)
        lies(boat, depth, 200.0)
        start = float(boat.state.z)
        assert put_out_of_trim(boat, -10_000.0, 0.0) == ""
        lies(boat, depth, 100.0)
        risen[breakout] = start - float(boat.state.z)
    assert risen[5.0] > 5.0
    assert 0.1 < risen[100.0] < 0.3


# The chart


VALUES = np.array([[30.0, 40.0], [10.0, 20.0]])  # southernmost row first


def on(grid: Grid, *, ends: bool = True) -> Bottom:
    """Return the ground of a grid of depths."""
    return Bottom(
        depth=grid,
        known=grid if ends else None,
        friction=0.4,
        breakout=0.0,
        kind="sand",
        grounding="free",
        bottoming=False,
    )


@pytest.mark.core
@pytest.mark.parametrize(
    ("north", "east", "depth", "slopes"),
    [
        (50.0, 50.0, 25.0, (-0.2, 0.1)),
        (0.0, 0.0, 30.0, (-0.2, 0.1)),
        (100.0, 100.0, 20.0, (-0.2, 0.1)),
        (-50.0, 50.0, 35.0, (0.0, 0.1)),  # beyond the edge: as there, and level across it
        (50.0, 250.0, 30.0, (-0.2, 0.0)),
    ],
)
def test_a_chart_is_bilinear_and_goes_on_as_at_its_edge(
    north: float, east: float, depth: float, slopes: tuple[float, float]
) -> None:

    boat = start_boat(1.0, 5.0)
    boat.state.x, boat.state.y = north, east
    sound(
        boat.records.vessel,
        chart_of(on(Grid(VALUES, 0.0, 0.0, (100.0, 100.0), degrees=False))),
        boat.records.state,
    )
    assert boat.state.bottom[0, 2] == pytest.approx(depth)
    assert tuple(boat.state.bottom[1:, 2]) == pytest.approx(slopes)


@pytest.mark.core
def test_no_depth_is_written_as_zero_which_would_be_no_ground() -> None:

    boat = start_boat(1.0, 5.0)
    flat = on(Grid(np.zeros((2, 2)), 0.0, 0.0, (1.0, 1.0), degrees=False), ends=False)
    chart = chart_of(flat)
    assert not chart[FIRST_SAMPLE:].any()
    sound(boat.records.vessel, chart, boat.records.state)
    assert (boat.state.bottom[0] != 0.0).all()


@pytest.mark.core
def test_ground_far_below_is_sounded_seldom_and_near_ground_at_each_tick(boat: Boat) -> None:
    changes = {}
    for depth in (100.0, 400.0 + DISTANT_GROUND_M):
        boat.start(5.0 * KNOT, 60.0, 0.0)
        Ground(boat, ground(depth_m=depth, slope_percent=1, deepens_deg=0))
        seen = []
        for _ in range(4 * (SELDOM_MASK + 1)):
            assert boat.tick() == 0
            seen.append(float(boat.state.bottom[0, 2]))
        changes[depth] = len(set(seen))
    assert list(changes.values()) == [4 * (SELDOM_MASK + 1), 4]


@pytest.mark.core
def test_a_chart_is_sounded_alike_by_the_tick_and_by_itself() -> None:
    boat = start_boat(5.0 * KNOT, 60.0, 0.3)
    part = Ground(boat, ground(depth_m=100, slope_percent=2, deepens_deg=40))
    assert boat.chart is not None
    assert boat.tick() == 0
    twin = start_boat(5.0 * KNOT, 60.0, 0.3)
    Ground(twin, part.bottom)
    sound(twin.records.vessel, boat.chart, twin.records.state)
    twin.sound_by(None)
    assert twin.tick() == 0
    assert twin.snapshot().tobytes() == boat.snapshot().tobytes()


def test_level_ground_is_written_once_and_costs_no_sounding() -> None:
    boat = start_boat(1.0)
    Ground(boat, ground(depth_m=200))
    assert boat.chart is None
    assert list(boat.state.bottom[0]) == [200.0] * 5
    Ground(boat, None)
    assert boat.records.scheme["friction"][0] == 0.0


# The echo sounder


def test_kinds_of_the_sounder_come_after_those_of_the_log() -> None:
    first = KINDS.index("log-stuck") + 1
    assert KINDS[first : first + 3] == ("sounder-noisy", "sounder-biased", "sounder-stuck")


def over(boat: Boat, depth: float) -> None:
    """Start a boat at 60 m over flat ground."""
    boat.start(5.0 * KNOT, 60.0, 0.0)
    Ground(boat, ground(depth_m=depth))


def test_the_sounder_reads_the_ground_less_the_boat_s_depth(boat: Boat) -> None:
    over(boat, 100.0)
    assert instrument_readings(boat).sounding == pytest.approx(40.0)
    assert isinstance(insert_casualty(boat, "sounder-biased", 1.0, 0.0), str)
    assert instrument_readings(boat).sounding == pytest.approx(50.0)
    assert isinstance(insert_casualty(boat, "sounder-stuck"), str)
    boat.state.z += 7.0
    assert instrument_readings(boat).sounding == pytest.approx(50.0)
    clear_casualty(boat, "all")
    boat.tick()
    assert instrument_readings(boat).sounding == pytest.approx(33.0, abs=0.1)


@pytest.mark.parametrize("depth", [None, 60.0 + SOUNDER_RANGE + 1.0])
def test_no_echo_comes_from_beyond_the_range_nor_without_ground(depth: float | None) -> None:
    boat = start_boat(5.0 * KNOT)
    if depth is None:
        assert isinstance(insert_casualty(boat, "sounder-noisy"), Refused)
    else:
        Ground(boat, ground(depth_m=depth))
        assert isinstance(insert_casualty(boat, "sounder-noisy"), str)
    assert instrument_readings(boat).sounding == 0.0


def test_the_sounder_s_noise_is_its_own(boat: Boat) -> None:
    over(boat, 100.0)
    for name in ("sounder-noisy", "log-noisy", "depth-gauge-noisy"):
        assert isinstance(insert_casualty(boat, name), str)
    off = []
    for _ in range(200):
        boat.tick()
        shown, s = instrument_readings(boat), boat.state
        off.append((shown.sounding - (100.0 - s.z), shown.depth - s.z, shown.speed - s.u))
    noise = np.array(off)
    assert noise[:, 0].std() == pytest.approx(3.0, rel=0.2)
    assert np.abs(np.corrcoef(noise.T)[0, 1:]).max() < 0.25
