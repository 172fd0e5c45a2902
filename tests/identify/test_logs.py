"""Logs of other houses: one known boat is the same in all of them."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from helpers import foreign_logs
from helpers.made_logs import UNITS, MadeLog, fly_boats

from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.units import UNIT_FACTORS
from trainer.identify.record.columns import BOAT_WORDS, CHANNEL_WORDS, guess_file
from trainer.identify.record.evidence import CHANNEL_QUANTITIES
from trainer.identify.record.logs import read_log
from trainer.identify.record.sources import column_said, read_record

LOG = next(one for one in fly_boats(12, 3) if 6.0 < one.length < 14.0)
SERVO_US = {"rudder": "RCOU.C1:deg*-0.075+112.5", "stern": "RCOU.C2:deg*0.075-112.5"}
SERVO = {"rudder": "actuator_servos.control[0]:deg*-30"}
SERVO["stern"] = "actuator_servos.control[1]:deg*30"
ROS = {"rudder": "/fins.rudder:rad", "stern": "/fins.stern:rad", "depth": "/depth.data:m"}
ROS["speed"] = "/log.data:m/s"
ALL = ("rudder", "stern", "heading", "yaw_rate", "pitch", "depth", "speed")
SHIPS = ("rudder", "heading", "yaw_rate", "speed", "pitch")
Write = Callable[[Path, MadeLog], None]
FORMS: dict[str, tuple[Write, dict[str, str], tuple[str, ...], float]] = {  # and largest miss
    "boat.bin": (foreign_logs.write_dataflash, SERVO_US, ALL, 0.04),
    "boat.ulg": (foreign_logs.write_ulog, SERVO, (*ALL[:-1], "ground_speed"), 1e-4),
    "boat.nmea": (foreign_logs.write_nmea, {}, (*SHIPS, "depth"), 0.06),
    "tagged.log": (lambda p, log: foreign_logs.write_nmea(p, log, tagged=True), {}, SHIPS, 0.06),
    "deltas.log": (foreign_logs.write_signal_k, {}, SHIPS, 1e-6),
    "bag": (lambda p, log: foreign_logs.write_bag(p, log, mcap=False), ROS, ALL, 1e-6),
    "mcap": (lambda p, log: foreign_logs.write_bag(p, log, mcap=True), ROS, ALL, 1e-6),
}


def written(folder: Path, form: str) -> Path:
    """Write the boat's log; skip where its library is lacking."""
    if form in ("bag", "mcap"):
        pytest.importorskip("rosbags")
    if form.endswith(".ulg"):
        pytest.importorskip("pyulog")
    FORMS[form][0](folder / form, LOG)
    return folder / form


@pytest.mark.parametrize("form", FORMS)
def test_a_known_boat_is_read_back_with_each_channels_own_readings(
    tmp_path: Path, form: str
) -> None:
    path = written(tmp_path, form)
    _, options, names, room = FORMS[form]
    told = {channel: column_said(text) for channel, text in options.items()}
    record = read_record(path, guess_file(path, BOAT_WORDS, told, "--columns").columns)
    for name in names:
        source = "speed" if name == "ground_speed" else name
        size = UNIT_FACTORS[CHANNEL_QUANTITIES[source]][UNITS[source]]
        values, right = getattr(record, name), LOG.channels[source] * size
        read = np.flatnonzero(np.isfinite(values))
        slow = source in ("depth", "speed") and len(read) < 0.5 * len(LOG.t)
        rows = np.argmin(np.abs(LOG.t[:, None] - record.t[read] + 0.003), axis=0)
        assert len(read) >= len(LOG.t) // (foreign_logs.SLOW_ROWS if slow else 1) - 2
        assert (np.diff(rows) == (foreign_logs.SLOW_ROWS if slow else 1)).all(), name
        off = values[read] - right[rows]
        off = np.angle(np.exp(1j * off)) if name == "heading" else off
        assert np.abs(off).max() <= room * size, name


