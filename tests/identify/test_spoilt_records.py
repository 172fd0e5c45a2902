"""Spoilt records: each fault is named with its remedy, or mended and reported."""

import math
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trainer.config.files import ConfigError
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.record.study import load_study, observe_record

Columns = dict[str, Any]
STEP, LENGTH, SPEED = 2.0, 100.0, 12.0
UNITS = {
    "t": "s",
    "rudder": "deg",
    "yaw_rate": "deg/s",
    "heading": "deg",
    "sway": "m/s",
    "speed": "kn",
}
HEADS = {"yaw_rate": "rot", "rudder": "helm", "heading": "gyro", "t": "time"}


def trial() -> Columns:
    """Return a record of a first-order ship, by channel, in UNITS; a little noise on all."""
    rng = np.random.default_rng(4)
    helm = np.resize(hold_bits(prbs(6), 10.0, 8), 400)
    rate, heading = np.zeros(400), np.full(400, 350.0)
    p = math.exp(-STEP / 20.0)
    for i in range(399):
        rate[i + 1] = p * rate[i] - 0.05 * (1.0 - p) * helm[i]
        heading[i + 1] = heading[i] + STEP * 0.5 * (rate[i] + rate[i + 1])
    sway = -0.45 * LENGTH * np.radians(rate)
    return {
        "t": STEP * np.arange(400),
        "rudder": helm,
        "yaw_rate": rate + 0.005 * rng.standard_normal(400),
        "heading": np.mod(heading + 0.05 * rng.standard_normal(400), 360.0),
        "sway": sway + 0.01 * rng.standard_normal(400),
        "speed": np.full(400, SPEED) + 0.05 * rng.standard_normal(400),
    }


def study(folder: Path, columns: Columns, units: dict[str, str], more: str = "") -> Any:
    """Write the study of columns that stand in trial.csv; return what is observed."""
    rows = "".join(
        f'\n[[columns]]\nchannel = "{name}"\ncolumn = "{HEADS.get(name, name)}"\n'
        + (f'unit = "{units[name]}"\n' if units.get(name) else "")
        for name in columns
    )
    ship = f"\n[ship]\nlength_m = {LENGTH}\nspeed_kn = {SPEED}\nbow_log_m = 30\nstern_log_m = 20\n"
    head = f'schema = "identify/1"\nname = "trial"\ndata = "trial.csv"\n{more}'
    (folder / "trial.toml").write_text(head + rows + ship)
    return observe_record(load_study(folder / "trial.toml"))


def text(columns: Columns, separator: str = ",", form: str = "") -> str:
    """Return the columns as a CSV text."""
    heads = separator.join(HEADS.get(name, name) for name in columns)

    def cell(value: Any) -> str:
        return "" if value != value else f"{value:{form}}" if form else f"{value}"  # noqa: PLR0124

    rows = zip(*columns.values(), strict=True)
    return "\n".join([heads, *(separator.join(map(cell, row)) for row in rows)]) + "\n"


def observed(folder: Path, columns: Columns, units: dict[str, str] | None = None) -> Any:
    """Write a record and its study; return what is observed."""
    (folder / "trial.csv").write_text(text(columns))
    return study(folder, columns, UNITS | (units or {}))


def put(channel: str, row: int, value: float, add: float = 0.0) -> Callable[[Columns], None]:
    """Return what puts a value into a channel, or adds to what is there."""

    def spoil(columns: Columns) -> None:
        columns[channel][row] = value if not add else columns[channel][row] + add

    return spoil


def scaled(channel: str, factor: float) -> Callable[[Columns], None]:
    """Return what multiplies a channel: by its unit, or its sign."""

    def spoil(columns: Columns) -> None:
        columns[channel] = columns[channel] * factor

    return spoil


def only(*channels: str, factor: float = 1.0) -> Callable[[Columns], None]:
    """Return what leaves some channels beside time and rudder, the first one multiplied."""

    def spoil(columns: Columns) -> None:
        for name in set(columns) - {"t", "rudder", *channels}:
            del columns[name]
        columns[channels[0]] = columns[channels[0]] * factor

    return spoil


