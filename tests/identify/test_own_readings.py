"""A channel's own readings: what was filled forward or left empty is none of them."""

import json
import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from trainer.cli.main import cli
from trainer.core.kernel import Numbers
from trainer.identify.record.readings import find_hold
from trainer.identify.record.sources import Column, load_record

GAIN, LAG = -0.12, 9.0  # [1/s, s] of the ship below
STEP = 0.2  # [s] from row to row
COUNT = 1500
FINE = 20  # steps of the ship in a row


def sailed() -> tuple[Numbers, Numbers, Numbers]:
    """Return times [s], rudder and heading [deg] of a first-order ship in a zig-zag."""
    h, helm, rate, heading, ordered = STEP / FINE, 0.0, 0.0, 0.0, 0.0
    keep = math.exp(-h / LAG)
    rows = []
    for i in range(COUNT * FINE):
        if i % FINE == 0:
            rows.append((i * h, helm, heading))
        if i * h > 20.0:
            ordered = ordered or 15.0
            ordered = math.copysign(15.0, heading) if abs(heading) > 12.0 else ordered
        moved = helm + min(max(ordered - helm, -4.0 * h), 4.0 * h)
        turning = keep * rate + (1.0 - keep) * GAIN * 0.5 * (helm + moved)
        heading += 0.5 * h * (rate + turning)
        helm, rate = moved, turning
    t, rudder, heading_deg = np.array(rows).T
    noise = np.random.default_rng(5)
    rudder = rudder + 0.05 * noise.standard_normal(COUNT)
    return t, rudder, 70.0 + heading_deg + 0.1 * noise.standard_normal(COUNT)


T, RUDDER, HEADING = sailed()


def held(values: Numbers, rows: float, begin: float = 0.37) -> Numbers:
    """Return a column in which a reading stands for so many rows."""
    read = np.floor(np.floor((np.arange(COUNT) + begin) / rows) * rows).astype(int)
    return np.asarray(values[np.maximum(read, 0)])


def sparse(values: Numbers, rows: int) -> Numbers:
    """Return a column that has a cell in each row of so many."""
    return np.where(np.arange(COUNT) % rows == 0, values, math.nan)


def write(path: Path, rudder: Numbers, heading: Numbers, t: Numbers = T) -> Path:
    """Write a log of three columns, to hundredths."""

    def cell(value: float) -> str:
        return "" if math.isnan(value) else f"{value:.2f}"

    rows = [",".join(map(cell, row)) for row in zip(t, rudder, heading % 360.0, strict=True)]
    path.write_text("\n".join(["time [s],rudder,heading", *rows]) + "\n", encoding="utf-8")
    return path


