"""The boat's unit beside another in a scenario of the Open Simulation Platform."""

import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import pytest
from helpers.fmu import UNIT_MARKS, Unit, unpack
from helpers.fmu_flight import OPTIONS, TICKS
from helpers.orders import obey_all
from helpers.places import ROOT
from helpers.typed import type_command

from trainer.cli.export import boat_at_start
from trainer.cli.main import cli
from trainer.io.tables import MOTION_COLUMNS

pytestmark = UNIT_MARKS
FOLDER: Final = Path(__file__).parent
PAGE: Final = ROOT / "docs" / "fmu.md"
WANTED_DEPTH_M: Final = 90.0
NAMES: Final = tuple(name for name in MOTION_COLUMNS if name not in ("t", "tick"))


def write_planesman(path: Path) -> None:
    """Compile the planesman, and pack his unit."""
    library = path.with_suffix(".so")
    words = ["cc", "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "-o", str(library)]
    subprocess.run([*words, str(FOLDER / "planesman.c"), "-lm"], check=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(FOLDER / "planesman.xml", "modelDescription.xml")
        archive.write(library, "binaries/linux64/planesman.so")


def answer_of_planesman(z: float, theta: float) -> float:
    """Return what the planesman's unit answers to depth and pitch, in Python."""
    degrees = max(-10.0, min(10.0, 0.5 * (z - WANTED_DEPTH_M) - 60.0 * theta))
    return round(10.0 * degrees) / 10.0


def fly_in_trainer() -> list[list[float]]:
    """Fly the scenario by the trainer's boat, coupled as the platform's fixed step couples."""
    boat = boat_at_start(replace(OPTIONS, sea="sea-state-4"))
    angle, rows = 0.0, []
    obey_all(boat, "stern planes rise 0")
    obey_all(boat, "bow planes rise 0")
    for _ in range(TICKS):
        answer = answer_of_planesman(*boat.numbers(("z", "theta")))
        boat.tick()
        rows.append(boat.numbers(NAMES))
        if answer != angle:
            angle = answer
            obey_all(boat, f"stern planes {'rise' if angle >= 0.0 else 'dive'} {abs(angle)!r}")
    return rows


def fly_in_platform(folder: Path, unit: Unit) -> list[list[float]]:
    """Fly the scenario in a folder by libcosim."""
    execution: Any = pytest.importorskip("libcosimpy.CosimExecution")
    observer: Any = pytest.importorskip("libcosimpy.CosimObserver")
    log: Any = pytest.importorskip("libcosimpy.CosimLogging")
    log.log_output_level(log.CosimLogLevel.FATAL)
    platform = execution.CosimExecution.from_osp_config_file(str(folder))
    values = observer.CosimObserver.create_last_value()
    assert platform.add_observer(values)
    boat = platform.slave_index_from_instance_name("boat")
    places = [unit.variables[name].reference for name in NAMES]
    rows = []
    for _ in range(TICKS):
        assert platform.step(1)
        rows.append(list(values.last_real_values(boat, places)))
    return rows


@pytest.mark.slow
def test_a_planesman_of_another_unit_steers_the_boat_to_the_trainers_bits(tmp_path: Path) -> None:
    """It flies the scenario of the page."""
    pytest.importorskip("libcosimpy")
    type_command(cli, "export-fmu", tmp_path / "bb2.fmu")
    unit = unpack(tmp_path / "bb2.fmu", tmp_path / "unpacked")
    write_planesman(tmp_path / "planesman.fmu")
    structure = PAGE.read_text(encoding="utf-8").split("```xml\n")[1].split("```")[0]
    (tmp_path / "OspSystemStructure.xml").write_text(structure, encoding="utf-8")

    rows, expected = fly_in_platform(tmp_path, unit), fly_in_trainer()

    different = next((i for i, row in enumerate(rows) if row != expected[i]), None)
    assert different is None
    z = NAMES.index("z")
    assert abs(rows[-1][z] - WANTED_DEPTH_M) < 1.0 < abs(rows[0][z] - WANTED_DEPTH_M)
