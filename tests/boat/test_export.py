"""The exported core: a C library of one boat."""

import ctypes
import errno
import json
import math
import os
import random
import re
import shutil
import struct
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.boats import make_boat
from helpers.exported import Core, link_shipped, shipped_kernel
from helpers.installation import installed, run_program
from helpers.nursery import Done, run_trainer
from helpers.places import ROOT
from helpers.typed import type_command
from llvmlite import binding  # type: ignore[import-untyped]

from trainer import __version__
from trainer.boat.boat import STATE_OFFSETS
from trainer.boat.entries import entry_of
from trainer.boat.export import library, lowering
from trainer.boat.export.header import PUBLISHED_NAMES, record_members
from trainer.boat.export.library import (
    HEADER_FILE,
    HOST_FILE,
    LIBRARY_FILE,
    OBJECT_FILE,
    add_library,
    name_trouble,
    write_core,
)
from trainer.boat.export.lowering import FREESTANDING_PATH, freestanding_text
from trainer.boat.export.targets import (
    NATIVE_NAME,
    REINSTALL_HINT,
    Effort,
    Processor,
    code_words,
    find_processor,
    object_code,
)
from trainer.boat.machine_code import Library as MemoryLibrary
from trainer.boat.machine_code import call_entry
from trainer.boat.platforms import CPU_TARGETS
from trainer.cli.export import CPU_NAMES, boat_at_start
from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.core.digest import core_digest
from trainer.core.noise import gaussian_pair
from trainer.core.state import STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.session.past.options import RunOptions

HOUR = 7200  # [ticks] of 0.5 s
OPTIONS = RunOptions(sea="sea-state-4", seed=7)
COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(not COMPILER, reason="no C compiler here")
needs_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ELF symbols")
pytestmark = [
    pytest.mark.process,
    needs_compiler,
    pytest.mark.skipif(os.name == "nt", reason="no shared objects"),
]


