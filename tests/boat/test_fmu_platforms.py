"""A unit for several platforms: each library sails the trainer's bits on its machine."""

import os
import shlex
import subprocess
import zipfile
from pathlib import Path
from typing import Final, NamedTuple

import pytest
from click.testing import CliRunner
from helpers.fmu import GUID_BYTES, UNIT_MARKS, Unit, unpack
from helpers.fmu_flight import ORDERS, TICKS, state_of_trainer
from helpers.installation import installed, run_program
from helpers.nursery import run_trainer
from helpers.places import ROOT
from helpers.typed import type_command

from trainer.boat.export.fmu import LIBRARY_ENDINGS
from trainer.boat.platforms import (
    NATIVE_PLATFORMS,
    SHIPPED_PLATFORMS,
    UNIT_PLATFORMS,
    platform_name,
)
from trainer.cli.export import NATIVE_PLATFORM_NAMES, UNIT_PLATFORM_NAMES
from trainer.cli.main import cli
from trainer.core.state import STATE

pytestmark = UNIT_MARKS
HOST: Final = Path(__file__).with_name("fmu_host.c")
PAGE: Final = ROOT / "docs" / "fmu.md"
KIND_LETTERS: Final = {"Real": "r", "Float64": "r", "Integer": "i", "Int32": "i", "Boolean": "b"}
MAX_BYTES: Final = 330_000  # of a unit for all platforms


class Machine(NamedTuple):
    """What runs a program of another platform here, and Debian's packages of it."""

    program: str
    packages: str
    words: tuple[str, ...] = ()
    environment: tuple[tuple[str, str], ...] = ()


MACHINES: Final = {
    "linux-aarch64": Machine("qemu-aarch64", "qemu-user", ("-L", "/usr/aarch64-linux-gnu")),
    "windows-x86_64": Machine("wine", "wine wine64", (), (("WINEDEBUG", "-all"),)),
}


def need_linkers(*names: str) -> None:
    """Have the linkers of platforms, or do without the test."""
    for name in names:
        target = SHIPPED_PLATFORMS[name]
        if name != platform_name():
            installed(target.compiler, target.packages)


def export_for(path: Path, fmi: str, *platforms: str) -> None:
    """Write BB2's unit for platforms."""
    asked = [word for name in platforms for word in ("--platform", name)]
    type_command(cli, "export-fmu", path, "--fmi", fmi, *asked)


def library_path(folder: Path, name: str, version: int) -> Path:
    """Return where the library for a platform lies in an unpacked unit."""
    ending = LIBRARY_ENDINGS[name.partition("-")[0]]
    place = SHIPPED_PLATFORMS[name].unit_folders[version - 2]
    return folder / "binaries" / place / f"trainer_bb2{ending}"


def script_of_run(
    unit: Unit, start: dict[str, float], begin: int = 0, end: int = TICKS, kept: int = 0
) -> str:
    """Return the run by orders in the host's words, from a tick to a later one.

    ``kept`` is the size [bytes] of a state of the first tick that it goes on from; 0: it starts.
    """
    lines = []

    def add(values: dict[str, float]) -> None:
        for name, value in values.items():
            place = unit.variables[name]
            lines.append(f"{KIND_LETTERS[place.kind]} {place.reference} {value!r}")

    add(start)
    lines.append("g 0 0")
    if kept:
        lines.append(f"k {kept} {begin * 0.5!r}")
    ends = [at for at, *_ in ORDERS[1:]] + [TICKS]
    for (at, _, values), until in zip(ORDERS, ends, strict=True):
        if begin <= at < end:
            add(values)
        if (count := min(until, end) - max(at, begin)) > 0:
            lines.append(f"s {count} 0.5")
    return "\n".join(lines) + "\n"


def sail_unit(name: str, unit: Unit, folder: Path, script: str, state: str = "state") -> bytes:
    """Return the state after a script, by the library for a platform in an unpacked unit."""
    own = name == platform_name()
    compiler = shlex.split("cc" if own else SHIPPED_PLATFORMS[name].compiler)
    host = folder / f"host-{name}.exe"
    compiler = [*compiler, f"-DVERSION={unit.version}"]
    subprocess.run([*compiler, "-o", str(host), str(HOST)], check=True)
    library = library_path(folder, name, unit.version).relative_to(folder)
    words = [f"./{host.name}", str(library), unit.guid.decode(), state]
    environment = dict(os.environ)
    if not own:
        machine = MACHINES[name]
        words = [installed(machine.program, machine.packages), *machine.words, *words]
        environment |= dict(machine.environment) | {"WINEPREFIX": str(folder / "wine")}
    flown = subprocess.run(
        words,
        input=script.encode(),
        cwd=folder,
        env=environment,
        capture_output=True,
        check=False,
        timeout=300,
    )
    assert flown.returncode == 0, flown.stdout.decode() + flown.stderr.decode()
    return (folder / state).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", MACHINES)
