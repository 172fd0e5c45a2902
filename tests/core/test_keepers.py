"""Speed, blow, waves, trim and hovering: what the keepers promise, in seas and out of them.

Figures are those of docs/autopilot.md with room for another seed.
"""

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import calls_of, make_boat
from helpers.orders import answer_of, obey_all
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.boat.pilot import PilotMonitor
from trainer.config.boat.vessel import parse_vessel
from trainer.config.world.sea import parse_sea
from trainer.core.autopilot.ascent import ASCENT_AFLOAT, ASCENT_RISING, NO_ASCENT
from trainer.core.autopilot.sections import low_pass, notch, pass_section
from trainer.core.sea.forces import suction
from trainer.units import KNOT

pytestmark = [pytest.mark.core, pytest.mark.long]

DEGREE = math.radians(1.0)


def start(
    knots: float,
    depth: float,
    state: int = 0,
    origin: float = 0.0,
    seed: int = 1,
    generator: str = "cosines",
) -> Boat:
    """Return BB2 started on autopilot, course north, in a sea from ahead or so."""
    boat = make_boat("bb2", "modified", "lagged", "adams2", 0.5)
    text = f"[sea]\nsea_state = {state}\ndirection_deg = {origin}\n"
    text += f'generator = "{generator}"\n'
    boat.sea = parse_sea(text + 'suction = "on"\n', Path("this.toml"))
    boat.start(knots * KNOT, depth, 0.0, seed)
    return boat


def sail(boat: Boat, seconds: float, *names: str) -> NDArray[np.float64]:
    """Return the named numbers after each tick, a row for each."""
    rows = np.empty((round(seconds / boat.method.step), len(names)))
    for row in rows:
        assert boat.tick() == 0
        row[:] = boat.numbers(names)
    return rows


def said(boat: Boat, seconds: float) -> list[str]:
    """Return what is called out in so many seconds."""
    return [call.text for call in calls_of(boat, PilotMonitor.over(boat), seconds)]


# --- speed


@pytest.mark.parametrize("origin", [0.0, 90.0, 180.0])
@pytest.mark.parametrize(("knots", "state"), [(4.0, 4), (5.0, 5), (8.0, 6), (10.0, 6)])
def test_the_mean_speed_is_the_ordered_one_in_any_sea(
    knots: float, state: int, origin: float
) -> None:
    means = []
    for seed in (7, 8, 9):
        boat = start(knots, 20.0, state, origin, seed=seed)
        sail(boat, 1200.0, "u")
        means.append(sail(boat, 1200.0, "u").mean() / KNOT)

    assert np.mean(means) == pytest.approx(knots, abs=0.1)


@pytest.mark.parametrize(("before", "after", "settled"), [(5, 10, 260.0), (10, 5, 430.0)])
def test_a_step_of_speed_settles_without_overshoot(
    before: float, after: float, settled: float
) -> None:
    boat = start(before, 100.0)
    boat.state.ordered_speed = after * KNOT
    speeds = sail(boat, 1800.0, "u")[:, 0] / KNOT
    off = np.nonzero(np.abs(speeds - after) > 0.1)[0][-1] * boat.method.step

    assert off < settled
    assert min(before, after) - 0.05 < speeds.min() < speeds.max() < max(before, after) + 0.05


def test_an_order_that_the_engine_cannot_reach_is_called_out_once() -> None:
    boat = start(5.0, 100.0)
    boat.vessel.u_c_ahead = 6.0 * KNOT
    boat.state.ordered_speed = 8.0 * KNOT

    news = [text for text in said(boat, 600.0) if "ordered speed" in text]

    assert len(news) == 1
    assert "the ordered speed is not reached" in news[0]


def test_a_boat_afloat_in_a_sea_is_never_driven_astern_for_its_speed() -> None:
    boat = start(4.0, 30.0, 6, 180.0)
    boat.state.blow[:3] = 2.0
    sail(boat, 120.0, "z")
    boat.state.blow[:] = 0.0
    rows = sail(boat, 1200.0, "command_u_c", "z")

    assert rows[-1, 1] < 8.0
    assert rows[:, 0].min() >= 0.0


def casualty(boat: Boat, text: str) -> None:
    """Let something break or mend at once."""
    answer = answer_of(boat, text)
    assert "no " not in answer, answer


def wrapped(away: NDArray[np.float64], watched: str) -> NDArray[np.float64]:
    """Return how far off, angles [deg] the short way."""
    return np.remainder(away + 180.0, 360.0) - 180.0 if watched == "psi" else away


