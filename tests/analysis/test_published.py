"""The BB2 submarine in the manoeuvres of its published trials, as the 2510 equations give them.

All figures are from the validation document of the vessel data, section 1: the steady turn of 1f,
and the columns "2510 model" of 1a (horizontal zig-zag), 1c (vertical zig-zag), 1d (roll decay).
"""

import csv
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from helpers.nursery import run_trainer
from helpers.places import environment
from numpy.typing import NDArray

from trainer.boat.boat import Boat

KNOT = 1852.0 / 3600.0
LENGTH = 70.2  # [m]
DEEP = 1000.0  # [m] room for a zig-zag of the planes
STEP = 0.02  # [s] of Runge-Kutta: published peaks move by 1 % between 0.1 s and this

History = dict[str, NDArray[np.float64]]
SEEN = ("u", "q", "r", "y", "z", "phi", "theta", "psi")


# The steady turn, from the CSV of a headless run


@pytest.fixture(scope="module")
def steady_turn(tmp_path_factory: pytest.TempPathFactory) -> dict[str, float]:
    """Return the last five minutes of a 15 degree turn at the revolutions of 10 kn."""
    folder = tmp_path_factory.mktemp("turn")
    (folder / "orders.txt").write_text("0 turns 10\n0 rudder right 15\n")
    options = "run --headless --equations full --duration 20m --speed max --step 0.5"
    files = ("--orders", "orders.txt", "--csv", "turn.csv")
    done = run_trainer(*options.split(), *files, cwd=folder, env=environment())
    assert done.returncode == 0, done.stderr
    with (folder / "turn.csv").open(newline="") as stream:
        rows = [{name: float(text) for name, text in row.items()} for row in csv.DictReader(stream)]
    late = [row for row in rows if row["t"] >= 900.0]
    speed = math.hypot(late[-1]["u"], late[-1]["v"])
    yaw_rate = (late[-1]["psi"] - late[0]["psi"]) / (late[-1]["t"] - late[0]["t"])
    return {
        "diameter [m]": 2.0 * speed / yaw_rate,
        "speed [kn]": speed / KNOT,
        "yaw rate [deg/s]": math.degrees(yaw_rate),
        "heel [deg]": math.degrees(late[-1]["phi"]),
        "depth lost [m]": abs(late[-1]["z"] - 60.0),
    }


@pytest.mark.process
@pytest.mark.parametrize(
    ("quantity", "published"),
    [
        ("diameter [m]", 255.0),
        ("speed [kn]", 6.18),
        ("yaw rate [deg/s]", 1.428),
        ("heel [deg]", 2.1),
    ],
)
def test_the_steady_turn_is_the_published_one(
    steady_turn: dict[str, float], quantity: str, published: float
) -> None:
    assert steady_turn["depth lost [m]"] < 0.5  # the published turn keeps its depth
    assert steady_turn[quantity] == pytest.approx(published, rel=0.02)


# Zig-zags: exact rates and Runge-Kutta, every surface in hand


class ZigZag(NamedTuple):
    """One zig-zag: which surface is thrown over when which angle reaches its mark."""

    surface: str  # the place of its order
    watched: str  # the place of the angle
    sense: float  # that a positive deflection turns the angle in
    deflection: float  # [deg]
    execute: float  # [deg]


HORIZONTAL = ZigZag("ordered_r", "psi", -1.0, 20.0, 20.0)
VERTICAL = ZigZag("ordered_s", "theta", -1.0, 10.0, 10.0)


