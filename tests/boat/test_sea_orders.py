"""Orders about the sea, what the sea then does to the boat, and what is called out about it."""

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import calls_of, start_boat
from helpers.orders import obey_all, read_order

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.limits import LimitMonitor
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.files import ConfigError
from trainer.config.world.sea import SeaFile, load_sea, parse_sea
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

DEGREE = math.pi / 180.0
# Significant height [m] and peak period [s] of degree 5: Hs = 0.2092 U^2/g, peak at 0.877 g/U.
STATE_5 = (3.25, 2.0 * math.pi / (0.877 * math.sqrt(9.81 * 0.2092 / 3.25)))


def boat_at(
    depth: float, speed_kn: float = 5.0, course: float = 0.0, equations: str = "modified"
) -> Boat:
    """Return BB2 under way in trim, everything automatic, in a calm."""
    return start_boat(speed_kn * KNOT, depth, course * DEGREE, seed=3, equations=equations)


@pytest.fixture
def boat() -> Boat:
    return boat_at(60.0)


def sea_of(text: str) -> SeaFile:
    return parse_sea(f"[sea]\n{text}\n", Path("my-sea.toml"))


def flown(boat: Boat, seconds: float, *names: str) -> np.ndarray:
    """Return the named places of the state after each tick of a flight, one row a tick."""
    found = []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        found.append(boat.numbers(names))
    return np.array(found)


# What an order changes


@pytest.mark.parametrize(
    ("line", "height", "period"),
    [
        ("sea state 5", *STATE_5),
        ("sea wind 30", 0.2092 * (30 * KNOT) ** 2 / 9.81, 2 * math.pi * 30 * KNOT / (0.877 * 9.81)),
        ("sea height 3.25 m", *STATE_5),
        ("sea height 10 ft", 3.048, STATE_5[1] * math.sqrt(3.048 / 3.25)),
    ],
)
def test_a_sea_is_ordered_by_state_wind_or_height(
    boat: Boat, line: str, height: float, period: float
) -> None:
    obey_all(boat, line)
    flown(boat, 60.0)
    assert boat.state.sea_height == pytest.approx(height, rel=1e-3)
    assert 2.0 * math.pi / boat.state.sea_omega == pytest.approx(period, rel=1e-3)


def test_a_sea_comes_about_in_the_time_of_its_ramp_and_not_at_once(boat: Boat) -> None:
    answer = obey_all(boat, "sea state 5")
    assert answer == ["sea state 5: 3.25 m, peak at 9.0 s, from 000, within 60 s"]
    heights = flown(boat, 70.0, "sea_height")[:, 0]
    assert heights[59] == pytest.approx(1.625, rel=0.05)
    assert heights[118] < heights[119] == 3.25
    assert heights[-1] == 3.25


def test_a_sea_of_the_users_own_ramp_takes_that_time(boat: Boat) -> None:
    boat.put_to_sea(sea_of("height_m = 1\nramp_s = 10"))
    obey_all(boat, "sea height 2")
    assert flown(boat, 10.0, "sea_height")[-1] == [2.0]


def test_an_order_keeps_direction_and_generator(boat: Boat) -> None:
    boat.put_to_sea(
        sea_of('sea_state = 3\ndirection_deg = 45\ngenerator = "cosines"\nsuction="on"')
    )
    obey_all(boat, "sea state 5")
    flown(boat, 61.0)
    s = boat.state
    assert (s.sea_cosines, s.sea_suction) == (1.0, 1.0)
    assert s.sea_direction == pytest.approx(225.0 * DEGREE)

    obey_all(boat, "sea from 090")
    flown(boat, 61.0)
    assert s.sea_height == 3.25
    assert s.sea_direction == pytest.approx(270.0 * DEGREE)


def test_a_direction_ordered_in_a_calm_is_that_of_the_next_sea(boat: Boat) -> None:
    obey_all(boat, "sea from 045", "sea state 3")
    flown(boat, 1.0)
    assert boat.state.sea_direction == pytest.approx(225.0 * DEGREE)


def test_a_calm_lets_the_sea_die_and_the_surface_is_flat(boat: Boat) -> None:
    boat.put_to_sea(load_sea("sea-state-4"))
    obey_all(boat, "sea calm")
    waves = flown(boat, 61.0, "eta_wave")[:, 0]
    assert waves[:60].std() > 0.1
    assert waves[-1] == 0.0