def pick(places: Any) -> Callable[[Columns], None]:
    """Return what takes these rows alone."""

    def spoil(columns: Columns) -> None:
        columns.update({name: values[places] for name, values in columns.items()})

    return spoil


def helmsman(columns: Columns) -> None:
    heading = np.unwrap(columns["heading"], period=360.0) - 350.0
    columns["rudder"] = 0.5 * heading + 20.0 * columns["yaw_rate"]


def logs(factor: float) -> Callable[[Columns], None]:
    """Return what has two logs for sway, 30 m ahead and 20 m behind, in another unit."""

    def spoil(columns: Columns) -> None:
        rate, sway = np.radians(columns["yaw_rate"]), columns.pop("sway")
        columns |= {"bow_sway": factor * (sway + 30 * rate)}
        columns |= {"stern_sway": factor * (sway - 20 * rate)}

    return spoil


DEGREE = math.pi / 180.0
KNOT = 1852.0 / 3600.0
TWICE = np.sort(np.append(np.arange(400), 60))


def another_row(columns: Columns) -> None:
    """Put a row in between, at the time of the one before it but with another yaw rate."""
    pick(TWICE)(columns)
    columns["yaw_rate"][61] += 1e-3


REFUSED = {
    "one time repeated": (put("t", 40, 78.0), {}, r"row 42: time = 78 s is repeated"),
    "a falling time": (put("t", 40, 3.0), {}, r"row 42: time = 3 s is before 78 s"),
    "a row twice": (pick(TWICE), {}, r"row 63: time = 120 s is repeated"),
    "a row more": (another_row, {}, r"row 63: time = 120 s is repeated"),
    "all rows twice": (pick(np.repeat(np.arange(400), 2)), {}, r"row 3: time = 0 s is repeated"),
    "a time missing": (put("t", 9, math.nan), {}, r"row 11: time has no value"),
    "no value at all": (scaled("yaw_rate", math.nan), {}, r"rot: has no value at all"),
    "a rudder at rest": (scaled("rudder", 0.0), {}, r"helm: stands at 0 deg in all rows"),
    "rudder in degrees": (scaled("rudder", 1), {"rudder": "rad"}, r'helm = .* say unit = "deg"'),
    "rate a minute": (scaled("yaw_rate", 60.0), {}, r'yaw rate is 60 of .* unit = "deg/min"'),
    "rate to port": (
        scaled("yaw_rate", -1.0),
        {},
        r"against the heading.* scale = -1 .* of rot",
    ),
    "rate in radians": (scaled("yaw_rate", DEGREE), {}, r'in rad/s all agrees: say unit = "rad/s"'),
    "rate in degrees": (scaled("yaw_rate", 1), {"yaw_rate": "rad/s"}, r'unit = "deg/s" in its'),
    "a rudder to starboard": (scaled("rudder", -1.0), {}, r'say positive_rudder = "starboard"'),
    "rudder in radians": (scaled("rudder", DEGREE), {}, r'unit = "rad" in its .* of helm'),
    "heading in radians": (only("heading", factor=DEGREE), {}, r'jumps by .* unit = "rad"'),
    "heading in degrees": (only("heading"), {"heading": "rad"}, r'jumps by .* unit = "deg"'),
    "rate alone in radians": (only("yaw_rate", factor=DEGREE), {}, r'unit = "rad/s" in its'),
    "rate alone in degrees": (only("yaw_rate"), {"yaw_rate": "rad/s"}, r'unit = "deg/s" in its'),
    "rate alone a minute": (only("yaw_rate", factor=60.0), {}, r'unit = "deg/min" in its'),
}
TOLD = {
    "a rudder missing": (put("rudder", 9, math.nan), {}, r"helm: has no reading for 4 s"),
    "a gap": (
        pick(np.delete(np.arange(400), slice(50, 53))),
        {},
        r"row 52: time: 8 s have passed.*: from_s, to_s",
    ),
    "an uneven time": (put("t", 60, 0.0, add=0.7), {}, r"row 62: time: 2.7 s .* varies"),
    "missing readings": (put("yaw_rate", 7, math.nan), {}, r"row 9: rot: 1 of 400 values"),
    "a wrapped heading": (pick(slice(None)), {}, r"gyro: jumps by more than half a turn .*unwr"),
    "an outlier of rate": (put("yaw_rate", 99, 0, add=0.3), {}, r"row 101: rot: stands out .*rej"),
    "an outlier of heading": (
        put("heading", 99, 0, add=4.0),
        {},
        r"row 101: gyro: 46\.8763 deg is no heading here",
    ),
    "a constant sway": (scaled("sway", 0.0), {}, r"sway: is the same in all rows"),
    "a helmsman alone": (helmsman, {}, r"closed loop without an experiment"),
    "sway in knots": (scaled("sway", 1.0 / KNOT), {}, r"sway: .* 0.88 lengths .*: is it in kn"),
    "sway to port": (scaled("sway", -1.0), {}, r"sway: .*: is it positive to port"),
    "logs in knots": (logs(1.0 / KNOT), {}, r"bow_sway and stern_sway: 1.9 .* is it in kn"),
    "logs in metres": (logs(1.0), {"bow_sway": "kn", "stern_sway": "kn"}, r"is it in m/s"),
    "speed in metres": (scaled("speed", KNOT), {}, r'the log is 0.51.* unit = "m/s"'),
}