@pytest.mark.parametrize("form", ["boat.bin", "boat.ulg", "boat.nmea", "deltas.log", "mcap"])
def test_a_log_has_a_study_as_typed_and_its_channels_agree(tmp_path: Path, form: str) -> None:
    path = written(tmp_path, form)
    options = [f"--column rudder={FORMS[form][1]['rudder']}"] if FORMS[form][1] else []
    if form == "mcap":
        options.append(f"--column speed={ROS['speed']}")
    study = tmp_path / "study.toml"
    words = (
        f"identify new {path} --length {LOG.length:.3f} --at {LOG.speed / 0.5144:.3f} -o {study}"
    )
    done = CliRunner().invoke(cli, shlex.split(" ".join([words, *options])))
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    done = CliRunner().invoke(cli, ["identify", str(study), "--data-only", "--json"])
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    (run,) = json.loads(done.output)["runs"]
    assert {one["test"] for one in run["evidence"]} > {"rate against heading", "turning by rudder"}
    assert all(one["agrees"] for one in run["evidence"])


def test_what_a_sounder_tells_is_no_depth_of_a_boat(tmp_path: Path) -> None:
    for form in ("tagged.log", "deltas.log"):
        log = read_log(written(tmp_path, form))
        assert log is not None
        assert any("not a boat's depth: left out" in one for one in log.told)
        assert not any("depth." in one and "environment" in one for one in log.meant)


def test_damaged_sentences_are_counted_and_of_two_compasses_the_oftener_one_is_read(
    tmp_path: Path,
) -> None:
    log = read_log(written(tmp_path, "boat.nmea"))
    assert log is not None
    assert "1 damaged sentences left out" in log.told
    deltas = read_log(written(tmp_path, "deltas.log"))
    assert deltas is not None
    assert any("old.compass" in one and one.startswith("heading:") for one in deltas.told)


def test_of_two_receivers_in_one_message_the_one_in_use_is_read(tmp_path: Path) -> None:
    log = read_log(written(tmp_path, "boat.bin"))
    assert log is not None
    assert log.columns["GPS.Spd"].values.max() < 9.0
    assert "GPS: I 0 of 2" in log.told


def test_a_servo_is_no_angle_until_its_user_says_how_much(tmp_path: Path) -> None:
    path = written(tmp_path, "boat.bin")
    with pytest.raises(ConfigError, match=r"say --column rudder=RCOU\.C1:deg"):
        guess_file(path, CHANNEL_WORDS, {"rudder": column_said("RCOU.C1")})
    with pytest.raises(ConfigError, match=r"no column RCOU\.C9"):
        guess_file(path, CHANNEL_WORDS, {"rudder": column_said("RCOU.C9:deg")})


def test_a_log_without_times_or_cut_short_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.nmea").write_text("$HEHDT,12.0,T*1C\n" * 20)
    with pytest.raises(ConfigError, match="no sentence has a time: RMC, GGA, ZDA or GLL"):
        read_log(tmp_path / "a.nmea")
    pytest.importorskip("rosbags")
    (tmp_path / "b.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(100))
    with pytest.raises(ConfigError, match="cannot be read as a bag"):
        read_log(tmp_path / "b.mcap")


def test_a_runs_own_sentences_give_the_boats_steering(tmp_path: Path) -> None:
    orders = tmp_path / "orders.txt"
    turns = [(20 + 60 * i, "right" if i % 2 else "left") for i in range(9)]
    orders.write_text("".join(f"{t} rudder {side} 10\n" for t, side in turns))
    log, study = tmp_path / "run.nmea", tmp_path / "study.toml"
    words = f"run --headless --duration 10m --speed max --orders {orders} --nmea-record {log}"
    assert CliRunner().invoke(cli, shlex.split(words)).exit_code == 0
    words = f"identify new {log} --length 70.2 --at 10 -o {study}"
    done = CliRunner().invoke(cli, shlex.split(words))
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    assert "heading in INHDT.heading" in done.output
    done = CliRunner().invoke(cli, ["identify", str(study), "--model", "nomoto1", "--json"])
    report = json.loads(done.output)
    found = {row["name"]: row["value"] for row in report["parameters"]}
    assert -0.2 < found["K"] < -0.02
