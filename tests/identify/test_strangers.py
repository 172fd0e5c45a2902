"""Records as strangers' loggers and spreadsheets write them: the right numbers, or a refusal.

Each file of tests/data/strangers is one run of one ship, written in another way.
"""

import math
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.places import DATA
from helpers.ships import SHIP
from helpers.studies import identified, numbers

from trainer.config.files import ConfigError
from trainer.config.ship.ship import ShipColumn
from trainer.config.tables import read_table
from trainer.identify.record.columns import CHANNEL_WORDS, SHIP_WORDS, guess_columns
from trainer.identify.record.frames import arrays_of, columns_of, record_of
from trainer.identify.record.measurements import Record
from trainer.identify.record.proposal import write_proposal
from trainer.identify.record.sources import Column, load_record
from trainer.identify.record.study import load_study, observe_record
from trainer.identify.ships.proposal import write_ship_file
from trainer.identify.ships.records import load_trial

STRANGERS = DATA / "strangers"
TRUE_T, TRUE_T_ERROR = 23.4, 1.0  # [s] of the ship in the files
WHOLE = {"t": "s", "rudder": "deg", "heading": "deg", "yaw_rate": "deg/s", "sway": "kn"}
WHOLE |= {"speed": "kn"}
BARE = {"t": "s", "rudder": "deg", "heading": "deg"}
READ = {
    "comment_top.csv": (WHOLE, "2 lines of comment left out"),
    "sep_line.csv": (WHOLE, 'columns by ";"'),
    "trail_sep2.csv": (WHOLE, "units of row 2"),
    "heading-511-two-rows.csv": (WHOLE, "row 43: gyro: 2 of 199 values are missing"),
    "date-as-rate.csv": (BARE, ""),
    "date-with-utc.csv": (BARE, "times by ISO 8601"),
}
REFUSED = {
    "lastline.csv": r"row 201: has 5 fields, the heading 6: the last line is cut short",
    "thousands_quoted_int.csv": r'row 3: time = "5,000": .* is it 5000 or 5\.000\?',
}


def cells(name: str) -> list[list[str]]:
    """Return the rows of numbers of the file whose heading is wrong in two rows."""
    lines = (STRANGERS / name).read_text().splitlines()
    return [line.split(",") for line in lines if line[:1].isdigit()]


def proposed(folder: Path, name: str, text: str | None = None) -> Any:
    """Return what is proposed for a stranger's file, or for another text of that name."""
    path = folder / name
    path.write_text((STRANGERS / name).read_text() if text is None else text)
    return write_proposal(path, folder / "a.toml", 70.2, 10.0)


def observed(folder: Path) -> Record:
    return observe_record(load_study(folder / "a.toml"))


@pytest.mark.parametrize("text", ["", "\n\n", "# a remark\n"])
def test_an_empty_file_is_called_empty(tmp_path: Path, text: str) -> None:
    with pytest.raises(ConfigError, match=r"a\.csv: is empty; headings of columns belong there"):
        proposed(tmp_path, "a.csv", text)


@pytest.mark.parametrize("name", READ)
def test_a_stranger_s_record_is_the_ship_s_run(tmp_path: Path, name: str) -> None:
    units, told = READ[name]
    found = proposed(tmp_path, name)
    assert {channel: one.unit for channel, one in found.columns.items()} == units
    assert told in "\n".join(found.remarks)
    record = observed(tmp_path)
    true = np.array(cells("heading-511-two-rows.csv"), float)
    known = true[:, 2] < 400.0
    assert record.t == pytest.approx(5.0 * np.arange(199))
    assert record.rudder == pytest.approx(np.radians(true[:, 1]))
    heading = np.mod(np.degrees(record.column("heading")), 360.0)
    assert heading[known] == pytest.approx(true[known, 2])


@pytest.mark.parametrize("name", REFUSED)
def test_a_stranger_s_record_that_has_two_readings_is_refused_by_row(
    tmp_path: Path, name: str
) -> None:
    with pytest.raises(ConfigError, match=REFUSED[name]):
        proposed(tmp_path, name)
    assert not (tmp_path / "a.toml").exists()


