"""The orders to the crew that wait at a console, as the session tells them."""

from trainer.console.crew import CrewOrders


def test_an_order_that_is_sent_again_stays_behind_a_newer_one() -> None:
    orders = CrewOrders()
    orders.give(0.0, "course 090")
    orders.give(10.0, "depth 100 m")
    orders.give(20.0, "course 090")  # nobody has repeated it

    oldest, newest = orders.oldest, orders.to_repeat("pilot")
    assert oldest is not None
    assert (oldest.says, oldest.seconds) == ("course 090", 0.0)
    assert newest is not None
    assert newest.says == "depth 100 m"


def test_an_order_in_place_of_another_is_the_newest() -> None:
    orders = CrewOrders()
    for seconds, order in enumerate(("course 090", "depth 100 m", "course 180")):
        orders.give(float(seconds), order)

    newest = orders.to_repeat("pilot")
    assert newest is not None
    assert (newest.says, newest.seconds) == ("course 180", 2.0)