@pytest.mark.parametrize("fault", REFUSED)
def test_what_cannot_be_used_is_refused_by_name(tmp_path: Path, fault: str) -> None:
    spoil, units, told = REFUSED[fault]
    columns = trial()
    spoil(columns)
    with pytest.raises(ConfigError, match=told):
        observed(tmp_path, columns, {"bow_sway": "m/s", "stern_sway": "m/s"} | units)


@pytest.mark.parametrize("fault", TOLD)
def test_what_may_mislead_is_told_by_name(tmp_path: Path, fault: str) -> None:
    spoil, units, told = TOLD[fault]
    columns = trial()
    spoil(columns)
    found = observed(tmp_path, columns, {"bow_sway": "m/s", "stern_sway": "m/s"} | units)
    said = list(map(str, found.findings))
    assert any(re.search(told, one) for one in said), said


def test_a_heading_that_never_changes_is_in_no_wrong_unit(tmp_path: Path) -> None:
    columns = trial()
    only("heading")(columns)
    columns["heading"] = np.full(400, 40.1)  # whose mean is not quite 40.1
    said = list(map(str, observed(tmp_path, columns).findings))
    assert len(said) == 2
    assert "gyro: is the same in all rows" in said[0]
    assert "helm: taken as " in said[1]


def test_a_good_record_has_no_finding_but_its_wrapped_heading(tmp_path: Path) -> None:
    finding, path = observed(tmp_path, trial()).findings
    assert "unwrapped" in str(finding)
    assert "helm: taken as " in str(path)
    columns = trial()
    logs(1.0)(columns)
    del columns["heading"]
    assert len(observed(tmp_path, columns, {"bow_sway": "m/s", "stern_sway": "m/s"}).findings) == 1


def clocked(form: Callable[[float], str], step: float, count: int = 400) -> Columns:
    """Return a trial whose clock prints so."""
    columns = trial()
    pick(slice(count))(columns)
    columns["t"] = np.array([float(form(step * i)) for i in range(count)])
    return columns


