"""A sea in numbers and pictures: the command `trainer boat sea`."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from trainer.analysis import seaway
from trainer.cli.workshop.vessel import sea
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea, parse_sea

BB2 = load_vessel("bb2")


def ask(*words: str) -> Result:
    return CliRunner().invoke(sea, words)


@pytest.fixture(scope="module")
def report() -> seaway.SeaReport:
    return seaway.survey(load_sea("sea-state-4"), BB2, (17.5, 18.0, 20.0), 0.5)


def test_a_sea_says_how_high_and_long_it_is_and_which_step_it_allows(
    report: seaway.SeaReport,
) -> None:
    found = report.sea

    assert (found.height_m, found.from_deg, found.generator) == (1.875, 0.0, "filter")
    assert found.period_s == pytest.approx(6.84, abs=0.01)
    assert found.wavelength_m == pytest.approx(9.81 * found.period_s**2 / (2.0 * math.pi))
    assert found.longest_step_s == pytest.approx(1.416, abs=1e-3)
    # nu = 0.15: 0.15 x 9.81 / 0.918 = 1.60 m/s
    assert found.followed_kn == pytest.approx(3.12, abs=0.01)


def test_the_suction_on_a_boat_is_that_of_the_model_document(report: seaway.SeaReport) -> None:
    _, at_18, at_20 = report.depths

    assert at_18.suction_N == pytest.approx(7200.0, abs=100.0)
    assert at_18.slope_N_m == pytest.approx(1280.0, abs=20.0)
    assert at_18.suction_kg == pytest.approx(7200.0 / 9.81, abs=10.0)
    assert at_18.doubling_s == pytest.approx(55.0, abs=1.0)
    assert at_20.doubling_s == pytest.approx(68.0, abs=1.5)


def test_the_series_have_the_energy_of_the_spectrum_in_every_band(report: seaway.SeaReport) -> None:
    assert report.variance == pytest.approx(1.0, abs=0.02)
    assert [band.begin for band in report.bands] == pytest.approx(np.arange(6, 20) / 10.0)
    for band in report.bands:
        assert band.ratio == pytest.approx(1.0, abs=0.15)


def test_the_page_shows_the_filter_of_1969_as_it_is() -> None:
    old = parse_sea('[sea]\nsea_state = 5\ngenerator = "filter-1969"', Path("old.toml"))
    found = seaway.survey(old, BB2, (17.5,), 0.5)
    ratios = [band.ratio or 0.0 for band in found.bands]

    # table of the model document, first row
    assert ratios[0] == pytest.approx(7.35, rel=0.1)
    assert ratios[7] == pytest.approx(0.79, rel=0.1)
    assert found.sea.followed_kn is None


def test_a_band_beyond_what_the_step_can_show_has_no_energy() -> None:
    cosines = parse_sea('[sea]\nsea_state = 3\ngenerator = "cosines"', Path("my.toml"))
    found = seaway.survey(cosines, BB2, (17.5,), 1.5)

    assert found.bands[0].ratio is not None
    assert found.bands[-1].ratio is None


def test_json_has_numbers_only_and_a_calm_has_no_waves() -> None:
    found = json.loads(ask("sea-state-5", "--json").stdout, parse_constant=pytest.fail)

    assert found["sea"]["height_m"] == 3.25
    assert len(found["bands"]) == 14
    assert ask("calm").stdout == "Calm: no waves\n"
    assert json.loads(ask("calm", "--json").stdout)["depths"] == []


@pytest.mark.slow
def test_a_plot_has_two_series_the_spectrum_and_the_suction(tmp_path: Path) -> None:
    path = tmp_path / "sea.svg"
    done = ask("sea-state-5", "--plot", str(path))
    file = load_sea("sea-state-5")
    found = seaway.panels(file, BB2, seaway.survey(file, BB2, (17.5, 60.0), 0.5))
    series, shares, energy, lift = (panel.curves for panel in found)

    assert done.exit_code == 0
    assert path.read_bytes().startswith(b"<?xml")
    assert series[0].x[-1] == 400.0
    assert (shares[0].x == np.arange(1, 401)).all()
    assert np.max(abs(shares[0].y)) == pytest.approx(100.0)
    assert shares[0].y[99] / shares[0].y[7] == pytest.approx(series[0].y[199] / series[0].y[15])
    assert 0.6 < np.std(series[0].y) < 1.0  # a quarter of 3.25 m
    assert np.max(energy[0].y) == pytest.approx(np.max(energy[1].y), rel=0.1)
    assert np.all(np.diff(lift[0].y) < 0.0)


def test_what_cannot_be_shown_is_told() -> None:
    calm = ask("calm", "--plot", "calm.svg").exception
    short = ask("sea-state-3", "--step", "1").exception

    assert isinstance(calm, ConfigError)
    assert "calm.toml is a calm: there is nothing to draw" in str(calm)
    assert isinstance(short, ConfigError)
    assert "sea-state-3.toml: a sea above Nyquist for the step" in str(short)
    assert ask("sea-state-4", "--depth", "0").exit_code == 2


def test_suction_that_is_off_is_told() -> None:
    still = parse_sea('[sea]\nsea_state = 4\nsuction = "off"', Path("still.toml"))

    assert "suction is off in this sea" in seaway.render(seaway.survey(still, BB2, (18.0,), 0.5))


@pytest.mark.parametrize(
    ("wind", "constants"),
    [(45, "0.39 0.325 0.21"), (40, "0.43 0.325 0.24"), (35, "0.48 0.325 0.27")],
)
def test_the_page_has_the_constants_of_table_15_for_the_filter_of_1969(
    wind: int, constants: str
) -> None:
    text = f'[sea]\nwind_kn = {wind}\ngenerator = "filter-1969"\n'
    vessel = load_vessel("bb2")
    report = seaway.survey(parse_sea(text, Path("wind.toml")), vessel, (), 0.5)
    low, damping, high = map(float, constants.split())
    found = report.sea.made_of

    assert found == pytest.approx(
        {"w_nL": low, "d_L": damping, "w_nH": high, "d_H": 0.707}, rel=2e-3
    )
    assert f"made of: w_nL {found['w_nL']:.4f}, d_L 0.3250, w_nH" in seaway.render(report)


def test_the_page_has_the_weights_of_table_14_for_a_sum_of_cosines_alone() -> None:
    result = CliRunner().invoke(sea, ["sea-state-1"])

    weights = "-60 deg 0.0906, -30 deg 0.4330, 0 deg 0.5236, 30 deg 0.4330, 60 deg 0.0906"
    assert f"made of: {weights}" in " ".join(result.output.split())
    other = CliRunner().invoke(sea, ["sea-state-5"])
    assert "made of" not in other.output
    for done in (result, other):
        assert done.exit_code == 0
        assert done.output.isascii()
        assert max(map(len, done.output.splitlines())) <= 79


def test_the_energy_of_a_band_has_the_standard_error_of_its_series() -> None:
    x = np.array([1.02, 1.05, 1.08])
    energies = np.array([1.0, 3.0, 8.0])  # of three series, in the band from 1.0
    variance = energies[:, None] * np.full((3, 3), 1.0 / 3.0)
    band = next(
        one for one in seaway.in_bands(x, variance, 1.0, 0.5) if one.begin == pytest.approx(1.0)
    )
    assert band.ratio is not None
    assert band.error is not None
    # the mean is 4, the deviations -3, -1, 4: sqrt(26/2)/sqrt(3)
    assert band.error / band.ratio == pytest.approx(math.sqrt(13.0 / 3.0) / 4.0)