def test_a_library_for_another_platform_sails_the_trainers_bits(
    name: str, version: int, tmp_path: Path
) -> None:
    need_linkers(name)
    export_for(tmp_path / "bb2.fmu", str(version), platform_name(), name)
    unit = unpack(tmp_path / "bb2.fmu", tmp_path)

    state = sail_unit(name, unit, tmp_path, script_of_run(unit, {"sea_state": 4, "seed": 7}))

    assert state[GUID_BYTES : GUID_BYTES + STATE.itemsize] == state_of_trainer()
    assert state[: len(unit.guid)] == unit.guid


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", MACHINES)
def test_a_state_of_one_platform_goes_on_at_another_and_comes_back(
    name: str, version: int, tmp_path: Path
) -> None:
    need_linkers(name)
    export_for(tmp_path / "bb2.fmu", str(version), platform_name(), name)
    unit = unpack(tmp_path / "bb2.fmu", tmp_path)
    sea: dict[str, float] = {"sea_state": 4, "seed": 7}
    kept = b""
    parts = (platform_name(), 0, 301), (name, 301, 777), (platform_name(), 777, TICKS)

    for place, begin, end in parts:
        start: dict[str, float] = {} if kept else sea
        kept = sail_unit(place, unit, tmp_path, script_of_run(unit, start, begin, end, len(kept)))

    assert kept[GUID_BYTES : GUID_BYTES + STATE.itemsize] == state_of_trainer()


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_one_file_has_the_libraries_of_all_platforms_and_the_same_bytes_each_time(
    version: int, tmp_path: Path
) -> None:
    need_linkers(*NATIVE_PLATFORMS)
    first, again, alone = (tmp_path / f"{name}.fmu" for name in ("first", "again", "alone"))
    export_for(first, str(version), "all")
    export_for(again, str(version), *reversed(NATIVE_PLATFORMS))
    export_for(alone, str(version))

    assert first.read_bytes() == again.read_bytes()
    assert first.stat().st_size < MAX_BYTES
    unit, own = unpack(first, tmp_path / "first"), unpack(alone, tmp_path / "alone")
    assert unit.guid == own.guid  # a state of one goes on in the other
    with zipfile.ZipFile(first) as archive, zipfile.ZipFile(alone) as smaller:
        names = [name for name in archive.namelist() if name.startswith("binaries/")]
        assert names == [str(library_path(Path(), name, version)) for name in NATIVE_PLATFORMS]
        assert [name for name in smaller.namelist() if name.startswith("binaries/")] == names[:1]
        for name in smaller.namelist():
            assert archive.read(name) == smaller.read(name), name


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_the_windows_library_shows_the_standards_functions_alone_and_needs_only_the_system(
    version: int, tmp_path: Path
) -> None:
    need_linkers("windows-x86_64")
    export_for(tmp_path / "bb2.fmu", str(version), platform_name(), "windows-x86_64")
    unit = unpack(tmp_path / "bb2.fmu", tmp_path)
    library = library_path(tmp_path, "windows-x86_64", version)
    words = ["x86_64-w64-mingw32-objdump", "-p", str(library)]
    lines = run_program(words).stdout.splitlines()
    needed = {line.split()[-1].lower() for line in lines if "DLL Name:" in line}
    shown = {line.split()[-1] for line in lines if f" fmi{version}" in line}
    listed = run_program(["nm", "-D", "--defined-only", str(unit.path)])
    exports = next(i for i, line in enumerate(lines) if "[Ordinal/Name Pointer] Table" in line)
    table = [line for line in lines[exports + 1 :] if line.startswith("\t[")]

    assert needed == {"kernel32.dll", "msvcrt.dll"}
    assert shown == {line.split()[-1] for line in listed.stdout.splitlines()}
    assert len(table) == len(shown)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", ["2", "3"])
def test_fmpy_finds_nothing_wrong_with_a_unit_for_all_platforms(fmi: str, tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy")
    validation = pytest.importorskip("fmpy.validation")
    need_linkers(*NATIVE_PLATFORMS)
    path = tmp_path / "bb2.fmu"
    export_for(path, fmi, "all")

    assert validation.validate_fmu(str(path)) == []
    assert {"linux64", "win64"} <= set(fmpy.supported_platforms(str(path)))


def test_the_command_offers_the_platforms_of_the_table() -> None:
    assert [*UNIT_PLATFORM_NAMES] == [*UNIT_PLATFORMS]
    assert [*NATIVE_PLATFORM_NAMES] == NATIVE_PLATFORMS


@pytest.mark.parametrize("name", [name for name in UNIT_PLATFORMS if name != platform_name()])
def test_a_missing_linker_of_a_platform_is_told_with_its_packages(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = UNIT_PLATFORMS[name]
    monkeypatch.setenv("PATH", str(tmp_path))
    done = run_trainer("export-fmu", "bb2.fmu", "--fmi", "3", "--platform", name, cwd=tmp_path)

    assert done.returncode == 2
    assert done.stderr == (
        f"trainer: export-fmu, {name}: there is no {target.compiler!r} here. "
        f"Debian and Ubuntu: apt install {target.packages}\n"
    )
    assert not list(tmp_path.iterdir())


def test_a_machine_that_no_unit_is_for_is_told_the_platforms(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.boat.export.fmu.platform_name", lambda: "macos-arm64")
    done = CliRunner().invoke(cli, ["export-fmu", str(tmp_path / "bb2.fmu")])

    assert str(done.exception) == (
        "export-fmu: there is no unit for macos-arm64: give --platform linux-x86_64, "
        "linux-aarch64, windows-x86_64, wasm"
    )