@pytest.fixture(
    scope="module", params=["shipped", pytest.param("compiled", marks=pytest.mark.slow)]
)
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of an exported BB2 in a sea; every commit takes the shipped kernel."""
    path = tmp_path_factory.mktemp("core")
    boat = boat_at_start(OPTIONS)
    with pytest.MonkeyPatch.context() as patched:
        if request.param == "shipped":
            installed("objcopy", "binutils")
            patched.setattr(lowering, "kernel_text", shipped_kernel)
            patched.setattr(library, "object_code", partial(link_shipped, path))
        write_core(boat, path, "x86-64-v2")
    add_library(path, "x86-64-v2")
    return path


@pytest.fixture
def core(folder: Path) -> Core:
    """Return the exported boat at her start."""
    return Core(folder / LIBRARY_FILE)


def ran(*words: str, where: Path, **environment: str) -> Done:
    """Return what a run of the command with those words came to."""
    return run_trainer(*words, cwd=where, env=os.environ | environment, timeout=120)


def give_the_hosts_orders(tick: int, s: np.record) -> None:
    """Give a boat the orders that host.c gives."""
    if tick == 60:
        s.ordered_r, s.rudder_by_hand = -15.0 * math.pi / 180.0, 1.0
    if tick == 600:
        s.ordered_depth, s.stern_by_hand, s.bow_by_hand = 90.0, 0.0, 0.0
    if tick == 1800:
        s.ordered_u_c, s.speed_by_hand = 3.0, 1.0


# The bits


def test_after_an_hour_the_c_host_the_library_and_the_trainer_are_the_same_to_the_bit(
    folder: Path, core: Core, tmp_path: Path
) -> None:
    boat = boat_at_start(OPTIONS)
    host, end = tmp_path / "host", tmp_path / "end.bin"
    source = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", str(folder / HOST_FILE)]
    subprocess.run(["cc", *source, str(folder / OBJECT_FILE), "-o", str(host)], check=True)
    table = run_program([host, str(HOUR), end])
    exported = np.frombuffer(core.state, STATE).view(np.recarray)[0]  # type: ignore[call-overload]

    for tick in range(HOUR):
        give_the_hosts_orders(tick, boat.state)
        give_the_hosts_orders(tick, exported)
        assert boat.tick() == core.tick() == 0

    trained = boat.records.state.tobytes()
    assert boat.state.eta_wave != 0.0
    assert abs(boat.state.z - 90.0) < 10.0
    assert bytes(core.state) == trained
    assert end.read_bytes() == trained
    assert float(table.stdout.splitlines()[-1].split(",")[4]) == boat.state.z


@pytest.mark.long
@pytest.mark.parametrize(
    ("cpu", "equations", "integrator", "vessel"),
    [
        pytest.param("x86-64-v2", "full", "rkv", "bb2", marks=pytest.mark.slow),
        pytest.param("x86-64-v3", "full", "rk4", "remus100", marks=pytest.mark.slow),
        pytest.param("x86-64-v4", "basic", "abm4", "sdv-mk9", marks=pytest.mark.slow),
        pytest.param("native", "modified", "adams3", "bb2", marks=pytest.mark.slow),
    ],
)
def test_every_processor_and_method_gives_the_trainers_bits(
    cpu: str, equations: str, integrator: str, vessel: str, tmp_path: Path
) -> None:
    how = {"vessel": vessel, "equations": equations, "integrator": integrator}
    boat = boat_at_start(replace(OPTIONS, **how, sea="calm"))  # type: ignore[arg-type]
    lacking = set(find_processor(cpu).needs) - set(find_processor(NATIVE_NAME).needs)
    if lacking:
        pytest.skip(f"this processor lacks {', '.join(sorted(lacking))}")
    write_core(boat, tmp_path, cpu)
    add_library(tmp_path, cpu)
    core = Core(tmp_path / LIBRARY_FILE)

    for tick in range(600):
        if tick == 20:
            boat.state.ordered_depth += 4.0
            core.state[STATE_OFFSETS["ordered_depth"]] += 4.0
        assert boat.tick() == core.tick() == 0

    assert bytes(core.state) == boat.records.state.tobytes()


def test_a_kernel_that_is_lowered_here_gives_the_bits_of_the_shipped_one() -> None:
    entry, target = entry_of(gaussian_pair), CPU_TARGETS["native"]
    text, kernel = lowering.kernel_text(entry)
    own = lowering.entry_text(entry, kernel, "lowered")
    target = target._replace(triple=binding.get_process_triple())
    memory = MemoryLibrary(lowering.compile_for(target, (text, own), {"lowered"}, Effort(3)))
    lowered = call_entry(entry, memory.address_of("lowered"))

    assert [lowered(1, 2, k) for k in range(1000)] == [gaussian_pair(1, 2, k) for k in range(1000)]


def compiled_library(text: str) -> ctypes.CDLL:
    """Return our own versions of library functions, compiled in memory."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    module = binding.parse_assembly(text)
    machine = binding.Target.from_default_triple().create_target_machine()
    return binding.create_mcjit_compiler(module, machine)  # type: ignore[no-any-return]


def some_numbers() -> list[float]:
    """Return numbers of every size: bits drawn, and the ends of what there is."""
    draw = random.Random(1)  # noqa: S311
    drawn = [struct.unpack("d", draw.randbytes(8))[0] for _ in range(3000)]
    ends = [0.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, math.inf, 1.0, 0.5]
    return [x for size in (*drawn, *ends) for x in (size, -size) if not math.isnan(x)]


def test_our_own_ldexp_rounds_as_the_library_does() -> None:
    engine = compiled_library(freestanding_text(64))
    address = engine.get_function_address("numba_ldexp")
    scaled = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.c_int)(address)
    draw = random.Random(2)  # noqa: S311
    cases = [(x, draw.choice((draw.randint(-2200, 2200), -1074, 0))) for x in some_numbers()]

    for x, n in cases:
        try:
            expected = math.ldexp(x, n)
        except OverflowError:
            expected = math.copysign(math.inf, x)
        assert struct.pack("d", scaled(x, n)) == struct.pack("d", expected), (x, n)


