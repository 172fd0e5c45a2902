"""Orders of tests, which are to be orders."""

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Order, Refused, parse


def read_order(words: str) -> Order:
    """Return the order that words are."""
    order = parse(words)
    assert isinstance(order, Order), f"{words}: {order}"
    return order


def obey_all(boat: Boat, *lines: str) -> list[str]:
    """Return what a boat answers to orders, all of which it obeys."""
    answers = [obey_order(boat, read_order(line)) for line in lines]
    assert all(isinstance(answer, str) for answer in answers), answers
    return [str(answer) for answer in answers]


def answer_of(boat: Boat, words: str) -> str:
    """Return a boat's answer to an order, or why it refuses."""
    reply = obey_order(boat, read_order(words))
    return reply.reason if isinstance(reply, Refused) else reply
