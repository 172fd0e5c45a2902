"""The shipped machine code: all that is called is in it, whole, and nothing else is needed."""

import ast
import gc
import gzip
import hashlib
import importlib
import json
import os
import platform
import re
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np
import pytest
from bench.standard_hour import digest, fly_standard_hour
from helpers import places
from helpers.boats import make_boat, start_boat, take_ticks
from helpers.installation import run_program
from helpers.loops import in_a_loop
from helpers.object_symbols import symbols
from llvmlite import binding

from trainer.boat import entries, machine_code, object_image, platforms
from trainer.boat.export import objects
from trainer.boat.export.fmu import SOURCE_FOLDER
from trainer.core import ballast, entry, kernel
from trainer.core.ballast.hover import wanted_pump
from trainer.core.current import north_and_east
from trainer.core.digest import core_digest, read_source
from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Numbers
from trainer.core.rates import rates
from trainer.core.sea.free_surface import sail_height
from trainer.core.sea.sea import order_sea
from trainer.core.state import new_sea, new_state

FOLDER = machine_code.SHIPPED_FOLDER
HERE = platforms.fitting_name(binding.get_host_cpu_features()) or ""
MAKE = "trainer boat export-core trainer/boat/shipped --cpu shipped"
CALLERS = ("analysis", "api", "boat", "config", "debrief", "report", "session", "cli")
# what goes on compiling: ships, and what is lowered
COMPILING = ("analysis/sweep", "boat/ship", "boat/export", "identify")
MAX_BYTES = 1_170_000  # of all objects, a quarter of it for units
MANY_PER_CALL = {entry.fly, entry.sail, entry.steer}
jitted = pytest.mark.skipif(
    machine_code.way_name() != "shipped", reason="settings of numba ask for other code"
)


def unpacked(name: str) -> bytes:
    return gzip.decompress((FOLDER / f"{name}.o.gz").read_bytes())


DECORATORS = {"kernel", "inline_kernel", "unlocked"}


def core_thing(module: str, name: str) -> Any:
    """Return what a module of the core has by a name, a module of its own among it."""
    place = importlib.import_module(module)
    if hasattr(place, name):
        return getattr(place, name)
    return importlib.import_module(f"{module}.{name}")


def core_things(tree: ast.AST) -> dict[str, Any]:
    """Return what a module imports of the core, by its name there; the module is not imported."""
    return {
        name.asname or name.name: core_thing(node.module, name.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module and "trainer.core" in node.module
        for name in node.names
    }


def called_kernels(path: Path) -> Iterator[kernel.Kernel]:
    """Yield the kernels of the core that functions of a module use which are no kernels."""
    if "trainer.core" not in (text := path.read_text("utf-8")):
        return
    tree = ast.parse(text)
    known = core_things(tree)
    inside = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        and DECORATORS & {ast.unparse(each) for each in function.decorator_list}
        for node in ast.walk(function)
    }
    for node in ast.walk(tree):
        thing = None
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
            thing = known.get(node.id)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            thing = getattr(known.get(node.value.id), node.attr, None)
        if isinstance(thing, kernel.Kernel) and id(node) not in inside:
            yield thing


@jitted
def test_every_kernel_that_is_called_from_outside_the_core_is_in_the_object() -> None:
    package = places.PACKAGES / "trainer"
    left = tuple(str(package / folder) for folder in COMPILING)
    missing = {
        f"{path.relative_to(package)}: {called.__module__}.{called.py_func.__name__}"
        for folder in CALLERS
        for path in sorted((package / folder).rglob("*.py"))
        if path.name != "__main__.py" and not str(path).startswith(left)
        for called in called_kernels(path)
        if called not in {each.kernel for each in entries.KERNEL_ENTRIES}
    }

    assert not missing


@jitted
def test_the_table_has_what_is_called_and_nothing_else() -> None:
    package = places.PACKAGES / "trainer"
    called = {
        each
        for folder in CALLERS
        for path in sorted((package / folder).rglob("*.py"))
        if path.name not in {"__main__.py", "entries.py"}
        for each in called_kernels(path)
    }

    assert {each.name for each in entries.KERNEL_ENTRIES if each.kernel not in called} == set()


