"""The tick of a boat: the tick of its records."""

import pytest
from helpers.boats import make_boat, start_boat

from trainer.core.update import update

pytestmark = pytest.mark.core


def test_a_boat_s_tick_is_the_tick_of_its_records() -> None:
    bound, called = make_boat(), make_boat()
    for boat in (bound, called):
        boat.start(5.0, 60.0, 0.0)
        boat.state.ordered_depth = 80.0

    for _ in range(20):
        assert bound.tick() == update(*called.records) == 0

    assert bound.ticks == 20
    assert bound.records.state.tobytes() == called.records.state.tobytes()


@pytest.mark.parametrize(("seconds", "ticks"), [(0.0, 0), (1.1, 11), (1.11, 12), (3 * 0.1, 3)])
def test_a_time_on_a_tick_is_that_tick(seconds: float, ticks: int) -> None:
    assert make_boat(step=0.1).ticks_in(seconds) == ticks


def test_the_tick_is_compiled_by_the_first_boat_that_takes_one() -> None:
    boat = start_boat(5.0)

    assert "advance" not in vars(boat)  # until then nobody has been told that it takes its time

    boat.tick()

    assert "advance" in vars(boat)


def test_plain_numbers_are_the_state() -> None:
    boat = start_boat(5.0)
    boat.tick()

    assert boat.numbers(("z", "t", "u")) == [boat.state.z, 0.5, boat.state.u]
    assert boat.numbers(("z",)) == [boat.state.z]
    assert list(boat.plain) == boat.records.state["whole"][0].tolist()