@pytest.mark.parametrize(
    ("broken", "watched", "scale", "least", "most"),
    [
        ("propulsion-lost 1", "u", KNOT, 1.0, 0.3),
        ("rudder-hard-over 0.1", "psi", DEGREE, 20.0, 3.0),
        ("stern-hard-over -0.2", "z", 1.0, 2.0, 4.0),
        ("bow-hard-over 0.5", "z", 1.0, 0.0, 4.0),
    ],
)
def test_a_keeper_held_at_its_end_for_ten_minutes_lets_go(
    broken: str, watched: str, scale: float, least: float, most: float
) -> None:
    boat = start(8.0, 100.0)
    goal = float(boat.state[watched])
    casualty(boat, f"casualty {broken}")
    away = wrapped((sail(boat, 600.0, watched)[-1, 0] - goal) / scale, watched)
    casualty(boat, f"clear {broken.split(maxsplit=1)[0]}")
    obey_all(boat, "course 000")
    back = wrapped((sail(boat, 1800.0, watched)[:, 0] - goal) / scale, watched)

    assert abs(away) >= least
    assert np.abs(back[-600:]).max() < 0.1 * max(most, 1.0), "it has come back"
    assert (-math.copysign(1.0, away) * back).max() < most, "and not beyond"


# --- emergency blow


@pytest.mark.parametrize(
    ("knots", "depth", "up"),
    [(10.0, 200.0, 110.0), (15.0, 200.0, 100.0), (5.0, 200.0, 115.0), (10.0, 60.0, 45.0)],
)
def test_an_emergency_blow_brings_the_boat_up_with_a_bubble(
    knots: float, depth: float, up: float
) -> None:
    boat = start(knots, depth)
    obey_all(boat, "emergency blow")
    rows = sail(boat, 240.0, "z", "theta", "ascent", "blow_aft")

    assert np.nonzero(rows[:, 0] < 6.0)[0][0] * boat.method.step < up
    assert rows[:, 1].min() / DEGREE > -10.0
    assert 9.0 < rows[:, 1].max() / DEGREE < 17.0
    assert set(rows[:, 2]) == {ASCENT_RISING}
    assert rows[0, 3] == 0.0, "the after group waits for the bow to be up"
    assert rows[:, 3].max() == 2.0
    assert boat.state.ordered_depth == 0.0


def test_a_blow_broken_off_is_handed_back_without_a_jump() -> None:
    boat = start(10.0, 100.0)
    obey_all(boat, "emergency blow")
    sail(boat, 8.0, "z")
    obey_all(boat, "blow stop", "vent all open")
    ascent = sail(boat, 40.0, "ascent")[:, 0]
    obey_all(boat, "vent all shut")
    while boat.state.ascent == ASCENT_RISING and boat.time < 300.0:
        planes = boat.numbers(("command_s", "command_b"))
        assert boat.tick() == 0
    after = sail(boat, 300.0, "z", "command_s", "command_b")

    assert set(ascent) == {ASCENT_RISING}
    assert boat.time < 600.0
    assert np.abs(after[0, 1:] - planes).max() < DEGREE
    assert np.abs(after[:, 0] - boat.state.ordered_depth).max() < 2.0


def test_afloat_no_depth_is_kept_until_one_is_ordered() -> None:
    boat = start(10.0, 60.0)
    obey_all(boat, "emergency blow")
    news = said(boat, 150.0)
    obey_all(boat, "blow stop")
    news += said(boat, 300.0)
    resting = float(boat.state.z), float(boat.state.ascent)
    obey_all(boat, "dive", "depth 40")
    sail(boat, 900.0, "z")

    assert any("emergency ascent" in text for text in news)
    assert any("afloat" in text for text in news)
    assert resting[0] < 6.0
    assert resting[1] == ASCENT_AFLOAT
    assert boat.state.ascent == NO_ASCENT
    assert boat.state.z == pytest.approx(40.0, abs=1.0)


def test_main_ballast_blown_to_keep_depth_0_brings_the_boat_up_level() -> None:
    boat = start(5.0, 60.0)
    s = boat.state
    s.blow[:3] = 1.0  # as a panel or a program does, without an order
    before = sail(boat, 10.0, "ascent")[:, 0]
    s.ordered_depth = 0.0
    rising = sail(boat, 40.0, "ascent")[:, 0]
    obey_all(boat, "blow stop", "vent all open")
    while s.ascent == ASCENT_RISING and boat.time < 600.0:
        assert boat.tick() == 0
    kept = float(s.ordered_depth)
    after = sail(boat, 60.0, "ascent")[:, 0]

    assert set(before) == {NO_ASCENT}, "the planes keep another depth against a blow"
    assert set(rising) == {ASCENT_RISING}
    assert kept > 10.0
    assert set(after) == {NO_ASCENT}, "broken off deep, nothing begins again"
    assert s.ordered_depth == kept


