"""Tables that documents have from code are those that the code makes now."""

import pytest
from helpers.document_tables import MAKERS
from helpers.key_tables import TABLES
from helpers.places import ROOT

from trainer.io.orders.grammar import MAX_LINE_LETTERS
from trainer.io.orders.sentences import MAX_ANSWER_LETTERS

MADE = {"document_tables": MAKERS, "key_tables": TABLES}  # by the module of helpers
SHOWN = {  # by page
    ("document_tables", "channels.md"): ["channels"],
    ("document_tables", "keys.md"): ["keys"],
    ("document_tables", "nmea-sentences.md"): ["nmea"],
    ("document_tables", "orders.md"): [
        *("orders", "order-numbers", "order-spellings", "order-phrases", "order-lines"),
        "order-refusals",
    ],
    ("document_tables", "station-tables.md"): ["order-words", "roles", "events", "alerts"],
    ("document_tables", "validation.md"): ["people"],
    ("key_tables", "ballast-keys.md"): ["ballast"],
    ("key_tables", "casualty-tables.md"): ["casualties", "casualty-kinds", "casualty-quantities"],
    ("key_tables", "check-cases.md"): ["check-cases"],
    ("key_tables", "exercise-keys.md"): ["exercises", "world"],
    ("key_tables", "hull-keys.md"): ["own-hull"],
    ("key_tables", "identification-keys.md"): [
        *("decca", "derivatives", "identification", "nomoto", "nonlinear-ships", "systems"),
    ],
    ("key_tables", "measures.md"): ["measures"],
    ("key_tables", "plant-keys.md"): ["plant"],
    ("key_tables", "seas.md"): ["seas"],
    ("key_tables", "sweep-keys.md"): ["sweeps"],
    ("key_tables", "vessel-keys.md"): ["documentary", "laws", "vessel-files"],
}


@pytest.mark.parametrize(
    ("module", "page", "table"),
    [(module, page, table) for (module, page), tables in SHOWN.items() for table in tables],
)
def test_a_page_has_the_table_that_is_made(module: str, page: str, table: str) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")

    assert MADE[module][table]() in text, f"renew: python -m helpers.{module} {table}"


@pytest.mark.parametrize("module", MADE)
def test_every_table_that_is_made_is_in_a_page(module: str) -> None:
    shown = [table for (by, _), tables in SHOWN.items() if by == module for table in tables]

    assert sorted(shown) == sorted(MADE[module])


def test_the_page_of_orders_says_how_long_a_line_may_be() -> None:
    text = " ".join((ROOT / "docs" / "orders.md").read_text(encoding="utf-8").split())

    assert f"An order is one line of at most {MAX_LINE_LETTERS} characters" in text
    assert (
        f"A line in has at most {MAX_LINE_LETTERS} characters, a line out {MAX_ANSWER_LETTERS}."
        in text
    )