def test_thousands_forbid_only_the_use_of_their_column(tmp_path: Path) -> None:
    found = proposed(tmp_path, "rpm_thousands.csv")
    assert found.columns["rudder"].unit == "deg"
    with pytest.raises(ConfigError, match=r'row 2: rpm = "1,000": .* is it 1000 or 1\.000\?'):
        write_ship_file(tmp_path / "rpm_thousands.csv", tmp_path / "ship.toml", 70.2)


def test_times_with_another_word_than_utc_are_refused_and_those_with_it_read(
    tmp_path: Path,
) -> None:
    found = proposed(tmp_path, "utc_suffix.csv")
    assert found.interval == 5.0
    assert "times by ISO 8601" in found.remarks[0]
    wrong = (STRANGERS / "utc_suffix.csv").read_text().replace(" UTC", " Quux")
    (tmp_path / "a.toml").unlink()
    with pytest.raises(ConfigError, match=r'row 2: time = "2021-01-01 00:00:00 Quux"'):
        proposed(tmp_path, "utc_suffix.csv", wrong)


# Not available, written as a number


@pytest.mark.parametrize("rows", [(), (10, 33, 60, 61, 120, 180)], ids=["two rows", "six more"])
def test_a_heading_of_511_does_not_turn_the_ship(tmp_path: Path, rows: tuple[int, ...]) -> None:
    pytest.importorskip("scipy")
    name = "heading-511-two-rows"
    shutil.copy(STRANGERS / f"{name}.toml", tmp_path)
    lines = (STRANGERS / f"{name}.csv").read_text().splitlines()
    for row in rows:
        parts = lines[row].split(",")
        lines[row] = ",".join([*parts[:2], "511", *parts[3:]])
    (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    report = identified(tmp_path / f"{name}.toml")
    assert abs(numbers(report)["T"][0] - TRUE_T) < TRUE_T_ERROR
    assert numbers(report)["K"][0] < 0.0
    told = sorted([43, 44, *(row + 1 for row in rows)])
    assert any(f"rows {', '.join(map(str, told))}" in one for one in report["findings"]), report


def loaded(folder: Path, heading: Any, unit: str = "deg") -> Record:
    """Return the record of a heading, beside a rudder."""
    rows = [f"{5 * i},{i % 2},{one}" for i, one in enumerate(heading)]
    (folder / "a.csv").write_text("\n".join(["t,helm,gyro", *rows]) + "\n")
    columns = {"t": Column("t", "s"), "rudder": Column("helm", "deg")}
    return load_record(folder / "a.csv", {**columns, "heading": Column("gyro", unit)})


SLOW = [round(350.0 + 0.5 * i, 2) % 360.0 for i in range(60)]  # through north
UNWRAPPED = [350.0 + 0.5 * i for i in range(60)]


def spoilt(heading: list[float], value: float, *rows: int) -> list[float]:
    return [value if i in rows else one for i, one in enumerate(heading)]


@pytest.mark.parametrize(
    ("heading", "rows"),
    [
        (spoilt(SLOW, 511.0, 7), [7]),
        (spoilt(SLOW, -9999.0, *range(20, 50)), [*range(20, 50)]),
        (spoilt(SLOW, 511.0, 0, 1, 59), [0, 1, 59]),
        (spoilt(spoilt(SLOW, 511.0, 5), 999.0, 6, 30), [5, 6, 30]),
        (spoilt(SLOW, 120.0, 30), [30]),
        (spoilt(SLOW, 180.0, *range(30, 35)), [*range(30, 35)]),
        (spoilt(SLOW, 180.0, *range(30, 36)), []),
        (spoilt(SLOW, 0.0, 2, 4), [2, 4]),
        (spoilt(UNWRAPPED, 511.0, 50), [50]),
        (UNWRAPPED, []),
        ([340.0 + i for i in range(28)], []),
        (UNWRAPPED[:10] + [one + 90.0 for one in UNWRAPPED[10:]], []),
        ([72.0 * i % 360.0 for i in range(60)], []),
        ([200.0 + (4.0 * i) % 360.0 for i in range(200)], []),
        (spoilt([-one for one in SLOW], 511.0, 3), [3]),
    ],
)
def test_readings_that_leave_the_heading_and_come_back_are_missing_by_row(
    tmp_path: Path, heading: list[float], rows: list[int]
) -> None:
    record = loaded(tmp_path, heading)
    assert np.flatnonzero(np.isnan(record.column("heading"))).tolist() == rows
    told = [str(one) for one in record.findings]
    assert len(told) == bool(rows)
    for one in told:
        assert one.startswith(f"row {rows[0] + 2}: gyro: {heading[rows[0]]:g} deg is no heading")
        assert f"{len(rows)} missing, rows {rows[0] + 2}" in one


def test_a_heading_in_radians_loses_its_codes_too(tmp_path: Path) -> None:
    heading = spoilt([math.radians(one) for one in SLOW], 511.0, 7)
    assert np.flatnonzero(np.isnan(loaded(tmp_path, heading, "rad").column("heading"))) == [7]


def refusal(folder: Path, channel: str, unit: str, value: str, missing: Any = ()) -> Record:
    """Return the record of a column that has a value in row 12."""
    rows = [f"{5 * i},{value if i == 10 else 0.1 * (i % 7)}" for i in range(40)]
    (folder / "a.csv").write_text("\n".join(["t,what", *rows]) + "\n")
    return load_record(
        folder / "a.csv", {"t": Column("t", "s"), channel: Column("what", unit, missing)}
    )


@pytest.mark.parametrize(
    ("channel", "unit", "value"),
    [
        ("yaw_rate", "deg/s", "-9999"),
        ("yaw_rate", "deg/s", "-8888"),
        ("yaw_rate", "deg/min", "32767"),
        ("yaw_rate", "rad/s", "-9999"),
        ("rudder", "deg", "511"),
        ("speed", "kn", "102.3"),
        ("sway", "m/s", "999.0"),
        ("bow_sway", "kn", "-9999.0"),
        ("latitude", "deg", "91"),
        ("longitude", "deg", "181"),
    ],
)
def test_a_number_that_no_ship_has_is_refused_and_a_study_says_that_it_is_none(
    tmp_path: Path, channel: str, unit: str, value: str
) -> None:
    with pytest.raises(ConfigError) as wrong:
        refusal(tmp_path, channel, unit, value)
    assert f'row 12: what = "{value}": ' in str(wrong.value)
    assert f"missing = [{value}]" in str(wrong.value)
    assert ("are these degrees" in str(wrong.value)) == (unit == "rad/s")
    if channel != "longitude":
        assert "-9999, 32767" in str(wrong.value)
    values = getattr(refusal(tmp_path, channel, unit, value, (float(value),)), channel)
    assert np.flatnonzero(np.isnan(values)).tolist() == [10]


def test_codes_are_guessed_in_a_proposal_and_spoil_no_unit(tmp_path: Path) -> None:
    rows = cells("comment_top.csv")
    for row, place, code in ((4, 2, "999"), (9, 3, "-9999"), (12, 4, "-9999"), (30, 5, "9999")):
        rows[row][place] = code
    text = "\n".join(["time,helm,gyro,rate,sway,speed", *map(",".join, rows)]) + "\n"
    found = proposed(tmp_path, "comment_top.csv", text)
    assert found.columns["heading"].missing == (999.0,)
    assert found.columns["yaw_rate"] == Column("rate", "deg/s", (-9999.0,))
    assert found.columns["sway"] == Column("sway", "m/s", (-9999.0,))
    assert "missing = [9999.0]  # guessed" in (tmp_path / "a.toml").read_text()
    record = observed(tmp_path)
    for channel, row in (("heading", 4), ("yaw_rate", 9), ("sway", 12), ("speed", 30)):
        assert np.flatnonzero(np.isnan(record.column(channel))).tolist() == [row]


def test_a_study_s_codes_are_numbers(tmp_path: Path) -> None:
    text = (STRANGERS / "heading-511-two-rows.toml").read_text()
    shutil.copy(STRANGERS / "heading-511-two-rows.csv", tmp_path)
    (tmp_path / "a.toml").write_text(text.replace('"gyro"\n', '"gyro"\nmissing = [511, -9999]\n'))
    assert np.isnan(observed(tmp_path).column("heading")).sum() == 2
    (tmp_path / "b.toml").write_text(text.replace('"gyro"\n', '"gyro"\nmissing = ["511"]\n'))
    with pytest.raises(ConfigError, match=r'missing\[0\] = "511": must be a number'):
        load_study(tmp_path / "b.toml")


def test_a_system_s_own_column_with_a_code_is_told(tmp_path: Path) -> None:
    rows = [f"{i},{-9999 if i == 3 else i % 5}" for i in range(40)]
    (tmp_path / "a.csv").write_text("\n".join(["t,fin", *rows]) + "\n")
    record = load_record(tmp_path / "a.csv", {"t": Column("t", "s"), "fin": Column("fin", "-")})
    assert "fin: is -9999 for no reading? then leave it empty" in str(record.findings[0])


def test_arrays_are_asked_the_same() -> None:
    frame = {"t": np.arange(60.0), "rudder": np.zeros(60), "heading": np.array(SLOW)}
    frame |= {"yaw_rate": np.zeros(60)}
    units = {"rudder": "deg", "heading": "deg", "yaw_rate": "deg/s"}
    columns = columns_of(frame, {}, units, ())
    frame["heading"][7] = 511.0
    record = record_of(arrays_of(frame, columns), columns)
    assert np.flatnonzero(np.isnan(record.column("heading"))).tolist() == [7]
    frame["yaw_rate"][3] = -9999.0
    with pytest.raises(
        ConfigError, match=r"frame: yaw_rate\[3\]: no yaw_rate in deg/s .* make it NaN"
    ):
        record_of(arrays_of(frame, columns), columns)


def test_a_ship_s_further_column_is_asked_the_same(tmp_path: Path) -> None:
    heads = {"t": "s", "rudder": "rad", "yaw_rate": "rad/s", "speed": "m/s", "sway": "m/s"}
    heads |= {"revolutions": "rpm"}
    rows = [f"{i},{0.1 * (i % 3)},{1e-3 * (i % 5)},8,0,{9999 if i == 5 else 90}" for i in range(60)]
    (tmp_path / "a.csv").write_text("\n".join([",".join(heads), *rows]) + "\n")
    columns = [ShipColumn(channel=one, column=one, unit=unit) for one, unit in heads.items()]
    with pytest.raises(
        ConfigError, match=r'row 7: revolutions = "9999": no revolutions in rpm .* = \[9999\]'
    ):
        load_trial(tmp_path / "a.csv", replace(SHIP, columns=tuple(columns)))
    columns[-1] = replace(columns[-1], missing=(9999.0,))
    record = load_trial(tmp_path / "a.csv", replace(SHIP, columns=tuple(columns)))
    assert any("revolutions: has no reading for 2 s" in str(one) for one in record.findings)
    assert record.column("revolutions") == pytest.approx(1.5)


# Signs within numbers


def table(folder: Path, text: str) -> Any:
    (folder / "a.csv").write_text(text)
    return read_table(folder / "a.csv")


@pytest.mark.parametrize(
    ("text", "want"),
    [
        ("a;b\n1,5;2\n2,25;3\n", [1.5, 2.25]),
        ("a;b\n1,005;2\n2,010;3\n", [1.005, 2.010]),
        ("a;b\n0;2\n1,005;3\n", [0.0, 1.005]),
        ("a;b\n998;2\n0,125;3\n1,005;3\n", [998.0, 0.125, 1.005]),
        ("a;b\n1234;2\n1,005;3\n", [1234.0, 1.005]),
        ("a;b\n999;2\n1.005;3\n1.5;3\n", [999.0, 1.005, 1.5]),
        ("a;b\n1.005;2\n2.010;3\n", [1.005, 2.010]),
        ("a\tb\n1,005\t2\n2,010\t3\n", [1.005, 2.010]),
        ("a,b\n999,2\n1.005,3\n", [999.0, 1.005]),
        ("# made by a logger\n# a,b\n1,2\n3,4\n", [1.0, 3.0]),
        ("sep=\t\na\tb\n1\t2\n3\t4\n", [1.0, 3.0]),
        ("a;b\n1,5;2;\n2,5;3;\n", [1.5, 2.5]),
        ("a;b;;\n1,5;2;;\n2,5;3;;\n", [1.5, 2.5]),
        ("\na,b\n// a remark, and one more\n1,2\n3,4\n", [1.0, 3.0]),
    ],
)
def test_a_column_has_one_reading(tmp_path: Path, text: str, want: list[float]) -> None:
    assert table(tmp_path, text).numbers(0) == pytest.approx(want)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('a,b\n"5,000",2\n', r'row 2: a = "5,000": .* is it 5000 or 5\.000\?'),
        ('a,b\n0.5,2\n"3,5",2\n', r'row 3: a = "3,5": .* is it 35 or 3\.5\?'),
        ('a,b\n"1,234,567",2\n', r'row 2: a = "1,234,567": .* without a sign between thousands'),
        ("a;b\n5;2\n1,005;3\n", r'row 3: a = "1,005", row 2: "5": is it 1005 or 1\.005\?'),
        ("a;b\n0;2\n5,000;3\n10,000;4\n", r'row 3: a = "5,000", row 2: "0": is it 5000 or 5\.000'),
        ("a;b\n-998;2\n1.005;3\n", r'row 3: a = "1.005", row 2: "-998": is it 1005 or 1\.005\?'),
        ("a\tb\n5\t2\n1,005\t3\n", r'row 3: a = "1,005", row 2: "5": is it 1005'),
        ("a;b\n5,000;2\n1,234,567;3\n", r'row 3: a = "1,234,567": .* sign between thousands'),
        ("a;b\n1,5;2.5\n", r"decimal commas and decimal points"),
    ],
)
def test_a_column_with_two_readings_is_refused(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        table(tmp_path, text).numbers(0)


def test_minutes_with_a_comma_in_a_file_of_commas_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r'row 2: a = "5,430": .* is it 5430 or 5\.430\?'):
        table(tmp_path, 'a,b\n"5,430",2\n').angles(0, "ddmm")