def test_with_the_planes_in_hand_a_blow_is_the_crews() -> None:
    boat = start(10.0, 60.0)
    obey_all(boat, "planes manual", "emergency blow")
    rows = sail(boat, 20.0, "ascent", "blow_aft", "delta_s")

    assert set(rows[:, 0]) == {NO_ASCENT}
    assert set(rows[:, 1]) == {2.0}
    assert np.ptp(rows[:, 2]) < 1e-9


# --- waves


@pytest.mark.parametrize(("omega", "h"), [(0.7, 0.5), (0.45, 0.1), (0.9, 1.0)])
def test_a_notch_takes_out_its_frequency_and_passes_the_mean(omega: float, h: float) -> None:
    kept, mean = np.zeros(3), 3.0
    section = notch(omega, h, 0.1, 0.4)
    times = h * np.arange(4000)
    past = np.empty(4000)
    for i, t in enumerate(times):
        pass_section(section, mean + math.sin(omega * t), i == 0, 0, kept)
        past[i] = kept[2]
    rest = past[2000:] - past[2000:].mean()

    assert past[0] == pytest.approx(mean), "it begins as if that had stood for long"
    assert past[2000:].mean() == pytest.approx(mean, abs=0.01)
    assert math.sqrt(2.0) * rest.std() == pytest.approx(0.25, rel=0.02), "0.1 of 0.4"


def test_a_low_pass_halves_about_its_corner_and_begins_at_rest() -> None:
    kept = np.zeros(3)
    section = low_pass(0.15, 0.5, 0.8)
    past = np.empty(4000)
    for i in range(4000):
        pass_section(section, 2.0 + math.cos(0.15 * 0.5 * i), i == 0, 0, kept)
        past[i] = kept[2]

    assert past[0] == pytest.approx(3.0)
    assert math.sqrt(2.0) * past[2000:].std() == pytest.approx(1.0 / 1.6, rel=0.02)


@pytest.mark.parametrize(
    ("knots", "state", "origin", "rms", "planes"),
    [(4.0, 5, 0.0, 1.0, 14.0), (5.0, 5, 0.0, 0.6, 10.0), (8.0, 6, 180.0, 2.0, 16.0)],
)
def test_depth_is_kept_in_waves_and_the_planes_leave_them_alone(
    knots: float, state: int, origin: float, rms: float, planes: float
) -> None:
    boat = start(knots, 17.5, state, origin, seed=3)
    sail(boat, 600.0, "z")
    rows = sail(boat, 3000.0, "z", "theta", "command_s", "command_b", "wave_share")

    assert np.sqrt(((rows[:, 0] - 17.5) ** 2).mean()) < rms
    assert rows[:, 3].std() / DEGREE < planes
    assert abs(rows[:, 1].mean()) < 0.6 * DEGREE
    assert rows[:, 4].min() == 1.0


@pytest.mark.parametrize(("state", "most"), [(5, 0.7), (6, 1.9)])
def test_depth_is_kept_at_5_knots_in_a_sea_of_the_filter(state: int, most: float) -> None:
    for seed in (11, 12, 13):
        boat = start(5.0, 17.5, state, seed=seed, generator="filter")
        sail(boat, 600.0, "z")
        depths = sail(boat, 3000.0, "z")[:, 0]

        assert np.sqrt(((depths - 17.5) ** 2).mean()) < most


@pytest.mark.parametrize(("knots", "state", "origin"), [(5.0, 5, 180.0), (8.0, 6, 0.0)])
def test_the_time_between_waves_is_counted(knots: float, state: int, origin: float) -> None:
    counted = []
    for seed in (3, 4, 5):
        boat = start(knots, 17.5, state, origin, seed=seed)
        counted.append(2.0 * math.pi / sail(boat, 1800.0, "wave_period")[600:, 0].mean())
    peak = float(boat.state.sea_omega)
    met = peak + peak * peak / 9.81 * knots * KNOT * math.cos(math.radians(origin))

    assert np.mean(counted) == pytest.approx(met, rel=0.1)


def test_in_a_calm_and_in_small_waves_the_law_stays_as_it_is() -> None:
    assert sail(start(5.0, 18.0), 120.0, "wave_share", "wave_count").max() == 0.0
    assert sail(start(5.0, 60.0, 3), 400.0, "wave_share").max() == 0.0


