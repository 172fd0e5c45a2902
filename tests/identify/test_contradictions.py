"""Readings that the ship cannot have made: told by row, refused, or not called settled."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.studies import answered
from helpers.turning import sail, write_study

from trainer.config.files import ConfigError
from trainer.identify.record.study import load_study, observe_record

TIME, RUDDER, HEADING, RATE = range(4)  # columns of a record


def findings_of(folder: Path, rows: Any, more: str = "") -> list[str]:
    return list(map(str, observe_record(load_study(write_study(folder, rows, more))).findings))


@pytest.mark.parametrize("count", [1, 3, 5])
@pytest.mark.parametrize("value", [0.0, 360.0, 25.0])
def test_a_heading_that_leaves_the_circle_of_the_possible_is_missing_by_row(
    tmp_path: Path, count: int, value: float
) -> None:
    rows = sail(1, rate=2.5, interval=1.0, seconds=300.0)
    rows[:, HEADING] = (rows[:, HEADING] + 345.0 - rows[100, HEADING]) % 360.0  # near north
    rows[100 : 100 + count, HEADING] = value
    path = write_study(tmp_path, rows)
    record = observe_record(load_study(path))
    assert np.flatnonzero(np.isnan(record.column("heading"))).tolist() == [*range(100, 100 + count)]
    told = ", ".join(str(row) for row in range(102, 102 + count))
    assert any(f"{count} missing, rows {told}" in str(one) for one in record.findings)


@pytest.mark.long
def test_at_most_one_of_100_clean_records_has_a_false_find(tmp_path: Path) -> None:
    false = 0
    for seed in range(100):
        kinds = {"rate": (2.0, 5.0)[seed % 2], "interval": (0.5, 1.0, 2.0, 5.0)[seed % 4]}
        rows = sail(seed, **kinds, seconds=300.0, heading_error=(0.0, 0.2, 1.0)[seed % 3])
        rows[:, HEADING] = np.round(rows[:, HEADING], seed % 2)  # of a compass in whole degrees
        found = findings_of(tmp_path, rows)
        false += any(word in one for one in found for word in ("is no heading", "stands still"))
    assert false <= 1


def test_a_heading_that_stands_still_under_helm_is_told(tmp_path: Path) -> None:
    rows = sail(2, rate=2.5, interval=2.0, seconds=600.0)
    rows[100:132, HEADING] = rows[100, HEADING]
    (told,) = [one for one in findings_of(tmp_path, rows) if "stands still" in one]
    assert told.startswith(
        "row 102: heading: stands still for 62 s, to row 133, while rudder works"
    )


@pytest.mark.parametrize(
    ("rate", "words"),
    [
        (lambda rows: 0.05 * np.gradient(rows[:, RUDDER]), "another axis"),
        (lambda rows: -rows[:, RATE], "scale = -1"),
        (lambda rows: rows[:, RATE] / 57.3, 'unit = "rad/s"'),
        (lambda rows: 60.0 * rows[:, RATE], 'unit = "deg/min"'),
    ],
    ids=["roll", "sign", "radians", "minutes"],
)
def test_a_yaw_rate_that_contradicts_the_heading_is_told_as_that(
    tmp_path: Path, rate: Any, words: str
) -> None:
    rows = sail(3, rate=2.5, interval=2.0)
    rows[:, RATE] = rate(rows)
    with pytest.raises(ConfigError, match=words) as wrong:
        findings_of(tmp_path, rows)
    assert "positive_rudder" not in str(wrong.value)


def test_times_in_microseconds_are_not_taken_for_seconds(tmp_path: Path) -> None:
    rows = sail(3, rate=2.5, interval=2.0, seconds=300.0)
    rows[:, TIME] *= 1e6
    with pytest.raises(ConfigError, match=r'are these ms or us. say unit = "us"'):
        findings_of(tmp_path, rows)
    path = tmp_path / "run.toml"
    path.write_text(path.read_text().replace('unit = "s"', 'unit = "us"'))
    assert observe_record(load_study(path)).interval == pytest.approx(2.0)
    answered("new", tmp_path / "run.csv", "-o", tmp_path / "new.toml")
    assert 'unit = "us"  # guessed' in (tmp_path / "new.toml").read_text()


def test_a_ship_that_only_sums_her_rudder_is_not_settled(tmp_path: Path) -> None:
    rows = sail(4, rate=2.5, interval=2.0, seconds=600.0)
    stream = np.random.default_rng(4)
    turning = 4e-4 * 2.0 * np.cumsum(rows[:, RUDDER] - rows[:, RUDDER].mean())
    rows[:, RATE] = turning + 1e-4 * stream.standard_normal(len(rows))
    rows[:, HEADING] = (2.0 * np.cumsum(turning) + 0.01 * stream.standard_normal(len(rows))) % 360.0
    path = write_study(tmp_path, rows)
    text = path.read_text() + '\n[[parameters]]\nname = "T"\nstart = 1e12\nfree = "no"\n'
    path.write_text(text)
    report = json.loads(answered(path, "--json", code=1).stdout)
    assert not report["converged"]
    assert "is beyond a record of 600 s" in report["doubt"]
