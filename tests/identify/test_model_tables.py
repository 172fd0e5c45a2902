"""Transfer functions, order tests and sequences against the golden vectors of the report."""

import json
import math
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA

from trainer.config.files import ConfigError
from trainer.identify.experiment import REGISTER_TAPS, hold_bits, prbs
from trainer.identify.fitting.armax import Armax, rounding_poles, without_wind
from trainer.identify.judge.residuals import aic_of_loss, f_test, ratio_test
from trainer.identify.judge.uncertainty import draw_parameters, propagate_covariance
from trainer.identify.model.nomoto import levers, nomoto, scale, solve_motion, transfer

VECTORS = DATA / "identification"
OURS = {"Kv": "K_v"}
KNOT = 1852.0 / 3600.0


def vectors(name: Any) -> Any:
    return json.loads((VECTORS / f"{name}.json").read_text())


def number(value: Any) -> Any:
    return complex(value["re"], value["im"]) if isinstance(value, dict) else value


def ship(case: Any) -> Any:
    M, F, g = (np.array(case[key]) for key in ("M", "F", "g"))
    return transfer(*solve_motion(M, F, g))


@pytest.mark.parametrize("case", vectors("transfer_functions")["cases"])
def test_transfer_functions_and_time_constants_are_those_of_the_matrices(case: Any) -> None:
    found = ship(case)
    for name, value in case["tf"].items():
        assert getattr(found, name) == pytest.approx(value, rel=1e-12, abs=1e-14)
    form = nomoto(found)
    for name, value in case["nomoto"].items():
        assert getattr(form, OURS.get(name, name)) == pytest.approx(number(value), rel=1e-10)


