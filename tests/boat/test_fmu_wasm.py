"""A unit as a component of WebAssembly, by the draft fmi-ls-wasm, in wasmtime."""

import zipfile
from pathlib import Path
from typing import Any, Final

import pytest
from helpers.fmu import GUID_BYTES, UNIT_MARKS, Unit, unpack
from helpers.fmu_flight import ORDERS, TICKS, state_of_trainer
from helpers.installation import do_without, installed
from helpers.nursery import run_trainer
from helpers.typed import type_command

from trainer.boat.export.component import (
    EMPTY_MODULE,
    MANIFEST_PLACE,
    SHELL_PATH,
    component_of,
    encode_size,
)
from trainer.boat.platforms import UNIT_PLATFORMS, WASM_PLATFORM
from trainer.cli.main import cli
from trainer.core.state import STATE

pytestmark = UNIT_MARKS
COMPONENT: Final = "binaries/wasm32-wasip2/trainer_bb2.wasm"
FACE: Final = "fmi:fmi3/co-simulation@3.0.0"
PACKAGES: Final = UNIT_PLATFORMS[WASM_PLATFORM].packages
SETTERS: Final = {"Float64": "set-float64", "Int32": "set-int32", "Boolean": "set-boolean"}
MAX_BYTES: Final = 120_000  # of the unit


@pytest.mark.parametrize(
    ("size", "code"), [(0, b"\0"), (127, b"\x7f"), (128, b"\x80\x01"), (624485, b"\xe5\x8e\x26")]
)
def test_a_size_is_written_as_webassembly_has_it(size: int, code: bytes) -> None:
    assert encode_size(size) == code


def test_the_shell_has_one_place_for_a_module() -> None:
    module = EMPTY_MODULE + b"\0" * 200

    made = component_of(module)

    assert made.startswith(b"\0asm\x0d\0\1\0")  # a component
    assert made.count(module) == 1
    assert len(made) == SHELL_PATH.stat().st_size + 201  # one more for the longer size
    assert component_of(EMPTY_MODULE) == SHELL_PATH.read_bytes()


@pytest.mark.process
@pytest.mark.parametrize("fmi", ["2", "both"])
def test_a_component_of_another_version_is_refused(fmi: str, tmp_path: Path) -> None:
    words = ("export-fmu", "bb2.fmu", "--platform", WASM_PLATFORM, "--fmi", fmi)
    done = run_trainer(*words, cwd=tmp_path)

    assert done.returncode == 2
    assert done.stderr == "trainer: export-fmu: --platform wasm is of FMI 3.0 alone: give --fmi 3\n"
    assert not list(tmp_path.iterdir())


class Component:
    """A boat in a component, as a host of WebAssembly has it."""

    def __init__(self, unit: Unit, code: bytes) -> None:
        """Begin a boat, in its initialization."""
        wasmtime = pytest.importorskip("wasmtime")
        parts = pytest.importorskip("wasmtime.component")
        engine = wasmtime.Engine()
        self.store = wasmtime.Store(engine)
        self.told: list[tuple[str, ...]] = []
        linker = parts.Linker(engine)
        with linker.root() as root, root.add_instance("fmi:fmi3/callbacks@3.0.0") as callbacks:
            callbacks.add_func("log-message", lambda _, *words: self.told.append(words))
        self.made = linker.instantiate(self.store, parts.Component(engine, code))
        self.face = self.made.get_export_index(self.store, FACE)
        self.unit = unit
        start = (unit.guid.decode(), "", *[False] * 4, [])
        self.boat = self.call("[static]", "instantiate-co-simulation", "boat", *start)

    def call(self, kind: str, name: str, *values: object) -> Any:
        """Call a function of the component; return its answer, or the word of its status."""
        place = self.made.get_export_index(
            self.store, f"{kind}co-simulation-instance.{name}", self.face
        )
        function = self.made.get_func(self.store, place)
        answer = function(self.store, *values)
        function.post_return(self.store)
        return getattr(answer, "payload", answer)

    def ask(self, name: str, *values: object) -> Any:
        """Call a method of the boat."""
        return self.call("[method]", name, self.boat, *values)

    def step(self, now: float, step: float) -> Any:
        """Sail a step; return what came of it, or that it failed."""
        no_return = False  # to a state before
        return self.ask("do-step", now, step, no_return)

    def give(self, values: dict[str, float]) -> str:
        """Set variables; return the last status."""
        status = "ok"
        for name, value in values.items():
            place = self.unit.variables[name]
            typed = {"Float64": float, "Int32": int, "Boolean": bool}[place.kind](value)
            status = self.ask(SETTERS[place.kind], [place.reference], [typed])
        return status

    def begin(self) -> None:
        """Go to sea."""
        assert self.ask("enter-initialization-mode", None, 0.0, None) == "ok"
        assert self.ask("exit-initialization-mode") == "ok"

    def sail(self, begin: int, end: int) -> None:
        """Sail from a tick to another, with the orders of the flight of ten minutes."""
        for tick in range(begin, end):
            for at, _, values in ORDERS:
                if at == tick:
                    assert self.give(values) == "ok"
            assert self.step(tick * 0.5, 0.5) != "error"


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return BB2's unit for this machine and for WebAssembly."""
    installed("clang", PACKAGES)
    if not Path("/usr/include/wasm32-wasi").is_dir():
        do_without(f"no C library of WebAssembly here: apt-get install {PACKAGES}")
    path = tmp_path_factory.mktemp("unit") / "bb2.fmu"
    platforms = ("--platform", WASM_PLATFORM, "--platform", "linux-x86_64")
    type_command(cli, "export-fmu", path, "--fmi", "3", *platforms)
    return path


