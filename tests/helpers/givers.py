"""Journals of tests, which say in words who gives an order and what is answered."""

from trainer.io.recording.facts import Giver
from trainer.io.recording.format_1 import crew_fact_of, giver_of
from trainer.io.recording.queries import RecordedOrder

HELM = giver_of("helm")


def giver_at(who: str) -> Giver:
    """Return who gives an order: ``ROLE at LINE``, a role alone, ``schedule``."""
    return giver_of(who)


def journalled(
    number: int, tick: int, who: str, text: str, answer: str = "", *, accepted: bool = True
) -> RecordedOrder:
    """Return an order of branch 1 as its words have it."""
    crew = crew_fact_of(text, answer, accepted=accepted)
    return RecordedOrder(number, 1, tick, giver_of(who), text, None, accepted, answer, crew)