def test_our_own_frexp_takes_numbers_apart_as_the_library_does() -> None:
    engine = compiled_library(freestanding_text(64))
    address = engine.get_function_address("numba_frexp")
    exponent = ctypes.c_int()
    taken = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_int))(
        address
    )

    for x in some_numbers():
        assert (taken(x, ctypes.byref(exponent)), exponent.value) == math.frexp(x), x


def test_our_own_conversions_for_arm_round_as_the_library_does() -> None:
    text = FREESTANDING_PATH.with_name("aeabi.ll").read_text(encoding="utf-8")
    engine = compiled_library(text.replace("arm_aapcscc ", ""))
    place = engine.get_function_address
    whole = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double)(place("__aeabi_d2lz"))
    signed = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(place("__aeabi_l2d"))
    plain = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_uint64)(place("__aeabi_ul2d"))
    draw = random.Random(3)  # noqa: S311
    ends = [0, 1, 2**52, 2**53 + 1, 2**53 + 3, 2**62 + 2**9, 2**63 - 1]
    sizes = [*ends, *(draw.getrandbits(draw.randint(1, 63)) for _ in range(3000))]
    fractions = [math.ldexp(draw.uniform(-1.0, 1.0), draw.randint(-60, 63)) for _ in range(3000)]

    assert [signed(n) for size in sizes for n in (size, -size)] == [
        float(n) for size in sizes for n in (size, -size)
    ]
    assert [plain(n + 2**63) for n in sizes] == [float(n + 2**63) for n in sizes]
    assert [whole(x) for x in (*some_small_numbers(), *fractions)] == [
        int(x) for x in (*some_small_numbers(), *fractions)
    ]


def some_small_numbers() -> list[float]:
    """Return numbers whose whole part an integer of 64 bits holds."""
    return [x for x in some_numbers() if abs(x) < 2.0**63]


# The library and its header


@needs_linux
@pytest.mark.skipif(not shutil.which("nm"), reason="no nm here")
@pytest.mark.parametrize("name", [OBJECT_FILE, LIBRARY_FILE])
def test_nothing_outside_is_needed(folder: Path, name: str) -> None:
    needed = run_program(["nm", *(["-D"] if name == LIBRARY_FILE else []), "-u", folder / name])

    assert not needed.stdout.strip()


@needs_linux
@pytest.mark.skipif(not shutil.which("nm"), reason="no nm here")
def test_only_the_five_names_of_the_header_are_seen(folder: Path) -> None:
    shown = run_program(["nm", "-D", "--defined-only", folder / LIBRARY_FILE])
    header = (folder / HEADER_FILE).read_text()

    names = {line.split()[-1] for line in shown.stdout.splitlines()}
    assert len(names) == 5
    assert names == set(
        re.findall(r"^(?:extern .*?|int )(trainer_\w+)(?:\[\])?[;(]", header, re.MULTILINE)
    )


@pytest.mark.parametrize(
    ("kind", "name"), [(STATE, "state"), (VESSEL, "vessel"), (COMPACT, "compact")]
)
def test_places_in_c_are_the_records_places(
    kind: np.dtype, name: str, folder: Path, tmp_path: Path
) -> None:
    prints = "\n".join(
        f'printf("%zu\\n", offsetof(struct trainer_{name}, {PUBLISHED_NAMES.get(member, member)}));'
        for member, _, _ in record_members(kind)
    )
    program = f'#include <stddef.h>\n#include <stdio.h>\n#include "{HEADER_FILE}"\n'
    (tmp_path / "places.c").write_text(f"{program}int main(void) {{ {prints} return 0; }}\n")
    subprocess.run(["cc", "-I", folder, "places.c", "-o", "places"], cwd=tmp_path, check=True)
    printed = run_program([tmp_path / "places"])

    assert [int(line) for line in printed.stdout.split()] == [
        at for _, at, _ in record_members(kind)
    ]