@pytest.mark.parametrize(
    ("form", "step"),
    [
        (lambda t: f"{t:.0f}", 0.4),
        (lambda t: f"{t // 1}", 0.4),
        (lambda t: f"{t:.3g}", 0.535264),
        (lambda t: f"{5 * round(t / 5)}", 2.0),
        (lambda t: f"{t:.1f}", 0.736),
    ],
    ids=["seconds", "whole seconds passed", "three digits", "ticks of 5 s", "no time repeated"],
)
def test_times_of_a_rounded_clock_are_rebuilt_evenly(tmp_path: Path, form: Any, step: Any) -> None:
    columns = clocked(form, step)
    del columns["heading"]  # which would not be that of the rate at another step
    found = observed(tmp_path, columns)
    told = [str(one) for one in found.findings if "rounded" in str(one)]
    assert len(told) == 1
    assert f"rebuilt every {found.interval:.6g} s" in told[0]
    assert np.ptp(np.diff(found.t)) < 1e-9
    assert found.interval == pytest.approx(step, rel=5e-4)
    assert found.t[0] == pytest.approx(0.0, abs=0.6)


def test_a_clock_that_stops_is_refused_not_rebuilt(tmp_path: Path) -> None:
    columns = clocked(lambda t: f"{t:.0f}", 0.4)
    columns["t"][200:] += 7.0
    with pytest.raises(ConfigError, match="is repeated"):
        observed(tmp_path, columns)


def german(columns: Columns) -> str:
    """Return a text with decimal commas, a row of units, ISO times, and empty last rows."""
    start = np.datetime64("2026-03-01T23:55:00")
    rows = [";".join(HEADS.get(name, name) for name in columns), "ISO;°;Grad/s;[°];m/s;(kts)"]
    for i, values in enumerate(zip(*columns.values(), strict=True)):
        cells = ";".join(f"{x:.12g}".replace(".", ",") for x in values[1:])
        rows.append(f"{start + np.timedelta64(2 * i, 's')}Z;{cells}")
    return "\n".join([*rows, ";;;;;", ";;;;;"]) + "\n"


GERMAN = (
    'columns by ";", 2 empty last rows left out, units of row 2, decimal commas, times by ISO 8601'
)


def clocks(columns: Columns) -> str:
    """Return a text by tabs, units in the heading, and times of day past midnight."""
    heads = "time\thelm [deg]\trot (deg/s)\tgyro [Degrees]\tsway [m/s]\tspeed [knots]"
    rows = [heads]
    for i, values in enumerate(zip(*columns.values(), strict=True)):
        second = (86100 + 2 * i) % 86400
        time = f"{second // 3600:02d}:{second // 60 % 60:02d}:{second % 60:02d}.00"
        rows.append("\t".join([time, *(f"{x:.12g}" for x in values[1:])]))
    return "\n".join(rows)


@pytest.mark.parametrize(
    ("make", "code", "units", "told"),
    [
        (
            lambda columns: german(columns).replace("Grad", "deg"),
            "utf-8-sig",
            {},
            GERMAN,
        ),
        (
            lambda columns: german(columns).replace("Grad", "°"),
            "cp1252",
            {},
            f"letters of Windows, {GERMAN}",
        ),
        (
            clocks,
            "utf-16",
            {},
            "UTF-16, columns by tabs, units of the heading, times by ISO 8601",
        ),
        (lambda columns: text(columns, form=".12g"), "utf-8-sig", UNITS, ""),
        (
            lambda columns: text(columns, ";", ".12g"),
            "utf-8",
            UNITS,
            'columns by ";"',
        ),
    ],
    ids=["semicolons", "Windows", "tabs", "byte order mark", "points between semicolons"],
)
def test_every_dialect_gives_the_same_record_and_says_how_it_was_read(
    tmp_path: Path, make: Any, code: str, units: dict[str, str], told: str
) -> None:
    columns = trial()
    plain = observed(tmp_path, columns)
    (tmp_path / "trial.csv").write_text(make(columns), encoding=code)
    found = study(tmp_path, columns, units)
    read = [str(one) for one in found.findings if "read with" in str(one)]
    assert read == ([f"trial.csv: read with {told}"] if told else [])
    for channel in ("t", *plain.channels):
        want = getattr(plain, channel)
        assert getattr(found, channel) == pytest.approx(want, rel=1e-9, abs=1e-9)


