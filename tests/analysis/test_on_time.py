"""The bench's sections on time: that they measure the product, and what they make of it."""

import itertools
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from trainer.analysis.bench import end_to_end, on_time, start_up
from trainer.analysis.bench.end_to_end import TRAINER_COMMAND, TerminalLine
from trainer.analysis.bench.metronome import run_idle_loop
from trainer.analysis.bench.on_time import CrowdLateness, account_entry, count_missed, sail_in_crowd
from trainer.cli import main
from trainer.config.boat.vessel import load_vessel
from trainer.session.time.ledger import SECOND_NS, Spread

pytestmark = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")

SOAK = float(os.environ.get("TRAINER_SOAK", "8"))  # [s]
SPREAD = Spread(1000, 2000, 3000, 4000)
ACCOUNT = """BB2
on time     overruns 2, caught up 9, slipped 3, gaps 1 (4.0 s)
the clock   priority real-time, memory locked, timer slack 1 ns
"""


def test_a_loop_of_the_clock_begins_every_tick_and_none_before_its_time() -> None:
    summary = run_idle_loop(0.2, 0.01)

    assert summary.ticks == 20
    assert summary.lateness.p50_ns > 0


@pytest.mark.alone
@pytest.mark.process
def test_a_loop_in_a_process_of_its_own_says_what_it_was_granted() -> None:
    found = on_time.measure_loop(0.1, "busy")

    assert found.granted.startswith("priority normal, memory not locked")
    assert 0 < found.lateness.p50_ns <= found.lateness.p99_ns <= found.lateness.max_ns


def test_missed_deadlines_are_overruns_slipped_ticks_and_gaps() -> None:
    assert count_missed(account_entry(ACCOUNT, "on time")) == 6
    assert account_entry(ACCOUNT, "the clock").startswith("priority real-time")
    assert account_entry(ACCOUNT, "weather") == ""


@pytest.mark.long
@pytest.mark.process
@pytest.mark.slow
def test_no_deadline_is_missed_among_busy_processes_a_console_and_a_hung_line() -> None:
    crowd = sail_in_crowd(load_vessel("bb2"), SOAK)

    assert crowd.ticks == round(SOAK / 0.5)
    assert crowd.missed == 0
    assert "a console" in crowd.among
    assert "memory" in crowd.granted


def test_the_page_on_time_names_every_loop() -> None:
    loop = on_time.LoopLateness("priority real-time, memory locked", SPREAD)
    crowd = CrowdLateness(("2 busy processes", "a console"), "priority normal", 0.5, 30, 0, SPREAD)
    figures = on_time.TickPunctuality(5.0, 2, loop, loop, loop, loop, crowd)

    page = "\n".join(on_time.lines(figures))

    for words in ("alone", "busy thread", "priority real-time", "0 deadlines missed"):
        assert words in page


# From helm to instrument


class Helm(TerminalLine):
    """A line that keeps what is said on it."""

    def __init__(self) -> None:
        super().__init__(-1, "")
        self.words: list[str] = []

    def say(self, words: str) -> None:
        self.words.append(words)


def test_an_order_is_timed_until_the_rudder_moves_as_ordered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # at rest; left: not yet, then it moves; right: still on its way left, then back
    shown = [0.0, None, 0.0, 0.0, -1.0, None, -2.0, -2.5, -1.5, 7.0]
    readings = iter(shown)
    monkeypatch.setattr(end_to_end, "next_rudder_angle", lambda *_: next(readings))
    helm = Helm()
    steered = end_to_end.time_rudder_orders(helm, Helm(), 0.01, 2)

    assert next(steered) > 0
    assert helm.words == ["rudder left full"]
    assert next(steered) > 0
    assert helm.words == ["rudder left full", "rudder right full"]
    assert list(readings) == [7.0]


def test_a_session_that_begins_late_is_waited_for_and_a_rudder_that_stands_still_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    waits: list[float] = []

    def wait(_: TerminalLine, until: float) -> float | None:
        waits.append(until - time.monotonic())
        return 0.0 if len(waits) == 1 else None

    monkeypatch.setattr(end_to_end, "next_rudder_angle", wait)

    assert list(end_to_end.time_rudder_orders(Helm(), Helm(), 0.01, 1)) == []
    begins, _, answers = waits
    assert begins > 10.0 * answers


@pytest.mark.parametrize("orders", [10, 12, 40])
def test_orders_come_at_instants_spread_evenly_over_a_tick(orders: int) -> None:
    phases = sorted(end_to_end.phase(number) for number in range(orders))

    gaps = [after - before for before, after in itertools.pairwise([*phases, 1.0 + phases[0]])]
    assert max(gaps) < 2.0 / orders
    assert phases[orders // 2] == pytest.approx(0.5, abs=1.0 / orders)


def test_times_fall_into_bins_of_a_tenth_of_a_step() -> None:
    figures = end_to_end.summarise(
        [int(0.04 * SECOND_NS), int(0.06 * SECOND_NS), int(0.21 * SECOND_NS)], 0.5
    )

    assert figures.histogram == (1, 1, 0, 0, 1)
    assert figures.latency.p50_ns == int(0.06 * SECOND_NS)
    assert figures.bin_ms == pytest.approx(50.0)
    assert figures.allowed_median_ms == pytest.approx(270.0)
    page = end_to_end.lines(figures)
    assert page[3].endswith("0 ms    1 " + "#" * end_to_end.MAX_BAR_LENGTH)
    assert page[5].endswith("100 ms    0")


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
@pytest.mark.long
def test_the_bench_steers_a_session_by_serial_lines() -> None:
    done = CliRunner().invoke(main.cli, ["bench", "--latency", "--seconds", "3", "--json"])

    assert done.exit_code == 0, done.output
    figures = json.loads(done.stdout)["latency"]
    assert figures["orders"] == sum(figures["histogram"]) >= 1
    assert figures["step_s"] == 0.5


# Starting


@pytest.mark.process
def test_where_nothing_is_compiled_a_run_compiles_nothing_and_leaves_nothing_behind() -> None:
    with start_up.empty_cache() as environment:
        done = subprocess.run(
            [*TRAINER_COMMAND, *start_up.RUN_WORDS, "--verbose"],
            env=os.environ | environment,
            capture_output=True,
            text=True,
            check=True,
        )
        assert not list(Path(environment["NUMBA_CACHE_DIR"]).iterdir())

    assert "interpreted" not in done.stdout


@pytest.mark.alone
@pytest.mark.clock
@pytest.mark.process
def test_the_console_is_timed_until_it_shows_figures() -> None:
    assert 0.0 < start_up.time_to_screen() < float("inf")


@pytest.mark.process
def test_a_process_that_fails_is_not_timed() -> None:
    with pytest.raises(subprocess.CalledProcessError):
        start_up.time_to_end(sys.executable, "-c", "raise SystemExit(1)")
