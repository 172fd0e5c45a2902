"""Tracks of latitude and longitude to sway: against geodesics, and as a study reads them."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from helpers.studies import columns

from trainer.config.files import ConfigError
from trainer.config.tables import read_table
from trainer.identify.record.study import load_study, observe_record
from trainer.identify.record.track import ground_velocity
from trainer.units import KNOT

STEP, COUNT = 1.0, 200
STUDY = (
    """schema = "identify/1"
name = "a track"
data = "track.csv"
{more}
"""
    + columns(
        t="t s",
        rudder="helm deg",
        heading="gyro deg",
        latitude="lat {unit}",
        longitude="lon {unit}",
    )
    + """{tables}"""
)


def sailed(antenna: float = 0.0, current: tuple[float, float] = (0.0, 0.0)) -> Any:
    """Return columns of a ship that weaves across the date line, and its true sway [m/s].

    ``antenna`` is ahead [m], ``current`` east and north [m/s]. The track is by geodesics.
    """
    t = STEP * np.arange(COUNT)
    heading = 0.7 + 0.5 * np.sin(0.05 * t)
    sway, ahead = 0.8 * np.sin(0.05 * t + 1.0), 6.0
    fine = np.linspace(0.0, STEP, 21)
    places, at = [], (57.0, 179.99)
    for start in t:
        psi = 0.7 + 0.5 * np.sin(0.05 * start)
        bow = Geodesic.WGS84.Direct(*at, math.degrees(psi), antenna)
        places.append((bow["lat2"], bow["lon2"]))
        angle = 0.7 + 0.5 * np.sin(0.05 * (start + fine))
        side = 0.8 * np.sin(0.05 * (start + fine) + 1.0)
        north = np.trapezoid(ahead * np.cos(angle) - side * np.sin(angle) + current[1], fine)
        east = np.trapezoid(ahead * np.sin(angle) + side * np.cos(angle) + current[0], fine)
        moved = Geodesic.WGS84.Direct(
            *at, math.degrees(math.atan2(east, north)), math.hypot(east, north)
        )
        at = (moved["lat2"], moved["lon2"])
    helm = 5.0 * np.sign(np.sin(0.21 * t))
    return t, helm, np.degrees(heading), np.array(places), sway


def write(folder: Path, run: Any, cells: Any, **more: str) -> Any:
    """Write a track and its study; return what is observed."""
    t, helm, gyro, places, _ = run
    rows = [
        f"{a},{b},{c},{cells(*place)}" for a, b, c, place in zip(t, helm, gyro, places, strict=True)
    ]
    (folder / "track.csv").write_text("\n".join(["t,helm,gyro,lat,lon", *rows]) + "\n")
    texts = {"more": "", "unit": "deg", "tables": ""} | more
    (folder / "study.toml").write_text(STUDY.format(**texts))
    return observe_record(load_study(folder / "study.toml"))


def plain(latitude: float, longitude: float) -> str:
    return f"{latitude:.9f},{longitude:.9f}"


def nautical(latitude: float, longitude: float) -> str:
    """Return degrees and minutes as instruments write them: 5412.3456789 and -17959.9."""
    parts = []
    for angle in (latitude, longitude):
        whole = int(abs(angle))
        minutes = 60.0 * (abs(angle) - whole)
        parts.append(f"{'-' if angle < 0 else ''}{whole:02d}{minutes:010.7f}")
    return ",".join(parts)


def spoken(latitude: float, longitude: float) -> str:
    """Return degrees, minutes and the half of the Earth: 54° 12.3456789' N."""
    found = []
    for angle, halves in ((latitude, "NS"), (longitude, "EW")):
        whole = int(abs(angle))
        half = halves[0] if angle >= 0 else halves[1]
        found.append(f"{whole}° {60.0 * (abs(angle) - whole):.7f}' {half}")
    return ",".join(found)


@pytest.mark.parametrize(("cells", "unit"), [(plain, "deg"), (nautical, "ddmm"), (spoken, "deg")])
def test_a_track_gives_sway_and_yaw_rate(tmp_path: Path, cells: Any, unit: str) -> None:
    run = sailed()
    found = write(tmp_path, run, cells, unit=unit)
    record, sway = found, run[-1]
    assert record.sway[2:-2] == pytest.approx(sway[2:-2], abs=2e-3)
    rate = 0.025 * np.cos(0.05 * record.t)
    assert record.yaw_rate[2:-2] == pytest.approx(rate[2:-2], abs=1e-5)
    assert "sway" in load_study(tmp_path / "study.toml").channels
    assert any("sway is that of this track, over the ground" in str(f) for f in found.findings)


