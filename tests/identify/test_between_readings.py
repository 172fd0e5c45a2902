"""How the rudder goes from reading to reading: straight if measured, in steps if ordered."""

import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.studies import answered, identified, numbers
from helpers.turning import K_TRUE, T_TRUE, sail, write_study
from scipy.integrate import solve_ivp

from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.nonlinear import BentShip, predict_turning
from trainer.identify.fitting.problem import problem_of
from trainer.identify.judge.validation import simulate_deterministic
from trainer.identify.model.models import MODELS, Plant, Ship
from trainer.identify.record.measurements import Record, Samples, lines_between
from trainer.identify.record.study import load_study, observe_record

UNTRUE = ("dynamics are missing", "closed loop")  # of a ship that is fitted as she is
LINE = "rudder: taken as "


def uneven_samples(between_readings: str = "straight") -> Samples:
    t = np.array([0.0, 2.0, 4.0, 7.0, 9.0, 11.0, 13.0, 16.0, 18.0, 20.0])
    rudder = np.array([0.0, 1.0, 4.0, 10.0, 14.0, 17.0, 13.0, 6.0, 4.0, 1.0])  # always moving
    return Samples(t, np.full((10, 2), np.nan), rudder[:, None], between_readings)


@pytest.mark.parametrize("angle", [0.0, 0.7], ids=["at once", "after a lag"])
@pytest.mark.parametrize("sampling", ["instantaneous", "integrating"])
def test_a_ramp_is_sampled_exactly(angle: float, sampling: str) -> None:
    model, samples = MODELS["nomoto2"], uneven_samples()
    given = {"K": -0.08, "T1": 22.0, "T2": 4.0, "T3": 7.0, "delta_0": 0.4, "lag": angle}
    values = model.vector(**given, x2_0=0.1)
    plant = Plant(model, Ship(100.0, 6.0), ("yaw_rate", "heading"), 2.0)
    problem = replace(problem_of(plant, samples, values, ("lag",)), sampling=sampling)
    run = simulate_deterministic(problem, problem.start)
    drift = plant.blocks(values[None]).drift[0]
    lag = 2.0 * abs(np.sin(angle))

    def flow(t: float, x: Any) -> Any:
        rudder = np.interp(t - lag, samples.t, samples.inputs[:, 0])
        return drift @ np.array([*x[:3], rudder, 1.0])

    first = np.concatenate([problem.sampled(problem.start).at(0).start[:, 0], np.zeros(2)])
    true = first
    for k in range(9):
        true = np.concatenate([true[:3], np.zeros(2)])
        knots = [samples.t[k], min(samples.t[k] + lag, samples.t[k + 1]), samples.t[k + 1]]
        for begin, end in itertools.pairwise(knots):
            if end > begin:
                true = solve_ivp(flow, (begin, end), true, rtol=1e-11, atol=1e-14).y[:, -1]
        assert run[k + 1, :3] == pytest.approx(true[:3], rel=1e-7, abs=1e-12)
        if sampling == "integrating":
            assert run[k, 3:] == pytest.approx(true[3:], rel=1e-7, abs=1e-10)


def test_the_slopes_of_a_ramp_are_those_of_the_cost() -> None:
    model, samples = MODELS["nomoto1"], uneven_samples()
    samples = replace(samples, outputs=np.random.default_rng(1).standard_normal((10, 2)))
    names = ("K", "T", "delta_0", "R1_r", "lag")
    values = model.vector(K=-0.08, T=22.0, delta_0=0.4, R1_r=1e-7, R2_r=0.1, R2_psi=0.2, lag=0.6)
    plant = Plant(model, Ship(100.0, 6.0), ("yaw_rate", "heading"), 2.0)
    cost = Likelihood(problem_of(plant, samples, values, names))
    theta = cost.problem.start
    for i, slope in enumerate(cost.slope(theta)[1]):
        aside = 1e-5 * theta[i] * np.eye(len(theta))[i]
        change = cost.value(theta + aside) - cost.value(theta - aside)
        assert slope == pytest.approx(change / (2.0 * aside[i]), rel=1e-4, abs=1e-6), names[i]


def test_a_bent_ship_turns_by_the_straight_rudder() -> None:
    ship = BentShip(-0.05, 40.0, 8.0, 15.0, 400.0)
    t: Any = 2.0 * np.arange(60)
    rudder = np.radians(15.0) * np.sin(t / 9.0 + 0.5)
    rows = np.arange(60)
    coarse = Record(
        source="run", t=t, rudder=rudder, rows=rows, names={}, between_readings="straight"
    )
    fine_t: Any = np.arange(0.0, 118.001, 0.01)
    fine = np.interp(fine_t + 0.005, t, rudder)  # steps so short that they are the line
    steps = Record(source="run", t=fine_t, rudder=fine, rows=np.arange(len(fine_t)), names={})
    run = predict_turning(ship, coarse, np.zeros(2))
    true = predict_turning(ship, steps, np.zeros(2))[::200]
    assert run == pytest.approx(true, abs=1e-4)
    held = predict_turning(ship, replace(coarse, between_readings="step"), np.zeros(2))
    assert np.abs(held - true).max() > 1e-3