def component_in(path: Path, folder: Path) -> Component:
    """Return a boat of the component in a unit."""
    with zipfile.ZipFile(path) as archive:
        code = archive.read(COMPONENT)
    return Component(unpack(path, folder), code)


@pytest.mark.slow
def test_a_component_sails_the_trainers_bits_and_goes_on_from_a_state(
    exported: Path, tmp_path: Path
) -> None:
    first, then = component_in(exported, tmp_path / "a"), component_in(exported, tmp_path / "b")
    for each in (first, then):
        assert each.give({"sea_state": 4, "seed": 7}) == "ok"
        each.begin()
    first.sail(0, 301)

    assert then.ask("set-fmu-state", first.ask("get-fmu-state")) == "ok"
    then.sail(301, TICKS)

    state = then.ask("get-fmu-state")
    assert state[: len(then.unit.guid)] == then.unit.guid
    assert state[GUID_BYTES : GUID_BYTES + STATE.itemsize] == state_of_trainer()


@pytest.mark.slow
def test_a_component_refuses_with_the_units_words_and_keeps_the_boat(
    exported: Path, tmp_path: Path
) -> None:
    boat = component_in(exported, tmp_path)
    boat.begin()
    before = boat.ask("get-fmu-state")
    asked = boat.unit.variables["z"].reference

    assert boat.step(0.0, 0.3) == "error"
    assert boat.told[-1][1:] == (
        *("error", "logStatusError"),
        "fmi3DoStep: step of 0.3 s: must be 0.5 s or its multiple",
    )
    assert boat.ask("set-float64", [asked, asked], [1.0]) == "error"
    assert boat.told[-1][-1].endswith("1 values for 2 references")
    assert boat.ask("get-string", [asked]) == "error"
    assert boat.ask("get-string", []) == []
    assert boat.ask("get-float64", [asked]) == [60.0]
    assert boat.ask("get-fmu-state") == before


@pytest.mark.slow
def test_a_unit_with_a_component_has_its_manifest_and_is_small(exported: Path) -> None:
    with zipfile.ZipFile(exported) as archive:
        manifest = archive.read(MANIFEST_PLACE).decode()
        size = archive.getinfo(COMPONENT).compress_size

    assert 'fmi-ls-name="org.modelica.fmi-ls-wasm"' in manifest
    assert size < MAX_BYTES


@pytest.mark.slow
def test_a_long_flight_of_a_component_takes_no_more_memory(exported: Path, tmp_path: Path) -> None:
    boat = component_in(exported, tmp_path)
    boat.begin()
    references = [each.reference for each in boat.unit.variables.values() if each.kind == "Float64"]
    for tick in range(6_000):
        if tick == 1_000:
            begun = resident_kb()
        assert len(boat.ask("get-float64", references)) == len(references)
    assert resident_kb() - begun < 2_000  # without a free it would be 17 MB


def resident_kb() -> int:
    """Return the memory of this process [kB]."""
    (line,) = (
        each for each in Path("/proc/self/status").read_text().splitlines() if "VmRSS" in each
    )
    return int(line.split()[1])
