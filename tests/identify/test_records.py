"""Records for identification: what is read of them; test_spoilt_records.py has their faults."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.studies import columns

from trainer.config.files import ConfigError
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.record.findings import examine_record, follows_motion, unwrap_heading
from trainer.identify.record.sources import Column, factor, load_record, own_columns
from trainer.identify.record.study import load_study, observe_record, plain_study, speed_of

STUDY = """
schema = "identify/1"
name = "sea trial"
data = "trial.csv"

""" + columns(t="time s", rudder="helm deg", yaw_rate="rot deg/min", heading="gyro deg")


def turned(rudder: Any, gain: Any = -0.05, constant: Any = 20.0, step: Any = 5.0) -> Any:
    """Return the yaw rate of a first-order ship, in the unit of the rudder a second."""
    rate, p = np.zeros_like(rudder), math.exp(-step / constant)
    for i in range(len(rudder) - 1):
        rate[i + 1] = p * rate[i] + gain * (1.0 - p) * rudder[i]
    return rate


def table() -> Any:
    """Return columns of a trial in degrees, seconds and degrees a minute."""
    helm = hold_bits(prbs(5), 5.0, 4)[:120]
    rate = turned(helm)
    heading = 90.0 + np.concatenate([[0.0], np.cumsum(5.0 * 0.5 * (rate[1:] + rate[:-1]))])
    t = 5.0 * np.arange(len(helm))
    return {"time": t, "helm": helm, "rot": 60.0 * rate, "gyro": np.mod(heading, 360.0)}


def write(path: Any, columns: Any, text: Any = STUDY) -> Any:
    """Write a trial and its study to a folder; return the study's path."""
    names = list(columns)
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(names), *(",".join(map(str, row)) for row in rows)]
    (path / "trial.csv").write_text("\n".join(lines) + "\n")
    (path / "trial.toml").write_text(text)
    return path / "trial.toml"


def observed(path: Any, columns: Any, text: Any = STUDY) -> Any:
    return observe_record(load_study(write(path, columns, text)))


def test_units_become_si_and_the_heading_does_not_jump(tmp_path: Path) -> None:
    columns = table()
    columns["gyro"] = np.mod(columns["gyro"] + 265.0, 360.0)
    found = observed(tmp_path, columns)
    record = found
    assert record.rudder == pytest.approx(np.radians(columns["helm"]))
    assert record.yaw_rate == pytest.approx(np.radians(columns["rot"] / 60.0))
    assert np.abs(np.diff(record.heading)).max() < 0.2
    assert any("unwrapped" in str(finding) for finding in found.findings)


def test_a_sequence_beside_the_helmsman_ends_the_warning(tmp_path: Path) -> None:
    record = observed(tmp_path, table())
    assert follows_motion(record) < 0.9  # type: ignore[operator]


def test_a_unit_of_another_quantity_is_refused(tmp_path: Path) -> None:
    text = STUDY.replace('unit = "deg/min"', 'unit = "kn"')
    with pytest.raises(
        ConfigError, match=r"columns\[2\]\] yaw_rate: unit \"kn\": must be rad/s or"
    ):
        observed(tmp_path, table(), text)
    with pytest.raises(ConfigError, match="must be s or ms"):
        factor("t", "fortnight")


def test_a_study_tells_all_that_is_wrong_with_it(tmp_path: Path) -> None:
    text = STUDY.replace('name = "sea trial"', 'nmae = "sea trial"').replace("helm", "helm ")
    text += '\n[model]\nkind = "4"\noutputs = ["heading"]\n\n[armax]\noutput = "rudder"\n'
    with pytest.raises(ConfigError) as wrong:
        load_study(write(tmp_path, table(), text))
    told = str(wrong.value)
    for part in ("nmae", "nearest is name", "lacks name", "[model] kind", "[armax] output"):
        assert part in told


def test_a_model_needs_a_ship_and_logs_need_their_places(tmp_path: Path) -> None:
    model = '\n[model]\nkind = "1"\noutputs = ["bow_sway", "yaw_rate"]\n'
    with pytest.raises(ConfigError, match=r"\[model\] needs a \[ship\]"):
        load_study(write(tmp_path, table(), STUDY + model))
    ship = "\n[ship]\nlength_m = 100\n"
    ship_alone = STUDY + '[ship]\n[model]\nkind = "nomoto1"\noutputs = ["yaw_rate"]\n'
    with pytest.raises(ConfigError) as lacking:
        observed(tmp_path, table(), ship_alone)
    assert str(lacking.value) == "trial.toml: [ship] lacks length_m"
    other_form = 'schema = "nomoto/1"\n[ship]\nlength = 300\n'
    with pytest.raises(ConfigError) as other:  # and no word of its keys
        observed(tmp_path, table(), other_form)
    assert str(other.value) == 'trial.toml: schema = "nomoto/1": must be identify/1'
    with pytest.raises(ConfigError, match="bow_sway needs bow_log_m"):
        load_study(write(tmp_path, table(), STUDY + model + ship))


def test_part_of_a_record_is_taken_and_thinned_with_the_mean_of_the_helm(tmp_path: Path) -> None:
    text = STUDY.replace("[[columns]]", "from_s = 100\nto_s = 400\nevery = 2\n\n[[columns]]", 1)
    columns = table()
    record = observed(tmp_path, columns, text)
    assert record.t[0] == 100.0
    assert record.t[-1] == 400.0
    assert record.interval == 10.0
    assert record.rudder[0] == pytest.approx(np.radians(columns["helm"][20:22].mean()))


def test_the_trainers_own_file_needs_no_columns(tmp_path: Path) -> None:
    data = tmp_path / "out.csv"
    rows = [f"{t},{0.1 * (-1) ** (t // 4)},0.0,0.0,0.0,5.0" for t in range(40)]
    data.write_text("t,delta_r,psi,r,v,u\n" + "\n".join(rows) + "\n")
    record = load_record(data, own_columns())
    assert record.channels == ("rudder", "heading", "yaw_rate", "sway", "speed")
    study = plain_study(data)
    assert speed_of(study, record) == 5.0


def test_without_times_rows_are_counted_by_the_interval_said(tmp_path: Path) -> None:
    times = '[[columns]]\nchannel = "t"\ncolumn = "time"\nunit = "s"\n'
    text = STUDY.replace(times, "")
    text = text.replace("[[columns]]", "interval_s = 5\n\n[[columns]]", 1)
    assert observed(tmp_path, table(), text).t[3] == 15.0


def test_a_wrapped_heading_is_unwrapped_across_what_is_missing(tmp_path: Path) -> None:
    columns = table()
    heading = np.radians(columns["gyro"])
    heading[30] = math.nan
    write(tmp_path, columns)
    record = load_record(tmp_path / "trial.csv", {"rudder": Column("helm", "deg")})
    found = unwrap_heading(replace(record, heading=np.mod(heading + 4.7, math.tau)))
    known = found.heading[~np.isnan(found.heading)]  # type: ignore[arg-type, index]
    assert np.abs(np.diff(known)).max() < 1.0


def test_examination_needs_a_rudder(tmp_path: Path) -> None:
    write(tmp_path, table())
    record = load_record(tmp_path / "trial.csv", {"yaw_rate": Column("rot", "deg/s")})
    with pytest.raises(ConfigError, match="no rudder was recorded; there is yaw_rate"):
        examine_record(record)