def test_the_shipped_objects_are_of_this_core_and_whole() -> None:
    card = machine_code.shipped_card()

    assert card["core"] == core_digest(), f"make them again: {MAKE}"
    for room in platforms.ROOMS:
        assert card[room] == entries.digest_room(room), f"make them again: {MAKE}"
    assert set(card["objects"]) == set(platforms.SHIPPED_OBJECTS)
    for name, said in card["objects"].items():
        code = unpacked(name)
        assert (len(code), hashlib.sha256(code).hexdigest()) == (said["bytes"], said["sha256"])
    assert sum(path.stat().st_size for path in machine_code.SHIPPED_FOLDER.iterdir()) < MAX_BYTES


@pytest.mark.parametrize("name", platforms.SHIPPED_OBJECTS)
def test_an_object_has_its_entries_and_asks_for_nothing(name: str) -> None:
    found = [(symbol.removeprefix("_"), known) for symbol, known in symbols(unpacked(name))]
    room = next((each for each in platforms.ROOMS if name.startswith(f"{each}-")), "")
    all_entries = {each.name for each in entries.entries_of(room)}
    all_entries |= {each.bound_name for each in entries.entries_of(room) if each.bound}
    unit = (SOURCE_FOLDER / "unit.c").read_text("utf-8")
    called = {each for each in all_entries if re.search(rf"^int {each}\(", unit, re.MULTILINE)}

    assert [symbol for symbol, known in found if not known] == []
    of_unit = name in platforms.UNIT_OBJECTS.values()
    assert {symbol for symbol, _ in found} == (called if of_unit else all_entries)


@pytest.mark.process
@pytest.mark.slow
def test_the_objects_made_again_are_those_that_are_shipped() -> None:
    card = machine_code.shipped_card()
    here = (platform.python_version(), numba.__version__, llvmlite.__version__)
    if here == (card["python"], card["numba"], card["llvmlite"]):
        made = objects.make_objects(*platforms.SHIPPED_OBJECTS)
        assert {name: hashlib.sha256(code).hexdigest() for name, code in made.items()} == {
            name: said["sha256"] for name, said in card["objects"].items()
        }
    else:  # another compiler may write other bytes, whose hour is the same
        made = objects.make_objects(HERE)
    library = machine_code.Library(made[HERE])
    address = library.address_of("trainer_fly")
    fly = machine_code.call_entry(
        next(e for e in entries.KERNEL_ENTRIES if e.kernel is entry.fly), address
    )
    empty = machine_code.EMPTY_CHART

    def take(records: Any, count: int) -> int:
        return int(fly(records, empty, empty, np.empty((count, 0))))

    assert digest(fly_standard_hour(take)) == digest(fly_standard_hour(in_a_loop))


@jitted
def test_a_kernel_called_from_python_is_the_object_s() -> None:
    boat = start_boat(5.0)
    records, asked = boat.records, (wanted_pump, ballast.hover.is_hovering, rates)
    for called in asked:
        vars(called).pop("dispatcher", None)  # that a test before this one has asked for
    assert north_and_east(1.25) == pytest.approx(cosine_and_sine(1.25), abs=0.0)
    assert isinstance(wanted_pump(records.vessel, 60.0, records.state), float)
    assert ballast.hover.is_hovering(records.state) is False
    assert rates(*records) is None
    # the object's code, and no dispatcher of numba, has answered
    for called in asked:
        assert "dispatcher" not in vars(called)


@jitted
def test_what_the_object_does_not_take_numba_takes() -> None:
    vessel = make_boat().records.vessel
    wanted = np.zeros(9)
    wanted[:3] = 1.0, 2.0, 0.8
    states = [new_state(), new_state()]
    for state, scratch in zip(states, (new_sea(), make_boat().records.scratch), strict=True):
        order_sea(vessel, 0.5, 0.0, wanted, scratch, state)

    assert states[0].tobytes() == states[1].tobytes()


