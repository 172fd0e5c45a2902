"""What may come next in an order that is being typed."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from trainer.io.order_table import Name, Place, UnitWord, Word
from trainer.io.orders import READINGS, match, tokenise
from trainer.io.quantities import Number


class Offer(NamedTuple):
    """Whole words that fit, and what else would, in words."""

    words: tuple[str, ...]
    hints: tuple[str, ...]


def offer(text: str, known: Mapping[str, Sequence[str]]) -> Offer:
    """Return what fits after the whole words of ``text``, the last one perhaps begun.

    ``known`` are names by what they are, as the grammar says it: "the name of a casualty".
    """
    begun = "" if not text or text[-1].isspace() else text.rsplit(maxsplit=1)[-1].lower()
    said = tokenise(text[: len(text) - len(begun)])
    words: dict[str, None] = {}
    hints: dict[str, None] = {}
    for place in following(said):
        for word in fitting(place, begun, known):
            words[word] = None
        if not isinstance(place, Word | UnitWord) and not begun:
            hints[says(place)] = None
    return Offer(tuple(words), tuple(hints))


def following(said: Sequence[str]) -> list[Place]:
    """Return the places that may follow the words said."""
    found = []
    for reading in READINGS:
        places = reading.places
        if reading.form.refusal or len(places) <= len(said):
            continue
        if all(any(True for _ in match(place, word)) for place, word in zip(places, said)):  # noqa: B905
            found.append(places[len(said)])
    return found


def fitting(place: Place, begun: str, known: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the words of a place that begin so; of several spellings the first."""
    if isinstance(place, Word):
        found = {word: said for said, word in reversed(place.spellings) if said.startswith(begun)}
        return [said if not word.startswith(begun) else word for word, said in found.items()]
    if isinstance(place, Name):
        return [name for name in known.get(place.says, ()) if name.startswith(begun)]
    return []


def says(place: Place) -> str:
    """Return what a place wants."""
    if isinstance(place, Number):
        return f"{place.says} ({place.limits})"
    return place.says if isinstance(place, Name) else "a token"


def completed(text: str, known: Mapping[str, Sequence[str]]) -> str:
    """Return ``text`` with its last word made whole as far as that is in no doubt."""
    words = offer(text, known).words
    begun = "" if not text or text[-1].isspace() else text.rsplit(maxsplit=1)[-1]
    if not words or (not begun and len(words) > 1):
        return text
    shared = words[0]
    for word in words[1:]:
        while not word.startswith(shared):
            shared = shared[:-1]
    ending = " " if len(words) == 1 else ""
    return text[: len(text) - len(begun)] + shared + ending


def hint(text: str, known: Mapping[str, Sequence[str]]) -> str:
    """Return what may come next, in words."""
    offered = offer(text, known)
    return "   ".join((*offered.words, *(f"<{each}>" for each in offered.hints)))
