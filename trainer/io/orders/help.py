"""The answers to the order ``help``, made of the order table, at most 79 columns.

``station`` answers by it, and the pages complete orders with its words. It is made of the table, so
that no order is without help.
"""

import difflib
import re
import textwrap
from collections.abc import Sequence

from trainer.io.orders.phrases import PHRASES
from trainer.io.orders.quantities import NUMBER_KINDS, Number
from trainer.io.orders.table import (
    FORMS,
    HELP_TOPICS,
    SESSION_TOPIC,
    WORD_SETS,
    Form,
    heading_word,
)
from trainer.io.orders.words import BOAT_TOPICS, SESSION_TOPICS, Topic

HELP_WIDTH = 79  # [characters]
# for a line that has no role yet; screens, which say theirs themselves, show none of it
NO_ROLE_TEXT = "type `help` for the orders, `role helm` to take a station, `detach` to leave"
SESSION_SUBJECTS = "time, moments and stations"


def help_text(topic: str) -> list[str]:
    """Return the lines of help on a topic, at most 79 columns. "" is the list of orders."""
    if not topic:
        first = "Orders; words may be cut short, and # starts a comment:"
        return [
            *overview(first, BOAT_TOPICS),
            f"help {SESSION_TOPIC} lists the rest: {SESSION_SUBJECTS}.",
        ]
    if topic == SESSION_TOPIC:
        return overview(f"Orders about {SESSION_SUBJECTS}:", SESSION_TOPICS)
    if topic not in HELP_TOPICS:
        near = difflib.get_close_matches(topic, HELP_TOPICS, n=1)
        return [f'no order "{topic}"' + (f"; did you mean {near[0]}?" if near else "")]
    forms = [form for form in FORMS if heading_word(form) == topic and not form.refusal]
    lines = [f"{topic}, in full:"]
    for form in forms:
        line = f"  {usage(form):<34}  {form.says}"
        lines += (
            [line]
            if len(line) <= HELP_WIDTH
            else [*wrap_pattern(usage(form)), f"      {form.says}"]
        )
    patterns = " ".join(form.pattern for form in forms).split()
    lines += [
        f"  {name} is {limits_and_units(number)}"
        for name, number in NUMBER_KINDS.items()
        if name in patterns
    ]
    lines += [f"  {same}" for same in synonyms(patterns)]
    said = [each.example for each in PHRASES if each.order.partition(" ")[0] == topic]
    return lines + wrap_pattern(f"also said: {', '.join(said)}") * bool(said)


def wrap_pattern(pattern: str) -> list[str]:
    """Return a pattern in lines that fit."""
    shape = textwrap.TextWrapper(HELP_WIDTH, "  ", "    ", break_on_hyphens=False)
    return shape.wrap(pattern)


def overview(first: str, topics: Sequence[Topic]) -> list[str]:
    """Return the list of some orders, at most 24 lines."""
    lines = (f"  {entry.example:<36} {entry.says}" for entry in topics)
    return [first, *lines, "help ORDER says more about one of them, such as: help rudder"]


def usage(form: Form) -> str:
    """Return the pattern of a form without its second spellings."""
    items = (WORD_SETS.get(item, item) for item in form.pattern.split() if item != "TOPIC")
    shown = " ".join(re.sub(r"=[^|]*", "", item) for item in items)
    return f"{shown} ORDER" if "TOPIC" in form.pattern else shown


def limits_and_units(number: Number) -> str:
    """Return what a number means, its limits and its units, the understood one first."""
    units = " or ".join(unit.names[0] for unit in number.units if unit.names)
    return f"{number.says}, {number.limits}" + (f" (in {units})" if len(number.units) > 1 else "")


def synonyms(patterns: list[str]) -> list[str]:
    """Return `word: other spellings` for the words of the patterns that have any, once each."""
    lines_by_word = {}
    for item in patterns:
        for alternative in WORD_SETS.get(item.strip("[]"), item.strip("[]")).split("|"):
            word, *others = alternative.split("=")
            if others:
                lines_by_word[word] = f"{word}: also {', '.join(others)}"
    return list(lines_by_word.values())
