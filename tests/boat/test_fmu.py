"""The functional mock-up unit of a boat: co-simulation by FMI 2.0 and 3.0."""

import ctypes
import math
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from helpers.fmu import ERROR, NO, NOTHING, OK, UNIT_MARKS, YES, Instance, Unit, begun, unpack
from helpers.fmu_flight import OPTIONS, ORDERS, TICKS
from helpers.fmu_judges import EcosJudge
from helpers.nursery import run_trainer
from helpers.orders import obey_all
from helpers.places import ROOT
from helpers.typed import type_command

from trainer.boat.casualties import instrument_readings
from trainer.boat.export.fmu import fmu_bytes
from trainer.boat.export.header import record_members
from trainer.boat.export.orders import order_rows
from trainer.boat.platforms import SHIPPED_PLATFORMS
from trainer.cli.export import boat_at_start
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.core.state import STATE
from trainer.io.tables import MOTION_COLUMNS
from trainer.units import KNOT

PAGE = ROOT / "docs" / "fmu.md"
MAX_BYTES = 300_000  # of a unit
pytestmark = UNIT_MARKS


@pytest.fixture(scope="module", params=["2", "3"])
def folder(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Path:
    """Return the folder of BB2's unit by a version of FMI, packed and unpacked."""
    path = tmp_path_factory.mktemp("fmu")
    type_command(cli, "export-fmu", path / "bb2.fmu", "--fmi", request.param)
    unpack(path / "bb2.fmu", path)
    return path


@pytest.fixture
def unit(folder: Path) -> Unit:
    """Return BB2's unit."""
    return Unit(folder)


def fly(boat: Instance, ticks: int = TICKS) -> None:
    """Fly the run by orders in a unit."""
    for tick in range(ticks):
        for at, _, values in ORDERS:
            if at == tick:
                assert [boat.set(name, value) for name, value in values.items()] == [OK] * len(
                    values
                ), boat.told[-1]
        assert boat.step() == OK, boat.told[-1]


# The bits


@pytest.mark.parametrize(
    ("sea", "seed", "start"),
    [
        ("calm", 1, {}),
        ("sea-state-4", 7, {"sea_state": 4, "seed": 7, "sea_from": 250.0}),
    ],
)
def test_a_run_by_orders_is_the_trainers_to_the_last_bit(
    unit: Unit, sea: str, seed: int, start: dict[str, float]
) -> None:
    boat = boat_at_start(replace(OPTIONS, sea="calm", seed=seed))
    file = load_sea(sea)
    boat.put_to_sea(replace(file, sea=replace(file.sea, direction_deg=start.get("sea_from", 0.0))))
    flown = begun(unit, **start)
    assert flown.numbers() == boat.records.state.tobytes()

    for tick in range(TICKS):
        for at, text, values in ORDERS:
            if at == tick:
                obey_all(boat, text)
                for name, value in values.items():
                    assert flown.set(name, value) == OK, flown.told[-1]
        assert boat.tick() == flown.step() == OK
        assert flown.numbers() == boat.records.state.tobytes(), tick

    assert flown.get("time") == flown.time == TICKS / 2.0
    shown = [flown.get(name) for name in MOTION_COLUMNS if name != "t"]
    assert shown == boat.numbers(tuple(name for name in MOTION_COLUMNS if name != "t"))
    readings = instrument_readings(boat)
    assert flown.get("gyro") == readings.heading / math.radians(1.0) != flown.get("psi")
    assert flown.get("log") == readings.speed / KNOT
    assert (boat.state.eta_wave != 0.0) == (sea != "calm")


def test_a_boat_in_the_sea_of_its_export_is_the_trainers(tmp_path: Path) -> None:
    options = replace(OPTIONS, vessel="remus100", sea="sea-state-3", seed=5)
    path = tmp_path / "remus.fmu"
    done = CliRunner().invoke(
        cli,
        [
            *("export-fmu", str(path), "--vessel", "remus100", "--sea", "sea-state-3"),
            *("--seed", "5", "--integrator", "rk4"),
        ],
    )
    assert done.exit_code == 0, done.output
    boat = boat_at_start(replace(options, integrator="rk4"))
    flown = begun(unpack(path, tmp_path / "remus"))
    ticks = round(30.0 / boat.method.step)

    for _ in range(ticks):
        assert boat.tick() == OK
    assert flown.step(10, boat.method.step * ticks / 10) == OK  # many ticks in a step

    assert flown.numbers() == boat.records.state.tobytes()


def test_a_value_that_is_set_again_at_each_step_changes_nothing(unit: Unit) -> None:
    once, often = begun(unit), begun(unit)
    values = {"ordered_psi": 200.0, "ordered_depth": 80.0, "casualty_bow_slow": 0.5}

    for tick in range(400):
        for name, value in values.items():
            often.set(name, value)
            if tick == 0:
                once.set(name, value)
        assert once.step() == often.step() == OK

    assert once.numbers() == often.numbers()
    for name, value in values.items():
        assert often.get(name) == pytest.approx(value, rel=1e-15)


def test_a_simulator_may_set_all_that_it_has_ever_given_at_each_step(unit: Unit) -> None:
    """The boat pumps its 3 t once, and goes on ascending after it has blown."""
    once, held = begun(unit), begun(unit)
    values: dict[str, float] = {}

    for tick in range(TICKS):
        new = {name: x for at, _, given in ORDERS if at == tick for name, x in given.items()}
        values |= new
        assert {once.set(name, value) for name, value in new.items()} <= {OK}
        assert {held.set(name, value) for name, value in values.items()} <= {OK}
        assert once.step() == held.step() == OK

    assert once.numbers() == held.numbers()


# States


def test_a_state_goes_on_in_another_instance_and_in_another_process(
    unit: Unit, folder: Path, tmp_path: Path
) -> None:
    whole, first, second = begun(unit), begun(unit), Instance(unit)
    fly(whole, 700)
    fly(first, 600)
    kept = first.serialised()
    (file := tmp_path / "state").write_bytes(kept)

    assert second.restore(kept) == OK
    second.time = 300.0
    for boat in (first, second):
        assert boat.set("casualty_stern_hard_over", 0.0) == OK
    assert first.step(40) == second.step(40) == OK
    assert first.serialised() == second.serialised()

    assert second.restore(kept) == OK
    second.time = 300.0
    assert second.step(100) == OK
    child = [sys.executable, "-m", "helpers.fmu", str(folder), str(file), "100"]
    path = os.pathsep.join([str(ROOT / "tests"), str(ROOT)])
    subprocess.run(child, check=True, env=os.environ | {"PYTHONPATH": path})
    assert file.read_bytes() == second.serialised() != whole.serialised()


def test_a_boat_that_is_reset_is_as_new(unit: Unit) -> None:
    new, again = begun(unit, sea_state=4), begun(unit, sea_state=5, seed=9)
    fly(again, 300)

    assert again.call("Terminate") == OK
    assert again.call("Reset") == OK
    again.begin(sea_state=4)
    fly(new, 300)
    fly(again, 300)

    assert new.serialised() == again.serialised()


def test_two_boats_at_once_do_not_disturb_each_other(unit: Unit) -> None:
    alone, one, other = begun(unit, sea_state=5), begun(unit, sea_state=5), begun(unit)
    fly(alone, 300)

    for tick in range(300):
        for at, _, values in ORDERS:
            if at == tick:
                assert [one.set(name, value) for name, value in values.items()]
        assert one.step() == OK
        assert other.step() == OK

    assert alone.serialised() == one.serialised() != other.serialised()


def test_a_thousand_resets_instances_and_states_leave_no_memory_behind(unit: Unit) -> None:
    def rounds(count: int) -> None:
        boat = begun(unit, sea_state=4)
        for _ in range(count):
            kept = boat.serialised()
            assert boat.call("Reset") == OK
            boat.begin(sea_state=4)
            assert boat.step(2) == OK
            assert boat.restore(kept) == OK
            other = begun(unit)
            other.free()
        boat.free()

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    rounds(100)
    before = resident()
    rounds(1000)

    assert resident() - before < 1_000_000  # an instance and its state have 20 kB


# What is refused


def limit_faults(boat: Instance) -> list[str]:
    """Return inputs that refuse a limit of theirs, or take what is beyond it."""
    faults = []
    for name, place in boat.unit.variables.items():
        if place.causality != "input" or place.kind == "Boolean" or "casualty" in name:
            continue
        low, high = (
            int(end) if place.kind.startswith("Int") else float(end)
            for end in (place.facts["min"], place.facts["max"])
        )
        beyond = 1 if place.kind.startswith("Int") else 1e-4
        answers = [boat.set(name, x) for x in (low, high, low - beyond, high + beyond)]
        if answers != [OK, OK, ERROR, ERROR]:
            faults.append(f"{name} {answers}")
    return faults


def test_each_input_takes_its_limits_and_nothing_beyond_them(unit: Unit) -> None:
    boat = begun(unit)

    assert not limit_faults(boat)
    assert "must be 0 to 250 m" in next(told for told in boat.told if "ordered_depth" in told)


FAULTS: list[tuple[Callable[[Instance], Any], str]] = [
    (lambda b: b.set("ordered_depth", math.nan), "ordered_depth (12) = nan: must be 0 to 250 m"),
    (lambda b: b.set("ordered_r", 31.0), "ordered_r (3) = 31: must be -30 to 30 deg"),
    (lambda b: b.set("blow_mid", 3), "= 3: must be 0 to 2"),
    (lambda b: b.set("casualty_stern_hard_over", -1.5), "= -1.5: must be -1 to 1"),
    (lambda b: b.set("z", 10.0), ") = 10: can only be read"),
    (lambda b: b.set("seed", 3), "a parameter is set before initialization ends"),
    (lambda b: b.step(size=0.3), "step of 0.3 s: must be 0.5 s or its multiple"),
    (lambda b: b.step(size=0.0), "step of 0 s"),
    (lambda b: b.step(size=math.nan), "step of nan s"),
    (lambda b: b.step(size=math.inf), "step of inf s"),
    (lambda b: b.sail(7.0, 0.5), "from 7 s: the last step ended at 5"),
    (lambda b: b.set("time", 3.0), ") = 3: can only be read"),
    (lambda b: b.call("ExitInitializationMode"), "not in this phase"),
    (lambda b: b.restore(b.serialised()[:-8]), "no state of this model"),
    (lambda b: b.restore(b"x" + b.serialised()[1:]), "no state of this model"),
    (lambda b: b.call("GetString"), "GetString: none"),
    (lambda b: bad_reference(b, "Set", 9999), "no REAL (9999) = 1: no such value reference"),
    (lambda b: bad_reference(b, "Set", 3, 9999), "no REAL (9999)"),
    (lambda b: bad_reference(b, "Get", 9999), "no REAL has value reference 9999"),
    (lambda b: bad_reference(b, "Set", 0), "no REAL (0)"),  # which is an Integer
]


BOOLEAN_FAULT = (lambda b: b.set("rudder_by_hand", 2), "= 2: must be 0 to 1")  # a bool in FMI 3.0


def bad_reference(boat: Instance, verb: str, *references: int) -> int:
    """Set or get real numbers by value references, of which the last is none."""
    places = (ctypes.c_uint * len(references))(*references)
    numbers = (ctypes.c_double * len(references))(*[1.0] * len(references))
    count = ctypes.c_size_t(len(references))
    there = (places, count, numbers, count)
    return boat.call(f"{verb}{boat.unit.real}", *there[: boat.unit.version + 1])


def test_what_is_refused_is_told_and_leaves_the_boat_as_it_was(unit: Unit) -> None:
    boat = begun(unit)
    assert boat.step(10) == OK
    before, faults = boat.serialised(), []
    known = [*FAULTS, BOOLEAN_FAULT] if unit.version == 2 else FAULTS
    for number, (fault, message) in enumerate(known):
        if fault(boat) != ERROR or message.replace("REAL", unit.real) not in boat.told[-1]:
            faults.append(f"{number} {message!r}: {boat.told[-1]!r}")
        if boat.serialised() != before:
            faults.append(f"{number} {message!r} changed the boat")

    assert not faults
    assert boat.step() == OK


def test_nine_casualties_and_a_step_before_the_start_are_refused(unit: Unit) -> None:
    boat = begun(unit)
    names = [name for name in unit.variables if name.startswith("casualty_")][:9]

    answers = [boat.set(name, 1) for name in names]
    early = Instance(unit)

    assert answers == [OK] * 8 + [ERROR]
    assert "as many casualties as can be" in boat.told[-1]
    assert boat.set(names[0], 0) == OK
    assert boat.step(600) == OK
    assert boat.set(names[8], 1) == OK
    assert early.step() == ERROR
    assert "not in this phase" in early.told[-1]


def test_a_unit_of_another_guid_is_no_instance(unit: Unit) -> None:
    unit.guid = b"{00000000-0000-0000-0000-000000000000}"

    with pytest.raises(AssertionError):
        Instance(unit)


def test_what_fmi_3_has_beside_co_simulation_is_told_as_lacking(tmp_path: Path) -> None:
    type_command(cli, "export-fmu", tmp_path / "x.fmu", "--fmi", "3")
    unit = unpack(tmp_path / "x.fmu", tmp_path)
    boat = Instance(unit)
    for interface in ("ModelExchange", "ScheduledExecution"):
        assert not boat.make(interface)
        assert "none; this unit is for co-simulation" in boat.told[-1]
    events = unit.function("InstantiateCoSimulation")
    asked = (YES, NO, NOTHING, ctypes.c_size_t(0), NOTHING, NOTHING, NOTHING)
    assert not events(b"boat", unit.guid, b"", NO, NO, *asked)


def test_both_versions_are_written_beside_each_other_and_sail_the_same_bits(
    tmp_path: Path,
) -> None:
    type_command(cli, "export-fmu", tmp_path / "x.fmu", "--fmi", "both")
    names = ("x", "x-fmi3")
    boats = [begun(unpack(tmp_path / f"{name}.fmu", tmp_path / name)) for name in names]
    for boat in boats:
        fly(boat, 300)

    assert [boat.unit.version for boat in boats] == [2, 3]
    assert boats[0].numbers() == boats[1].numbers()


# The file


def test_two_exports_have_the_same_bytes_and_what_is_inside_is_small_and_whole(
    folder: Path, unit: Unit, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "cc -Wall -Werror")
    path, version = folder / "bb2.fmu", unit.version
    again = fmu_bytes(boat_at_start(replace(OPTIONS, sea="calm")), load_sea("calm"), version)
    place = SHIPPED_PLATFORMS["linux-x86_64"].unit_folders[version - 2]
    binary = f"binaries/{place}/trainer_bb2.so"

    assert again == path.read_bytes()
    assert len(again) < MAX_BYTES
    with zipfile.ZipFile(path) as archive:
        assert archive.namelist() == [
            "modelDescription.xml",
            binary,
            "documentation/index.html",
            "documentation/licenses/license.txt",
        ]
        assert "ordered_depth" in archive.read("documentation/index.html").decode()
        assert b"Permission is hereby granted" in archive.read("documentation/licenses/license.txt")
        assert b"libpython" not in archive.read(binary)
    sailing = boat_at_start(replace(OPTIONS, sea="calm", seed=2))
    other = fmu_bytes(sailing, load_sea("calm"), version)
    assert other != again


def test_every_place_that_an_order_writes_a_number_to_is_an_input(unit: Unit) -> None:
    boat = boat_at_start(replace(OPTIONS, sea="calm"))
    written = {
        int(write.partition("=")[0])
        for row in order_rows(boat)
        for write in row.split(";")[-1].split(",")
        if "=number" in write or "=short:" in write
    }
    inputs = [name for name, place in unit.variables.items() if place.causality == "input"]
    names = {place: name for name, place in reversed(list(boat_places()))}

    assert {names[place] for place in written} <= set(inputs)
    assert len(written) >= 10


def boat_places() -> list[tuple[str, int]]:
    """Return the places of the single numbers of a state."""
    return [(name, offset // 8) for name, offset, shape in record_members(STATE) if not shape]


def test_each_output_but_pure_numbers_has_a_unit(unit: Unit) -> None:
    outputs = {n: p for n, p in unit.variables.items() if p.causality == "output"}
    bare = {name for name, place in outputs.items() if "unit" not in place.facts}

    assert bare == {"tick", "validity"}
    assert outputs["z"].facts["unit"] == outputs["z_g"].facts["unit"] == "m"
    assert outputs["delta_b"].facts["unit"] == "rad"
    assert {name for name in MOTION_COLUMNS if name != "t"} <= set(outputs)


@pytest.mark.parametrize(
    ("compiler", "words", "told"),
    [
        (
            "no-such",
            "bb2.fmu",
            "there is no 'no-such' here. Debian and Ubuntu: apt install gcc; CC names another",
        ),
        ("false", "bb2.fmu", "linux-x86_64: false: no word; Debian and Ubuntu: apt install gcc"),
        ("cc", f"bb2.fmu --seed {2**40}", "--seed 1099511627776: must be at most 2147483647"),
        ("cc", "bb2.html", ".fmu"),
        ("cc", "no/folder/bb2.fmu", "there is no folder no/folder"),
    ],
)
def test_what_cannot_be_exported_is_told_in_a_line_and_nothing_is_written(
    compiler: str, words: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", compiler)
    done = run_trainer("export-fmu", *words.split(), cwd=tmp_path)

    assert done.returncode == 2
    assert told in done.stderr
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_core_that_is_not_the_objects_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trainer.boat.export.fmu.shipped_object", lambda _name: None)

    with pytest.raises(ConfigError, match="export-core trainer/boat/shipped --cpu shipped"):
        fmu_bytes(boat_at_start(replace(OPTIONS, sea="calm")), load_sea("calm"))


def test_a_sea_that_the_step_is_too_long_for_is_refused(tmp_path: Path) -> None:
    words = ["export-fmu", str(tmp_path / "slow.fmu"), "--step", "2", "--unsafe-step"]
    done = CliRunner().invoke(cli, words)
    boat = Instance(unpack(tmp_path / "slow.fmu", tmp_path))

    assert done.exit_code == 0
    assert boat.set("sea_state", 1) == ERROR
    assert "above Nyquist for this step" in boat.told[-1]
    assert boat.set("sea_state", 6) == OK


# Another's simulator


@pytest.mark.slow
def test_fmpy_finds_nothing_wrong_and_flies_the_trainers_bits(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It runs the example of the page, whose last line prints where the boat has come to."""
    pytest.importorskip("fmpy")
    validation = pytest.importorskip("fmpy.validation")
    monkeypatch.chdir(folder)
    names = tuple(name for name in MOTION_COLUMNS if name not in ("t", "tick"))
    example = PAGE.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    scope: dict[str, Any] = {}

    assert validation.validate_fmu("bb2.fmu") == []
    exec(example.replace('["z", "psi"]', repr(names)), scope)  # noqa: S102

    boat = boat_at_start(replace(OPTIONS, sea="sea-state-4", seed=7))
    rows = [boat.numbers(names)]
    for tick in range(TICKS):
        if tick == 60:
            obey_all(boat, "depth 90")
        if tick == 180:
            obey_all(boat, "course 100")
        boat.tick()
        rows.append(boat.numbers(names))
    assert [[row[name] for name in names] for row in scope["flown"]] == rows


@pytest.mark.slow
def test_another_simulator_flies_ten_minutes_by_orders_with_the_trainers_bits(
    tmp_path: Path,
) -> None:
    path = tmp_path / "bb2.fmu"
    type_command(cli, "export-fmu", path)
    names = tuple(name for name in MOTION_COLUMNS if name not in ("t", "tick"))
    flown = EcosJudge(path, unpack(path, tmp_path), 0.5, {"sea_state": 4, "seed": 7})
    boat = boat_at_start(replace(OPTIONS, sea="sea-state-4", seed=7))

    for tick in range(TICKS):
        for at, text, values in ORDERS:
            if at == tick:
                obey_all(boat, text)
                for name, value in values.items():
                    flown.set(name, value)
        boat.tick()
        flown.fly_step()
        assert flown.numbers(names) == boat.numbers(names), tick


def test_the_page_names_every_input_that_is_no_casualty(unit: Unit) -> None:
    page = PAGE.read_text(encoding="utf-8")
    chosen = {n for n, p in unit.variables.items() if p.causality in ("input", "parameter")}
    broken = {name for name in chosen if name.startswith("casualty_")}

    assert [name for name in chosen - broken if f"`{name}`" not in page] == []
    assert f"and {len(broken) - 1} others" in page
