"""Logs that a crowd cannot flood."""

import pytest

from trainer.io.noise_log import (
    ENTRY_PERIOD_S,
    ENTRY_RETURN_S,
    MAX_ENTRIES,
    MAX_SUM_PAUSE_S,
    CrowdLog,
)

WRONG = "stranger: wrong token"


class Crowd:
    """A crowd's log, what it has passed on, and a clock of its own."""

    def __init__(self) -> None:
        self.now = 0.0
        self.passed: list[tuple[str, str]] = []
        self.log = CrowdLog(lambda *entry: self.passed.append(entry), lambda: self.now)

    def make_noise(self, seconds: float, a_second: int, kind: str = "refused") -> None:
        """Say so many things a second, and let the sums be told when they are due."""
        for i in range(round(seconds * a_second)):
            words = f"{WRONG} {i}"
            self.log.log(kind, words)
            self.now += 1.0 / a_second
            self.log.settle()


@pytest.fixture
def crowd() -> Crowd:
    return Crowd()


def test_a_crowd_writes_twenty_entries_and_then_their_number(crowd: Crowd) -> None:
    crowd.make_noise(4.5, 120)
    assert len(crowd.passed) == MAX_ENTRIES

    crowd.now += ENTRY_PERIOD_S
    crowd.log.settle()

    assert crowd.passed[MAX_ENTRIES:] == [
        ("refused", "520 more of the same, not written one by one")
    ]
    assert crowd.log.wait == float("inf")


def test_each_kind_is_summed_up_by_itself(crowd: Crowd) -> None:
    crowd.make_noise(1.0, 50, "station")
    crowd.make_noise(1.0, 30, "refused")

    crowd.log.close()

    sums = [(kind, text.partition(" ")[0]) for kind, text in crowd.passed if "more of" in text]
    assert sums == [("station", "30"), ("refused", "10")]
    assert sum(kind == "refused" for kind, _ in crowd.passed) == MAX_ENTRIES + 1


def test_hours_of_noise_do_not_push_all_else_out_of_a_log_of_500(crowd: Crowd) -> None:
    hours = 3.0
    crowd.make_noise(hours * 3600.0, 2)

    assert (
        len(crowd.passed)
        < MAX_ENTRIES + hours * 3600.0 * (1 / ENTRY_RETURN_S + 1 / MAX_SUM_PAUSE_S) + 8
    )
    assert len(crowd.passed) < 250


def test_after_a_rest_entries_are_written_again_and_sums_come_soon(crowd: Crowd) -> None:
    crowd.make_noise(3600.0, 2)
    crowd.log.close()
    crowd.passed.clear()
    crowd.now += 2.0 * MAX_SUM_PAUSE_S + MAX_ENTRIES * ENTRY_RETURN_S

    crowd.make_noise(1.0, 40)

    assert [text for _, text in crowd.passed] == [f"{WRONG} {i}" for i in range(MAX_ENTRIES)]
    assert crowd.log.wait <= ENTRY_PERIOD_S


def test_it_is_known_when_the_next_sum_is_due(crowd: Crowd) -> None:
    assert crowd.log.wait == float("inf")
    for i in range(MAX_ENTRIES + 3):
        crowd.log.log("refused", str(i))
    assert crowd.log.wait == ENTRY_PERIOD_S
    crowd.now += 4.0
    assert crowd.log.wait == ENTRY_PERIOD_S - 4.0
