"""The core for WebAssembly: the trainer's bits, nothing from outside, the same bytes again."""

import hashlib
import json
import os
from pathlib import Path

import pytest
from bench.standard_hour import digest, standard_boat
from helpers.boats import take_ticks
from helpers.installation import installed, run_program
from helpers.tab import fly, standard_hour
from helpers.typed import type_command

from trainer.boat.export import wasm
from trainer.cli.export import boat_at_start
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.core.digest import core_digest
from trainer.debrief.page.boat_page import boat_for_page
from trainer.session.past.options import RunOptions

SHIPPED_CARD = wasm.SHIPPED_PATH.with_name(wasm.CARD_FILE)
CARD = dict(line.split(" ", 1) for line in SHIPPED_CARD.read_text().splitlines())
BUILD = (
    "trainer boat export-core DIR --cpu wasm32 builds it; copy core.wasm and core.wasm.txt from DIR"
)
AGAIN = f"core.wasm is of another core: {BUILD}"


@pytest.mark.process
def test_the_standard_hour_ends_in_its_bits() -> None:
    deeds, end = standard_hour()
    boat = standard_boat()
    page = boat_for_page(boat, "instructor")

    before, *_, after, found = fly(page, ("digest",), *deeds, ("time",), ("digest",))

    assert before == digest(boat)
    assert after > 0.0
    assert len(deeds) > 50
    assert found == end


def test_the_shipped_module_is_of_this_core() -> None:
    assert CARD["core"] == core_digest(), AGAIN
    assert hashlib.sha256(wasm.SHIPPED_PATH.read_bytes()).hexdigest() == CARD["sha256"]


@pytest.mark.process
def test_the_module_imports_nothing_and_shows_what_a_host_needs() -> None:
    node = installed("node", "nodejs")
    script = (
        "const m = new WebAssembly.Module(require('fs').readFileSync(process.argv[1]));"
        "console.log(JSON.stringify([WebAssembly.Module.imports(m),"
        "WebAssembly.Module.exports(m).map(({ name }) => name)]))"
    )
    done = run_program([node, "-e", script, str(wasm.SHIPPED_PATH)])

    imports, exports = json.loads(done.stdout)
    rooms = {f"trainer_{room}" for room in wasm.ROOM_NAMES}
    assert imports == []
    assert set(exports) == {"memory", *wasm.HOST_FUNCTIONS, *rooms}


@pytest.mark.slow
@pytest.mark.process
def test_the_module_is_built_again_to_the_byte(tmp_path: Path) -> None:
    installed("wasm-ld", "lld")
    built = type_command(cli, "export-core", tmp_path, "--cpu", "wasm32", "--json")
    card = (tmp_path / wasm.CARD_FILE).read_text()
    same = (tmp_path / wasm.MODULE_FILE).read_bytes() == wasm.SHIPPED_PATH.read_bytes()
    assert same, f"shipped: {CARD}; built now: {card}; {BUILD}"
    assert json.loads(built.stdout)["module_bytes"] < 250_000
    said = run_program([installed("node", "nodejs"), str(tmp_path / wasm.HOST_FILE), "120"])
    boat = boat_at_start(RunOptions(vessel="bb2"))
    boat.state.ordered_depth += 10.0
    take_ticks(boat, 120)
    assert said.stdout.splitlines()[-1] == digest(boat)


def test_a_linker_that_is_missing_is_named_with_its_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))

    with pytest.raises(
        ConfigError, match=r"no linker wasm-ld here\. Debian and Ubuntu: apt install lld"
    ):
        wasm.build_module(boat_at_start(RunOptions(vessel="bb2")).records.scheme)


def test_without_a_linker_the_module_of_the_trainer_is_exported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))

    type_command(cli, "export-core", tmp_path / "core", "--cpu", "wasm32")
    for name, shipped in ((wasm.MODULE_FILE, wasm.SHIPPED_PATH), (wasm.CARD_FILE, SHIPPED_CARD)):
        assert (tmp_path / "core" / name).read_bytes() == shipped.read_bytes()
    numbers = json.loads((tmp_path / "core" / wasm.NUMBERS_FILE).read_text())
    assert numbers["boat"] == load_vessel("bb2").name


def test_without_a_linker_another_method_is_refused_with_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    boat = boat_at_start(RunOptions(vessel="bb2", equations="full"))

    told = r"no linker wasm-ld here, and the core\.wasm .* is for the modified set, .* not the full"
    with pytest.raises(ConfigError, match=rf"{told} set, .*apt install lld"):
        wasm.files_of(boat)
    monkeypatch.setattr(wasm, "same_core", lambda _: False)
    with pytest.raises(ConfigError, match=rf"is of core {CARD['core']}, not .*apt install lld"):
        wasm.files_of(boat)


@pytest.mark.process
def test_a_linker_that_fails_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    linker = tmp_path / "wasm-ld"
    linker.write_text("#!/bin/sh\necho first >&2\necho 'error: no room' >&2\nexit 1\n")
    linker.chmod(0o755)
    monkeypatch.setattr(wasm, "_lowered", lambda *_: None)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")

    with pytest.raises(ConfigError, match=r"wasm-ld failed: error: no room$"):
        wasm.build_module(boat_at_start(RunOptions(vessel="bb2")).records.scheme)


def test_a_kernel_of_another_text_is_taken_as_it_is() -> None:
    text = "define i32 @other(ptr %arg.scheme.4) {\n  ret i32 0\n}\n"

    assert wasm.settle_method(text, b"\0" * 8) == text


def test_what_the_method_settles_is_constant_and_step_and_triggers_are_not() -> None:
    lines = [
        "define i32 @trainer_core6update6update_x(ptr %arg.scheme.4) {",
        "  %a = getelementptr inbounds i8, ptr %arg.scheme.4, i64 40",
        "  %b = getelementptr inbounds i8, ptr %arg.scheme.4, i64 272",
        "  %c = load double, ptr %arg.scheme.4",
        "  ret i32 0",
        "}",
    ]

    told = wasm.settle_method("\n".join(lines), b"\1\2").splitlines()

    assert told[0].startswith("@settled = internal constant [2 x i8]")
    assert "@settled, i64 40" in told[2]
    assert told[3:5] == lines[2:4]
