"""The waves round the boat: at the boat the core's own, elsewhere those that others would meet."""

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import start_boat

from trainer.boat.boat import Boat
from trainer.boat.world.swell import (
    PACKING_DIGITS,
    REACH_STEPS,
    bank_outputs,
    pack_numbers,
    swell_round,
)
from trainer.config.world.sea import parse_sea
from trainer.core.sea.sea import advance_sea
from trainer.units import KNOT

G = 9.81
SEAS = {
    "filter": 'sea_state = 4\ngenerator = "filter"',
    "peaked": 'height_m = 2\nperiod_s = 9\nspectrum = "jonswap"\ngenerator = "filter"',
    "cosines": 'sea_state = 4\ngenerator = "cosines"',
    "1969": 'sea_state = 4\ngenerator = "filter-1969"',
}


def at_sea(text: str, direction: float = 120.0, seed: int = 3) -> Boat:
    """Return BB2 at periscope depth in a sea."""
    boat = start_boat(6.0 * KNOT, 17.5, 0.3, seed=seed, equations="modified")
    boat.put_to_sea(parse_sea(f"[sea]\n{text}\ndirection_deg = {direction}\n", Path("my-sea.toml")))
    return boat


def run(boat: Boat, ticks: int, speed: float = 0.0) -> None:
    """Let the sea alone run on over a boat that goes north [m/s]."""
    records = boat.records
    boat.state.through_north, boat.state.through_east = speed, 0.0
    for _ in range(ticks):
        advance_sea(records.vessel, boat.method.step, records.scratch, records.state)
        boat.state.tick += 1.0


@pytest.mark.parametrize("name", SEAS)
def test_at_the_boat_the_waves_are_the_core_s_to_rounding(name: str) -> None:
    boat = at_sea(SEAS[name])
    for _ in range(60):
        assert boat.tick() == 0
        assert swell_round(boat.plain, G).level(0.0, 0.0) == pytest.approx(
            float(boat.state.eta_wave), abs=1e-12
        )


@pytest.mark.parametrize(("ahead", "right"), [(80.0, 0.0), (-35.0, 60.0)])
def test_cosines_elsewhere_are_those_above_a_boat_that_is_there(ahead: float, right: float) -> None:
    boat = at_sea(SEAS["cosines"])
    run(boat, 5)
    there = swell_round(boat.plain, G).level(ahead, right)
    heading, direction = float(boat.state.psi), float(boat.state.sea_direction)
    number = float(boat.state.sea_omega) ** 2 / G
    north = ahead * math.cos(heading) - right * math.sin(heading)
    east = ahead * math.sin(heading) + right * math.cos(heading)
    boat.state.sea_along += number * (north * math.cos(direction) + east * math.sin(direction))
    boat.state.sea_across += number * (east * math.cos(direction) - north * math.sin(direction))
    before = boat.snapshot()
    run(boat, 0)
    boat.state.sea_turned -= boat.state.sea_omega * boat.method.step
    run(boat, 1)
    assert float(boat.state.eta_wave) == pytest.approx(there, abs=1e-9)
    boat.restore(before)


@pytest.mark.parametrize("speed", [2.0, -3.0])
def test_groups_elsewhere_are_those_that_a_boat_meets_which_runs_there(speed: float) -> None:
    still, runs = (at_sea(SEAS["filter"], direction=180.0) for _ in range(2))
    for boat in (still, runs):
        boat.state.psi = boat.state.sea_direction = 0.0  # waves go north, and so does the bow
    run(still, 40)
    run(runs, 40, speed)
    swell = swell_round(still.plain, G)
    assert swell.level(speed * 40 * 0.5, 0.0) == pytest.approx(float(runs.state.eta_wave), abs=1e-6)
    assert abs(float(runs.state.eta_wave) - float(still.state.eta_wave)) > 0.01


@pytest.mark.parametrize("bank", [0, 1])
def test_the_outputs_of_any_step_are_the_core_s(bank: int) -> None:
    boat = at_sea(SEAS["peaked" if bank else "filter"])
    run(boat, 400)
    step = int(boat.state.sea_steps)
    mine = bank_outputs(int(boat.state.seed), bank, step - 4, step)
    theirs = [complex(*boat.state.sea_past[each & 3, :2]) for each in range(step - 4, step)]
    assert mine == pytest.approx(np.array(theirs), abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("name", ["filter", "cosines"])
def test_waves_elsewhere_are_as_high_as_at_the_boat(name: str) -> None:
    levels = []
    for seed in range(40):
        swell = swell_round(at_sea(SEAS[name], seed=seed).plain, G)
        levels += [swell.level(x, y) for x in (-150.0, -60.0, 60.0, 150.0) for y in (-70.0, 70.0)]
    assert 4.0 * np.std(levels) == pytest.approx(swell.height, rel=0.1)
    assert np.mean(levels) == pytest.approx(0.0, abs=0.1 * swell.height)


def test_what_is_packed_can_be_unpacked_and_fits_a_line() -> None:
    text = pack_numbers(np.array([-1.0, 0.0, 0.9999]), 2)
    whole = [
        64 * PACKING_DIGITS.index(text[i]) + PACKING_DIGITS.index(text[i + 1]) for i in (0, 2, 4)
    ]
    assert whole == [0, 2048, 4095]
    boat = at_sea(SEAS["filter"])
    boat.state.sea_cosines = 0.5  # as while one sea becomes another
    swell = swell_round(boat.plain, G)
    groups, waves = swell.packed_groups() or "", swell.packed_waves() or ""
    assert (len(groups), len(waves)) == (8 * REACH_STEPS, 450)
    assert len(groups) + len(waves) < 1800  # and the rest of a line of 2000