def test_antenna_and_current_are_taken_off(tmp_path: Path) -> None:
    run = sailed(antenna=25.0, current=(1.0, -0.5))
    tables = (
        "\n[track]\nantenna_m = 25\n"
        f"current_east_kn = {1.0 / KNOT}\ncurrent_north_kn = {-0.5 / KNOT}\n"
    )
    found = write(tmp_path, run, plain, tables=tables)
    assert found.sway[2:-2] == pytest.approx(run[-1][2:-2], abs=2e-3)
    left = write(tmp_path, run, plain).sway - run[-1]
    assert np.nanmax(np.abs(left)) > 0.5


@pytest.mark.parametrize("latitude", [-70.0, 0.0, 35.0, 80.0])
def test_velocities_are_those_of_geodesics(latitude: float) -> None:
    t = np.arange(9.0)
    track = [Geodesic.WGS84.Direct(latitude, 10.0, 60.0, 5.0 * (one - 4.0)) for one in t]
    latitudes, longitudes = (np.radians([one[key] for one in track]) for key in ("lat2", "lon2"))
    east, north = ground_velocity(latitudes, longitudes, 1.0)
    assert east[4] == pytest.approx(5.0 * math.sin(math.radians(60.0)), rel=1e-5)
    assert north[4] == pytest.approx(5.0 * math.cos(math.radians(60.0)), rel=1e-5)


def test_a_track_that_gives_no_sway_is_refused_where_the_model_needs_it_else_told(
    tmp_path: Path,
) -> None:
    run = sailed()
    write(tmp_path, run, plain)
    path = tmp_path / "study.toml"
    text = path.read_text()
    heading = '[[columns]]\nchannel = "heading"\ncolumn = "gyro"\nunit = "deg"\n'
    sway = '\n[[columns]]\nchannel = "sway"\ncolumn = "helm"\nunit = "kn"\n'
    model = '[ship]\nlength_m = 100\nspeed_kn = 12\n[model]\nkind = "2"\noutputs = ["sway"]\n'
    for study, wrong in (
        (text.replace(heading, ""), "no heading was recorded"),
        (text + sway, "has both helm and a track: take one"),
    ):
        path.write_text(study)
        told = list(map(str, observe_record(load_study(path)).findings))
        assert any(f"lat: no sway is made of this track: {wrong}" in one for one in told), told
        path.write_text(study + model)
        with pytest.raises(ConfigError, match=wrong):
            observe_record(load_study(path))


def test_a_track_read_in_each_fifth_row_gives_the_sway_of_its_fixes(tmp_path: Path) -> None:
    t, helm, heading, places, sway = sailed()
    held = np.arange(COUNT) // 4 * 4
    record = write(tmp_path, (t, helm, heading, places[held], sway), plain)
    fixes = np.flatnonzero(np.isfinite(record.sway))
    assert (np.diff(fixes) == 4).all()
    assert record.sway[fixes] == pytest.approx(sway[fixes], abs=2e-2)


@pytest.mark.parametrize(
    ("text", "unit", "degrees"),
    [
        ("54.5", "deg", 54.5),
        ("-54.5", "deg", -54.5),
        ("S54.5", "deg", -54.5),
        ("54 30,0 N", "deg", 54.5),
        ("54-30.0 S", "deg", -54.5),
        ("54°29'30\"W", "deg", -54.0 - 29.5 / 60.0),
        ("5430.0", "ddmm", 54.5),
        ("-00030.0", "ddmm", -0.5),
        ("05430.0W", "ddmm", -54.5),
        ("1.5", "rad", 1.5),
        ("", "deg", math.nan),
    ],
)
def test_an_angle_is_read_as_it_is_written(
    tmp_path: Path, text: str, unit: str, degrees: float
) -> None:
    (tmp_path / "a.csv").write_text(f"t;lat\n0;{text}\n1;2\n")
    table = read_table(tmp_path / "a.csv")
    assert table.angles(1, unit)[0] == pytest.approx(degrees, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("5430.0", r'row 2: lat = "5430.0": must be at most 180, .*"ddmm" is degrees and minutes'),
        ("54 60.0 N", r"minutes below 60"),
        ("north", r"must be a number"),
    ],
)
def test_an_angle_that_is_none_is_refused_by_row(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "a.csv").write_text(f"t;lat\n0;{text}\n1;2\n")
    with pytest.raises(ConfigError, match=told):
        read_table(tmp_path / "a.csv").angles(1, "deg")
