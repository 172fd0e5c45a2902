"""Round trip: a boat flown under an experiment, identified, written, and flown against herself."""

import json
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from trainer.analysis.characteristic import horizontal
from trainer.analysis.manoeuvres.flight import fly
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.analysis.manoeuvres.zigzag import ZigZag
from trainer.cli.identify import identify, prbs
from trainer.config.vessel import load_vessel
from trainer.identify.experiment import method_of
from trainer.identify.nomoto import load_nomoto
from trainer.identify.steering import Steered, steering
from trainer.units import KNOT

pytest.importorskip("scipy")

SENSIBLE = ("--amplitude", "1", "--interval", "5", "--depth", "17.5", "--sea", "sea-state-3")
# A degree of helm is no longer linear: in a calm, without noise, it gives a T1 8 % below the
# linear boat's, and a tenth of a degree gives hers.
BENT = 0.1  # [-] of a linear figure


def run(command: Any, *arguments: Any) -> Any:
    result = CliRunner().invoke(command, [str(one) for one in arguments])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.stdout


@pytest.fixture(scope="module")
def trial(tmp_path_factory: Any) -> Any:
    """Return the folder of 1 degree flown by BB2 at periscope depth in sea state 3."""
    folder = tmp_path_factory.mktemp("trial")
    run(prbs, "bb2", *SENSIBLE, "--write", folder / "trial.toml")
    order = [sys.executable, "-m", "trainer", "run", "trial.toml", "--headless"]
    order += ["--speed", "max", "--record", "trial.trainer"]
    subprocess.run(order, cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def found(trial: Any) -> Any:
    """Return the reports of Model 1 and Nomoto's, their files written."""
    reports = {}
    for model, more in (
        ("1", ("--write-vessel", trial / "bb2-found.toml")),
        ("nomoto2", ("--write-nomoto", trial / "nomoto.toml")),
    ):
        arguments = (trial / "trial.trainer", "--model", model, "--vessel", "bb2", "--every", "10")
        reports[model] = json.loads(run(identify, *arguments, *more, "--json"))
    return reports


@pytest.mark.long
@pytest.mark.parametrize("model", ["1", "nomoto2"])
def test_the_roots_found_are_those_of_trainer_modes(found: Any, model: Any) -> None:
    ship = {one["name"]: (one["value"], one["deviation"]) for one in found[model]["ship"]}
    speed = found[model]["speed_kn"] * KNOT
    roots = sorted(-s.real for s in horizontal(load_vessel("bb2"), speed).eigenvalues if not s.imag)
    for name, rate in zip(("T1", "T2"), roots, strict=True):
        value, deviation = ship[name]
        assert abs(value - 1.0 / rate) < 3.0 * deviation + BENT / rate


@pytest.mark.long
def test_the_boat_written_steers_like_the_boat_flown(found: Any, trial: Any) -> None:
    speed = found["1"]["speed_kn"] * KNOT
    deviations = {one["name"]: one["deviation"] for one in found["1"]["ship"]}
    true, again = (
        steering(load_vessel(one), speed).nomoto for one in ("bb2", str(trial / "bb2-found.toml"))
    )
    for name in ("K", "T1", "T2", "T3", "K_v", "T3v"):
        linear = getattr(true, name)
        off = abs(getattr(again, name) - linear)
        assert off < 3.0 * deviations[name] + BENT * abs(linear), name


def flight(vehicle: Any, speed: Any) -> Any:
    return fly(vehicle, ZigZag(angle_deg=5.0, execute_deg=5.0, duration_s=300.0), speed)


def error_of(true: Any, other: Any, seconds: Any) -> Any:
    """Return the rms difference of two headings [deg] over the first seconds."""
    early = true.t < seconds
    error = np.degrees(true.column("psi")[early] - other.column("psi")[early])
    return math.sqrt(float(np.mean(error**2)))


@pytest.mark.long
@pytest.mark.usefixtures("found")
def test_the_boat_written_zigzags_like_the_boat_flown(trial: Any) -> None:
    speed = 10.0 * KNOT
    bb2, again = load_vessel("bb2"), load_vessel(str(trial / "bb2-found.toml"))
    true, other = (flight(Submarine(f, method_of(f), Rig()), speed) for f in (bb2, again))
    assert error_of(true, other, 60.0) < 0.2
    assert error_of(true, other, 300.0) < 0.5
    first, second = (f.marks[1].t - f.marks[0].t for f in (true, other))
    assert second == pytest.approx(first, rel=0.1)


@pytest.mark.long
@pytest.mark.usefixtures("found")
def test_the_nomoto_ship_zigzags_like_the_boat_flown(trial: Any) -> None:
    ship = Steered(load_nomoto(trial / "nomoto.toml"))
    bb2 = load_vessel("bb2")
    true = flight(Submarine(bb2, method_of(bb2), Rig()), 10.0 * KNOT)
    other = flight(ship, 10.0 * KNOT)
    assert error_of(true, other, 60.0) < 1.2
    peaks = [np.degrees(f.column("psi")[f.t < 60.0].max()) for f in (true, other)]
    assert peaks[1] == pytest.approx(peaks[0], rel=0.15)
