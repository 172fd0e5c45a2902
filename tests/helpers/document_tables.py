"""The tables of the documents that are made of the trainer's own tables, in Markdown.

    python -m helpers.document_tables orders > ../docs/orders.md

prints a whole page; the other names print a part of one, to be put in its place by hand. Tests
compare each with its document, so that the two cannot differ for long.
"""

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from trainer.console.keys import KEYS
from trainer.io.orders import sentences
from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.orders.help import limits_and_units, synonyms, usage
from trainer.io.orders.phrases import PHRASES, meaning
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import FORMS, heading_word
from trainer.session.dispatch import ORDERS
from trainer.session.nmea.page import heading as sentence_heading
from trainer.session.nmea.sentences import INSTRUMENTS
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.panels import Channel
from trainer.session.stations.roles import (
    ALL_ROLES,
    COMMON_ORDERS,
    EVENT_KINDS,
    INSTRUCTOR_ROLE,
    ROLES,
)

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

RANGE_KEYS: Final = {  # keys of the fact `range`
    "length": "of the hull [m]",
    "mass": "of the boat with the water in it [t]",
    "rudder": "largest angle either way [deg]",
    "stern": "that of the stern planes [deg]",
    "bow": "that of the bow planes [deg]",
    "depth": "the greatest depth that may be ordered [m]",
    "test-depth": "test depth [m]; for instructor, diving officer and observer",
    "periscope": "periscope depth [m]",
    "speed": "turns at most, ahead [kn]",
    "astern": "turns at most, astern [kn]",
    "bell": "a bell as it is ordered, a colon and its turns [kn]; one fact each",
    "tank": "a tank, a colon and what it holds [t]; one fact each",
    "trim-arm": "distance between the centres of the trim tanks [m]",
}

EXERCISE_KEYS: Final = {  # keys of the fact `exercise`
    "name": "the exercise's file; for the instructor",
    "title": "its title",
    "line": "a line of its briefing; one fact each",
    "hand": "the axes that are worked by hand now",
    "hand-from": "when they come into hand [s]; for the instructor",
    "allowed": "automatic orders and axes that are allowed all the same",
    "free": "`yes`: the instructor has allowed what was in hand; there are no marks",
    "limits": "the gate: names and values, `depth_m_max:105,pitch_deg_max:15`",
    "lost": "a condition that loses it; one fact each",
    "wins": "what wins it; one fact each",
    "visitors": "`yes`: a visitor may begin it again; there is a kiosk",
    "way": "`yes`: there is a reference crew, which can show the way",
    "hint": "the marks that each `hint` costs",
    "aids": "the aids that are allowed, `ghost,predictor`",
    "steps": "how many steps lead who trains",
    "duration": "its length [s]",
    "left": "what is left of it [s], at the time of the fact",
}


def orders_page(obeyed_by: Mapping[str, str]) -> str:
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
            *table_lines(("wording", "order", "obeyed by", "what it does"), escaped),
            "## Numbers\n",
            *table_lines(
                ("in the table", "is"),
                [(name, limits_and_units(n)) for name, n in NUMBER_KINDS.items()],
            ),
            "The boat's own limits are narrower, and are applied later.\n",
            "## Other spellings\n",
            *(f"- {same}" for same in synonyms(" ".join(f.pattern for f in FORMS).split())),
            "",
            PHRASES_TEXT,
            *table_lines(("said", "order", "said by instructor or diving officer"), phrase_table()),
            PROGRAMS_TEXT,
            *table_lines(
                ("line", "what it is", "example"),
                [(line, says, f"`{example}`") for line, says, example in EXAMPLE_ORDERS],
            ),
            "## Refused with advice\n",
            *table_lines(("wording", "answer"), refused),
        ]
    )


