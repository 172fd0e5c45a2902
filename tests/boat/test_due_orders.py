"""A boat flown by orders that are given when they are due, without a session."""

import numpy as np
from helpers.boats import make_boat, start_bb2

from trainer.boat.boat import Boat
from trainer.boat.due_orders import entries_due, fly_ticks, obey_all, orders_due
from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Order
from trainer.io.orders.schedule import BadSchedule, ScheduledOrder, parse_schedule


def schedule_of(*lines: str) -> list[ScheduledOrder]:
    """Return a schedule of lines such as ``5 rudder right 10``."""
    schedule = parse_schedule("\n".join(lines), "orders.txt")
    assert not isinstance(schedule, BadSchedule), schedule
    return schedule


def ordered(boat: Boat) -> tuple[float, float]:
    """Return the angles ordered of rudder and stern planes [rad]."""
    return float(boat.state.ordered_r), float(boat.state.ordered_s)


def test_an_order_is_due_in_the_first_tick_that_is_not_before_its_time() -> None:
    boat = make_boat(step=0.1)
    schedule = schedule_of(
        "0 depth 80", "30 rudder right 10", "30.05 rudder left 5", "40 course 90"
    )
    assert entries_due(boat, schedule) == {0: [0], 300: [1], 301: [2], 400: [3]}


def test_an_order_is_not_due_before_those_ahead_of_it() -> None:
    late, early = (schedule_of(line)[0] for line in ("20 depth 80", "10 course 90"))
    due = orders_due(make_boat(), [late, early])
    assert {tick: [each.text for each in orders] for tick, orders in due.items()} == {
        40: ["depth 80 m", "course 090"]
    }


def test_orders_act_in_the_tick_in_which_they_are_due_and_are_seen_obeyed() -> None:
    flown, by_hand = start_bb2(), start_bb2()
    schedule = schedule_of("2 rudder right 10", "3 stern dive 4")
    seen: list[tuple[int, list[str], tuple[float, float]]] = []

    def look(now: object) -> None:
        assert isinstance(now, list | tuple)
        if now:
            seen.append((flown.ticks, [each.text for each in now], ordered(flown)))

    ticks = [*fly_ticks(flown, 20, orders_due(flown, schedule), look)]
    wanted = []
    for tick in range(20):
        for entry in schedule:
            if entry.seconds == tick * 0.5:
                obey_order(by_hand, entry.order)
                wanted.append((tick, [entry.order.text], ordered(by_hand)))
        assert by_hand.tick() == 0

    assert ticks == [*range(1, 21)]
    assert seen == wanted
    assert np.array_equal(flown.plain, by_hand.plain)


def test_who_is_told_something_moves_nothing_and_a_refusal_is_told() -> None:
    boat = start_bb2()
    before = boat.snapshot()
    orders = [entry.order for entry in schedule_of("1 tell hold her so", "1 rudder right 10")]
    assert obey_all(boat, orders[:1]) == []
    assert boat.snapshot() == before
    ((text, why),) = obey_all(make_boat("remus100"), [*orders, *bow_orders()])
    assert text == "bow planes rise 5"
    assert "bow" in why


def bow_orders() -> list[Order]:
    """Return an order that a boat without bow planes refuses."""
    return [schedule_of("1 bow rise 5")[0].order]


def test_a_flight_ends_where_the_boat_is_lost() -> None:
    boat = start_bb2()

    def lose(_: object) -> None:
        if boat.ticks == 5:
            boat.state.u = 1e9

    assert [*fly_ticks(boat, 20, {}, lose)] == [1, 2, 3, 4, 5]
    assert boat.ticks == 5
