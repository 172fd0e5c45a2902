"""A few of every fault lose nothing, and what would be wrong is seen."""

import dataclasses
import os
import random

import pytest
from helpers.lanes import sample_cases

from faults import faults, recordings
from faults.rig import Bench, Tried

pytestmark = pytest.mark.process

posix = pytest.mark.skipif(os.name != "posix", reason="signals and forks of POSIX")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return Bench(tmp_path_factory.mktemp("f"), random.Random(1969))  # noqa: S311  instants


@posix
@pytest.mark.long
@pytest.mark.parametrize(
    ("fault", "times"),
    [
        (faults.kill_sessions, 3),  # type: ignore[attr-defined]
        (faults.damage_last_page, 10),  # type: ignore[attr-defined]
        pytest.param(faults.stop_session, 2, marks=pytest.mark.slow),  # type: ignore[attr-defined]
        pytest.param(faults.unplug, 2, marks=pytest.mark.slow),
        (faults.full, 1),  # type: ignore[attr-defined]
        pytest.param(faults.full_disk, 1, marks=pytest.mark.slow),  # type: ignore[attr-defined]
        pytest.param(faults.lock_recording, 1, marks=pytest.mark.slow),  # type: ignore[attr-defined]
        pytest.param(faults.relieve_disk, 1, marks=pytest.mark.slow),  # type: ignore[attr-defined]
        pytest.param(faults.take_disk_away, 1, marks=pytest.mark.slow),  # type: ignore[attr-defined]
        pytest.param(faults.clock_set, 2, marks=pytest.mark.slow),  # type: ignore[attr-defined]
        pytest.param(faults.console_killed, 1, marks=pytest.mark.slow),  # type: ignore[attr-defined]
    ],
)
def test_a_fault_loses_nothing_that_is_journalled(
    bench: Bench, fault: faults.Fault, times: int
) -> None:
    tried = fault(bench, times)
    assert not tried.wrong, tried
    assert tried.times == times or "not tried" in str(tried.seen)


DAMAGED = 3  # recordings of each way; `python -m tests.faults --damaged 2000` opens more


@pytest.fixture(scope="module")
def good_recording(bench: Bench) -> bytes:
    return recordings.make_recording(bench)


@posix
@pytest.mark.slow
@pytest.mark.parametrize(
    "way",
    sample_cases(recordings.DAMAGES, recordings.pages_changed, recordings.texts_changed),
    ids=lambda way: way.__name__,
)
def test_a_damaged_recording_is_told_in_a_line_or_read_as_it_is(
    bench: Bench, good_recording: bytes, way: recordings.Damage
) -> None:
    own = dataclasses.replace(bench, dice=random.Random(1969))  # noqa: S311  the same every time
    tried = recordings.open_damaged(own, good_recording, way, DAMAGED)
    assert not tried.wrong, tried
    assert sum(tried.seen.values()) == DAMAGED * len(recordings.COMMANDS)


@posix
@pytest.mark.long
def test_a_command_that_ends_with_a_traceback_or_without_end_is_seen(bench: Bench) -> None:
    tried = Tried("recording", "told in a line")
    recordings.judge(bench, tried, ("list", "--no-such"))
    assert tried.wrong == []
    assert tried.seen == {"told as damaged": 1}
    endless = ("--duration", "90000h", "--vessel", "remus100")  # which has no battery that ends
    loop = ("run", "--headless", "--speed", "max", *endless)
    recordings.judge(bench, tried, loop, seconds=1)
    assert "run ended with -24" in tried.wrong[0]
