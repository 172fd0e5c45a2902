"""The exported core: a C library of one boat, and the run on it without numba."""

import ctypes
import json
import math
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.places import ROOT
from llvmlite import binding  # type: ignore[import-untyped]

from trainer.boat.boat import PLACES, Boat
from trainer.boat.export.header import PUBLISHED, members
from trainer.boat.export.library import HEADER, HOST, LIBRARY, OBJECT, add_library, export
from trainer.boat.export.lowering import freestanding_text
from trainer.boat.export.orders import rows
from trainer.boat.export.runner import library as bare_core
from trainer.boat.export.runner import run as bare_options
from trainer.boat.export.runner import run as bare_run
from trainer.boat.export.runner.library import FORMAT, Core, WrongError
from trainer.boat.export.runner.orders import Row
from trainer.boat.export.runner.run import read_schedule
from trainer.boat.export.targets import Processor, code_words, object_code, processor
from trainer.boat.helm import obey
from trainer.cli.export import boat_at_start
from trainer.cli.main import cli
from trainer.cli.types import Duration, Speed
from trainer.config.files import ConfigError
from trainer.core.state import STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.session.options import RunOptions
from trainer.verify.bench.exported import lines, measure_exported

HOUR = 7200  # [ticks] of 0.5 s
OPTIONS = RunOptions(sea="sea-state-4", seed=7)
COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(not COMPILER, reason="no C compiler here")
needs_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ELF symbols")
pytestmark = [needs_compiler, pytest.mark.skipif(os.name == "nt", reason="no shared objects")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of an exported BB2 in a sea."""
    path = tmp_path_factory.mktemp("core")
    export(boat_at_start(OPTIONS), path, "x86-64-v2")
    add_library(path)
    return path


@pytest.fixture
def core(folder: Path) -> Core:
    """Return the exported boat at her start."""
    return Core(str(folder / LIBRARY))


def ran(*words: str, where: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Return what a run of the command with those words came to."""
    return subprocess.run(
        [sys.executable, "-m", "trainer", *words],
        cwd=where,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


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
    source = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", str(folder / HOST)]
    subprocess.run(["cc", *source, str(folder / OBJECT), "-o", str(host)], check=True)
    table = subprocess.run([host, str(HOUR), end], capture_output=True, text=True, check=True)
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
        ("native", "modified", "adams3", "bb2"),
    ],
)
def test_every_processor_and_method_gives_the_trainers_bits(
    cpu: str, equations: str, integrator: str, vessel: str, tmp_path: Path
) -> None:
    how = {"vessel": vessel, "equations": equations, "integrator": integrator}
    boat = boat_at_start(replace(OPTIONS, **how, sea="calm"))  # type: ignore[arg-type]
    export(boat, tmp_path, cpu)
    add_library(tmp_path)
    try:
        core = Core(str(tmp_path / LIBRARY))
    except WrongError as lacking:
        pytest.skip(str(lacking))

    for tick in range(600):
        if tick == 20:
            boat.state.ordered_depth += 4.0
            core.state[PLACES["ordered_depth"]] += 4.0
        assert boat.tick() == core.tick() == 0

    assert bytes(core.state) == boat.records.state.tobytes()


def test_a_table_of_the_exported_boat_is_the_trainers_to_the_byte(
    folder: Path, tmp_path: Path
) -> None:
    orders = "10 rudder right 15\n100.2 course 010 # back\n120 depth 70\n200 bell ahead one-third\n"
    (tmp_path / "orders.txt").write_text(orders)
    common = ("--headless", "--speed", "max", "--duration", "5m", "--orders", "orders.txt")
    trainer = ("--sea", "sea-state-4", "--seed", "7", "--csv", "trainer.csv")
    exported = ("--core", str(folder / LIBRARY), "--csv", "core.csv", "--state", "end.bin")

    first = ran("run", *common, *trainer, where=tmp_path)
    second = ran("run", *common, *exported, where=tmp_path)

    assert (first.returncode, second.returncode) == (0, 0), first.stderr + second.stderr
    assert (tmp_path / "core.csv").read_bytes() == (tmp_path / "trainer.csv").read_bytes()
    ends = [
        [line for line in ran.stdout.splitlines() if line.startswith("the boat")]
        for ran in (first, second)
    ]
    assert ends[0] == ends[1] != []
    assert struct.unpack_from("d", (tmp_path / "end.bin").read_bytes()) == (600.0,)


