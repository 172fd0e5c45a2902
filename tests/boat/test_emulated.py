"""Objects for other processors, in emulators: the hour ends in the same bits."""

import gzip
import re
import subprocess
from pathlib import Path

import pytest
from bench.standard_hour import digest, fly_standard_hour, standard_boat
from helpers.emulated import (
    EMULATORS,
    emulated_ticks,
    fly_exported_hour,
    link_host,
    needed_programs,
)
from helpers.installation import installed, run_program
from helpers.loops import in_a_loop
from helpers.places import ROOT

from trainer.boat.export.library import OBJECT_FILE, write_core
from trainer.boat.machine_code import SHIPPED_FOLDER
from trainer.boat.platforms import CPU_TARGETS
from trainer.cli.export import boat_at_start
from trainer.session.past.options import RunOptions

HOST = Path(__file__).with_name("emulated.c")
LEAST_HOST = Path(__file__).with_name("least.c")
OBJECT_NAME = "linux-aarch64"
METHODS = (("full", "rkv", "exact"), ("basic", "abm4", "report"), ("modified", "rk4", "exact"))
PROMISED = r"^\| Cortex-M7: (?:flash|memory|stack)[^|]*\| (\d+) kB \|"
PAGE = ROOT / "docs" / "exported-core.md"


def need_programs(cpu: str) -> None:
    """Have the compiler and the emulator of a target, or do without the test."""
    for program, packages in needed_programs(cpu).items():
        installed(program, packages)


def build_host(folder: Path) -> Path:
    """Return the host with the shipped object in it, for aarch64; needs its compiler."""
    tick, host = folder / "tick.o", folder / "host"
    tick.write_bytes(gzip.decompress((SHIPPED_FOLDER / f"{OBJECT_NAME}.o.gz").read_bytes()))
    words = ["aarch64-linux-gnu-gcc", "-O2", "-Wall", "-Werror", "-static"]
    subprocess.run([*words, "-o", str(host), str(HOST), str(tick)], check=True)
    return host


@pytest.mark.slow
@pytest.mark.process
def test_the_object_for_aarch64_ends_the_standard_hour_in_the_same_bits(tmp_path: Path) -> None:
    need_programs("aarch64")
    host = build_host(tmp_path)
    records = standard_boat().records
    words = EMULATORS["aarch64"].words(host, *(str(record.nbytes) for record in records))
    with emulated_ticks(words, slice(len(records))) as take:
        flown = digest(fly_standard_hour(take))

    assert flown == digest(fly_standard_hour(in_a_loop))


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize("cpu", EMULATORS)
def test_an_exported_core_ends_the_standard_hour_in_the_same_bits(cpu: str, tmp_path: Path) -> None:
    need_programs(cpu)

    assert fly_exported_hour(cpu, tmp_path) == digest(fly_standard_hour(in_a_loop))


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize("cpu", EMULATORS)
def test_an_exported_core_asks_for_nothing_by_any_method(cpu: str, tmp_path: Path) -> None:
    need_programs(cpu)
    tools = CPU_TARGETS[cpu].compiler.partition(" ")[0].removesuffix("gcc")
    asked = {}
    for equations, integrator, trig in METHODS:
        how = RunOptions(equations=equations, integrator=integrator, trig=trig, unsafe_step=True)
        write_core(boat_at_start(how), tmp_path, cpu)
        words = [f"{tools}nm", "-u", str(tmp_path / OBJECT_FILE)]
        asked[equations] = run_program(words).stdout

    assert asked == dict.fromkeys(asked, "")


@pytest.mark.slow
@pytest.mark.process
def test_a_boat_on_a_cortex_m7_takes_the_memory_that_is_promised(tmp_path: Path) -> None:
    need_programs("cortex-m7")
    write_core(boat_at_start(RunOptions(vessel="bb2", sea="sea-state-5")), tmp_path, "cortex-m7")
    host = link_host("cortex-m7", tmp_path, LEAST_HOST, "-nostartfiles")
    words = EMULATORS["cortex-m7"].words(host)
    said = run_program(words, timeout=120)
    stack = int(said.stdout + said.stderr)
    size = run_program(["arm-none-eabi-size", str(host)])
    code, data, zeros = map(int, size.stdout.splitlines()[1].split()[:3])
    measured = (code + data, data + zeros, stack)

    rows = re.findall(PROMISED, PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    promised = [int(kilobytes) * 1000 for kilobytes in rows]
    within = [0.8 * most < found <= most for found, most in zip(measured, promised, strict=True)]
    assert within == [True] * 3, (measured, promised)
