"""What users wait for is counted whole, and what cannot be measured is told."""

import time

import pytest

from bench import waits
from trainer.config.files import ConfigError


@pytest.mark.process
def test_the_processor_time_of_a_command_is_its_own_and_not_what_others_wait() -> None:
    began = time.perf_counter()
    took = waits.processor_s((("--version",), ("exercises",)))

    assert 0.05 < took < 60.0
    assert took < 3.0 * (time.perf_counter() - began) + 0.1


@pytest.mark.process
def test_a_command_that_is_wrong_is_told_in_its_words() -> None:
    with pytest.raises(ConfigError, match='no vessel "bb3"'):
        waits.processor_s((("boat", "check", "bb3"),))


def test_each_command_runs_once_before_it_counts() -> None:
    calls: list[waits.Commands] = []

    def measure(words: waits.Commands) -> float:
        calls.append(words)
        return float(len(calls))

    timed = dict(waits.time_each({"one": (("a",),), "two": (("b",),)}, measure))

    assert timed == {"one": 2.0, "two": 4.0}


def test_the_dearest_exercise_stands_first_beside_its_goal() -> None:
    page = waits.lines(waits.Waits({"a start": 0.5}, {"calm": 0.25, "jam": 7.0, "dive": 1.0}))

    assert page[2].split() == ["a", "start", "0.50"]
    assert page[3].split()[-2:] == ["1.00", "(1)"]
    assert [line.split() for line in page[4:]] == [
        ["jam", "7.00", "(5)"],
        ["dive", "1.00"],
        ["calm", "0.25"],
    ]
