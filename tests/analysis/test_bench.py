"""What ``trainer dev bench`` measures: structure and consistency, never the machine's speed."""

import itertools
import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from helpers.places import ROOT

from trainer.analysis.bench import delays, ticks
from trainer.analysis.bench.delays import OrderDelays, StartTimes
from trainer.analysis.bench.ticks import TickFigures
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.casualties import insert_casualty
from trainer.cli import main
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError

SHORT_BATCH_TICKS = 2000
COMMAND = ROOT / "trainer/cli/workshop/bench.py"
MAX_LINES = 500  # of command and measures: what compares, or proves a bound, is tests/bench


def test_the_bench_of_this_machine_stays_small() -> None:
    modules = [COMMAND, *(ROOT / "trainer/analysis/bench").glob("*.py")]

    assert sum(len(path.read_text("utf-8").splitlines()) for path in modules) <= MAX_LINES


@pytest.fixture(scope="module")
def figures() -> TickFigures:
    """Return what one second at each step gives, by short batches."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(ticks, "BATCH_TICKS", SHORT_BATCH_TICKS)
        return ticks.time_duty(load_vessel("bb2"), 1)


@pytest.mark.process
def test_duty_cycle_is_work_over_step_and_is_compared_with_1969(figures: TickFigures) -> None:
    half, whole = figures.runs[0.5], figures.runs[1.0]

    assert (half.ticks, whole.ticks) == (2, 1)
    assert figures.duty_cycles_1969_percent == {0.5: 38.0, 1.0: 19.0}
    # a single tick: its duty cycle is its work
    assert whole.duty_cycle_percent == pytest.approx(100.0 * whole.work.max_ns / 1e9, abs=1e-4)
    # waiting counted as work would make it nearly all of the time
    for run in (half, whole):
        assert 0.0 < run.duty_cycle_percent < 50.0
        assert 0.0 < run.unrecorded_percent < 50.0
        assert run.work.p50_ns > 0
        assert run.counts.keys() == {"overruns", "caught up", "slipped", "gaps"}
        assert run.granted.startswith("priority ")
        for spread in (run.work, run.lateness):
            assert 0 <= spread.p50_ns <= spread.p99_ns <= spread.p999_ns <= spread.max_ns


@pytest.mark.process
def test_a_tick_is_timed_called_and_in_a_kernel_and_the_crossing_is_between(
    figures: TickFigures,
) -> None:
    cost = figures.tick

    assert 0.0 < cost.in_kernel_ns < 1e7
    assert 0.0 < cost.called_ns < 1e7
    assert cost.crossing_ns < cost.called_ns


def boat_under_way(fill: Callable[[Boat], object]) -> Boat:
    """Return BB2 with its own battery, after something was done to it."""
    boat = Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5))
    boat.start(5.0, 60.0, 0.0)
    fill(boat)
    return boat


def test_each_batch_begins_from_the_boat_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    boat, begun = boat_under_way(lambda _: None), []
    monkeypatch.setattr(ticks, "BATCH_TICKS", 10)
    fly = boat.fly

    def watched(*flown: Any) -> int:
        begun.append(boat.snapshot().tobytes())
        return fly(*flown)

    monkeypatch.setattr(boat, "fly", watched)
    ticks.time_tick(boat)

    assert len(begun) == ticks.BATCH_COUNT
    assert len({*begun}) == 1


@pytest.mark.parametrize(
    ("fill", "told"),
    [
        (lambda boat: boat.state.__setitem__("battery_spent", 1e12), "the battery went flat"),
        (lambda boat: boat.state.__setitem__("z", 5664.0), "collapse at 56"),
        (lambda boat: insert_casualty(boat, "bus-dc-lost"), "dc without power"),
        (lambda boat: boat.state.__setitem__("u", 2e3), "it has done 0 of"),
    ],
)
def test_a_boat_that_is_lost_frozen_or_without_power_has_no_figure(
    fill: Callable[[Boat], object], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ticks, "BATCH_TICKS", 200)
    boat = boat_under_way(fill)

    with pytest.raises(ConfigError, match=f"bb2.toml has no figure in a benchmark: .*{told}"):
        ticks.time_tick(boat)


@pytest.mark.process
def test_a_run_whose_boat_is_lost_has_no_figure(tmp_path: Path) -> None:
    text = Path(load_vessel("bb2").path).read_text("utf-8")
    lost = tmp_path / "lost.toml"
    for was, now in (("start_depth_m = 60.0", "start_depth_m = 250"), ("450.0", "255")):
        assert was in text
        text = text.replace(was, now, 1)
    lost.write_text(text, "utf-8")
    dive = tmp_path / "dive.txt"
    dive.write_text("0 stern planes dive 25\n", "utf-8")
    words = ("--orders", str(dive), "--duration", "120", "--speed", "max", "--no-record")

    with pytest.raises(ConfigError, match=r"no figure in a benchmark: .*collapse at 255 m"):
        ticks.sail(load_vessel(str(lost)), *words)


@pytest.mark.process
def test_the_processor_is_named_as_the_kernel_lists_it(tmp_path: Path) -> None:
    listing = tmp_path / "cpuinfo"
    listing.write_text("processor\t: 0\nmodel name\t: A Chip @ 2 GHz\nprocessor\t: 1\n")

    assert ticks.cpu_model(listing) == "A Chip @ 2 GHz"
    assert ticks.cpu_model(tmp_path / "none")


@pytest.mark.process
def test_the_page_is_in_ascii_and_tells_load_and_1969(figures: TickFigures) -> None:
    page = "\n".join(ticks.lines(figures))

    assert page.isascii()
    assert max(map(len, page.splitlines())) <= 79
    for words in ("1969: 38 %", "1969: 19 %", "load of the machine in the minute before: "):
        assert words in page


def units(tree: Any, path: str = "") -> set[str]:
    """Return the names under which numbers with a unit stand."""
    if isinstance(tree, dict):
        return {name for key, value in tree.items() for name in units(value, f"{path}.{key}")}
    if isinstance(tree, list):
        return {name for value in tree for name in units(value, path)}
    return {path} if isinstance(tree, float) else set()


@pytest.mark.process
def test_json_is_one_object_whose_keys_carry_the_units(
    figures: TickFigures, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def measured(file: Any, seconds: int) -> TickFigures:
        asked.append((file.path.name, seconds))
        return figures

    monkeypatch.setattr(ticks, "time_duty", measured)
    tree = json.loads(said("--seconds", "1", "--json"))

    assert asked == [("bb2.toml", 1)]
    assert tree == json.loads(json.dumps(asdict(figures)))
    by_unit = (name.split(".") for name in units(tree))
    assert not [each for each in by_unit if not any(p.endswith(("_ns", "_percent")) for p in each)]
    assert said("--seconds", "1") == "\n".join(ticks.lines(figures)) + "\n"


# An order's way to a page


def test_an_order_is_timed_until_the_rudder_moves_as_ordered() -> None:
    # at rest; left: not yet, then it moves; right: still on its way left, then back
    shown = iter([0.0, None, 0.0, 0.0, -1.0, None, -2.0, -2.5, -1.5, 7.0])
    words: list[str] = []

    found = delays.time_orders(load_vessel("bb2"), 0.5, words.append, lambda _: next(shown))

    assert words == ["rudder left full", "rudder right full"]
    assert len(found.delays_s) == 2
    assert min(found.delays_s) > 0.0
    assert list(shown) == [7.0]


def test_a_rudder_that_stands_still_is_not_waited_for_forever() -> None:
    waits: list[float] = []

    def look(until: float) -> float | None:
        waits.append(until - time.monotonic())
        return 0.0 if len(waits) == 1 else None

    with pytest.raises(ConfigError, match=r"bb2\.toml: the rudder is not seen to move"):
        delays.time_orders(load_vessel("bb2"), 0.25, lambda _: None, look)

    begins, _, answers = waits
    assert begins == pytest.approx(answers, abs=1.0)


@pytest.mark.parametrize("orders", [10, 12, 40])
def test_orders_come_at_instants_spread_evenly_over_a_tick(orders: int) -> None:
    phases = sorted(delays.phase(number) for number in range(orders))

    gaps = [after - before for before, after in itertools.pairwise([*phases, 1.0 + phases[0]])]
    assert max(gaps) < 2.0 / orders
    assert phases[orders // 2] == pytest.approx(0.5, abs=1.0 / orders)


def test_times_fall_into_bins_of_a_tenth_of_a_step() -> None:
    page = delays.order_lines(OrderDelays(0.5, (0.04, 0.06, 0.21)))

    assert page[1] == "  3 orders: median 60 ms (at most 270: half a step and 20 ms), most 210 ms"
    assert [line.split() for line in page[2:]] == [
        ["0", "ms", "1", "#"], ["50", "ms", "1", "#"], ["100", "ms", "0"], ["150", "ms", "0"],
        ["200", "ms", "1", "#"],
    ]  # fmt: skip


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@pytest.mark.long
def test_the_bench_steers_a_session_by_a_page_s_own_line() -> None:
    tree = json.loads(said("--latency", "--seconds", "3", "--json"))["latency"]

    assert 1 <= len(tree["delays_s"]) <= 12
    assert min(tree["delays_s"]) > 0.0
    assert tree["step_s"] == 0.5


# Starting


@pytest.mark.process
def test_where_nothing_is_compiled_a_run_compiles_nothing_and_leaves_nothing_behind(
    tmp_path: Path,
) -> None:
    words = (*delays.TRAINER_COMMAND, *delays.RUN_WORDS, "--verbose")

    assert "interpreted" not in delays.finish(*words, NUMBA_CACHE_DIR=str(tmp_path))
    assert not list(tmp_path.iterdir())


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals here")
def test_the_console_is_timed_until_it_shows_figures() -> None:
    assert 0.0 < delays.time_to_screen() < 60.0


@pytest.mark.process
def test_a_process_that_fails_is_not_timed_and_says_why() -> None:
    with pytest.raises(ConfigError, match="no figure in a benchmark: too shallow"):
        delays.time_to_end(sys.executable, "-c", "raise SystemExit('too shallow')")


@pytest.mark.process
def test_a_session_that_ends_before_it_serves_says_why() -> None:
    with (
        pytest.raises(ConfigError, match=r'the session of the bench failed: .*no vessel "bb3"'),
        delays.serving("pages at", "--vessel", "bb3"),
    ):
        pass


def test_starts_are_told_beside_numba_s() -> None:
    page = delays.start_lines(StartTimes({"import numba": 0.3, "trainer --help": 0.15}))

    assert page[-1].split() == ["trainer", "--help", "150", "ms", "0.50", "times", "numba"]


# The parts, each by its option


@dataclass(frozen=True)
class Figure:
    """What a part found."""

    name: str


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every part be measured at once."""
    for module, name, lines in (
        (ticks, "time_duty", "lines"),
        (delays, "time_page", "order_lines"),
        (delays, "time_starts", "start_lines"),
    ):
        monkeypatch.setattr(module, name, lambda *_, name=name: Figure(name))
        monkeypatch.setattr(module, lines, lambda figure: [f"PART {figure.name}"])


def said(*words: str) -> str:
    """Return what the command prints."""
    result = CliRunner().invoke(main.cli, ["bench", *words])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("option", "name"), [("latency", "time_page"), ("starting", "time_starts")]
)
def test_every_part_has_an_option_and_is_printed_by_itself(option: str, name: str) -> None:
    assert said(f"--{option}") == f"PART {name}\n"
    assert json.loads(said(f"--{option}", "--json")) == {option: {"name": name}}


@pytest.mark.usefixtures("quick")
def test_all_is_the_standard_figures_and_every_part() -> None:
    assert json.loads(said("--all", "--json")).keys() == {"standard", "latency", "starting"}
    assert said("--all") == "PART time_duty\n\nPART time_page\n\nPART time_starts\n"


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("option", ["--latency", "--all"])
def test_what_a_page_needs_is_asked_for_before_anything_is_measured(
    option: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.config.extras.find_spec", lambda _: None)
    result = CliRunner().invoke(main.cli, ["bench", option])

    assert isinstance(result.exception, ConfigError)
    assert "needs websockets: pip install 'submarine-trainer[web]'" in str(result.exception)
    assert "PART" not in result.output
