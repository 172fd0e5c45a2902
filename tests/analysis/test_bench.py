"""The benchmark's figures: their structure and consistency, never the machine's speed."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from trainer.analysis.bench import bench as bench_module
from trainer.analysis.bench.bench import (
    BenchFigures,
    bench_boat,
    cpu_model,
    render,
    run_paced,
    samples_up,
)
from trainer.analysis.bench.sections import SECTIONS, Section
from trainer.analysis.bench.session_tick import effect
from trainer.analysis.bench.tick import (
    BATCH_COUNT,
    BATCH_NS,
    CASUALTY_KINDS,
    STANDARD_METHOD,
    BatchCost,
    Voyage,
    in_a_loop,
    long_enough,
    ready_boat,
    time_batches,
)
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.casualties import insert_casualty
from trainer.cli import main
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.io.recording.recording import Recording
from trainer.session.time.ledger import Spread

SHORT_BATCH_NS = 1_000_000


@pytest.fixture(scope="module")
def figures() -> BenchFigures:
    """Return what one second at each step gives, by batches of a millisecond."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("trainer.analysis.bench.tick.BATCH_NS", SHORT_BATCH_NS)
        return bench_boat(load_vessel("bb2"), 1)


@pytest.mark.process
def test_duty_cycle_is_work_over_step_and_is_compared_with_1969(figures: BenchFigures) -> None:
    half, whole = figures.real_time

    assert (half.step_s, half.ticks, half.duty_cycle_1969_percent) == (0.5, 2, 38.0)
    assert (whole.step_s, whole.ticks, whole.duty_cycle_1969_percent) == (1.0, 1, 19.0)
    # a single tick: its duty cycle is its work
    assert whole.duty_cycle_percent == pytest.approx(100.0 * whole.work.max_ns / 1e9)
    assert whole.times_less_than_1969 == pytest.approx(19.0 / whole.duty_cycle_percent)
    # waiting counted as work would make it nearly all of the time
    assert 0.0 < half.duty_cycle_percent < 50.0
    assert 0.0 < half.unrecorded_percent < 50.0
    for run in figures.real_time:
        assert run.work.p50_ns > 0
        for spread in (run.work, run.lateness):
            assert 0 <= spread.p50_ns <= spread.p99_ns <= spread.p999_ns <= spread.max_ns


def test_half_of_the_ticks_are_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[Recording] = []
    create = bench_module.temporary  # type: ignore[attr-defined]

    def temporary(boat: Boat) -> Recording:
        begun.append(create(boat))
        return begun[-1]

    monkeypatch.setattr(bench_module, "temporary", temporary)
    boat = ready_boat(load_vessel("bb2"), STANDARD_METHOD, 0.5)
    ticks: list[int] = []

    run_paced(boat, 1, ticks.append)

    assert len(begun) == 1
    assert ticks == [1, 2, 3, 4]


def test_a_percentile_tells_how_many_ticks_it_rests_on() -> None:
    # of 20, the 20th is the 99 % one; of 1000, the 990th, with ten above it; the 999th, with one
    assert samples_up(20, 990) == 1
    assert samples_up(1000, 990) == 11
    assert samples_up(1000, 999) == 2
    assert samples_up(2000, 999) == 3


@pytest.mark.process
def test_batches_are_many_long_and_their_least_is_not_above_the_median(
    figures: BenchFigures,
) -> None:
    tick = figures.attended
    batches = [tick.boat, tick.bare, tick.csv_row, tick.recorded, tick.subscribed]
    batches += [b for update in figures.updates for b in (update.called, update.in_kernel)]

    for batch in batches:
        assert batch.batches >= 9
        assert 0.0 < batch.least_ns <= batch.median_ns
        # long enough when calibrated; a machine that was ten times busier then is beyond belief
        assert batch.median_ns * batch.repetitions > SHORT_BATCH_NS / 10


def test_a_batch_cost_is_per_repetition(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0]
    monkeypatch.setattr("time.perf_counter_ns", lambda: clock[0])
    calls: list[int] = []

    def work(count: int) -> None:
        compiling = 0 if calls else 10**9
        calls.append(count)
        clock[0] += 1000 * count + compiling

    # 2^14: the first power of two that takes 10 ms at 1 us each
    assert time_batches([work]) == [BatchCost(1000.0, 1000.0, BATCH_COUNT, 2**14)]
    assert calls[-BATCH_COUNT:] == [2**14] * BATCH_COUNT


