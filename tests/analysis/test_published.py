"""The steady turn of BB2, from the CSV of a headless run, as the 2510 equations give it.

All figures are from the validation document of the vessel data, section 1f.
"""

import csv
import math

import pytest
from helpers.nursery import run_trainer
from helpers.places import environment

KNOT = 1852.0 / 3600.0


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