# Names


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("date", "t"),
        ("tide", None),
        ("heel", "roll"),
        ("helm", "rudder"),
        ("long", None),
        ("wave speed", None),
        ("rates", None),
        ("ruder", "rudder"),
        ("rudder 1", "rudder"),
        ("Headings", "heading"),
    ],
)
def test_a_short_name_that_is_like_another_is_not_taken_for_it(
    tmp_path: Path, name: str, channel: str | None
) -> None:
    text = f"{name},x1\n" + "".join(f"{i},{i}\n" for i in range(30))
    found = guess_columns(table(tmp_path, text), SHIP_WORDS).columns
    assert [*found] == ([channel] if channel else [])


def test_a_heel_is_no_helm(tmp_path: Path) -> None:
    text = "heel,x1\n" + "".join(f"{i},{i}\n" for i in range(30))
    assert not guess_columns(table(tmp_path, text), CHANNEL_WORDS).columns


def test_a_heading_of_360_near_20_does_not_slow_the_ship(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    name = "heading-360-two-rows"
    for end in ("toml", "csv"):
        shutil.copy(STRANGERS / f"{name}.{end}", tmp_path)
    report = identified(tmp_path / f"{name}.toml")
    assert abs(numbers(report)["T"][0] - TRUE_T) < TRUE_T_ERROR
    assert any(
        "360 deg is no heading here: 2 missing, rows 43, 44" in x for x in report["findings"]
    )
