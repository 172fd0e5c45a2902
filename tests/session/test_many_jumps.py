"""Many jumps and orders: memory grows by little, and every answer comes soon."""

import gc
import time
import tracemalloc
from random import Random

import pytest
from helpers.crewed import Begin

GROWTH_BYTES = 20_000_000  # [bytes] that 541 jumps and 30,800 orders may add to their first quarter
ORDERS = 30_800
ANSWER_S = 1.0  # [s] in which an answer comes
WORDS = ("rudder left {}", "stern planes rise {}", "tell course {}", "in {} s rpm 60", "mark {}")


@pytest.mark.long
@pytest.mark.parametrize(
    ("jumps", "orders"),
    [(40, 10), pytest.param(541, 57, marks=pytest.mark.slow)],
    ids=["some minutes", "three quarters of an hour"],
)
def test_many_jumps_and_orders_add_little_and_no_answer_is_late(
    crewed: Begin, monkeypatch: pytest.MonkeyPatch, jumps: int, orders: int
) -> None:
    monkeypatch.setattr("trainer.session.stations.station.ORDERS_A_SECOND", 1e6)
    dice = Random(65)  # noqa: S311  choices, not secrets
    ship = crewed(seconds=None)
    waits: list[float] = []
    held: list[int] = []

    def order(words: str) -> None:
        begun = time.process_time()
        ship.say(ship.instructor, words)
        waits.append(time.process_time() - begun)
        ship.instructor.sent.clear()

    tracemalloc.start()
    try:
        for jump in range(jumps):
            for _ in range(orders):
                order(dice.choice(WORDS).format(dice.randrange(1, 30)))
            ship.fly(10)
            kept = f"moment-{dice.randrange(10)}"
            order(f"snapshot {kept}")
            order(dice.choice((f"restore {kept}", "backtrack 20 s", f"return {max(jump, 1)}")))
            order("branches")
            if jump in (jumps // 4, jumps - 1):
                gc.collect()
                held.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert ship.recording.last_order() > jumps * orders / 2  # a mark is an event
    assert held[1] - held[0] < GROWTH_BYTES * max(jumps * orders / ORDERS, 0.05)
    assert max(waits) < ANSWER_S