@jitted
@pytest.mark.parametrize("wanted", [np.zeros(10), np.zeros(9, np.float32), np.zeros((9, 1))])
def test_numbers_of_another_size_or_kind_are_numba_s(
    monkeypatch: pytest.MonkeyPatch, wanted: Numbers
) -> None:
    records = make_boat().records
    monkeypatch.setitem(vars(order_sea), "dispatcher", lambda *_: "numba's")

    answer = order_sea(records.vessel, 0.5, 0.0, wanted, records.scratch, records.state)

    assert answer == "numba's"


@jitted
def test_a_kernel_called_for_two_boats_in_turns_takes_each_one_s_records() -> None:
    boats = [make_boat() for _ in range(2)]
    depths = (8.0, 12.0)
    for boat, depth in zip(boats, depths, strict=True):
        boat.start(5.0, depth, 0.0)
    heights = [sail_height(boat.records.vessel, boat.records.state) for boat in boats * 3]

    assert heights == heights[:2] * 3
    assert heights[0] - heights[1] == pytest.approx(depths[1] - depths[0])
    other = make_boat("remus100")  # one record is another, and one the same
    changed = sail_height(other.records.vessel, boats[1].records.state)
    assert changed != heights[1]
    with pytest.raises(Exception, match="none"):  # numba's, and no end of the process
        sail_height(None, None)  # type: ignore[arg-type]


@jitted
def test_numbers_that_may_only_be_read_are_taken_by_the_object_too() -> None:
    vars(entry.fly).pop("dispatcher", None)  # that a test before this one has asked for
    flown = []
    for may_be_written in (True, False):
        boat, places, rows = make_boat(), np.arange(3.0), np.empty((4, 3))
        boat.start(5.0, 60.0, 0.0)
        places.flags.writeable = may_be_written
        assert entry.fly(boat.records, machine_code.EMPTY_CHART, places, rows) == 0
        flown.append(rows.tobytes())

    assert flown[0] == flown[1]
    assert "dispatcher" not in vars(entry.fly)


def test_only_calls_of_many_ticks_let_other_threads_go_on() -> None:
    assert {each.kernel for each in entries.KERNEL_ENTRIES if each.many_ticks} == MANY_PER_CALL


