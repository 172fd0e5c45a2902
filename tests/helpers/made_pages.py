"""What of the documents is made from code, and how many of their words are written by hand.

    python -m helpers.made_pages        in tests/

prints the words by hand of each page, the longest last.
"""

from collections.abc import Callable, Mapping
from typing import Final

from helpers import conformity, document_tables, exit_codes, key_tables, python_reference
from helpers.places import ROOT
from helpers.worked_diff import BLOCK, PAGE

MADE: Final = {  # by the module of helpers
    "document_tables": document_tables.MAKERS,
    "key_tables": key_tables.TABLES,
}
SHOWN: Final = {  # by page
    ("document_tables", "channels.md"): ["channels"],
    ("document_tables", "coefficients.md"): ["coefficients"],
    ("document_tables", "keys.md"): ["keys"],
    ("document_tables", "nmea-sentences.md"): ["nmea"],
    ("document_tables", "orders.md"): [
        *("orders", "order-numbers", "order-spellings", "order-phrases", "order-lines"),
        "order-refusals",
    ],
    ("document_tables", "station-tables.md"): [
        *("order-words", "roles", "events", "alerts", "facts"),
    ],
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
WHOLE: Final[Mapping[str, Callable[[], str]]] = {
    "conformity.md": conformity.page,
    "exit-codes.md": exit_codes.page,
    "python-names.md": python_reference.reference,
}


def made_words(page: str) -> int:
    """Return how many words of a page are made from code."""
    if page in WHOLE:
        return len(WHOLE[page]().split())
    parts = [
        MADE[module][table]()
        for (module, shown), tables in SHOWN.items()
        for table in tables
        if shown == page
    ]
    if page == PAGE.name:
        parts += BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    return sum(len(part.split()) for part in parts)


def words_by_hand() -> Mapping[str, int]:
    """Return the words of each page that nothing makes, by the page's name."""
    return {
        path.name: len(path.read_text(encoding="utf-8").split()) - made_words(path.name)
        for path in sorted((ROOT / "docs").glob("*.md"))
    }


if __name__ == "__main__":
    for page, count in sorted(words_by_hand().items(), key=lambda item: item[1]):
        print(f"{count:6,} {page}")