@pytest.mark.parametrize("kind", [STATE, VESSEL, COMPACT])
def test_every_number_of_a_record_has_one_name_in_c(kind: np.dtype) -> None:
    taken = [at + 8 * i for _, at, shape in record_members(kind) for i in range(math.prod(shape))]

    assert taken == list(range(0, kind.itemsize, 8))


def test_the_header_says_what_the_numbers_are(folder: Path) -> None:
    header = (folder / HEADER_FILE).read_text()

    assert "double ordered_depth;  /* 99 [m] */" in header.replace(
        f"/* {STATE_OFFSETS['ordered_depth']} ", "/* 99 "
    )
    assert "double diameter;" in header
    assert "#define TRAINER_STEP_S 0.5" in header


def test_the_host_in_the_documents_compiles_and_steers(folder: Path, tmp_path: Path) -> None:
    page = ROOT / "docs" / "exported-core.md"
    (example,) = re.findall(r"```c\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "example.c").write_text(example)
    words = ["cc", "-Wall", "-Werror", "-I", str(folder), "example.c", str(folder / OBJECT_FILE)]
    subprocess.run([*words, "-o", "example"], cwd=tmp_path, check=True)

    said = run_program([tmp_path / "example"]).stdout

    assert said.startswith("300.0 s: ")
    assert float(said.split("heading ")[1].split()[0]) > 1.0


def test_the_size_of_code_is_that_of_its_instructions() -> None:
    target = Processor("x86-64-v2", "", ())
    module = binding.parse_assembly("define i32 @one() {\n ret i32 1\n}")

    if not binding.get_process_triple().startswith("x86_64"):
        pytest.skip("counts the bytes of another processor")
    assert code_words(object_code(module, target)) == 3  # five bytes to load 1, one to return


def test_a_processor_needs_all_that_the_ones_before_it_need() -> None:
    levels = [set(find_processor(name).needs) for name in ("x86-64-v2", "x86-64-v3", "x86-64-v4")]

    assert levels[0] < levels[1] < levels[2]


def test_the_card_says_what_the_library_is_of_and_where_its_columns_are(core: Core) -> None:
    columns = dict(each.split("=") for each in core.card["columns"].split())

    assert core.card["trainer-core"] == "1"
    assert (core.card["version"], core.card["core"]) == (__version__, core_digest())
    assert core.card["boat"].startswith("Joubert BB2")
    assert float.fromhex(core.card["step"]) == 0.5
    assert columns["z"] == str(STATE_OFFSETS["z"])


def test_a_tick_that_fails_says_which_number_and_leaves_the_state(core: Core) -> None:
    core.state[STATE_OFFSETS["u"]] = 1e5
    before = bytes(core.state)

    status = core.tick()

    assert core.card["watched"].split()[status - 1] == "udot"
    assert bytes(core.state) == before


# The command


@pytest.mark.slow  # the core is compiled anew
@pytest.mark.parametrize(
    ("cpu", "packages"), [("x86-64-v2", "gcc"), ("riscv64", "gcc-riscv64-linux-gnu libc6")]
)
def test_without_a_compiler_the_object_is_written_and_the_way_to_link_it_told(
    cpu: str, packages: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")

    done = CliRunner().invoke(cli, ["export-core", str(tmp_path), "--json", "--cpu", cpu])

    assert done.exit_code == 1
    assert "there is no 'no-such-compiler' here" in done.stderr
    assert f"Debian and Ubuntu: apt install {packages}" in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        [HOST_FILE, HEADER_FILE, OBJECT_FILE]
    )
    assert json.loads(done.stdout)["files"] == [OBJECT_FILE, HEADER_FILE, HOST_FILE]


def listed_targets() -> dict[str, str]:
    """Return what the command lists of each target."""
    done = type_command(cli, "export-core", "--list")
    return dict(line.split(maxsplit=1) for line in done.stdout.splitlines())


def test_the_list_says_what_is_here_and_the_packages_of_the_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "riscv64-linux-gnu-gcc"
    program.write_text("")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)

    told = listed_targets()

    assert (*told, "shipped") == (*CPU_TARGETS, "shipped") == CPU_NAMES
    assert told["riscv64"].split() == ["yes", *CPU_TARGETS["riscv64"].purpose.split()]
    assert told["cortex-m7"].startswith("no linker")
    assert told["cortex-m7"].endswith("apt install gcc-arm-none-eabi libnewlib-arm-none-eabi")
    assert told["wasm32"].endswith("there is no 'wasm-ld' here. Debian and Ubuntu: apt install lld")