def boat_under_way(fill: Callable[[Boat], object]) -> Boat:
    """Return BB2 with its own battery, after something was done to it."""
    boat = Boat(load_vessel("bb2"), Method("modified", "lagged", "exact", "adams2", 0.5))
    boat.start(5.0, 60.0, 0.0)
    fill(boat)
    return boat


def test_each_batch_begins_from_the_boat_put_back() -> None:
    boat, begun = boat_under_way(lambda _: None), []

    def take(count: int) -> None:
        begun.append(boat.snapshot().tobytes())
        in_a_loop(boat.records, count)

    time_batches([Voyage.of(boat, take)])

    assert len(begun) > BATCH_COUNT
    assert len({*begun}) == 1


@pytest.mark.parametrize(
    ("fill", "told"),
    [
        (lambda boat: boat.state.__setitem__("battery_spent", 1e12), "the battery went flat"),
        (lambda boat: boat.state.__setitem__("z", 5664.0), "collapse at 5664 m"),
        (lambda boat: insert_casualty(boat, "bus-dc-lost"), "dc without power"),
        (lambda boat: boat.state.__setitem__("u", 2e3), "it has done 0 of"),
    ],
)
def test_a_boat_that_is_lost_frozen_or_without_power_has_no_figure(
    fill: Callable[[Boat], object], told: str
) -> None:
    boat = boat_under_way(fill)

    with pytest.raises(ConfigError, match=f"bb2.toml has no figure in a benchmark: .*{told}"):
        time_batches([Voyage.of(boat, partial(in_a_loop, boat.records))])


def test_an_interruption_does_not_make_batches_short(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0]
    monkeypatch.setattr("time.perf_counter_ns", lambda: clock[0])
    calls: list[int] = []

    def work(count: int) -> None:
        calls.append(count)
        clock[0] += 1000 * count + (0 if len(calls) % 3 else BATCH_NS)

    assert long_enough(work) == 2**14


@pytest.mark.process
def test_three_ways_to_compute_are_timed_and_the_crossing_is_their_difference(
    figures: BenchFigures,
) -> None:
    ways = [(u.equations, u.rates, u.integrator) for u in figures.updates]

    assert ways == [
        ("modified", "lagged", "adams2"),
        ("full", "exact", "adams2"),
        ("full", "exact", "rk4"),
    ]
    for update in figures.updates:
        assert update.crossing_ns == update.called.least_ns - update.in_kernel.least_ns


@pytest.mark.process
def test_sizes_are_in_bytes_and_words_and_the_state_is_under_4_kib(figures: BenchFigures) -> None:
    assert {"state", "vessel", "compact", "scheme"} <= figures.sizes.keys()
    for size in figures.sizes.values():
        assert size.bytes == 2 * size.words_of_16_bits > 0
    assert figures.sizes["state"].bytes < 4096
    assert figures.memory_1969_words_of_16_bits == 8192


