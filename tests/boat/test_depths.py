"""Test depth and collapse: the depth that counts, and what is called out on the way down."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.boats import make_boat

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthGuard, DepthMonitor, collapse_of, hull_depth, lowest_depth
from trainer.units import KNOT


def boat_with(test_depth: float | None, collapse_depth: float | None = None) -> Boat:
    """Return BB2 at 60 m and 10 knots, her test and collapse depth [m] as given."""
    boat = make_boat("bb2", "modified")
    hull = replace(boat.file.hull, test_depth_m=test_depth, collapse_depth_m=collapse_depth)
    boat.file = replace(boat.file, hull=hull)
    boat.start(10.0 * KNOT, 60.0, 0.0)
    boat.state.theta = 0.0
    return boat


def called(boat: Boat, monitor: DepthMonitor, *depths: float) -> list[str]:
    """Return what is called out, or "", at these depths [m] one after the other."""
    words = []
    for depth in depths:
        boat.state.z = depth
        passed = monitor.look(boat)
        words.append(passed.call.text if passed else "")
    return words


def test_the_depth_that_counts_is_that_of_the_lower_end_of_the_hull() -> None:
    boat = boat_with(250.0)
    # 0.4 of 70.2 m by the sine of 30 degrees is 14.04 m, whichever end is down
    for pitch in (-30.0, 30.0):
        boat.state.theta = math.radians(pitch)
        assert hull_depth(boat) == pytest.approx(60.0 + 14.04)
    boat.state.theta, boat.state.phi = 0.0, 1.0
    assert hull_depth(boat) == 60.0
    depths = lowest_depth(np.array([60.0, 80.0]), np.radians([30.0, 0.0]), 70.2)
    assert depths == pytest.approx([74.04, 80.0])


def test_the_depth_called_is_that_of_the_lower_end_of_the_hull() -> None:
    boat = boat_with(250.0)
    monitor = DepthMonitor.over(boat)
    boat.state.theta = math.radians(-30.0)
    assert called(boat, monitor, 205.0, 206.0) == ["", "Passing 220 m, 30 m above test depth"]


def test_test_depth_is_called_30_m_before_it_at_it_and_every_25_m_beyond() -> None:
    boat = boat_with(250.0)
    monitor = DepthMonitor.over(boat)
    said = called(boat, monitor, *np.arange(60.0, 331.0, 1.0))
    assert [(60 + i, words) for i, words in enumerate(said) if words] == [
        (220, "Passing 220 m, 30 m above test depth"),
        (250, "Passing test depth, 250 m"),
        (275, "Passing 275 m, 25 m beyond test depth"),
        (300, "Passing 300 m, 50 m beyond test depth"),
        (325, "Passing 325 m, 75 m beyond test depth"),
    ]


def test_a_depth_is_called_again_only_after_she_has_come_up_from_it_by_5_m() -> None:
    boat = boat_with(250.0)
    monitor = DepthMonitor.over(boat)
    told = "Passing test depth, 250 m"
    assert called(boat, monitor, 249.0, 250.0, 249.0, 251.0)[1:] == [told, "", ""]
    assert called(boat, monitor, 245.1, 251.0) == ["", ""]
    assert called(boat, monitor, 245.0, 249.0, 250.0) == ["", "", told]
    assert called(boat, monitor, 215.0, 221.0)[1].startswith("Passing 220 m")
    assert called(boat, monitor, 251.0) == [told]
    assert monitor.times == {"test depth passed": [0.0, 0.0, 0.0]}


def test_what_she_has_passed_before_a_jump_in_time_is_no_news() -> None:
    boat = boat_with(250.0)
    monitor = DepthMonitor.over(boat)
    boat.state.z = 260.0
    monitor.reset_to(boat)
    assert called(boat, monitor, 261.0, 274.0, 276.0)[:2] == ["", ""]
    boat.state.z = 240.0
    monitor.reset_to(boat)
    assert called(boat, monitor, 251.0) == ["Passing test depth, 250 m"]


def test_a_test_depth_of_less_than_30_m_is_called_at_it_and_beyond() -> None:
    boat = boat_with(20.0)
    boat.state.z = 0.0
    monitor = DepthMonitor.over(boat)
    assert called(boat, monitor, -1.0, 19.0, 20.0) == ["", "", "Passing test depth, 20 m"]


def test_the_hull_collapses_at_its_depth_and_not_before() -> None:
    boat = boat_with(None, 450.0)
    boat.state.z = 449.9
    assert collapse_of(boat) == ""
    boat.state.z = 451.2
    assert collapse_of(boat) == "collapse at 451 m"
    boat.state.z, boat.state.theta = 440.0, math.radians(-30.0)
    assert collapse_of(boat) == "collapse at 454 m"


def test_while_the_depth_is_frozen_nothing_is_called_and_nothing_collapses() -> None:
    boat = boat_with(250.0, 450.0)
    monitor = DepthMonitor.over(boat)
    boat.state.held_depth = 1.0
    assert called(boat, monitor, 260.0, 500.0) == ["", ""]
    assert collapse_of(boat) == ""
    boat.state.held_depth = 0.0
    assert called(boat, monitor, 260.0) == ["Passing test depth, 250 m"]


def test_of_a_boat_without_test_and_collapse_depth_nothing_is_told() -> None:
    boat = boat_with(None)
    monitor = DepthMonitor.over(boat)
    assert called(boat, monitor, 100.0, 1000.0, 11000.0) == ["", "", ""]
    assert (collapse_of(boat), monitor.times, monitor.passed) == ("", {}, 0)


def test_a_guard_takes_the_planes_before_its_depth_and_gives_them_back_when_level() -> None:
    boat, guard = boat_with(None), DepthGuard(90.0)
    seen = []
    for by_hand, depth, sinking, pitch in (
        (1.0, 80.0, 0.0, 0.2),  # by hand, and 90 m are not near
        (1.0, 80.0, 0.4, 0.0),  # in 30 s it would be at 92 m
        (0.0, 89.0, 0.0, 0.0),  # not high enough to give them back
        (0.0, 80.0, 0.0, 0.2),  # not level enough
        (0.0, 80.0, 0.0, 0.0),
    ):
        state = boat.state
        state.stern_by_hand, state.z, state.zdot, state.theta = by_hand, depth, sinking, pitch
        order = guard.order(boat)
        seen.append(order.text if order else "")

    assert seen == ["", "depth 70 m", "", "", "lever zero"]


def test_a_guard_of_no_depth_never_has_the_planes() -> None:
    boat, guard = boat_with(None), DepthGuard()
    boat.state.theta = 0.2

    assert not guard.holds(boat)
    assert guard.order(boat) is None
