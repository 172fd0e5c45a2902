"""The comparisons of the bench: each by itself, all in one, and what cannot be measured said."""

import json
import re
import shutil
from dataclasses import dataclass, replace
from typing import Any

import click
import pytest
from c_twin import comparison
from c_twin.compiler import BUILDS, SAME_BITS
from helpers.tables_1969 import CORE_WORDS
from helpers.typed import type_command
from llvmlite import binding  # type: ignore[import-untyped]

from bench import control, footprint, peers, sections, wasm
from bench import fleet as fleet_module
from bench import parts as parts_module
from bench.__main__ import bench
from bench.fleet import SideBySide
from trainer.analysis.bench.sections import Section
from trainer.analysis.bench.standard_hour import levels_here
from trainer.analysis.bench.tick import BatchCost
from trainer.analysis.fleet.block import supports_boat, supports_scheme
from trainer.cli.main import run_command
from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.session.time.pacer import SPIN_TIME_NS

OPTIONS = [f"--{name.replace('_', '-')}" for name in sections.SECTIONS]
HALVER = """
target triple = "x86_64-unknown-linux-gnu"
@factor = internal constant [4 x double] [double 1.0, double 0.5, double 0.25, double 0.125]
define double @half(double %x, i64 %n) {
  %place = getelementptr double, ptr @factor, i64 %n
  %y = load double, ptr %place
  %z = fmul double %x, %y
  ret double %z
}
"""


needs_compiler = pytest.mark.skipif(
    not shutil.which("gcc") and not shutil.which("cc"), reason="no C compiler"
)


