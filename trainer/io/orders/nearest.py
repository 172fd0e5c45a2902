"""The nearest of the known words to one that is wrong, mistyped or a beginner's."""

import difflib
from collections.abc import Iterable

from trainer.io.orders.table import (
    FORMS,
    GOING_WORDS,
    MEANT_ORDERS,
    WORD_SETS,
    heading_word,
    spellings,
)
from trainer.io.orders.words import BOAT_TOPICS, SESSION_TOPICS

ORDER_TOPICS = BOAT_TOPICS + SESSION_TOPICS
MAX_KINDRED_ORDERS = 3  # that are offered for one word


def nearest_word(token: str, known: Iterable[str]) -> str:
    """Return the known word that was mistyped, "" if none is near.

    A word with another first letter must be more alike, because few mistype the first letter.
    """
    whole = difflib.get_close_matches(token, sorted(known), n=1, cutoff=0.8)
    begun = [word for word in sorted(known) if word[0] == token[0]]
    near = whole or difflib.get_close_matches(token, begun, n=1, cutoff=0.65)
    return near[0] if near else ""


def meant_order(tokens: list[str]) -> str:
    """Return the order that is meant by words that are none, "" for none.

    "go deeper" is about depth, mistyped too, though "go" alone is about time.
    """
    if tokens[0] in GOING_WORDS and len(tokens) > 1:
        known = nearest_word(tokens[1], MEANT_ORDERS.keys() - {*GOING_WORDS})
        return MEANT_ORDERS.get(known, "")
    return MEANT_ORDERS.get(tokens[0], "")


def kindred_orders(token: str, head: str) -> str:
    """Return the few orders, up to this word, that may be meant; "": none.

    ``head`` is the order that does not take the word: others that stand in help beside it may.
    """
    beside = next(
        (topic for topic in ORDER_TOPICS if head in {word.name for word in topic.words}), None
    )
    names = {word.name for word in beside.words} if beside else set()
    found: dict[str, None] = {}
    for form in FORMS:
        before = heading_word(form)
        if form.refusal or (head and before not in names):
            continue
        for item in form.pattern.split()[1:]:
            if token in {said for said, _ in spellings(WORD_SETS.get(item, item))}:
                found[f"{before} {token}"] = None
            if item in WORD_SETS or not item.islower() or "|" in item:
                break
            before = f"{before} {item}"
    return join_names(list(found)) if len(found) <= MAX_KINDRED_ORDERS else ""


def join_names(names: list[str]) -> str:
    """Return the names as `a, b or c`."""
    return " or ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