WRITTEN: dict[str, tuple[Callable[[Columns], str], str]] = {
    "a comma for both": (
        lambda columns: text(columns, form=".4f").replace(".", ","),
        r'row 2: has 12 fields, the heading 6: is "," both .* write ";" between columns',
    ),
    "commas and points": (
        lambda columns: text(columns, ";", ".4f").replace(".", ",", 9).replace(";-", ";-0", 1),
        r"row 2: time = .* decimal commas and decimal points: write all numbers one way",
    ),
    "thousands": (
        lambda columns: text(columns, ";").replace("\n2.0;", "\n1.002,5;"),
        r'row 3: time = "1.002,5": must be a number, or empty: .* thousands',
    ),
    "columns by a bar": (
        lambda columns: text(columns).replace(",", "|"),
        r'"\|" parts columns: write commas, semicolons or tabs instead',
    ),
    "a time of another form": (
        lambda columns: text(columns).replace("\n2.0,", "\n28.11.2026 08:00:02,"),
        r'row 3: time = "28.11.2026 08:00:02": must be a number, or empty, or a time such as 2026-',
    ),
    "a word": (
        lambda columns: text(columns).replace(",-10.0,", ",port,", 1),
        r'row \d+: helm = "port": must be a number',
    ),
    "a field too few": (
        lambda columns: text(columns).replace("\n2.0,", "\n", 1),
        r"row 3: has 5 fields, the heading 6",
    ),
    "a column twice": (
        lambda columns: text(columns).replace("gyro", "rot"),
        r'column "rot" is given twice',
    ),
    "a column that is not there": (
        lambda columns: text(columns).replace("gyro", "gyros"),
        r'no column "gyro" for heading; nearest is gyros',
    ),
    "not a text": (lambda columns: "\0" + text(columns) + "\udcff", r"not a CSV text"),
    "a time that is none": (
        lambda columns: german(columns).replace("2026-03-01T23:55:02Z", "soon"),
        r'row 4: time = "soon": must be a time by ISO 8601',
    ),
}


@pytest.mark.parametrize("fault", WRITTEN)
def test_a_text_that_cannot_be_read_is_refused_by_row_with_the_remedy(
    tmp_path: Path, fault: str
) -> None:
    make, told = WRITTEN[fault]
    columns = trial()
    (tmp_path / "trial.csv").write_bytes(make(columns).encode(errors="surrogateescape"))
    with pytest.raises(ConfigError, match=told):
        study(tmp_path, columns, UNITS)


def test_the_study_s_unit_is_taken_before_the_file_s_and_told(tmp_path: Path) -> None:
    columns = trial()
    (tmp_path / "trial.csv").write_text(text(columns).replace("rot", "rot [rad/s]", 1))
    found = study(tmp_path, columns, UNITS)
    said = "rot is in rad/s, the study says deg/s: taken as deg/s"
    assert said in [one.text for one in found.findings]
    assert found.yaw_rate == pytest.approx(np.radians(columns["yaw_rate"]))


def test_a_unit_that_nobody_says_is_asked_for(tmp_path: Path) -> None:
    columns = trial()
    (tmp_path / "trial.csv").write_text(text(columns))
    with pytest.raises(ConfigError, match=r'rot for yaw_rate: .* say in the study unit = "rad/s"'):
        study(tmp_path, columns, {**UNITS, "yaw_rate": ""})
    (tmp_path / "trial.csv").write_text(text(columns).replace("rot", "rot [kn]", 1))
    with pytest.raises(ConfigError, match=r'the file says "kn": say in the study'):
        study(tmp_path, columns, {**UNITS, "yaw_rate": ""})


@pytest.mark.parametrize("channel", ["heading", "yaw_rate", "sway", "speed"])
def test_a_channel_read_in_every_third_row_is_examined_without_a_warning(
    tmp_path: Path, channel: str
) -> None:
    columns = trial()
    columns[channel][np.arange(400) % 3 > 0] = math.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        told = observed(tmp_path, columns).findings
    assert any("134 readings, one in " in str(one) for one in told)