@dataclass(frozen=True)
class Figure:
    """What a part found."""

    name: str


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every part be measured at once."""
    for name in sections.SECTIONS:
        part = Section(lambda _, name=name: Figure(name), lambda f: ["", f"PART {f.name}"])  # type: ignore[misc]
        monkeypatch.setitem(sections.SECTIONS, name, part)


def said(*words: str) -> str:
    """Return what the command prints."""
    return type_command(bench, *words).output


@pytest.mark.usefixtures("quick")
def test_every_part_has_an_option_and_is_printed_by_itself() -> None:
    for option, name in zip(OPTIONS, sections.SECTIONS, strict=True):
        assert said(option) == f"PART {name}\n"
        assert json.loads(said(option, "--json")) == {name: {"name": name}}


@pytest.mark.usefixtures("quick")
def test_without_an_option_every_part_is_measured() -> None:
    tree = json.loads(said("--json"))

    assert tree.keys() == sections.SECTIONS.keys()
    assert said().count("PART ") == len(sections.SECTIONS)


def test_a_part_without_its_compiler_is_left_out_and_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")

    why = "no C was compiled: CC is 'no-such-compiler', which is not here"
    for part in ("--against-c", "--same-bits", "--beside-c"):
        assert said(part).startswith(why)
    assert json.loads(said("--against-c", "--json"))["against_c"]["left_out"].startswith(why)


@pytest.mark.process
@needs_compiler
def test_the_clock_is_timed_beside_the_same_loop_in_c() -> None:
    figures = control.time_beside_c(0.2)

    for lateness in (figures.lateness, figures.lateness_in_c):
        assert 0 <= lateness.p50_ns <= lateness.p99_ns <= lateness.max_ns
    assert figures.times_the_c == figures.lateness.p99_ns / max(figures.lateness_in_c.p99_ns, 1)
    assert f"99 % is {figures.times_the_c:.2f} times" in "\n".join(control.lines(figures))


def test_the_loop_in_c_sleeps_and_spins_as_the_clock_does() -> None:
    spin = re.search(r"#define SPIN (\d+)", control.CONTROL.read_text())

    assert spin
    assert int(spin[1]) == SPIN_TIME_NS


@pytest.mark.process
@pytest.mark.slow
@needs_compiler
def test_the_standard_hour_ends_in_the_same_bits_in_every_way_and_in_c() -> None:
    figures = sections.same_bits_as_c()

    assert figures.same
    assert len(figures.sha256) == 3 + len(levels_here()) + len(SAME_BITS)


@pytest.mark.process
@pytest.mark.skipif(not shutil.which("node"), reason="node is not here")
def test_an_hour_in_node_is_timed_without_its_start() -> None:
    figures = wasm.time_hour_in_node(load_vessel("bb2"), 1)

    assert figures.ticks == 7200
    assert f"7200 ticks {figures.hour_ms:.0f} ms" in wasm.lines(figures)[-1]


def test_without_node_the_hour_is_left_out_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda _name: None)

    assert said("--wasm") == "no hour was flown: node is not here; install the package nodejs\n"


def test_a_ratio_is_the_median_of_pairs_and_a_tick_the_least(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(comparison, "PAIRS", 3)
    spent = iter([8000, 4000, 12000, 12000, 40000, 10000])  # ratios 2, 1, 4
    monkeypatch.setattr(comparison, "time_repetitions", lambda *_: next(spent))

    ours, other, ratio = comparison.time_pair(lambda _: None, lambda _: None)

    assert (ours * comparison.TICKS, other * comparison.TICKS, ratio) == (8000.0, 4000.0, 2.0)


@pytest.mark.process
@needs_compiler
def test_the_tick_is_timed_against_each_way_of_compiling_the_same_in_c(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(comparison, "PAIRS", 1)
    monkeypatch.setattr(comparison, "TICKS", 50)
    monkeypatch.setattr(comparison, "without_jit", lambda _: 1e5)
    monkeypatch.setattr(comparison, "BUILDS", BUILDS[:1])  # each takes a compiler a while

    figures = comparison.against_c(load_vessel("bb2"))
    page = "\n".join(comparison.lines(figures))

    for rows in (figures.in_a_sea, figures.in_a_calm):
        assert [row.other for row in rows] == [way.name for way in BUILDS[:1]]
        assert all(row.tick_ns > 0.0 and row.other_ns > 0.0 for row in rows)
    assert figures.times_interpreted == 1e5 / min(row.tick_ns for row in figures.in_a_sea)
    assert page.isascii()
    assert " ".join(BUILDS[0].flags) in page


def test_boats_side_by_side_are_told_as_times_of_one_in_c() -> None:
    figures = SideBySide(
        vessel="a boat",
        ticks_a_flight=120,
        alone_per_s=3e6,
        c_per_s=4e6,
        few_boats=1024,
        few_per_s=24e6,
        levels_per_s={"x86-64-v3": 12e6},
        many_boats=65536,
        many_per_s=18e6,
        threads=2,
        threads_per_s=40e6,
        many_of_few=0.75,
        threads_of_one=1.6,
    )

    page = [" ".join(line.split()) for line in fleet_module.lines(figures)]

    assert "one, in a compiled loop 3.00 0.75" in page
    assert "1024 24.00 6.00" in page
    assert "1024, for x86-64-v3 12.00 3.00" in page
    assert "65536 18.00 4.50 75% of 1024" in page
    assert "2 threads of 1024 40.00 10.00 1.60 of one" in page
    alone = fleet_module.lines(replace(figures, c_per_s=None))
    assert not any("in C" in line for line in alone)
    assert " ".join(alone[-2].split()) == "65536 18.00 6.00 75% of 1024"
    assert max(map(len, [*alone, *fleet_module.lines(figures)])) <= 79


def test_fleets_of_the_bench_keep_depths_and_courses_of_their_own() -> None:
    boat = fleet_module.under_way(load_vessel("bb2"))

    fleet = fleet_module.fleet_of(boat, 3)

    depth = boat.state.z
    assert fleet.states["ordered_depth"].tolist() == [depth - 10.0, depth, depth + 10.0]
    assert fleet.states["ordered_psi"].tolist() == [-1.0, 0.0, 1.0]
    assert fleet.states["u"].tolist() == [boat.state.u] * 3
    assert supports_scheme(boat.records.scheme), "what is timed is flown side by side"
    assert supports_boat(boat.records.vessel, boat.records.state)


def test_the_fastest_of_several_flights_counts_but_never_the_first() -> None:
    ticks = iter([0.0, 1.0, 1.0, 2.0] + [0.0, 7.0, 7.0, 19.0] * 8 + [0.0, 5.0, 5.0, 15.0])

    fastest = fleet_module.fastest_s([lambda: None, lambda: None], lambda: next(ticks))

    assert fastest == [5.0, 10.0]


@pytest.mark.process
@pytest.mark.slow
def test_rates_are_measured_of_fleets_alone_in_threads_and_by_level(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, few in (("FEW", 32), ("MANY", 64), ("ALONE", 50), ("FLIGHTS", 1)):
        monkeypatch.setattr(fleet_module, name, few)
    monkeypatch.setattr(fleet_module, "levels_here", lambda: ["x86-64-v2"])
    monkeypatch.setattr(fleet_module, "level_per_s", lambda _file, level: len(level) * 1.0)

    figures = fleet_module.time_side_by_side(load_vessel("bb2"))

    rates = (figures.alone_per_s, figures.few_per_s, figures.many_per_s, figures.threads_per_s)
    assert min(rates) > 0.0
    assert figures.levels_per_s == {"x86-64-v2": 9.0}
    assert (figures.few_boats, figures.many_boats) == (32, 64)
    assert figures.many_of_few == pytest.approx(figures.many_per_s / figures.few_per_s)
    assert fleet_module.few_per_s(str(load_vessel("bb2").path)) > 0.0


def test_a_peer_that_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "library", lambda _: None)
    cost = BatchCost(2.0, 1.0, 21, 9)
    monkeypatch.setattr(peers, "time_batches", lambda works: [cost] * len(works))

    figures = peers.time_peers(load_vessel("bb2"))

    assert figures.peers == ()
    assert peers.lines(figures)[-2:] == ["  jsbsim: not installed", "  scipy: not installed"]


def test_a_step_of_scipy_takes_the_boat_on(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("scipy.integrate")
    known = peers.library
    monkeypatch.setattr(peers, "library", lambda name: None if name == "jsbsim" else known(name))

    def timed(works: list[Any]) -> list[BatchCost]:
        for work in works:
            work(3)
        return [BatchCost(1e3, 1e3, 21, 3), BatchCost(6e3, 5e3, 21, 3)]

    monkeypatch.setattr(peers, "time_batches", timed)

    figures = peers.time_peers(load_vessel("bb2"))

    assert [peer.name for peer in figures.peers] == ["scipy"]
    assert 0.0 < figures.peers[0].step_s <= 2.0
    assert figures.peers[0].times_ours == 5.0


def test_the_tick_is_told_by_its_parts_and_beside_another_commit() -> None:
    parts = {name: dict.fromkeys(parts_module.PARTS, 20.0) for name in parts_module.REGIMES}
    ticks = {name: 100.0 + i for i, name in enumerate(parts_module.REGIMES)}
    ratios = dict.fromkeys(parts_module.REGIMES, 0.5)

    figures = parts_module.PartTimes("a boat", ticks, parts, "ae943c54", ratios)
    page = [" ".join(line.split()) for line in parts_module.lines(figures)]

    assert page[2] == "sea, 18 m sea, 60 m calm, 18 m calm, 60 m"
    assert page[3] == "tick 100 101 102 103"
    assert page[4:-1] == [f"{part} 20 20 20 20" for part in parts_module.PARTS]
    assert page[-1] == "tick/ae943c54 0.50 0.50 0.50 0.50"
    alone = parts_module.lines(replace(figures, against=None, ratio={}))
    assert len(alone) == len(page) - 1


@pytest.mark.process
@pytest.mark.slow
def test_the_tick_is_timed_beside_that_of_a_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts_module, "TICKS", 50)
    with parts_module.core_process(parts_module.ROOT, load_vessel("bb2")) as child:
        assert all(parts_module.batch_ns(child, *regime) > 0 for regime in (("calm", 60.0),) * 2)


@pytest.mark.process
def test_a_commit_that_is_not_there_is_told() -> None:  # a copy may have no history at all
    lacks = r"--against no-such-commit: fatal: .*(no-such-commit|not a git repository)"
    with pytest.raises(ConfigError, match=lacks):
        parts_module.time_against(load_vessel("bb2"), "no-such-commit")


def test_code_and_constants_of_an_object_are_counted_apart() -> None:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()

    code, constants = footprint.sizes(footprint.small_object(HALVER, "x86-64-v3"))

    assert constants >= 32  # four doubles
    assert 0 < code < 64  # a load, a product, a return


def test_numbers_of_the_state_are_counted_from_one_to_another() -> None:
    assert footprint.words_of("last_turn", "last_turn") == 12
    assert footprint.words_of("last_turn", "validity") == 24


def test_the_words_are_printed_beside_those_of_1969() -> None:
    figures = footprint.Footprint(
        (
            footprint.Code("update", "x86-64-v4", 2506, 100, 1253),
            footprint.Code("wide", "x86-64-v4", 3000, 50, None),
            footprint.Code("elementary", "x86-64-v4", 270, 20, None),
        ),
        *(992, {"the wide set": 24}, 412, 4000, 4096),
    )

    page = footprint.lines(figures)

    assert [each for each in CORE_WORDS if not any(each in line for line in page)] == ["UPDATE"]
    assert "  SQRT and SIN/COS         270                317" in page
    assert "  COMMON                  1404                268" in page
    assert "  update  x86-64-v4       2506        100    1253    2.00" in page
    assert "  the tick with all of it 4000; half the memory of 1969: 4096" in page
    assert page[-2:] == ["  wide    x86-64-v4       3000         50", "  state, the wide set 24"]


def test_what_another_program_lacks_is_told_in_its_own_words(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["lacking"])

    @click.command()
    def lacking() -> None:
        raise OSError("Can't find the default root directory")  # JSBSim's, without a number

    with pytest.raises(SystemExit) as left:
        run_command(lacking, "lacking")

    assert left.value.code == 1
    assert capsys.readouterr().err == "trainer: Can't find the default root directory\n"