@pytest.mark.parametrize("case", vectors("transfer_functions")["with_wind"])
def test_the_wind_on_the_heading_adds_its_terms(case: Any) -> None:
    found = transfer(np.array(case["A"]), np.array(case["b"]))
    assert found._asdict() == pytest.approx(case["tf"], rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("case", vectors("transfer_functions")["cases"])
def test_a_ship_is_stable_when_yaw_acts_further_forward_than_sway(case: Any) -> None:
    arms = levers(np.array(case["F"]), np.array(case["g"]))
    assert arms[3] == pytest.approx(case["lever"]["stability"], rel=1e-12)
    assert (arms[3] > 0.0) == nomoto(ship(case)).stable


@pytest.mark.parametrize(
    "ship", vectors("published_tables")["dimensional"]["ships"], ids=lambda ship: ship["ship"]
)
def test_prime_values_of_the_report_become_dimensional(ship: Any) -> None:
    own = scale("prime", ship["L"], ship["V_kn"] * KNOT)
    for name, prime, _, converted_value in ship["pairs"]:
        unit = {"K": 1.0 / own.time, "Kv": own.speed}.get(name, own.time)
        assert prime * unit == pytest.approx(converted_value, rel=1e-9)


def test_bis_and_prime_describe_one_ship() -> None:
    # K' = K''/F_nL, and K_v in speeds
    length, speed = 161.0, 4.5
    prime, bis = scale("prime", length, speed), scale("bis", length, speed)
    froude = speed / math.sqrt(9.81 * length)
    assert prime.time / bis.time == pytest.approx(1.0 / froude, rel=1e-12)
    assert prime.speed / bis.speed == pytest.approx(froude, rel=1e-12)


@pytest.mark.parametrize("row", vectors("order_tests")["aic"])
def test_the_reports_criteria_are_reproduced(row: Any) -> None:
    found = aic_of_loss(row["V"], row["N"], row["p"])
    assert found == pytest.approx(row["computed"], rel=1e-12)
    assert found == pytest.approx(row["published"], abs=0.1)


@pytest.mark.parametrize("row", vectors("order_tests")["f"])
def test_the_reports_f_values_are_reproduced(row: Any) -> None:
    pytest.importorskip("scipy")
    found = f_test((row["Va"], row["pa"]), (row["Vb"], row["pb"]), row["N"])
    assert found.statistic == pytest.approx(row["computed"], rel=1e-12)
    assert found.statistic == pytest.approx(row["published"], abs=0.1)
    assert (found.probability < 0.05) == (row["published"] > 2.8)


def test_the_likelihood_ratio_of_a_hundredth_is_no_reason_for_a_parameter() -> None:
    pytest.importorskip("scipy")
    # 2 (log L2 - log L1) = 3.84 is the 95 % point of chi-square with one degree of freedom
    assert ratio_test((0.0, 3), (1.92, 4)).probability == pytest.approx(0.05, abs=1e-3)
    assert ratio_test((0.0, 3), (0.01, 4)).probability > 0.05
    with pytest.raises(ConfigError, match="not more than"):
        ratio_test((0.0, 3), (1.0, 3))


@pytest.mark.parametrize("row", vectors("order_tests")["nomoto_from_armax"])
def test_a_second_order_model_gives_the_reports_time_constant_without_wind(row: Any) -> None:
    # A3: T = 29.4 s and K = -0.074 1/s, not the -0.055 that the report prints
    model = Armax((row["a1"], -row["a1"] - 1.0), (row["b1"], row["b2"]), (0.0, 0.0), ())
    found = without_wind(model, row["h"])
    assert pytest.approx(row["computed"]["T"], rel=1e-12) == found.T
    assert pytest.approx(row["computed"]["K"], rel=1e-12) == found.K


def test_zeros_of_the_reports_models_are_where_it_says() -> None:
    # A4
    for row, within in zip(vectors("order_tests")["zeros"], (0.02, 0.15, 0.02, 0.05), strict=True):
        poly = row["poly"]
        tail = tuple(x / poly[0] for x in poly[1:])
        model = Armax(tail, (0.0,) * len(tail), (0.0,) * len(tail), ())
        found = sorted(root.real for root in model.poles)
        assert found == pytest.approx(sorted(row["published"]), abs=within)
        assert found == pytest.approx(sorted(row["roots"]), rel=1e-9)


def test_a_pole_that_a_zero_cancels_is_told_as_rounding() -> None:
    # (6.4): the pole -0.61 beside the zero -0.41 of the report is not near enough; -0.6 with -0.55
    near = Armax((0.6,), (0.1, 0.055), (0.0,), ())
    assert rounding_poles(Armax((-0.3, -0.54), (1.0, 0.55), (0.0, 0.0), ())) != ()
    assert rounding_poles(Armax((-0.3, -0.54), (1.0, -0.9), (0.0, 0.0), ())) == ()
    assert near.poles[0].real == pytest.approx(-0.6)


@pytest.mark.parametrize("case", vectors("prbs")["sequences"], ids=lambda case: str(case["nbits"]))
def test_sequences_are_those_of_the_shift_register(case: Any) -> None:
    assert prbs(case["nbits"], case["seed"]).tolist() == case["values"]


def autocorrelation(sequence: Any) -> Any:
    own = np.fft.ifft(np.abs(np.fft.fft(sequence)) ** 2).real
    return own / own[0]


def test_a_sequence_looks_like_white_noise_of_its_period() -> None:
    case = vectors("prbs")
    for bits in REGISTER_TAPS:
        own = autocorrelation(prbs(bits))
        assert own[1:] == pytest.approx(np.full(2**bits - 2, -1.0 / (2**bits - 1)), abs=1e-12)
    assert autocorrelation(prbs(6)).tolist() == pytest.approx(case["period63_autocorrelation"])
    assert prbs(6).mean() == pytest.approx(case["mean"])


def test_a_bit_is_held_for_as_many_samples_as_asked() -> None:
    case = vectors("prbs")["held"]
    sequence = np.array(case["values"])[:: case["hold"]] / 2.5
    assert hold_bits(sequence, 2.5, case["hold"]).tolist() == case["values"]
    assert hold_bits(prbs(3), 2.0, 2).tolist()[:6] == [-2.0, -2.0, -2.0, -2.0, 2.0, 2.0]


def test_an_empty_register_is_refused() -> None:
    with pytest.raises(ConfigError, match="seed 0"):
        prbs(5, 0)
    with pytest.raises(ConfigError, match="must be 2 to 12"):
        prbs(40)


def test_uncertainty_of_a_product_is_that_of_its_factors() -> None:
    # var(xy) = y^2 var x + x^2 var y + 2 x y cov, to first order
    theta, covariance = np.array([3.0, -2.0]), np.array([[0.04, 0.01], [0.01, 0.09]])
    found = propagate_covariance(lambda t: np.array([t[0] * t[1]]), theta, covariance)
    expected = 4.0 * 0.04 + 9.0 * 0.09 + 2.0 * 3.0 * -2.0 * 0.01
    assert found.deviations[0] ** 2 == pytest.approx(expected, rel=1e-7)


def test_draws_have_the_covariance_they_are_asked_for_and_repeat() -> None:
    theta, covariance = np.array([1.0, 2.0]), np.array([[1.0, 0.8], [0.8, 1.0]])
    draws = draw_parameters(theta, covariance, 20000, seed=1)
    assert np.cov(draws.T) == pytest.approx(covariance, abs=0.03)
    assert np.array_equal(draws, draw_parameters(theta, covariance, 20000, seed=1))
