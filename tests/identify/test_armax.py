"""ARMAX models: fitted to what they simulated, judged by their residuals, chosen by order."""

import csv
from typing import Any

import numpy as np
import pytest
from helpers.places import ROOT

from trainer.config.files import ConfigError
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.fitting.armax import (
    Armax,
    _Orders,
    detrend,
    fit_armax,
    remove_delay,
    without_wind,
)
from trainer.identify.judge.residuals import describe_tests, examine_residuals
from trainer.identify.pages.armax import try_orders

DATA = ROOT.parent / "shared" / "data"  # beside the project
HAKUSAN = DATA / "hakusan" / "hakusan.csv"
# (6.3) of the report, heading by rudder of the Atlantic Song at 15 s; C is not printed there
SONG = Armax((-1.60, 0.61), (-0.161, -0.285), (-0.4, 0.05), (0.0, 0.0))
LAMBDA = np.sqrt(2.0 * 17.96 / 80)


def simulated(model: Any, samples: Any, deviation: Any, seed: Any) -> Any:
    rng = np.random.default_rng(seed)
    u = np.tile(hold_bits(prbs(6), 5.0, 1), 1 + samples // 63)[:samples]
    return model.simulated(u, deviation * rng.standard_normal(samples)), u


def test_residuals_of_the_true_model_are_the_noise_that_was_put_in() -> None:
    rng = np.random.default_rng(2)
    e, u = rng.standard_normal(50), rng.standard_normal(50)
    model = Armax((-1.5, 0.7), (1.0, 0.5), (-1.0, 0.2), (0.3, -0.4))
    assert model.residuals(model.simulated(u, e), u) == pytest.approx(e, abs=1e-12)


def test_without_noise_the_coefficients_come_back() -> None:
    y, u = simulated(SONG, 120, 1e-6, 1)
    found = fit_armax(y, u, 2).model
    assert found.a == pytest.approx(SONG.a, abs=1e-5)
    assert found.b == pytest.approx(SONG.b, abs=1e-5)


@pytest.mark.slow
def test_standard_deviations_are_those_of_repeated_experiments() -> None:
    # 60 records: the scatter of each estimate is known to 9 %, three of those are allowed
    model = Armax((-1.5, 0.7), (1.0, 0.5), (-0.5, 0.2), (0.0, 0.0))
    fits = [fit_armax(*simulated(model, 400, 1.0, seed), 2, initial=False) for seed in range(60)]  # type: ignore[arg-type, misc]
    estimates = np.array([[*f.model.a, *f.model.b, *f.model.c] for f in fits])
    said = np.mean([f.deviations for f in fits], axis=0)
    assert estimates.std(axis=0) == pytest.approx(said, rel=0.27)
    assert estimates.mean(axis=0) == pytest.approx([*model.a, *model.b, *model.c], abs=0.03)
    assert all(f.converged for f in fits)


@pytest.mark.slow
def test_atlantic_song_is_found_as_exactly_as_the_report_says() -> None:
    # S1: means of the estimated deviations within 40 % of the printed ones or of those the
    # prototype found; K and T in the ranges of simulated records
    fits, ships = [], []
    for seed in range(40):
        y, u = simulated(SONG, 80, LAMBDA, seed)
        fit = fit_armax(y, u, 2)
        fits.append(fit.deviations[:6])
        ships.append(without_wind(fit.model, 15.0))
    found = np.array([0.020, 0.020, 0.014, 0.017, 0.112, 0.113])
    assert np.mean(fits, axis=0) == pytest.approx(found, rel=0.4)
    assert -0.079 < np.median([ship.K for ship in ships]) < -0.069
    assert 26.0 < np.median([ship.T for ship in ships]) < 32.0


def test_derivatives_of_the_errors_are_those_of_differences() -> None:
    y, u = simulated(SONG, 60, LAMBDA, 2)
    search = _Orders(y, u, 2)
    theta = np.array([-1.5, 0.55, -0.1, -0.2, -0.5, 0.1, 1.0, 0.5])
    _, J = search.jacobian(theta)
    for i, column in enumerate(J.T):
        step = 1e-6 * np.eye(8)[i]
        ends = (search.model(theta + side * step).residuals(y, u) for side in (1.0, -1.0))
        up, down = ends
        assert (up - down) / 2e-6 == pytest.approx(column, abs=1e-6 * np.abs(column).max())


def test_a_larger_model_never_fits_worse() -> None:
    y, u = simulated(SONG, 200, LAMBDA, 3)
    losses = [order.loss for order in try_orders(y, u, 4, initial=True, lags=10).tried]
    assert losses == sorted(losses, reverse=True)


def test_the_order_that_made_a_record_is_chosen_for_it() -> None:
    model = Armax((-1.5, 0.7), (1.0, 0.5), (-0.5, 0.2), (0.0, 0.0))
    y, u = simulated(model, 600, 1.0, 4)
    orders = try_orders(y, u, 4, initial=False, lags=10)
    assert orders.by_bic.order == 2
    assert orders.by_test.order == 2
    first = orders.tried[0].residuals
    assert first.whiteness.probability < 1e-6
    assert orders.tried[1].residuals.whiteness.probability > 0.01


def test_a_common_factor_is_named() -> None:
    # order 2 of a first-order record without noise of its own: A, B and C share a factor
    y, u = simulated(Armax((-0.8,), (1.0,), (0.0,), ()), 300, 1e-9, 5)
    fit = fit_armax(y, u, 2, initial=False)
    assert set(fit.inseparable) >= {"a1", "a2", "b2"}
    assert np.isinf(fit.deviations[fit.names.index("a2")])


def test_gaps_and_short_records_are_refused() -> None:
    y, u = simulated(SONG, 80, LAMBDA, 7)
    with pytest.raises(ConfigError, match="too few"):
        fit_armax(y[:12], u[:12], 2)
    y[3] = np.nan
    with pytest.raises(ConfigError, match="missing"):
        fit_armax(y, u, 2)


def test_dead_time_and_trend_are_taken_out() -> None:
    t = np.arange(40.0)
    assert detrend(3.0 + 2.0 * t, "trend") == pytest.approx(np.zeros(40), abs=1e-10)
    assert detrend(3.0 + 2.0 * t, "mean").mean() == pytest.approx(0.0, abs=1e-12)
    y, u = remove_delay(t, 10.0 + t, 3)
    assert y[0] == 3.0
    assert u[0] == 10.0
    assert len(y) == len(u) == 37


def test_white_residuals_pass_and_coloured_ones_are_told() -> None:
    rng = np.random.default_rng(8)
    white, rudder = rng.standard_normal(500), rng.standard_normal(500)
    assert describe_tests(examine_residuals("r", white, rudder)) == []
    coloured = white + 0.5 * np.roll(white, 1)
    assert "not white" in describe_tests(examine_residuals("r", coloured, rudder))[0]
    driven = white + 0.5 * np.roll(rudder, 2)
    assert any(
        "follow the rudder" in text
        for text in describe_tests(examine_residuals("r", driven, rudder))
    )
    steered = rudder + 0.5 * np.roll(white, 2)
    found = describe_tests(examine_residuals("r", white, steered))
    assert found == ["r: the rudder follows the residuals: the record is of a closed loop"]


def test_a_sensor_of_few_steps_is_seen_in_the_distribution() -> None:
    rng = np.random.default_rng(9)
    rounded = np.round(rng.standard_normal(400))
    found = examine_residuals("psi", rounded, rng.standard_normal(400))
    assert found.normality.probability < 1e-6


def test_sign_changes_of_white_noise_are_half_of_the_pairs() -> None:
    rng = np.random.default_rng(10)
    found = examine_residuals("r", rng.standard_normal(2001), rng.standard_normal(2001))
    assert found.sign_changes_expected == 1000.0
    assert abs(found.sign_changes - 1000.0) < 4.0 * found.sign_changes_deviation


@pytest.mark.slow
@pytest.mark.skipif(not HAKUSAN.is_file(), reason="the Hakusan record is not on this machine")
def test_hakusans_record_asks_for_a_high_order_and_shows_its_autopilot() -> None:
    with HAKUSAN.open() as file:
        rows = list(csv.DictReader(file))
    y = detrend(np.array([float(row["YawRate"]) for row in rows]), "mean")
    u = detrend(np.array([float(row["Rudder"]) for row in rows]), "mean")
    orders = try_orders(y, u, 4, initial=True, lags=20)
    assert orders.by_aic.order == 4
    # a second-order ship leaves the waves in its residuals, an autopilot feeds them back
    assert orders.tried[1].residuals.whiteness.probability < 0.01
    assert orders.tried[3].residuals.whiteness.probability > 0.1
    assert orders.tried[3].residuals.feedback.probability < 1e-10