def test_a_boat_that_loses_its_numbers_is_refused(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    boat.start(5.0, 60.0, 0.0)
    boat.state.q = np.inf

    with pytest.raises(ConfigError, match=r"bb2\.toml has no place .* out of all bounds"):
        run_paced(boat, 1, lambda _: None)


@pytest.mark.process
def test_the_processor_is_named_as_the_kernel_lists_it(tmp_path: Path) -> None:
    listing = tmp_path / "cpuinfo"
    listing.write_text("processor\t: 0\nmodel name\t: A Chip @ 2 GHz\nprocessor\t: 1\n")

    assert cpu_model(listing) == "A Chip @ 2 GHz"
    assert cpu_model(tmp_path / "none")


@pytest.mark.process
def test_the_page_is_ascii_in_79_columns(figures: BenchFigures) -> None:
    page = render(figures)
    assert "load of the machine in the minute before: " in page

    assert page.isascii()
    assert max(map(len, page.splitlines())) <= 79
    for words in ("1969: 38 %", "1969: 19 %", "99 % rests on the longest one", "8192 words"):
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
    figures: BenchFigures, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def measured(file: Any, seconds: int) -> BenchFigures:
        asked.append((file.path.name, seconds))
        return figures

    monkeypatch.setattr(bench_module, "bench_boat", measured)
    result = CliRunner().invoke(main.cli, ["bench", "--seconds", "1", "--json"])

    assert result.exit_code == 0, result.output
    assert asked == [("bb2.toml", 1)]
    tree = json.loads(result.stdout)
    assert tree == json.loads(json.dumps(asdict(figures)))
    bare = {
        n
        for n in units(tree)
        if not n.endswith(
            ("_s", "_ns", "_percent", "_than_1969", "_the_calm", "_the_bare", "_processes")
        )
    }
    assert not bare
    assert set(asdict(Spread(1, 2, 3, 4))) == set(tree["real_time"][0]["work"])


@pytest.mark.process
def test_the_command_prints_the_page(
    figures: BenchFigures, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bench_module, "bench_boat", lambda *_: figures)

    result = CliRunner().invoke(main.cli, ["bench", "--seconds", "1"])

    assert result.output == render(figures) + "\n"


@pytest.mark.process
def test_the_troubled_tick_has_six_casualties_and_a_ratio_to_the_calm_one(
    figures: BenchFigures,
) -> None:
    troubled = figures.troubled

    assert len(CASUALTY_KINDS) == 6
    assert troubled.times_the_calm == troubled.troubled.least_ns / troubled.calm.least_ns
    assert "tanks at work and six casualties" in render(figures)


@pytest.mark.process
def test_orders_over_tcp_are_answered_and_act_within_a_tick(figures: BenchFigures) -> None:
    latency = figures.latency

    assert latency.orders > 1
    assert latency.tick_s == 0.05
    assert 0 < latency.reply.p50_ns <= latency.reply.p99_ns <= latency.reply.max_ns
    assert latency.ticks_to_effect_most == 1
    assert f"{latency.orders} orders; from order to effect: 1 tick at most" in render(figures)


def test_an_order_that_acts_late_is_seen_to(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat()
    boat.start(5.0, 60.0, 0.0)
    boat.state.rudder_by_hand, boat.state.ordered_r = 1.0, -0.2
    states = [boat.snapshot()[0]]
    for ordered in (-0.2, -0.2, 0.2, 0.2):  # the rudder is on its way at first
        boat.state.ordered_r = ordered
        boat.tick()
        states.append(boat.snapshot()[0])

    assert [effect(states[given:]) for given in (0, 1, 2)] == [3, 2, 1]


@pytest.mark.process
def test_a_boat_without_a_rudder_has_no_effect_to_tell(figures: BenchFigures) -> None:
    steered = replace(figures.latency, ticks_to_effect_most=0)

    assert "none: this boat has no rudder" in render(replace(figures, latency=steered))


# The parts, each by its option


@dataclass(frozen=True)
class Figure:
    """What a part found."""

    name: str


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every part be measured at once."""
    for name in SECTIONS:
        part = Section(lambda _, name=name: Figure(name), lambda f: ["", f"PART {f.name}"])  # type: ignore[misc]
        monkeypatch.setitem(SECTIONS, name, part)
    monkeypatch.setattr(bench_module, "bench_boat", lambda *_: Figure("whole"))
    monkeypatch.setattr(bench_module, "render", lambda _: "STANDARD")


def said(*words: str) -> str:
    """Return what the command prints."""
    result = CliRunner().invoke(main.cli, ["bench", *words])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.usefixtures("quick")
def test_every_part_has_an_option_and_is_printed_by_itself() -> None:
    for name in SECTIONS:
        option = f"--{name.replace('_', '-')}"
        assert said(option) == f"PART {name}\n"
        assert json.loads(said(option, "--json")) == {name: {"name": name}}


@pytest.mark.usefixtures("quick")
def test_all_is_the_standard_figures_and_every_part() -> None:
    tree = json.loads(said("--all", "--json"))

    assert tree.keys() == {"standard", *SECTIONS}
    assert said("--all").startswith("STANDARD\n\nPART ")
    assert said("--all").count("PART ") == len(SECTIONS)
