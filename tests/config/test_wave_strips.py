"""The strips of a vessel file that waves push on."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trainer.boat.assemble import Method, fit_out
from trainer.config.boat.vessel import VesselFile, load_vessel, read_vessel
from trainer.config.files import ConfigError, shipped_path
from trainer.core.vessel import STRIP_SHARES, STRIP_STATIONS

METHOD = Method("modified", "lagged", "exact", "adams2", 0.5)


def bb2_with(**strips: Any) -> VesselFile:
    """Return BB2 with other entries of her table, None for none."""
    table = tomllib.loads(shipped_path("vessels", "bb2").read_text(encoding="utf-8"))
    table["wave_strips"] |= strips
    return read_vessel(table, "", Path("mine.toml"))


def test_the_strips_of_bb2_are_her_hull_by_mass_centre_and_gyradius() -> None:
    file = load_vessel("bb2")
    table = file.wave_strips
    assert table
    for masses, whole, gyradius in (
        (table.displaced_kg, 4.4188e6, 16.5),
        (table.added_down_kg, 3.7103e6, 16.8),
        (table.added_side_kg, 5.2940e6, 15.3),
    ):
        mass, x = np.array(masses), np.array(table.x_m)
        assert np.sum(mass) == pytest.approx(whole, rel=1e-3)
        assert np.sqrt(np.sum(mass * x * x) / np.sum(mass)) == pytest.approx(gyradius, abs=0.06)
    assert not [text for text in file.remarks if "wave_strips" in text]


def test_a_run_has_places_in_lengths_and_shares_of_each_mass() -> None:
    file = load_vessel("bb2")
    assert file.wave_strips
    places, *shares = fit_out(file, METHOD).vessel["strips"][0]

    assert places == pytest.approx(np.array(file.wave_strips.x_m) / 70.2)
    for share in shares:
        assert np.sum(share) == pytest.approx(1.0)
    assert shares[2][2] == pytest.approx(1680.3 / 5294.0, rel=1e-3)  # where the sail is


def test_a_file_without_strips_has_those_of_a_usual_hull_about_its_centre() -> None:
    file = load_vessel("sdv-mk9")
    file = replace(file, hull=replace(file.hull, cb=(0.2, 0.0, 0.0)))
    places, *shares = fit_out(file, METHOD).vessel["strips"][0]
    centre = file.hull.cb[0] / file.hull.length

    assert file.wave_strips is None
    assert places == pytest.approx(np.array(STRIP_STATIONS) + centre)
    for share in shares:
        assert share == pytest.approx(np.array(STRIP_SHARES) / np.sum(STRIP_SHARES))
    assert np.dot(STRIP_STATIONS, STRIP_SHARES) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize(
    ("strips", "told"),
    [
        ({"displaced_kg": [5e5] * 7}, "displaced_kg: the sum is 3.5e+06 kg, must be buoyancy/g"),
        (
            {"displaced_kg": [161.6e3, 647.3e3, 779.4e3, 793.1e3, 779.4e3, 778.7e3, 479.4e3]},
            "displaced_kg: the centre is at x = -5.25 m, must be that of cb, 0 m, within 0.351 m",
        ),
        ({"x_m": [7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 2.0]}, "must descend from the bow, none twice"),
        (
            {"x_m": [50.0, 17.3, 7.3, -2.8, -12.9, -22.4, -50.0]},
            "must lie within 42.12 m of the origin",
        ),
        ({"added_side_kg": [0.0] * 7}, "added_side_kg: all are 0, must have a sum"),
        ({"x_m": [1.0]}, "must be a list of 7 numbers"),
        ({"displaced_kg": [0.0] * 7}, "must be above 0 to 1e+09 kg"),
    ],
)
def test_strips_that_are_not_this_hull_are_refused(strips: dict[str, Any], told: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(told)) as caught:
        bb2_with(**strips)
    assert str(caught.value).startswith("mine.toml: [wave_strips")


def test_added_masses_that_are_not_the_coefficients_are_remarked_on() -> None:
    even = bb2_with(added_down_kg=[5e5] * 7, added_side_kg=[400e3, 1000e3, *[780e3] * 5])

    assert [text.partition("] ")[2] for text in even.remarks if "wave_strips" in text] == [
        "added_down_kg: the sum is 3.5e+06 kg, -Z_wdot is 3.71033e+06 kg, which a run shares out",
        "added_side_kg: the centre is at x = -3.79 m, by Y_rdot it is at 0.125 m",
    ]