def fly(boat: Boat, zigzag: ZigZag, first: float, seconds: float) -> History:
    """Return what a zig-zag looks like from its start; ``first`` is the way the angle goes first.

    Planes and angles count from trimmed flight, in which BB2's pitch is -0.6 degrees.
    """
    s = boat.state
    neutral, level = float(s[zigzag.surface]), float(s[zigzag.watched])
    deflection, execute = math.radians(zigzag.deflection), math.radians(zigzag.execute)
    way = first
    rows = []
    for _ in range(round(seconds / boat.method.step)):
        if way * (s[zigzag.watched] - level) >= execute:
            way = -way
        s[zigzag.surface] = neutral + way * zigzag.sense * deflection
        assert boat.tick() == 0
        rows.append([boat.time, *(float(s[name]) for name in SEEN)])
    seen = dict(zip(("t", *SEEN), np.array(rows).T, strict=True))
    seen[zigzag.watched] -= level
    return seen


def peaks(angle: NDArray[np.float64]) -> list[int]:
    """Return where the first three swings of an angle, to more than 5 degrees, are largest."""
    far = np.flatnonzero(np.abs(angle) > math.radians(5.0))
    swings = np.split(far, np.flatnonzero(np.diff(far) > 1) + 1)
    return [int(swing[np.argmax(np.abs(angle[swing]))]) for swing in swings[:3]]


@pytest.fixture(scope="module")
def horizontal(make_boat: Callable[..., Boat], by_hand: Callable[[Boat], None]) -> dict[str, float]:
    """Return the figures of the 20/20 zig-zag from 4.95 m/s, first to port, starboard positive."""
    boat = make_boat("bb2", "full", "exact", "rk4", STEP)
    boat.start(4.95, DEEP, 0.0)
    by_hand(boat)
    seen = fly(boat, HORIZONTAL, -1.0, 200.0)
    t, heading = seen["t"], -seen["psi"]  # the first swing positive, as published
    first, second, third = peaks(heading)
    at = {seconds: round(seconds / STEP) - 1 for seconds in (40.0, 110.0)}
    return {
        "first peak [rad]": heading[first],
        "first peak [s]": t[first],
        "second peak [rad]": heading[second],
        "second peak [s]": t[second],
        "third peak [rad]": heading[third],
        "third peak [s]": t[third],
        "first overshoot [deg]": math.degrees(heading[first]) - 20.0,
        "second overshoot [deg]": -math.degrees(heading[second]) - 20.0,
        "heading zero [s]": t[first + int(np.argmax(heading[first:] < 0.0))],
        "largest yaw rate [rad/s]": -seen["r"].min(),
        "smallest yaw rate [rad/s]": -seen["r"].max(),
        "u at 40 s [m/s]": seen["u"][at[40.0]],
        "u at 110 s [m/s]": seen["u"][at[110.0]],
        "lateral displacement [m]": -seen["y"].min(),
        "heel to port [rad]": -seen["phi"].min(),
        "heel to starboard [rad]": -seen["phi"].max(),
    }


@pytest.mark.core
@pytest.mark.long
@pytest.mark.parametrize(
    ("quantity", "published"),
    [
        ("first peak [rad]", 0.574),
        ("first peak [s]", 30.5),
        ("first overshoot [deg]", 13.0),
        ("second overshoot [deg]", 17.3),
        ("heading zero [s]", 58.4),
        ("second peak [rad]", -0.65),
        ("second peak [s]", 87.0),
        ("third peak [rad]", 0.64),
        ("third peak [s]", 153.0),
        ("largest yaw rate [rad/s]", 0.0327),
        ("smallest yaw rate [rad/s]", -0.0337),
        ("u at 40 s [m/s]", 4.36),
        ("u at 110 s [m/s]", 3.75),
        ("lateral displacement [m]", 76.0),
        ("heel to port [rad]", 0.061),
        ("heel to starboard [rad]", -0.055),
    ],
)
def test_the_horizontal_zig_zag_is_the_published_one(
    horizontal: dict[str, float], quantity: str, published: float
) -> None:
    assert horizontal[quantity] == pytest.approx(published, rel=0.03)


