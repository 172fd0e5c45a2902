"""Records for identification: what is read, refused and warned of, by column and row."""

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


def table(rudder: Any = None) -> Any:
    """Return columns of a trial in degrees, seconds and degrees a minute."""
    helm = hold_bits(prbs(5), 5.0, 4)[:120] if rudder is None else rudder
    rate = turned(helm)
    heading = 90.0 + np.concatenate([[0.0], np.cumsum(5.0 * 0.5 * (rate[1:] + rate[:-1]))])
    t = 5.0 * np.arange(len(helm))
    return {"time": t, "helm": helm, "rot": 60.0 * rate, "gyro": np.mod(heading, 360.0)}


def write(path: Any, columns: Any, text: Any = STUDY) -> Any:
    """Write a trial and its study to a folder; return the study's path."""
    names = list(columns)
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(names), *(",".join(cell(x) for x in row) for row in rows)]
    (path / "trial.csv").write_text("\n".join(lines) + "\n")
    (path / "trial.toml").write_text(text)
    return path / "trial.toml"


def cell(value: Any) -> Any:
    return "" if isinstance(value, float) and math.isnan(value) else f"{value}"


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


def test_a_good_record_raises_no_finding(tmp_path: Path) -> None:
    assert observed(tmp_path, table()).findings == ()


def test_a_repeated_time_is_refused_by_row(tmp_path: Path) -> None:
    columns = table()
    columns["time"][40] = columns["time"][39]
    # row 1 is the heading, so that sample 40 stands in row 42
    with pytest.raises(ConfigError, match=r"row 42: time = 195 s is repeated"):
        observed(tmp_path, columns)
    columns["time"][40] = 3.0
    with pytest.raises(ConfigError, match=r"row 42: time = 3 s is before 195 s"):
        observed(tmp_path, columns)


def test_a_gap_is_told_with_its_length(tmp_path: Path) -> None:
    columns = {name: np.delete(values, slice(50, 53)) for name, values in table().items()}
    texts = [str(finding) for finding in observed(tmp_path, columns).findings]
    assert texts == ["row 52: time: 20 s have passed, the interval is 5 s"]


def test_uneven_times_are_told(tmp_path: Path) -> None:
    columns = table()
    columns["time"] = columns["time"] + np.where(np.arange(120) == 60, 1.0, 0.0)
    texts = [str(finding) for finding in observed(tmp_path, columns).findings]
    assert any("row 62: time: 6 s have passed" in text and "varies" in text for text in texts)


def test_missing_readings_are_told_and_kept_as_missing(tmp_path: Path) -> None:
    columns = table()
    columns["rot"][[7, 8]] = math.nan
    found = observed(tmp_path, columns)
    assert [str(f) for f in found.findings] == [
        "row 9: rot: 2 of 120 values are missing, the first here"
    ]
    assert np.isnan(found.yaw_rate).sum() == 2


def test_a_missing_rudder_is_refused_by_row(tmp_path: Path) -> None:
    columns = table()
    columns["helm"][10] = math.nan
    with pytest.raises(ConfigError, match=r"trial.csv: row 12: helm: .* it is empty"):
        observed(tmp_path, columns)


def test_words_in_a_column_of_numbers_are_refused_by_row_and_column(tmp_path: Path) -> None:
    path = write(tmp_path, table())
    data = tmp_path / "trial.csv"
    lines = data.read_text().split("\n")
    lines[3] = lines[3].replace(lines[3].split(",")[1], "port")
    data.write_text("\n".join(lines))
    with pytest.raises(ConfigError, match=r'row 4: helm = "port": must be a number'):
        observe_record(load_study(path))


def test_a_rudder_at_rest_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"helm: stands at 2 deg in all rows"):
        observed(tmp_path, table(np.full(120, 2.0)))