# --- trim


@pytest.mark.parametrize("knots", [4.0, 5.0, 6.0, 8.0, 12.0])
def test_automatic_trim_takes_pitch_and_planes_to_nothing(knots: float) -> None:
    boat = start(knots, 18.0)
    water = float(boat.state.water.sum())
    rows = sail(boat, 3600.0, "z", "theta", "delta_s", "delta_b")
    s = boat.state

    assert np.abs(rows[:, 0] - 18.0).max() < 0.8
    assert abs(rows[-1, 1]) < 0.1 * DEGREE
    assert np.abs(rows[-1, 2:]).max() < DEGREE
    assert s.water_taken == pytest.approx(float(s.water.sum()) - water, abs=1e-6)


def test_trim_by_hand_moves_no_water_and_pitch_stays_steady() -> None:
    boat = start(5.0, 18.0)
    assert answer_of(boat, "trim manual") == "trim by hand"
    water = boat.state.water.copy()
    pitch = sail(boat, 3600.0, "theta")[:, 0]

    assert (boat.state.water == water).all()
    assert abs(pitch[-1] - pitch[1200]) < 0.05 * DEGREE


def test_a_pump_that_the_crew_uses_is_not_taken_from_it() -> None:
    boat = start(5.0, 18.0)
    sail(boat, 120.0, "z")
    assert boat.state.trim_flood != 0.0
    obey_all(boat, "pump auxiliary 5")
    before = float(boat.state.water_auxiliary)
    sail(boat, 10.0, "z")

    pumped = before - float(boat.state.water_auxiliary)
    assert pumped == pytest.approx(5000.0 + float(boat.state.move_auxiliary), abs=1e-6)


def test_automatic_trim_does_not_outdo_a_failed_pump() -> None:
    boat = start(5.0, 18.0)
    boat.state.pump_fault[:] = 1.0
    water = boat.state.water.copy()
    sail(boat, 600.0, "z")

    assert (boat.state.water == water).all()


# --- astern


def test_a_boat_handed_over_in_a_hard_turn_is_stopped_and_comes_back() -> None:
    boat = start(10.0, 60.0)
    obey_all(boat, "rudder left 15")
    sail(boat, 30.0)
    begun = boat.state.psi

    obey_all(boat, "rudder auto")
    heading = sail(boat, 300.0, "psi")[:, 0]

    assert begun < -30.0 * DEGREE
    assert heading.min() > begun - 20.0 * DEGREE
    assert heading[-1] == pytest.approx(0.0, abs=DEGREE)


def test_a_boat_handed_over_in_a_steep_dive_is_pulled_up() -> None:
    boat = start(10.0, 60.0)
    obey_all(boat, "stern dive 20", "bow dive 20")
    sail(boat, 30.0)
    begun = boat.state.z

    obey_all(boat, "planes auto")
    depth = sail(boat, 400.0, "z")[:, 0]

    assert begun > 75.0
    assert depth.max() < begun + 40.0
    assert depth[-1] == pytest.approx(60.0, abs=1.0)


def test_going_astern_course_and_depth_are_kept_as_they_can_be() -> None:
    boat = start(10.0, 100.0)
    obey_all(boat, "turns -6")
    news = said(boat, 480.0)
    boat.state.psi += 3.0 * DEGREE
    rows = sail(boat, 300.0, "psi", "z", "u")

    assert rows[-1, 2] < -4.0 * KNOT
    assert abs(rows[-1, 0]) < DEGREE, "the rudder is put over the other way"
    assert np.abs(rows[:, 1] - 100.0).max() < 5.0
    assert len([text for text in news if "astern" in text]) == 1


@pytest.mark.parametrize("speed_kn", [-8.0, -4.0])
@pytest.mark.parametrize("given_s", [0.0, 300.0])
def test_going_astern_the_boat_turns_to_its_course_and_stays_there(
    speed_kn: float, given_s: float
) -> None:
    boat = start(8.0, 100.0)
    obey_all(boat, f"turns {speed_kn:g}")
    if given_s:
        sail(boat, given_s)
    obey_all(boat, "course 090")
    rows = sail(boat, 2400.0, "psi", "u")

    assert rows[-1, 1] < -2.0 * KNOT
    assert rows[:, 0].max() < 100.0 * DEGREE
    assert np.abs(rows[-400:, 0] - 90.0 * DEGREE).max() < DEGREE


