"""The check cases, flown by units: each run from its exact start, by orders to the inputs."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
import pytest
from helpers.fmu import OK, UNIT_MARKS, Instance, begun, unpack
from helpers.lanes import sample_cases
from helpers.places import ROOT

from trainer.analysis.check_cases import boat_of_run, fly_cases, fly_run
from trainer.boat.export.fmu import fmu_bytes
from trainer.config.exercise.check_case import (
    CASE_CHANNELS,
    CaseRun,
    CheckCase,
    case_paths,
    load_case,
    parse_case,
)
from trainer.config.files import ConfigError

pytestmark = UNIT_MARKS
CASES: Final = {path.stem: path for path in case_paths(None)}
# what a simulator sets for the words of a case
INPUTS: Final[dict[str, dict[str, float]]] = {
    "bell stop": {"speed_by_hand": 1, "ordered_u_c": 0.0},
    "bow planes dive 10": {"bow_by_hand": 1, "ordered_b": -10.0},
    "bow planes rise 0": {"bow_by_hand": 1, "ordered_b": 0.0},
    "bow planes rise 10": {"bow_by_hand": 1, "ordered_b": 10.0},
    "casualty stern-hard-over -0.5": {"casualty_stern_hard_over": -0.5},
    "clear stern-hard-over": {"casualty_stern_hard_over": 0.0},
    "emergency blow": {"blow_forward": 2, "blow_mid": 2, "blow_aft": 2},
    "flood auxiliary 20 t": {"move_auxiliary": 20.0},
    "rudder right 10": {"rudder_by_hand": 1, "ordered_r": 10.0},
    "rudder right 5": {"rudder_by_hand": 1, "ordered_r": 5.0},
    "stern planes dive 10": {"stern_by_hand": 1, "ordered_s": -10.0},
    "stern planes dive 8": {"stern_by_hand": 1, "ordered_s": -8.0},
    "stern planes rise 0": {"stern_by_hand": 1, "ordered_s": 0.0},
    "stern planes rise 10": {"stern_by_hand": 1, "ordered_s": 10.0},
    "stern planes zero": {"stern_by_hand": 1, "ordered_s": 0.0},
}


def unit_of_run(case: CheckCase, run: CaseRun, version: int, folder: Path) -> Instance:
    """Return a run's boat in a unit, begun at the exact start of its case."""
    boat = boat_of_run(case, run)
    folder.mkdir()
    (file := folder / "case.fmu").write_bytes(fmu_bytes(boat, case.sea, version))
    flown = begun(unpack(file, folder))
    assert flown.numbers() == boat.records.state.tobytes()
    return flown


def fly_unit(case: CheckCase, run: CaseRun, flown: Instance) -> dict[str, list[float]]:
    """Fly a run in its unit; return the channels of the case at its times, in their units."""
    step = run.step_s or 0.0
    due = [math.ceil(entry.seconds / step - 1e-9) for entry in case.orders]
    samples = [round(t / step) for t in case.times]
    columns: dict[str, list[float]] = {name: [] for name in case.spread}
    stops = sorted({*samples, *due})
    for tick, until in pairwise([*stops, stops[-1]]):
        if tick in samples:
            for name, values in columns.items():
                channel = CASE_CHANNELS[name]
                values.append(flown.get(channel.state) * channel.factor)
        for at, entry in zip(due, case.orders, strict=True):
            if at == tick:
                for name, value in INPUTS[entry.order.text].items():
                    assert flown.set(name, value) == OK, flown.told[-1]
        if until > tick:
            assert flown.sail(tick * step, (until - tick) * step) == OK, flown.told[-1]
    return columns


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", sample_cases(CASES, "turn", "filter-sea"))
def test_a_unit_flies_a_check_case_as_the_trainer_does_to_the_last_bit(
    name: str, version: int, tmp_path: Path
) -> None:
    case = load_case(CASES[name])
    runs = [run for run in case.runs if run.integrator]
    assert len(runs) >= 2
    faults = []
    for i, run in enumerate(runs):
        expected = fly_run(case, run).columns
        columns = fly_unit(case, run, unit_of_run(case, run, version, tmp_path / str(i)))
        faults += [
            f"{run.name}: {channel}"
            for channel, values in columns.items()
            if not np.array_equal(values, expected[channel])
        ]
    assert not faults


def test_every_order_of_a_case_is_one_to_the_inputs_and_no_other() -> None:
    """A new case is flown by itself, and a new word of it wants its inputs here."""
    given = {entry.order.text for path in CASES.values() for entry in load_case(path).orders}

    assert given == set(INPUTS)


@pytest.mark.slow
def test_fmpy_flies_the_turn_as_the_page_has_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("fmpy")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "fmu.md").read_text(encoding="utf-8")
    example = page.split("## A check case")[1].split("```python\n")[1].split("```")[0]

    exec(example, {})  # noqa: S102
    (flight,) = fly_cases(case_paths(None), [tmp_path / "turn.unit.csv"])

    (beside,) = flight.others
    assert [each.channel for each in beside.differences] == [*flight.case.spread]
    assert {each.largest for each in beside.differences} == {0.0}


def case_in(world: str) -> CheckCase:
    """Return the turn, flown in another world."""
    text = CASES["turn"].read_text(encoding="utf-8")
    return parse_case(text.replace("[spread]", f"{world}\n[spread]"), CASES["turn"])


def test_a_level_ground_and_a_steady_current_stay_with_a_unit(tmp_path: Path) -> None:
    case = case_in("[bottom]\ndepth_m = 60.0\n[current]\nset_deg = 60.0\ndrift_kn = 1.0")
    run = case.runs[1]
    flown = unit_of_run(case, run, 2, tmp_path / "unit")

    columns = fly_unit(case, run, flown)

    assert columns == {name: [*each] for name, each in fly_run(case, run).columns.items()}
    assert np.all(boat_of_run(case, run).state.bottom[0] == 60.0)


@pytest.mark.parametrize(
    "world",
    [
        "[bottom]\ndepth_m = 60.0\nslope_percent = 1.0\ndeepens_deg = 90.0",
        "[current]\ntable = [[0.0, 0.0, 0.0], [50.0, 60.0, 1.0]]",
    ],
)
def test_a_world_that_changes_is_refused(world: str) -> None:
    case = case_in(world)

    with pytest.raises(ConfigError, match="a ground that is not level, a ship that pulls, and a"):
        fmu_bytes(boat_of_run(case, case.runs[0]), case.sea)
