"""Files as loggers vary them: a study that `new` writes is one that `identify` takes."""

import json
import shlex
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.made_logs import MadeLog, fly_ships

from trainer.cli.main import cli
from trainer.core.kernel import Numbers

LOGS = [log for log in fly_ships(60, 9) if 150 < len(log.t) < 1200]
NAMES = {
    "rudder": ("rudder", "Rudder angle", "helm", "delta", "RUDDER_DEG"),
    "heading": ("heading", "HDG", "psi", "gyro", "Yaw angle"),
    "yaw_rate": ("yaw rate", "ROT", "Rate of Turn", "r"),
    "speed": ("speed", "STW", "log", "Speed Through Water"),
}
BRACKETS = ("{} [{}]", "{} ({})", "{}")
UNITS = {"rudder": ("deg", "rad"), "heading": ("deg", "rad"), "speed": ("m/s", "kn", "km/h")}
UNITS["yaw_rate"] = ("deg/s", "deg/min", "rad/s")
FACTORS = {"rad": np.pi / 180.0, "rad/s": np.pi / 180.0, "deg/min": 60.0}
FACTORS |= {"kn": 3600.0 / 1852.0, "km/h": 3.6}
CLOCKS = ("t", "time [s]", "Time [ms]", "timestamp [us]", "UTC", "Date")


def typed(*words: str) -> Result:
    """Return what a command answers; a warning of numpy's is an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        return CliRunner().invoke(cli, words)


def clock(drawn: np.random.Generator, t: Numbers) -> tuple[str, list[str]]:
    """Return a heading of times, and their cells."""
    head = str(drawn.choice(CLOCKS))
    if head in ("UTC", "Date"):
        start = np.datetime64("2026-11-28T23:58:00")
        stamps = start + (1e3 * t).round().astype("timedelta64[ms]")
        return head, [f"{one}Z" if head == "UTC" else str(one) for one in stamps]
    size = {"Time [ms]": 1e3, "timestamp [us]": 1e6}.get(head, 1.0)
    return head, [f"{size * one:.6g}" if size == 1.0 else f"{size * one:.0f}" for one in t]


def columns_of(drawn: np.random.Generator, log: MadeLog) -> list[tuple[str, list[str]]]:
    """Return headings and cells as some logger writes a log."""
    found = []
    for channel, names in NAMES.items():
        if channel not in ("rudder", "heading") and drawn.random() < 0.4:
            continue
        unit = str(drawn.choice(UNITS[channel]))
        values = log.channels[channel] * FACTORS.get(unit, 1.0)
        if channel == "rudder" and drawn.random() < 0.5:
            values = -values
        plain = unit in ("deg", "deg/s", "m/s")
        head = BRACKETS[drawn.integers(0, 3 if plain else 2)].format(drawn.choice(names), unit)
        cells = [f"{one:.5g}" for one in values]
        kind, rows = drawn.integers(0, 5), np.arange(len(cells))
        if kind == 0 and channel != "rudder":  # a slow channel, filled forward or empty between
            cells = [cells[i // 3 * 3] for i in rows]
        elif kind == 1:
            cells = ["" if i % 3 else cells[i] for i in rows]
        elif kind == 2:
            for i in drawn.integers(1, len(cells) - 1, 3):
                cells[i] = str(drawn.choice(["", "-9999", "nan"]))
        found.append((head, cells))
    if drawn.random() < 0.5:
        found.append(("battery [V]", [f"{24.0 + 0.1 * (i % 3):.1f}" for i in range(len(log.t))]))
    return found


def write(drawn: np.random.Generator, log: MadeLog, path: Path) -> None:
    """Write a log with separators, decimal signs, comments and clocks of some logger."""
    parts = [clock(drawn, log.t), *columns_of(drawn, log)]
    separator = str(drawn.choice([",", ";", "\t"]))
    heads, cells = zip(*parts, strict=True)
    rows = [separator.join(row) for row in zip(*cells, strict=True)]
    if separator != "," and drawn.random() < 0.5:
        rows = [row.replace(".", ",") if "T" not in row else row for row in rows]
    before = ["# logged by a logger"] if drawn.random() < 0.3 else []
    path.write_text("\n".join([*before, separator.join(heads), *rows]) + "\n", encoding="utf-8")


def check(seeds: Sequence[int], folder: Path) -> int:
    """Return how many studies were written; each of them is taken."""
    count = 0
    for seed in seeds:
        drawn = np.random.default_rng(seed)
        log = LOGS[int(drawn.integers(len(LOGS)))]
        path, study = folder / f"{seed}.csv", folder / f"{seed}.toml"
        write(drawn, log, path)
        words = f"--length {log.length:.4g} --at {log.speed * 3600 / 1852:.4g} -o {study}"
        done = typed("identify", "new", str(path), *shlex.split(words))
        said = f"{seed}: {done.output} {done.exception}"
        assert done.exception is None or path.name in str(done.exception), said
        if done.exit_code:
            assert not study.exists(), said
            continue
        count += 1
        seen = typed("identify", str(study), "--data-only", "--json")
        assert seen.exit_code == 0, f"{said} {seen.output} {seen.exception}"
        (run,) = json.loads(seen.output)["runs"]
        assert {one["name"] for one in run["channels"]} >= {"rudder", "heading"}, said
    return count


@pytest.mark.parametrize(
    "seeds", [range(40), pytest.param(range(40, 600), marks=pytest.mark.slow)], ids=["few", "many"]
)
def test_what_new_writes_identify_takes(tmp_path: Path, seeds: Sequence[int]) -> None:
    assert check(seeds, tmp_path) >= 0.95 * len(seeds)


def test_a_date_that_cannot_be_read_gives_way_to_a_time_that_can(tmp_path: Path) -> None:
    log, path = LOGS[0], tmp_path / "log.csv"
    rows = zip(log.t, log.channels["rudder"], log.channels["heading"], strict=True)
    lines = [f"28. Nov,{t:.2f},{helm:.2f},{heading:.2f},7" for t, helm, heading in rows]
    path.write_text("\n".join(["Date,Time,rudder,heading,crew", *lines]) + "\n")
    done = typed("identify", "new", str(path), "--length", f"{log.length:.4g}")
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    assert "t in Time" in done.output
    assert "Date: cannot be read as times" in done.output
    assert "not used: Date, crew" in done.output
    assert typed("identify", str(path.with_suffix(".toml")), "--data-only").exit_code == 0


@pytest.mark.parametrize("unit", ["deg/s", "deg/min", "rad/s"])
@pytest.mark.parametrize("nimble", [0, 3, 8, 15, -1])
def test_a_rate_without_a_unit_is_read_in_that_by_which_the_heading_agrees(
    tmp_path: Path, unit: str, nimble: int
) -> None:
    log = sorted(LOGS, key=lambda one: float(np.abs(one.channels["yaw_rate"]).max()))[nimble]
    rate = log.channels["yaw_rate"] * FACTORS.get(unit, 1.0)
    rows = zip(log.t, log.channels["rudder"], log.channels["heading"], rate, strict=True)
    lines = [f"{t:.2f},{helm:.2f},{heading:.2f},{turn:.5g}" for t, helm, heading, turn in rows]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time,rudder,heading,yaw rate", *lines]) + "\n")
    done = typed("identify", "new", str(path), "--length", f"{log.length:.4g}")
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    study = path.with_suffix(".toml").read_text()
    assert f'column = "yaw rate"\nunit = "{unit}"' in study