@pytest.fixture(scope="module")
def vertical(
    make_boat: Callable[..., Boat], by_hand: Callable[[Boat], None]
) -> dict[float, dict[str, float]]:
    """Return, by speed [kn], the figures of the 10/10 zig-zag that begins with a dive."""
    figures = {}
    for speed in (10.0, 15.0):
        boat = make_boat("bb2", "full", "exact", "rk4", STEP)
        boat.start(speed * KNOT, DEEP, 0.0)
        by_hand(boat)
        seen = fly(boat, VERTICAL, -1.0, 200.0)
        t, pitch, rate = seen["t"], -seen["theta"], -seen["q"]
        first, second, third = peaks(pitch)
        deeper = seen["z"] - DEEP
        turning = first + int(np.argmax(np.diff(deeper[first:]) < 0.0))
        figures[speed] = {
            "first peak [deg]": math.degrees(pitch[first]),
            "second peak [deg]": math.degrees(pitch[second]),
            "third peak [deg]": math.degrees(pitch[third]),
            "first rate [rad/s]": rate[:first].max(),
            "second rate [rad/s]": rate[first:second].min(),
            "third rate [rad/s]": rate[second:third].max(),
            "t2/T1 [-]": t[second] / t[first],
            "t3/T1 [-]": t[third] / t[first],
            "first depth excursion [L]": deeper[turning] / LENGTH,
            "speed late [-]": seen["u"][-1] / (speed * KNOT),
        }
    return figures


@pytest.mark.core
@pytest.mark.long
@pytest.mark.parametrize(
    ("quantity", "at_10", "at_15"),
    [
        ("first peak [deg]", 11.8, 13.3),
        ("second peak [deg]", -12.3, -14.3),
        ("third peak [deg]", 12.1, 14.1),
        ("first rate [rad/s]", 0.0118, 0.0208),
        ("second rate [rad/s]", -0.0166, -0.0251),
        ("third rate [rad/s]", 0.0161, 0.0240),
        ("t2/T1 [-]", 2.37, 2.52),
        ("t3/T1 [-]", 3.82, 4.15),
        ("first depth excursion [L]", 0.223, 0.330),
        ("speed late [-]", 0.925, 0.923),
    ],
)
def test_the_vertical_zig_zag_is_the_published_one(
    vertical: dict[float, dict[str, float]], quantity: str, at_10: float, at_15: float
) -> None:
    assert vertical[10.0][quantity] == pytest.approx(at_10, rel=0.03)
    assert vertical[15.0][quantity] == pytest.approx(at_15, rel=0.03)


@pytest.mark.core
@pytest.mark.long
def test_dead_in_the_water_the_roll_decays_as_published(
    make_boat: Callable[..., Boat], by_hand: Callable[[Boat], None]
) -> None:
    # period 13.25 s; from one cycle to the next 0.80 of the amplitude is left, later 0.86
    boat = make_boat("bb2", "full", "exact", "rk4", STEP)
    s = boat.state
    boat.start(10.0 * KNOT, DEEP, 0.0)
    for name in ("motion", "rates", "surface"):
        s[name][:] = 0.0
    s.u_c = s.telegraph_order = s.telegraph_answer = 0.0
    by_hand(boat)
    s.z, s.phi = DEEP, math.radians(4.58)
    heel = [float(s.phi)]
    for _ in range(round(60.0 / STEP)):
        assert boat.tick() == 0
        heel.append(float(s.phi))
    phi = np.array(heel)

    up = np.flatnonzero((phi[:-1] < 0.0) & (phi[1:] >= 0.0))
    crests = [0, *(up[i] + np.argmax(phi[up[i] : up[i] + round(7.0 / STEP)]) for i in range(4))]

    periods = np.diff(up) * STEP
    kept = phi[crests[1:]] / phi[crests[:-1]]
    assert periods == pytest.approx([13.25] * len(periods), rel=0.03)
    assert kept[0] == pytest.approx(0.80, rel=0.03)
    assert kept[3] == pytest.approx(0.86, rel=0.03)
    assert np.all(np.diff(kept) > 0.0)
