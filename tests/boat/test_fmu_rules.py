"""The standard's formal rules on the model description of a unit."""

import shutil
import subprocess
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Final

import pytest
from helpers.fmu import UNIT_MARKS
from helpers.typed import type_command

from trainer.cli.main import cli

pytestmark = UNIT_MARKS
# what the table of the standard (2.2.7 of FMI 2.0, 2.4.7.4 of FMI 3.0) leaves for variables that
# say nothing of `initial`: whether a start value is to be there
START_RULES: Final = {
    ("parameter", "fixed"): True,
    ("input", "discrete"): True,
    ("output", "continuous"): False,
    ("local", "continuous"): False,
    ("independent", "continuous"): False,
}
UNKNOWN_PATHS: Final = {2: "ModelStructure/InitialUnknowns/*", 3: "ModelStructure/InitialUnknown"}


def write_description(folder: Path, version: int, vessel: str) -> Path:
    """Return the model description of a vessel's unit, written into a folder."""
    path = folder / "boat.fmu"
    words = ["export-fmu", str(path), "--vessel", vessel, "--fmi", str(version)]
    type_command(cli, *words)
    with zipfile.ZipFile(path) as archive:
        return Path(archive.extract("modelDescription.xml", folder))


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("vessel", ["bb2", "remus100"])
def test_each_variable_has_what_the_table_of_the_standard_asks_of_it(
    vessel: str, version: int, tmp_path: Path
) -> None:
    root = ET.parse(write_description(tmp_path, version, vessel)).getroot()  # noqa: S314
    variables = root.findall("ModelVariables/*")
    names = [each.attrib["name"] for each in variables]
    units = {each.attrib["name"] for each in root.findall("UnitDefinitions/Unit")}
    faults = []
    for each in variables:
        facts = (each[0] if version == 2 else each).attrib
        start = facts.get("start")
        kind = (each.attrib["causality"], each.attrib["variability"])
        if START_RULES.get(kind) is not (start is not None):
            faults.append(f"{each.attrib['name']}: {kind} with start {start}")
        if "min" in facts and not (
            float(facts["min"]) <= float(facts["start"]) <= float(facts["max"])
        ):
            faults.append(f"{each.attrib['name']}: start {start} is beyond {facts}")
        if facts.get("unit", "s") not in units:
            faults.append(f"{each.attrib['name']}: no unit {facts['unit']}")
    outputs = [each for each in variables if each.attrib["causality"] == "output"]
    places = [each.attrib["valueReference"] for each in outputs]
    if version == 2:
        places = [str(variables.index(each) + 1) for each in outputs]
    unknown = [
        each.attrib["index" if version == 2 else "valueReference"]
        for each in root.findall(UNKNOWN_PATHS[version])
    ]

    assert not faults
    assert len(set(names)) == len(names) > 200
    assert [int(each.attrib["valueReference"]) for each in variables] == [*range(len(names))]
    assert unknown == places


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("vessel", ["bb2", "remus100"])
def test_the_formal_model_of_the_standard_finds_nothing_wrong(
    vessel: str, version: int, tmp_path: Path
) -> None:
    """The model is in VDM-SL: https://github.com/INTO-CPS-Association/FMI-VDM-Model."""
    program = shutil.which(f"VDMCheck{version}.sh")
    if program is None:
        pytest.skip(f"no VDMCheck{version}.sh here: its release's folder belongs on PATH")
    description = write_description(tmp_path, version, vessel)

    def check() -> str:
        words = [program, str(description)]
        return subprocess.run(words, capture_output=True, text=True, check=False).stdout

    assert check() == "No errors found.\n"
    text = description.read_text(encoding="utf-8").replace('"independent"', '"input"')
    description.write_text(text, encoding="utf-8")
    assert "validVariableAttributes" in check()
