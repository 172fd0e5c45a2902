"""Decca: lanes to places, places to sway velocity, against the golden vectors."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.decca_run import CASES, CHAIN, TRACK, write_run
from helpers.typed import type_command

from trainer.cli.workshop.identify import decca
from trainer.config.files import ConfigError
from trainer.identify.pages.decca import (
    Point,
    Slave,
    SlaveRow,
    fixes,
    lane_at,
    lane_number,
    load_decca,
    resolve_lane,
    solve_track,
    track,
    write_track,
)
from trainer.identify.record.sources import Column, load_record, own_columns
from trainer.identify.record.track import (
    SPENCER_WEIGHTS,
    derivative,
    even_interval,
    resolve_along,
    smooth_spencer,
)


@pytest.mark.parametrize("case", CASES["lanes"], ids=lambda case: case["colour"])
def test_a_reading_counts_the_lanes_from_zone_a(case: Any) -> None:
    text = f"{case['zone']}{case['lane']}"
    assert lane_number(case["colour"], text) == pytest.approx(case["numerical"], abs=1e-9)


def test_two_lanes_of_the_base_line_are_as_wide_as_the_file_says() -> None:
    slave = Slave(Point(9000.0, 0.0), 600.0)
    assert [lane_at(slave, Point(x, 0.0)) for x in (0.0, 300.0, 600.0)] == [0.0, 1.0, 2.0]
    described = {each.name: each.metadata for each in dataclasses.fields(SlaveRow)}["lane_m"]
    assert "twice a lane's width" in str(described)


def test_a_lane_that_the_zone_does_not_have_is_refused() -> None:
    with pytest.raises(ConfigError, match="zones of green have lanes 30 to 47"):
        lane_number("green", "B12.5")
    with pytest.raises(ConfigError, match="must be a zone A to J"):
        lane_number("red", "K3")


def test_names_that_come_again_are_told_apart_by_the_place() -> None:
    assert resolve_lane("red", 84.34, 330.0) == pytest.approx(84.34 + 240.0)
    assert resolve_lane("red", 84.34, 80.0) == pytest.approx(84.34)


@pytest.mark.parametrize("case", CASES["points"])
def test_places_have_the_lanes_and_lanes_the_places(case: Any) -> None:
    ship = Point(*case["P"])
    lanes = {colour: lane_at(slave, ship) for colour, slave in CHAIN.items()}
    assert lanes == pytest.approx(case["lanes"], abs=1e-9)
    found = fixes(CHAIN["red"], CHAIN["green"], (lanes["red"], lanes["green"]))
    expected = [Point(*place) for place in case["from_red_green"]]
    assert len(found) == len(expected)
    for place in expected:
        assert min(math.dist(place, one) for one in found) < 1e-6


def test_stations_in_a_line_give_no_fix() -> None:
    line = Slave(Point(1000.0, 2000.0), 800.0), Slave(Point(-2000.0, -4000.0), 800.0)
    with pytest.raises(ConfigError, match="in one line"):
        fixes(*line, (1.0, 1.0))


def test_a_track_takes_the_nearer_of_two_places_and_the_colours_that_cross_best() -> None:
    near = Point(-49722.1, -31582.7)
    readings = [
        {c: lane_at(s, Point(near.x + 50.0 * i, near.y)) for c, s in CHAIN.items()}
        for i in range(5)
    ]
    found = track(CHAIN, readings, near)
    for i, fix in enumerate(found):
        assert math.dist(fix.location, (near.x + 50.0 * i, near.y)) < 1e-3
    # red and green cross at a small angle there: another pair is taken
    assert set(found[0].colours) != {"red", "green"}


def test_a_missing_colour_leaves_the_other_two_and_one_alone_leaves_no_fix() -> None:
    ship = Point(20000.0, 15000.0)
    lanes = {c: lane_at(s, ship) for c, s in CHAIN.items()}
    found = track(CHAIN, [lanes | {"red": math.nan}, {"green": lanes["green"]}], ship)
    assert math.dist(found[0].location, ship) < 1e-6
    assert not found[1].colours


def sway_of_track(x: Any, y: Any, turned: Any) -> Any:
    return resolve_along(derivative(y, TRACK["h"]), derivative(x, TRACK["h"]), turned)[1]


def test_sway_of_a_known_track_is_found_by_five_points() -> None:
    x, y, psi = (np.array(TRACK[key]) for key in ("x0", "y0", "psi"))
    found = sway_of_track(x, y, psi)
    expected = np.array(TRACK["v_five_point"], float)
    assert found == pytest.approx(expected, abs=1e-12, nan_ok=True)
    assert found[2:-2] == pytest.approx(np.array(TRACK["v_true"])[2:-2], abs=5e-5)


def test_spencers_points_smooth_as_published_and_keep_cubics() -> None:
    x, y, psi = (np.array(TRACK[key]) for key in ("x0", "y0", "psi"))
    found = sway_of_track(smooth_spencer(x), smooth_spencer(y), psi)
    assert found == pytest.approx(np.array(TRACK["v_smoothed"], float), abs=1e-12, nan_ok=True)
    t = np.linspace(-3.0, 3.0, 40)
    cubic = 1.0 + t - 2.0 * t**2 + 0.5 * t**3
    assert smooth_spencer(cubic)[7:-7] == pytest.approx(cubic[7:-7], abs=1e-12)
    assert SPENCER_WEIGHTS.tolist() == pytest.approx(CASES["spencer"]["weights"])


def test_the_derivative_is_of_fourth_order() -> Any:
    def error(h: Any) -> Any:
        t = np.arange(0.0, 4.0 + h / 2, h)
        return np.nanmax(np.abs(derivative(np.sin(t), h) - np.cos(t)))

    assert np.log2(error(0.1) / error(0.05)) == pytest.approx(4.0, abs=0.1)


def test_uneven_times_have_no_derivative() -> None:
    with pytest.raises(ConfigError, match=r"a\.csv: sample 4: 2 s after the one before"):
        even_interval(np.array([0.0, 1.0, 2.0, 4.0, 5.0]), "a.csv")


def run(tmp_path: Path, antenna: Any = 0.0, extra: Any = "") -> Any:
    """Write lanes of the known track and its study; return the study."""
    return load_decca(write_run(tmp_path, antenna, extra))


def test_lanes_of_a_known_track_give_its_sway_velocity(tmp_path: Path) -> None:
    file = run(tmp_path)
    sailed = solve_track(file, smooth=False)
    true = np.array(TRACK["v_true"])
    assert all(sailed.colours)
    assert len(sailed.colours) == len(true)
    assert sailed.sway[2:-2] == pytest.approx(true[2:-2], abs=1e-4)
    assert sailed.ahead[2:-2] == pytest.approx(np.full(len(true) - 4, TRACK["u"]), abs=1e-2)


def test_an_antenna_ahead_feels_the_yaw_and_is_corrected(tmp_path: Path) -> None:
    file = run(tmp_path, antenna=40.0, extra="\n[ship]\nantenna_m = 40\n")
    sailed = solve_track(file, smooth=False)
    true = np.array(TRACK["v_true"])
    assert sailed.sway[4:-4] == pytest.approx(true[4:-4], abs=2e-4)


def test_a_current_is_taken_off(tmp_path: Path) -> None:
    file = run(tmp_path)
    still = solve_track(file, smooth=False)
    text = (tmp_path / "run.toml").read_text()
    head = "current_east_kn = 1\n\n[[slaves]]"
    (tmp_path / "run.toml").write_text(text.replace("[[slaves]]", head, 1))
    moved = load_decca(tmp_path / "run.toml")
    found = solve_track(moved, smooth=False)
    knot = 1852.0 / 3600.0
    # a current to the east sets a ship heading north to starboard
    assert still.sway[2] - found.sway[2] == pytest.approx(knot * math.cos(still.heading[2]))


def test_the_track_is_written_as_a_record(tmp_path: Path) -> None:
    file = run(tmp_path)
    sailed = solve_track(file, smooth=False)
    write_track(sailed, tmp_path / "sway.csv")
    record = load_record(
        tmp_path / "sway.csv",
        {"t": Column("t", "s"), "sway": Column("v", "m/s"), "heading": Column("psi", "rad")},
    )
    assert record.sway == pytest.approx(sailed.sway, nan_ok=True)


@pytest.mark.parametrize(("side", "sign"), [("port", 1.0), ("starboard", -1.0)])
def test_the_track_with_a_rudder_is_a_record_to_identify(
    tmp_path: Path, side: str, sign: float
) -> None:
    file = run(tmp_path)
    lines = (tmp_path / "lanes.csv").read_text().splitlines()
    helm = [5.0 * (-1.0) ** (i // 9) for i in range(len(lines) - 1)]
    rows = [f"{line},{angle}" for line, angle in zip(lines[1:], helm, strict=True)]
    (tmp_path / "lanes.csv").write_text("\n".join([f"{lines[0]},helm", *rows]) + "\n")
    study = (tmp_path / "run.toml").read_text() + '\n[columns]\nrudder_deg = "helm"\n'
    study = study.replace("[[slaves]]", f'positive_rudder = "{side}"\n\n[[slaves]]', 1)
    (tmp_path / "run.toml").write_text(study)
    file = load_decca(tmp_path / "run.toml")
    sailed = solve_track(file, smooth=False)
    write_track(sailed, tmp_path / "sway.csv")
    record = load_record(tmp_path / "sway.csv", own_columns())
    assert record.channels == ("rudder", "heading", "yaw_rate", "sway", "speed")
    assert record.rudder == pytest.approx(sign * np.radians(helm))
    assert record.sway == pytest.approx(sailed.sway, nan_ok=True)


def test_lanes_may_stand_between_semicolons(tmp_path: Path) -> None:
    plain = solve_track(run(tmp_path), smooth=False)
    data = tmp_path / "lanes.csv"
    data.write_text(data.read_text().replace(",", ";").replace(".", ","))
    found = solve_track(load_decca(tmp_path / "run.toml"), smooth=False)
    assert found.east == pytest.approx(plain.east)
    assert found.heading == pytest.approx(plain.heading)


def test_a_wrong_lane_is_refused_by_row(tmp_path: Path) -> None:
    file = run(tmp_path)
    data = tmp_path / "lanes.csv"
    lines = data.read_text().split("\n")
    lines[4] = "15.0,1.0,D99.0,10.0,10.0"
    data.write_text("\n".join(lines))
    with pytest.raises(ConfigError, match=r"lanes\.csv: row 5: red lane \"D99.0\""):
        solve_track(file, smooth=False)


def test_a_study_without_width_or_with_one_slave_is_refused(tmp_path: Path) -> None:
    run(tmp_path)
    path = tmp_path / "run.toml"
    path.write_text(path.read_text().replace("lane_m = 881.3235294117648\n", ""))
    with pytest.raises(ConfigError, match="give one of lane_m, frequency_khz"):
        load_decca(path)


def test_the_command_tells_how_many_rows_have_a_fix(tmp_path: Path) -> None:
    run(tmp_path)
    result = type_command(decca, tmp_path / "run.toml", "--csv", tmp_path / "sway.csv")
    assert "121 of 121 rows have a fix; not smoothed" in result.stdout
    assert (tmp_path / "sway.csv").read_text().startswith("t,east,north,psi,r,v,u")
