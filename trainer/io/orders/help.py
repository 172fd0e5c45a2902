"""The order table as help on a terminal and as the page docs/orders.md."""

import difflib
import re
import textwrap
from collections.abc import Mapping, Sequence

from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.orders.phrases import phrase_table
from trainer.io.orders.quantities import NUMBER_KINDS, Number
from trainer.io.orders.table import (
    BOAT_TOPICS,
    FORMS,
    SESSION_TOPIC,
    SESSION_TOPICS,
    TOPICS,
    WORD_SETS,
    Form,
    Topic,
    heading_word,
)

HELP_WIDTH = 79  # [characters]
SESSION_SUBJECTS = "time, moments and stations"

INTRODUCTION_TEXT = f"""# Orders

<!-- Made of the tables of trainer/io/orders and trainer/session/dispatch; a test compares them. -->

After this page you can give any order, in full, cut short, or as it is said in a control room.

An order is one line of at most {MAX_LINE_LETTERS} characters: plain words, in capitals or not. \
Any word may
be cut short as long as the line allows one meaning (`ru r 15` is `rudder right 15`); a doubtful or
unknown word is refused with the words it could be, and changes nothing. Numbers are plain decimals.
What follows a `#` is ignored. `[word]` may be left out, `a|b` is one or the other; NAME, LABEL and
CHANNEL are a word of letters, digits and dashes; TOKEN is a word of any characters but `#`, `$`,
`*` and commas.

A file of orders (`--orders FILE`) has lines of `SECONDS ORDER`, for example `600 rudder right 15`.
"""


PHRASES_TEXT = """## Phrases

The words of a control room are understood too. A station means the order of the second column. The
instructor, the diving officer and a schedule mean the order to the crew of the third column, where
there is one. Numbers may be words: `zero four five`, `one eighty`, `two hundred`. An unknown phrase
is refused, with the nearest. `meet her` puts the rudder against the swing, and amidships when the
swing has stopped; `ease` and `shift` keep the side of the rudder that is on.
"""

PROGRAMS_TEXT = f"""## Lines of programs

A program sends the same words in a frame, and is answered in frames. The two hexadecimal digits
after `*` are the exclusive or of all characters between `$` and `*`. A tag of one to six digits may
stand before the words; every answer to that order carries it. A damaged line is answered without
a tag, which cannot be trusted either. A line in has at most {MAX_LINE_LETTERS} characters, \
a line out
{sentences.MAX_ANSWER_LETTERS}.

The text is the last field and may hold commas; a `$`, a `*` or a character beyond ASCII in it is
sent as `?`. In a field before others a comma is sent as `;`.
"""

EXAMPLE_ORDERS = (
    ("$TRO,[tag,]words*HH", "an order", sentences.order_sentence("rudder left 15")),
    ("$TRO,[tag,]words*HH", "one with a tag", sentences.order_sentence("rudder left 15", "7")),
    (
        "$TRA,[tag,]ok,text*HH",
        "done, and what holds now",
        sentences.answer("7", accepted=True, text="rudder left 15, by hand"),
    ),
    (
        "$TRA,[tag,]no,text*HH",
        "not done, and why",
        sentences.answer("7", accepted=False, text="this boat has no rudder"),
    ),
    (
        "$TRA,[tag,]say,text*HH",
        "a line of a long answer, before the last",
        sentences.say("7", "pitch +0.10   heel +0.00 degrees"),
    ),
    (
        "$TRN,channel,name:unit,...*HH",
        "names and units on a channel",
        sentences.names("example", [("depth", "m"), ("course", "deg")]),
    ),
    (
        "$TRS,channel,tick,seconds,value,...*HH",
        "its values",
        sentences.state("example", 120, 60.0, ["60.02", "089.9"]),
    ),
    (
        "$TRE,tick,seconds,kind,text*HH",
        "something that happened",
        sentences.event(120, 60.0, "order", "helm: rudder left 15"),
    ),
    (
        "$TRF,tick,seconds,what,subject*HH",
        "a fact of it, for programs",
        sentences.fact(120, 60.0, "order", "rudder left 15"),
    ),
)


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
    topics = [head for entry in TOPICS for head in entry.heads]
    if topic not in topics:
        near = difflib.get_close_matches(topic, topics, n=1)
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
    return lines + [f"  {same}" for same in synonyms(patterns)]


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


def page(obeyed_by: Mapping[str, str]) -> str:
    """Return docs/orders.md; ``obeyed_by`` says of each order word who obeys it."""
    escaped = [
        (usage(form).replace("|", "\\|"), name, obeyed_by[name], form.says)
        for form in FORMS
        if not form.refusal and (name := form.name or heading_word(form))
    ]
    refused = [(usage(form).replace("|", "\\|"), form.refusal) for form in FORMS if form.refusal]
    return "\n".join(
        [
            INTRODUCTION_TEXT,
            *table(("wording", "order", "obeyed by", "what it does"), escaped),
            "## Numbers\n",
            *table(
                ("in the table", "is"),
                [(name, limits_and_units(n)) for name, n in NUMBER_KINDS.items()],
            ),
            "The boat's own limits are narrower, and are applied later.\n",
            "## Other spellings\n",
            *(f"- {same}" for same in synonyms(" ".join(f.pattern for f in FORMS).split())),
            "",
            PHRASES_TEXT,
            *table(("said", "order", "said by instructor or diving officer"), phrase_table()),
            PROGRAMS_TEXT,
            *table(
                ("line", "what it is", "example"),
                [(line, says, f"`{example}`") for line, says, example in EXAMPLE_ORDERS],
            ),
            "## Refused with advice\n",
            *table(("wording", "answer"), refused),
        ]
    )


def table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Return a Markdown table, its first column as code, and a blank line."""
    lines = [f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}"]
    return [*lines, *(f"| `{row[0]}` | {' | '.join(row[1:])} |" for row in rows), ""]