def test_a_boat_put_to_sea_again_meets_the_same_waves() -> None:
    waves = []
    for _ in range(2):
        boat = boat_at(60.0)
        boat.put_to_sea(load_sea("sea-state-5"))
        waves.append(flown(boat, 30.0, "eta_wave"))
    assert np.array_equal(waves[0], waves[1])
    boat.start(5.0 * KNOT, 60.0, 0.0, 4)
    assert not np.array_equal(waves[0], flown(boat, 30.0, "eta_wave"))


def test_a_boat_put_from_one_sea_into_another_forgets_the_first() -> None:
    moved, fresh = boat_at(60.0), boat_at(60.0)
    moved.put_to_sea(load_sea("sea-state-3"))
    for boat in (moved, fresh):
        boat.put_to_sea(load_sea("sea-state-5"))
    assert np.array_equal(flown(moved, 30.0, "eta_wave"), flown(fresh, 30.0, "eta_wave"))


# What the sea does


@pytest.mark.parametrize("equations", ["modified", "full"])
@pytest.mark.parametrize("course", [0.0, 90.0, 180.0])
def test_at_100_m_in_sea_state_5_the_boat_holds_depth_within_30_cm(
    equations: str, course: float
) -> None:
    boat = boat_at(100.0, 10.0, course, equations)
    boat.put_to_sea(load_sea("sea-state-5"))
    depth = flown(boat, 1200.0, "z")[:, 0]
    assert np.abs(depth - 100.0).max() < 0.3
    assert depth.std() > 1e-3  # but the swell is felt


@pytest.mark.parametrize("equations", ["modified", "full"])
def test_at_periscope_depth_the_same_sea_moves_the_boat_visibly(equations: str) -> None:
    boat = boat_at(17.5, 10.0, 180.0, equations)
    boat.put_to_sea(load_sea("sea-state-5"))
    seen = flown(boat, 1200.0, "z", "theta")[240:]
    assert seen[:, 0].std() > 0.4
    assert seen[:, 1].std() > 1.0 * DEGREE


@pytest.mark.parametrize(
    ("generator", "excess"),
    [("filter-1969", 1.0), ("filter", 1.45)],
)
def test_motion_falls_with_depth_as_the_waves_do(generator: str, excess: float) -> None:
    # Planes by hand, below the tables of the calm surface: the boat is the same at each depth.
    # That of 1969 has one wave number, omega^2/g; of the other the longer waves are left.
    swings = []
    for depth in (60.0, 80.0, 100.0):
        boat = boat_at(depth, 8.0)
        obey_all(boat, "planes manual")
        boat.put_to_sea(sea_of(f'sea_state = 5\ngenerator = "{generator}"\nsuction = "off"'))
        swings.append(flown(boat, 600.0, "zdot")[:, 0].std())
        number = float(boat.state.sea_omega) ** 2 / 9.81
    expected = excess * math.exp(-number * 20.0)
    slack = 0.02 if excess == 1.0 else 0.1
    assert swings[1] / swings[0] == pytest.approx(expected, rel=slack)
    assert swings[2] / swings[1] == pytest.approx(expected, rel=slack)


# What is called out


def watched(boat: Boat, monitor: LimitMonitor, seconds: float) -> list[str]:
    return [call.text for call in calls_of(boat, monitor, seconds)]


def shown(said: list[str]) -> list[str]:
    """Return what was said of sail and deck, without the ticks."""
    words = [line.partition(": ")[2] for line in said]
    return [text for text in words if "above the sea" in text]


def test_a_boat_thrown_up_by_the_sea_is_called_out_as_broached() -> None:
    boat = boat_at(17.5, 3.0)
    boat.put_to_sea(sea_of("sea_state = 6"))
    monitor = LimitMonitor.over(boat, ExerciseLimits())
    said = watched(boat, monitor, 900.0)
    assert any("BROACHED: the boat shows 0." in line for line in said)
    assert said[0].startswith("tick ")
    assert "broached " in monitor.account()


def test_a_boat_that_is_blown_up_has_surfaced_and_not_broached_and_is_called_out_once() -> None:
    boat = boat_at(60.0, 10.0)
    monitor = LimitMonitor.over(boat, ExerciseLimits())
    obey_all(boat, "surface")
    said = watched(boat, monitor, 300.0)
    assert shown(said) == ["surfaced: the boat shows above the sea"]
    obey_all(boat, "dive", "depth 40")
    assert shown(watched(boat, monitor, 300.0)) == []
    obey_all(boat, "surface")
    assert len(shown(watched(boat, monitor, 300.0))) == 1


