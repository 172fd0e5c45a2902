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