def table_lines(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Return a Markdown table, its first column as code, and a blank line."""
    lines = [f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}"]
    return [*lines, *(f"| `{row[0]}` | {' | '.join(row[1:])} |" for row in rows), ""]


def phrase_table() -> list[tuple[str, str, str]]:
    """Return the rows of the table in docs/orders.md: phrase, order, order to the crew."""
    rows = []
    for phrase in PHRASES:
        phrase_meaning = meaning(as_tokens(phrase.example))
        if phrase_meaning:
            rows.append(
                (
                    phrase.example,
                    f"`{phrase_meaning.order}`",
                    phrase_meaning.crew and f"`{phrase_meaning.crew}`",
                )
            )
    return rows


def as_tokens(example: str) -> list[str]:
    """Return an example as the tokens that a line would have."""
    return re.sub(r"\b(one|two) third", r"\1-third", example.lower()).split()


def order_table() -> str:
    """Return the Markdown table of the order words, as docs/station-tables.md shows it."""
    rows: dict[tuple[str, ...], list[str]] = {}
    for word, rule in ORDERS.items():
        holders = roles_with(word)
        gates = (rule.journalled, rule.in_replay, rule.after_end, rule.watching)
        marks = ["yes" if is_open else "no" for is_open in gates]
        everybody = len(holders) == len(ROLES)
        row = rule.obeyer.value, *marks, "all" if everybody else ", ".join(holders)
        rows.setdefault(row, []).append(f"`{word}`")
    heads = "orders", "obeyed by", "journalled", "in a replay", "after the end", "watching", "roles"
    lines = [heads, ("---",) * len(heads)]
    lines += [(", ".join(sorted(words)), *row) for row, words in sorted(rows.items())]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def roles_with(word: str) -> list[str]:
    """Return the names of the roles that may give an order of that word."""
    return [name for name, role in ROLES.items() if word in role.commands]


def role_table() -> str:
    """Return the Markdown table of the roles, as docs/station-tables.md shows it."""
    lines = ["| role | orders | sees |", "|---|---|---|"]
    for role in ROLES.values():
        own_orders = sorted(role.commands - COMMON_ORDERS)
        orders = (
            "all"
            if role is INSTRUCTOR_ROLE
            else ", ".join(f"`{name}`" for name in own_orders) or "none"
        )
        lines.append(f"| {role.name} | {orders} | {', '.join(role.channels)} |")
    common = ", ".join(f"`{name}`" for name in sorted(COMMON_ORDERS))
    return "\n".join([*lines, "", f"Every line may say {common}."]) + "\n"


def event_table() -> str:
    """Return the Markdown table of what happens and who hears of it."""
    lines = ["| kind | is | heard by the instructor and |", "|---|---|---|"]
    for kind, (says, roles) in EVENT_KINDS.items():
        heard = "everybody" if roles == ALL_ROLES else ", ".join(roles) or "nobody else"
        lines.append(f"| `{kind}` | {says} | {heard} |")
    return "\n".join(lines) + "\n"


def channel_tables() -> str:
    """Return the Markdown tables of the channels, as docs/channels.md shows them."""
    return "\n".join(f"{channel_table(channel)}\n" for channel in CHANNELS.values())


def channel_table(channel: Channel) -> str:
    """Return the table of one channel."""
    rows = [f"### `{channel.name}`", "", f"{channel.says[0].upper()}{channel.says[1:]}.", ""]
    rows += ["| field | unit |", "|---|---|"]
    return "\n".join(
        [*rows, *(f"| `{field.name}` | {field.unit or 'word'} |" for field in channel.fields)]
    )


def fact_table(fact: str, keys: Mapping[str, str]) -> str:
    """Return the Markdown table of a fact's keys, as docs/station-tables.md shows it."""
    rows = [f"| `{key}` | {says} |" for key, says in keys.items()]
    return "\n".join([f"| {fact} | is |", "|---|---|", *rows]) + "\n"


def sentence_table() -> str:
    """Return the table of the sentences, as docs/nmea-sentences.md shows it."""
    rows = ["| sentence | tells | fields | source |", "|---|---|---|---|"]
    rows += [
        f"| `{sentence_heading(instrument)}` | {instrument.says} | {'; '.join(instrument.fields)} "
        f"| {instrument.source} |"
        for instrument in INSTRUMENTS
    ]
    return "\n".join(rows) + "\n"


def key_table(role: str) -> str:
    """Return the Markdown table of a role's keys, as docs/keys.md shows it."""
    rows = [f"| `{key.label}` | {key.does} |" for key in KEYS[role]]
    return "\n".join(["| key | does |", "|---|---|", *rows]) + "\n"


def key_tables() -> str:
    """Return the tables of all roles but those of who looks on or visits."""
    shown = (role for role in KEYS if role not in ("observer", "scope", "visitor"))
    return "\n".join(f"#### {role.capitalize()}\n\n{key_table(role)}" for role in shown)


def obeyed_by() -> dict[str, str]:
    """Return who obeys each order word."""
    return {word: rule.obeyer.value for word, rule in ORDERS.items()}


MAKERS: Final[Mapping[str, Callable[[], str]]] = {
    "orders": lambda: orders_page(obeyed_by()),  # docs/orders.md
    "order-words": order_table,  # docs/station-tables.md, as the next ones
    "roles": role_table,
    "events": event_table,
    "channels": channel_tables,  # docs/channels.md
    "range-keys": lambda: fact_table("range", RANGE_KEYS),
    "exercise-keys": lambda: fact_table("exercise", EXERCISE_KEYS),
    "keys": key_tables,  # docs/keys.md
    "nmea": sentence_table,  # docs/nmea-sentences.md
}

if __name__ == "__main__":
    print(MAKERS[sys.argv[1]](), end="")
