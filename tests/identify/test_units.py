"""Units in brackets: known ones are read, all others are refused by name with those known."""

import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.boat_trials import estimated_boat, made_trial, write_csv

from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.tables import read_table
from trainer.config.units import KNOWN_UNITS, spell_unit
from trainer.identify.boat.instruments import instruments_of
from trainer.identify.boat.prior import read_prior
from trainer.identify.boat.trial import read_trial
from trainer.identify.record.columns import BOAT_WORDS, CHANNEL_WORDS, guess_columns
from trainer.identify.record.sources import Column, column_said, read_record
from trainer.units import DEGREE

COUNT = 60
TIMES = np.arange(COUNT, dtype=float)
ANGLES = 10.0 * np.sin(0.1 * TIMES)


def table(folder: Path, *heads: str, cells: str = "{t:g},{angle:.4f},{angle:.4f}") -> Path:
    """Write a file of times, and angles under two headings."""
    path = folder / "log.csv"
    rows = [cells.format(t=t, angle=angle) for t, angle in zip(TIMES, ANGLES, strict=True)]
    path.write_text("\n".join([",".join(heads), *rows]) + "\n", encoding="utf-8")
    return path


def read(path: Path, channel: str) -> np.ndarray:
    """Return a channel as it is guessed and read."""
    found = guess_columns(read_table(path), BOAT_WORDS).columns
    return np.asarray(getattr(read_record(path, found), channel))


@pytest.mark.parametrize(
    ("head", "channel", "size"),
    [
        ("rudder [gon]", "rudder", math.pi / 200.0),
        ("rudder (mil)", "rudder", math.pi / 3200.0),
        ("heading [mrad]", "heading", 1e-3),
        ("heading [deg true]", "heading", DEGREE),
        ("yaw rate [deg/h]", "yaw_rate", DEGREE / 3600.0),
        ("yaw rate [°/min]", "yaw_rate", DEGREE / 60.0),
        ("speed [km/h]", "speed", 1.0 / 3.6),
        ("log (mph)", "speed", 0.44704),
        ("speed [ft/s]", "speed", 0.3048),
        ("speed [cm s-1]", "speed", 0.01),
        ("depth [feet]", "depth", 0.3048),
        ("depth [fathoms]", "depth", 1.8288),
        ("rpm [1/min]", "revolutions", 1.0 / 60.0),
    ],
)
def test_a_unit_in_brackets_is_read(tmp_path: Path, head: str, channel: str, size: float) -> None:
    path = table(tmp_path, "time [s]", head, "other")
    assert read(path, channel) == pytest.approx(size * np.round(ANGLES, 4))


@pytest.mark.parametrize(
    ("head", "said", "known"),
    [
        ("rudder [grains]", "grains", ":rad, :gon, :mil, :mrad, :cdeg"),
        ("heading (true)", "true", ":rad, :gon"),
        ("speed [furlong/h]", "furlong/h", ":m/s, :km/h, :mph, :ft/s, :cm/s"),
        ("depth [kn]", "kn", ":ft, :fathom, :cm"),
        ("heading [deg/s]", "deg/s", ":rad"),
        ("time [kn]", "kn", ":ms, :us, :min, :h"),
    ],
)
def test_what_is_no_unit_of_the_channel_is_refused_with_those_known(
    tmp_path: Path, head: str, said: str, known: str
) -> None:
    heads = (head, "rudder [deg]", "b") if head.startswith("time") else ("t [s]", head, "b")
    with pytest.raises(ConfigError) as wrong:
        guess_columns(read_table(table(tmp_path, *heads)), BOAT_WORDS)
    assert f'the file says "{said}"' in str(wrong.value)
    assert known in str(wrong.value)


@pytest.mark.parametrize("unit", ["%", "counts", "V", "us", "-"])
def test_a_gauge_that_says_no_angle_needs_a_scale(tmp_path: Path, unit: str) -> None:
    path = table(tmp_path, "time [s]", f"rudder [{unit}]", "heading [deg]")
    with pytest.raises(ConfigError, match=r"rudder.*:deg\*0.35 where 100 are 35 deg"):
        guess_columns(read_table(path), CHANNEL_WORDS)
    head = f"rudder [{unit}]"
    with pytest.raises(ConfigError, match=r'unit = "deg" and scale = 0\.35'):
        read_record(path, {"t": Column("time", "s"), "rudder": Column(head, "deg")})
    told = {"rudder": column_said(f"{head}:deg*0.5-2")}
    found = guess_columns(read_table(path), CHANNEL_WORDS, told).columns
    record = read_record(path, found)
    assert record.rudder == pytest.approx(DEGREE * (0.5 * np.round(ANGLES, 4) - 2.0))


@pytest.mark.parametrize("head", ["rudder (actual)", "rudder (delta)", "Rudder"])
def test_a_name_in_brackets_is_no_unit(tmp_path: Path, head: str) -> None:
    found = guess_columns(read_table(table(tmp_path, "time [s]", head, "b")), CHANNEL_WORDS)
    assert found.columns["rudder"].unit == "deg"
    assert "rudder" in found.unsure


def test_every_known_unit_is_spelled_as_it_is_known() -> None:
    assert {spell_unit(one) for one in KNOWN_UNITS} == KNOWN_UNITS


def test_a_study_of_an_unknown_unit_is_not_written(tmp_path: Path) -> None:
    path = table(tmp_path, "time [s]", "rudder [%]", "heading [deg]")
    done = CliRunner().invoke(cli, ["identify", "new", str(path), "--length", "12"])
    assert done.exit_code != 0
    assert "--column rudder=rudder:deg*0.35" in f"{done.exception} {done.output}"
    assert not path.with_suffix(".toml").exists()
    told = ["--column", "rudder=rudder [%]:deg*0.35"]
    done = CliRunner().invoke(cli, ["identify", "new", str(path), "--length", "12", *told])
    assert done.exit_code == 0, done.output
    assert 'unit = "deg"\nscale = 0.35\n' in path.with_suffix(".toml").read_text(encoding="utf-8")
    seen = CliRunner().invoke(cli, ["identify", str(path.with_suffix(".toml")), "--data-only"])
    assert seen.exit_code == 0, seen.output


def test_a_boats_record_is_refused_by_its_unit_and_read_by_the_option(tmp_path: Path) -> None:
    vessel = read_prior(str(estimated_boat(tmp_path))).vessel
    made = made_trial(vessel, read_prior(str(tmp_path / "own.toml")).values)
    path = write_csv(tmp_path / "trial.csv", made, vessel.file.propulsion.rps_per_mps)
    plain = read_trial(path, vessel)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("rudder [deg]", "rudder [%]"), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"--columns rudder=rudder:deg\*0.35"):
        read_trial(path, vessel)
    read = read_trial(path, vessel, instruments_of(["rudder=rudder [%]:deg*0.5"], []))
    assert read.inputs[:, 0] == pytest.approx(0.5 * plain.inputs[:, 0])
    path.write_text(text.replace("depth [m]", "depth [kn]"), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"depth for depth: the file says \"kn\""):
        read_trial(path, vessel)