@jitted
@pytest.mark.process
def test_two_boats_and_a_fork_tick_as_one_does() -> None:
    boats = [make_boat() for _ in range(3)]
    for boat in boats:
        boat.start(5.0, 60.0, 0.0)
        boat.state.ordered_depth = 80.0
    take_ticks(boats[0], 40)
    threads = [threading.Thread(target=take_ticks, args=(boat, 20)) for boat in boats[1:]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    read, write = os.pipe()
    if os.fork() == 0:
        take_ticks(boats[1], 20)
        os.write(write, hashlib.sha256(boats[1].records.state.tobytes()).digest())
        os._exit(0)
    os.wait()
    kept = boats[2].snapshot()
    address = boats[2].records.state.ctypes.data
    take_ticks(boats[2], 5)
    boats[2].restore(kept)
    take_ticks(boats[2], 20)

    assert boats[2].records.state.ctypes.data == address
    assert boats[2].records.state.tobytes() == boats[0].records.state.tobytes()
    assert os.read(read, 32) == hashlib.sha256(boats[0].records.state.tobytes()).digest()


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with copies of this platform's object and card, which is used."""
    name = f"{HERE}.o.gz"
    for each in (name, platforms.CARD_FILE):
        (tmp_path / each).write_bytes((machine_code.SHIPPED_FOLDER / each).read_bytes())
    monkeypatch.setattr(machine_code, "SHIPPED_FOLDER", tmp_path)
    assert machine_code.shipped_object() == unpacked(HERE)
    return tmp_path / name


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def of_another_platform(path: Path) -> None:
    others = set(platforms.SHIPPED_PLATFORMS) - {HERE}
    path.write_bytes(gzip.compress(unpacked(others.pop())))


def changed(path: Path) -> None:
    code = bytearray(unpacked(HERE))
    code[len(code) // 2] ^= 1
    path.write_bytes(gzip.compress(bytes(code)))


@pytest.mark.parametrize(
    "harm", [cut, changed, of_another_platform, Path.unlink, lambda path: path.write_bytes(b"")]
)
def test_an_object_that_is_not_whole_is_never_loaded_and_told(
    shipped: Path, harm: Callable[[Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    harm(shipped)

    assert machine_code.shipped_object() is None
    assert capsys.readouterr().err == (
        f"trainer: {shipped}: damaged, and not used: install again\n"
    )


@pytest.mark.parametrize("card", [b"", b"[1]", b"{", b"\xff"])
def test_an_object_without_a_card_is_not_used(shipped: Path, card: bytes) -> None:
    shipped.with_name(platforms.CARD_FILE).write_bytes(card)

    assert machine_code.shipped_object() is None


def test_an_object_of_another_core_or_for_another_machine_is_not_used(
    shipped: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in (("fitting_name", lambda _: None), ("core_digest", lambda: "of another")):
        with monkeypatch.context() as patch:
            patch.setattr(machine_code, name, value)
            assert machine_code.shipped_object() is None
    card = json.loads(shipped.with_name(platforms.CARD_FILE).read_text())
    card["core"] = "of another"
    shipped.with_name(platforms.CARD_FILE).write_text(json.dumps(card))
    assert machine_code.shipped_object() is None
    assert capsys.readouterr().err == ""


def test_an_object_is_made_here_once_in_sight_and_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made: list[str] = []

    def make(name: str) -> dict[str, bytes]:
        made.append(name)
        return {name: b"code"}

    monkeypatch.setattr(objects, "make_objects", make)
    monkeypatch.setattr("trainer.core.cache.cache_folder", lambda: tmp_path)

    assert machine_code.made_object() == machine_code.made_object() == b"code"
    assert made == [machine_code.HOST_NAME]
    assert capsys.readouterr().err == f"{machine_code.MAKING_TEXT}\n"
    (kept,) = tmp_path.glob("*.o")
    kept.write_bytes(b"odd")
    assert machine_code.made_object() == b"code"
    assert len(made) == 2


def test_where_no_machine_code_may_be_made_that_is_said_and_how_to_allow_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse() -> None:
        raise OSError("no")

    monkeypatch.setattr(binding, "check_jit_execution", refuse)

    with pytest.raises(PermissionError, match="MemoryDenyWriteExecute=no"):
        machine_code.Library(b"never read")


on_linux = pytest.mark.skipif(
    platforms.platform_name() != "linux-x86_64", reason="LLVM loads the object"
)


def _change(code: bytes, kind: int, field: str, value: int) -> bytes:
    """Return an object with a field of its first full section of a kind, or of what is in it."""
    changed = bytearray(code)
    begin, count = (int.from_bytes(code[a:b], "little") for a, b in ((40, 48), (60, 62)))
    sections = np.frombuffer(changed, object_image.SECTION_LAYOUT, count, begin)
    first = np.flatnonzero((sections["kind"] == kind) & (sections["size"] > 0))[0]
    section = sections[first]
    rows = (
        {2: object_image.SYMBOL_LAYOUT, 4: object_image.RELOCATION_LAYOUT}[kind]
        if " " in field
        else None
    )
    if rows is not None:
        number = int(section["size"]) // rows.itemsize
        found = np.frombuffer(changed, rows, number, section["begin"])
        found[field.removeprefix("last ")][-1] = value
    else:
        sections[field][first] = value
    return bytes(changed)


@on_linux
@pytest.mark.parametrize(
    ("kind", "field", "value"),
    [
        (object_image.RELOCATIONS, "last kind", 42),  # R_X86_64_REX_GOTPCRELX
        (object_image.RELOCATIONS, "last place", 2**40),
        (object_image.RELOCATIONS, "last added", -(2**40)),
        (object_image.RELOCATIONS, "last symbol", 2**20),
        (object_image.RELOCATIONS, "kind", 9),  # without what is added
        (object_image.SYMBOLS, "last section", 0),  # of another object
        (object_image.PLAIN, "kind", 14),  # functions to be called first
        (object_image.PLAIN, "flags", 0x403),  # each thread's own
        (object_image.PLAIN, "flags", 3),  # written while it runs
        (object_image.PLAIN, "step", 4096),
    ],
)
def test_an_object_that_asks_for_more_than_its_own_addresses_is_left_to_llvm(
    kind: int, field: str, value: int
) -> None:
    with pytest.raises((ValueError, IndexError), match=r"unknown|out of bounds"):
        object_image.ObjectImage(_change(unpacked(HERE), kind, field, value))


@on_linux
def test_machine_code_stays_for_good_and_no_memory_is_written_and_run_at_once() -> None:
    address = machine_code.Library(unpacked(HERE)).address_of(entries.KERNEL_ENTRIES[0].name)
    gc.collect()
    rows = [line.split() for line in Path("/proc/self/maps").read_text("utf-8").splitlines()]
    spans = [([int(each, 16) for each in row[0].split("-")], row[1]) for row in rows]
    assert [way for (begin, end), way in spans if begin <= address < end] == ["r-xp"]


@jitted
def test_llvm_loads_what_the_image_refuses_and_neither_has_what_is_not_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(_: bytes) -> None:
        raise ValueError("another system")

    by_image = machine_code.Library(unpacked(HERE))
    monkeypatch.setattr(machine_code, "ObjectImage", refuse)
    by_llvm = machine_code.Library(unpacked(HERE))
    for library in (by_image, by_llvm):
        assert not library.address_of("nothing")
        assert all(library.address_of(each.name) for each in entries.KERNEL_ENTRIES)


@pytest.mark.process
@on_linux
@jitted
def test_a_system_that_lets_no_memory_become_executable_is_told() -> None:
    code = (
        "import ctypes, trainer; from trainer.boat import machine_code\n"
        "code = machine_code.shipped_object()\n"
        "print(ctypes.CDLL(None).prctl(65, 1, 0, 0, 0))\n"  # PR_SET_MDWE, of Linux 6.3
        "try: machine_code.Library(code)\n"
        "except PermissionError as problem: print(problem)"
    )
    answer, *told = run_program([sys.executable, "-c", code]).stdout.splitlines()
    if answer != "0":
        pytest.skip("this kernel has no such rule")
    assert "MemoryDenyWriteExecute=no" in told[0]


def test_the_newest_processor_level_that_a_machine_has_is_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flags = platforms.flags_of("x86-64-v3")
    all_of_them = {platforms.LLVM_NAMES.get(flag, flag): True for flag in flags}
    monkeypatch.setattr(platforms, "platform_name", lambda: "linux-x86_64")
    assert platforms.fitting_name(all_of_them) == "linux-x86_64-v3"
    assert platforms.fitting_name(all_of_them | {"avx2": False}) == "linux-x86_64"
    assert platforms.fitting_name(all_of_them | {"popcnt": False}) is None
    monkeypatch.setattr(platforms, "platform_name", lambda: "linux-riscv64")
    assert platforms.fitting_name(all_of_them) is None


def test_a_processor_has_what_the_compiler_says_that_it_has(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    by_compiler, flags = binding.get_host_cpu_features(), platforms.flags_of("x86-64-v4")
    for facts in (platforms.CPU_FACTS, tmp_path / "none"):
        monkeypatch.setattr(platforms, "CPU_FACTS", facts)
        here = platforms.host_features()
        assert all(
            platforms.has_flag(here, flag) == platforms.has_flag(by_compiler, flag)
            for flag in flags
        )


LANES = {
    "interpreted": {"NUMBA_DISABLE_JIT": "1"},
    "compiled by numba": {"NUMBA_BOUNDSCHECK": "1"},
    "compiled by  numba": {"NUMBA_CPU_NAME": "x86-64-v3"},
    "shipped": {},
}


@pytest.mark.process
@pytest.mark.parametrize("way", LANES)
def test_a_lane_runs_the_code_that_it_is_about(way: str) -> None:
    own = {
        name: value for name, value in places.environment().items() if not name.startswith("NUMBA_")
    }
    code = "from trainer.boat.machine_code import way_name; print(way_name())"
    done = run_program([sys.executable, "-c", code], env=own | LANES[way])

    assert done.stdout.split() == way.split()


def test_line_ends_of_a_checkout_do_not_change_the_digest(tmp_path: Path) -> None:
    for name, ends in (("a.py", b"\n"), ("b.py", b"\r\n")):
        (tmp_path / name).write_bytes(b"x = 1" + ends + b"y = 2" + ends)

    assert read_source(tmp_path / "a.py") == read_source(tmp_path / "b.py")