def test_the_list_looks_for_the_compiler_that_cc_names_where_a_library_is_linked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("mine", "arm-none-eabi-gcc", "wasm-ld"):
        (tmp_path / name).write_text("")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))

    told = {}
    for compiler in ("mine -m64", "no-such-compiler"):
        monkeypatch.setenv("CC", compiler)
        told[compiler] = listed_targets()

    boards = {"cortex-m7", "wasm32"}
    assert [name for name, text in told["mine -m64"].items() if not text.startswith("yes")] == []
    refused = {name for name, text in told["no-such-compiler"].items() if "no linker" in text}
    assert refused == set(CPU_TARGETS) - boards
    assert "there is no 'no-such-compiler' here" in told["no-such-compiler"]["aarch64"]


def test_a_compiler_without_a_processor_says_so_and_what_brings_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(triple: str) -> object:
        if triple.startswith("riscv64"):
            raise RuntimeError(triple)
        return None

    boat = make_boat("bb2")  # its own machine code is loaded before
    monkeypatch.setattr(binding.Target, "from_triple", refuse)

    told = listed_targets()
    assert told["riscv64"].startswith("no ")
    assert told["riscv64"].endswith("has no riscv64 here; pip's has: " + REINSTALL_HINT)
    assert "has no" not in told["aarch64"]  # its linker may be missing, its processor is not
    with pytest.raises(ConfigError, match="--cpu riscv64: the compiler in llvmlite has no riscv64"):
        write_core(boat, tmp_path, "riscv64")


def test_a_level_of_another_kind_of_processor_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binding, "get_process_triple", lambda: "aarch64-unknown-linux-gnu")

    with pytest.raises(ConfigError, match="this machine is aarch64; give --cpu native"):
        find_processor("x86-64-v2")


def test_an_unknown_processor_is_answered_with_the_nearest() -> None:
    done = CliRunner().invoke(cli, ["export-core", "core", "--cpu", "cortex-m4"])

    assert done.exit_code == 2
    assert "nearest is cortex-m7" in done.stderr


def test_without_the_jit_nothing_can_be_exported(tmp_path: Path) -> None:
    done = ran("export-core", "core", "--unsafe-step", where=tmp_path, NUMBA_DISABLE_JIT="1")

    assert done.returncode == 2
    assert "unset NUMBA_DISABLE_JIT" in done.stderr
    assert not list(tmp_path.rglob("*.o"))


def test_another_version_of_the_compiler_is_refused_with_the_one_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("numba.__version__", "0.99.1")
    wrong = re.escape("numba 0.99.1 was not tested with it: install 'numba>=0.68,<0.69'")
    with pytest.raises(ConfigError, match=wrong):
        write_core(boat_at_start(OPTIONS), tmp_path, "x86-64-v2")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_named_before_anything_is_compiled(tmp_path: Path) -> None:
    (tmp_path / "core").write_text("")

    with pytest.raises(ConfigError, match="core: File exists"):
        write_core(make_boat("bb2"), tmp_path / "core", "x86-64-v2")


def test_a_full_disk_names_the_folder_where_the_system_names_no_file(tmp_path: Path) -> None:
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with pytest.raises(ConfigError, match=f"{tmp_path}: {full.strerror}"), name_trouble(tmp_path):
        raise full