def test_degrees_said_to_be_radians_are_refused_by_row(tmp_path: Path) -> None:
    text = STUDY.replace('column = "helm"\nunit = "deg"', 'column = "helm"\nunit = "rad"')
    with pytest.raises(
        ConfigError, match=r"row 2: helm = .-5.0.: no rudder in rad is so large; are these degrees"
    ):
        observed(tmp_path, table(), text)


def test_radians_said_to_be_degrees_are_told(tmp_path: Path) -> None:
    columns = table()
    columns["helm"] = np.radians(columns["helm"])
    texts = [str(finding) for finding in observed(tmp_path, columns).findings]
    assert any("helm" in text and "is it radians?" in text for text in texts)


def test_a_rate_that_is_not_that_of_the_heading_is_refused(tmp_path: Path) -> None:
    text = STUDY.replace('unit = "deg/min"', 'unit = "deg/s"')
    with pytest.raises(ConfigError, match=r"rot and gyro: .* per minute"):
        observed(tmp_path, table(), text)
    columns = table()
    columns["rot"] = -columns["rot"]
    with pytest.raises(ConfigError, match=r"positive to port"):
        observed(tmp_path, columns)


def test_a_rudder_of_the_other_sign_is_told_and_can_be_turned(tmp_path: Path) -> None:
    columns = table()
    columns["helm"] = -columns["helm"]
    texts = [str(finding) for finding in observed(tmp_path, columns).findings]
    assert any('say positive_rudder = "starboard"' in text for text in texts)
    text = STUDY.replace("[[columns]]", 'positive_rudder = "starboard"\n\n[[columns]]', 1)
    found = observed(tmp_path, columns, text)
    assert found.findings == ()
    assert found.rudder == pytest.approx(-np.radians(columns["helm"]))


def test_a_helmsman_without_an_experiment_is_told(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    rate, heading, rudder = np.zeros(200), np.zeros(200), np.zeros(200)
    for i in range(199):
        rudder[i] = 2.0 * heading[i] + 8.0 * rate[i]
        rate[i + 1] = 0.8 * rate[i] - 0.01 * rudder[i] + 0.05 * rng.standard_normal()
        heading[i + 1] = heading[i] + 5.0 * rate[i]
    rudder[-1] = 2.0 * heading[-1] + 8.0 * rate[-1]
    columns = {"time": 5.0 * np.arange(200), "helm": rudder, "rot": 60.0 * rate, "gyro": heading}
    texts = [str(finding) for finding in observed(tmp_path, columns).findings]
    assert any("closed loop without an experiment" in text for text in texts)


def test_a_sequence_beside_the_helmsman_ends_the_warning(tmp_path: Path) -> None:
    record = observed(tmp_path, table())
    assert follows_motion(record) < 0.9  # type: ignore[operator]


def test_a_column_that_is_not_there_is_named_with_the_nearest(tmp_path: Path) -> None:
    text = STUDY.replace('column = "gyro"', 'column = "gyros"')
    with pytest.raises(ConfigError, match=r'no column "gyros" for heading; nearest is gyro'):
        observed(tmp_path, table(), text)


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


def test_a_constant_output_is_told(tmp_path: Path) -> None:
    columns = table()
    columns["rot"] = np.zeros(120)
    found = observed(tmp_path, columns)
    assert [f.text for f in found.findings] == ["is the same in all rows: is it recorded?"]


def test_an_output_without_any_value_is_refused(tmp_path: Path) -> None:
    columns = table()
    columns["rot"] = np.full(120, math.nan)
    with pytest.raises(ConfigError, match="rot: has no value at all"):
        observed(tmp_path, columns)


def test_examination_needs_a_rudder(tmp_path: Path) -> None:
    write(tmp_path, table())
    record = load_record(tmp_path / "trial.csv", {"yaw_rate": Column("rot", "deg/s")})
    with pytest.raises(ConfigError, match="no rudder was recorded; there is yaw_rate"):
        examine_record(record)
