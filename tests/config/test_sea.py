"""What a sea file may say, and what its author is told when it is wrong."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from helpers.places import ROOT

from trainer.config.files import ConfigError, shipped_path
from trainer.config.world.sea import load_sea, parse_sea, sea_settings, step_problem

G = 9.81


def settings_of(text: str) -> list[float]:
    """Return the settings of the sea whose [sea] table is ``text``."""
    return sea_settings(parse_sea(f"[sea]\n{text}", Path("my.toml")), G).tolist()  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("degree", "height"),
    [(0, 0.0), (1, 0.05), (2, 0.3), (3, 0.875), (4, 1.875), (5, 3.25), (6, 5.0)],
)
def test_a_sea_state_has_the_middle_height_of_its_degree(degree: int, height: float) -> None:
    name = f"sea-state-{degree}" if degree else "calm"

    assert sea_settings(load_sea(name), G)[0] == height


def test_a_wind_raises_the_sea_of_pierson_and_moskowitz() -> None:
    height, omega, gamma, *_ = settings_of("wind_kn = 40")
    wind = 40.0 * 1852.0 / 3600.0

    assert height == pytest.approx(0.2092 * wind**2 / G, rel=3e-4)
    assert omega == pytest.approx(0.877 * G / wind, rel=3e-4)
    assert gamma == 1.0
    assert settings_of(f"height_m = {height}")[1] == pytest.approx(omega, rel=1e-12)


def test_height_and_period_are_taken_as_given() -> None:
    text = 'height_m = 3\nperiod_s = 10\ngenerator = "cosines"\n'

    assert settings_of(text + 'spectrum = "bretschneider"')[:3] == pytest.approx(
        [3.0, 0.2 * np.pi, 1.0]
    )
    assert settings_of(text + 'spectrum = "jonswap"\ngamma = 2')[:3] == pytest.approx(
        [3.0, 0.2 * np.pi, 2.0]
    )


@pytest.mark.parametrize(("comes_from", "goes_to"), [(0, 180.0), (90, 270.0), (315, 135.0)])
def test_waves_travel_away_from_where_they_come_from(comes_from: int, goes_to: float) -> None:
    direction = settings_of(f"sea_state = 4\ndirection_deg = {comes_from}")[3]

    assert np.degrees(direction) == pytest.approx(goes_to)


def test_a_sea_has_suction_unless_it_is_switched_off_and_no_taper_unless_asked_for() -> None:
    assert settings_of("sea_state = 4")[4:] == [0.0, 1.0, 0.0, 0.0, 0.0]
    asked = 'sea_state = 4\ngenerator = "cosines"\nsuction = "off"\ntaper = "on"'
    assert settings_of(asked)[4:] == [1.0, 0.0, 0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("gamma", "generator", "shares"),
    [
        (1.7, "filter", [0.0, 0.0]),
        (1.8, "filter", [0.0, 1.0]),
        (3.3, "filter", [0.0, 1.0]),
        (3.3, "cosines", [0.0, 1.0]),
    ],
)
def test_the_peaked_bank_makes_the_spectra_that_are_nearer_to_it(
    gamma: float, generator: str, shares: list[float]
) -> None:
    sea = f'height_m = 3\nperiod_s = 9\nspectrum = "jonswap"\ngamma = {gamma}\n'

    assert settings_of(f'{sea}generator = "{generator}"')[6:8] == shares


def test_the_filter_of_1969_is_asked_for_by_its_name() -> None:
    assert settings_of('sea_state = 4\ngenerator = "filter-1969"')[6:8] == [1.0, 0.0]


@pytest.mark.parametrize(("degree", "longest"), [(1, 0.231), (2, 0.566), (3, 0.967), (4, 1.416)])
def test_a_sea_above_nyquist_is_refused_for_the_step_with_one_that_would_do(
    degree: int, longest: float
) -> None:
    sea = np.array(settings_of(f"sea_state = {degree}"))

    assert step_problem(sea, longest) is None
    refused = step_problem(sea, 1.05 * longest)
    assert refused
    assert refused.reason.startswith("a sea above Nyquist for the step: its peak of ")
    assert refused.reason.endswith(
        f'at most 1.3; take a step of {longest:g} s or generator = "cosines"'
    )
    assert step_problem(sea, longest + 0.001)
    refused = step_problem(np.array(settings_of("wind_kn = 0.01")), 0.1)
    assert refused
    assert refused.reason.endswith('at most 1.3; take generator = "cosines"')
    for others in ('generator = "cosines"', 'generator = "filter-1969"'):
        assert step_problem(np.array(settings_of(f"sea_state = {degree}\n{others}")), 2.0) is None
    assert step_problem(np.array(settings_of("sea_state = 0")), 2.0) is None


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "my.toml: [sea] has none of them: give one of sea_state, wind_kn, height_m"),
        ("sea_state = 4\nwind_kn = 20", "has sea_state, wind_kn: give one of"),
        ("sea_state = 4.5", "sea_state = 4.5: must be a whole number"),
        ("wind_kn = nan", "wind_kn = nan: must be finite"),
        ("wind_kt = 20", "wind_kt = 20: no such key; nearest is wind_kn"),
        ("wind_kn = 20\nperiod_s = 9", "period_s = 9: pierson-moskowitz has its own"),
        ('height_m = 3\nspectrum = "jonswap"', "lacks period_s"),
        (
            'height_m = 3\nperiod_s = 9\nspectrum = "jonswap"\ngenerator = "filter-1969"',
            'generator = "filter-1969": makes no jonswap spectrum; set generator = "filter"',
        ),
        (
            'height_m = 9\nperiod_s = 5\nspectrum = "bretschneider"',
            "period_s = 5: waves of 9 m break; must be at least 7.6 s",
        ),
        ("sea_state = 4\nramp_s = true", "ramp_s = true: must be a number"),
    ],
)
def test_a_wrong_sea_is_refused_with_the_reason(text: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        settings_of(text)

    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("sea_state = 4", "my.toml: sea_state = 4: belongs under [sea]"),
        ("nmae = 'x'\n[sea]\nsea_state = 4", 'nmae = "x": no such key; nearest is name'),
        ("name = 'x'", "my.toml: lacks the table [sea]"),
        ("[[sea]]\nsea_state = 4", "[sea] must be a table"),
    ],
)
def test_a_wrong_file_is_refused_with_the_reason(text: str, told: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_sea(text, Path("my.toml"))

    assert told in str(caught.value)


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match="nearest is sea-state-5"):
        load_sea("seastate-5")
    with pytest.raises(ConfigError, match="there is no such file"):
        load_sea("./storm.toml")


def test_the_manual_has_the_defaults_and_its_examples_load() -> None:
    manual = (ROOT / "docs" / "seas.md").read_text(encoding="utf-8")
    examples = re.findall(r"```toml\n(.*?)```", manual, re.DOTALL)
    defaults = tomllib.loads(shipped_path("", "sea-defaults").read_text(encoding="utf-8"))["sea"]

    assert len(examples) >= 2
    for example in examples:
        parse_sea(example, Path("example.toml"))
    for key, value in defaults.items():
        assert f"`{key}` {value if isinstance(value, str) else f'{value:g}'}" in manual
