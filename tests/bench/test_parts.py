"""The comparisons of the bench: each by itself, all in one, and what cannot be measured said."""

import json
import re
import shutil
from dataclasses import dataclass
from typing import Any

import click
import pytest
from c_twin.compiler import SAME_BITS
from helpers.tables_1969 import CORE_WORDS
from helpers.typed import type_command

from bench import control, footprint, peers, sections, wasm
from bench import parts as parts_module
from bench.__main__ import bench
from bench.batches import BatchCost
from bench.sections import OmittedSection, Section, or_left_out
from bench.standard_hour import levels_here
from bench.web import NoBrowserError
from trainer.cli.main import run_command
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.core.scheme import SCHEME
from trainer.core.state import STATE
from trainer.core.vessel import COMPACT, VESSEL
from trainer.session.time.pacer import SPIN_TIME_NS

OPTIONS = [f"--{name.replace('_', '-')}" for name in sections.SECTIONS]
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
def test_every_part_has_an_option_and_without_one_all_are_measured() -> None:
    for option, name in zip(OPTIONS, sections.SECTIONS, strict=True):
        assert said(option) == f"PART {name}\n"
    assert json.loads(said("--json")).keys() == sections.SECTIONS.keys()


def test_a_part_without_its_compiler_is_left_out_and_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")

    why = "no C was compiled: CC is 'no-such-compiler', which is not here"
    for part in ("--against-c", "--beside-c"):
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
    assert len(figures.sha256) == 2 + len(levels_here()) + len(SAME_BITS)


@pytest.mark.process
@pytest.mark.skipif(not shutil.which("node"), reason="node is not here")
def test_an_hour_in_node_is_timed_without_its_start() -> None:
    figures = wasm.time_hour_in_node(load_vessel("bb2"), 1)

    assert figures.ticks == 7200
    assert f"7200 ticks {figures.hour_ms:.0f} ms" in wasm.lines(figures)[-1]


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


@pytest.mark.process
@pytest.mark.slow
def test_the_tick_is_timed_beside_that_of_a_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts_module, "TICKS", 50)
    with parts_module.core_process(parts_module.ROOT, load_vessel("bb2")) as child:
        assert all(parts_module.batch_ns(child, *regime) > 0 for regime in (("calm", 60.0),) * 2)


def test_the_commit_that_is_typed_is_the_one_whose_tick_is_beside_ours(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def timed(file: VesselFile, commit: str | None = None) -> parts_module.PartTimes:
        none = dict.fromkeys(parts_module.REGIMES, 0.0)
        each = {name: dict.fromkeys(parts_module.PARTS, 0.0) for name in none}
        return parts_module.PartTimes(file.name, none, each, commit, none)

    monkeypatch.setattr(parts_module, "time_parts", timed)

    typed = [said("--parts", *words, "--json") for words in ([], ["--against", "HEAD~1"])]

    assert [json.loads(page)["parts"]["against"] for page in typed] == [None, "HEAD~1"]


@pytest.mark.process
def test_a_commit_that_is_not_there_is_told() -> None:  # a copy may have no history at all
    lacks = r"--against no-such-commit: fatal: .*(no-such-commit|not a git repository)"
    with pytest.raises(ConfigError, match=lacks):
        parts_module.time_against(load_vessel("bb2"), "no-such-commit")


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


def test_any_other_trouble_of_a_part_is_not_taken_for_what_the_machine_lacks() -> None:
    def fails(_: Any) -> None:
        raise ValueError("another")

    def lacks(_: Any) -> None:
        raise NoBrowserError("none")

    def measured(measure: Any) -> Any:
        return or_left_out(NoBrowserError, Section(measure, list)).measure(None)

    assert measured(lacks) == OmittedSection("none")
    with pytest.raises(ValueError, match="another"):
        measured(fails)


def test_the_state_is_under_4_kib_and_records_are_whole_words() -> None:
    assert STATE.itemsize < 4096
    assert all(each.itemsize % 2 == 0 for each in (STATE, VESSEL, COMPACT, SCHEME))
