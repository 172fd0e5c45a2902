"""How late ticks begin: that loops and the crowd are timed, and what the page makes of them."""

import os

import pytest

from bench import on_time
from bench.metronome import run_idle_loop
from bench.on_time import CrowdLateness, count_missed, sail_in_crowd
from trainer.analysis.bench.ticks import PacedTicks
from trainer.config.boat.vessel import load_vessel
from trainer.session.time.ledger import Spread

pytestmark = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals here")

SOAK = float(os.environ.get("TRAINER_SOAK", "8"))  # [s]
SPREAD = Spread(1000, 2000, 3000, 4000)


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
    counts = {"overruns": 2, "caught up": 9, "slipped": 3, "gaps": 1}

    assert count_missed(PacedTicks(30, 0.1, SPREAD, SPREAD, counts, "")) == 6


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