def test_a_corner_between_two_readings_is_where_the_lines_meet() -> None:
    # at rest until 3.5 s, then 5 deg/s until 7.2 s
    t = np.arange(0.0, 13.0, 2.0)
    fine = np.arange(0.0, 12.0, 1e-3) + 5e-4
    rudder, exact = (5.0 * (np.clip(one, 3.5, 7.2) - 3.5) for one in (t, fine))
    begin, slope = lines_between(t, rudder[:, None], "straight")
    mean = (begin + slope * np.diff(t, append=t[-1])[:, None] / 2.0)[:-1, 0]
    assert mean == pytest.approx(exact.reshape(6, 2000).mean(axis=1), abs=1e-5)
    held, none = lines_between(t, rudder[:, None], "step")
    assert held[:, 0] == pytest.approx(rudder)
    assert not none.any()


@pytest.mark.long
@pytest.mark.parametrize("rate", [2.5, None], ids=["moving", "at once"])
def test_the_ship_is_found_whether_her_rudder_moves_or_jumps(
    tmp_path: Path, rate: float | None
) -> None:
    report = identified(write_study(tmp_path, sail(1, rate=rate)))
    (line,) = [one for one in report["findings"] if one.startswith(LINE)]
    path = "straight" if rate else "step"
    assert report["between_readings"] == path
    assert ("straight from reading" if rate else "held until the next") in line
    for name, true in (("K", -K_TRUE), ("T", T_TRUE)):
        value, deviation = numbers(report)[name]
        assert abs(value - true) < 3.0 * deviation < 0.02 * abs(true), name
    assert not [one for one in report["verdicts"] if any(word in one for word in UNTRUE)]


@pytest.mark.parametrize("interval", [0.1, 0.5, 2.0])
def test_a_rudder_is_seen_to_move_however_often_it_is_read(tmp_path: Path, interval: float) -> None:
    rows = sail(2, rate=2.0, interval=interval, seconds=300.0)
    assert observe_record(load_study(write_study(tmp_path, rows))).between_readings == "straight"


def test_the_other_way_is_wrong_by_half_an_interval(tmp_path: Path) -> None:
    path = write_study(tmp_path, sail(1, rate=2.5), 'between_readings = "step"')
    report = identified(path)
    assert report["between_readings"] == "step"
    assert any("the study says so" in one for one in report["findings"])
    value, deviation = numbers(report)["T"]
    assert value < T_TRUE - 5.0 * deviation


@pytest.mark.parametrize("name", ["Rudder order", "delta_c", "cmd helm", "Ruder Soll"])
def test_an_ordered_rudder_is_a_step(tmp_path: Path, name: str) -> None:
    path = write_study(tmp_path, sail(1, rate=2.5, seconds=300.0), rudder=name)
    report = json.loads(answered(path, "--data-only", "--json").stdout)
    (run,) = report["runs"]
    assert run["between_readings"] == "step"
    assert any("its name is that of an order" in one for one in run["findings"])


@pytest.mark.parametrize(
    ("more", "words"),
    [(("--every", "2"), "the mean of 2 readings"), (("--armax",), "ARMAX models know no other")],
)
def test_what_knows_steps_alone_says_so(tmp_path: Path, more: tuple[str, ...], words: str) -> None:
    path = write_study(tmp_path, sail(1, rate=2.5), 'between_readings = "straight"')
    findings = " ".join(identified(path, *more)["findings"])
    assert f"held until the next reading, {words}" in findings


def test_thinned_the_mean_is_that_of_the_straight_line() -> None:
    t = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    record = Record(
        source="run", t=t, rudder=np.array([0.0, 1, 3, 3, 1]), rows=np.arange(5), names={}
    )
    straight = replace(record, between_readings="straight").every(2)
    assert straight.rudder == pytest.approx([1.25, 2.5, 1.0])
    assert straight.between_readings == "step"
    assert record.every(2).rudder == pytest.approx([0.5, 3.0, 1.0])


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "interval"), [(5.0, 2.0), (2.0, 1.0)])
def test_95_of_100_bands_hold_the_ship(tmp_path: Path, rate: float, interval: float) -> None:
    held = []
    for seed in range(24):
        report = identified(write_study(tmp_path, sail(seed, rate=rate, interval=interval)))
        ship = {one["name"]: one for one in report["ship"]}
        for name, true in (("K", -K_TRUE), ("T", T_TRUE)):
            held.append(ship[name]["low"] <= true <= ship[name]["high"])
    # 48 of .95 are 45.6 +- 1.5; K and T of one record are not independent
    assert sum(held) >= 41
