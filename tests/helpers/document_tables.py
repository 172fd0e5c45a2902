"""The tables of the documents that are made of the trainer's own tables, in Markdown.

    python -m helpers.document_tables orders

prints a part of a page, to be put in its place by hand. Tests compare each with its document, so
that the two cannot differ for long.
"""

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from helpers.places import ROOT
from helpers.tables_1969 import table_of
from trainer.config.exercise.baseline import kept_baseline
from trainer.config.files import path_named, shipped_names
from trainer.console.keys import KEYS
from trainer.core.terms import COMPACT_TERMS, EXTRA_TERMS, TERM_TABLE, THRUST_KEYS, Term
from trainer.io.orders import sentences
from trainer.io.orders.help import limits_and_units, synonyms, usage
from trainer.io.orders.phrases import PHRASES, meaning
from trainer.io.orders.quantities import NUMBER_KINDS
from trainer.io.orders.table import FORMS, word_of
from trainer.io.orders.words import ORDER_WORDS
from trainer.session.nmea.page import heading as sentence_heading
from trainer.session.nmea.sentences import INSTRUMENTS
from trainer.session.stations.alert_table import ALERT_TABLE, SOUND_PACES_S
from trainer.session.stations.alerts import SEEN_RANKS
from trainer.session.stations.channels import CHANNELS
from trainer.session.stations.panels import Channel
from trainer.session.stations.roles import (
    ALL_ROLES,
    COMMON_ORDERS,
    EVENT_KINDS,
    INSTRUCTOR_ROLE,
    ROLES,
)
from trainer.web.words import catalogues

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


def form_table() -> str:
    """Return the table of the wordings, as docs/orders.md shows it, and the next five too."""
    return table_lines(
        ("wording", "order", "obeyed by", "what it does"),
        [
            (usage(form).replace("|", "\\|"), name, ORDER_WORDS[name].obeyer.value, form.says)
            for form in FORMS
            if not form.refusal and (name := word_of(form))
        ],
    )


def number_table() -> str:
    """Return the table of the kinds of numbers."""
    rows = [(name, limits_and_units(kind)) for name, kind in NUMBER_KINDS.items()]
    return table_lines(("in the table", "is"), rows)


def spelling_list() -> str:
    """Return the list of the other spellings."""
    words = " ".join(form.pattern for form in FORMS).split()
    return "".join(f"- {same}\n" for same in synonyms(words))


def example_table() -> str:
    """Return the table of the lines of programs."""
    rows = [(line, says, f"`{example}`") for line, says, example in EXAMPLE_ORDERS]
    return table_lines(("line", "what it is", "example"), rows)


def refusal_table() -> str:
    """Return the table of what is refused with advice."""
    rows = [(usage(form).replace("|", "\\|"), form.refusal) for form in FORMS if form.refusal]
    return table_lines(("wording", "answer"), rows)


def fact_keys(fact: str) -> set[str]:
    """Return the keys of a fact that docs/station-tables.md tells."""
    text = (ROOT / "docs" / "station-tables.md").read_text(encoding="utf-8")
    table = text.partition(f"\n| {fact} | is |\n")[2].partition("\n\n")[0]
    return set(re.findall(r"^\| `([a-z-]+)` \|", table, re.MULTILINE))


def table_lines(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """Return a Markdown table, its first column as code."""
    lines = [f"| {' | '.join(head)} |", f"|{' --- |' * len(head)}"]
    lines += [f"| `{row[0]}` | {' | '.join(row[1:])} |" for row in rows]
    return "\n".join(lines) + "\n"


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
    for name, word in ORDER_WORDS.items():
        holders = roles_with(name)
        gates = (word.journalled, word.in_replay, word.after_end, word.watching)
        marks = ["yes" if is_open else "no" for is_open in gates]
        everybody = len(holders) == len(ROLES)
        row = word.obeyer.value, *marks, "all" if everybody else ", ".join(holders)
        rows.setdefault(row, []).append(f"`{name}`")
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


def alert_table() -> str:
    """Return the Markdown table of all alerts, in English and German."""
    lines = [
        "| alert | name | in German | rank | sounds every | begins | is over | acknowledged by |",
        "|---|---|---|---|---|---|---|---|",
    ]
    german = catalogues()["de"]
    for name, row in ALERT_TABLE.items():
        pace = f"{SOUND_PACES_S[row.rank]:g} s" if row.rank in SOUND_PACES_S else "-"
        seen = row.rank in SEEN_RANKS
        by = ("nobody: silence" if pace != "-" else "-") if not seen else ", ".join(row.roles)
        told = (row.title, f"`{name}`" if name else "none", german[row.title], row.rank.value, pace)
        lines.append(f"| {' | '.join((*told, row.begins, row.ends, by))} |")
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


def people_table() -> str:
    """Return the table of model people, as docs/validation.md shows it, the easiest first."""
    kept = {
        each: kept_baseline(path_named(each, "exercises")) for each in shipped_names("exercises")
    }
    figures = {name: each.people for name, each in kept.items() if each and each.people}
    rows = [
        (
            *(name, f"{each.mean:.0f}", f"{100.0 * each.ceiling:.0f} %", f"{each.correlation:.2f}"),
            *(f"{each.better_has_more:.2f}", f"{each.standard_error:.0f}"),
        )
        for name, each in sorted(figures.items(), key=lambda item: -item[1].mean)
    ]
    heads = ("exercise", "mean", "95 or more", "correlation", "better has more", "standard error")
    return table_lines(heads, rows)


def term_row(term: Term) -> str:
    """Return a coefficient's row of docs/coefficients.md."""
    key, equation, power, multiplies, mnemonic = term
    kept = (
        "yes"
        if key in COMPACT_TERMS or key in THRUST_KEYS
        else "a hull may"
        if key in EXTRA_TERMS
        else ""
    )
    multiplied = multiplies.replace("|", "\\|")
    cells = (equation, f"`{key}`", power, multiplied, mnemonic, table_of(mnemonic), kept)
    return f"| {' | '.join(map(str, cells))} |"


MAKERS: Final[Mapping[str, Callable[[], str]]] = {
    "orders": form_table,  # docs/orders.md, as the next ones
    "order-numbers": number_table,
    "order-spellings": spelling_list,
    "order-phrases": lambda: table_lines(
        ("said", "order", "said by instructor or diving officer"), phrase_table()
    ),
    "order-lines": example_table,
    "order-refusals": refusal_table,
    "order-words": order_table,  # docs/station-tables.md, as the next ones
    "roles": role_table,
    "events": event_table,
    "alerts": alert_table,
    "facts": lambda: table_lines(("fact", "its subject"), [*sentences.FACTS.items()]),
    "channels": channel_tables,  # docs/channels.md
    "coefficients": lambda: "".join(f"{term_row(term)}\n" for term in TERM_TABLE),
    "keys": key_tables,  # docs/keys.md
    "nmea": sentence_table,  # docs/nmea-sentences.md
    "people": people_table,  # docs/validation.md
}

if __name__ == "__main__":
    print(MAKERS[sys.argv[1]](), end="")
