"""Rudder experiments: what is ordered, how the boat takes it, and what it would tell."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trainer.analysis.programs.characteristic import MeanMotions, horizontal_system
from trainer.config.boat.vessel import load_vessel, parse_vessel
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.config.ship.sensors import Sensors
from trainer.identify.experiment import (
    BinarySequence,
    exercise_text,
    fly_trial,
    measure_zigzag,
    remarks,
    schedule_orders,
    suggest_bits,
    suggest_hold,
    suggest_interval,
    zigzag_flight,
    zigzag_orders,
)
from trainer.identify.fitting.minimise import ignore_news
from trainer.identify.judge.fitted import fit_study
from trainer.identify.model.nomoto import Nomoto, find_steering
from trainer.identify.pages.experiment import prospect
from trainer.identify.pages.ship_files import averages, coefficients, rewrite_coefficients
from trainer.identify.record.sources import read_by
from trainer.identify.record.study import plain_study
from trainer.identify.record.study_records import ModelTable, Ship
from trainer.units import KNOT

SHIP = Nomoto(K=-0.28, T1=40.0 + 0j, T2=5.0 + 0j, T3=9.0, K_v=8.0, T3v=2.5)
SENSORS = Sensors(sway_kn=0.05, yaw_rate_deg_s=0.02, heading_deg=0.1)
SPEED = 10.0 * KNOT


@pytest.fixture(scope="module")
def bb2() -> Any:
    return load_vessel("bb2")


@pytest.fixture(scope="module")
def calm(bb2: Any) -> Any:
    """Return the record of 2 degrees flown by BB2 in a calm."""
    sequence = BinarySequence(5, 2.0, 15.0, 1, "rudder")
    return fly_trial(bb2, schedule_orders(sequence.orders()), SPEED, 60.0, sequence.seconds)


def test_orders_change_sides_with_the_sequence_and_end_on_course() -> None:
    orders = BinarySequence(3, 5.0, 10.0, 1, "rudder").orders()
    # -1 -1 1 -1 1 1 1 from 30 s, a bit 10 s: positive rudder is to port
    assert orders == (
        (30.0, "rudder right 5"),
        (50.0, "rudder left 5"),
        (60.0, "rudder right 5"),
        (70.0, "rudder left 5"),
        (100.0, "rudder auto"),
    )


def test_courses_are_ordered_on_both_sides_of_north() -> None:
    orders = dict(BinarySequence(3, 4.5, 10.0, 1, "course").orders())
    assert orders[30.0] == "course 004.5"
    assert orders[50.0] == "course 355.5"
    assert orders[100.0] == "course 000"


def test_more_orders_than_an_exercise_takes_are_refused() -> None:
    with pytest.raises(ConfigError, match="more than the 499"):
        BinarySequence(12, 5.0, 10.0, 1, "rudder").orders()


def test_suggestions_follow_the_time_constants() -> None:
    interval = suggest_interval(SHIP, 0.5)
    assert 0.5 * 5.0 <= interval <= 0.2 * 40.0
    hold = suggest_hold(SHIP, interval)
    assert 0.2 * 40.0 <= hold <= 0.5 * 40.0
    sequence = BinarySequence(suggest_bits(SHIP, hold), 5.0, hold, 1, "rudder")
    assert sequence.seconds >= 20.0 * 40.0
    assert list(remarks(sequence, SHIP, interval, 10.0 / interval / 2.0)) == []


def test_unwise_experiments_are_told_why() -> None:
    unstable = Nomoto(K=0.1, T1=-300.0 + 0j, T2=10.0 + 0j, T3=20.0, K_v=1.0, T3v=1.0)
    texts = " ".join(remarks(BinarySequence(4, 20.0, 7.0, 1, "rudder"), unstable, 3.0, 8.0))
    assert "goes over in 5 s: record it every 2.5 s or oftener" in texts
    for part in ("much", "bits of 7 s", "is short", "--by course", "samples every", "no whole"):
        assert part in texts


def test_the_exercise_written_is_one_the_trainer_reads() -> None:
    orders = BinarySequence(5, 3.0, 15.0, 1, "rudder").orders()
    table = {"vessel": "bb2", "speed_kn": 10.0, "depth_m": 60.0, "duration_s": 500.0}
    text = exercise_text(orders, "PRBS at 10 kn", {**table, "sea": "sea-state-3"})
    exercise = parse_exercise(text, Path("trial.toml"))
    assert [entry.order.text for entry in exercise.schedule] == [order for _, order in orders]
    assert exercise.sea is not None
    assert exercise.initial.depth_m == 60.0
    assert exercise.heading.integrator == "rk4"


def test_the_boat_turns_to_port_when_the_record_says_positive_rudder(calm: Any) -> None:
    first = int(np.argmax(calm.rudder > math.radians(1.9)))
    assert calm.yaw_rate[first + 20] < calm.yaw_rate[first]
    helmed = (calm.t > 32.0) & (calm.t < 30.0 + 15.0 * 31)
    assert np.abs(calm.rudder[helmed]).max() == pytest.approx(math.radians(2.0))
    assert calm.t[-1] == pytest.approx(30.0 + 15.0 * 32)


def test_an_order_that_the_boat_refuses_stops_the_trial(bb2: Any) -> None:
    with pytest.raises(ConfigError, match=r"30 s: rudder right 45: the limit"):
        fly_trial(bb2, schedule_orders(((30.0, "rudder right 45"),)), SPEED, 60.0, 60.0)
    with pytest.raises(ConfigError, match=r'rudder sideways: "sideways" after "rudder"'):
        schedule_orders(((0.0, "rudder sideways"),))
    with pytest.raises(ConfigError, match="rudder right 200: 200: an angle is 0 to 90 deg"):
        schedule_orders(((0.0, "rudder right 200"),))


def test_steering_of_a_boat_is_that_of_its_modes(bb2: Any) -> None:
    # roll is left out, and moves the slowest root by less than a hundredth
    form = find_steering(bb2, SPEED).nomoto
    roots = horizontal_system(bb2, SPEED).eigenvalues
    spiral = max(root.real for root in roots if root.imag == 0.0)
    assert -1.0 / form.T1.real == pytest.approx(spiral, rel=0.01)
    assert form.K < 0.0 < form.T1.real


def test_the_boats_prime_numbers_are_those_of_its_file(bb2: Any) -> None:
    prime = find_steering(bb2, SPEED).prime
    mass = bb2.hull.mass / (0.5 * bb2.fluid.rho * bb2.hull.length**3)
    assert prime["Y_v"] == pytest.approx(bb2.coefficients["Y_v"])
    assert prime["Y_r"] == pytest.approx(bb2.coefficients["Y_r"] - mass)
    assert prime["m11"] == pytest.approx(mass - bb2.coefficients["Y_vdot"])
    assert -prime["Y_delta"] * prime["l_delta"] == pytest.approx(bb2.coefficients["N_dr"])


def test_identified_numbers_go_back_into_the_file_they_came_from(bb2: Any) -> None:
    # at rest nothing is taken off: the file's own numbers come back
    values = coefficients(bb2, find_steering(bb2, SPEED).prime, SPEED, MeanMotions())
    for key, value in values.items():
        assert value == pytest.approx(bb2.coefficients[key], abs=1e-12)
    again = parse_vessel(
        rewrite_coefficients(bb2.text, {"N_v": -0.0123}, "found"), Path("new.toml")
    )
    assert again.coefficients["N_v"] == -0.0123
    assert again.coefficients["Y_v"] == bb2.coefficients["Y_v"]
    with pytest.raises(ConfigError, match="no line N_q"):
        rewrite_coefficients(bb2.text, {"N_q": 1.0}, "found")


def test_quadratic_terms_of_the_file_are_not_counted_twice(bb2: Any) -> None:
    means = MeanMotions(v=0.3, r=0.01)
    found = find_steering(bb2, SPEED, means).prime
    values = coefficients(bb2, found, SPEED, means)
    for key in ("Y_v", "Y_r", "N_v", "N_r"):
        assert values[key] == pytest.approx(bb2.coefficients[key], abs=1e-12)


def test_averages_of_a_square_wave_are_its_height(calm: Any) -> None:
    wave = np.where(np.arange(len(calm.t)) % 2 == 0, 0.3, -0.3)
    assert averages(replace(calm, sway=wave)).v == pytest.approx(0.3)


def test_sensors_add_white_errors_of_their_size_and_the_same_ones_again(calm: Any) -> None:
    read = read_by(calm, SENSORS)
    errors = np.degrees(read.heading - calm.heading)
    assert errors.std() == pytest.approx(0.1, rel=0.1)
    assert np.array_equal(read.heading, read_by(calm, SENSORS).heading)  # type: ignore[arg-type]
    assert np.array_equal(read.rudder, calm.rudder)  # type: ignore[arg-type]
    assert not np.array_equal(errors, np.degrees(read.yaw_rate - calm.yaw_rate))


@pytest.mark.slow
def test_what_is_expected_of_a_trial_is_what_estimates_of_it_scatter(bb2: Any) -> None:
    pytest.importorskip("scipy")
    sequence = BinarySequence(5, 0.5, 15.0, 1, "rudder")
    record = fly_trial(
        bb2, schedule_orders(sequence.orders()), SPEED, 60.0, sequence.seconds
    ).every(10)
    gentle = {"sway_kn": 0.02, "yaw_rate_deg_s": 0.01, "heading_deg": 0.05}
    outputs = ("yaw_rate", "heading")
    said = prospect(find_steering(bb2, SPEED), record, outputs, Sensors(**gentle), 0.0)
    study = replace(
        plain_study(Path("x.csv")),
        ship=Ship(length_m=bb2.hull.length, speed_kn=10.0),
        model=ModelTable(kind="nomoto2", outputs=outputs, noise="output-error"),
    )
    found = []
    for seed in range(1, 25):
        noisy = read_by(record, Sensors(**gentle, seed=seed))
        found.append(fit_study(study, noisy, ignore_news).quantity_spread.values[0])
    # 24 estimates know their scatter to 15 %
    assert np.std(found, ddof=1) == pytest.approx(said.deviations["K"], rel=0.45)


def test_a_quieter_sea_and_a_larger_helm_tell_more(bb2: Any, calm: Any) -> None:
    pytest.importorskip("scipy")
    ship, record = find_steering(bb2, SPEED), calm.every(10)
    outputs = ("sway", "yaw_rate", "heading")
    rough = prospect(ship, record, outputs, SENSORS, 0.1).deviations
    quiet = prospect(ship, record, outputs, SENSORS, 0.02).deviations
    assert quiet["K"] < rough["K"]
    assert quiet["N_v"] < rough["N_v"]
    without_log = prospect(ship, record, ("yaw_rate", "heading"), SENSORS, 0.02)
    assert without_log.model == "nomoto2"
    assert without_log.deviations["T1"] > quiet["T1"]


def test_a_trial_without_helm_tells_nothing(bb2: Any) -> None:
    pytest.importorskip("scipy")
    record = fly_trial(bb2, (), SPEED, 60.0, 300.0).every(10)
    with pytest.raises(ConfigError, match="cannot separate"):
        prospect(find_steering(bb2, SPEED), record, ("yaw_rate", "heading"), SENSORS, 0.02)


def test_a_zigzag_is_told_and_flown_again_by_its_orders(bb2: Any) -> None:
    flight = zigzag_flight(bb2, SPEED, (10.0, 10.0), 200.0)
    told = measure_zigzag(flight, 10.0)
    assert told["reach_s"] == pytest.approx(flight.marks[1].t - flight.marks[0].t)
    assert told["overshoots_deg"][0] > 1.0
    orders = zigzag_orders(flight, 10.0)
    assert orders[0] == (30.0, "rudder right 10")
    record = fly_trial(bb2, schedule_orders(orders), SPEED, 60.0, orders[-1][0])
    first_swing = record.t < orders[2][0]
    peak = math.degrees(float(record.heading[first_swing].max()))  # type: ignore[index]
    assert peak == pytest.approx(10.0 + told["overshoots_deg"][0], abs=1.0)
    with pytest.raises(ConfigError, match="rudder goes to 30 deg"):
        zigzag_flight(bb2, SPEED, (40.0, 10.0), 100.0)