def compiled_library() -> ctypes.CDLL:
    """Return our own versions of the library functions, compiled in memory."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    module = binding.parse_assembly(freestanding_text(64))
    machine = binding.Target.from_default_triple().create_target_machine()
    return binding.create_mcjit_compiler(module, machine)  # type: ignore[no-any-return]


def some_numbers() -> list[float]:
    """Return numbers of every size: bits drawn, and the ends of what there is."""
    draw = random.Random(1)  # noqa: S311
    drawn = [struct.unpack("d", draw.randbytes(8))[0] for _ in range(3000)]
    ends = [0.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, math.inf, 1.0, 0.5]
    return [x for size in (*drawn, *ends) for x in (size, -size) if not math.isnan(x)]


def test_our_own_ldexp_rounds_as_the_library_does() -> None:
    engine = compiled_library()
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
    engine = compiled_library()
    address = engine.get_function_address("numba_frexp")
    exponent = ctypes.c_int()
    taken = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_int))(
        address
    )

    for x in some_numbers():
        assert (taken(x, ctypes.byref(exponent)), exponent.value) == math.frexp(x), x


# The library and its header


@needs_linux
@pytest.mark.skipif(not shutil.which("nm"), reason="no nm here")
@pytest.mark.parametrize("name", [OBJECT, LIBRARY])
def test_nothing_outside_is_needed(folder: Path, name: str) -> None:
    needed = subprocess.run(
        ["nm", *(["-D"] if name == LIBRARY else []), "-u", folder / name],
        capture_output=True,
        text=True,
        check=True,
    )

    assert not needed.stdout.strip()


@needs_linux
@pytest.mark.skipif(not shutil.which("nm"), reason="no nm here")
def test_only_the_five_names_of_the_header_are_seen(folder: Path) -> None:
    shown = subprocess.run(
        ["nm", "-D", "--defined-only", folder / LIBRARY], capture_output=True, text=True, check=True
    )
    header = (folder / HEADER).read_text()

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
        f'printf("%zu\\n", offsetof(struct trainer_{name}, {PUBLISHED.get(member, member)}));'
        for member, _, _ in members(kind)
    )
    program = f'#include <stddef.h>\n#include <stdio.h>\n#include "{HEADER}"\n'
    (tmp_path / "places.c").write_text(f"{program}int main(void) {{ {prints} return 0; }}\n")
    subprocess.run(["cc", "-I", folder, "places.c", "-o", "places"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "places"], capture_output=True, text=True, check=True)

    assert [int(line) for line in printed.stdout.split()] == [at for _, at, _ in members(kind)]


@pytest.mark.parametrize("kind", [STATE, VESSEL, COMPACT])
def test_every_number_of_a_record_has_one_name_in_c(kind: np.dtype) -> None:
    taken = [at + 8 * i for _, at, shape in members(kind) for i in range(math.prod(shape))]

    assert taken == list(range(0, kind.itemsize, 8))


def test_the_header_says_what_the_numbers_are(folder: Path) -> None:
    header = (folder / HEADER).read_text()

    assert "double ordered_depth;  /* 99 [m] */" in header.replace(
        f"/* {PLACES['ordered_depth']} ", "/* 99 "
    )
    assert "double diameter;" in header
    assert "#define TRAINER_STEP_S 0.5" in header


def test_the_host_in_the_documents_compiles_and_steers(folder: Path, tmp_path: Path) -> None:
    page = ROOT / "docs" / "exported-core.md"
    (example,) = re.findall(r"```c\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "example.c").write_text(example)
    words = ["cc", "-Wall", "-Werror", "-I", str(folder), "example.c", str(folder / OBJECT)]
    subprocess.run([*words, "-o", "example"], cwd=tmp_path, check=True)

    said = subprocess.run([tmp_path / "example"], capture_output=True, text=True, check=True).stdout

    assert said.startswith("300.0 s: ")
    assert float(said.split("heading ")[1].split()[0]) > 1.0


def test_the_size_of_code_is_that_of_its_instructions() -> None:
    target = Processor("x86-64-v2", "", ())
    module = binding.parse_assembly("define i32 @one() {\n ret i32 1\n}")

    if not binding.get_process_triple().startswith("x86_64"):
        pytest.skip("counts the bytes of another processor")
    assert code_words(object_code(module, target)) == 3  # five bytes to load 1, one to return


def test_a_processor_needs_all_that_the_ones_before_it_need() -> None:
    levels = [set(processor(name).needs) for name in ("x86-64-v2", "x86-64-v3", "x86-64-v4")]

    assert levels[0] < levels[1] < levels[2]


# Orders


def wordings(boat: Boat) -> list[str]:
    """Return every order that the exported boat takes, with some numbers where one is taken."""
    said = []
    for row in map(Row, rows(boat)):
        low, high = row.typed
        numbers = {max(low, 0.0), 0.3 * high, math.floor(1000.0 * high) / 1000.0}
        numbers |= {-1.0} if low < 0.0 else set()
        typed = [f"{row.words} {number:.3f}" for number in sorted(numbers)]
        said += typed if row.takes_number else [row.words]
    return [*said, *(["course 360"] if boat.automatic else [])]


@pytest.mark.parametrize("vessel", ["bb2", "sdv-mk9", "remus100"])
def test_an_order_to_an_exported_core_means_what_the_helm_makes_of_it(
    vessel: str, make_boat: Callable[..., Boat]
) -> None:
    boat = make_boat(vessel, "modified")
    boat.start(boat.file.run.start_speed_kn * 0.5, boat.file.run.start_depth_m, 0.3)
    s = boat.state
    s.psi, s.ordered_psi, s.delta_r, s.u_c = 14.1, 2.5, -0.1, 0.7
    before = boat.snapshot()
    known = {row.words: row for row in map(Row, rows(boat))}

    for text in wordings(boat):
        boat.restore(before)
        order = parse(text)
        assert isinstance(order, Order), text
        answer = obey(boat, order)
        assert not isinstance(answer, Refused), f"{text}: {answer}"
        stand_in = SimpleNamespace(state=before["whole"][0].copy())
        row = known.get(text) or known[text.rpartition(" ")[0]]
        row.carry_out(stand_in, row.number(text.split()[-1]) if row.takes_number else 0.0)  # type: ignore[arg-type]
        assert stand_in.state.tobytes() == boat.records.state.tobytes(), text


def test_a_number_the_helm_refuses_is_refused(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat("bb2", "modified")
    boat.start(5.0, 60.0, 0.0)

    for row in map(Row, rows(boat)):
        if row.takes_number:
            beyond = f"{row.typed[1] + 0.001:.4f}"
            order = parse(f"{row.words} {beyond}")
            refused = not isinstance(order, Order) or isinstance(obey(boat, order), Refused)
            assert refused, f"{row.words} {beyond}"
            with pytest.raises(WrongError, match="this boat takes"):
                row.number(beyond)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("10 rudder port 15", "rudder right NUMBER"),
        ("10 hover on", "in full words"),
        ("10 depth deep", "give a plain number"),
        ("10 depth -5", "give a plain number"),
        ("10 depth 9999", "this boat takes 0 to"),
        ("rudder right 15", "a line is SECONDS ORDER"),
        ("2000000 bell stop", "the latest time is 1000000 s"),
    ],
)
def test_a_line_that_cannot_be_followed_is_named(
    line: str, told: str, core: Core, tmp_path: Path
) -> None:
    (tmp_path / "orders.txt").write_text(f"# first\n5 bell stop\n{line}\n")

    with pytest.raises(WrongError, match=told) as wrong:
        read_schedule(str(tmp_path / "orders.txt"), core)
    assert "orders.txt:3: " in str(wrong.value)


# The run


def test_a_run_on_an_exported_core_imports_neither_numba_nor_numpy(folder: Path) -> None:
    words = [
        "run",
        "--headless",
        "--core",
        str(folder / LIBRARY),
        "--duration",
        "60",
        "--speed",
        "max",
    ]
    program = (
        f"import sys; sys.argv[1:] = {words!r}\nfrom trainer.__main__ import main\n"
        "try: main()\nexcept SystemExit as end: print(end.code, *sorted(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-S", "-c", program],
        env=os.environ | {"PYTHONPATH": str(Path(bare_core.__file__).parents[4])},
        capture_output=True,
        text=True,
        check=True,
    )

    code, *modules = done.stdout.splitlines()[-1].split()
    assert code == "0"
    assert "trainer.boat.export.runner.run" in modules
    heavy = {"numba", "numpy", "click", "re", "typing", "json", "pathlib", "hashlib", "dataclasses"}
    assert heavy.isdisjoint(modules)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--sea", "calm"], "--sea: a run on an exported core"),
        (["extra"], "extra: a run on an exported core"),
        (["--headless"], "--core: give the path"),
        (["--core", "x.so"], "add --headless"),
        (["--headless", "--core"], "--core: a value is missing"),
        (["--headless", "--core", "x.so", "--speed", "1000"], "--speed 1000: give 0.1 to 100"),
        (["--headless", "--core", "x.so", "--duration", "soon"], "--duration soon: give a time"),
        (["--headless", "--core", "x.so"], "x.so: no such file"),
        (["--headless", "--core", __file__], "not an exported core"),
    ],
)
def test_what_such_a_run_does_not_take_is_refused_by_name(
    words: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bare_run.main(words) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("text", ["90", "90s", "1.5", "10m", "1h", "1h30m", "2h1m5.5s", "1m30s"])
def test_a_duration_means_what_it_means_to_other_runs(text: str) -> None:
    assert bare_options.seconds(text) == Duration().convert(text, None, None)


@pytest.mark.parametrize("text", ["", "0", "-5", "m", "30m1h", "1h30", ".5", "5d", "1m1m", "1..2"])
def test_what_is_no_duration_to_other_runs_is_none_here(text: str) -> None:
    with pytest.raises(WrongError):
        bare_options.seconds(text)
    with pytest.raises(Exception, match=r"time|longer"):
        Duration().convert(text, None, None)


@pytest.mark.parametrize("text", ["1", "x2", "0.1", "100", "max"])
def test_a_speed_means_what_it_means_to_other_runs(text: str) -> None:
    assert bare_options.speed(text) == Speed().convert(text, None, None)


def test_a_core_of_another_version_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bare_core, "__version__", "99.0")

    with pytest.raises(WrongError, match=r"exported by trainer .*, this is 99\.0: export again"):
        Core(str(folder / LIBRARY))


def test_a_core_of_another_format_is_refused(folder: Path, tmp_path: Path) -> None:
    data = (folder / LIBRARY).read_bytes()
    heading = f"trainer-core {FORMAT}\n".encode()
    (tmp_path / "old.so").write_bytes(data.replace(heading, b"trainer-core 9\n"))

    assert data.count(heading) == 1
    with pytest.raises(WrongError, match="format 9, this trainer reads 1: export again"):
        Core(str(tmp_path / "old.so"))


@needs_linux
def test_a_core_for_another_processor_is_refused_before_it_runs(
    core: Core, folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    listing = tmp_path / "cpuinfo"
    listing.write_text(f"model name: old\nflags : {' '.join(core.card.needs)}\n")
    monkeypatch.setattr(bare_core, "LISTING", str(listing))
    monkeypatch.setattr(bare_core, "BASE", 0)

    Core(str(folder / LIBRARY))
    listing.write_text("flags : sse4_2 ssse3\n")
    with pytest.raises(WrongError, match="this processor lacks popcnt"):
        Core(str(folder / LIBRARY))


def test_a_tick_that_fails_leaves_the_state_and_ends_the_run(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = Core.__init__

    def overcome(self: Core, path: str) -> None:
        loaded(self, path)
        self.state[PLACES["u"]] = 1e5

    monkeypatch.setattr(Core, "__init__", overcome)

    code = bare_run.main(["--headless", "--core", str(folder / LIBRARY), "--speed", "max"])

    said = capsys.readouterr()
    assert code == 1
    assert re.search(r"out of all bounds after tick 0", said.err)
    assert "in 0 ticks" in said.out


def test_control_c_ends_such_a_run_with_its_account(folder: Path, tmp_path: Path) -> None:
    pipe = tmp_path / "rows"
    os.mkfifo(pipe)
    words = [
        "run",
        "--headless",
        "--core",
        str(folder / LIBRARY),
        "--speed",
        "20",
        "--csv",
        str(pipe),
    ]
    run = subprocess.Popen(
        [sys.executable, "-m", "trainer", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with pipe.open() as rows_of_run:
        heading = rows_of_run.readline()
        seen = [rows_of_run.readline() for _ in range(3)]
        run.send_signal(signal.SIGINT)
        rest = rows_of_run.read()
    said, trouble = run.communicate(timeout=30)

    assert heading.startswith("tick,t,u,v")
    assert [line.split(",")[0] for line in seen] == ["0", "1", "2"]
    assert (rest or seen[-1]).endswith("\n")
    assert run.returncode == 0, trouble
    assert "simulated" in said
    assert not trouble


def test_after_a_long_delay_five_ticks_are_made_up_and_the_rest_let_go(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = SimpleNamespace(now=100.0, slept=[])
    clock.monotonic = lambda: clock.now

    def sleep(seconds: float) -> None:
        clock.slept.append(round(seconds, 9))
        clock.now += seconds

    clock.sleep = sleep
    monkeypatch.setattr(bare_run, "time", clock)
    pace = bare_run.Pace(0.5)

    pace.wait(1)
    clock.now += 60.0
    for tick in range(2, 10):
        pace.wait(tick)

    # the tick at hand and five more are late; those after it wait for their time again
    assert clock.slept == [0.5, 0.5, 0.5]
    assert pace.late == 4


# The command


def test_without_a_compiler_the_object_is_written_and_the_way_to_link_it_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")

    done = CliRunner().invoke(cli, ["export-core", str(tmp_path), "--json"])

    assert done.exit_code == 1
    assert "there is no C compiler 'no-such-compiler' here" in done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([HOST, HEADER, OBJECT])
    assert json.loads(done.stdout)["files"] == [OBJECT, HEADER, HOST]


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
        export(boat_at_start(OPTIONS), tmp_path, "x86-64-v2")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file_is_named_before_anything_is_compiled(
    tmp_path: Path, make_boat: Callable[..., Boat]
) -> None:
    (tmp_path / "core").write_text("")

    with pytest.raises(ConfigError, match="core: File exists"):
        export(make_boat("bb2"), tmp_path / "core", "x86-64-v2")


@pytest.mark.slow
@pytest.mark.long
def test_start_and_memory_are_measured_beside_pythons_own() -> None:
    figures = measure_exported("bb2", 2)

    assert figures.first_tick.least_ms > 0.0
    assert figures.python.least_ms > 0.0
    assert figures.times_python == figures.first_tick.least_ms / figures.python.least_ms
    assert 1.0 < figures.times_python_memory < 2.0
    assert f"{figures.times_python:.2f} times Python's own" in "\n".join(lines(figures))
    assert (figures.wasm_hour_ms is None) is (shutil.which("node") is None)