def follow_told(said: list[str]) -> list[str]:
    """Return what was said of a sea that follows, without the ticks."""
    return [text for line in said if (text := line.partition(": ")[2]).startswith("FOLLOWING")]


def test_a_sea_that_follows_too_fast_for_the_filter_is_called_out_once() -> None:
    boat = boat_at(25.0, 6.0)  # nu = 0.697 rad/s x 3.1 m/s / 9.81 = 0.22
    monitor = LimitMonitor.over(boat, ExerciseLimits())
    boat.put_to_sea(sea_of("sea_state = 5\ndirection_deg = 180"))

    said = (
        "FOLLOWING SEA: at 0.22 of the waves' speed the filter puts energy into wrong bands; "
        'a sea with generator = "cosines" does not'
    )
    assert follow_told(watched(boat, monitor, 120.0)) == [said]


@pytest.mark.parametrize(
    ("speed", "depth", "sea"),
    [
        (6.0, 25.0, "direction_deg = 0"),
        (3.0, 25.0, "direction_deg = 180"),
        (6.0, 80.0, "direction_deg = 180"),
        (6.0, 25.0, 'direction_deg = 180\ngenerator = "cosines"'),
    ],
)
def test_a_sea_that_the_filter_can_follow_or_that_is_not_felt_is_not_called_out(
    speed: float, depth: float, sea: str
) -> None:
    boat = boat_at(depth, speed)
    monitor = LimitMonitor.over(boat, ExerciseLimits())
    boat.put_to_sea(sea_of(f"sea_state = 5\n{sea}"))

    assert follow_told(watched(boat, monitor, 60.0)) == []


# A step that is too long for a sea


def test_a_sea_above_nyquist_for_the_step_is_refused_by_order_and_by_file(boat: Boat) -> None:
    order = read_order("sea state 1")

    answer = obey_order(boat, order)

    assert isinstance(answer, Refused)
    assert answer.reason.startswith("a sea above Nyquist for the step: its peak of 5.6")
    assert boat.state.sea_target[0] == 0.0
    with pytest.raises(ConfigError, match=r"my-sea\.toml: a sea above Nyquist for the step"):
        boat.put_to_sea(sea_of("sea_state = 1"))
    boat.put_to_sea(load_sea("sea-state-1"))  # a sum of cosines
    assert flown(boat, 60.0, "eta_wave").std() > 0.005


def test_a_limit_is_called_out_at_each_crossing_and_only_then() -> None:
    boat = boat_at(60.0, 10.0)
    monitor = LimitMonitor.over(
        boat, ExerciseLimits(depth_m_max=70.0, depth_m_min=65.0, speed_kn_max=10.0)
    )  # she starts above 65 m: no news
    assert monitor.account() == ""
    obey_all(boat, "depth 80")
    down = watched(boat, monitor, 240.0)
    obey_all(boat, "depth 60")
    up = watched(boat, monitor, 240.0)
    assert [line.partition(": ")[2] for line in down if "deeper" in line] == [
        "LIMIT: deeper than 70 m"
    ]
    assert [line.partition(": ")[2] for line in up if "shallower" in line] == [
        "LIMIT: shallower than 65 m"
    ]
    assert "deeper than 70 m 1 time (first at " in monitor.account()


@pytest.mark.parametrize(
    ("limits", "place", "value"),
    [
        (ExerciseLimits(pitch_deg_max=10.0), "theta", -11.0 * DEGREE),
        (ExerciseLimits(heel_deg_max=10.0), "phi", -11.0 * DEGREE),
        (ExerciseLimits(speed_kn_min=4.0), "u", 3.0 * KNOT),
        (ExerciseLimits(speed_kn_max=6.0), "u", 7.0 * KNOT),
    ],
)
def test_each_limit_watches_its_own_quantity(
    boat: Boat, limits: ExerciseLimits, place: str, value: float
) -> None:
    monitor = LimitMonitor(limits)
    assert monitor.look(boat) == []
    boat.state[place] = value
    assert len(monitor.look(boat)) == 1
    assert monitor.look(boat) == []