def test_slow_astern_the_planes_lie_amidships() -> None:
    boat = start(4.0, 100.0)
    boat.state.u = -2.0 * KNOT
    rows = sail(boat, 10.0, "command_s", "command_b")

    assert np.abs(rows).max() == 0.0


# --- hovering


def at_rest(depth: float, state: int, seed: int) -> Boat:
    """Return a boat that lies stopped and balanced under waves, moving as they move it."""
    boat = start(4.0, depth, state, 0.0, seed)
    s = boat.state
    s.motion[:9] = s.rates[:] = s.surface[:] = 0.0
    s.u_c = s.command_u_c = s.telegraph_answer = s.telegraph_order = s.ordered_u_c = 0.0
    s.speed_by_hand = 1.0
    up = 0.0
    if state:
        up = suction(9.81, s.sea_omega, s.sea_height, depth)[0]
    mass = boat.vessel.buoyancy / 9.81 - boat.vessel.Z_wdot
    # one that gives way to the waves is drawn up half as much as one held still
    s.water_auxiliary += 0.5 * up * mass / 9.81 + (boat.vessel.buoyancy - s.weight) / 9.81
    s.held_depth = 1.0
    drift = np.empty(400)
    for i in range(400):
        assert boat.tick() == 0
        s.u = s.theta = s.q = 0.0
        drift[i] = s.w
    s.w -= np.polyval(np.polyfit(np.arange(400), drift, 1), 399)
    s.held_depth, s.z, s.history = 0.0, depth, 0.0
    return boat


@pytest.mark.parametrize(("depth", "state", "within"), [(18.0, 4, 5.0), (30.0, 5, 5.0)])
@pytest.mark.parametrize("seed", [202, 203, 204])
def test_hovering_holds_its_depth_under_waves(
    depth: float, state: int, within: float, seed: int
) -> None:
    boat = at_rest(depth, state, seed)
    assert "hovering" in answer_of(boat, "hover on")
    rows = sail(boat, 3600.0, "z", "hover", "command_s", "command_b")

    assert rows[:, 1].min() == 1.0
    assert np.abs(rows[:, 0] - depth).max() < within
    assert np.abs(rows[:, 2:]).max() == 0.0, "the planes have no part in it"


def test_hovering_is_refused_where_the_pump_cannot_hold() -> None:
    boat = start(4.0, 18.0, 5)

    answer = answer_of(boat, "hover on")

    assert answer.startswith("the pump cannot hold 18 m here")
    assert answer.endswith(", or make 3 knots")
    assert boat.state.hover == 0.0
    depth = float(answer.rpartition("go to ")[2].split()[0])
    boat.state.z = depth
    assert "until then the planes keep the depth" in answer_of(boat, "hover on"), "at 4 knots"
    assert "cannot hold 18 m" in answer_of(boat, "depth 18"), "nor is the boat sent there hovering"


def test_hovering_that_is_lost_is_given_up_and_told() -> None:
    boat = at_rest(30.0, 5, 201)
    obey_all(boat, "hover on")
    boat.state.speed_by_hand = 0.0
    boat.state.ordered_speed = 0.0
    boat.state.water_auxiliary -= 6000.0
    news = said(boat, 600.0)

    assert any("hovering is given up" in text for text in news)
    assert boat.state.hover == 0.0
    assert boat.state.ordered_speed == pytest.approx(4.0 * KNOT)


def test_a_sea_without_suction_is_told_where_one_hovers() -> None:
    boat = start(4.0, 30.0, 4)
    boat.state.u, boat.state.sea_suction = 0.5, 0.0

    assert "no suction" in answer_of(boat, "hover on")


# --- tanks too small for automatic trim


def test_a_trim_tank_too_small_is_named_in_its_file() -> None:
    text = make_boat("bb2").file.text
    start = text.index('name = "trim_forward"')
    key = text.index("capacity_m3", start)
    end = text.index("\n", key)
    file = parse_vessel(text[:key] + "capacity_m3 = 0.2" + text[end:], Path("boat.toml"))

    [remark] = file.remarks
    assert remark.startswith("boat.toml: [ballast] pumped: trim_forward: capacity_m3 = 0.2: ")
    assert "automatic trim wants 0.43 m3 or more" in remark


def test_automatic_trim_tells_when_a_tank_has_no_more_to_give() -> None:
    boat = start(6.0, 18.0)
    boat.vessel.capacity[6] = boat.state.water_auxiliary  # full, and more is wanted
    news = said(boat, 300.0)

    assert len([text for text in news if "no more water or room" in text]) == 1