def fitted(log: Path) -> dict[str, Any]:
    """Return the numbers of a fit as a newcomer types it, no warning of numpy's on the way."""
    study = log.with_suffix(".toml")
    new = ["identify", "new", str(log), "--length", "12", "--at", "6.1"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        done = CliRunner().invoke(cli, [*new, "-o", str(study)])
        assert done.exit_code == 0, done.output
        done = CliRunner().invoke(cli, ["identify", str(study), "--json"])
    assert done.exit_code == 0, f"{done.output} {done.exception}"
    report: dict[str, Any] = json.loads(done.output)
    return report


CASES = {  # rudder, heading, K, T and how near
    "as it is": (RUDDER, HEADING, 0.05),
    "a heading held for 5 rows": (RUDDER, held(HEADING, 5, 0.0), 0.05),
    "a heading in each 5th row": (RUDDER, sparse(HEADING, 5), 0.05),
    "a rudder held for 5 rows": (held(RUDDER, 5, 0.0), HEADING, 0.08),
    "a rudder in each 5th row": (sparse(RUDDER, 5), HEADING, 0.08),
    "a heading of another clock": (RUDDER, held(HEADING, 4.6), 0.1),
    "a rudder of another clock": (held(RUDDER, 4.6), HEADING, 0.12),
    "both, held": (held(RUDDER, 3, 0.0), held(HEADING, 7, 0.0), 0.1),
}


@pytest.mark.parametrize("case", CASES)
def test_a_fit_finds_the_ship_whatever_its_logger_fills_in(tmp_path: Path, case: str) -> None:
    rudder, heading, room = CASES[case]
    report = fitted(write(tmp_path / "log.csv", rudder, heading))
    found = {row["name"]: row["value"] for row in report["parameters"]}
    assert found["K"] == pytest.approx(GAIN, abs=0.001)
    assert found["T"] == pytest.approx(LAG, abs=room)


@pytest.mark.parametrize("rows", [2, 3, 5, 10, 20])
def test_a_reading_that_stands_for_rows_is_found_with_their_count(rows: int) -> None:
    hold = find_hold(np.round(held(HEADING, rows, 0.0), 2))
    assert hold.every == rows
    assert (np.flatnonzero(hold.kept) % rows == 0).all()
    assert np.count_nonzero(hold.kept) == pytest.approx(COUNT / rows, abs=1)


@pytest.mark.parametrize("rows", [2.5, 4.6, 7.3])
def test_the_beat_of_another_clock_is_found(rows: float) -> None:
    hold = find_hold(np.round(held(HEADING, rows), 2))
    assert hold.every == pytest.approx(rows, rel=0.02)
    assert not hold.exact


def coarse(step: float, noise: float, seed: int) -> Numbers:
    """Return a heading that turns to and fro as an instrument of so coarse a step reads it."""
    drawn = np.random.default_rng(seed)
    swing = drawn.uniform(5.0, 40.0) * np.sin(drawn.uniform(0.05, 0.4) * T + drawn.uniform(0, 6))
    return np.round((swing + noise * drawn.standard_normal(COUNT)) / step) * step


@pytest.mark.parametrize("step", [0.01, 0.1, 0.5, 1.0])
@pytest.mark.parametrize("noise", [0.0, 0.05, 0.3])
def test_a_coarse_instrument_is_not_taken_for_one_filled_forward(step: float, noise: float) -> None:
    found = [seed for seed in range(25) if find_hold(coarse(step, noise, seed)).every > 1.0]
    assert found == []


def test_an_order_that_stands_is_a_reading_in_each_row(tmp_path: Path) -> None:
    ordered = np.repeat(np.where(np.random.default_rng(1).random(60) > 0.5, 10.0, -10.0), 25)
    path = write(tmp_path / "log.csv", ordered, HEADING)
    columns = {"t": Column("time", "s"), "rudder": Column("rudder", "deg")}
    record = load_record(path, columns)
    assert np.isfinite(record.column("rudder")).all()
    assert not any("filled" in str(one) for one in record.findings)


def test_channels_of_three_clocks_each_keep_their_own_times(tmp_path: Path) -> None:
    stamps = np.concatenate([T, T + 0.0013])
    rudder = np.concatenate([RUDDER, np.full(COUNT, math.nan)])
    heading = np.concatenate([np.full(COUNT, math.nan), sparse(HEADING, 5)])
    order = np.argsort(stamps, kind="stable")
    kept = order[np.isfinite(rudder[order]) | np.isfinite(heading[order])]
    path = tmp_path / "log.csv"
    rows = [
        f"{1e6 * stamps[i]:.0f},{'' if math.isnan(rudder[i]) else round(rudder[i], 2)},"
        f"{'' if math.isnan(heading[i]) else round(heading[i] % 360.0, 2)}"
        for i in kept
    ]
    path.write_text("\n".join(["stamp [us],rudder,heading", *rows]) + "\n", encoding="utf-8")
    found = {row["name"]: row["value"] for row in fitted(path)["parameters"]}
    assert found["K"] == pytest.approx(GAIN, abs=0.001)
    assert found["T"] == pytest.approx(LAG, abs=0.05)


def test_what_was_filled_forward_is_told_and_what_another_clock_costs(tmp_path: Path) -> None:
    columns = {
        "t": Column("time", "s"),
        "rudder": Column("rudder", "deg"),
        "heading": Column("heading", "deg"),
    }
    path = write(tmp_path / "log.csv", held(RUDDER, 4.6), held(HEADING, 5, 0.0))
    record = load_record(path, columns)
    _, clock, turned = map(str, record.findings)
    assert turned == "heading: filled forward: a reading each 5 rows; the others are left out"
    assert "rudder: filled forward: a reading each 4.6 rows" in clock
    assert "at times that the file does not know to a row (0.2 s): no band has that" in clock
    read = np.flatnonzero(np.isfinite(record.column("rudder")))
    assert np.median(record.t[read] % STEP) == pytest.approx(0.5 * STEP)
    assert math.degrees(np.nanmax(record.column("heading"))) == pytest.approx(HEADING.max(), abs=1)
